# SPDX-License-Identifier: GPL-3.0-or-later
r"""Coulomb friction that does not dilate: descents to a least factor.

Sliding that opens nothing, u_n = 0, is not the associated flow rule, and the factor of collapse is then not unique. A factor belongs to it
when forces and velocities satisfy together, with w_1 . v = 1 and u = H v,

    r as in the static problem,    u_n >= 0,    g = sum over the points of  u_n (r_n + f) + mu r'_n |u_t| + r_t . u_t  = 0,

and over the ties (N_y - N) G v, or -N G v of those that are slack. No term of g is negative. The least such factor is a programme with
complementarity constraints (Ferris & Tin-Loi, Int. J. Mech. Sci. 43, 2001).

**Descent.** The terms of g are linear in r and convex in v. For the mechanism at hand the forces of least lambda + sum M_k g_k are found,
for these forces the mechanism of least g: that of the associated problem with the strips |r_t| <= mu r'_n for cones, which open nothing
(Gilbert, Casapulla & Ahmed, Computers & Structures 84, 2006; in space Portioli, Casapulla, Gilbert & Cascini, ibid. 142, 2014). And so on,
with M_k that grow from round to round, fastest at the few points that have most of g: as long as they are small, forces may leave what a
mechanism asks of them, so that a descent does not end where it began. Where it sticks before g is nothing and no pair is known, rounds of
strips alone, each with the normal forces of the one before, move it on.

In space a stone may turn like a door about an upright edge through which all passes that bears on it. Nothing that is pressed slides, and
no load at all starts it; real joints, pressed over an area, do not allow it. So strips of the corners of a joint share a little of their
width, which leads descents past these and is not part of g; where a descent comes to no pair so, and none is known, it is made without.

Once g is small, rounds hardly change more than the blocks that move and those that touch them. They continue with all others held, at a
fraction of the cost (see neighbours.py), and forces in all blocks that belong to the mechanism are found at the end. Where there are none,
rounds continue with all blocks.

A pair with g = 0 is a proof that its factor is one of those that Coulomb's law allows; that no other is less is not proof but the agreement
of starts (see search.py). Cone programmes are solved to a tolerance, so that g in space is small and not zero; it is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.neighbours import Neighbours, neighbours
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.programme import Programme, programme
from masonry_cd.analysis.limit.solution import LeastFound, Optimum, Unbounded
from masonry_cd.mechanics.solvers.options import cores

ROUNDS = 24  # of a descent at most
GROWS, LARGEST = 3.0, 1e3  # M_k, over w_1 . v = 1, begin at one and grow by this factor from round to round, up to that
WORST, FASTER, MOST = 0.05, 10.0, 1e4  # of points with more than this share of g they grow by this factor instead, up to that
LOWER = 2e-3  # share of the factor that a round takes off at least, once a pair is found
STUCK, CLOSER = 1e-3, 0.8  # a round sticks that moves the factor by no more than this share of it and leaves more than that of g
LOOSENED, STRIPS, AGAIN = 2, 4, 3.0  # how often a descent that sticks is moved on, each time by how many rounds of strips; M_k after it
WORSE = 0.1  # share by which forces may cost more than those of the round before, which would do as well: more is not an answer
SPREAD = 0.1  # share of the width of a joint's strips in space that its corners have in common
IDLE = 1e-5  # power of the loads, over that of the largest factor that is looked for, up to which they do no work
EXACT, NEARLY = 1e-7, 1e-3  # g of a pair, over the power of the loads: in a plane, and in space
NO_POWER = 0.5  # w_1 . v of a programme of strips below which its factor is the cap: it is 1 elsewhere
BEYOND = 0.25  # share of the least factor known by which a descent lies above it that is given up: their e* seldom differ as much
SETTLED = 1e-2  # g from which on the blocks that move and their neighbours are looked at alone
LARGE = 1_000  # contact points from which on descents run in several threads, and rounds among few blocks pay

Pair = tuple[Optimum, float]  # forces and velocities, and g over the power of the loads
_SEEN: ContextVar[Callable[[int, int], object]] = ContextVar("_SEEN", default=lambda begun, ended: None)


@contextmanager
def watched(seen: Callable[[int, int], object]) -> Iterator[None]:
    """Call ``seen`` with how many more descents begin, and how many have ended, in all searches of the body."""
    token = _SEEN.set(seen)
    try:
        yield
    finally:
        _SEEN.reset(token)


@dataclass(frozen=True, eq=False)
class _Asked:
    """The coefficients of g for a mechanism: g is linear in the forces."""

    prices: np.ndarray  # (P, m) of r'
    of_bars: np.ndarray  # (T,) of N
    least: np.ndarray  # (P,) prices of a tension that is cut off, which cannot be less
    yields: float  # work of the ties that yield


@dataclass(frozen=True, eq=False)
class Begin:
    """The beginning of a start: a mechanism (unknowns,) with w_1 . v = 1, or that of normal forces r'_n (P,); none without both."""

    velocity: np.ndarray | None = None
    normal: np.ndarray | None = None


class GivenUp(Unbounded):
    """Raised by a descent that stays far above what is known."""


class Search:
    """The descents of a problem, whose programmes are set up once."""

    def __init__(self, problem: LimitProblem, cap: float, known: LeastFound | None = None) -> None:
        """``cap``: the largest factor that is looked for; ``known``: what was found before, far above which descents are given up."""
        self.problem, self.cap = problem, cap
        self.known, self.beyond = np.inf if known is None else known.optimum.factor, BEYOND
        self.exact = EXACT if problem.axis is not None else NEARLY

    @cached_property
    def _strips(self) -> Programme:
        return programme(self.problem, self.problem.dead, self.problem.live, self.cap, strips=True)

    @cached_property
    def _cones(self) -> Programme:
        return programme(self.problem, self.problem.dead, self.problem.live, self.cap).for_the_least()

    @cached_property
    def least_normal(self) -> np.ndarray | None:
        """The normal forces r'_n (P,) of least sum that bear the dead loads with any factor; the factor hardly counts in that sum.

        None where no factor is borne.
        """
        prices = np.zeros((self.problem.points.count, self.problem.directions))
        prices[:, 0] = LARGEST
        try:
            return normal_forces(self.problem, self._cones.priced(prices).solved(refined=False))
        except Unbounded:
            return None

    def mechanism_of(self, normal: np.ndarray, spread: float = SPREAD) -> np.ndarray:
        """The velocities (unknowns,) with w_1 . v = 1 of least g for forces with normal parts r'_n (P,), but for what strips share.

        Raises:
            Unbounded: there is none below the cap.
        """
        if self.problem.axis is None:
            joint = self.problem.points.joint
            mean = np.bincount(joint, normal) / np.maximum(np.bincount(joint), 1)
            normal = (1.0 - spread) * normal + spread * mean[joint]
        found = self._strips.within(self.problem.mu * normal).solved(refined=False)
        power = float(self.problem.live @ found.velocity)
        if power < NO_POWER:
            raise Unbounded("no mechanism below the largest factor that is looked for")
        return found.velocity / power

    def each(self, descend: Callable[[Any], Pair | None], begins: Sequence[Any]) -> list[Pair]:
        """The pairs of several descents, in their order, in as many threads as there are cores: solvers release Python's lock."""
        several = self.problem.points.count >= LARGE and len(begins) > 1
        if several:
            _ = self._strips, self._cones
        seen, found = _SEEN.get(), []
        seen(len(begins), 0)
        with ThreadPoolExecutor(cores()) if several else nullcontext() as threads:
            for end in threads.map(descend, begins) if threads is not None else map(descend, begins):
                seen(0, 1)
                found.append(end)
        return [end for end in found if end is not None]

    def descend_from(self, begin: Begin) -> Pair | None:
        """The end of a descent from where a start begins; None where that leads to no mechanism."""
        try:
            velocity = begin.velocity
            if velocity is None and begin.normal is not None:
                velocity = self.mechanism_of(begin.normal)
            return None if velocity is None else self.descend(velocity)
        except Unbounded:
            return None

    def descend(self, velocity: np.ndarray, begin: float = 1.0) -> Pair | None:
        """The pair of least factor on the way down from a mechanism (unknowns,) with w_1 . v = 1; None where none has a small g.

        ``begin`` is M_k of the first round: from LARGEST on, the descent stays close to its mechanism.
        """
        best: Pair | None = None
        for spread in (0.0,) if self.problem.axis is not None else (SPREAD, 0.0):
            try:
                for pair in self.pairs(velocity, begin, spread):
                    best = pair if best is None or pair[0].factor < best[0].factor else best
            except GivenUp:
                break
            except Unbounded:
                pass
            if best is not None or self.known < np.inf:
                break
        return best

    def pairs(self, velocity: np.ndarray, begin: float | np.ndarray, spread: float) -> Iterator[Pair]:
        """The pairs with a small g on the way down from a mechanism.

        Raises:
            Unbounded: no further answer of the solver.
        """
        penalty, loosened, least, near = np.full(self.problem.points.count, begin), 0, np.inf, None
        factor, gap, before = np.inf, np.inf, None
        for number in range(ROUNDS):
            asked = self._asked(velocity)
            found = self._forces(asked, penalty, before)
            power = self._power(velocity, found)
            if power <= IDLE * self.cap:
                return
            shares = self._gaps(asked, found) / power
            last, gap = (factor, gap), float(shares.sum())
            factor, normal, before = found.factor, normal_forces(self.problem, found), found
            if (number or np.min(begin) >= LARGEST) and factor > self.known + self.beyond * abs(self.known):
                raise GivenUp
            if gap <= self.exact:
                yield self._pair(found, velocity, gap)
            if factor >= least * (1.0 - LOWER):
                return
            if gap <= self.exact:
                least = factor
            penalty = np.minimum(GROWS * penalty, np.maximum(LARGEST, penalty))
            worst = shares[:-1] > WORST * gap
            penalty[worst] = np.minimum(FASTER * penalty[worst], MOST)
            if gap > self.exact and abs(factor - last[0]) <= STUCK * abs(factor) and gap > CLOSER * last[1]:
                if loosened == LOOSENED or self.known < np.inf:
                    return
                normal, penalty, before, loosened = self._loosened(normal), np.full(len(penalty), AGAIN), None, loosened + 1
            elif near is None and gap <= SETTLED:
                near = self.near(velocity)
                pair = near and self._of_neighbours(near, normal, penalty, spread)
                if pair:
                    yield pair
                    return
            velocity = self.mechanism_of(normal, spread)

    def near(self, velocity: np.ndarray) -> Neighbours | None:
        """The blocks that move and those that touch them, where these are few of many."""
        return neighbours(self.problem, velocity) if self.problem.points.count >= LARGE else None

    def among(self, near: Neighbours) -> Search:
        """A search among some blocks, with the same bounds."""
        search = Search(near.problem, self.cap)
        search.known, search.beyond, search.exact = self.known, self.beyond, self.exact
        return search

    def _of_neighbours(self, near: Neighbours, normal: np.ndarray, penalty: np.ndarray, spread: float) -> Pair | None:
        """The pair to which rounds among some blocks lead, None where they lead to none, or where no forces in all blocks belong to it."""
        search, best = self.among(near), None
        with suppress(Unbounded):
            for optimum, _ in search.pairs(search.mechanism_of(normal[near.points], spread), penalty[near.points], spread):
                best = optimum if best is None or optimum.factor < best.factor else best
        with suppress(Unbounded):
            return None if best is None else self.confirmed(near.of_all(best.velocity, self.problem.unknowns))
        return None

    def confirmed(self, velocity: np.ndarray) -> Pair | None:
        """The pair of a mechanism (unknowns,) with w_1 . v = 1; None where no forces belong to it.

        Raises:
            Unbounded: no answer of the solver.
        """
        asked = self._asked(velocity)
        found = self._forces(asked, np.full(self.problem.points.count, LARGEST), None)
        gap = float(self._gaps(asked, found).sum()) / self._power(velocity, found)
        return self._pair(found, velocity, gap) if gap <= self.exact else None

    def _pair(self, found: Optimum, velocity: np.ndarray, gap: float) -> Pair:
        """Forces with the mechanism that they were found for."""
        return replace(found, velocity=velocity, method=self._method), gap

    def _loosened(self, normal: np.ndarray) -> np.ndarray:
        """Normal forces r'_n (P,) after some rounds of strips alone."""
        for _ in range(STRIPS):
            found = self._strips.within(self.problem.mu * normal).solved(refined=False)
            normal = 0.5 * (normal + normal_forces(self.problem, found))
        return normal

    def _forces(self, asked: _Asked, penalty: np.ndarray, before: Optimum | None) -> Optimum:
        """The forces of least lambda + sum M_k g_k, with those of the round before for comparison.

        Raises:
            Unbounded: no answer of the solver.
        """
        most = float(penalty.max(initial=0.0))
        found = self._cones.priced(penalty[:, None] * asked.prices, most * asked.of_bars).solved()
        if before is not None:
            weights = np.append(penalty, most)
            cost, bound = (one.factor + float(weights @ self._gaps(asked, one)) for one in (found, before))
            if cost > bound + WORSE * abs(bound):
                raise Unbounded(f"{found.method}: forces that are known cost less")
        return found

    def _asked(self, velocity: np.ndarray) -> _Asked:
        """The coefficients of g for a mechanism (unknowns,)."""
        problem = self.problem
        moved = (problem.jacobian @ velocity).reshape(-1, problem.directions)
        opening = np.maximum(moved[:, 0], 0.0)
        prices = moved.copy()
        prices[:, 0] = opening + problem.mu * np.linalg.norm(moved[:, 1:], axis=1)
        longer, yields = problem.bars @ velocity, np.isfinite(problem.strength)
        slack = np.where(yields, -longer, np.maximum(-longer, 0.0))
        work = float(np.maximum(longer[yields], 0.0) @ problem.strength[yields])
        return _Asked(prices, slack, opening * np.maximum(problem.apex - problem.tension, 0.0), work)

    def _gaps(self, asked: _Asked, found: Optimum) -> np.ndarray:
        """The terms of g, (P + 1,): one for each point, and one for all ties."""
        lifted = found.force.copy()
        lifted[:, 0] += self.problem.apex
        of_points = np.maximum(np.sum(asked.prices * lifted, axis=1) - asked.least, 0.0)
        return np.append(of_points, max(float(asked.of_bars @ found.bars) + asked.yields, 0.0))

    def _power(self, velocity: np.ndarray, found: Optimum) -> float:
        """The power of the loads in a mechanism with w_1 . v = 1."""
        return abs(float(self.problem.dead @ velocity)) + abs(found.factor) + 1e-300

    @property
    def _method(self) -> str:
        return f"descent by {'linear programmes (HiGHS)' if self.problem.axis is not None else 'cone programmes (Clarabel)'}"


def normal_forces(problem: LimitProblem, found: Optimum) -> np.ndarray:
    """r'_n (P,)."""
    return np.maximum(found.force[:, 0] + problem.apex, 0.0)
