# SPDX-License-Identifier: GPL-3.0-or-later
"""The structure of a scene alone, written and drawn: what ``masonry-cd build`` does."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.outputs.folders import BLOCKS, files_of
from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result, Say, said, silent
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require

if TYPE_CHECKING:
    from masonry_cd.mechanics.model.blocks import Block
    from structures import MadeStructure
    from structures.geometry.checks import Unsound
    from structures.kind import DrawnPlan

PLAN = tuple(name for name in files_of("build") if name.startswith("plan"))  # plan.json, plan.svg, plan_left.csv, plan_junctions.csv
LEFT = ("handle", "layer", "drawn_as", "why")
MEETINGS = ("what", "x", "y", "walls", "thickness", "angle", "nearest", "gap")
JSON = "json"  # the format in which a structure of kind "file" is best read again


def build(
    scene: Scene, folder: Path, formats: Sequence[str] = (JSON,), picture: bool = True, force: bool = False, say: Say = silent
) -> Result[list[Block]]:
    """Build the structure of a scene, and write it into a folder.

    Args:
        scene: whose tables are checked.
        folder: for the files, created if missing.
        formats: of blocks.
        picture: draw structure.png, or problem.png of blocks that are refused, and the plan of a building.
        force: overwrite the files that are there.
        say: takes lines on problem.png, and on the plan of what is refused, before the error comes.

    Raises:
        InputError: unsound blocks, wrong keys, no such format, or files that are there.
    """
    from structures import summary
    from structures.files import meshfile
    from structures.geometry.checks import Unsound

    if picture:
        require("structure.png", "pyvista", "matplotlib", "PIL", without=" (or go without: --no-picture)")
    formats = tuple(dict.fromkeys(formats))
    for name in formats:
        if name not in BLOCKS:
            raise InputError("--format", f'"{name}" is not a format; choose one of {", ".join(BLOCKS)}')
    marks = [name for name in files_of("build") if not name.startswith("blocks.") or name.removeprefix("blocks.") in formats]
    refused_before = not any((folder / f"blocks.{name}").exists() for name in BLOCKS)
    free_folder(folder, tuple(marks), force or refused_before)  # the plan of what was refused gives way
    for name in formats:
        if name != JSON:
            meshfile.require_writer(folder / f"blocks.{name}")
    from masonry_cd.app.case import assembled, make_structures

    try:
        made = make_structures(scene)
    except InputError as error:
        if picture and isinstance(error, Unsound):
            _draw_problem(error, folder, say)
        _write_refused_plan(scene, folder, picture, error, say)
        raise
    links = assembled(scene, made.blocks, (), made.ties).assembly.links if scene.links else ()
    found = summary.report(made.blocks, links)
    warnings = [*summary.warnings(found), *_doubts(scene, made)]
    own_files.begin(folder, marks)
    written, nameless = _write_blocks(made, folder, formats)
    return Result(
        made.blocks,
        [*summary.lines(found), *made.notes],
        [*warnings, *nameless],
        [*written, *_write_plan(scene, folder, picture), *_draw(scene, made, folder, picture)],
    )


def repairs(asked: Iterable[str]) -> list[str]:
    """The changes of a scene that repairs stand for, "shells" and "gaps=0.002".

    Raises:
        InputError: no such repair.
    """
    changes = []
    for repair in asked:
        what, _, width = repair.partition("=")
        if what not in ("shells", "gaps") or (what == "gaps") != bool(width):
            raise InputError("--repair", f'"{repair}" is not a repair; write shells, or gaps=WIDTH with the widest gap to close [m]')
        changes.append("structure.repair=true" if what == "shells" else f"structure.gaps={width}")
    return changes


def _doubts(scene: Scene, made: MadeStructure) -> list[str]:
    """Walls that do not stand under their fill, and values that are likely not what is wanted."""
    from masonry_cd.app.case import assembled
    from masonry_cd.app.doubts import structure_doubts

    leaning = replace(assembled(scene, made.blocks, (), made.ties), fills=made.fills).leaning if made.fills else []
    return [*leaning, *structure_doubts(scene, made.blocks)]


def _write_blocks(made: MadeStructure, folder: Path, formats: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Write blocks and fills; return the files, and a line where fill cannot be put back from them."""
    from structures.files import blockfile, fillfile, meshfile

    written = [folder / f"blocks.{name}" for name in formats]
    for path in written:
        if path.suffix == f".{JSON}":
            blockfile.write(path, made.blocks, made.fills)
        else:
            meshfile.write(path, made.blocks)
    if not made.fills or tuple(formats) == (JSON,):
        return written, []
    fillfile.write(folder / fillfile.FILL_FILE, made.blocks, made.fills)
    nameless = ", ".join(f"blocks.{name}" for name in formats if name not in (JSON, "step", *meshfile.MARKED))
    lines = [f"{nameless} cannot store names of blocks, which {fillfile.FILL_FILE} needs to restore the fill"] if nameless else []
    return [*written, folder / fillfile.FILL_FILE], lines


def _draw(scene: Scene, made: MadeStructure, folder: Path, picture: bool) -> list[Path]:
    """Draw structure.png where it is requested."""
    if not picture:
        return []
    from reports.drawing.figure import Sheet
    from reports.drawing.solids import structure_scene
    from structures.ties import lines_of

    Sheet.drawn(structure_scene(made.blocks, scene.title, ties=lines_of(made.ties), fills=made.fills)).save(folder / "structure.png")
    return [folder / "structure.png"]


def _draw_problem(fault: Unsound, folder: Path, say: Say) -> None:
    """Draw problem.png where the libraries for it are installed, else warn on standard error; the error itself is reported in any case."""
    try:
        from reports.drawing.refused_blocks import draw_refused_blocks

        own_files.begin(folder, ("problem.png",))
        draw_refused_blocks(fault.blocks, fault.faulty, str(fault), folder / "problem.png")
    except (ImportError, InputError) as failure:
        said(True)(f"masonry-cd: warning: problem.png is not drawn: {failure}")
    else:
        say(f"written: {folder / 'problem.png'}")


def _write_refused_plan(scene: Scene, folder: Path, picture: bool, error: InputError, say: Say) -> None:
    """Write the plan of a building that is refused, as far as it is understood, with its faults marked; else nothing."""
    from structures.geometry.checks import Unsound

    try:
        own_files.check(folder, PLAN)
        written = _write_plan(scene, folder, picture, error, error.faulty if isinstance(error, Unsound) else ())
    except InputError:  # of keys that are wrong, or a drawing that cannot be read, there is no plan
        return
    for path in written:
        say(f"written: {path}")


def _write_plan(scene: Scene, folder: Path, picture: bool, error: InputError | None = None, blocks: Iterable[str] = ()) -> list[Path]:
    """Write the plan from which a structure is built; the paths of what was written, none for a kind without a plan.

    Args:
        scene: of a structure.
        folder: which gets the files.
        picture: whether plan.svg is requested.
        error: for which the structure is refused.
        blocks: names of those that are unsound.

    Raises:
        InputError: a file cannot be written, or a plan cannot be read.
    """
    from structures.plans.json_plan import write_json
    from structures.tables import own_keys

    kind = scene.kind
    if kind is None or kind.plan is None:
        return []
    faults = () if error is None else error.faults
    plan = kind.plan(own_keys(scene.structure), scene.folder, faults)
    if not plan.walls:
        return []
    own_files.begin(folder, PLAN)
    own_files.remove(folder, PLAN[1:])  # of a former build
    written = [folder / PLAN[0]]
    write_json(written[0], plan.tables)
    if picture:
        written.append(folder / PLAN[1])
        wrong = plan.wrong | {block.split(".")[0] for block in blocks}
        _draw_plan(plan, written[-1], scene.title, wrong, () if error is None else error.lines)
    for name, head, rows in ((PLAN[2], LEFT, plan.left), (PLAN[3], MEETINGS, plan.meetings)):
        if rows:
            written.append(folder / name)
            with replacing(written[-1]) as part, part.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([head, *rows])
    return written


def _draw_plan(plan: DrawnPlan, path: Path, title: str, wrong: Collection[str], faults: Sequence[str]) -> None:
    """Draw plan.svg: the walls, and the outlines of vaults and columns; what is wrong in red."""
    from reports.drawing.plan_picture import draw_plan

    others = [(vault["shape"], np.array(vault["corners"], dtype=float)) for vault in plan.tables.get("vaults", ()) if vault.get("corners")]
    for column in plan.tables.get("columns", ()):
        at, half = np.array(column["at"], dtype=float), 0.5 * float(column.get("size", 0.6))
        others += [("", place + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])) for place in at.reshape(-1, 2)]
    draw_plan(plan.walls, others, path, title, wrong, faults)
