# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids that a structure should fill, measured by the geometry kernel or by formulae, not by its blocks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from models import advance, stepper

import structures
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import loop_normal
from structures.courser import wall_plan


def build(kind: str, **keys: object) -> list[Block]:
    """A structure of 2000 kg/m3."""
    return structures.build({"kind": kind, **keys}, 2000.0, Path())


def holes_of(wall: wall_plan.PlanWall, sizes: wall_plan.Sizes) -> list[np.ndarray]:
    """The polygons s, z of the openings of a wall."""
    from masonry_cd.foundation.errors import Faults
    from structures.building import square_plan
    from structures.geometry import polygons

    faults = Faults()
    frames = square_plan.frames_of([wall], sizes, faults)
    assert not faults.found
    return [polygons.loop(frame.hole) + [wall.start, 0.0] for some in frames.values() for frame in some]


def outline(wall: wall_plan.PlanWall) -> list[tuple[float, float]]:
    """The polygon s, z of a wall without shoulders."""
    a, b = wall.start, wall.end
    peak = [(0.5 * (a + b), wall.top + wall.gable)] if wall.gable else []
    return [(a, wall.foot), (b, wall.foot), (b, wall.top), *peak, (a, wall.top)]


def volume_of_walls(walls: Sequence[wall_plan.PlanWall], sizes: wall_plan.Sizes) -> float:
    """Volume of the union of some walls, without their openings, by the geometry kernel [m3]."""
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        bodies, holes = [], []
        for wall in walls:
            bodies.append(_slab(occ, wall, outline(wall)))
            holes += [_slab(occ, wall, [tuple(p) for p in hole]) for hole in holes_of(wall, sizes)]
        if len(bodies) > 1:
            bodies = occ.fuse(bodies[:1], bodies[1:])[0]
        if holes:
            bodies = occ.cut(bodies, holes)[0]
        return float(sum(occ.getMass(*body) for body in bodies))


def _slab(occ, wall: wall_plan.PlanWall, polygon: Sequence[tuple[float, float]]) -> tuple[int, int]:
    """A polygon drawn out over the thickness of its wall."""
    thickness = wall.far - wall.near
    place = [(s, wall.near, z) if wall.axis == 0 else (wall.near, s, z) for s, z in polygon]
    points = [occ.addPoint(*p) for p in place]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    surface = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    along = (0.0, thickness, 0.0) if wall.axis == 0 else (thickness, 0.0, 0.0)
    return next(body for body in occ.extrude([(2, surface)], *along) if body[0] == 3)


def free_volume(blocks: Sequence[Block]) -> float:
    """Volume of the free blocks [m3]."""
    assembly = Assembly.from_blocks(blocks, 0.6)
    return float(assembly.volume[~assembly.fixed].sum())


def exposed(blocks: Sequence[Block], assembly: Assembly, joints: Joints) -> float:
    """Surface of the free blocks that is not a joint [m2]."""
    surface = 0.0
    for block in blocks:
        for face in () if block.fixed else block.faces:
            corners = block.vertices[list(face)] - block.vertices[face[0]]
            surface += 0.5 * np.linalg.norm(np.cross(corners[1:-1], corners[2:]).sum(axis=0))
    between_free = ~assembly.fixed[joints.block_a] & ~assembly.fixed[joints.block_b]
    return float(surface - joints.area.sum() - joints.area[between_free].sum())


def touching_area(blocks: Sequence[Block]) -> float:
    """Area over which faces of different blocks lie on each other, by clipping every pair: what the joints should add up to [m2]."""
    faces = [(k, part.vertices[list(face)]) for k, block in enumerate(blocks) for part in block.convex_parts for face in part.faces]
    owner, fixed = np.array([k for k, _ in faces]), np.array([blocks[k].fixed for k, _ in faces])
    normal = np.array([loop_normal(corners) for _, corners in faces])
    height = np.array([n @ corners[0] for n, (_, corners) in zip(normal, faces, strict=True)])
    low, high = (np.array([end(corners, axis=0) for _, corners in faces]) for end in (np.min, np.max))
    total = 0.0
    for i, (_, corners) in enumerate(faces):
        opposed = (normal[i + 1 :] @ normal[i] < -1.0 + 1e-12) & (np.abs(height[i + 1 :] + height[i]) < 1e-6)
        meet = (low[i + 1 :] <= high[i] + 1e-6).all(axis=1) & (high[i + 1 :] >= low[i] - 1e-6).all(axis=1)
        for j in i + 1 + np.flatnonzero(opposed & meet & (owner[i + 1 :] != owner[i]) & ~(fixed[i + 1 :] & fixed[i])):
            total += _common_area(corners, faces[j][1], normal[i])
    return total


def _common_area(first: np.ndarray, second: np.ndarray, normal: np.ndarray) -> float:
    """Area that two convex polygons (n, 3) in one plane share: the first, cut by the planes through the sides of the second [m2]."""
    inner = second.mean(axis=0)
    for a, b in zip(second, np.roll(second, -1, axis=0), strict=True):
        inward = np.cross(normal, b - a)
        depth = (first - a) @ (inward * np.sign((inner - a) @ inward))
        kept = []
        for p, q, f, g in zip(first, np.roll(first, -1, axis=0), depth, np.roll(depth, -1), strict=True):
            kept += [p] if f >= 0.0 else []
            kept += [p + f / (f - g) * (q - p)] if f * g < 0.0 else []
        if len(kept) < 3:
            return 0.0
        first = np.array(kept)
    spokes = first[1:] - first[0]
    return 0.5 * float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)))


def moved_at_rest(blocks: Sequence[Block], seconds: float = 0.1, dt: float = 2e-3, friction: float = 0.6) -> float:
    """Largest displacement of a corner of mass under gravity alone [m]."""
    steps = round(seconds / dt)
    run = stepper(list(blocks), steps, friction=friction, dt=dt, solver="auto", tolerance=1e-8)
    advance(run, steps)
    return float(np.linalg.norm(run.state.position - run.assembly.centre, axis=1).max())


def bonded_share(blocks: Sequence[Block], axis: int, at: float, near: float, far: float) -> float:
    """Share of the height of an upright plane, between two places across it, at which some block runs through it."""
    top, crossed = 0.0, 0.0
    for block in blocks:
        low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
        inside = low[1 - axis] > near - 1e-6 and high[1 - axis] < far + 1e-6
        if block.fixed or not inside or low[axis] > at + 1e-6 or high[axis] < at - 1e-6:
            continue
        top = max(top, high[2])
        if low[axis] < at - 1e-6 and high[axis] > at + 1e-6:
            crossed += high[2] - low[2]
    return crossed / top
