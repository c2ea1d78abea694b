# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls along x and y: what kinds of structure with keys of their own draw of a plan, the beds that all of its walls share, and the ground.

The engine of buildings makes the blocks (:mod:`structures.building.square_plan`). Where the footprints of two walls overlap, at a corner,
a junction or a crossing, the courses take turns: in even ones the wall along x runs through and the wall along y stops against it, in odd
ones the other way round. So the walls are interlocked without a cut stone, and no upright joint runs from bottom to top. Unbonded walls
leave every such place to one of the two, a straight joint: a real and dangerous condition, so it must be asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.geometry.prism import box
from structures.layout.openings import Opening, breaks, haunch_break

CORE = "core"  # group of the middle one of three leaves
LEAST_COURSE = 0.4  # height of the lowest course between two given levels, in courses
UNEVEN = 0.25  # by how much the courses of rubble vary
SAME = 1e-9  # lengths closer than this are one [m]
AROUND = 1.5  # of the height: how far the ground reaches around a structure


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


def levels(walls: Sequence[Wall], course: float, more: Iterable[tuple[float, str]] = ()) -> list[float]:
    """The beds that all walls share: courses of nearly one height between the levels that feet, tops and openings need [m].

    Args:
        course: the height of a course that is aimed at [m].
        more: further heights that need a bed, and the key that sets each.

    Raises:
        InputError: two levels that are too close for a course between them.
    """
    openings = [opening for wall in walls for opening in wall.openings]
    fixed = [(min(w.foot for w in walls), "foot"), (max(w.top + w.gable for w in walls), "structure.height")]
    fixed += [(w.top, f"the top of {w.name}") for w in walls] + [(w.top + w.gable, f"the gable of {w.name}") for w in walls if w.gable]
    fixed += [(w.foot, f"the foot of {w.name}") for w in walls]
    fixed += [(w.shoulder[0], f"the shoulder of {w.name}") for w in walls if w.shoulder]
    fixed += [*more, *(at for opening in openings for at in breaks(opening))]
    beds = _divided(fixed, course)
    for opening in openings:
        extra = haunch_break(opening, beds, [z for z, _ in fixed], LEAST_COURSE * course)
        if extra:
            fixed.append(extra)
            beds = _divided(fixed, course)
    return beds


def _divided(fixed: Sequence[tuple[float, str]], course: float) -> list[float]:
    """Beds at all of some heights, of which the keys are given."""
    ordered = sorted(fixed, key=lambda item: item[0])
    size.within((ordered[-1][0] - ordered[0][0]) / course, ordered[-1][1].removeprefix("structure."))  # a block to a course, at least
    kept = ordered[:1]
    for level, key in ordered[1:]:
        below, step = kept[-1], level - kept[-1][0]
        if step < SAME:
            continue
        if step < LEAST_COURSE * course - SAME:
            what, other = (key, below) if key != "structure.height" else (below[1], (level, key))
            raise InputError(
                f"{what}: asks for a bed {1e3 * step:.3g} mm from the one of {other[1]} at {other[0]:g} m; "
                f"bring them to one level, or {LEAST_COURSE * course:g} m apart or more, or take lower courses"
            )
        kept.append((level, key))
    return [float(z) for z in even([z for z, _ in kept], course)]


def even(levels: Sequence[float], course: float, random: np.random.Generator | None = None) -> np.ndarray:
    """Beds (N + 1,) of courses of nearly one height between levels, ascending; a generator makes them vary [m]."""
    found = [levels[0]]
    for a, b in pairwise(levels):
        count = max(1, round((b - a) / course))
        rise = (b - a) * np.arange(1, count) / count
        if random is not None:
            rise += (b - a) * UNEVEN / count * (random.random(count - 1) - 0.5)
        found += [*(a + rise).tolist(), b]
    return np.array(found)


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
