# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd compare``: runs side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.cli.shared import errors_reported, warn


def compare(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR1 DIR2 ...", help="Folders of runs.", show_default=False)],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Write comparison.csv, .md and .png there.", show_default=False)
    ] = None,
) -> None:
    """Lay runs side by side: what differs in their scenes, their damage and their response.

    Prints a table; with -o it is written as CSV and Markdown, with a picture. Damage is judged by the thresholds of the first run.

    \b
    Examples:
      masonry-cd compare out/weak out/strong
      masonry-cd compare out/mu0.5 out/mu0.6 out/mu0.7 -o out/friction
    """
    with errors_reported():
        from reports.compare import comparison, comparison_files

        found = comparison.compare(folders)
        typer.echo(comparison_files.markdown(found), nl=False)
        if output is not None:
            typer.echo(f"written: {', '.join(map(str, comparison_files.write_comparison(found, output)))}")
        warn(found.words)
