# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd strengthen``: the least ties that bring a scene to a load factor."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, Trust


def strengthen(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    picture: Annotated[bool, typer.Option(help="Draw before.png and after.png.")] = True,
    view: Annotated[str, typer.Option(metavar="NAME", help="auto, front, back, side, left, top or isometric.")] = "auto",
    shake: Annotated[bool, typer.Option("--shake", help="Run the scene with its own loads before and after, and compare.")] = False,
    force: Force = False,
    trust: Trust = False,
    quiet: Quiet = False,
) -> Result[Any]:
    """Find the cheapest ties that bring a scene to a load factor, or to a share of the motion that a code requires.

    The table [strengthen] has the target, factor or zeta_E, and the candidates: ties [[strengthen.ties]], or rules that generate them.
    The command finds the cheapest yield forces for which no mechanism of the whole, and if requested of the macro-elements, starts below
    the target. The search for the least factor verifies them, and they are rounded up to the next bars on the market.
    DIR gets strengthen.json, ties.csv, parts.csv, the governing mechanism in before.png and after.png, the page strengthen.html, and
    strengthened.toml, the scene with its ties, for masonry-cd run and limit; with --shake also the folder shaken with both runs and their
    comparison.

    \b
    Examples:
      masonry-cd strengthen church.toml -o out/ties --set strengthen.factor=0.2
      masonry-cd strengthen church.toml -o out/few --set strengthen.fewest=true
      masonry-cd strengthen church.toml -o out/shaken --shake
    """
    from masonry_cd.app.scene import read_scene
    from masonry_cd.strengthening.command import StrengtheningFiles
    from masonry_cd.strengthening.command import strengthen as command

    return command(read_scene(scene, set_ or ()), StrengtheningFiles(output, force, picture, view, shake, quiet), said(not quiet))
