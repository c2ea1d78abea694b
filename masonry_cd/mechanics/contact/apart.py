# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairs of parts without contact, however near they come: of blocks that are not there, or that a link holds together, which stands in the
place of their joint; of the ground below footings, and of footings with one another and with supports."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly


class Apart(NamedTuple):
    """Parts and pairs of blocks that have no contact."""

    block: np.ndarray  # (P,) of each part
    absent: np.ndarray | None  # (P,) bool: parts of blocks that are not there
    linked: np.ndarray  # (L,) keys of pairs of blocks
    founded: np.ndarray | None = None  # (2, P) bool: parts of footings, of these and of supports; None: there are no footings

    @classmethod
    def of(cls, assembly: Assembly) -> Apart:
        """Return the parts and pairs without contact of an assembly."""
        block = assembly.shapes.part_block
        linked = np.array([sorted(link.blocks) for link in assembly.links_there], dtype=np.int64).reshape(-1, 2) @ [assembly.count, 1]
        absent, footings = assembly.absent, assembly.footings
        if footings is None:
            return cls(block, None if absent is None else absent[block], linked)
        own, bare = (np.isin(np.arange(assembly.count), of) for of in (footings.blocks[:, 0], footings.blocks[footings.bare, 1]))
        return cls(block, (bare if absent is None else bare | absent)[block], linked, np.stack([own, own | assembly.fixed])[:, block])

    def without(self, pairs: np.ndarray, count: int) -> np.ndarray:
        """Pairs of parts (P, 2) of a given number of blocks but those without contact."""
        if self.absent is not None:
            pairs = pairs[~self.absent[pairs].any(axis=1)]
        if self.founded is not None:
            pairs = pairs[~(self.founded[0][pairs].any(axis=1) & self.founded[1][pairs].all(axis=1))]
        if len(self.linked):
            pairs = pairs[~np.isin(np.sort(self.block[pairs], axis=1) @ [count, 1], self.linked)]
        return pairs
