# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for the least factor of sliding without dilation: where descents begin (see descent.py), and how well their ends agree.

The first start begins at the associated mechanism, the second at the least normal forces in equilibrium, which press together nothing that
need not be, others at random normal forces around these, by turns. In space forces may differ a little everywhere, and factors of starts
that come to one mechanism by some percent. Rounds that begin close to the least pair lower it until that takes off nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from masonry_cd.analysis.limit.descent import LARGEST, NO_POWER, SPREAD, Begin, Pair, Search, normal_forces
from masonry_cd.analysis.limit.mechanism import STILL
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import ALIKE, LeastFound, Optimum, Unbounded, merged

CAP = 10.0  # times the associated factor: the largest that is looked for
POLISH, POLISHED = 9.0, 4  # M_k from which rounds lead from a pair to the next, lower by a percent in space; pairs at most
CLOSE, FINER = 0.05, 0.1  # share of the least factor by which they may lie above it, and the share of g of a pair, for these rounds


def sought(associated: Optimum) -> float:
    """The largest factor that is looked for without dilation."""
    return CAP * max(abs(associated.factor), 1e-3)


def least_factor(
    problem: LimitProblem, associated: Optimum, starts: int, seed: int, first: int = 0, known: LeastFound | None = None
) -> LeastFound | None:
    """The least factor that some starts come to, None where none is made or comes to a pair.

    The second start, which is the quickest and often the best, is made before all others, so that these are given up in time.

    Args:
        problem: whose least factor is sought.
        associated: its associated answer.
        starts: how many.
        seed: of the random ones.
        first: number of the first that is made; those before it are left out.
        known: what these found.
    """
    if starts <= first:
        return None
    search = Search(problem, sought(associated), known)
    begins = list(_begins(search, associated, starts, seed))[first:]
    quick = search.each(search.descend_from, [begins.pop(1)]) if known is None and len(begins) > 1 else []
    search.known = min([search.known, *(end[0].factor for end in quick)])
    return _found([*quick, *search.each(search.descend_from, begins)], starts - first)


def polished(problem: LimitProblem, found: LeastFound, cap: float) -> LeastFound:
    """A search whose least pair is lowered by rounds that begin close to it, from pair to pair, which is not a further start."""
    every = Search(problem, cap, found)
    every.beyond, every.exact = CLOSE, FINER * every.exact
    near = every.near(found.optimum.velocity)
    search, best = (every, found.optimum) if near is None else (every.among(near), near.of_some(found.optimum))
    pair, ends = None, [*_lowered(search, best)]
    if ends:
        with suppress(Unbounded):
            pair = ends[-1] if near is None else every.confirmed(near.of_all(ends[-1][0].velocity, problem.unknowns))
    if pair is None or pair[0].factor >= found.optimum.factor:
        return found
    return LeastFound(*pair, found.starts, found.ends)


def _lowered(search: Search, best: Optimum) -> Iterator[Pair]:
    """Lower and lower pairs, each from rounds that begin close to the one before."""
    for _ in range(POLISHED):
        try:
            pair = next(search.pairs(search.mechanism_of(normal_forces(search.problem, best)), POLISH, SPREAD), None)
        except Unbounded:
            return
        if pair is None or pair[0].factor >= best.factor:
            return
        yield pair
        best = pair[0]


def _begins(search: Search, associated: Optimum, starts: int, seed: int) -> Iterator[Begin]:
    """The beginnings of a number of starts."""
    random, power = np.random.default_rng(seed), float(search.problem.live @ associated.velocity)
    pressed = normal_forces(search.problem, associated)
    for start in range(starts):
        if start % 2:
            least = search.least_normal
            yield Begin(normal=None if least is None else least if start == 1 else least * random.uniform(0.5, 1.5, len(least)))
        elif start == 0:
            yield Begin(associated.velocity / power) if power > NO_POWER else Begin(normal=pressed)
        else:
            yield Begin(normal=pressed * random.random(len(pressed)) + random.exponential(float(pressed.mean()), len(pressed)))


def _found(ends: Sequence[Pair], starts: int) -> LeastFound | None:
    """The least of some pairs."""
    if not ends:
        return None
    best, gap = min(ends, key=lambda end: end[0].factor)
    return LeastFound(best, gap, starts, tuple(optimum for optimum, _ in ends))


def close_to(problem: LimitProblem, normal: np.ndarray, cap: float) -> Optimum | None:
    """The pair close to normal forces r'_n (P,), None where the descent from their mechanism comes to none."""
    search = Search(problem, cap)
    try:
        end = search.descend(search.mechanism_of(normal), LARGEST)
    except Unbounded:
        return None
    return None if end is None else end[0]


@dataclass(frozen=True, eq=False)
class Searched:
    """A search: what it found, None where no start came to an end, and of how many starts."""

    least: LeastFound | None
    starts: int


def ends_of(problem: LimitProblem, mechanisms: Sequence[np.ndarray], cap: float, known: LeastFound | None = None) -> list[Pair]:
    """The pairs close to known mechanisms, of those that come to one.

    Args:
        problem: whose least factor is sought.
        mechanisms: velocities (unknowns,) that the live loads drive, w_1 . v > 0, under which no joint closes and that no tie holds which
            does not yield; others are passed over. They may be of another problem: the structure without its ties, one of its parts.
        cap: the largest factor that is looked for.
        known: what was found before.
    """
    search = Search(problem, cap, known)
    begun = [(velocity, float(problem.live @ velocity)) for velocity in mechanisms if not _is_held(problem, velocity)]
    return search.each(partial(search.descend, begin=LARGEST), [velocity / power for velocity, power in begun if power > 0.0])


def _is_held(problem: LimitProblem, velocity: np.ndarray) -> bool:
    """True of a mechanism that stretches a tie which does not yield, or closes a joint."""
    longer = (problem.bars @ velocity)[~np.isfinite(problem.strength)]
    opening = (problem.jacobian @ velocity)[:: problem.directions]
    size = STILL * float(np.abs(velocity).max(initial=0.0))
    return bool((longer > size).any() or (opening < -size).any())


def begun_at(problem: LimitProblem, before: Searched, mechanisms: Sequence[np.ndarray], cap: float) -> Searched:
    """A search that has begun at mechanisms as well; arguments as of :func:`ends_of`.

    Descents from mechanisms that are alike come to one end, which is not agreement: those that come to one factor are one start.
    """
    every, apart = ends_of(problem, mechanisms, cap, before.least), list[Pair]()
    for end in sorted(every, key=lambda pair: pair[0].factor):
        if not apart or end[0].factor - apart[-1][0].factor > ALIKE * abs(apart[-1][0].factor):
            apart.append(end)
    starts = before.starts + len(mechanisms) - len(every) + len(apart)
    return Searched(merged(before.least, _found(apart, starts), starts), starts)
