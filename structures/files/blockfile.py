# SPDX-License-Identifier: GPL-3.0-or-later
"""Block files: the blocks of a structure as JSON.

    {"units": "m", "blocks": [{"name": "v1", "vertices": [[x, y, z], ...], "faces": [[i, j, k, ...], ...],
                               "density": 2200, "fixed": false, "group": "arch"}, ...]}

Faces are zero-based loops of vertices, counter-clockwise seen from outside. A block that is not convex lists the convex parts that
fill it, ``"parts": [{"vertices": ..., "faces": ...}, ...]``, besides its own shell. A sphere has ``"centre": [x, y, z]`` and
``"radius": r`` instead of vertices and faces. Blocks with the same ``"stone"`` are pieces of it, which
crack from each other by ``material.stones``. Name, density, group and units have defaults:
b0, b1 ...; the material's density; ``base`` for fixed blocks and ``block`` for the others; metres. ``"fills"`` and ``"carried"`` are the
fill of bridges (:mod:`structures.files.fillfile`). Other keys at the top level are left alone, so that a program may keep its own notes
in the same file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron
from masonry_cd.mechanics.model.sphere import ball_centre
from structures.files import fillfile
from structures.files.json_object import load
from structures.geometry.checks import Unsound, check, check_shells
from structures.geometry.convex import split
from structures.geometry.merge_coplanar import merge_coplanar

OF_SUPPORTS = 2000.0  # density of fixed blocks where none is given: it enters no result [kg/m3]
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
Finite = Annotated[float, Field(allow_inf_nan=False)]


Vertices = Annotated[list[Annotated[list[Finite], Field(min_length=3, max_length=3)]], Field(min_length=4)]
Loops = Annotated[list[Annotated[list[Annotated[int, Field(ge=0, lt=2**31)]], Field(min_length=3)]], Field(min_length=4)]


class PartEntry(BaseModel):
    """A convex part of a block."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)

    vertices: Vertices
    faces: Loops


class _Keys(BaseModel):
    """Keys of any block of a block file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)

    name: str | None = Field(None, min_length=1)
    density: Annotated[float, Unit("kg/m3"), Field(gt=0, allow_inf_nan=False)] | None = None
    fixed: bool = False
    group: str | None = Field(None, min_length=1)


class BlockEntry(_Keys):
    """A polyhedron."""

    vertices: Vertices
    faces: Loops
    parts: list[PartEntry] = []
    stone: str = ""


class Sphere(_Keys):
    """A sphere."""

    centre: Annotated[list[Finite], Field(min_length=3, max_length=3)]
    radius: float = Field(gt=0, allow_inf_nan=False)


def sound(blocks: Sequence[Block], source: str, overlap: float = 0.0) -> list[Block]:
    """Blocks of any shape, checked, those that are not convex split into convex parts; they may be in each other up to a depth [m].

    Raises:
        Unsound: one line that names the block.
    """
    check_shells(blocks, source)
    try:
        parted = [block if block.radius else split(block) for block in blocks]
    except Unsound as failure:
        failure.blocks = tuple(blocks)
        raise failure.under(source) from None
    check(parted, source, overlap)
    return merge_coplanar(parted)


def read(path: Path, density: float) -> list[Block]:
    """Read and check a block file.

    Args:
        path: a JSON file as described above.
        density: for the blocks that state none [kg/m3].

    Raises:
        InputError: one line that names the file and the block, key or line.
    """
    blocks = read_unchecked(path, density)
    check(blocks, path.name)
    return merge_coplanar(blocks)


def read_unchecked(path: Path, density: float) -> list[Block]:
    """The blocks of a block file, whose shells may be open, or reach into each other."""
    content = load(path, "blocks")
    scale = _scale(content, path)
    entries = content.get("blocks")
    if not isinstance(entries, list) or not entries:
        raise InputError(path.name, '"blocks" must be a list of one block or more')
    return [_block(entry, i, density, scale, path) for i, entry in enumerate(entries)]


def read_fill(path: Path) -> dict[str, Any]:
    """Return the fill of a block file, see :func:`structures.files.fillfile.with_fill`.

    Raises:
        InputError: in units that are not those of fill.
    """
    content = load(path, "blocks")
    if _scale(content, path) != 1.0 and any(key in content for key in fillfile.KEYS):
        raise InputError(path.name, f"{' and '.join(fillfile.KEYS)} are in metres; give the blocks in metres as well")
    return content


def write(path: Path, blocks: Sequence[Block], fills: Sequence[Fill] = ()) -> None:
    """Write a block file in metres, one block per line; reading it gives the same blocks to the bit. A density of NaN is left out."""
    lines = []
    for block in blocks:
        entry: dict[str, Any] = {
            "name": block.name,
            **_form(block),
            **({} if math.isnan(block.density) else {"density": block.density}),
            "fixed": block.fixed,
            "group": block.group,
            **({"stone": block.stone} if block.stone else {}),
        }
        if block.parts:
            entry["parts"] = [{"vertices": p.vertices.tolist(), "faces": [list(face) for face in p.faces]} for p in block.parts]
        lines.append(json.dumps(entry))
    with replacing(path) as part:
        fill = "".join(f',\n"{key}": {json.dumps(value)}' for key, value in fillfile.entries(blocks, fills).items())
        part.write_text('{"units": "m", "blocks": [\n' + ",\n".join(lines) + f"\n]{fill}}}\n", encoding="utf-8")


def _form(block: Block) -> dict[str, Any]:
    """Vertices and faces of a polyhedron, centre and radius of a sphere."""
    if block.radius:
        return {"centre": ball_centre(block.vertices).tolist(), "radius": block.radius}
    return {"vertices": block.vertices.tolist(), "faces": [list(face) for face in block.faces]}


def _scale(content: Mapping[str, Any], path: Path) -> float:
    """Metres per unit of the file."""
    units = str(content.get("units", "m"))
    if units not in METRES:
        raise InputError(path.name, f'unknown units "{units}"{suggest(units, METRES)}; known: {", ".join(METRES)}')
    return METRES[units]


def _block(entry: Any, index: int, density: float, scale: float, path: Path) -> Block:
    """Turn one entry into a block."""
    given = entry.get("name") if isinstance(entry, dict) else None
    where = f'{path.name}: block "{given}"' if isinstance(given, str) else f"{path.name}: blocks[{index}]"
    if not isinstance(entry, dict):
        raise InputError(where, "must be an object with vertices and faces, or centre and radius")
    if "radius" in entry or "centre" in entry:
        ball = parse_table(Sphere, entry, where)
        return Block.sphere(centre=np.array(ball.centre) * scale, radius=ball.radius * scale, **_common(ball, index, density))
    parsed = parse_table(BlockEntry, entry, where)
    vertices, faces = _shell(parsed, scale)
    parts = tuple(Polyhedron(*_shell(part, scale)) for part in parsed.parts)
    return Block(vertices=vertices, faces=faces, parts=parts, stone=parsed.stone, **_common(parsed, index, density))


def _common(parsed: _Keys, index: int, density: float) -> dict[str, Any]:
    """Return the common keys of any block, with their defaults."""
    return {
        "name": parsed.name or f"b{index}",
        "density": _density(parsed, density),
        "group": parsed.group or ("base" if parsed.fixed else "block"),
        "fixed": parsed.fixed,
    }


def _density(parsed: _Keys, density: float) -> float:
    """Its own, or that of the material; a support needs none, since it has no weight to bear and nothing moves it."""
    if parsed.density is not None:
        return parsed.density
    return OF_SUPPORTS if parsed.fixed and math.isnan(density) else density


def _shell(entry: BlockEntry | PartEntry, scale: float) -> tuple[np.ndarray, Faces]:
    """Vertices in metres, and faces."""
    vertices = np.array(entry.vertices)
    return vertices if scale == 1.0 else vertices * scale, tuple(tuple(face) for face in entry.faces)
