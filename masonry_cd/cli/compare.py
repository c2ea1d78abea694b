# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd compare``: runs side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result


def compare(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR1 DIR2 ...", help="Folders of runs.", show_default=False)],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Folder for comparison.csv, .md and .png.", show_default=False)
    ] = None,
) -> Result[Any]:
    """Compare runs: the differences of their scenes, their damage and their response.

    Prints a table; -o writes it as CSV and Markdown, with a picture. Damage is judged by the thresholds of the first run.

    \b
    Examples:
      masonry-cd compare out/weak out/strong
      masonry-cd compare out/mu0.5 out/mu0.6 out/mu0.7 -o out/friction
    """
    from reports.compare.comparison import compare as laid_side_by_side
    from reports.compare.comparison import markdown, write_comparison

    found = laid_side_by_side(folders)
    return Result(found, markdown(found).splitlines(), found.words, [] if output is None else write_comparison(found, output))
