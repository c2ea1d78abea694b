# SPDX-License-Identifier: GPL-3.0-or-later
"""A structure of other blocks: its table with blocks of another size, or laid in another bond, its outline as before.

Lengths of blocks are multiplied, counts of blocks divided; what is counted is whole, so the size that comes out may differ a little. Keys
that a table leaves to defaults which follow the size are left to them; defaults that follow something else are written out.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from typing import Any

from structures.bridge.profile import voussoirs_of
from structures.bridge.table import AbutmentTable, FillTable, SpanTable, SupportTable, WallTable
from structures.tables import table_of

Keys = dict[str, Any]
BARREL = "barrel"
PRESSURES = ("at_rest", "active", "none")
ANGLE = 5.0  # by which the friction angle of fill is varied [degrees]


def resized(table: Mapping[str, Any], factor: float) -> Keys | None:
    """The table [structure] with blocks of other lengths, by a factor; None where its kind has no key for that."""
    made = copy.deepcopy(dict(table))
    kind = str(table.get("kind"))
    if kind not in _SIZES:
        return None
    _SIZES[kind](made, factor)
    return made


def rebonded(table: Mapping[str, Any]) -> list[tuple[str, Keys]]:
    """Other bonds of a structure: of each its name and the table [structure] that has it; none where its kind has no key for that."""
    kind = str(table.get("kind"))
    found: list[tuple[str, Keys]] = []
    if kind in ("church", "tower") or (kind == "vault" and table.get("form", BARREL) == BARREL):
        where = "between rings" if kind == "vault" else "where walls meet"
        bonded = bool(table.get("bonded", True))
        found.append((f"{'straight joints' if bonded else 'bonded'} {where}", {"bonded": not bonded}))
    if kind == "building":
        butt = table.get("junction", "bonded") == "butt"
        found.append((f"{'bonded' if butt else 'straight joints'} where walls meet", {"junction": "bonded" if butt else "butt"}))
        if table.get("bond", "regular") != "regular":
            found.append(("other seed of the bond", {"seed": table.get("seed", 0) + 1}))
    if kind == "solid":
        running = table.get("bond", "running") == "running"
        found.append(("straight joints" if running else "running bond", {"bond": "stack" if running else "running"}))
    if kind == "aqueduct":
        whole = table.get("pier_blocks", 2) == 1
        found.append(("piers in bond" if whole else "whole courses in piers", {"pier_blocks": 2 if whole else 1}))
    if kind in ("wall", "tower") and table.get("leaves", 1) > 1 and table.get("through", 3):
        found.append(("half the through-stones", {"through": 2 * table.get("through", 3)}))
    if kind == "wall" and table.get("core") == "rubble":
        found.append(("other seed of the core", {"core_seed": table.get("core_seed", 0) + 1}))
    if kind == "packing":
        found.append(("other seed", {"seed": table.get("seed", 0) + 1}))
    if kind == "bridge" and any(span.get("rings", 1) > 1 for span in table.get("spans") or ()):
        found.append(("rings as one", {"spans": [{**span, "rings": 1} for span in table["spans"]]}))
    if isinstance(table.get("noise"), Mapping):
        found.append(("other seed of the noise", {"noise": {**table["noise"], "seed": table["noise"].get("seed", 0) + 1}}))
    return [(name, copy.deepcopy({**table, **keys})) for name, keys in found]


def refilled(table: Mapping[str, Any]) -> dict[str, list[tuple[str, Keys]]]:
    """Other assumptions on the fill of a bridge, by what they are about: of each its name and the table [structure] that has it."""
    if table.get("kind") != "bridge":
        return {}
    given = dict(table.get("fill") or {})
    fill = {name: field.default for name, field in FillTable.model_fields.items()} | given
    twice = {name: min(1.0, 2.0 * fill[name]) for name in ("passive", "passive_shaken")}
    none, angle = dict.fromkeys(twice, 0.0), fill["friction_angle"]
    stands = dict(table.get("walls") or {}) or any(not abutment.get("rigid", True) for abutment in table.get("abutments") or ())
    found: dict[str, list[tuple[str, Keys]]] = {
        "resistance": [("none", none), ("twice", twice)] if any(twice.values()) else [("a third of K_p", {"passive": 1.0 / 3.0})],
        "spread": [(way, {"spread": way}) for way in ("boussinesq", "2:1") if way != fill["spread"]],
        "pressure": [
            (way.replace("_", " "), {"pressure": way}) for way in ("at_rest", "active", "none") if stands and way != fill["pressure"]
        ],
        "angle": [(f"{angle + turn:g} degrees", {"friction_angle": angle + turn}) for turn in (-ANGLE, ANGLE) if 0.0 < angle + turn < 60.0],
    }
    return {about: [(name, copy.deepcopy({**table, "fill": {**given, **keys}})) for name, keys in some] for about, some in found.items()}


def _lengths(*names: str) -> Callable[[Keys, float], None]:
    """Multiplies keys that are given or have a default of their own."""

    def change(table: Keys, factor: float) -> None:
        for name in names:
            given = _value(table, name)
            if given is not None:
                table[name] = [factor * value for value in given] if isinstance(given, (list, tuple)) else factor * given

    return change


def _counts(*names: str, least: int = 1) -> Callable[[Keys, float], None]:
    """Divides keys that are given or have a default of their own."""

    def change(table: Keys, factor: float) -> None:
        for name in names:
            given = _value(table, name)
            if given is not None:
                whole = [max(least, round(value / factor)) for value in (given if isinstance(given, (list, tuple)) else [given])]
                table[name] = whole if isinstance(given, (list, tuple)) else whole[0]

    return change


def _value(table: Mapping[str, Any], name: str) -> Any:
    """What a table gives for a key, or else its default."""
    model = table_of(str(table["kind"]))
    return table.get(name, None if model is None else model.model_fields[name].default)


def _dome(table: Keys, factor: float) -> None:
    """Rows follow the thickness by default: pi / 4 span / thickness of them, about, in a hemisphere."""
    thick, span = _value(table, "thickness"), _value(table, "span")
    table.setdefault("rows", max(2, round(0.25 * math.pi * span / thick)))
    table.setdefault("unit_length", 1.5 * thick)
    _lengths("unit_length")(table, factor)
    _counts("rows", least=2)(table, factor)


def _vault(table: Keys, factor: float) -> None:
    """Blocks are 1.2 thicknesses long by default."""
    table.setdefault("unit_length", 1.2 * _value(table, "thickness"))
    _lengths("unit_length")(table, factor)
    _counts("voussoirs", least=3)(table, factor)


def _aqueduct(table: Keys, factor: float) -> None:
    """The courses of the piers are counted, and their height is what the piers keep: it follows from the whole number."""
    before = _value(table, "pier_courses")
    height = _value(table, "course_height")
    table.setdefault("cover", 1.5 * height)
    _counts("pier_courses", "voussoirs", least=2)(table, factor)
    total, now = (sum(n) if isinstance(n, (list, tuple)) else n for n in (before, table["pier_courses"]))
    table["course_height"] = height * total / now
    _lengths("unit_length")(table, factor)


def _bridge(table: Keys, factor: float) -> None:
    """Voussoirs of each span, an even number where there is a joint at the apex; courses of piers, of abutments of blocks and of walls."""
    for span in table.get("spans") or ():
        known = SpanTable.model_validate(span)
        span["voussoirs"] = max(3, round(voussoirs_of(known) / factor))
        if known.shape == "pointed":
            span["voussoirs"] += span["voussoirs"] % 2
    for name, model in (("piers", SupportTable), ("abutments", AbutmentTable), ("walls", WallTable)):
        given = table.get(name, None if name == "walls" else [{}])
        for part in [given] if isinstance(given, dict) else given or ():
            for key in {"course_height", "unit_length"} & set(model.model_fields):
                part[key] = factor * part.get(key, model.model_fields[key].default)
        if given:
            table[name] = given


def _both(first: Callable[[Keys, float], None], second: Callable[[Keys, float], None]) -> Callable[[Keys, float], None]:
    def change(table: Keys, factor: float) -> None:
        first(table, factor)
        second(table, factor)

    return change


_SIZES: dict[str, Callable[[Keys, float], None]] = {
    "aqueduct": _aqueduct,
    "bridge": _bridge,
    "arch": _both(_counts("voussoirs", least=2), _counts("buttress_courses")),
    "building": _lengths("block_length", "course_height"),
    "church": _lengths("block_length", "course_height"),
    "column": _counts("drums"),
    "dome": _dome,
    "solid": _lengths("course_height", "unit_length"),
    "tower": _lengths("course_height", "unit_length"),
    "vault": _vault,
    "wall": _lengths("course_height", "unit_length"),
}
