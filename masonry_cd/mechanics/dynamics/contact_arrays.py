# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of a step as the kernels read them: those of the friction problem are all that were found, but half of them in a plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


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
    jacobian: np.ndarray  # (C, 2, m, n) H by contact and side
    offset: np.ndarray  # (C, m) b of rigid contacts [m/s]
    mu: np.ndarray  # (C,)
    start: np.ndarray  # (C, m) impulses of the last step [N s]

    @classmethod
    def allocate(cls, count: int, m: int, n: int) -> ContactRows:
        """Room for a number of contacts, to be filled."""
        one, pair, index = (count,), (count, 2), np.int64
        return cls(
            np.empty(one, index), np.empty(one), np.empty(one, index), np.empty(pair, index), np.empty(pair, index), np.empty(pair, index),
            np.empty(pair, index), np.empty((count, 3, 3)), np.empty((count, 2, m, n)), np.empty((count, m)), np.empty(one),
            np.empty((count, m)),
        )  # fmt: skip

    def first(self, count: int) -> ContactRows:
        """The first contacts."""
        return self if count == len(self.gap) else ContactRows(*[array[:count] for array in self])
