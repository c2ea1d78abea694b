# SPDX-License-Identifier: GPL-3.0-or-later
"""Packings: spheres of given sizes in a box or a cylinder, laid loosely one above another, to be poured by gravity.

The container stands on a fixed floor at z = 0, about the origin, and is open at the top: four walls, or a ring of plates, are fixed blocks.
Without walls the spheres fall on the floor as a heap. A ring that a settlement lifts (``supports = "walls"``, ``direction = "z"``) leaves a
heap, too. The spheres do not touch at first (:mod:`structures.layout.loose_grains`): the run lets them fall.

The default is some 570 spheres of 0.1 m in a box of 1 m by 1 m. Groups: ``spheres``, or one for each diameter, ``spheres.1``,
``spheres.2`` ..., ``walls`` and ``base``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.geometry.prism import between, box
from structures.kind import StructureKind, other_seed
from structures.layout.ground import ground
from structures.layout.loose_grains import ContainerPlan, count_for, loose, numbers_of
from structures.schema import Length, Share, Table, Thickness, WallHeight

MOST_PLACES = 1e6  # in a layer of the loose spheres, and of small ones in the cell of a large one: some ten megabytes


class PackingTable(Table):
    """The [structure] table of a packing."""

    diameters: tuple[Length, ...] = Field((0.1,), strict=False, min_length=1, max_length=20)
    """of the spheres"""
    shares: tuple[Share, ...] | None = Field(None, strict=False)
    """of each diameter, in any unit; by default equal ones"""
    share_of: Literal["number", "volume"] = "number"
    """quantity of the shares"""
    count: int | None = Field(None, ge=1)
    """number of spheres; or fill"""
    fill: Length = 0.5
    """height that they fill when they have settled, at a solid fraction of 0.6; or count"""
    form: Literal["box", "cylinder"] = "box"
    """of the container"""
    length: Length = 1.0
    """clear, of a box along x"""
    width: Length = 1.0
    """clear, of a box along y"""
    diameter: Length = 1.0
    """clear, of a cylinder"""
    walls: bool = True
    """false leaves them out: the spheres fall on the floor as a heap"""
    height: WallHeight | None = None
    """of the walls; by default as high as the loose spheres reach"""
    wall_thickness: Thickness | None = None
    """by default the largest diameter of the spheres"""
    sides: int = Field(24, ge=6, le=128)
    """plates of a cylinder"""
    seed: int = Field(0, ge=0)
    """of where the spheres lie; equal seeds give equal places"""
    base_depth: Length | None = None
    """of the floor; by default the thickness of the walls"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a packing.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    keys = parse_table(PackingTable, table, "structure")
    _check(keys)
    round_plan = keys.form == "cylinder"
    plan = ContainerPlan(keys.diameter, keys.diameter, True) if round_plan else ContainerPlan(keys.length, keys.width)
    for k, diameter in enumerate(keys.diameters):
        if diameter > plan.clear:
            inner = "the diameter of the cylinder over the root of two" if round_plan else "the smaller measure of the box"
            raise InputError(f"structure.diameters[{k}]", f"must be at most {inner}, {plan.clear:.4g} m, got {diameter:g}")
    shares = keys.shares or (1.0,) * len(keys.diameters)
    by_volume = keys.share_of == "volume"
    wanted = keys.count or count_for(keys.fill, plan, keys.diameters, shares, by_volume)
    size.check_size(wanted, "fill" if keys.count is None else "count")
    numbers = numbers_of(max(1, round(wanted)), keys.diameters, shares, by_volume)
    for k, number in enumerate(numbers):
        if number == 0:
            raise InputError(f"structure.shares[{k}]", f"leaves no sphere of {keys.diameters[k]:g} m among {sum(numbers)}; make it larger")
    _refuse_wide(plan, keys.diameters)
    grains = loose(plan, keys.diameters, numbers, keys.seed)
    names = ["spheres"] if len(numbers) == 1 else [f"spheres.{k + 1}" for k in range(len(numbers))]
    spheres = [
        Block.sphere(f"s{i + 1}", centre, 0.5 * keys.diameters[k], density, names[k])
        for i, (centre, k) in enumerate(zip(grains.centre, grains.size.tolist(), strict=True))
    ]
    top = max(block.vertices[0, 2] + block.radius for block in spheres)
    thick, high = keys.wall_thickness or max(keys.diameters), keys.height or float(top)
    walls = [] if not keys.walls else _ring(keys, thick, high, density) if round_plan else _box(keys, thick, high, density)
    blocks = [*walls, *spheres]
    blocks.append(ground(blocks, keys.base_depth or thick, density))
    return blocks


def _refuse_wide(plan: ContainerPlan, diameters: tuple[float, ...]) -> None:
    """Refuse spheres that are dust against their container, or with the largest of them: a layer or cell would have too many places."""
    largest = max(diameters)
    if plan.length / largest * (plan.width / largest) > MOST_PLACES:
        raise InputError(
            "structure.diameters",
            f"a layer of the container, {plan.length:g} m by {plan.width:g} m, would hold more than "
            f"{MOST_PLACES:.0e} spheres of {largest:g} m; take larger ones, or a smaller container",
        )
    for k, diameter in enumerate(diameters):
        if (largest / diameter) ** 3 > MOST_PLACES:
            raise InputError(
                f"structure.diameters[{k}]", f"must be at least {largest / MOST_PLACES ** (1 / 3):.2g} m, as the largest is {largest:g} m"
            )


def _check(keys: PackingTable) -> None:
    """Refuse keys that say nothing, or two things."""
    given = keys.model_fields_set
    if "count" in given and "fill" in given:
        raise InputError("structure.count", "either count or fill, not both")
    if keys.shares is not None and len(keys.shares) != len(keys.diameters):
        raise InputError("structure.shares", f"must have one for each of the {len(keys.diameters)} diameters, got {len(keys.shares)}")
    box_keys, round_keys = ("length", "width"), ("diameter", "sides")
    for key in round_keys if keys.form == "box" else box_keys:
        if key in given:
            other = "cylinder" if keys.form == "box" else "box"
            raise InputError(f"structure.{key}", f'belongs to form = "{other}", and the form is "{keys.form}"')
    for key in ("height", "wall_thickness", "sides"):
        if key in given and not keys.walls:
            raise InputError(f"structure.{key}", "belongs to walls, and walls = false leaves them out")


def _box(keys: PackingTable, thick: float, high: float, density: float) -> list[Block]:
    """Four walls: those across x reach over the ends of those across y."""
    x, y = 0.5 * keys.length, 0.5 * keys.width
    made = {
        "x0": ((-x - thick, -y - thick), (-x, y + thick)),
        "x1": ((x, -y - thick), (x + thick, y + thick)),
        "y0": ((-x, -y - thick), (x, -y)),
        "y1": ((-x, y), (x, y + thick)),
    }
    return [Block(f"wall.{name}", *box((*low, 0.0), (*up, high)), density, "walls", fixed=True) for name, (low, up) in made.items()]


def _ring(keys: PackingTable, thick: float, high: float, density: float) -> list[Block]:
    """Plates round a circle, which each of them touches."""
    turns = [2.0 * math.pi * k / keys.sides for k in range(keys.sides + 1)]
    corner = np.array([[math.cos(turn), math.sin(turn), 0.0] for turn in turns]) / math.cos(math.pi / keys.sides)
    inner, outer = 0.5 * keys.diameter * corner, (0.5 * keys.diameter + thick) * corner
    up = np.array([0.0, 0.0, high])
    foot = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(keys.sides)]
    return [Block(f"wall.{k + 1}", *between(plan, plan + up), density, "walls", fixed=True) for k, plan in enumerate(foot)]


KIND = StructureKind(build, PackingTable, first={"diameters": [0.1, 0.06], "fill": 0.3}, bonds=other_seed)
