# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls along x and y: what kinds of structure with keys of their own draw of a plan, the beds that all of its walls share, and the ground.

The engine of buildings makes the blocks (:mod:`structures.building.square_plan`). Where the footprints of two walls overlap, at a corner,
a junction or a crossing, the courses take turns: in even ones the wall along x runs through and the wall along y stops against it, in odd
ones the other way round. So the walls are interlocked without a cut stone, and no upright joint runs from bottom to top. Unbonded walls
leave every such place to one of the two, a straight joint: a real and dangerous condition, so it must be asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import box
from structures.layout.openings import Opening

CORE = "core"  # group of the middle one of three leaves
SAME = 1e-9  # lengths closer than this are one [m]
AROUND = 1.5  # of the height: how far the ground reaches around a structure


class Sizes(NamedTuple):
    """Of the stones aimed at [m]."""

    course: float
    unit: float


@dataclass(frozen=True, eq=False)
class Wall:
    """One straight wall [m]. It may end at, run through or cross walls along the other axis."""

    name: str
    group: str
    axis: int  # 0: along x, 1: along y
    start: float  # along its axis
    end: float
    near: float  # across
    far: float
    foot: float
    top: float  # the eaves, where there is a gable
    openings: tuple[Opening, ...] = ()
    gable: float = 0.0  # height of the gable above the top
    leaves: int = 1
    through: int = 3  # with two leaves or more: every through-th stone of every through-th course reaches through all of them; 0: none
    voids: tuple[tuple[float, float, float, float], ...] = ()  # s0, s1, z0, z1 left out for what is bonded in from outside the plan
    anchor: float | None = None  # where its bond starts; its own start by default
    shoulder: tuple[float, float, float] | None = None  # from this height up it only reaches from the second to the third
    core: tuple[float, float] | None = None  # of three leaves: where the middle one begins and ends, across
    hollow: bool = False  # the core is left out

    @property
    def profile(self) -> list[tuple[float, float]]:
        """The top, s and z of its corners [m]."""
        low, start, end = self.shoulder or (self.top, self.start, self.end)
        gable = [(0.5 * (start + end), self.top + self.gable)] if self.gable else []
        upper = [(start, self.top), *gable, (end, self.top)]
        return [(self.start, low), (start, low), *upper, (end, low), (self.end, low)] if self.shoulder else upper


def ground(blocks: Sequence[Block], depth: float, density: float) -> Block:
    """A fixed slab under all blocks, its top at the lowest of them; so wide that what topples lies on it, and does not roll off at once."""
    low = np.min([block.vertices.min(axis=0) for block in blocks], axis=0)
    high = np.max([block.vertices.max(axis=0) for block in blocks], axis=0)
    margin = AROUND * float(high[2] - low[2])
    vertices, faces = box(
        (float(low[0]) - margin, float(low[1]) - margin, float(low[2]) - depth),
        (float(high[0]) + margin, float(high[1]) + margin, float(low[2])),
    )
    return Block("ground", vertices, faces, density, "base", fixed=True)
