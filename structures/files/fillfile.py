# SPDX-License-Identifier: GPL-3.0-or-later
"""The fill of bridges as JSON: what it does to the faces that it touches, and what of it rides on which block.

    {"fills": [{"level": 2.3, "density": 2000, "friction_angle": 30, "spread": "2:1", "pressure": "at_rest", "passive": 0.33, ...,
                "faces": [{"block": "arch1.v1", "kind": "extrados", "corners": [[x, y, z], ...]}, ...]}],
     "carried": {"arch1.v1": {"mass": 812.5, "centre": [x, y, z], "inertia": [[...], [...], [...]]}, ...}}

in metres and kilograms, inertia about the centre. Both are keys of a block file (:mod:`structures.files.blockfile`), or of a file of their
own next to blocks in other formats. What is written is read back to the bit.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block, CarriedLoad
from masonry_cd.mechanics.model.fill import ACTIVE_AT, Fill, FillFace
from structures.schema import Density, Place, Share, Table

FILL_FILE = "fill.json"
SAME = 1e-6  # [m]: heights nearer than this are one
FILLS, CARRIED = "fills", "carried"
KEYS = (FILLS, CARRIED)
Point = Annotated[list[Place], Field(min_length=3, max_length=3)]
Ends = Annotated[list[Place], Field(min_length=2, max_length=2)]
Matrix = Annotated[list[Point], Field(min_length=3, max_length=3)]
Part = Annotated[float, Field(ge=0.0, le=1.0)]


class FaceEntry(Table):
    """A face that the fill touches."""

    block: str
    kind: Literal["extrados", "top", "back", "wall"]
    corners: Annotated[list[Point], Field(min_length=3)]


class FillEntry(Table):
    """The fill of one bridge, see :class:`masonry_cd.mechanics.model.fill.Fill`."""

    level: Place
    density: Density
    friction_angle: float = Field(ge=0.0, lt=60.0)
    spread: Literal["2:1", "boussinesq"]
    pressure: Literal["at_rest", "active", "none"]
    passive: Part
    passive_shaken: Part
    mobilised_at: Share
    deck: Ends
    clear: Ends
    faces: list[FaceEntry]
    active_at: float = Field(ACTIVE_AT, ge=1e-4, le=0.1)
    gone_at: float | None = Field(None, gt=0.0, le=10.0)
    slant: float = Field(0.0, allow_inf_nan=False)
    origin: Point | None = None
    turn: Matrix | None = None


class CarriedEntry(Table):
    """Load that a block carries."""

    mass: Share
    centre: Point
    inertia: Matrix


def entries(blocks: Sequence[Block], fills: Sequence[Fill]) -> dict[str, Any]:
    """The two keys, those of them that there is something for."""
    riding = {block.name: _plain(block.carried._asdict()) for block in blocks if block.carried is not None}
    found = {FILLS: [_entry(fill) for fill in fills], CARRIED: riding}
    return {key: value for key, value in found.items() if value}


def _entry(fill: Fill) -> dict[str, Any]:
    kept = {name: getattr(fill, name) for name in FillEntry.model_fields if name != "faces"}
    return _plain({**kept, "faces": [face._asdict() for face in fill.faces]})


def _plain(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table with lists in place of arrays and tuples, and without what is not there."""
    listed = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in table.items() if value is not None}
    return {
        name: [_plain(each) if isinstance(each, Mapping) else each for each in value] if isinstance(value, (list, tuple)) else value
        for name, value in listed.items()
    }


def write(path: Path, blocks: Sequence[Block], fills: Sequence[Fill]) -> None:
    """Write a file of its own."""
    with replacing(path) as part:
        part.write_text(json.dumps(entries(blocks, fills)) + "\n", encoding="utf-8")


def with_fill(blocks: Sequence[Block], content: Mapping[str, Any], source: str, of: str) -> tuple[list[Block], tuple[Fill, ...]]:
    """Blocks of a file ``of`` with what rides on them, and the fills that the content of a file has.

    Raises:
        InputError: a key that is wrong, or a block that is not there.
    """
    names = {block.name for block in blocks}
    fills = tuple(_fill(entry, f"{source}: {FILLS}[{i}]", of, names) for i, entry in enumerate(_listed(content, FILLS, source, list)))
    riding = {}
    for name, entry in _listed(content, CARRIED, source, dict).items():
        where = f'{source}: {CARRIED}, block "{name}"'
        _refuse_absent({name}, names, f"{source}: {CARRIED}", of)
        keys = parse_table(CarriedEntry, entry if isinstance(entry, dict) else {}, where)
        riding[name] = CarriedLoad(keys.mass, np.array(keys.centre), _positive(np.array(keys.inertia), where))
    return [replace(block, carried=riding[block.name]) if block.name in riding else block for block in blocks], fills


def _listed(content: Mapping[str, Any], key: str, source: str, kind: type[Any]) -> Any:
    """The value of a key, empty where it is not there."""
    value = content.get(key, kind())
    if not isinstance(value, kind):
        raise InputError(source, f'"{key}" must be {"a list of fills" if kind is list else "an object, by the names of blocks"}')
    return value


def _fill(entry: Any, where: str, of: str, names: set[str]) -> Fill:
    keys = parse_table(FillEntry, entry if isinstance(entry, dict) else {}, where)
    _refuse_absent({face.block for face in keys.faces}, names, f"{where}.faces", of)
    faces = tuple(FillFace(face.block, face.kind, np.array(face.corners)) for face in keys.faces)
    own = {name: getattr(keys, name) for name in FillEntry.model_fields}
    for name in ("deck", "clear"):
        low, high = own[name] = tuple(own[name])
        if low >= high:
            raise InputError(f"{where}.{name}", f"must be two places, the lower first, got {low:g} and {high:g}")
    if keys.gone_at is not None and keys.gone_at <= keys.active_at:
        raise InputError(f"{where}.gone_at", f"must exceed active_at, {keys.active_at:g}, got {keys.gone_at:g}")
    for i, face in enumerate(faces):
        if (highest := float(face.corners[:, 2].max())) > keys.level + SAME:
            raise InputError(f"{where}.faces[{i}]", f"reaches up to z = {highest:.4g} m, above the fill, which ends at {keys.level:.4g} m")
    arrays = {name: None if own[name] is None else np.array(own[name]) for name in ("origin", "turn")}
    return Fill(where=where, **{**own, **arrays, "faces": faces})


def _refuse_absent(wanted: set[str], names: set[str], where: str, of: str) -> None:
    absent = sorted(wanted - names)
    if absent:
        more = f" and {len(absent) - 1} more" if len(absent) > 1 else ""
        raise InputError(where, f'no block "{absent[0]}"{more} in {of}')


def _positive(inertia: np.ndarray, where: str) -> np.ndarray:
    if np.abs(inertia - inertia.T).max() > 1e-9 * np.abs(inertia).max() or np.linalg.eigvalsh(inertia).min() < 0.0:
        raise InputError(where, "inertia: must be symmetric, with moments of 0 or more")
    return inertia
