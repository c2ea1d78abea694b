# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairs of parts without contact, however near they come: of blocks that are not there, or that a link holds together, which stands in the
place of their joint."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly


class Apart(NamedTuple):
    """Parts and pairs of blocks that have no contact."""

    block: np.ndarray  # (P,) of each part
    absent: np.ndarray | None  # (P,) bool: parts of blocks that are not there
    linked: np.ndarray  # (L,) keys of pairs of blocks

    @classmethod
    def of(cls, assembly: Assembly) -> Apart:
        """Return the parts and pairs without contact of an assembly."""
        block = assembly.shapes.part_block
        linked = np.array([sorted(link.blocks) for link in assembly.links_there], dtype=np.int64).reshape(-1, 2) @ [assembly.count, 1]
        return cls(block, None if assembly.absent is None else assembly.absent[block], linked)

    def without(self, pairs: np.ndarray, count: int) -> np.ndarray:
        """Pairs of parts (P, 2) of a given number of blocks but those without contact."""
        if self.absent is not None:
            pairs = pairs[~self.absent[pairs].any(axis=1)]
        if len(self.linked):
            pairs = pairs[~np.isin(np.sort(self.block[pairs], axis=1) @ [count, 1], self.linked)]
        return pairs
