# SPDX-License-Identifier: GPL-3.0-or-later
"""Buildings from a plan: walls by their middle lines, of any direction, with their junctions, openings, vaults, columns and arcades.

A plan is typed as tables of the scene, or read from a JSON or DXF file (``plan``). Walls that meet, at a corner, against a side or across
each other, are interlocked course by course; every corner is filled. How: :mod:`structures.building`.

Groups are the names of walls, vaults, columns and arcades, unless they say another, and ``base``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import Fault, Faults, InputError, parse_table
from structures import MadeStructure
from structures.building.elements import parts
from structures.building.meetings import meetings_of
from structures.building.table import BuildingTable
from structures.kind import DrawnPlan, Keys, StructureKind, other_seed, scaled
from structures.layout.ground import ground
from structures.plans import FilePlan, open_plan
from structures.plans.keys import PlanKeys
from structures.plans.outlines import outline_of
from structures.plans.places import drawn_about
from structures.plans.storeys import stacked

IN_A_LIST = re.compile(r"(?:structure\.|(.*): )(\w+)\[(\d+)\]")  # place of an entry of a list, with the file of the plan that has it


def build(table: Mapping[str, Any], density: float, folder: Path) -> MadeStructure:
    """Build a building on its base; the notes say what of its plan was assumed, and what was not understood.

    Raises:
        InputError: a key that is wrong, or all that is wrong with the plan, a line each.
    """
    from structures.building import engine

    keys, plan = _opened(table, folder)
    Faults([*dict.fromkeys(plan.faults.values())]).refuse()
    try:
        with drawn_about(plan.origin):
            blocks, bars, apart = engine.blocks_of(keys, density)
    except InputError as error:
        raise error.each(lambda fault: _in_plan(fault, plan)) from None
    blocks.append(ground(blocks, keys.base_depth or 2.0 * keys.course_height, density))
    return MadeStructure(blocks, [*plan.notes, *apart], bars, (), plan.floors)


def plan_of(table: Mapping[str, Any], folder: Path, faults: Sequence[Fault] = ()) -> DrawnPlan:
    """All that scene and plan say of a building, as far as it is understood.

    Args:
        table: own keys of [structure].
        folder: of the scene.
        faults: for which the building is refused, whose places are in the tables of the scene or of the plan.

    Raises:
        InputError: a key that is wrong, or a plan that cannot be read.
    """
    keys, plan = _opened(table, folder)
    tables = keys.model_dump(mode="json", exclude_unset=True, exclude={"plan", "storeys", *PlanKeys.model_fields})
    met = meetings_of(keys, plan.origin)
    walls = [outline_of(wall, met.reach.get(wall["name"], (0.0, 0.0))) for wall in tables.get("walls", ())]
    files = [file for file, _ in plan.entries.get("walls", ())]
    numbers = [[*dict.fromkeys(files)].index(file) for file in files] + [0] * (len(walls) - len(files))
    walls = [wall._replace(storey=number) for wall, number in zip(walls, numbers, strict=True) if not wall.ground.is_empty]
    wrong = {name for fault in faults if (name := _named(fault, tables, plan))}
    return DrawnPlan(tables, walls, plan.left, met.found, frozenset(wrong | set(plan.faults)))


def _named(fault: Fault, tables: Mapping[str, Any], plan: FilePlan) -> str:
    """The name of what a fault speaks of, by its place; empty where it is not an entry of a list."""
    found = IN_A_LIST.match(fault.place)
    if found is None:
        return ""
    own, before, number = tables.get(found[2], ()), plan.entries.get(found[2], []), int(found[3])
    number = number + len(before) if not found[1] else before.index((found[1], number)) if (found[1], number) in before else len(own)
    return str(own[number].get("name") or f"{found[2].removesuffix('s')}{number + 1}") if number < len(own) else ""


def _opened(table: Mapping[str, Any], folder: Path) -> tuple[BuildingTable, FilePlan]:
    """The keys of a table and its plan, whose lists come before those of the table; an empty one where it names none.

    Raises:
        InputError: keys of the table that are wrong, or else keys of the plan that are wrong.
    """
    keys = parse_table(BuildingTable, table, "structure")
    if keys.plan is None and not keys.storeys:
        return keys, FilePlan.of("", {})
    if keys.plan is not None and keys.storeys:
        raise InputError("structure.storeys", "give one plan, or a drawing for each storey")
    own = {key: value for key, value in table.items() if key != "plan"}
    plan = stacked(keys.storeys, folder, own) if keys.plan is None else open_plan(folder / keys.plan, own)
    lists = {key: [*plan.tables[key], *own[key]] for key in own if isinstance(own[key], (list, tuple)) and key in plan.tables}
    try:
        return parse_table(BuildingTable, {**plan.tables, **own, **lists}, "structure"), plan
    except InputError as error:
        raise error.each(lambda fault: _in_plan(fault, plan)) from None


def _in_plan(fault: Fault, plan: FilePlan) -> Fault:
    """A fault of an entry of a list, which lies in the file of the plan, or else is counted as in the scene."""
    found = IN_A_LIST.match(fault.place)
    if found is None or found[2] not in plan.entries:
        return fault
    before, number, rest = plan.entries[found[2]], int(found[3]), fault.place[found.end() :]
    if number < len(before):
        file, own = before[number]
        return fault._replace(place=f"{file}: {found[2]}[{own}]{rest}")
    return fault._replace(place=f"structure.{found[2]}[{number - len(before)}]{rest}")


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
    build, BuildingTable, first={"walls": WALLS}, masonry="split stone", plan=plan_of,
    resized=partial(scaled, BuildingTable, lengths=("block_length", "course_height")), bonds=bonds, parts=parts,
)  # fmt: skip
