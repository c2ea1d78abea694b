# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls in plan: which wall runs through where two of them meet, course by course.

All walls share one list of beds. Where the footprints of two walls overlap, at a corner, a junction or a crossing, the
courses take turns: in even ones the wall along x runs through and the wall along y stops against it, in odd ones the other way
round. So the walls are interlocked without a cut stone, and no upright joint runs from bottom to top. Unbonded walls
leave every such place to one of the two, a straight joint: a real and dangerous condition, so it must be asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import box, prism
from structures.layout import coursing
from structures.layout.coursing import LEAST_UNIT, Band, Piece
from structures.layout.openings import Opening, close

CORE = "core"  # group of the middle one of three leaves
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

    def stands(self, low: float, high: float) -> bool:
        """True when the wall proper, without its gable, fills the course between two beds."""
        return self.foot <= low + SAME and high <= self.top + SAME


def levels(walls: Sequence[Wall], course: float, more: Iterable[tuple[float, str]] = ()) -> list[float]:
    """The beds that all walls share."""
    foot, top = min(w.foot for w in walls), max(w.top + w.gable for w in walls)
    needed = [(w.top, f"the top of {w.name}") for w in walls] + [(w.top + w.gable, f"the gable of {w.name}") for w in walls if w.gable]
    needed += [(w.foot, f"the foot of {w.name}") for w in walls]
    needed += [(w.shoulder[0], f"the shoulder of {w.name}") for w in walls if w.shoulder]
    openings = [opening for wall in walls for opening in wall.openings]
    return coursing.levels(foot, top, openings, course, [*needed, *more])


def build(walls: Sequence[Wall], beds: Sequence[float], unit: float, density: float, bonded: bool = True) -> list[Block]:
    """The blocks of all walls, ``NAME.COURSE.NUMBER``, voussoirs and lintels ``NAME.oOPENING.NUMBER``.

    Args:
        beds: from :func:`levels` [m].
        unit: length of a block [m].
        density: [kg/m3].
        bonded: False makes straight joints where walls meet.
    """
    blocks: list[Block] = []
    for wall in walls:
        meets = [_meeting(wall, other) for other in walls if _meet(wall, other)]
        blocks += _blocks(wall, beds, unit, density, meets, bonded)
    return blocks


@dataclass(frozen=True, eq=False)
class _Meeting:
    """Another wall, and the stretch of this one that both fill."""

    other: Wall
    low: float
    high: float
    inner: bool  # not at an end of this wall


def _meet(wall: Wall, other: Wall) -> bool:
    if wall.axis == other.axis:
        return False
    along = min(wall.end, other.far) - max(wall.start, other.near)
    across = min(other.end, wall.far) - max(other.start, wall.near)
    height = min(wall.top, other.top) - max(wall.foot, other.foot)
    return along > SAME and across > SAME and height > SAME


def _meeting(wall: Wall, other: Wall) -> _Meeting:
    low, high = max(wall.start, other.near), min(wall.end, other.far)
    if abs(low - other.near) + abs(high - other.far) > SAME or other.start > wall.near + SAME or other.end < wall.far - SAME:
        raise RuntimeError(f"the walls {wall.name} and {other.name} meet in a part of their thickness only")
    return _Meeting(other, low, high, low > wall.start + SAME and high < wall.end - SAME)


def _owns(wall: Wall, meeting: _Meeting, course: int, bonded: bool) -> bool:
    """True when this wall runs through at a meeting."""
    if bonded:
        return course % 2 == wall.axis
    other = _meeting(meeting.other, wall)
    return meeting.inner if meeting.inner != other.inner else wall.axis == 0


def _bands(
    wall: Wall, beds: Sequence[float], first: int, unit: float, meets: Sequence[_Meeting], bonded: bool
) -> Callable[[int], list[Band]]:
    """The solid stretches of each course of a wall, counted from its foot."""

    def of(course: int) -> list[Band]:
        j = first + course
        low, high = beds[j], beds[j + 1]
        bands = [_whole(wall, low, high)]
        for meeting in meets:
            if not meeting.other.stands(low, high):
                continue
            if _owns(wall, meeting, j, bonded):
                if bonded:  # a stone on a corner, or a stretcher's end in the other wall, reaches beyond it
                    reach = meeting.high - meeting.low + LEAST_UNIT * unit
                    bands = [_bound(band, meeting, reach) for band in bands]
            else:
                bands = [part for band in bands for part in _without(band, meeting.low, meeting.high)]
        for s0, s1, z0, z1 in wall.voids:
            if z0 < high - SAME and low < z1 - SAME:
                bands = [part for band in bands for part in _without(band, s0, s1)]
        return bands

    return of


def _whole(wall: Wall, low: float, high: float) -> Band:
    """A course without openings and junctions; in a gable it ends on the slopes."""
    start, end = wall.start, wall.end
    if wall.shoulder and low > wall.shoulder[0] - SAME:
        start, end = wall.shoulder[1:]
    if high <= wall.top + SAME:
        return Band(start, start, end, end)
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    rest = [1.0 - (z - wall.top) / wall.gable for z in (low, high)]
    reach = [half * share if share > 1e-12 else 0.0 for share in rest]
    return Band(middle - reach[0], middle - reach[1], middle + reach[0], middle + reach[1])


def _bound(band: Band, meeting: _Meeting, reach: float) -> Band:
    if abs(band.left0 - meeting.low) < SAME:
        band = band._replace(bond_left=reach)
    if abs(band.right0 - meeting.high) < SAME:
        band = band._replace(bond_right=reach)
    return band


def _without(band: Band, low: float, high: float) -> list[Band]:
    """A band without a stretch."""
    if high <= band.left0 + SAME or low >= band.right0 - SAME:
        return [band]
    parts = []
    if low > band.left0 + SAME:
        parts.append(band._replace(right0=low, right1=low, bond_right=0.0))
    if high < band.right0 - SAME:
        parts.append(band._replace(left0=high, left1=high, bond_left=0.0))
    return parts


def _blocks(wall: Wall, beds: Sequence[float], unit: float, density: float, meets: Sequence[_Meeting], bonded: bool) -> list[Block]:
    """Cut a wall and draw its pieces out across it, leaf by leaf."""
    first, last = (int(np.argmin(np.abs(np.asarray(beds) - z))) for z in (wall.foot, wall.top + wall.gable))
    own = beds[first : last + 1]
    course = (own[-1] - own[0]) / (len(own) - 1)
    closings = [close(opening, own, course) for opening in wall.openings]
    bands = _bands(wall, beds, first, unit, meets, bonded)
    bounds = np.linspace(wall.near, wall.far, wall.leaves + 1) if wall.core is None else np.array([wall.near, *wall.core, wall.far])
    blocks = []
    tied: list[Piece] = []
    for leaf in range(wall.leaves):
        shift = _shift(wall, first, leaf)
        pieces = coursing.lay_courses(own, bands, closings, unit, shift, wall.start if wall.anchor is None else wall.anchor)
        if leaf == 0:
            tied = [piece for piece in pieces if piece.opening < 0 and _tied(wall, piece.course)]
        else:  # courses with through-stones have the joints of the first leaf
            pieces = [piece for piece in pieces if piece.opening < 0 and not _tied(wall, piece.course)] + tied
        for piece in pieces:
            whole = wall.leaves == 1 or piece.opening >= 0 or (_tied(wall, piece.course) and piece.number % wall.through == 0)
            whole = whole or (wall.core is not None and _at_end(wall, piece))
            if (whole and leaf > 0) or (wall.hollow and leaf == 1 and not whole):
                continue
            near, far = (wall.near, wall.far) if whole else (float(bounds[leaf]), float(bounds[leaf + 1]))
            name = _name(wall, piece, first) + ("" if whole else f".{'abcdefgh'[leaf]}")
            group = CORE if wall.core is not None and leaf == 1 else wall.group
            blocks.append(Block(name, *prism(piece.polygon, wall.axis, near, far), density, group))
    return blocks


def _shift(wall: Wall, first: int, leaf: int) -> coursing.Shift:
    """The running bond; the leaves behind each other are a quarter of a block apart."""

    def of(course: int) -> float:
        return 0.5 * ((first + course) % 2) + (0.0 if wall.core or _tied(wall, course) else 0.25 * leaf)

    return of


def _tied(wall: Wall, course: int) -> bool:
    """True for the courses of a wall of several leaves that have through-stones; all its leaves have the same joints there."""
    return wall.leaves > 1 and wall.through > 0 and course % wall.through == wall.through - 1


def _at_end(wall: Wall, piece: Piece) -> bool:
    """True for the stones that close a wall with a core at its two ends: all of them reach through it."""
    return bool(piece.polygon[:, 0].min() < wall.start + SAME or piece.polygon[:, 0].max() > wall.end - SAME)


def _name(wall: Wall, piece: Piece, first: int) -> str:
    if piece.opening < 0:
        return f"{wall.name}.{first + piece.course + 1}.{piece.number + 1}"
    return f"{wall.name}.o{piece.opening + 1}.{'v' if piece.kind == 'voussoir' else piece.kind[0]}{piece.number + 1}"


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
