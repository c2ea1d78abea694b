# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd select``: a set of records for a site."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.shared import Force, Output, Quiet


def select(
    selection: Annotated[Path, typer.Argument(metavar="SELECTION", help="Selection file (TOML).", show_default=False)],
    output: Output,
    force: Force = False,
    quiet: Quiet = False,
) -> Result[dict[str, Any]]:
    """Choose from a folder of records a set whose spectra match that of a site in their mean and, if requested, their scatter.

    DIR gets selected.toml, the [records] of a study, selection.csv with the factor and the misfit of each record, selection.json and a
    picture. The set is checked against the rule of EN 1998-1, and scaled by a common factor to meet it where meet_rule = true.

    \b
    Examples:
      masonry-cd select select.toml -o out/set
    """
    from masonry_cd.studies.selection.command import select as command
    from masonry_cd.studies.selection.tables import read_selection

    return command(read_selection(selection), output, force, said(not quiet))
