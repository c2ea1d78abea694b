# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd report``: the reports of a run, redone."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Folder, exclude


def report(
    folder: Folder,
    crack_map: Annotated[bool, typer.Option(help="Draw crack_map.png.")] = True,
    time: Annotated[float | None, typer.Option(metavar="SECONDS", help="Draw the frame nearest to this time; the last by default.")] = None,
    times: Annotated[str | None, typer.Option(metavar="T1,T2,...", help="Draw a map at each of these times, on one scale.")] = None,
    view: Annotated[str | None, typer.Option(help="front, back, side, left, top or isometric; the scene's by default.")] = None,
    scale: Annotated[float | None, typer.Option(help="Amplification of displacements; the scene's by default.")] = None,
    cut: Annotated[str | None, typer.Option(metavar="PLANE", help="Cut along a plane: y=1.5 [m], or y for the middle.")] = None,
    thrust: Annotated[bool | None, typer.Option("--thrust/--no-thrust", help="Draw the line of thrust.", show_default=False)] = None,
    animation: Annotated[bool, typer.Option("--animation", help="Draw crack_map.gif of the whole run.")] = False,
    vector: Annotated[bool, typer.Option("--vector", help="Draw crack_map.svg and crack_map.pdf, sharp at any size.")] = False,
    energy: Annotated[bool, typer.Option("--energy", help="Draw energy.png: work done, where it went, balance error.")] = False,
    stress_map: Annotated[
        bool, typer.Option("--stress-map", help="Draw stress_map.png, at --time or of the whole run, if the run recorded stress.")
    ] = False,
    extra: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Another output, by its key of [report]; repeatable.")] = None,
    html: Annotated[bool, typer.Option("--html", help="Write report.html, a page of the run that works offline.")] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print that page to report.pdf; needs Chromium.")] = False,
) -> Result[Any]:
    """Write the reports of a run again.

    Writes joints.csv, the damage by part (damage.csv, damage_history.csv, hinges.csv, drift.csv, damage.json) and crack_map.png from
    result.h5, also for a run that was stopped or killed. Thresholds and grades are those of the scene's [report].

    \b
    Examples:
      masonry-cd report out/aqueduct
      masonry-cd report out/aqueduct --time 3.5 --view isometric --scale 20
      masonry-cd report out/aqueduct --times 1,2,3 --cut y --thrust
      masonry-cd report out/aqueduct --html --no-crack-map
    """
    drawn = crack_map or times is not None or animation or vector or stress_map
    for name, given in (("--view", view), ("--scale", scale), ("--cut", cut), ("--thrust", thrust)):
        exclude((name, given is not None and not (name == "--scale" and (html or pdf))), ("--no-crack-map", not drawn))
    exclude(("--time", time is not None), ("--no-crack-map", not (crack_map or stress_map)))
    from masonry_cd.app.commands.report import report as command

    settings: dict[str, Any] = {
        "view": view,
        "scale": scale,
        "cut": cut,
        "thrust": thrust,
        "vector": vector or None,
        "animation": animation,
    }
    settings |= dict.fromkeys(extra or (), True)
    return command(folder, settings, crack_map=crack_map, time=time, times=times, energy=energy, stress_map=stress_map, page=html, pdf=pdf)
