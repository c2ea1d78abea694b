# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism that was found, of the whole of a structure or of a part: its name, how it was found, where it is held, its oscillator."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.held import held_at
from masonry_cd.analysis.limit.mechanism import Mechanism, mechanism
from masonry_cd.analysis.limit.oscillator import Oscillator, oscillator
from masonry_cd.analysis.limit.part import FreedPart, Whole
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import ALIKE, Optimum
from masonry_cd.foundation.quantities import counted

SEARCH, ASSOCIATED = "search without dilation", "associated"
STOPPED = ", the solver stopped before it met its tolerance"
FREE = "free least mechanism"
SAME_HEIGHT = 1e-6  # [m]
SAME = 5e-3  # share by which numbers of mechanisms that say the same may differ: their d0* are found in two ways


@dataclass(frozen=True, eq=False)
class FoundMechanism:
    """A mechanism that starts at a finite factor, alpha of its oscillator."""

    name: str  # as tables and pictures show it
    source: str  # how it was found
    oscillator: Oscillator
    dilation: float  # work of normal forces on joints that open, as a share of the power of the loads
    moving: int  # blocks that move
    height: float  # z at which it is held [m]
    velocity: np.ndarray  # in the unknowns of the part's blocks
    mechanism: Mechanism | None  # of the gravest of a part and a push only: a large structure has a megabyte of joints
    stones: bool = False  # whether stones of one course slide by themselves: no mechanism of the part


def found_in(part: FreedPart, source: str, optimum: Optimum, dilates: float, name: str = "") -> FoundMechanism:
    """A mechanism of a part with its oscillator; ``name`` is that of practice, and without one its joints name it."""
    assembly, joints = part.assembly, part.whole.joints
    moves = _within(mechanism(part.problem, assembly, joints, optimum.velocity), part)
    called, stones = named(moves, part.whole, part.free, name)
    made, height = oscillator(part, moves, optimum.factor, dilates), held_at(moves, assembly, joints)
    how = source + (STOPPED if optimum.stopped else "")
    return FoundMechanism(called, how, made, dilates, int(moves.moving.sum()), height, optimum.velocity, moves, stones)


def are_alike(one: FoundMechanism, other: FoundMechanism) -> bool:
    """True of one mechanism that was found twice in the same way."""
    near = abs(one.oscillator.alpha - other.oscillator.alpha) <= ALIKE * abs(other.oscillator.alpha)
    if one.mechanism is None or other.mechanism is None:
        return False
    return one.source == other.source and near and bool(np.array_equal(one.mechanism.moving, other.mechanism.moving))


def says_the_same(one: FoundMechanism, other: FoundMechanism) -> bool:
    """True where a check of one mechanism has the numbers of another, its displacement among them where the other has one."""
    mine, theirs = one.oscillator, other.oscillator
    pairs = [(mine.alpha, theirs.alpha), (mine.fraction, theirs.fraction), (1.0 + one.height, 1.0 + other.height)]
    if theirs.falls:
        pairs.append((mine.last, theirs.last))
    return one.moving == other.moving and all(abs(a - b) <= SAME * abs(b) for a, b in pairs)


def grave(found: Sequence[FoundMechanism]) -> list[int]:
    """Which mechanisms, the least acceleration first, may have the least ratio: one that is held higher is checked against more."""
    out: list[int] = []
    highest = -math.inf
    for k, one in enumerate(found):
        if one.height > highest + SAME_HEIGHT:
            out.append(k)
            highest = one.height
    return out


def gravest_followed(found: Sequence[FoundMechanism], follow: Callable[[int, FoundMechanism], Oscillator] | None) -> list[FoundMechanism]:
    """Mechanisms, the least acceleration first, of which the gravest and that of least factor alone keep their velocities.

    The gravest get the oscillator that ``follow`` gives of the k-th, with its displacements; None follows none.
    """
    gravest = grave(found)
    if follow is None:
        gravest += [k for k, one in enumerate(found) if one.oscillator.alpha == min(each.oscillator.alpha for each in found)]
    else:
        found = [replace(one, oscillator=follow(k, one)) if k in gravest else one for k, one in enumerate(found)]
    return [one if k in gravest else replace(one, mechanism=None) for k, one in enumerate(found)]


def dilation(problem: LimitProblem, found: Optimum) -> float:
    """Work of normal forces, less what a bond takes up, on joints that open, over the power of the loads."""
    opening = np.maximum((problem.jacobian @ found.velocity)[:: problem.directions], 0.0)
    power = abs(float(problem.dead @ found.velocity)) + abs(found.factor * float(problem.live @ found.velocity))
    return float(opening @ np.maximum(found.force[:, 0] + problem.tension, 0.0)) / max(power, 1e-300)


def _within(moves: Mechanism, part: FreedPart) -> Mechanism:
    """A mechanism whose joints outside the part are still."""
    inside = np.zeros(part.whole.joints.count, dtype=bool)
    inside[part.problem.points.joint] = True
    names = ("opening", "least_opening", "sliding", "rotation", "state", "closing")
    return replace(moves, **{name: np.where(inside, getattr(moves, name), 0) for name in names})


def named(moves: Mechanism, whole: Whole, free: np.ndarray, name: str = "") -> tuple[str, bool]:
    """The name of a mechanism, and whether it is one of a few of the ``free`` (B,) stones that slide, which none of practice is."""
    crushed, count = _crushed(moves, whole), moves.stones(whole.joints)
    if name:
        return name + crushed, False
    if 0 < count < free.sum():
        return f"{counted(count, 'stone')} of one course that slide{'s' if count == 1 else ''}", True
    return f"{FREE}: {_counts(moves)}{crushed}", False


def _crushed(moves: Mechanism, whole: Whole) -> str:
    """Which joint crushes most, and how many others do; nothing where none does."""
    if not moves.crushing.any():
        return ""
    worst, more = int(np.argmax(moves.closing)), int(moves.crushing.sum()) - 1
    ends = (whole.assembly.names[int(block[worst])] for block in (whole.joints.block_a, whole.joints.block_b))
    crush = f"and {counted(more, 'joint')} more crush" if more else "crushes"
    return f"; {' - '.join(ends)} {crush}"


def _counts(moves: Mechanism) -> str:
    """How many joints hinge and slide."""
    both = moves.count("hinge and slide")
    counts = {"hinge": moves.count("hinge") + both, "slide": moves.count("slide") + both, "open": moves.count("open")}
    at_work = [(number, word) for word, number in counts.items() if number]
    if not at_work:
        return "no joint at work"
    (first, word), *others = at_work
    subject = f"1 joint {word}s" if first == 1 else f"{first} joints {word}"
    return ", ".join([subject, *(f"{number} {word}{'s' * (number == 1)}" for number, word in others)])
