# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of a step as the kernels read them: those of the friction problem are all that were found, but half of them in a plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.friction.contact_geometry import IN_SPACE, Geometry, axes_at
from masonry_cd.mechanics.linalg.triples import cross, in_axes, plus, scaled


class Velocities(NamedTuple):
    """How the blocks move: F free blocks with n unknowns, S support motions."""

    free: np.ndarray  # (F, n) [m/s, rad/s]
    support: np.ndarray  # (S, 3) [m/s], or (S, 6) with [rad/s] where supports turn


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
    geometry: Geometry  # where the contacts lie: by frames and arms, or where blocks deform by the rows of H
    offset: np.ndarray  # (C, m) b of rigid contacts [m/s]
    mu: np.ndarray  # (C,)
    start: np.ndarray  # (C, m) impulses of the last step [N s]
    support_arm: np.ndarray  # (C, 2, 3) from the centres of supports that turn, else zero [m]; (0, 2, 3) where none turns

    @classmethod
    def allocate(cls, active: np.ndarray, m: int, n: int, turning: bool) -> ContactRows:
        """Room for the contacts at these places (C,), to be filled; ``turning``: supports turn."""
        count = len(active)
        one, pair, index, frame = (count,), (count, 2), np.int64, np.empty((count, 3, 3))
        if n > 3 * (m - 1):  # blocks deform
            geometry = Geometry.by_rows(np.empty((count, 2, m, n)))
        else:
            geometry = Geometry.by_arms(frame if m == IN_SPACE else np.empty((count, m, m)), np.empty((count, 2, m)))
        return cls(
            active, np.empty(one), np.empty(one, index), np.empty(pair, index), np.empty(pair, index), np.empty(pair, index),
            np.empty(pair, index), frame, geometry, np.empty((count, m)), np.empty(one), np.empty((count, m)),
            np.zeros((count if turning else 0, 2, 3)),
        )  # fmt: skip

    def of(self, contacts: np.ndarray) -> ContactRows:
        """Some contacts, by a mask (C,)."""
        chosen = {name: each[contacts] for name, each in self._asdict().items() if name not in ("geometry", "support_arm")}
        arms = self.support_arm[contacts] if len(self.support_arm) else self.support_arm
        return ContactRows(geometry=self.geometry.of(contacts), support_arm=arms, **chosen)


@borrower()
def support_velocity(rows, c, velocity):
    """Relative velocity that supports with velocities (S, 3 or 6) give contact c of ContactRows, along its axes: three numbers."""
    u = (0.0, 0.0, 0.0)
    for side in range(2):
        s = rows.supports[c, side]
        if s >= 0:
            move = velocity[s, 0], velocity[s, 1], velocity[s, 2]
            if len(rows.support_arm):
                arm = rows.support_arm[c, side, 0], rows.support_arm[c, side, 1], rows.support_arm[c, side, 2]
                move = plus(move, cross((velocity[s, 3], velocity[s, 4], velocity[s, 5]), arm))
            u = plus(u, scaled(1.0 - 2.0 * side, in_axes(axes_at(rows, c), move)))
    return u
