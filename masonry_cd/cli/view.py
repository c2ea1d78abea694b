# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd view``: the page of a run or a study in the browser."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import typer

from masonry_cd.cli.shared import Folder, errors_reported

STUDY_PAGE = "study.html"  # as reports.study.outputs calls it, which takes long to import


def view(folder: Folder) -> None:
    """Open the page of a run, report.html, or that of a study, study.html, in the browser.

    Where there is no display it is said where the page lies.

    \b
    Examples:
      masonry-cd view out/aqueduct
    """
    with errors_reported():
        page = page_of(folder)
        place = page.absolute().as_uri()
        if not _has_display():
            typer.echo(f"no display here; the page is {place}")
            return
        import webbrowser

        typer.echo(f"opened: {place}" if webbrowser.open(place) else f"no browser was found; the page is {place}")


def page_of(folder: Path) -> Path:
    """The page of a run or of a study.

    Raises:
        InputError: no such folder, nothing of ours in it, or no page, with the command that makes one.
    """
    from masonry_cd.foundation.errors import InputError
    from reports.outputs import PAGE

    if not folder.is_dir():
        raise InputError(folder, "is a file; a folder of a run is needed" if folder.exists() else "no such folder")
    of_study = (folder / "study.json").is_file()
    page = folder / (STUDY_PAGE if of_study else PAGE)
    if not page.is_file():
        if of_study:
            remedy = f"masonry-cd study STUDY -o {folder} --report makes it of the runs that are there"
        elif (folder / "result.h5").is_file():
            remedy = f"masonry-cd report {folder} --html makes it"
        else:
            remedy = "nor a result.h5 to make it from"
        raise InputError(folder, f"holds no {page.name}; {remedy}")
    return page


def _has_display() -> bool:
    """Whether a browser has somewhere to open: X11 and Wayland say so in the environment, as a user may with BROWSER."""
    return sys.platform in ("win32", "darwin") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
