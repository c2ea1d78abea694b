# SPDX-License-Identifier: GPL-3.0-or-later
"""The clear room between walls at the height of a floor: the largest rectangle about a point that no block reaches into.

Blocks count by the boxes about their convex parts. They are taken from the nearest outwards, so that the walls of the room bound it before
those of its neighbours are looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.blocks import Block

NAMES = ("west", "east", "south", "north")  # x points east and y north
AT = 1e-6  # [m]: faces closer to an edge than this bound it


@dataclass(frozen=True, eq=False)
class Boxes:
    """The boxes about P convex parts in plan, and the block of each."""

    low: np.ndarray  # (P, 2) [m]
    high: np.ndarray  # (P, 2) [m]
    owner: np.ndarray  # (P,)

    @classmethod
    def between(cls, blocks: Sequence[Block], bottom: float, top: float) -> Boxes:
        """Of the free blocks between two heights [m]."""
        low, high, owner = [], [], []
        for i, block in enumerate(blocks):
            for part in () if block.fixed else block.convex_parts:
                least, most = part.vertices.min(axis=0), part.vertices.max(axis=0)
                if least[2] < top - AT and most[2] > bottom + AT:
                    low.append(least[:2])
                    high.append(most[:2])
                    owner.append(i)
        return cls(np.reshape(low, (-1, 2)), np.reshape(high, (-1, 2)), np.array(owner, dtype=int))

    def around(self, point: np.ndarray) -> np.ndarray:
        """(P,) which of them a point (2,) lies in."""
        return np.asarray(((self.low < point - AT) & (point + AT < self.high)).all(axis=1))


@dataclass(frozen=True, eq=False)
class Side:
    """A side of a room."""

    number: int  # 0 west, 1 east, 2 south, 3 north
    place: float  # of its wall's face, along its axis [m]
    far: float  # of the other face of that wall [m]; its own where there is none
    owners: frozenset[int]  # blocks that bound it; none where it is open

    @property
    def axis(self) -> int:
        """Across which it lies."""
        return self.number // 2

    @property
    def sign(self) -> int:
        """1 where the room lies on its lower side."""
        return 1 if self.number % 2 else -1

    @property
    def name(self) -> str:
        """By the compass."""
        return NAMES[self.number]

    @property
    def depth(self) -> float:
        """Of its wall [m]."""
        return abs(self.far - self.place)


def room(boxes: Boxes, point: np.ndarray, extent: np.ndarray) -> list[Side]:
    """The sides of the room about a point.

    Args:
        boxes: of what stands at its height; none of them is around the point.
        point: (2,) [m].
        extent: (2, 2) lowest and highest x and y beyond which it does not reach [m].
    """
    edges = extent.copy()  # [low, high] of each axis
    beyond = np.maximum(boxes.low - point, point - boxes.high)  # (P, 2) how far each lies from the point along each axis
    for p in np.argsort(beyond.max(axis=1), kind="stable"):
        if (boxes.low[p] < edges[1] - AT).all() and (boxes.high[p] > edges[0] + AT).all():
            axis = int(beyond[p].argmax())
            if boxes.low[p, axis] > point[axis]:
                edges[1, axis] = boxes.low[p, axis]
            else:
                edges[0, axis] = boxes.high[p, axis]
    return [_side(boxes, edges, number) for number in range(4)]


def _side(boxes: Boxes, edges: np.ndarray, number: int) -> Side:
    """A side of the rectangle between two corners (2, 2) [m]."""
    axis, upper = divmod(number, 2)
    other = 1 - axis
    near, far = (boxes.low, boxes.high) if upper else (boxes.high, boxes.low)
    place = float(edges[upper, axis])
    along = (boxes.low[:, other] < edges[1, other] - AT) & (boxes.high[:, other] > edges[0, other] + AT)
    bounding = np.flatnonzero(along & (np.abs(near[:, axis] - place) <= AT))
    reach = far[bounding, axis]
    end = place if not len(bounding) else float(reach.max() if upper else reach.min())
    return Side(number, place, end, frozenset(boxes.owner[bounding].tolist()))
