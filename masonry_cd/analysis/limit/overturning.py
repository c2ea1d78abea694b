# SPDX-License-Identifier: GPL-3.0-or-later
r"""Bodies that may overturn below a factor: starts of the search for the least factor that no other start leads to.

A body stands on a row of neighbouring blocks of one course and takes along all that rests on them. About the edge of the row to which it
is pushed it overturns, where no joint resists, at

    lambda = (t - x_G) / (z_G - z_t),      (t, z_t) the edge, (x_G, z_G) the centre of mass.

Friction adds to that and takes nothing off, so only bodies whose lambda is below the least factor known can lower it. Whether equilibrium
allows their joints to be relieved is for the descent to find: what rests on several blocks may be borne by any of them, and a search that
begins at normal forces keeps to those that it has begun with.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_cd.analysis.limit.part import Whole
from masonry_cd.analysis.limit.restrictions import SAME, lowest_toe, spin

UPRIGHT = 0.9  # component along a course of the normal of a joint between neighbours in it
MOST = 4  # bodies at which a search begins, a few cone programmes each
OWN = 0.5  # share of a body's blocks that are in none of those before it
CLOSES = 1e-6  # [m] closing of a point at one radian that counts as none


def overturning_below(whole: Whole, direction: np.ndarray, factor: float) -> list[np.ndarray]:
    """Velocities (B, 6) of all blocks, at one radian a second, as bodies overturn under a level push along a direction (3,) at less than
    a factor, the least first; no joint closes."""
    chosen: list[np.ndarray] = []
    bodies: list[np.ndarray] = []
    above = _resting_above(whole)
    for _, row in sorted(_rows_below(whole, above, direction, factor), key=lambda one: one[0]):
        body = np.asarray(above[row].any(axis=0))
        if any((body & ~other).sum() < OWN * body.sum() for other in bodies):
            continue
        moves = np.zeros((whole.assembly.count, 6))
        spin(whole, np.flatnonzero(body), lowest_toe(whole, np.array(row), direction), direction, 1.0, moves)
        if not _closes(whole, body, moves):
            chosen.append(moves)
            bodies.append(body)
        if len(chosen) == MOST:
            break
    return chosen


def _resting_above(whole: Whole) -> np.ndarray:
    """(B, B) which blocks rest on each one, directly or on what does, itself included."""
    lies = np.flatnonzero(whole.upper >= 0)
    upper, lower = whole.upper[lies], whole.lower[lies]
    out = np.eye(whole.assembly.count, dtype=bool)
    while True:
        before = out.sum()
        for one, other in zip(upper, lower, strict=True):
            out[other] |= out[one]
        if out.sum() == before:
            return out


def _rows_below(whole: Whole, above: np.ndarray, direction: np.ndarray, factor: float) -> Iterator[tuple[float, list[int]]]:
    """The factor and the blocks of each row that a body below a factor stands on."""
    assembly, neighbour = whole.assembly, _neighbours(whole, direction)
    along = assembly.centre @ direction
    edge = np.array([lowest_toe(whole, np.array([b]), direction) for b in range(assembly.count)])
    for first in np.flatnonzero(~assembly.fixed):
        row, body = [int(first)], above[first].copy()
        while True:
            mass = assembly.mass[body]
            high = float(mass @ assembly.centre[body, 2] / mass.sum()) - edge[first, 2]
            starts_at = (max(edge[row] @ direction) - float(mass @ along[body] / mass.sum())) / high if high > SAME else np.inf
            if 0.0 < starts_at < factor and not assembly.fixed[body].any():
                yield starts_at, list(row)
            if row[-1] not in neighbour:
                break
            row.append(neighbour[row[-1]])
            body |= above[row[-1]]


def _neighbours(whole: Whole, direction: np.ndarray) -> dict[int, int]:
    """The next block of the same course to the left of a push, for those that have one."""
    joints, left = whole.joints, np.array([-direction[1], direction[0], 0.0])
    low, fixed = whole.box[0][:, 2], whole.assembly.fixed
    out: dict[int, int] = {}
    for j in np.flatnonzero((whole.upper < 0) & (np.abs(joints.normal @ left) > UPRIGHT)):
        a, b = int(joints.block_a[j]), int(joints.block_b[j])
        if abs(low[a] - low[b]) <= SAME and not (fixed[a] or fixed[b]):
            one, other = (a, b) if float(joints.normal[j] @ left) > 0.0 else (b, a)
            out[one] = other
    return out


def _closes(whole: Whole, body: np.ndarray, moves: np.ndarray) -> bool:
    """True where a point between a body (B,) that moves (B, 6) and what is at rest closes."""
    points = whole.points
    goes = body[points.bodies]
    cut = np.flatnonzero(goes[:, 0] != goes[:, 1])
    block = np.where(goes[cut, 1], points.bodies[cut, 1], points.bodies[cut, 0])
    arm = points.point[cut] - whole.assembly.centre[block]
    moved = moves[block, :3] + np.cross(moves[block, 3:], arm)
    opening = np.sum(moved * points.frame[cut, 0], axis=1) * np.where(goes[cut, 1], 1.0, -1.0)
    return bool((opening < -CLOSES).any())
