# SPDX-License-Identifier: GPL-3.0-or-later
r"""Coulomb friction that does not dilate, in space: a factor that belongs to it.

The sequence of :mod:`masonry_cd.analysis.limit.nonassociated` with circles for strips, |r_t| <= mu N_k (Portioli, Casapulla, Gilbert &
Cascini, Computers & Structures 142, 2014), and its descent: for the mechanism found, the forces of least lambda + M g,

    g(r, v) = sum over the points of  u_n (r_n + f) + mu r'_n |u_t| + r_t . u_t  and over the ties of  (N_y - N) G v, or -N G v where slack,

a cone programme too; the velocities of least g for forces r are those of the strips mu r'_n. Cone programmes are solved to a tolerance,
so g is small and not zero; it is reported.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from masonry_cd.analysis.limit.conic import (
    ConeProgramme,
    cone_programme,
    for_the_least,
    priced,
    solve_programme,
    solve_quickly,
    with_strips,
)
from masonry_cd.analysis.limit.nonassociated import LeastFound, Pair, least_of_starts
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Optimum, Unbounded

STEPS = 20  # of the sequence at most
SETTLED = 5e-3  # change of the factor, as a share of it, at which the sequence ends: the descent behind it takes longer steps
ROUNDS = 8  # of the descent at most
LOWER = 2e-3  # share of the factor that a round of the descent takes off at least
AGAIN = 0.5  # blend of the sequence with which a start goes on whose descent came to no end
CLOSER = 0.9  # of the gap of the round before, at most, in a round that ends in no pair
PENALTY = 100.0  # M, over w_1 . v = 1
NEARLY = 1e-3  # g of a pair that counts, as a share of the power of the loads
NO_POWER = 1e-3  # w_1 . v of a strip programme below which its factor is the cap: it is 1 elsewhere
MOST = 10.0  # times the associated factor: the largest that is looked for


def least_factor_in_space(problem: LimitProblem, associated: Optimum, starts: int, seed: int, first: int = 0) -> LeastFound | None:
    """The least factor that the starts come to, None where none ends in a pair with a small g; arguments as of ``least_factor``, and the
    number of the first start that is made."""
    programmes = SearchInSpace(problem, MOST * max(abs(associated.factor), 1e-3))

    def search(normal: np.ndarray, blend: float) -> Pair | None:
        try:
            end = programmes.descend(programmes.sequence(normal, blend))
            return end or programmes.descend(programmes.sequence(programmes.normal, AGAIN))
        except Unbounded:
            return None

    def least_normal() -> np.ndarray | None:
        try:
            return programmes.least_normal()
        except Unbounded:
            return None

    return least_of_starts(search, (_normal(problem, associated), least_normal), starts, seed, first)


class SearchInSpace:
    """The cone programmes of the two moves, of P points and T ties; what they have in common is set up once."""

    def __init__(self, problem: LimitProblem, cap: float) -> None:
        """``cap``: the largest factor that is looked for."""
        self.problem = problem
        self.normal = np.zeros(problem.points.count)  # r'_n of the last forces that a descent found
        self._programme = partial(cone_programme, problem, problem.dead, problem.live, cap)

    @cached_property
    def _strips(self) -> ConeProgramme:
        return self._programme(np.zeros(self.problem.points.count))

    @cached_property
    def _cones(self) -> ConeProgramme:
        return for_the_least(self.problem, self._programme())

    def least_normal(self) -> np.ndarray:
        """The normal forces r'_n (P,) of least sum that bear the dead loads with any factor, which weighs next to nothing beside them."""
        prices = np.zeros((self.problem.points.count, 3))
        prices[:, 0] = PENALTY
        return _normal(self.problem, solve_quickly(self.problem, priced(self.problem, self._cones, prices)))

    def sequence(self, normal: np.ndarray, blend: float) -> np.ndarray:
        """The velocities of the sequence from normal forces r'_n (P,)."""
        last = np.inf
        for _ in range(STEPS):
            found = self._within_strips(normal)
            if abs(found.factor - last) <= SETTLED * abs(found.factor):
                break
            last = found.factor
            normal = blend * normal + (1.0 - blend) * _normal(self.problem, found)
        return _with_power(self.problem, found)

    def descend(self, velocity: np.ndarray) -> Pair | None:
        """The least pair from a mechanism (unknowns,) with w_1 . v = 1, None where none has a small g.

        By turns the forces of least lambda + M g for a mechanism are found, and the mechanism of least g for these forces.
        """
        best: Pair | None = None
        last = np.inf
        for _ in range(ROUNDS):
            pair = self._forces(velocity)
            optimum, gap = pair
            self.normal = _normal(self.problem, optimum)
            if gap > NEARLY and (best is not None or gap > CLOSER * last):
                break
            before, last = best, gap
            if gap <= NEARLY:
                best = min((each for each in (best, pair) if each is not None), key=lambda each: each[0].factor)
            if before is not None and optimum.factor >= before[0].factor * (1.0 - LOWER):
                break
            found = self._within_strips(self.normal)
            if float(self.problem.live @ found.velocity) < NO_POWER:
                break
            velocity = _with_power(self.problem, found)
        return best

    def _within_strips(self, normal: np.ndarray) -> Optimum:
        """The largest factor where the friction at each point is that of given normal forces (P,)."""
        return solve_quickly(self.problem, with_strips(self._strips, self.problem.mu * normal))

    def _forces(self, velocity: np.ndarray) -> Pair:
        """The forces of least lambda + M g for a mechanism, and g over the power of the loads."""
        problem = self.problem
        moved = (problem.jacobian @ velocity).reshape(-1, 3)
        size = np.linalg.norm(moved[:, 1:], axis=1)
        prices = moved.copy()
        prices[:, 0] = np.maximum(moved[:, 0], 0.0) + problem.mu * size
        longer, yields = problem.bars @ velocity, np.isfinite(problem.strength)
        slack = np.where(yields, -longer, np.maximum(-longer, 0.0))
        found = solve_programme(problem, priced(problem, self._cones, PENALTY * prices, PENALTY * slack))
        lifted = found.force + np.stack([problem.apex, 0.0 * problem.apex, 0.0 * problem.apex], axis=1)
        least = float(np.maximum(moved[:, 0], 0.0) @ np.maximum(problem.apex - problem.tension, 0.0))
        least -= float(np.maximum(longer[yields], 0.0) @ problem.strength[yields])
        power = abs(float(problem.dead @ velocity)) + abs(found.factor) + 1e-300
        pair = replace(found, velocity=velocity, method="sequence of cone programmes (Clarabel)")
        return pair, abs(float(np.sum(prices * lifted)) + float(slack @ found.bars) - least) / power


def _normal(problem: LimitProblem, found: Optimum) -> np.ndarray:
    """r'_n (P,)."""
    return np.maximum(found.force[:, 0] + problem.apex, 0.0)


def _with_power(problem: LimitProblem, found: Optimum) -> np.ndarray:
    """The velocities of an optimum, with w_1 . v = 1.

    Raises:
        Unbounded: they have no power, as those of blocks that are held.
    """
    power = float(problem.live @ found.velocity)
    if power < NO_POWER:
        raise Unbounded("no mechanism below the largest factor that is looked for")
    return found.velocity / power
