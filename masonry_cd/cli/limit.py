# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd limit``: the largest load factor of a scene and its mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, Trust, exclude


def limit(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    picture: Annotated[bool, typer.Option(help="Draw mechanism.png and thrust.png.")] = True,
    curve: Annotated[bool, typer.Option("--curve", help="Follow the mechanism: capacity.csv, .json and .png.")] = False,
    view: Annotated[str, typer.Option(metavar="NAME", help="auto, front, back, side, left, top or isometric.")] = "auto",
    macro_elements: Annotated[
        bool, typer.Option("--macro-elements", help="Analyse each part of the structure with all others held.")
    ] = False,
    run: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder of a run whose damage the table of parts shows.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an analysis with macro-elements that was stopped.")] = False,
    force: Force = False,
    trust: Trust = False,
    quiet: Quiet = False,
) -> Result[Any]:
    """Find the largest load factor of a scene by limit analysis, and the mechanism.

    The factor multiplies the scene's load of kind push, tilt, settlement or spreading, or the load that the table [limit] names: push =
    "x", tilt = "x", or live = [0] for point loads or a vehicle. A vehicle without a position goes to its worst one: crossing.csv and .png.
    In plane structures, and for a check in space, the least factor without dilation is searched for as well.
    DIR gets limit.json, mechanisms.csv, blocks.csv, joints.csv, mechanism.png, thrust.png and the page limit.html; with ties also ties.csv,
    their tension at collapse; with a table [limit.check] check.json and check.csv, the code check of the governing mechanism; with --curve,
    or a table [limit.curve], the capacity curve: the factor that the displaced structure still carries, over the displacement of a block,
    until it vanishes.

    With --macro-elements the parts that the structure's kind names (facade, gable, side walls, apse, tower, belfry, corners, piers) are
    analysed one by one with all other blocks held, for the mechanisms of practice and the free least one. They add rows to mechanisms.csv
    and the page, and a picture each. Tables [[limit.mechanism]] choose or add parts. The whole structure is analysed as well where the
    scene names a push or a tilt. A check of the whole always lists the rigid-body mechanisms of its parts along the push.

    \b
    Examples:
      masonry-cd limit arch.toml -o out/limit --set 'limit.push="x"'
      masonry-cd limit church.toml -o out/across --set 'limit.tilt="y"' --no-picture
      masonry-cd limit wall.toml -o out/wall --set limit.starts=20
      masonry-cd limit arch.toml -o out/arch --curve --set limit.curve.steps=50
      masonry-cd limit church.toml -o out/parts --macro-elements
    """
    from masonry_cd.app.scene import read_scene
    from masonry_cd.limit.case import WantedMechanisms
    from masonry_cd.limit.command import LimitFiles
    from masonry_cd.limit.command import limit as command

    exclude(("--resume", resume), ("--force", force))
    wanted = WantedMechanisms(macro_elements, curve, quiet=quiet)
    return command(read_scene(scene, set_ or ()), wanted, LimitFiles(output, force, resume, picture, view, run))
