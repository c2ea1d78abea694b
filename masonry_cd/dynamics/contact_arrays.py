"""The contacts of a step as the kernels read them.

"Found" are the K contacts that the detector lists, "rows" the C contacts of the friction problem: all of them, but half in a plane.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.contact.detector import ContactSet


class Velocities(NamedTuple):
    """How the blocks move: F free blocks with n unknowns, S support motions."""

    free: np.ndarray  # (F, n) [m/s, rad/s]
    support: np.ndarray  # (S, 3) [m/s]


class FoundArrays(NamedTuple):
    """The arrays of a ContactSet."""

    blocks: np.ndarray  # (K, 2) candidate and antagonist
    point: np.ndarray  # (K, 3) world frame [m]
    normal: np.ndarray  # (K, 3) from the antagonist to the candidate
    gap: np.ndarray  # (K,) [m]
    area: np.ndarray  # (K,) share of the joint's area where its law goes by area, else 0 [m2]
    pair: np.ndarray  # (K,) row of the detector's list of pairs
    previous: np.ndarray  # (K,) place of the contact in the last set; -1: a new one

    @classmethod
    def of(cls, found: ContactSet) -> FoundArrays:
        """Those of a set."""
        return cls(found.bodies, found.point, found.normal, found.gap, found.area, found.pair, found.previous)


class ContactRows(NamedTuple):
    """The contacts of the friction problem, with m rows each, on blocks of n unknowns."""

    active: np.ndarray  # (C,) places among the contacts found
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
    def room(cls, count: int, m: int, n: int) -> ContactRows:
        """Arrays to be filled."""
        index, pair = np.int64, (count, 2)
        return cls(
            np.empty(count, index), np.empty(pair, index), np.empty(pair, index), np.empty(pair, index), np.empty(pair, index),
            np.empty((count, 3, 3)), np.empty((count, 2, m, n)), np.empty((count, m)), np.empty(count), np.empty((count, m)),
        )  # fmt: skip

    def first(self, count: int) -> ContactRows:
        """The first contacts."""
        return ContactRows(*(array[:count] for array in self))
