# SPDX-License-Identifier: GPL-3.0-or-later
"""The limit analysis of a macro-element: the mechanisms of practice, and the free least mechanism within it, each push by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.analysis import refuse_crushed, searched_finely
from masonry_cd.analysis.limit.candidates import ASSOCIATED, SEARCH, Candidate, alike, dilation
from masonry_cd.analysis.limit.crushing import solved_finely
from masonry_cd.analysis.limit.held import held_at
from masonry_cd.analysis.limit.linkage import with_displacements
from masonry_cd.analysis.limit.mechanism import Mechanism, mechanism
from masonry_cd.analysis.limit.oscillator import Oscillator, oscillator
from masonry_cd.analysis.limit.part import Part, Whole, part_of, resting
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.analysis.limit.restrictions import Restriction, restrictions
from masonry_cd.analysis.limit.rigid_groups import RigidGroups, rigid_groups
from masonry_cd.analysis.limit.search import Searched, begun_at, least_factor
from masonry_cd.analysis.limit.solution import LeastFound, Optimum, Unbounded
from masonry_cd.foundation.quantities import counted
from structures.macro_elements.element import HORIZONTAL_BENDING, MacroElement

MOST = 5.0  # load factor, in g, beyond which nothing is looked for: a part that bears so much is held
HELD = 0.99  # share of it from which on a part counts as held
FREE = "free least mechanism"
BEGIN_AT = 3  # mechanisms of practice of least factor from which the free search begins as well
SAME_HEIGHT = 1e-6  # [m]
STARTS = 2  # of the search of a mechanism of practice
SLIDES = 0.5  # speed of the foot of a body over that of its top, or its own, from which on it slides rather than turns over


@dataclass(frozen=True)
class Effort:
    """How much is looked for."""

    starts: int  # of the free search within a part, beside those at the mechanisms of practice
    most_points: int  # contact points of a part up to which it is made
    seed: int = 0
    displacements: bool = False  # follow the gravest mechanisms of each part and push until its factor vanishes


@dataclass(frozen=True, eq=False)
class PartMechanism:
    """A mechanism of a macro-element that starts at a finite factor."""

    element: MacroElement
    direction: np.ndarray  # (3,) of the push
    name: str  # of the mechanism, in words
    source: str  # how it was found
    oscillator: Oscillator
    moving: int  # blocks that move
    height: float  # z at which it is held [m]
    velocity: np.ndarray  # in the unknowns of the part's blocks
    found: Candidate | None  # of the gravest mechanisms of a part and a push only: a large structure has a megabyte of joints
    stones: bool = False  # whether stones of one course slide by themselves: no mechanism of the part


@dataclass(frozen=True, eq=False)
class ElementAnalysis:
    """What was found of a macro-element under one push."""

    element: MacroElement
    direction: np.ndarray
    mechanisms: tuple[PartMechanism, ...]  # the least acceleration first; none of a part that is held
    least: LeastFound | None  # of the free search
    points: int  # contact points of the part
    interlock: float  # friction of bonded walls that holds it [N]
    remarks: tuple[str, ...]


def analyse_element(whole: Whole, element: MacroElement, direction: Sequence[float], effort: Effort) -> ElementAnalysis:
    """All mechanisms of a macro-element under a push along a direction (3,).

    Raises:
        InputError: joints of the part that crush under the dead loads alone.
    """
    way, found, remarks = np.asarray(direction, dtype=float), [], []
    made = list(restrictions(whole, element, way))
    for name in dict.fromkeys(each.name for each in made):
        try:
            found += _least_of(whole, element, way, [each for each in made if each.name == name])
        except Unbounded as failure:
            remarks.append(f"{name}: no answer: {failure}")
    part = part_of(whole, resting(whole, element.blocks), way)
    least = None
    try:
        more, least = _free(part, element, way, found, effort)
        found += more
    except Unbounded as failure:
        remarks.append(f"{FREE}: no answer, the part may not stand with all else held: {failure}")
    found.sort(key=lambda one: one.oscillator.acceleration())
    gravest = grave(found)
    if effort.displacements:
        found = [_followed(whole, one, effort) if k in gravest else one for k, one in enumerate(found)]
    found = [one if k in gravest else replace(one, found=None) for k, one in enumerate(found)]
    return ElementAnalysis(element, way, tuple(found), least, part.problem.points.count, part.interlock, tuple(remarks))


def _least_of(whole: Whole, element: MacroElement, way: np.ndarray, made: Sequence[Restriction]) -> list[PartMechanism]:
    """Of restrictions that differ in a height or an angle: the one of least factor without dilation, and of least associated factor."""
    least: list[tuple[Optimum, Part, RigidGroups, Restriction]] = []
    upper: list[tuple[Optimum, Part, RigidGroups, Restriction]] = []
    for each in made:
        part = part_of(whole, each.free, way)
        bodies = rigid_groups(part.problem, part.assembly, each.bodies)
        begun = [bodies.of_bodies(drawn) for drawn in each.by_hand(whole, way)]
        best, found = _searched(bodies.problem, (STARTS, 0), begun)
        if found is not None and found.optimum.factor < HELD * MOST:
            least.append((found.optimum, part, bodies, each))
        if best.factor < HELD * MOST:
            upper.append((best, part, bodies, each))
    out = []
    for source, solved in ((SEARCH, least), (ASSOCIATED, upper)):
        if solved:
            best, part, bodies, each = min(solved, key=lambda one: one[0].factor)
            velocity = bodies.of_blocks(best.velocity)
            called = _worded(each, part, velocity), source
            out.append(_made(part, element, way, called, replace(best, velocity=velocity), dilation(bodies.problem, best)))
    return out


def _free(
    part: Part, element: MacroElement, way: np.ndarray, known: Sequence[PartMechanism], effort: Effort
) -> tuple[list[PartMechanism], LeastFound | None]:
    """The least mechanism block by block, from starts of its own and from mechanisms that are known."""
    problem = part.problem
    if problem.points.count > effort.most_points:
        return [], None
    refuse_crushed(problem, part.assembly)
    first = sorted((one for one in known if len(one.velocity) == problem.unknowns), key=lambda one: one.oscillator.alpha)[:BEGIN_AT]
    best, least = _searched(problem, (effort.starts, effort.seed), [one.velocity for one in first])
    ends = [] if least is None else sorted((end for end in least.ends if end.factor < HELD * MOST), key=lambda end: end.factor)
    upper = [(ASSOCIATED, best)] if best.factor < HELD * MOST else []
    out: list[PartMechanism] = []
    for source, optimum in [*((SEARCH, end) for end in ends), *upper]:
        made = _made(part, element, way, (FREE, source), optimum, dilation(problem, optimum))
        assert made.found is not None
        if not any(alike(made.found, other.found) for other in out if other.found):
            name, stones = named(made.found.mechanism, part.whole, part.free)
            out.append(replace(made, name=name, stones=stones))
    return out, least


def _searched(problem: LimitProblem, begin: tuple[int, int], known: Sequence[np.ndarray]) -> tuple[Optimum, LeastFound | None]:
    """The associated answer of a problem and the least one without dilation, from so many starts of a seed and from known mechanisms."""
    problem, best = solved_finely(problem, lambda finer: largest(finer, finer.dead, finer.live, MOST))

    def search(finer: LimitProblem) -> LeastFound | None:
        own = Searched(least_factor(finer, best, *begin), begin[0])
        return begun_at(finer, own, known, MOST).least

    return best, searched_finely(problem, search)[1]


def _made(part: Part, element: MacroElement, way: np.ndarray, called: tuple[str, str], optimum: Optimum, dilates: float) -> PartMechanism:
    """A mechanism with its oscillator."""
    moves = _within(mechanism(part.problem, part.assembly, part.whole.joints, optimum.velocity), part)
    found = Candidate(called[1], optimum.factor, moves, dilates)
    height = held_at(moves, part.assembly, part.whole.joints)
    made = oscillator(found, part.assembly, part.whole.joints, part.push, None, part.loads.live)
    name, source = called[0] + _crushed(moves, part.whole), called[1]
    return PartMechanism(element, way, name, source, made, int(moves.moving.sum()), height, optimum.velocity, found)


def grave(found: Sequence[PartMechanism]) -> list[int]:
    """Which mechanisms, the least acceleration first, may have the least ratio: one that is held higher is asked for more."""
    out: list[int] = []
    highest = -math.inf
    for k, one in enumerate(found):
        if one.height > highest + SAME_HEIGHT:
            out.append(k)
            highest = one.height
    return out


def _followed(whole: Whole, one: PartMechanism, effort: Effort) -> PartMechanism:
    """A mechanism with the displacements of its oscillator, or why there are none."""
    assert one.found is not None
    moving = one.found.mechanism.moving
    free = resting(whole, np.union1d(one.element.blocks, np.flatnonzero(moving & ~whole.assembly.fixed)))
    part = part_of(whole, free, one.direction)
    return replace(one, oscillator=with_displacements(part, one.found, one.oscillator, effort.seed))


def _within(moves: Mechanism, part: Part) -> Mechanism:
    """A mechanism whose joints outside the part are still."""
    inside = np.zeros(part.whole.joints.count, dtype=bool)
    inside[part.problem.points.joint] = True
    names = ("opening", "least_opening", "sliding", "rotation", "state", "closing")
    return replace(moves, **{name: np.where(inside, getattr(moves, name), 0) for name in names})


def _worded(each: Restriction, part: Part, velocity: np.ndarray) -> str:
    """The name of a restriction, and where its first body slides at its foot, that it does."""
    if each.name == HORIZONTAL_BENDING:
        return each.name
    own, moved = each.bodies[0], part.problem.block_velocity(velocity, part.assembly.count)
    low, high = part.whole.box[0][own, 2].min(), part.whole.box[1][own, 2].max()
    middle, spin = part.assembly.centre[own].mean(axis=0), moved[own[0], 3:]
    ends = [moved[own[0], :3] + np.cross(spin, [*middle[:2], z] - part.assembly.centre[own[0]]) for z in (low, high)]
    foot, top = (float(np.linalg.norm(end[:2])) for end in ends)
    return f"{each.name}: it slides" if foot > SLIDES * max(foot, top) else each.name


def named(moves: Mechanism, whole: Whole, free: np.ndarray) -> tuple[str, bool]:
    """The name of a mechanism that was found block by block, and whether it is one of a few of the ``free`` (B,) stones that slide."""
    count = moves.stones(whole.joints)
    if 0 < count < free.sum():
        return f"{counted(count, 'stone')} of one course that slide{'s' if count == 1 else ''}", True
    return f"{FREE}: {_counts(moves)}{_crushed(moves, whole)}", False


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
