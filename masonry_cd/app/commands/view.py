# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a run or a study in the browser: what ``masonry-cd view`` opens."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from masonry_cd.app.result import Result
from masonry_cd.foundation.errors import InputError
from reports.outputs import PAGE

STUDY_PAGE = "study.html"  # as reports.study.outputs calls it, which takes long to import


def view(folder: Path) -> Result[Path]:
    """Open the page of a run or of a study; where there is no display, a line says where it lies.

    Raises:
        InputError: no such folder, nothing of ours in it, or no page, with the command that makes one.
    """
    page = _page_of(folder)
    place = page.absolute().as_uri()
    if not _has_display():
        return Result(page, [f"no display is available; the page is {place}"])
    import webbrowser

    return Result(page, [f"opened: {place}" if webbrowser.open(place) else f"no browser was found; open the page yourself: {place}"])


def _page_of(folder: Path) -> Path:
    """The page of a run or of a study."""
    if not folder.is_dir():
        raise InputError(folder, "is a file; give the folder of a run" if folder.exists() else "no such folder")
    of_study = (folder / "study.json").is_file()
    page = folder / (STUDY_PAGE if of_study else PAGE)
    if not page.is_file():
        if of_study:
            remedy = f"write it from the finished runs with masonry-cd study STUDY -o {folder} --report"
        elif (folder / "result.h5").is_file():
            remedy = f"write it with masonry-cd report {folder} --html"
        else:
            remedy = "nor result.h5, from which it could be written"
        raise InputError(folder, f"has no {page.name}; {remedy}")
    return page


def _has_display() -> bool:
    """Return True if a browser has somewhere to open: X11 and Wayland say so in the environment, as a user may with BROWSER."""
    return sys.platform in ("win32", "darwin") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
