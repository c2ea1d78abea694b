# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones by wall, and the openings of a wall, read from the names and places of blocks.

Walls in plan name their stones ``WALL.COURSE.NUMBER``, and those around an opening ``WALL.oOPENING.PIECE`` (see structures/layout).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block

SAME = 1e-6  # lengths closer than this are one [m]
OF_OPENING = re.compile(r"o(\d+)$")


@dataclass(frozen=True)
class Hole:
    """An opening in a wall [m]."""

    start: float  # along the wall
    end: float
    sill: float
    head: float  # where its arch springs, or its lintel lies


@dataclass(frozen=True, eq=False)
class BlockLayout:
    """The B blocks of a structure by name, place and group."""

    wall: np.ndarray  # (B,) first part of the name
    piece: np.ndarray  # (B,) second part of the name, empty without one
    group: np.ndarray  # (B,)
    fixed: np.ndarray  # (B,)
    low: np.ndarray  # (B, 3) [m]
    high: np.ndarray  # (B, 3) [m]
    blocks: Sequence[Block]

    @classmethod
    def of(cls, blocks: Sequence[Block]) -> BlockLayout:
        """Layout of blocks."""
        parts = [(*block.name.split("."), "")[:2] for block in blocks]
        low = np.array([block.vertices.min(axis=0) for block in blocks])
        high = np.array([block.vertices.max(axis=0) for block in blocks])
        wall, piece = (np.array([part[k] for part in parts], dtype=object) for k in (0, 1))
        group = np.array([block.group for block in blocks], dtype=object)
        return cls(wall, piece, group, np.array([block.fixed for block in blocks]), low, high, blocks)

    def turned(self, along: np.ndarray) -> BlockLayout:
        """Seen with a unit vector (2,) of the plan as x, so that a wall along it lies as one along x does."""
        turn = np.array([along, [-along[1], along[0]]])
        plans = [block.vertices[:, :2] @ turn.T for block in self.blocks]
        low, high = (
            np.column_stack([[end(plan, axis=0) for plan in plans], z[:, 2]]) for end, z in ((np.min, self.low), (np.max, self.high))
        )
        return replace(self, low=low, high=high)

    @property
    def middle(self) -> np.ndarray:
        """Middle of the boxes around the blocks, (B, 3) [m]."""
        return 0.5 * (self.low + self.high)

    @property
    def names(self) -> list[str]:
        """The groups of the free blocks, in their order."""
        return list(dict.fromkeys(str(name) for name in self.group[~self.fixed]))

    def of_walls(self, *names: str) -> np.ndarray:
        """Numbers of the free blocks of walls."""
        return np.flatnonzero(np.isin(self.wall, names) & ~self.fixed)

    def of_groups(self, *names: str) -> np.ndarray:
        """Numbers of the free blocks of groups."""
        return np.flatnonzero(np.isin(self.group, names) & ~self.fixed)

    def above(self, blocks: np.ndarray, height: float) -> np.ndarray:
        """Those of some blocks that stand on or above a height."""
        return blocks[self.low[blocks, 2] >= height - SAME]

    def foot(self, blocks: np.ndarray) -> float:
        """Lowest point of some blocks [m]."""
        return float(self.low[blocks, 2].min())

    def top(self, blocks: np.ndarray) -> float:
        """Highest point of some blocks [m]."""
        return float(self.high[blocks, 2].max())

    def axis(self, blocks: np.ndarray) -> int:
        """Along which a wall runs: 0 or 1."""
        size = self.high[blocks, :2].max(axis=0) - self.low[blocks, :2].min(axis=0)
        return int(size[1] > size[0])

    def holes(self, wall: str) -> list[Hole]:
        """The openings of a wall, from its start on."""
        own = self.of_walls(wall)
        if not len(own):
            return []
        axis, found = self.axis(own), []
        plain = own[[not OF_OPENING.match(self.piece[b]) for b in own]]
        for piece in dict.fromkeys(self.piece[b] for b in own if OF_OPENING.match(self.piece[b])):
            around = own[self.piece[own] == piece]
            head, middle = self.foot(around), float(np.mean(self.middle[around, axis]))
            under = plain[
                (self.low[plain, axis] < middle + SAME) & (self.high[plain, axis] > middle - SAME) & (self.high[plain, 2] <= head + SAME)
            ]
            sill = self.top(under) if len(under) else self.foot(own)
            adjacent = plain[(self.low[plain, 2] < head - SAME) & (self.high[plain, 2] > sill + SAME)]
            left = self.high[adjacent, axis][self.high[adjacent, axis] <= middle]
            right = self.low[adjacent, axis][self.low[adjacent, axis] >= middle]
            ends = self.low[around, axis].min(), self.high[around, axis].max()
            start, end = (float(left.max()) if len(left) else float(ends[0])), (float(right.min()) if len(right) else float(ends[1]))
            found.append(Hole(start, end, sill, head))
        return sorted(found, key=lambda hole: (hole.start, hole.sill))
