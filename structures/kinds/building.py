"""Buildings from a plan: walls by their middle lines, of any direction, with their junctions, openings, vaults, columns and arcades.

A plan is typed as tables of the scene, or read from a JSON or DXF file (``plan``). Walls that meet, at a corner, against a side or across
each other, are interlocked course by course; every corner is filled. How: :mod:`structures.building`.

Groups are the names of walls, vaults, columns and arcades, unless they say another, and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures.building.table import BuildingTable as BuildingTable  # which structures.tables finds here
from structures.geometry.checks import check
from structures.layout import wall_plan


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a building on its base.

    Raises:
        InputError: a key that is wrong, or all that is wrong with the plan, a line each.
    """
    from structures.building import engine

    keys = table_of(table, folder)
    blocks = engine.blocks_of(keys, density)
    blocks.append(wall_plan.ground(blocks, keys.base_depth or 2.0 * keys.course_height, density))
    check(blocks)
    return blocks


def table_of(table: Mapping[str, Any], folder: Path) -> BuildingTable:
    """The keys of a [structure] table, with those of its plan where it names one; lists of both follow on each other.

    Raises:
        InputError: a key that is wrong, or a plan that cannot be read.
    """
    keys = parse_table(BuildingTable, table, "structure")
    if keys.plan is None:
        return keys
    from structures.plans import read

    own = {key: value for key, value in table.items() if key != "plan"}
    rest = read(folder / keys.plan, own)
    lists = {key: [*rest[key], *own[key]] for key in own if isinstance(own[key], (list, tuple)) and key in rest}
    return parse_table(BuildingTable, {**rest, **own, **lists}, "structure")
