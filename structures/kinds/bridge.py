# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges: arches of their own shapes in one or several rings, on piers and abutments, with walls and fill up to a level road.

Everything is plane in the x-z plane of the road and drawn out along y; with a skew it is slanted, x by tan(skew) times y, so that voussoirs
are parallelepipeds whose joints run along the springings. Spans, thicknesses and widths are measured along and at right angles to the
road: a span at right angles to the springings is cos(skew) times as long. The left springing of the first span is at x = 0, and
springings are at z = 0 where their spans do not say otherwise.

The fill is no blocks (:mod:`masonry_cd.mechanics.model.fill`). Its weight rides on the blocks under it, so that it is there in every
analysis, and moves with them in an earthquake.

Groups: ``arch1`` ... (of several rings ``arch1_ring1`` ... from the intrados outwards), ``pier1`` ..., ``abutment1``, ``spandrel_front``,
``wing1_front`` ..., ``parapet_front`` and those at the ``back``, ``backing`` and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import parse_table
from masonry_cd.mechanics.model.blocks import Block, CarriedLoad
from masonry_cd.mechanics.model.fill import COVERED, Fill, FillFace
from masonry_cd.mechanics.model.geometry import mass_properties
from structures import MadeStructure, size
from structures.bridge.backing import backings
from structures.bridge.layout import BridgeLayout, layout_of
from structures.bridge.masonry import arches, supports
from structures.bridge.profile import voussoirs_of
from structures.bridge.table import AbutmentTable, BridgeSupportTable, BridgeTable, FillTable, SpandrelTable, SpanTable
from structures.bridge.walls import walls
from structures.geometry.prism import between
from structures.kind import Keys, StructureKind, scaled, value_of
from structures.macro_elements import AROUND, EAST, HINGES, NORTH, OVERTURNING, SOUTH, WEST, MacroElement
from structures.macro_elements import BlockLayout as Groups

TURN = 5.0  # by which the friction angle of fill is varied [degrees]


def build(table: Mapping[str, Any], density: float, folder: Path) -> MadeStructure:
    """Build a bridge on its fixed feet, with its fill.

    Raises:
        InputError: a key that is unknown or out of range, or all measures that do not fit together, a line each.
    """
    keys = parse_table(BridgeTable, table, "structure")
    layout = layout_of(keys)
    size.check_size(_estimate(layout), "spans" if keys.walls is None else "walls.unit_length")
    blocks, faces = list[Block](), list[FillFace]()
    for made, touched in (part(layout, density) for part in (arches, supports, backings, walls)):
        blocks += made
        faces += touched
    fill = _fill(layout, faces)
    blocks = _loaded(blocks, fill)
    return MadeStructure(blocks, [_note(fill, blocks)], (), (fill,))


def _estimate(layout: BridgeLayout) -> float:
    """About how many blocks a bridge has."""
    keys = layout.keys
    arched = sum(span.rings * voussoirs_of(span) for span in keys.spans) * keys.strips
    if keys.walls is None:
        return arched
    length = layout.ends[1] - layout.ends[0] + 2.0 * (keys.walls.wing_length or 0.0)
    height = layout.deck - min(support.foot for support in layout.supports) + (keys.walls.parapet_height or 0.0)
    return arched + 2.0 * length * height / keys.walls.course_height / keys.walls.unit_length


def _fill(layout: BridgeLayout, faces: Sequence[FillFace]) -> Fill:
    """The fill over and next to the faces that it touches."""
    keys, wings = layout.keys.fill, 0.0 if layout.keys.walls is None else layout.keys.walls.wing_length or 0.0
    return Fill(
        where="structure.fill", level=layout.deck, density=keys.density, friction_angle=keys.friction_angle, spread=keys.spread,
        pressure=keys.pressure, passive=keys.passive, passive_shaken=keys.passive_shaken, mobilised_at=keys.mobilised_at,
        active_at=keys.active_at, gone_at=keys.gone_at,
        deck=(layout.ends[0] - wings, layout.ends[1] + wings), clear=(-layout.clear, layout.clear), faces=tuple(faces), slant=layout.slant,
    )  # fmt: skip


def _loaded(blocks: Sequence[Block], fill: Fill) -> list[Block]:
    """The blocks, with the columns of fill that lie on them up to the road."""
    over: dict[str, list[np.ndarray]] = {}
    for face in fill.faces:
        if face.kind in COVERED:
            over.setdefault(face.block, []).append(face.corners)
    return [block if block.fixed or block.name not in over else replace(block, carried=carried(over[block.name], fill)) for block in blocks]


def carried(faces: Sequence[np.ndarray], fill: Fill) -> CarriedLoad:
    """The fill between faces (n, 3) and the road, as one body."""
    columns = [mass_properties(*between(face, face * [1.0, 1.0, 0.0] + [0.0, 0.0, fill.level])) for face in faces]
    mass = np.array([fill.density * column.volume for column in columns])
    centre = np.sum([m * column.centre for m, column in zip(mass, columns, strict=True)], axis=0) / mass.sum()
    inertia = np.zeros((3, 3))
    for m, column in zip(mass, columns, strict=True):
        arm = column.centre - centre
        inertia += fill.density * column.unit_inertia + m * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return CarriedLoad(float(mass.sum()), centre, inertia)


def _note(fill: Fill, blocks: Sequence[Block]) -> str:
    """How the fill is taken, in a line."""
    ridden = sum(block.carried.mass for block in blocks if block.carried is not None)
    pressed = {"at_rest": "at rest", "active": "active", "none": "none"}[fill.pressure]
    if fill.pressure != "none" and any(face.kind in ("wall", "back") for face in fill.faces):
        falls = f"active {fill.active_at:g} and " if fill.pressure == "at_rest" else ""
        pressed += f" as built, {falls}gone {fill.reach:.3g} of their depth away from there"
    spread = "2:1" if fill.spread == "2:1" else "by Boussinesq's line load within 30 degrees"
    k = fill.coefficients["passive"]
    return (
        f"fill up to z = {fill.level:g} m: {ridden:.4g} kg ride on the blocks below it and move with them; wheels are spread {spread}; "
        f"pressure on walls and backs: {pressed}; arches that move into it meet at most {fill.passive:.3g} of K_p = {k:.3g}, "
        f"under loads that shake or push {fill.passive_shaken:.3g} of it"
    )


def resized(table: Keys, factor: float) -> Keys:
    """Voussoirs of each span, an even number where there is a joint at the apex; courses of piers, of abutments of blocks and of walls."""
    spans = []
    for span in table.get("spans") or ():
        known = SpanTable.model_validate(span)
        count = max(3, round(voussoirs_of(known) / factor))
        spans.append({**span, "voussoirs": count + count % 2 if known.shape == "pointed" else count})
    made = table | {"spans": spans}
    for name, model in (("piers", BridgeSupportTable), ("abutments", AbutmentTable)):
        made[name] = [_coursed(model, part, factor) for part in table.get(name, [{}])]
    if table.get("walls"):
        made["walls"] = _coursed(SpandrelTable, table["walls"], factor)
    return made


def _coursed(model: type[BridgeSupportTable | SpandrelTable], table: Keys, factor: float) -> Keys:
    """A part of a bridge in blocks of other lengths."""
    return scaled(model, table, factor, tuple({"course_height", "unit_length"} & model.model_fields.keys()))


def bonds(table: Keys) -> dict[str, Keys]:
    """Rings that do not slide on each other."""
    ringed = any(span.get("rings", 1) > 1 for span in table.get("spans") or ())
    return {"rings as one": {"spans": [{**span, "rings": 1} for span in table["spans"]]}} if ringed else {}


def _resistances(table: Keys, crossed: bool) -> dict[str, Keys]:
    """Other resistances of the fill where the arch moves into it."""
    twice = {name: min(1.0, 2.0 * _of_fill(table, name)) for name in ("passive", "passive_shaken")}
    if not any(twice.values()):
        return {"a third of K_p": _filled(table, passive=1.0 / 3.0)}
    return {"none": _filled(table, **dict.fromkeys(twice, 0.0)), "twice": _filled(table, **twice)}


def _spreads(table: Keys, crossed: bool) -> dict[str, Keys] | str:
    """The other way in which fill spreads wheels."""
    if not crossed:
        return "no vehicle stands on it"
    return {way: _filled(table, spread=way) for way in ("boussinesq", "2:1") if way != _of_fill(table, "spread")}


def _pressures(table: Keys, crossed: bool) -> dict[str, Keys] | str:
    """Other pressures of the fill on walls and backs of abutments."""
    if not table.get("walls") and all(abutment.get("rigid", True) for abutment in table.get("abutments") or ()):
        return "it presses nothing that may move"
    ways = (way for way in ("at_rest", "active", "none") if way != _of_fill(table, "pressure"))
    return {way.replace("_", " "): _filled(table, pressure=way) for way in ways}


def _angles(table: Keys, crossed: bool) -> dict[str, Keys]:
    """Fill that is looser or denser."""
    angles = (_of_fill(table, "friction_angle") + turn for turn in (-TURN, TURN))
    return {f"{angle:g} degrees": _filled(table, friction_angle=angle) for angle in angles if 0.0 < angle < 60.0}


def _of_fill(table: Keys, name: str) -> Any:
    """A key of the fill."""
    return value_of(FillTable, table.get("fill") or {}, name)


def _filled(table: Keys, **keys: Any) -> Keys:
    """The keys that change the fill."""
    return {"fill": {**(table.get("fill") or {}), **keys}}


def parts(layout: Groups) -> list[MacroElement]:
    """Spans of one or several rings, piers, spandrel walls across the road."""
    found, rings = [], {name: name.split("_")[0] for name in layout.names if name.startswith("arch")}
    for span in dict.fromkeys(rings.values()):
        own = layout.of_groups(*(name for name in rings if rings[name] == span))
        found.append(MacroElement(f"span {span}", "span", own, (EAST, WEST), (HINGES,)))
    for name in layout.names:
        if name.startswith("pier"):
            found.append(MacroElement(name, "pier", layout.of_groups(name), AROUND, (OVERTURNING,)))
        elif name.startswith(("spandrel", "wing")):
            way = SOUTH if name.endswith("front") else NORTH
            found.append(MacroElement(name.replace("_", " "), "wall", layout.of_groups(name), (way,), (OVERTURNING,)))
    return found


KIND = StructureKind(
    build, BridgeTable, first={"spans": [{"span": 6.0, "rise": 1.8, "thickness": 0.5}], "width": 4.0, "cover": 0.4},
    resized=resized, bonds=bonds, parts=parts,
    assumptions={"fill resistance": _resistances, "fill spread": _spreads, "fill pressure": _pressures, "fill angle": _angles},
)  # fmt: skip
