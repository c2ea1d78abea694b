# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of a step as the kernels read them: those of the friction problem are all that were found, but half of them in a plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.friction.contact_geometry import Geometry, axes_at
from masonry_cd.mechanics.linalg.triples import in_axes, plus, scaled


class Velocities(NamedTuple):
    """How the blocks move: F free blocks with n unknowns, S support motions."""

    free: np.ndarray  # (F, n) [m/s, rad/s]
    support: np.ndarray  # (S, 3) [m/s]


class ContactRows(NamedTuple):
    """The contacts of the friction problem, with m rows each, on blocks of n unknowns."""

    active: np.ndarray  # (C,) places among the contacts found
    gap: np.ndarray  # (C,) at q_m [m]
    pair: np.ndarray  # (C,) which pair of parts a contact belongs to
    blocks: np.ndarray  # (C, 2) candidate and antagonist
    groups: np.ndarray  # (C, 2) of these blocks
    bodies: np.ndarray  # (C, 2) their places among the free blocks; -1: a support
    supports: np.ndarray  # (C, 2) their prescribed motion; -1: a free block
    frame: np.ndarray  # (C, 3, 3) rows n, t1, t2
    arm: np.ndarray  # (C, 2, 3) of the contact from the centres of the blocks, zero on supports [m]
    jacobian: np.ndarray  # (C, 2, m, n) H by contact and side; (0, 2, m, n) of rigid blocks in space
    offset: np.ndarray  # (C, m) b of rigid contacts [m/s]
    mu: np.ndarray  # (C,)
    start: np.ndarray  # (C, m) impulses of the last step [N s]

    @classmethod
    def allocate(cls, count: int, m: int, n: int) -> ContactRows:
        """Room for a number of contacts, to be filled."""
        one, pair, index, rows = (count,), (count, 2), np.int64, 0 if (m, n) == (3, 6) else count
        return cls(
            np.empty(one, index), np.empty(one), np.empty(one, index), np.empty(pair, index), np.empty(pair, index), np.empty(pair, index),
            np.empty(pair, index), np.empty((count, 3, 3)), np.empty((count, 2, 3)), np.empty((rows, 2, m, n)), np.empty((count, m)),
            np.empty(one), np.empty((count, m)),
        )  # fmt: skip

    def first(self, count: int) -> ContactRows:
        """The first contacts."""
        return self if count == len(self.gap) else ContactRows(*[array[:count] for array in self])

    @property
    def geometry(self) -> Geometry:
        """Where the contacts lie: by frames and arms, or by the rows of H."""
        return Geometry.by_rows(self.jacobian) if len(self.jacobian) else Geometry(self.frame, self.arm, self.jacobian)


@borrower()
def support_velocity(rows, c, velocity):
    """What supports with velocities (S, 3) move along the axes of contact c of ContactRows: three numbers."""
    u = (0.0, 0.0, 0.0)
    for side in range(2):
        s = rows.supports[c, side]
        if s >= 0:
            move = velocity[s, 0], velocity[s, 1], velocity[s, 2]
            u = plus(u, scaled(1.0 - 2.0 * side, in_axes(axes_at(rows, c), move)))
    return u
