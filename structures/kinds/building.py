# SPDX-License-Identifier: GPL-3.0-or-later
"""Buildings from a plan: walls by their middle lines, of any direction, with their junctions, openings, vaults, columns and arcades.

A plan is typed as tables of the scene, or read from a JSON or DXF file (``plan``). Walls that meet, at a corner, against a side or across
each other, are interlocked course by course; every corner is filled. How: :mod:`structures.building`.

Groups are the names of walls, vaults, columns and arcades, unless they say another, and ``base``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.errors import Fault, Faults, InputError, parse_table
from structures import Made
from structures.building.elements import parts
from structures.building.table import BuildingTable
from structures.kind import Keys, StructureKind, other_seed, scaled
from structures.layout.ground import ground
from structures.plans import Plan, open_plan
from structures.plans.keys import PlanKeys
from structures.plans.places import drawn_about

if TYPE_CHECKING:
    from structures.plans.recognised import Left


def build(table: Mapping[str, Any], density: float, folder: Path) -> Made:
    """Build a building on its base; the notes say what of its plan was assumed, and what was not understood.

    Raises:
        InputError: a key that is wrong, or all that is wrong with the plan, a line each.
    """
    from structures.building import engine

    keys, plan = _opened(table, folder)
    try:
        with drawn_about(plan.origin):
            blocks, bars, apart = engine.blocks_of(keys, density)
    except InputError as error:
        raise error.each(lambda fault: _in_plan(fault, table, plan)) from None
    blocks.append(ground(blocks, keys.base_depth or 2.0 * keys.course_height, density))
    return Made(blocks, [*plan.notes, *apart], bars)


def plan_tables(table: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], list[Left]]:
    """All that scene and plan say of a building, as tables of a plan in JSON, and what of a drawing was not understood.

    Raises:
        InputError: a key that is wrong, or a plan that cannot be read.
    """
    keys, plan = _opened(table, folder)
    return keys.model_dump(mode="json", exclude_unset=True, exclude={"plan", *PlanKeys.model_fields}), plan.left


def _opened(table: Mapping[str, Any], folder: Path) -> tuple[BuildingTable, Plan]:
    """The keys of a table and its plan, whose lists come before those of the table; an empty one where it names none.

    Raises:
        InputError: keys of the table that are wrong, or else what the plan lacks, or else keys of the plan that are wrong.
    """
    keys = parse_table(BuildingTable, table, "structure")
    if keys.plan is None:
        return keys, Plan({}, [], [])
    own = {key: value for key, value in table.items() if key != "plan"}
    plan = open_plan(folder / keys.plan, own)
    Faults([*plan.faults.values()]).refuse()
    lists = {key: [*plan.tables[key], *own[key]] for key in own if isinstance(own[key], (list, tuple)) and key in plan.tables}
    try:
        return parse_table(BuildingTable, {**plan.tables, **own, **lists}, "structure"), plan
    except InputError as error:
        raise error.each(lambda fault: _in_plan(fault, table, plan)) from None


def _in_plan(fault: Fault, table: Mapping[str, Any], plan: Plan) -> Fault:
    """A fault of an entry of a list, which lies in the file of the plan, or else is counted as in the scene."""
    found = re.match(r"structure\.(\w+)\[(\d+)\]", fault.place)
    if found is None or found[1] not in plan.tables:
        return fault
    number = int(found[2]) - len(plan.tables[found[1]])
    if number < 0:
        return fault._replace(place=f"{Path(table['plan']).name}: {fault.place.removeprefix('structure.')}")
    return fault._replace(place=f"structure.{found[1]}[{number}]{fault.place[found.end() :]}")


def bonds(table: Keys) -> dict[str, Keys]:
    """Straight joints where walls meet, other stones of a random bond."""
    butt, regular = table.get("junction", "bonded") == "butt", table.get("bond", "regular") == "regular"
    met = {f"{'bonded' if butt else 'straight joints'} where walls meet": {"junction": "bonded" if butt else "butt"}}
    return met if regular else met | other_seed(table, of=" of the bond")


WALLS = [
    {"name": "south", "axis": [[0.0, 0.0], [6.0, 0.0]], "thickness": 0.5, "height": 3.0, "openings": [{"at": 3.0, "width": 1.0}]},
    {"name": "east", "axis": [[6.0, 0.0], [6.0, 5.0]], "thickness": 0.5, "height": 3.0},
    {"name": "north", "axis": [[6.0, 5.0], [0.0, 5.0]], "thickness": 0.5, "height": 3.0},
    {"name": "west", "axis": [[0.0, 5.0], [0.0, 0.0]], "thickness": 0.5, "height": 3.0},
]
KIND = StructureKind(
    build, BuildingTable, first={"walls": WALLS}, masonry="split stone", plan=plan_tables,
    resized=partial(scaled, BuildingTable, lengths=("block_length", "course_height")), bonds=bonds, parts=parts,
)  # fmt: skip
