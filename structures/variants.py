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

from structures.tables import table_of

Keys = dict[str, Any]
BARREL = "barrel"


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
    if isinstance(table.get("noise"), Mapping):
        found.append(("other seed of the noise", {"noise": {**table["noise"], "seed": table["noise"].get("seed", 0) + 1}}))
    return [(name, copy.deepcopy({**table, **keys})) for name, keys in found]


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


def _both(first: Callable[[Keys, float], None], second: Callable[[Keys, float], None]) -> Callable[[Keys, float], None]:
    def change(table: Keys, factor: float) -> None:
        first(table, factor)
        second(table, factor)

    return change


_SIZES: dict[str, Callable[[Keys, float], None]] = {
    "aqueduct": _aqueduct,
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
