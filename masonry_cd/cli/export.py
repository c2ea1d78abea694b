# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd export``: a run for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Folder


def export(
    folder: Folder,
    format_: Annotated[str, typer.Option("--format", metavar="NAME", help="vtkhdf, or pvd for older readers.")] = "vtkhdf",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Folder for the files.", show_default="DIR/paraview")
    ] = None,
) -> Result[None]:
    """Write a run for ParaView: blocks and joints over time.

    OUT gets blocks and joints as VTKHDF, or as PVD collections of VTP files, with openings, slidings, forces, states and displacements,
    and names.csv, which lists the names of blocks and groups by their numbers.

    \b
    Examples:
      masonry-cd export out/aqueduct
      masonry-cd export out/aqueduct --format pvd -o out/view
    """
    from masonry_cd.app.commands.export import export as command

    return command(folder, format_, output)
