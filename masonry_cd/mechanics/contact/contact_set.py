# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of a step, and how they come out of what is remembered of the pairs: in the world frame, those within the margin."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.motion import BodyMotion
from masonry_cd.mechanics.contact.pair_memory import PairMemory
from masonry_cd.mechanics.model.geometry import turned_normal


class ContactSet(NamedTuple):
    """C contacts. The normal points from the antagonist (second body) to the candidate (first body)."""

    bodies: np.ndarray  # (C, 2) candidate and antagonist block
    point: np.ndarray  # (C, 3) world frame [m]
    normal: np.ndarray  # (C, 3) unit
    gap: np.ndarray  # (C,) [m], negative when the blocks overlap
    area: np.ndarray  # (C,) share of the joint's area where its law is per area, else 0 [m2]
    pair: np.ndarray  # (C,) row of the detector's pair list
    previous: np.ndarray  # (C,) the same contact in the last set, -1 for a new one
    exchanged: np.ndarray  # (C,) bool: one of the points that its joint has got in place of others, whose slip they take over

    @classmethod
    def allocate(cls, count: int) -> ContactSet:
        """Room for a number of contacts, to be filled."""
        one, three, index = (count,), (count, 3), np.int64
        return cls(
            np.empty((count, 2), index), np.empty(three), np.empty(three), np.empty(one), np.empty(one), np.empty(one, index),
            np.empty(one, index), np.empty(one, np.bool_),
        )  # fmt: skip


@entry()
def write_contacts(memory: PairMemory, part_block: np.ndarray, motion: BodyMotion, rows: ContactSet) -> None:
    """Fill the rows of a set with the points within the margin, in the world frame, and note the row of each."""
    total = 0
    for k in range(memory.parts.shape[0]):
        if memory.point_count[k] == 0:
            continue
        a, b = part_block[memory.parts[k, 0]], part_block[memory.parts[k, 1]]
        r, x, scale = motion.rotation[a], motion.position[a], 1.0
        if len(motion.affine) == 2:
            nx, ny, nz, scale = turned_normal(motion.rotation, a, memory.normal[k])
        else:
            nx, ny, nz = _turned(r, memory.normal[k])
        for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
            if memory.gap[s] == np.inf:
                memory.place[s] = -1
                continue
            px, py, pz = _turned(r, memory.local[s])
            rows.point[total, 0], rows.point[total, 1], rows.point[total, 2] = x[0] + px, x[1] + py, x[2] + pz
            rows.normal[total, 0], rows.normal[total, 1], rows.normal[total, 2] = nx, ny, nz
            rows.bodies[total, 0], rows.bodies[total, 1] = b, a
            rows.gap[total], rows.area[total] = scale * memory.gap[s], memory.area[s]
            rows.pair[total], rows.previous[total], rows.exchanged[total] = k, memory.place[s], memory.exchanged[k]
            memory.place[s] = total
            total += 1


@borrower()
def _turned(r, v):
    """The vector r v, r (3, 3), as three numbers: no array is made."""
    return (
        r[0, 0] * v[0] + r[0, 1] * v[1] + r[0, 2] * v[2],
        r[1, 0] * v[0] + r[1, 1] * v[1] + r[1, 2] * v[2],
        r[2, 0] * v[0] + r[2, 1] * v[1] + r[2, 2] * v[2],
    )
