# SPDX-License-Identifier: GPL-3.0-or-later
"""Which joint each pair of parts of the detector belongs to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.contact.find_joints import joint_parts
from masonry_cd.mechanics.model.blocks import Assembly


class PairJoints:
    """The joints of pairs, found again when the list of pairs is another; numbered as built, whichever blocks are there or held now."""

    def __init__(self, assembly: Assembly) -> None:
        built = replace(assembly, absent=None, fixed=np.array([block.fixed for block in assembly.blocks]))
        self._joint_of = {(a, b): j for j, (a, b) in enumerate(joint_parts(built).tolist())}
        self._pairs: np.ndarray | None = None
        self._joint = np.empty(0, dtype=np.int64)

    def of(self, pairs: np.ndarray) -> np.ndarray:
        """The joint of each pair (P, 2), -1 for pairs that are none; the same array as long as ``pairs`` is."""
        if pairs is not self._pairs:
            self._joint = np.array([self._joint_of.get((a, b), -1) for a, b in pairs.tolist()], dtype=np.int64)
            self._pairs = pairs
        return self._joint
