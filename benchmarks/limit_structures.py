# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures whose load factors :mod:`benchmarks.limit` compares: one of each kind, and two that are put together from pieces of kinds.

The corner of two walls is half the plan of a tower, bonded or with a straight joint; pushed along x, its wall along y leans outwards and
away from the other. The cross vault on piers is that of the kind, whose four fixed supports give way to piers of free blocks on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import structures
from masonry_cd.mechanics.model.blocks import Block
from structures.building import square_plan
from structures.courser import wall_plan
from structures.geometry.prism import box
from structures.layout.ground import ground

DENSITY = 2000.0
SIDE, HIGH, THICK, COURSE = 2.4, 2.0, 0.4, 0.25  # of the corner: both walls, outer [m]
PIER, DRUMS = 2.0, 4  # height of the piers of the cross vault [m], and blocks to each


def church(length: float) -> dict[str, Any]:
    """A church with aisles and a tower, of blocks of a length; 2.6 m makes 710."""
    table = {"kind": "church", "block_length": length, "course_height": 0.5 * length, "aisles": True, "length": 26.0, "height": 11.0}
    return table | {"thickness": 1.1, "windows": 3, "tower_height": 22.0}


TABLES: dict[str, dict[str, Any]] = {
    "arch": {"kind": "arch", "span": 4.0, "thickness": 0.6, "width": 1.0, "voussoirs": 21},
    "aqueduct": {"kind": "aqueduct", "spans": 2, "clear_span": 4.0, "pier_width": 1.6, "ring_thickness": 0.5, "width": 2.0},
    "wall": {"kind": "wall", "length": 3.0, "height": 2.0, "thickness": 0.4, "course_height": 0.25},
    "column": {"kind": "column", "height": 5.0, "diameter": 0.9, "drums": 6, "sides": 8},
    "tower": {"kind": "tower", "side": 3.0, "height": 9.0, "thickness": 0.6, "course_height": 0.75, "belfry_width": 0.0, "door_width": 0.0},
    "barrel vault": {"kind": "vault", "form": "barrel", "span": 4.0, "thickness": 0.5, "voussoirs": 13, "length": 2.0, "unit_length": 1.0},
    "cross vault": {"kind": "vault", "form": "cross", "span": 4.0, "thickness": 0.5, "voussoirs": 9},
    "dome": {"kind": "dome", "span": 5.0, "thickness": 0.6, "sides": 8, "rows": 5, "oculus": 1.0},
    "church": {"kind": "church", "block_length": 3.0, "course_height": 1.25},
    "large church": church(2.6),
}


def of_table(table: dict[str, Any]) -> list[Block]:
    """The blocks of a [structure] table."""
    return structures.build(table, DENSITY, Path())


def corner(bonded: bool = True) -> list[Block]:
    """Two walls that meet at the origin, one along x and one along y, on the ground."""
    walls = [
        wall_plan.PlanWall("along", "along", 0, -SIDE, 0.0, -THICK, 0.0, 0.0, HIGH),
        wall_plan.PlanWall("across", "across", 1, -SIDE, 0.0, -THICK, 0.0, 0.0, HIGH),
    ]
    sizes = wall_plan.Sizes(COURSE, 2.0 * COURSE)
    blocks = square_plan.build(walls, square_plan.beds_of(walls, sizes), sizes, DENSITY, bonded)
    return [*blocks, ground(blocks, COURSE, DENSITY)]


def cross_vault_on_piers() -> list[Block]:
    """The cross vault with piers of free blocks instead of its supports, on the ground."""
    blocks = []
    for block in of_table(TABLES["cross vault"] | {"ground": False}):
        if not block.fixed:
            blocks.append(block)
            continue
        low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
        beds = np.linspace(-PIER, 0.0, DRUMS + 1)
        for k in range(DRUMS):
            drum = box((low[0], low[1], beds[k]), (high[0], high[1], beds[k + 1]))
            blocks.append(Block(f"{block.name}.{k + 1}", *drum, DENSITY, block.name))
    return [*blocks, ground(blocks, 0.5, DENSITY)]


MADE: dict[str, Callable[[], list[Block]]] = {
    "corner": corner,
    "corner, straight joint": partial(corner, bonded=False),
    "cross vault on piers": cross_vault_on_piers,
}
NAMES = (*TABLES, *MADE)
USUAL = tuple(name for name in NAMES if name != "large church")  # which takes as long as all others


def made(name: str) -> list[Block]:
    """The blocks of a structure by its name."""
    return MADE[name]() if name in MADE else of_table(TABLES[name])
