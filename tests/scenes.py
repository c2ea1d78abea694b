# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems of simple scenes, from analytic contacts, for the tests of the solvers."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem

GRAVITY = 9.81


def box_inverse_mass(size: np.ndarray, density: float) -> np.ndarray:
    """M^-1 (6, 6) of a box of edge lengths size (3,) [m]."""
    mass = density * float(np.prod(size))
    inertia = mass / 12.0 * (np.sum(size**2) - size**2)
    return np.diag(np.concatenate([np.full(3, 1.0 / mass), 1.0 / inertia]))


def assemble(
    centres: np.ndarray,
    inverse_mass: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    bodies: np.ndarray,
    mu: float | np.ndarray,
    v_free: np.ndarray,
    gap: np.ndarray | None = None,
    step: float = 1e-3,
) -> FrictionProblem:
    """A spatial problem from contact points (C, 3) with normals (C, 3) from the antagonist to the candidate body."""
    n = normals
    helper = np.where(np.abs(n[:, [0]]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    t1 = np.cross(helper, n)
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    frame = np.stack([n, t1, np.cross(n, t1)], axis=1)  # (C, 3 rows, 3)
    arm = np.where(bodies[:, :, None] >= 0, points[:, None] - centres[bodies], 0.0)
    offset = np.zeros((len(n), 3))
    if gap is not None:
        offset[:, 0] = np.maximum(gap, 0.0) / step
    friction = np.broadcast_to(mu, (len(n),)).astype(float).copy()
    return FrictionProblem(inverse_mass, v_free, bodies, Geometry.by_arms(frame, arm), offset, friction, np.zeros_like(offset))


def in_plane(problem: FrictionProblem) -> FrictionProblem:
    """A planar problem between the same bodies: contacts of a pair that follow one another have equal axes, all else is random."""
    random, pair = np.random.default_rng(3), np.cumsum(np.append(False, (problem.bodies[1:] != problem.bodies[:-1]).any(axis=1)))
    angle = random.uniform(0.0, 2.0 * np.pi, pair[-1] + 1)[pair]
    frame = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], axis=1).reshape(-1, 2, 2)
    point, centre = random.normal(size=(problem.contacts, 1, 2)), random.normal(size=(len(problem.v_free), 2))
    apart = np.where(problem.bodies[:, :, None] >= 0, point - centre[problem.bodies], 0.0)
    arm = np.stack([-apart[..., 1], apart[..., 0]], axis=2)
    root, v_free = random.normal(size=(len(problem.v_free), 3, 3)) + 3.0 * np.eye(3), random.normal(size=(len(problem.v_free), 3))
    return replace(
        problem, inverse_mass=root @ root.transpose(0, 2, 1), v_free=v_free, geometry=Geometry.by_arms(frame, arm),
        offset=problem.offset[:, :2], compliance=problem.compliance[:, :2],
    )  # fmt: skip


def _corners(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The four corners of an axis-parallel rectangle (one of the three extents is zero)."""
    flat = int(np.argmin(high - low))
    a, b = (i for i in range(3) if i != flat)
    out = np.repeat(low[None], 4, axis=0)
    out[1, a] = out[2, a] = high[a]
    out[2, b] = out[3, b] = high[b]
    return out


def boxes(low: np.ndarray, high: np.ndarray, mu: float = 0.6, density: float | np.ndarray = 2000.0, step: float = 1e-3) -> FrictionProblem:
    """Axis-parallel boxes on the ground z = 0, free to fall for one step: every touching pair of faces has its corners.

    Args:
        low, high: (B, 3) opposite corners of the boxes [m].
    """
    count = len(low)
    centres, size = 0.5 * (low + high), high - low
    near = 1e-9 * size.max()
    points, normals, bodies = [], [], []
    for b in np.flatnonzero(low[:, 2] < near):
        points.append(_corners(low[b], np.array([high[b, 0], high[b, 1], low[b, 2]])))
        normals.append([0.0, 0.0, 1.0])
        bodies.append((b, -1))
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        by_top: dict[int, list[int]] = {}
        for b in range(count):
            by_top.setdefault(round(high[b, axis] / near / 10), []).append(b)
        for upper in range(count):
            for lower in by_top.get(round(low[upper, axis] / near / 10), []):
                a, b = np.maximum(low[upper], low[lower]), np.minimum(high[upper], high[lower])
                if (b[others] - a[others] > near).all():
                    a[axis] = b[axis] = low[upper, axis]
                    points.append(_corners(a, b))
                    normals.append(np.eye(3)[axis])
                    bodies.append((upper, lower))
    densities = np.broadcast_to(density, (count,))
    inverse_mass = np.array([box_inverse_mass(s, d) for s, d in zip(size, densities, strict=True)])
    v_free = np.zeros((count, 6))
    v_free[:, 2] = -GRAVITY * step
    four = np.ones(4, dtype=np.int64)
    return assemble(
        centres,
        inverse_mass,
        np.concatenate(points),
        np.kron(np.array(normals), four[:, None]),
        np.kron(np.array(bodies), four[:, None]),
        mu,
        v_free,
    )


def softened(problem: FrictionProblem, softness: float, every: int = 2, by_joint: bool = False) -> FrictionProblem:
    """Every n-th contact or joint becomes elastic, n = ``every``: C_n = softness trace(W_cc) / m, and twice that along the tangents."""
    own = np.trace(problem.delassus_diagonal(), axis1=1, axis2=2) / problem.dimension
    compliance = np.outer(softness * own, [1.0, 2.0, 2.0][: problem.dimension])
    count = np.arange(problem.contacts)
    if by_joint:
        count = np.cumsum(np.any(np.diff(problem.bodies, axis=0, prepend=problem.bodies[:1]), axis=1))
    compliance[count % every > 0] = 0.0
    return replace(problem, compliance=compliance)


def tower(blocks: int, **kwargs: float) -> FrictionProblem:
    """Boxes of 1 x 1 x 0.5 m one on the other."""
    low = np.zeros((blocks, 3))
    low[:, 2] = 0.5 * np.arange(blocks)
    return boxes(low, low + [1.0, 1.0, 0.5], **kwargs)


def apart() -> FrictionProblem:
    """A box that touches nothing."""
    one = tower(1)
    return one.subset(np.zeros(one.contacts, dtype=np.bool_))


def wall(columns: int, courses: int, **kwargs: float) -> FrictionProblem:
    """A wall in running bond of blocks 1 x 0.5 x 0.5 m, every second course with two half blocks at its ends."""
    low, high = [], []
    for course in range(courses):
        edges = np.arange(columns + 1.0)
        if course % 2:
            edges = np.concatenate([[0.0], np.arange(columns) + 0.5, [float(columns)]])
        for a, b in pairwise(edges):
            low.append([a, 0.0, 0.5 * course])
            high.append([b, 0.5, 0.5 * course + 0.5])
    return boxes(np.array(low), np.array(high), **kwargs)


def thrown(speed: float) -> FrictionProblem:
    """A wall whose supports have suddenly taken on a horizontal velocity [m/s]."""
    problem = wall(4, 6)
    offset = problem.offset.copy()
    ground = problem.bodies[:, 1] < 0
    offset[ground] -= speed * problem.geometry.frame[ground, :, 0]
    return replace(problem, offset=offset)


def off_centre(problem: FrictionProblem) -> FrictionProblem:
    """A spatial problem whose blocks have coordinates that are not those of their centres of mass."""
    shift = np.eye(6)
    shift[:3, 3:] = [[0.0, 0.2, -0.3], [-0.2, 0.0, 0.1], [0.3, -0.1, 0.0]]
    return replace(problem, inverse_mass=shift @ problem.inverse_mass @ shift.T)


def packing(cells: int, mu: float, speed: float, seed: int = 0, radius: float = 0.05, step: float = 1e-3) -> FrictionProblem:
    """Spheres in a box, on the places of a face-centred cubic lattice, ``cells`` of them along each side, some of them missing.

    They fall for a step, and move at random: ``speed`` [m/s], and as much at their surface.
    """
    random, edge = np.random.default_rng(seed), 2.0 * np.sqrt(2.0) * radius
    corners = np.stack(np.meshgrid(*3 * [np.arange(cells)], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    places = corners + np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]])
    centres = places.reshape(-1, 3) * edge + radius
    centres = centres[random.random(len(centres)) < 0.85]
    count, near = len(centres), 1e-6 * radius
    apart = centres[:, None] - centres[None]
    first, second = np.nonzero(np.triu(np.linalg.norm(apart, axis=-1) < 2.0 * radius + near, k=1))
    normals, bodies = [apart[first, second] / (2.0 * radius)], [np.stack([first, second], axis=1)]
    points = [centres[second] + radius * normals[0]]
    for axis, sign in ((2, 1.0), (0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)):  # ground and walls
        inwards = sign * np.eye(3)[axis]
        on = np.flatnonzero(sign * centres[:, axis] < (sign * centres[:, axis]).min() + near)
        points.append(centres[on] - radius * inwards)
        normals.append(np.tile(inwards, (len(on), 1)))
        bodies.append(np.stack([on, np.full(len(on), -1)], axis=1))
    mass = 2500.0 * 4.0 / 3.0 * np.pi * radius**3
    inverse_mass = np.tile(np.diag(np.repeat([1.0 / mass, 2.5 / (mass * radius**2)], 3)), (count, 1, 1))
    v_free = speed * random.normal(size=(count, 6)) / np.repeat([1.0, radius], 3)
    v_free[:, 2] -= GRAVITY * step
    return assemble(centres, inverse_mass, np.concatenate(points), np.concatenate(normals), np.concatenate(bodies), mu, v_free)
