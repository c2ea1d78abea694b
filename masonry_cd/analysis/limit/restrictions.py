# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanisms that practice checks by hand, as rigid bodies into which the blocks of a macro-element are tied.

Each is a restriction of how the blocks may move, so that it starts at no less than the least mechanism of these blocks, and its factor is
that of virtual work, [C8.7.1.1]. Whether a body turns over or slides is left to the limit analysis, and said of what it finds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.limit.part import Whole, resting
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.plugins import load
from structures.macro_elements.element import (
    CORNER,
    HORIZONTAL_BENDING,
    IN_PLANE,
    MECHANISMS,
    OVERTURNING,
    PIERS,
    VERTICAL_BENDING,
    MacroElement,
)

LEVELS = 4  # beds at most about which a part is overturned, between the heights that it gives
WEDGES = (
    15.0,
    30.0,
)  # angles from the upright of the cracks by which a wall takes wedges of the walls that it is bonded with along [degrees]
HEIGHTS = (0.35, 0.5, 0.65, 0.8)  # shares of the height at which a wall bends that is held at its top
CRACKS = (30.0, 45.0, 60.0)  # slopes of the diagonal cracks of a wall in its plane [degrees]
SAME = 1e-6  # [m]


@dataclass(frozen=True, eq=False)
class Restriction:
    """Which blocks are free, and which of them move as one."""

    name: str
    free: np.ndarray  # (B,) bool
    bodies: tuple[np.ndarray, ...]  # numbers of the blocks of each; the first one gives the mechanism its name

    def by_hand(self, whole: Whole, direction: np.ndarray) -> list[np.ndarray]:
        """Velocities (B, 6) of the blocks as practice draws the mechanism under a push along (3,): the search begins there as well."""
        if self.name == PIERS:
            return [_rocking(whole, self.bodies, direction)]
        found = [_turned(whole, self.bodies, direction)]
        if self.name != VERTICAL_BENDING:
            return found
        lower, upper = self.bodies
        return [*found, _bent(whole, lower, upper, direction)]


def restrictions(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """The mechanisms that an element names, for a push along a direction (3,)."""
    for name in element.mechanisms:
        if name in MAKERS:
            yield from MAKERS[name](whole, element, direction)
        elif name not in MECHANISMS:
            yield from _of_package(name, whole, element, direction)


def _of_package(name: str, whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """A mechanism that an installed package adds: the bodies that it gives, with what rests on them.

    Raises:
        InputError: the package cannot be used, or gives something else than numbers of blocks.
    """
    for bodies in load("mechanisms", name)(whole, element, direction):
        blocks = tuple(np.asarray(body) for body in bodies)
        every = np.concatenate(blocks) if blocks else np.zeros(0)
        if not len(every) or every.dtype.kind not in "iu" or len(np.unique(every)) < len(every) or not np.isin(every, element.blocks).all():
            raise InputError("limit.mechanism", f'"{name}" of a package: bodies are numbers of blocks of the part, each in one of them')
        yield _made(whole, name, blocks)


def _overturning(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """The part above each of some beds, alone and with wedges of the walls in which it is bonded."""
    for level in _levels(whole, element):
        own = _above(whole, element.blocks, level)
        yield _made(whole, "simple overturning", (own,))
        for angle in WEDGES:
            more = _wedge(whole, own, element.directions[0], level, math.tan(math.radians(angle)))
            if len(more):
                yield _made(whole, f"composite overturning, wedges of {angle:g} degrees", (np.concatenate([own, more]),))


def _vertical_bending(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """Two bodies over one another, where something holds the upper one."""
    own = element.blocks
    tied = np.isin(whole.bars.blocks, own).any()
    loaded = np.isin(whole.lower, own) & (whole.upper >= 0) & ~np.isin(whole.upper, own)
    if not tied and not loaded.any():
        return
    low, high = _reach(whole, own)
    for share in HEIGHTS:
        upper = _above(whole, own, low + share * (high - low))
        lower = np.setdiff1d(own, upper)
        if len(upper) and len(lower):
            yield _made(whole, VERTICAL_BENDING, (lower, upper))


def _horizontal_bending(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """Two bodies next to one another, of the part above half of its height or above its lowest level."""
    low, high = _reach(whole, element.blocks)
    own = _above(whole, element.blocks, element.levels[0] if element.levels else 0.5 * (low + high))
    if not len(own):
        return
    along = whole.assembly.centre[own] @ np.array([-direction[1], direction[0], 0.0])
    left = along < 0.5 * (along.min() + along.max())
    if left.any() and not left.all():
        yield _made(whole, HORIZONTAL_BENDING, (own[left], own[~left]))


def _corner(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    for level in _levels(whole, element):
        own = _above(whole, element.blocks, level)
        if len(own):
            yield _made(whole, CORNER, (own,))


def _piers(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """Each pier a body, and all that rests on them another."""
    rest = np.setdiff1d(element.blocks, np.concatenate(element.piers)) if element.piers else element.blocks
    if len(rest) and element.piers:
        yield _made(whole, PIERS, (*element.piers, rest))


def _in_plane(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[Restriction]:
    """The part above a diagonal crack that rises from the toe, and the whole."""
    own, centre = element.blocks, whole.assembly.centre[element.blocks]
    along, (low, _) = centre @ direction, _reach(whole, element.blocks)
    yield _made(whole, "rocking in its plane", (own,))
    for slope in CRACKS:
        over = centre[:, 2] - low >= (along.max() - along) * math.tan(math.radians(slope))
        if over.any() and not over.all():
            yield _made(whole, f"{IN_PLANE}, a crack of {slope:g} degrees", (own[over],))


MAKERS = {
    OVERTURNING: _overturning, VERTICAL_BENDING: _vertical_bending, HORIZONTAL_BENDING: _horizontal_bending, CORNER: _corner, PIERS: _piers,
    IN_PLANE: _in_plane,
}  # fmt: skip


def _made(whole: Whole, name: str, bodies: tuple[np.ndarray, ...]) -> Restriction:
    """With what rests on the bodies, which goes with the one under it."""
    free = resting(whole, np.concatenate(bodies))
    owner = np.full(len(free), -1)
    for number, blocks in enumerate(bodies):
        owner[blocks] = number
    lies = np.flatnonzero((whole.upper >= 0) & free[whole.upper] & free[whole.lower])
    upper, lower = whole.upper[lies], whole.lower[lies]
    while True:
        carried = (owner[upper] < 0) & (owner[lower] >= 0)
        if not carried.any():
            break
        owner[upper[carried]] = owner[lower[carried]]
    return Restriction(name, free, tuple(np.flatnonzero(owner == number) for number in range(len(bodies))))


def spin(whole: Whole, blocks: np.ndarray, place: np.ndarray, direction: np.ndarray, rate: float, out: np.ndarray) -> None:
    """Turn blocks about a level axis through a place [m] so that what is above it moves along the push, at a rate [rad/s]."""
    axis = rate * np.array([-direction[1], direction[0], 0.0])
    out[blocks, :3] = np.cross(axis, whole.assembly.centre[blocks] - place)
    out[blocks, 3:] = axis


def lowest_toe(whole: Whole, blocks: np.ndarray, direction: np.ndarray, sense: float = 1.0) -> np.ndarray:
    """The lowest corner of some blocks that lies farthest along a push [m]."""
    corners = np.concatenate([whole.assembly.blocks[b].vertices for b in blocks])
    lowest = corners[corners[:, 2] <= corners[:, 2].min() + SAME]
    return np.asarray(lowest[np.argmax(sense * (lowest @ direction))])


def _turned(whole: Whole, bodies: Sequence[np.ndarray], direction: np.ndarray) -> np.ndarray:
    """All bodies as one, about the toe."""
    own, out = np.concatenate(bodies), np.zeros((whole.assembly.count, 6))
    spin(whole, own, lowest_toe(whole, own, direction), direction, 1.0, out)
    return out


def _bent(whole: Whole, lower: np.ndarray, upper: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """The lower body about its toe, the upper one back about the edge between the two, so that its top stays in its upright."""
    out = np.zeros((whole.assembly.count, 6))
    toe, hinge = lowest_toe(whole, lower, direction), lowest_toe(whole, upper, direction, -1.0)
    spin(whole, lower, toe, direction, 1.0, out)
    own = np.array([-direction[1], direction[0], 0.0])
    high = max(_reach(whole, upper)[1] - hinge[2], SAME)
    spin(whole, upper, hinge, direction, -(hinge[2] - toe[2]) / high, out)
    out[upper, :3] += np.cross(own, hinge - toe)
    return out


def _rocking(whole: Whole, bodies: Sequence[np.ndarray], direction: np.ndarray) -> np.ndarray:
    """Each pier about its own toe, and what rests on them along with their tops."""
    *piers, rest = bodies
    out = np.zeros((whole.assembly.count, 6))
    for pier in piers:
        spin(whole, pier, lowest_toe(whole, pier, direction), direction, 1.0, out)
    low, high = _reach(whole, np.concatenate(piers))
    wide = np.mean([float(np.ptp(whole.box[0][pier] @ direction)) for pier in piers])
    out[rest, :3] = (high - low) * direction + np.array([0.0, 0.0, wide])
    return out


def _levels(whole: Whole, element: MacroElement) -> list[float]:
    """Heights of some beds [m]: the foot of a part that gives none."""
    low = whole.box[0][element.blocks, 2]
    if element.levels is None:
        return [float(low.min())]
    beds = np.unique(np.round(low[(low >= element.levels[0] - SAME) & (low <= element.levels[1] + SAME)], 6))
    if not len(beds):
        return [float(low.min())]
    return [float(beds[k]) for k in np.unique(np.linspace(0, 0.75 * (len(beds) - 1), LEVELS).round().astype(int))]


def _above(whole: Whole, blocks: np.ndarray, level: float) -> np.ndarray:
    return blocks[whole.box[0][blocks, 2] >= level - SAME]


def _beyond(low: np.ndarray, high: np.ndarray, own: np.ndarray) -> np.ndarray:
    """How far the middles of blocks with extents (B,) lie outside those of some of them, (B,) [m]."""
    middle = 0.5 * (low + high)
    return np.asarray(np.maximum(np.maximum(low[own].min() - middle, middle - high[own].max()), 0.0))


def _reach(whole: Whole, blocks: np.ndarray) -> tuple[float, float]:
    """Foot and top of some blocks [m]."""
    return float(whole.box[0][blocks, 2].min()), float(whole.box[1][blocks, 2].max())


def _wedge(whole: Whole, own: np.ndarray, across: Sequence[float], level: float, slope: float) -> np.ndarray:
    """Blocks of other walls that rest on some blocks, or on one another above them, within a slope of the part; no floors and roofs.

    The part and its distances to other blocks are measured along and ``across`` it (3,) in plan.
    """
    x, y = across[:2]
    plan = [whole.extents(np.array([x, y, 0.0])), whole.extents(np.array([-y, x, 0.0]))]
    away = np.max([_beyond(*extents, own) for extents in plan], axis=0)
    middle = 0.5 * (whole.box[0] + whole.box[1])
    within = (away <= slope * (middle[:, 2] - level)) & ~whole.assembly.fixed
    floors = np.array([whole.rests(group) for group in whole.assembly.groups])[whole.assembly.group_of]
    taken = np.zeros(len(away), dtype=bool)
    taken[own] = True
    lies = np.flatnonzero(whole.upper >= 0)
    upper, lower = whole.upper[lies], whole.lower[lies]
    while True:
        more = np.unique(upper[taken[lower]])
        more = more[~taken[more] & within[more] & ~floors[more]]
        if not len(more):
            break
        taken[more] = True
    taken[own] = False
    return np.flatnonzero(taken)
