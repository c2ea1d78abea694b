# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks joined by links as one body of the friction problem, see ``linking.py``: velocities, contacts, forces and work."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.linkage import Linkage
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.condensation import identities
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem

HELD = 1e-10  # share of the square of a contact's row that is left where links hold it


class Cluster(NamedTuple):
    """Blocks that hang together, k of them with n unknowns each."""

    free: np.ndarray  # (k,) places among the free blocks
    rows: np.ndarray  # (r,) the independent ones among 6 L
    scale: np.ndarray  # (r,) that makes each of unit length in the norm of M^-1
    push: np.ndarray  # (k n, r) W
    unknowns: int  # columns of T


class Linked(NamedTuple):
    """Links of a step, with the clusters of blocks that they hold together."""

    linkage: Linkage
    clusters: tuple[Cluster, ...]
    rows: np.ndarray  # (L, 6, 2, 6) G
    unlinked: np.ndarray  # (F, n) velocities without links and contacts
    inverse_mass: np.ndarray  # (F, n, n)
    root: np.ndarray  # (F, n, w) T of each free block, those of the largest body first and zeros after
    half: np.ndarray  # (F, n, n) C
    shift: np.ndarray  # (U, 6) that takes away what is left of c at q_m [m, rad]

    def velocity(self, own: np.ndarray) -> np.ndarray:
        """T y of the free blocks (F, n), for unknowns (B, w)."""
        return np.asarray(np.matmul(self.root, own[self.linkage.body][:, :, None])[:, :, 0])

    def impulse(self, velocity: np.ndarray) -> np.ndarray:
        """M v (F, n) of velocities."""
        return np.linalg.solve(self.inverse_mass, velocity[:, :, None])[:, :, 0]

    def multipliers(self, impulse: np.ndarray) -> np.ndarray:
        """l of all rows (L, 6), by what the links gave the free blocks, (F, n) [N s, N m s]."""
        out = np.zeros(self.rows.shape[:2])
        for c in self.clusters:
            out.reshape(-1)[c.rows] = c.scale * (impulse[c.free].ravel() @ c.push)
        return out

    def wrenches(self, multipliers: np.ndarray) -> np.ndarray:
        """Impulse and its moment about the centres on both blocks of each link, (L, 2, 6), of l (L, 6)."""
        return np.einsum("lr,lrsk->lsk", multipliers, self.rows)

    def contacts(self, rows: ContactRows) -> tuple[np.ndarray, LinkedContacts]:
        """Which contacts are left, (C,) bool, and these as linked bodies feel them."""
        own, body = rows.geometry.rows(rows.bodies), self.linkage.body
        jacobian, whole = np.matmul(own, self.root[rows.bodies]), np.matmul(own[:, :, :1], self.half[rows.bodies])
        moves = np.zeros(self.linkage.bodies, dtype=np.bool_)
        moves[body[self.root.any(axis=(1, 2))]] = True
        bodies = np.where(rows.bodies >= 0, body[rows.bodies], -1)
        bodies[(bodies >= 0) & ~moves[bodies]] = -1  # links hold it to supports
        same = (bodies[:, 0] == bodies[:, 1]) & (bodies[:, 0] >= 0)
        jacobian[same, 0] += jacobian[same, 1]
        bodies[same, 1] = -1
        jacobian[bodies < 0] = 0.0
        left = np.sum(jacobian[:, :, 0] ** 2, axis=(1, 2)) > HELD * np.sum(whole**2, axis=(1, 2, 3))
        return left, LinkedContacts(bodies[left], Geometry.by_rows(np.ascontiguousarray(jacobian[left])))

    def problem(self, contacts: LinkedContacts, problem: FrictionProblem) -> FrictionProblem:
        """The friction problem of the free blocks as one of linked bodies."""
        count, width = self.linkage.bodies, self.root.shape[2]
        return replace(
            problem, inverse_mass=identities(count, width), v_free=np.zeros((count, width)), bodies=contacts.bodies,
            geometry=contacts.geometry, offset=problem.free_relative_velocity(),
        )  # fmt: skip

    def work(self, system: System, impulse: np.ndarray, mean: np.ndarray, support: np.ndarray) -> tuple[float, float]:
        """Return the work that supports did through links, and the energy lost in the links [J].

        Impulse of the links on the free blocks (F, n), velocities of these in the mean of the step (F, n), and of the supports (S, 3 or 6).
        """
        moved = in_space(system, self.linkage, np.zeros_like(mean), of_supports(system, support))
        base = -float(np.sum(self.multipliers(impulse) * speeds(self.linkage, self.rows, moved)))
        return base, base - float(np.sum(impulse * mean))


class LinkedContacts(NamedTuple):
    """Contacts as linked bodies feel them."""

    bodies: np.ndarray  # (C, 2)
    geometry: Geometry  # by rows H T


def of_supports(system: System, velocity: np.ndarray) -> np.ndarray:
    """Velocities (B, 6) of the supports, zero of free blocks, of those (S, 3 or 6) of their motions."""
    out, fixed = np.zeros((len(system.free), 6)), ~system.free
    out[fixed, : velocity.shape[1]] = velocity[system.assembly.support_of[fixed]]
    return out


def in_space(system: System, linkage: Linkage, v: np.ndarray, support: np.ndarray) -> np.ndarray:
    """Velocities (U, 6) of the blocks with links, of velocities (F, n) of the free blocks and those (B, 6) of supports."""
    out = support[linkage.used]
    out[linkage.moved[:, None], system.blocks.columns] = v[linkage.free]
    return out


def speeds(linkage: Linkage, rows: np.ndarray, v: np.ndarray) -> np.ndarray:
    """G v (L, 6) of velocities (U, 6)."""
    return np.asarray(np.einsum("lrsk,lsk->lr", rows, v[linkage.ends]))
