# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks cut from a solid: a CAD model (.step, .stp, .brep) or a gmsh script (.geo), laid in courses.

The geometry kernel OpenCASCADE does the cutting, through gmsh. Level planes cut the solid into courses of one height. In each course
upright planes cut the bodies into stones, across x and across y, half a stone farther on in every second course (running bond). Bodies no
longer than a stone stay whole, and no plane passes closer than a quarter of a stone to the end of a body or to the face of a wall along
which it runs: there are no slivers. Stones twice as long as the walls are thick bond the corners of a plan with whole stones, since
the grid begins at the lowest corner of the solid; otherwise there are stones around the corner.

Joints are planes, so they are exact: corners that the kernel returns within ``tolerance`` of such a plane are put onto it, and
the stones of both sides share it to the bit. Only the outer faces of a solid may be curved. These become flat facets with all corners on
the surface, at most ``chord`` off; stones that are not convex (at a corner of the plan, under a curved intrados) are split exactly into
convex parts that move as one.

The kernel reads and cuts in a child process (:mod:`structures.files.cutting`). A .geo is a program in gmsh's language: it can start others,
read and write any file, and is refused unless the command line says ``--trust``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.trust import require_trust
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.files import foreign
from structures.files.blockfile import METRES, sound
from structures.files.meshfile import placed, repaired
from structures.geometry import prism
from structures.kind import Keys, StructureKind, scaled
from structures.schema import Length, Table, WallHeight

SUFFIXES = (".geo", ".step", ".stp", ".brep")
FILLED = 1e-6  # volume of the blocks relative to that of a solid with flat faces
PROGRAM = "a program that gmsh runs with your rights: it may start others, read and write files"
GEO = """// A wall of 3 x 0.5 x 2 m: put your own solid in its place, or name a .step file.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 3.0, 0.5, 2.0};
"""
DAY = 86400.0  # [s]
SECONDS = 600.0  # of processor time, unless the scene says otherwise [s]: towers of 35 to 63 stones take 1 to 4 s


class SolidTable(Table):
    """The [structure] table of a solid that is cut into blocks."""

    path: str
    """of the solid, relative to the scene file"""
    units: Literal["m", "cm", "mm"] | None = None
    """unit of a .geo or .brep file, which does not state it"""
    up: Literal["y", "z"] = "z"
    """which axis of the file points upwards"""
    course_height: WallHeight
    """aimed at: the height is divided into whole courses"""
    unit_length: Length | None = None
    """of a stone; by default two courses"""
    bond: Literal["running", "stack"] = "running"
    """running: every second course is shifted by half a stone"""
    chord: Length | None = None
    """how far a flat facet may be off the curved face that it stands for"""
    tolerance: Length = 1e-6
    """corners this close to a joint's plane lie in it"""
    trusted: bool = False
    """of older scenes with a .geo file, which is a program; alone it has no effect: --trust runs it"""
    time_limit: Annotated[float, Unit("s")] = Field(SECONDS, gt=0, le=DAY)
    """processor time that reading and cutting may take"""
    base_depth: Length | None = None
    """of the fixed block underneath; by default a course"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> tuple[list[Block], list[str]]:
    """Cut the solid that a [structure] table names.

    Returns:
        the blocks, with a fixed one underneath, and lines on what was not read, and on the facets where faces are curved.

    Raises:
        InputError: a file that cannot be read or is not trusted, curved faces without ``chord``, or a piece that makes no sound block.
    """
    keys = parse_table(SolidTable, table, "structure")
    path = folder / keys.path
    scale = _scale(keys, path)
    _trusted(keys, path)
    stones, (whole, curved, off), unread = _cut(keys, path, scale)
    blocks = _named(stones, keys, scale, density, path.name)
    filled = sum(block.mass_properties.volume for block in blocks)
    if not curved and abs(filled / (whole * scale**3) - 1.0) > FILLED:
        raise InputError(path.name, f"its pieces have {filled:.9g} m3, the solid has {whole * scale**3:.9g} m3")
    notes = [*unread]
    if curved:
        share = 100.0 * (filled / (whole * scale**3) - 1.0)
        notes.append(
            f"{path.name}: curved faces are flat facets, at most {1e3 * scale * off:.3g} mm off; the volume changes by {share:+.3g} %"
        )
    return sound([*blocks, _base(blocks, keys, density)], path.name), notes


def _trusted(keys: SolidTable, path: Path) -> None:
    """Refuse a .geo that whoever runs the scene does not vouch for; what the scene says of it does not count."""
    program = path.suffix.lower() == ".geo"
    if program:
        require_trust("structure.path", path.name, PROGRAM, ", else use a .step or .brep")
    if not program and "trusted" in keys.model_fields_set:
        raise InputError("structure.trusted", f"belongs to .geo files, which are programs; {path.name} is none")


def _cut(keys: SolidTable, path: Path, scale: float) -> foreign.FileContents:
    """The stones, as :func:`structures.files.cutting.cut` returns them from a child process, their corners joined."""
    asked = {
        "scale": scale,
        "up": keys.up,
        "course_height": keys.course_height,
        "unit_length": keys.unit_length or 2.0 * keys.course_height,
        "running": keys.bond == "running",
        "chord": keys.chord,
        "tolerance": keys.tolerance,
        "most_blocks": size.most_blocks(),
    }
    limits = foreign.Limits(seconds=keys.time_limit)
    made = foreign.read("structures.files.cutting:cut", path, asked, limits, advice="; structure.time_limit gives it longer")
    pieces = [foreign.FileShell(p.number, p.name, *repaired(p.vertices, p.faces, keys.tolerance / scale)) for p in made.pieces]
    return made._replace(pieces=pieces)


def _scale(keys: SolidTable, path: Path) -> float:
    """Metres per unit of the file; STEP files are read in metres."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError("structure.path", f'"{keys.path}" is not a solid; known: {", ".join(SUFFIXES)}')
    if not is_file(path):
        raise InputError("structure.path", f'no file "{keys.path}"')
    states = path.suffix.lower() in (".step", ".stp")
    if states and keys.units is not None:
        raise InputError("structure.units", f"belongs to .geo and .brep files; {path.name} states it itself")
    if not states and keys.units is None:
        raise InputError("structure.units", f"missing; {path.name} does not say it, so take one of {', '.join(METRES)}")
    return METRES[keys.units or "m"]


def _named(stones: Sequence[foreign.FileShell], keys: SolidTable, scale: float, density: float, source: str) -> list[Block]:
    """Blocks in metres, z up, named by course and place: ``c0s0``, ``c0s1`` ... from the foot upwards."""
    made = []
    for course, group, vertices, faces, *_ in stones:
        if len(faces) < 4:
            raise InputError(source, f"a piece of course {course} has only {len(faces)} faces; its solid is not closed")
        made.append((course, Block("", placed(vertices, scale, keys.up), faces, density, group)))
    made.sort(key=lambda item: (item[0], *np.round(item[1].vertices.mean(axis=0)[[1, 0]], 6)))
    count: dict[int, int] = {}
    blocks = []
    for course, block in made:
        blocks.append(replace(block, name=f"c{course}s{count.get(course, 0)}"))
        count[course] = count.get(course, 0) + 1
    return blocks


def _base(blocks: Sequence[Block], keys: SolidTable, density: float) -> Block:
    """The fixed block underneath, wider than the structure by its own depth."""
    corners = np.concatenate([block.vertices for block in blocks])
    depth = keys.base_depth or keys.course_height
    low, high = corners.min(axis=0) - depth, corners.max(axis=0) + depth
    vertices, faces = prism.box(tuple(low), (high[0], high[1], corners[:, 2].min()))
    return Block("ground", vertices, faces, density, "base", fixed=True)


def bonds(table: Keys) -> dict[str, Keys]:
    """Straight joints from bottom to top, or stones in bond."""
    running = table.get("bond", "running") == "running"
    return {"straight joints" if running else "running bond": {"bond": "stack" if running else "running"}}


KIND = StructureKind(
    build, SolidTable, first={"path": "solid.geo", "units": "m", "course_height": 0.5}, files=lambda: {"solid.geo": GEO},
    remark="its solid.geo is a program of gmsh: the commands that read this scene take --trust",
    resized=partial(scaled, SolidTable, lengths=("course_height", "unit_length")), bonds=bonds, checks=True,
)  # fmt: skip
