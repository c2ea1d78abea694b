# SPDX-License-Identifier: GPL-3.0-or-later
r"""Linked blocks: what hangs together by links is one body of the friction problem, with the velocities that the links leave it.

Links are equations c(q) = 0 with rows G at q_m, see linkage.py, and no matter which contacts press,

    M v+ = M v_free + G^T l + H^T p,        c(q_m (+) h v+) = 0,

so l can be eliminated before the contacts are solved. With M^-1 = C C^T, block by block, and the factors (G C)^T = Q1 R of the rows that
are independent (pivoted QR), W = C Q1 R^-T and T = C Q2 give

    v+ = v_c + T y,        v_c = v_free - W G v_free  (Newton, until c(q_m (+) h v_c) = 0),        y = (H T)^T p,

where y are the unknowns of a body of unit mass, whose contacts have the rows H T and the free velocity H v_c: a friction problem like any
other, for any solver. That is SHAKE (Ryckaert, Ciccotti & Berendsen, J. Comput. Phys. 23, 1977) with contacts: the chord between two q_m
lies on the links, and not the tangent at one of them, so that a pendulum neither gains energy nor loses any. What contacts change after v_c
leaves c of second order in h; the next step takes that away by moving blocks, W c, as overlaps are.

Contacts whose normal velocity the links hold alone are left out: no impulse would change it.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

from masonry_cd.mechanics.dynamics.driving import turned_on
from masonry_cd.mechanics.dynamics.free_motion import Prediction, drift
from masonry_cd.mechanics.dynamics.linkage import Linkage
from masonry_cd.mechanics.dynamics.linked_bodies import Cluster, Linked, in_space, of_supports, speeds
from masonry_cd.mechanics.dynamics.system import MotionState, System
from masonry_cd.mechanics.linalg.small_blocks import room_for
from masonry_cd.mechanics.solvers.condensed import UNIFORM

DEPENDENT = 1e-8  # share of a row of unit length that may be left of it where others say the same
ITERATIONS, CLOSED = 12, 1e-12  # of Newton's method for v_c, and share of the size of the largest block by which links are then torn


def link(system: System, linkage: Linkage, last: MotionState, free: Prediction) -> Prediction:
    """A prediction whose linked blocks move as their links let them."""
    position, orientation = free.state.position[linkage.used], free.state.orientation[linkage.used]
    value, rows = linkage.rows(position, orientation)
    half = np.linalg.cholesky(free.inverse_mass)
    clusters, root = _factorised(system, linkage, rows, half)
    shift = _pushed(system, linkage, clusters, -value)
    drift(position, orientation, shift, 1.0)
    v = _on_the_links(system, linkage, clusters, rows, (position, orientation), free)
    momentum = turned_on(system, free, v, linkage.used[linkage.moved])
    _, gained = system.speeds(v - last.v)
    made = Linked(linkage, clusters, rows, free.v_free, free.inverse_mass, root, half, shift)
    pull = max(free.pull, float(gained.max()) / system.constants.step)
    return free._replace(v_free=v, angular_momentum=momentum, pull=pull, linked=made)


def _factorised(system: System, linkage: Linkage, rows: np.ndarray, half: np.ndarray) -> tuple[tuple[Cluster, ...], np.ndarray]:
    """The clusters at q_m by the rows (L, 6, 2, 6) of the links and C (F, n, n) of the free blocks, and T of all free blocks."""
    columns, n = system.blocks.columns, half.shape[1]
    made, free = [], system.blocks.free_index[linkage.used]  # -1: a support
    bases: list[np.ndarray] = []
    for members, held in linkage.clusters:
        own, link, row = free[members], held // 6, held % 6
        g = np.zeros((len(held), len(members), n))
        for side in (0, 1):
            place = np.searchsorted(members, linkage.ends[link, side])
            on = free[linkage.ends[link, side]] >= 0
            g[on, place[on]] += rows[link[on], row[on], side][:, columns]
        felt = np.sqrt(np.sum(rows[link, row] ** 2, axis=(1, 2)))
        g[np.sqrt(np.sum(g * g, axis=(1, 2))) <= DEPENDENT * felt] = 0.0  # those across the plane of a scene that moves in it
        turned = np.einsum("rkn,knm->rkm", g, half[own]).reshape(len(held), -1)
        size = np.sqrt(np.sum(turned * turned, axis=1))
        scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
        q, r, order = qr((scale[:, None] * turned).T, pivoting=True)
        rank = int((np.abs(np.diagonal(r)) > DEPENDENT).sum())
        push = np.linalg.solve(r[:rank, :rank], q[:, :rank].T).T
        kept = order[:rank]
        made.append(Cluster(own, held[kept], scale[kept], _by_half(half[own], push), q.shape[0] - rank))
        bases.append(_by_half(half[own], q[:, rank:]))
    widest = max(n, *(cluster.unknowns for cluster in made))
    root = np.zeros((len(half), n, max(room_for(widest), room_for(UNIFORM[system.rows] + 1))))  # so that each is condensed
    root[:, :, :n] = half
    for cluster, basis in zip(made, bases, strict=True):
        root[cluster.free] = 0.0
        root[cluster.free, :, : cluster.unknowns] = basis.reshape(len(cluster.free), n, -1)
    return tuple(made), root


def _by_half(half: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """C times columns (k n, r), C (k, n, n) block by block."""
    return np.matmul(half, columns.reshape(*half.shape[:2], -1)).reshape(columns.shape)


def _pushed(system: System, linkage: Linkage, clusters: tuple[Cluster, ...], wanted: np.ndarray) -> np.ndarray:
    """The least velocities of the blocks with links (U, 6) by which the rows of the links have wanted ones (L, 6)."""
    v = np.zeros((len(system.reach), len(system.blocks.columns)))
    _push(v, clusters, wanted)
    return in_space(system, linkage, v, np.zeros((len(system.free), 6)))


def _push(v: np.ndarray, clusters: tuple[Cluster, ...], wanted: np.ndarray) -> float:
    """Add to velocities (F, n) of the free blocks what gives the rows wanted velocities (L, 6) more; return the largest of these."""
    largest = 0.0
    for c in clusters:
        more = wanted.reshape(-1)[c.rows]
        v[c.free] += (c.push @ (c.scale * more)).reshape(len(c.free), -1)
        largest = max(largest, float(np.abs(more).max(initial=0.0)))
    return largest


def _on_the_links(
    system: System, linkage: Linkage, clusters: tuple[Cluster, ...], rows: np.ndarray, at: tuple[np.ndarray, np.ndarray], free: Prediction
) -> np.ndarray:
    """v_c (F, n): the free velocities, changed least, that leave the blocks on their links after a step from positions and orientations."""
    h, v, support = system.constants.step, free.v_free.copy(), of_supports(system, free.loads.support_after)
    _push(v, clusters, -speeds(linkage, rows, in_space(system, linkage, v, support)))
    for _ in range(ITERATIONS):
        position, orientation = at[0].copy(), at[1].copy()
        drift(position, orientation, in_space(system, linkage, v, support), h)
        if h * _push(v, clusters, -linkage.rows(position, orientation)[0] / h) <= CLOSED * float(system.reach.max()):
            break
    return v
