# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd risk``: hazard, capacity, return period, class and annual frequency on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result


def risk(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a limit analysis with [hazard] and [limit.check].", show_default=False)
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="OUT", help="Folder for risk.html, risk.json and hazard.png.", show_default=False),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option("--after", metavar="DIR", help="Folder of the analysis of the strengthened structure.", show_default=False),
    ] = None,
    study: Annotated[
        Path | None, typer.Option("--study", metavar="DIR", help="Folder of a study over the same [hazard].", show_default=False)
    ] = None,
) -> Result[Any]:
    """Summarise the seismic risk of a structure on one page, before and after strengthening.

    Reads the results of limit and study: the acceleration at capacity and its return period, the risk class of the Italian guideline,
    the annual frequency of each limit state, each with its formula.

    \b
    Examples:
      masonry-cd risk out/limit -o out/risk
      masonry-cd risk out/limit --after out/strengthened --study out/study -o out/risk
    """
    from reports.risk.sheet import read_sheet, write_sheet

    sheet = read_sheet(folder, after, study)
    return Result(sheet, sheet.lines, [], [] if output is None else write_sheet(sheet, output))
