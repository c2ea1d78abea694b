# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd export``: a run for ParaView, or a scene for another program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Changes, Force, Trust


def export(
    source: Annotated[Path, typer.Argument(metavar="DIR|SCENE", help="Folder of a run, or scene file (TOML).", show_default=False)],
    format_: Annotated[
        str, typer.Option("--format", metavar="NAME", help="For a run: vtkhdf, or pvd for older readers; for a scene: lmgc90 or 3dec.")
    ] = "vtkhdf",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Folder for the files.", show_default="DIR/paraview")
    ] = None,
    set_: Changes = None,
    force: Force = False,
    trust: Trust = False,
) -> Result[None]:
    """Write a run for ParaView, or a scene for LMGC90 or 3DEC.

    For a run, OUT gets blocks and joints over time as VTKHDF, or as PVD collections of VTP files, with openings, slidings, forces, states
    and displacements, and names.csv, which lists the names of blocks and groups by their numbers.

    For a scene, OUT gets the input of another program: blocks, materials, supports, gravity and base motion. Anything that the program
    cannot represent is an error.

    \b
    Examples:
      masonry-cd export out/aqueduct
      masonry-cd export out/aqueduct --format pvd -o out/view
      masonry-cd export aqueduct.toml --format lmgc90 -o out/lmgc90
      masonry-cd export church.toml --format 3dec -o out/3dec --set material.joints.normal_stiffness=1e10
    """
    from masonry_cd.app.commands import export as commands
    from masonry_cd.app.scene import read_scene
    from masonry_cd.foundation.errors import InputError

    if source.suffix != ".toml":
        if set_:
            raise InputError("--set", "changes a scene, and a run is exported as it was")
        return commands.export(source, format_, output)
    if output is None:
        raise InputError("--output", "missing; give the folder for the input files")
    return commands.deck(read_scene(source, set_ or ()), format_, output, force)
