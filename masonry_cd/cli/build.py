# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd build``: the structure of a scene alone."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Changes, Force, Output, SceneFile, Trust


def _list_formats(asked: bool) -> None:
    """Print the formats and exit, whatever the other options."""
    if asked:
        from structures.files.formats import listed

        typer.echo("\n".join(listed()))
        raise typer.Exit


def build(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    picture: Annotated[bool, typer.Option(help="Draw structure.png, or problem.png of blocks with errors.")] = True,
    format_: Annotated[
        list[str] | None,
        typer.Option(
            "--format", metavar="NAME", help="json, obj, stl, vtu, vtm, vtkhdf, step, brep or msh; repeatable.", show_default="json"
        ),
    ] = None,
    repair: Annotated[
        list[str] | None,
        typer.Option(metavar="WHAT", help="Repair a file of blocks: shells, or gaps=0.002 [m] to close gaps up to that width."),
    ] = None,
    force: Force = False,
    list_formats: Annotated[
        bool, typer.Option("--formats", help="List the block formats that are read and written.", is_eager=True, callback=_list_formats)
    ] = False,
    trust: Trust = False,
) -> Result[Any]:
    """Build only the structure of a scene.

    DIR gets blocks.json, which kind = "file" reads back, or the blocks in other formats, and structure.png. The fill of a bridge is part of
    blocks.json, or a separate fill.json for other formats. Where blocks have errors, problem.png shows which. The plan of a building is
    written as plan.json, which you can correct and read back, and drawn as plan.svg, with any errors in red; plan_left.csv lists the parts
    of a drawing that were not understood, plan_junctions.csv the junctions and free ends.

    \b
    Examples:
      masonry-cd build aqueduct.toml -o out/aqueduct
      masonry-cd build aqueduct.toml -o out/five --set structure.spans=5 --no-picture
      masonry-cd build scan.toml -o out/scan --repair shells --repair gaps=0.002
      masonry-cd build aqueduct.toml -o out/meshes --format obj --format vtkhdf
    """
    from masonry_cd.app.commands.build import build as command
    from masonry_cd.app.commands.build import repairs
    from masonry_cd.app.scene import read_scene

    asked = read_scene(scene, [*(set_ or ()), *repairs(repair or ())])
    return command(asked, output, format_ or ("json",), picture, force, typer.echo)
