# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd build``: the structure of a scene alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from masonry_cd.app.folders import free_folder
from masonry_cd.cli.shared import Changes, Force, Output, SceneFile, Trust, errors_reported, warn
from masonry_cd.foundation import own_files

if TYPE_CHECKING:
    from structures.geometry.checks import Unsound


def _list_formats(asked: bool) -> None:
    """Print the formats and end, whatever else is asked for."""
    if asked:
        from structures.files.formats import listed

        typer.echo("\n".join(listed()))
        raise typer.Exit


def build(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    picture: Annotated[bool, typer.Option(help="Draw structure.png, or problem.png of blocks that are refused.")] = True,
    format_: Annotated[
        list[str] | None,
        typer.Option(
            "--format", metavar="NAME", help="json, obj, stl, vtu, vtm, vtkhdf, step, brep or msh; as often as needed.", show_default="json"
        ),
    ] = None,
    repair: Annotated[
        list[str] | None, typer.Option(metavar="WHAT", help="Of a file: shells, or gaps=0.002 [m] to close gaps up to that width.")
    ] = None,
    force: Force = False,
    list_formats: Annotated[
        bool, typer.Option("--formats", help="List the formats of blocks that are read and written.", is_eager=True, callback=_list_formats)
    ] = False,
    trust: Trust = False,
) -> None:
    """Build the structure of a scene alone.

    DIR gets blocks.json, which kind = "file" reads back, or the blocks in other formats, and structure.png. The fill of a bridge is in
    blocks.json, and in fill.json beside other formats. Where blocks are refused, problem.png shows which. A building's plan is written as
    plan.json, to be corrected and read again, and drawn as plan.svg; plan_left.csv lists what of a drawing was not understood.

    \b
    Examples:
      masonry-cd build aqueduct.toml -o out/aqueduct
      masonry-cd build aqueduct.toml -o out/five --set structure.spans=5 --no-picture
      masonry-cd build scan.toml -o out/scan --repair shells --repair gaps=0.002
      masonry-cd build aqueduct.toml -o out/meshes --format obj --format vtkhdf
    """
    from masonry_cd.foundation.extras import require

    with errors_reported():
        if picture:
            require("structure.png", "pyvista", "matplotlib", "PIL", without=" (or go without: --no-picture)")
        from masonry_cd.analysis.outputs.folders import files_of
        from masonry_cd.app import plan_files

        formats = _formats(format_)
        marks = [name for name in files_of("build") if not name.startswith("blocks.") or name.removeprefix("blocks.") in formats]
        free_folder(output, tuple(marks), force)
        from masonry_cd.app.scene import read_scene

        asked = read_scene(scene, [*(set_ or ()), *_repairs(repair)])
        from structures.files import blockfile, fillfile, meshfile

        for name in formats:
            if name != "json":
                meshfile.require_writer(output / f"blocks.{name}")
        import structures
        from masonry_cd.app.case import assembled, make_structures
        from masonry_cd.app.doubts import structure_doubts
        from structures import summary
        from structures.geometry.checks import Unsound

        try:
            blocks, notes, ties, fills = make_structures(asked)
        except Unsound as fault:
            if picture:
                _draw_problem(fault, output)
            raise
        made = structures.report(blocks)
        typer.echo("\n".join([*summary.lines(made), *notes]))
        leaning = replace(assembled(asked, blocks, (), ties), fills=fills).leaning if fills else []
        warn([*summary.warnings(made), *leaning, *structure_doubts(asked, blocks)])
        own_files.begin(output, marks)
        written = [output / f"blocks.{name}" for name in formats]
        for path in written:
            if path.suffix == ".json":
                blockfile.write(path, blocks, fills)
            else:
                meshfile.write(path, blocks)
        if fills and formats != ("json",):
            written.append(output / fillfile.FILL_FILE)
            fillfile.write(written[-1], blocks, fills)
            nameless = ", ".join(f"blocks.{name}" for name in formats if name not in ("json", "step", *meshfile.MARKED))
            warn([f"{nameless} keep no names of blocks, by which {fillfile.FILL_FILE} puts the fill back"] if nameless else [])
        if plan_files.is_of_plan(asked):
            written += plan_files.write_plan_files(asked, output, picture)
        if picture:
            from reports.drawing.figure import Sheet
            from reports.drawing.solids import structure_scene
            from structures.ties import lines_of

            written.append(output / "structure.png")
            Sheet.drawn(structure_scene(blocks, asked.title, ties=lines_of(ties))).save(written[-1])
        typer.echo(f"written: {', '.join(map(str, written))}")


def _formats(asked: list[str] | None) -> tuple[str, ...]:
    """The formats of blocks to write, each once."""
    from masonry_cd.analysis.outputs.folders import BLOCKS
    from masonry_cd.foundation.errors import InputError

    for name in asked or ():
        if name not in BLOCKS:
            raise InputError("--format", f'"{name}" is none; formats: {", ".join(BLOCKS)}')
    return tuple(dict.fromkeys(asked or ("json",)))


def _repairs(asked: list[str] | None) -> list[str]:
    """What --repair changes in the scene."""
    from masonry_cd.foundation.errors import InputError

    changes = []
    for repair in asked or ():
        what, _, width = repair.partition("=")
        if what not in ("shells", "gaps") or (what == "gaps") != bool(width):
            raise InputError("--repair", f'"{repair}" is none; shells, or gaps=WIDTH with the widest gap to close [m]')
        changes.append("structure.repair=true" if what == "shells" else f"structure.gaps={width}")
    return changes


def _draw_problem(fault: Unsound, folder: Path) -> None:
    """Draw problem.png where the libraries for it are installed; the error itself is reported in any case."""
    from masonry_cd.foundation.errors import InputError

    try:
        from reports.drawing.refused_blocks import problem_picture

        own_files.begin(folder, ("problem.png",))
        problem_picture(fault.blocks, fault.faulty, str(fault), folder / "problem.png")
    except (ImportError, InputError) as failure:
        typer.echo(f"masonry-cd: warning: problem.png is not drawn: {failure}", err=True)
        return
    typer.echo(f"written: {folder / 'problem.png'}")
