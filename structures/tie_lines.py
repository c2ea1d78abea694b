# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines on which ties may be built into a structure: those of tables, one by one, and those that its geometry gives.

Floors, roofs and vaults are groups of blocks that rest on walls (:func:`structures.macro_elements.rests`). Under a floor or a roof, and at
the springing of a vault, lines run along x and y at a spacing, between the walls at the ends of what they lie under. Along each wall in
plan a line runs from corner to corner, at the levels of floors and roofs, or near its top.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from structures.macro_elements import BlockLayout, rests
from structures.ties import AXES, ConvexSolids, LineTable, TieRowTable, places_of, ties_of

BELOW = 0.1  # of a floor or roof at which a tie runs [m]
THROUGH = 0.25  # of the box around a straight wall that its widest stone takes at least: walls have at most four leaves
NEAR_TOP = 0.3  # below the top of a wall without floor or roof at which a tie runs along it [m]
RULES = {"floors": "no floor", "roofs": "no roof or vault that lies on walls", "corners": "no walls in plan that meet at corners"}


def one_by_one(blocks: Sequence[Block], tables: Sequence[LineTable], where: str) -> list[tuple[str, dict[str, object]]]:
    """The keys of each line of some tables, with one place and a name of its own, and its table; ``where`` is the key of the list.

    Raises:
        InputError: parts that no block has, or a height at which none of them stands.
    """
    solids, found = ConvexSolids.of(blocks), []
    for i, keys in enumerate(tables):
        own, name = f"{where}[{i}]", keys.name or f"candidate{i + 1}"
        allowed = solids.any_of(keys.parts or ("*",), f"{own}.parts")
        places = places_of(solids, keys, AXES[keys.along], allowed, own)
        fixed = keys.model_dump(
            include=set(LineTable.model_fields) - {"at", "number", "spacing", "name"}, exclude_defaults=True, mode="json"
        )
        for k, place in enumerate(places):
            found.append((own, fixed | {"at": [round(place, 9)], "name": name if len(places) == 1 else f"{name}.{k + 1}"}))
    return found


def by_rule(blocks: Sequence[Block], rule: str, spacing: float, plate: float | None) -> tuple[list[dict[str, object]], str]:
    """The keys of the lines of a rule, and a line on those that hold on to nothing; empty where all do.

    Raises:
        InputError: a structure for which the rule gives none.
    """
    layout, solids = BlockLayout.of(blocks), ConvexSolids.of(blocks)
    lines = _corners(layout, solids) if rule == "corners" else _under(layout, solids, rule, spacing)
    found, left = list[dict[str, object]](), list[str]()
    for keys in lines:
        keys |= {} if plate is None else {"plate": plate}
        try:
            ties_of(blocks, [TieRowTable.model_validate(keys | {"diameter": 0.02})])
        except InputError as error:
            left.append(error.faults[0].text)
        else:
            found.append(keys)
    if not found:
        raise InputError("strengthen.rules", f'"{rule}": the structure has {RULES[rule]}{f": {left[0]}" if left else ""}')
    return found, f"{rule}: {len(left)} of {len(left) + len(found)} lines are left out: {left[0]}" if left else ""


def _slabs(layout: BlockLayout, rule: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """The groups that rest on walls: floors, roofs with vaults, or both without a rule, with the numbers of their blocks."""
    for name in layout.names:
        if rests(name) and rule in ("", "floors" if name.startswith("floor") else "roofs"):
            yield name, layout.of_groups(name)


def _under(layout: BlockLayout, solids: ConvexSolids, rule: str, spacing: float) -> Iterator[dict[str, object]]:
    """Lines under floors, or under roofs and vaults."""
    for name, own in _slabs(layout, rule):
        low, high = layout.low[own].min(axis=0), layout.high[own].max(axis=0)
        for along, axis in AXES.items():
            wide = float(high[1 - axis] - low[1 - axis])
            count = max(1, round(wide / spacing))
            for k in range(count):
                place = 0.5 * float(low[1 - axis] + high[1 - axis]) + (k - 0.5 * (count - 1)) * wide / count
                keys = _line(layout, solids, along, (place, float(low[2]) - BELOW), (float(low[axis]), float(high[axis])))
                yield keys | {"name": f"{name} {along}{k + 1}"}


def _corners(layout: BlockLayout, solids: ConvexSolids) -> Iterator[dict[str, object]]:
    """Lines along walls in plan, from corner to corner."""
    levels = [layout.foot(own) - BELOW for _, own in _slabs(layout)]
    names = [name for name in dict.fromkeys(map(str, layout.wall)) if _is_straight(layout, layout.of_walls(name))]
    for name in names if len(names) > 2 else []:
        own = layout.of_walls(name)
        axis = layout.axis(own)
        across = 0.5 * float(layout.low[own, 1 - axis].min() + layout.high[own, 1 - axis].max())
        ends = float(layout.low[own, axis].min()), float(layout.high[own, axis].max())
        crossed = [level for level in levels if layout.foot(own) < level < layout.top(own)]
        for k, level in enumerate(sorted(set(crossed or [layout.top(own) - NEAR_TOP]))):
            yield _line(layout, solids, "xy"[axis], (across, level), ends) | {"name": f"{name} {k + 1}"}


def _is_straight(layout: BlockLayout, own: np.ndarray) -> bool:
    """True of several blocks of a wall that is straight in plan: its stones reach through its box, or through a leaf of it."""
    if len(own) < 2 or rests(str(layout.group[own[0]])):
        return False
    across = 1 - layout.axis(own)
    size = layout.high[own, across] - layout.low[own, across]
    return bool(size.max() >= THROUGH * (layout.high[own, across].max() - layout.low[own, across].min()))


def _line(
    layout: BlockLayout, solids: ConvexSolids, along: str, through: tuple[float, float], ends: tuple[float, float]
) -> dict[str, object]:
    """The keys of a line along an axis, through a place along the other one and a height, on the walls nearest to two ends along it [m]."""
    axis, point = AXES[along], np.empty(3)
    point[axis], point[1 - axis], point[2] = 0.0, *through
    walls = np.array([not rests(str(group)) for group in layout.group]) & ~layout.fixed
    met = solids.along(axis, point, walls)
    groups = [str(layout.group[min(met, key=lambda part: abs(0.5 * (part[0] + part[1]) - end))[2]]) for end in ends] if met else []
    return {"along": along, "at": [round(through[0], 9)], "height": round(through[1], 9)} | (
        {"parts": list(dict.fromkeys(groups))} if groups else {}
    )
