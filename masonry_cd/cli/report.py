# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd report``: the reports of a run, redone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from masonry_cd.cli.shared import Folder, errors_reported, exclude, warn

if TYPE_CHECKING:
    from masonry_cd.io.results import Results


def report(
    folder: Folder,
    crack_map: Annotated[bool, typer.Option(help="Draw crack_map.png.")] = True,
    time: Annotated[float | None, typer.Option(metavar="SECONDS", help="Draw the frame next to this time; the last by default.")] = None,
    times: Annotated[str | None, typer.Option(metavar="T1,T2,...", help="Draw a map at each of these times, alike in scale.")] = None,
    view: Annotated[str | None, typer.Option(help="front, back, side, left, top or isometric; the scene's by default.")] = None,
    scale: Annotated[float | None, typer.Option(help="Amplification of displacements; the scene's by default.")] = None,
    cut: Annotated[str | None, typer.Option(metavar="PLANE", help="Cut by a plane, y=1.5 [m], or y for the middle.")] = None,
    thrust: Annotated[bool | None, typer.Option("--thrust/--no-thrust", help="Draw the line of thrust.", show_default=False)] = None,
    animation: Annotated[bool, typer.Option("--animation", help="Draw crack_map.gif, the whole run.")] = False,
    vector: Annotated[bool, typer.Option("--vector", help="Draw crack_map.svg and crack_map.pdf, sharp at any size.")] = False,
    energy: Annotated[bool, typer.Option("--energy", help="Draw energy.png: what was put in, where it went, the balance.")] = False,
    stress_map: Annotated[
        bool, typer.Option("--stress-map", help="Draw stress_map.png, at --time, or of the whole run; the run must have kept stress.")
    ] = False,
    extra: Annotated[list[str] | None, typer.Option(metavar="NAME", help="A further report by its name; as often as needed.")] = None,
    html: Annotated[bool, typer.Option("--html", help="Write report.html, a page that shows the run and needs no network.")] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print that page to report.pdf, by Chromium where it is installed.")] = False,
) -> None:
    """Redo the reports of a run.

    Writes joints.csv, the damage by part (damage.csv, damage_history.csv, hinges.csv, drift.csv, damage.json) and crack_map.png anew from
    result.h5, also for a run that was stopped or killed. Thresholds and grades are those of the scene's [report].

    \b
    Examples:
      masonry-cd report out/aqueduct
      masonry-cd report out/aqueduct --time 3.5 --view isometric --scale 20
      masonry-cd report out/aqueduct --times 1,2,3 --cut y --thrust
      masonry-cd report out/aqueduct --html --no-crack-map
    """
    with errors_reported():
        drawn = crack_map or times is not None or animation or vector or stress_map
        for name, given in (("--view", view), ("--scale", scale), ("--cut", cut), ("--thrust", thrust)):
            exclude((name, given is not None and not (name == "--scale" and (html or pdf))), ("--no-crack-map", not drawn))
        exclude(("--time", time is not None), ("--no-crack-map", not (crack_map or stress_map)))
        from masonry_cd.foundation.extras import require

        if drawn:
            require("a picture", "pyvista", "matplotlib", "PIL", without=" (or go without: --no-crack-map)")
        if html or pdf:
            require("the page", "matplotlib")
        from masonry_cd.io.results import Results
        from reports.settings import report_of

        with Results.open(folder / "result.h5") as results:
            from masonry_cd.app.folders import is_run, names_of_run
            from masonry_cd.app.part_lines import part_lines
            from masonry_cd.app.summary import damage_line, verdict_lines, write_json
            from masonry_cd.foundation import own_files
            from masonry_cd.io.summary_file import NAME
            from reports import damage as damage_files
            from reports import outputs
            from reports.files import Job

            own_files.begin(folder, set(names_of_run()) - {NAME}, is_run)  # a damaged summary.json is replaced
            changes = {"view": view, "scale": scale, "cut": cut, "thrust": thrust, "vector": vector or None, "animation": animation}
            settings = report_of(results.scene, **changes, extra=extra or None)
            outputs.check_again(settings, results)
            names = dict.fromkeys([*settings.extra, *(["energy"] if energy else [])])
            chosen = outputs.parse_times(results, times) if times is not None else []
            settings = settings.model_copy(update={"times": tuple(chosen), "extra": tuple(names)})
            summary, words = summary_of(results, folder)
            summary |= damage_files.write_joint_damage(results, folder, settings)
            typer.echo("\n".join([*verdict_lines(summary), damage_line(summary)]))
            asked = {"damage": True, "crack_map": crack_map, "stress": stress_map or results.has_stress, "stress_map": stress_map}
            job = Job(results, folder, settings, summary, time, asked | {"page": html or pdf, "pdf": pdf})
            typer.echo("\n".join(part_lines(job.damage.parts)))
            written = [folder / "joints.csv", *job.write()]
            if not (folder / NAME).exists() and results.closing:
                added = {key: value for key, value in job.more.items() if key != "parts" or settings.damage}
                write_json(summary | added, folder / NAME)
                written.append(folder / NAME)
        typer.echo(f"written: {', '.join(map(str, written))}")
        warn([*results.words, *words])


def summary_of(results: Results, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """summary.json of a run, or what its results hold of it where a kill came before it was written; and lines on what is damaged.

    Raises:
        InputError: one of a newer format.
    """
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.io.summary_file import NAME, Newer, read_summary

    words: list[str] = []
    try:
        found = read_summary(folder)
    except Newer:
        raise
    except InputError as reason:
        found, words = {}, [f"{reason}; {'it is written anew' if results.closing else 'the report does without it'}"]
        if results.closing:
            (folder / NAME).unlink()
    return found or results.closing, words
