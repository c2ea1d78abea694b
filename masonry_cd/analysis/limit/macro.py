# SPDX-License-Identifier: GPL-3.0-or-later
"""The limit analysis of a macro-element: the mechanisms of practice, and the free least mechanism within it, each push by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.analysis import refuse_crushed, searched_finely
from masonry_cd.analysis.limit.crushing import solved_finely
from masonry_cd.analysis.limit.found import ASSOCIATED, FREE, SEARCH, FoundMechanism, are_alike, dilation, found_in, gravest_followed
from masonry_cd.analysis.limit.linkage import with_displacements
from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.analysis.limit.outcome import SearchNumbers
from masonry_cd.analysis.limit.part import FreedPart, Whole, part_of, resting
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.analysis.limit.restrictions import Restriction, restrictions
from masonry_cd.analysis.limit.rigid_groups import RigidGroups, rigid_groups
from masonry_cd.analysis.limit.search import Searched, begun_at, least_factor
from masonry_cd.analysis.limit.solution import LeastFound, Optimum, Unbounded
from structures.macro_elements.element import HORIZONTAL_BENDING, MacroElement

MOST = 5.0  # load factor, in g, beyond which nothing is looked for: a part that bears so much is held
HELD = 0.99  # share of it from which on a part counts as held
BEGIN_AT = 3  # mechanisms of practice of least factor from which the free search begins as well
STARTS = 2  # of the search of a mechanism of practice
SLIDES = 0.5  # speed of the foot of a body over that of its top, or its own, from which on it slides rather than turns over


@dataclass(frozen=True)
class Effort:
    """How much is looked for."""

    starts: int  # of the free search within a part, in addition to those at the mechanisms of practice
    most_points: int  # contact points of a part up to which it is made
    seed: int = 0
    displacements: bool = False  # follow the governing mechanisms of each part and push until its factor vanishes


@dataclass(frozen=True, eq=False)
class ElementAnalysis:
    """The mechanisms of a macro-element under one push, and their search; the whole of a structure is the one that holds everything."""

    element: MacroElement
    direction: np.ndarray
    mechanisms: tuple[FoundMechanism, ...]  # the least acceleration first; none of a part that is held
    points: int  # contact points of the part
    interlock: float  # friction of bonded walls that holds it [N]
    remarks: tuple[str, ...]
    numbers: SearchNumbers  # of the free search
    doubt: str = ""  # the reason why no demand counts as met after the search; empty where one may
    search: str = ""  # the line of the terminal on its outcome

    @property
    def held(self) -> bool:
        """True where it was found to have no mechanism, not where the search for one came to no answer."""
        return not self.mechanisms and not self.remarks


def analyse_element(whole: Whole, element: MacroElement, direction: Sequence[float], effort: Effort) -> ElementAnalysis:
    """All mechanisms of a macro-element under a push along a direction (3,).

    Raises:
        InputError: joints of the part that crush under the dead loads alone.
    """
    way, found, remarks = np.asarray(direction, dtype=float), [], []
    made = list(restrictions(whole, element, way))
    for name in dict.fromkeys(each.name for each in made):
        try:
            found += _least_of(whole, way, [each for each in made if each.name == name])
        except Unbounded as failure:
            remarks.append(f"{name}: no answer: {failure}")
    part = part_of(whole, resting(whole, element.blocks), way)
    least = None
    try:
        more, least = _free(part, found, effort)
        found += more
    except Unbounded as failure:
        remarks.append(f"{FREE}: no answer, the part may not stand with all other blocks held: {failure}")
    found.sort(key=lambda one: one.oscillator.acceleration())

    def follow(_: int, one: FoundMechanism) -> Oscillator:
        assert one.mechanism is not None
        moving = np.flatnonzero(one.mechanism.moving & ~whole.assembly.fixed)
        around = part_of(whole, resting(whole, np.union1d(element.blocks, moving)), way)
        return with_displacements(around, one, effort.seed)

    found = gravest_followed(found, follow if effort.displacements else None)
    upper = min((one.oscillator.alpha for one in found if one.source.startswith(ASSOCIATED)), default=None)
    numbers = SearchNumbers.of(upper, least, 0)
    return ElementAnalysis(element, way, tuple(found), part.problem.points.count, part.interlock, tuple(remarks), numbers)


def _least_of(whole: Whole, way: np.ndarray, made: Sequence[Restriction]) -> list[FoundMechanism]:
    """From restrictions that differ in a height or an angle, the one of least factor without dilation, and of least associated factor."""
    least: list[tuple[Optimum, FreedPart, RigidGroups, Restriction]] = []
    upper: list[tuple[Optimum, FreedPart, RigidGroups, Restriction]] = []
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
            name, dilates = _worded(each, part, velocity), dilation(bodies.problem, best)
            out.append(found_in(part, source, replace(best, velocity=velocity), dilates, name))
    return out


def _free(part: FreedPart, known: Sequence[FoundMechanism], effort: Effort) -> tuple[list[FoundMechanism], LeastFound | None]:
    """The least mechanism block by block, from starts of its own and from mechanisms that are known."""
    problem = part.problem
    if problem.points.count > effort.most_points:
        return [], None
    refuse_crushed(problem, part.assembly)
    first = sorted((one for one in known if len(one.velocity) == problem.unknowns), key=lambda one: one.oscillator.alpha)[:BEGIN_AT]
    best, least = _searched(problem, (effort.starts, effort.seed), [one.velocity for one in first])
    ends = [] if least is None else sorted((end for end in least.ends if end.factor < HELD * MOST), key=lambda end: end.factor)
    upper = [(ASSOCIATED, best)] if best.factor < HELD * MOST else []
    out: list[FoundMechanism] = []
    for source, optimum in [*((SEARCH, end) for end in ends), *upper]:
        made = found_in(part, source, optimum, dilation(problem, optimum))
        if not any(are_alike(made, other) for other in out):
            out.append(made)
    return out, least


def _searched(problem: LimitProblem, begin: tuple[int, int], known: Sequence[np.ndarray]) -> tuple[Optimum, LeastFound | None]:
    """The associated answer of a problem and the least one without dilation, from starts (number, seed) and from known mechanisms."""
    problem, best = solved_finely(problem, lambda finer: largest(finer, finer.dead, finer.live, MOST))

    def search(finer: LimitProblem) -> LeastFound | None:
        own = Searched(least_factor(finer, best, *begin), begin[0])
        return begun_at(finer, own, known, MOST).least

    return best, searched_finely(problem, search)[1]


def _worded(each: Restriction, part: FreedPart, velocity: np.ndarray) -> str:
    """The name of a restriction, and where its first body slides at its foot, that it does."""
    if each.name == HORIZONTAL_BENDING:
        return each.name
    own, moved = each.bodies[0], part.problem.block_velocity(velocity, part.assembly.count)
    low, high = part.whole.box[0][own, 2].min(), part.whole.box[1][own, 2].max()
    middle, spin = part.assembly.centre[own].mean(axis=0), moved[own[0], 3:]
    ends = [moved[own[0], :3] + np.cross(spin, [*middle[:2], z] - part.assembly.centre[own[0]]) for z in (low, high)]
    foot, top = (float(np.linalg.norm(end[:2])) for end in ends)
    return f"{each.name}: it slides" if foot > SLIDES * max(foot, top) else each.name
