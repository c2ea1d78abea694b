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
    """Choose from a folder of records a set whose spectra match that of a site, in their mean and, if requested, their scatter.

    DIR gets selected.toml, which a study takes as its records, selection.csv with the factor and the misfit of each, selection.json and a
    picture. The rule of EN 1998-1 for sets of records is judged, and met by one more factor where meet_rule = true.

    \b
    Examples:
      masonry-cd select select.toml -o out/set
    """
    from masonry_cd.studies.selection.command import select as command
    from masonry_cd.studies.selection.tables import read_selection

    return command(read_selection(selection), output, force, said(not quiet))
