# SPDX-License-Identifier: GPL-3.0-or-later
"""Supports that stand on ground: footings on springs, and below each a support that moves as the loads prescribe for it.

A support becomes a free block, the footing, and a slab of its plan below its base takes its place, NAME.soil; loads that name the support
move that slab. The slab of a tower, wall, church or column, on which what topples comes to lie, is not a footing: one is cut out of it
below what stands on it, and the slab goes down by its own depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from loads.supports import bearing, select
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import pressure
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.footings import Footings
from masonry_cd.mechanics.model.ground_table import GroundTable
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.polygon import polygon_area, polygon_centroid

SLAB = "ground"  # name of a kind's own one, or part of the name of its pieces
DEPTH = 0.25  # of the slabs below other footings, which meet nothing and are only seen, over the shorter side of the plan
ON = 1e-6  # of the size of a support: nearer to its top than this stands on it, nearer to its lowest corner is its base
NAME = "{}.soil"


class Footing(NamedTuple):
    """A support and what becomes of it."""

    number: int  # of the support
    own: Block
    below: Block
    bare: bool  # the slab below meets nothing
    middle: np.ndarray  # (3,) of its base [m]
    stiffness: np.ndarray  # (6, 6)
    damping: np.ndarray  # (6, 6)
    line: str
    bed: JointLaw | None = None  # on which it may lift off; None: it stands on springs and dashpots


def footings_of(tables: Sequence[GroundTable], assembly: Assembly) -> list[Footing]:
    """The supports of an assembly that stand on the ground of a scene.

    Raises:
        InputError: names that fit no support, a support named twice, one out of which no footing can be cut, or sides that do not fit.
    """
    made, owner = list[Footing](), np.full(assembly.count, -1)
    for i, table in enumerate(tables):
        where = f"ground[{i}].supports"
        chosen = assembly.fixed & (bearing(assembly) if table.supports is None else select(table.supports, assembly, where))
        if not chosen.any():
            raise InputError(where, "names no fixed block: footings are made of supports")
        twice = np.flatnonzero(chosen & (owner >= 0))
        if len(twice):
            raise InputError(where, f'"{assembly.names[twice[0]]}" stands on ground[{owner[twice[0]]}] already')
        owner[chosen] = i
        made += [_footing(table, assembly, b, f"ground[{i}]") for b in np.flatnonzero(chosen).tolist()]
    return made


def founded_blocks(blocks: Sequence[Block], made: Sequence[Footing]) -> list[Block]:
    """Blocks of which supports have become footings, then the slabs below these."""
    out = list(blocks)
    for one in made:
        out[one.number] = one.own
    return [*out, *(one.below for one in made)]


def on_beds(material: Material, made: Sequence[Footing]) -> Material:
    """A material with the laws of the beds on which footings may lift off.

    Raises:
        InputError: masonry that gives bond or strength to all joints, these among them.
    """
    beds = {f"{one.own.group}-{one.below.group}": one.bed for one in made if one.bed is not None}
    if not beds:
        return material
    if material.masonry is not None and (material.masonry.cohesion or material.masonry.crushing):
        raise InputError(
            "ground.uplift", "a bed has no bond: masonry.shear_bond and masonry.crushing give all joints theirs, joints.* a pair"
        )
    return material.model_copy(update={"joints": {**material.joints, **beds}})


def founded(assembly: Assembly, made: Sequence[Footing]) -> Assembly:
    """An assembly of founded blocks with the springs of its footings.

    Raises:
        InputError: a footing that would deform.
    """
    springs = np.array([one.bed is None for one in made])
    below = np.arange(assembly.count - len(made), assembly.count)[springs]
    made = [one for one in made if one.bed is None]
    if not made:
        return assembly
    numbers = np.array([one.number for one in made])
    blocks = np.stack([numbers, below], axis=1)
    soft = np.zeros(0) if assembly.deformation is None else np.intersect1d(numbers, assembly.deformation.block)
    if len(soft):
        group = assembly.groups[int(assembly.group_of[soft[0]])]
        raise InputError("material.deformable", f'footings are rigid; deformable.{group} = "rigid" says so')
    middles = np.array([one.middle for one in made])
    stiffness, damping = (np.array([getattr(one, name) for one in made]) for name in ("stiffness", "damping"))
    bare = np.array([one.bare for one in made])
    return replace(assembly, footings=Footings(blocks, middles[:, None] - assembly.centre[blocks], stiffness, damping, bare))


def _footing(table: GroundTable, assembly: Assembly, number: int, where: str) -> Footing:
    """One support as a footing."""
    from structures.geometry.polygons import plan_of

    block = assembly.blocks[number]
    is_slab = SLAB in block.name.split(".")
    cut = _cut(block, assembly, table.projection or 0.0, where) if is_slab or table.projection is not None else block
    low = float(cut.vertices[:, 2].min())
    base = cut.vertices[cut.vertices[:, 2] <= low + ON * float(np.ptp(block.vertices, axis=0).max())]
    plan = plan_of(base if len(base) > 2 else cut.vertices)
    sides, along = _rectangle(plan)
    try:
        stiffness, damping = table.of_footing(sides, along)
    except ValueError as fault:
        raise InputError(f"{where}.length", f'footing "{block.name}": {fault}') from None
    name = NAME.format(block.name)
    if is_slab:
        depth = float(np.ptp(block.vertices[:, 2]))
        below = replace(block, name=name, vertices=block.vertices - [0.0, 0.0, depth])
    else:
        below = _prism(block, name, plan, low - DEPTH * sides[1], low)
    mass = cut.density * cut.mass_properties.volume
    own = replace(cut, fixed=False, density=cut.density * (1.0 + table.added_mass / mass))
    middle, line, bed = np.array([*polygon_centroid(plan), low]), _line(block.name, sides, mass + table.added_mass, stiffness), None
    if table.uplift:
        area = abs(polygon_area(plan))
        bed = JointLaw(
            normal_stiffness=float(stiffness[2, 2]) / area,
            tangential_stiffness=float(stiffness[0, 0]) / area,
            compressive_strength=table.bearing_strength,
        )
        below = replace(below, group=name)
        line = _bed_line(block.name, sides, bed)
    return Footing(number, own, below, not is_slab, middle, stiffness, damping, line, bed)


def _cut(block: Block, assembly: Assembly, projection: float, where: str) -> Block:
    """The part of a support below what stands on it, and a projection around that [m].

    Raises:
        InputError: nothing stands on it.
    """
    import shapely

    top, size = float(block.vertices[:, 2].max()), float(np.ptp(block.vertices, axis=0).max())
    free = [one.vertices for one in assembly.blocks if not one.fixed]
    feet = [points[np.abs(points[:, 2] - top) <= ON * size][:, :2] for points in free]
    areas = [shapely.MultiPoint(points).convex_hull for points in feet if len(points) > 2]
    own = shapely.MultiPoint(block.vertices[:, :2]).convex_hull
    stands = shapely.union_all([area.intersection(own) for area in areas]).convex_hull
    if not stands.area > 0.0:
        raise InputError(f"{where}.supports", f'nothing stands on the level top of "{block.name}", out of which a footing would be cut')
    grown = stands.buffer(projection, join_style="mitre").intersection(own) if projection else stands
    ring = shapely.geometry.polygon.orient(grown).exterior.simplify(ON * size).coords
    return _prism(block, block.name, np.array(ring)[:-1, :2], float(block.vertices[:, 2].min()), top)


def _prism(like: Block, name: str, plan: np.ndarray, low: float, high: float) -> Block:
    """A fixed block upright on a plan (n, 2) between two heights [m]."""
    from structures.geometry.prism import between

    ends = [np.column_stack([plan, np.full(len(plan), height)]) for height in (low, high)]
    return Block(name, *between(*ends), like.density, like.group, fixed=True, structure=like.structure)


def _rectangle(plan: np.ndarray) -> tuple[tuple[float, float], np.ndarray]:
    """Sides [m] of the rectangle with the area and the ratio of the second moments of a plan (n, 2), and (2,) along the longer one."""
    area, own = polygon_area(plan), plan - polygon_centroid(plan)
    after = np.roll(own, -1, axis=0)
    weight = (own[:, 0] * after[:, 1] - own[:, 1] * after[:, 0]) / 24.0
    xx, yy, xy = (
        float(np.sum(weight * (p * q + r * s + (p + r) * (q + s))))
        for p, q, r, s in (
            (own[:, 0], own[:, 0], after[:, 0], after[:, 0]),
            (own[:, 1], own[:, 1], after[:, 1], after[:, 1]),
            (own[:, 0], own[:, 1], after[:, 0], after[:, 1]),
        )
    )
    values, vectors = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
    ratio = float(np.sqrt(values[1] / values[0]))
    return (float(np.sqrt(area * ratio)), float(np.sqrt(area / ratio))), vectors[:, 1]


def _bed_line(name: str, sides: tuple[float, float], bed: JointLaw) -> str:
    """Return the line on a footing that may lift off."""
    normal, tangential = (1e-6 * value for value in bed.stiffness)
    strength = f", yields at {pressure(bed.compressive_strength)}" if bed.compressive_strength else ""
    return (
        f'ground: footing "{name}", {sides[0]:.4g} m by {sides[1]:.4g} m, on a bed of {normal:.4g} MN/m3 down and {tangential:.4g} '
        f"MN/m3 along, which does not pull{strength}"
    )


def _line(name: str, sides: tuple[float, float], mass: float, stiffness: np.ndarray) -> str:
    """Return the line on a footing."""
    x, y, z, rx, ry, rz = np.diagonal(stiffness).tolist()
    return (
        f'ground: footing "{name}", {sides[0]:.4g} m by {sides[1]:.4g} m, {1e-3 * mass:.4g} t, on springs of '
        f"{1e-6 * x:.4g}, {1e-6 * y:.4g} and {1e-6 * z:.4g} MN/m along x, y and z, "
        f"{1e-6 * rx:.4g}, {1e-6 * ry:.4g} and {1e-6 * rz:.4g} MN m about them"
    )
