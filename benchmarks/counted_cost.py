# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of steps, counted and not timed: equal on every machine, so that a table shows how uneven the steps of a run are.

A step counts with what the methods did in it, and with a constant per contact for all else. An iteration counts by contacts, entries of H
and operations of a factorisation; the weights were fitted to the processor time of ADMM and of Newton's steps in 14 shaken scenes of 1 to
5,008 blocks in a plane and in space, and meet most of it to 15 %.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from unittest.mock import patch

import numpy as np

from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.solvers import Options, accelerated, admm, interior, newton, nlgs, pivoting
from masonry_cd.mechanics.solvers.recall import recall

OUTSIDE_SOLVER = 0.6  # of a step for each contact: detection, assembly, update and account [us]
ADMM = (3.3, 0.014, 0.001, 0.0)  # of an iteration, by what :func:`work` counts [us]
LINEARISED = (0.2, 0.049, 0.019, 1.3e-4)
SWEEP = 0.002  # for each entry of H on one side, or of W [us]


def entries(problem: Problem) -> int:
    """Number of entries of H on one side, or of W."""
    if isinstance(problem, FrictionProblem):
        return problem.contacts * problem.dimension * problem.unknowns
    return int(problem.w.nnz)


def work(problem: Problem, pattern: Pattern) -> np.ndarray:
    """Work of an iteration, (4,): one; contacts; entries of H on one side, or a third of those of W, with which less is done; operations of
    a factorisation divided by the unknowns per body, or contact."""
    n, share = (problem.unknowns, 1.0) if isinstance(problem, FrictionProblem) else (problem.dimension, 1.0 / 3.0)
    return np.array([1.0, problem.contacts, share * entries(problem), pattern.operations(n) / n])


def cost_of(method: str, problem: Problem, found: Solution) -> float:
    """Return the cost of the iterations of a method [us]."""
    if not found.iterations:
        return 0.0
    if method in ("nlgs", "accelerated"):
        return found.iterations * SWEEP * entries(problem)
    return found.iterations * float(work(problem, _pattern(problem, found)) @ (ADMM if method == "admm" else LINEARISED))


def _pattern(problem: Problem, found: Solution) -> Pattern:
    """The pattern of the factorisation, made for the count where the solution has none."""
    factors = found.memory.factors
    return recall(problem, None).factors.pattern if factors is None else factors.pattern


@dataclass
class CountedCost:
    """Costs of steps in microseconds of the machine that the weights were fitted on."""

    steps: list[float] = field(default_factory=list)
    _now: float = 0.0

    def end_step(self, contacts: int) -> None:
        """Take in a step with a given number of contacts."""
        self.steps.append(self._now + OUTSIDE_SOLVER * contacts)
        self._now = 0.0

    @property
    def worst(self) -> float:
        """That of the most expensive step in times of the median, but for the first one, which starts cold; 1 without any other."""
        costs = np.array(self.steps[1:])
        return float(costs.max() / np.median(costs)) if len(costs) and costs.max() > 0.0 else 1.0

    def add(self, cost: float) -> None:
        """Count what iterations cost [us]."""
        self._now += cost


@contextmanager
def counted() -> Iterator[CountedCost]:
    """Count what the methods do while the body runs; the body ends the steps.

    Pivoting in space leaves a problem to the interior point method, which counts by itself: ``auto`` asks it in a plane alone.
    """
    cost = CountedCost()

    def watched(solve: Callable[..., Solution], method: str) -> Callable[..., Solution]:
        def call(problem: FrictionProblem, options: Options, start: Solution | None = None) -> Solution:
            found = solve(problem, options, start)
            cost.add(cost_of(method, problem, found))
            return found

        return call

    with ExitStack() as stack:
        for method in (admm, newton, interior, pivoting, nlgs, accelerated):
            name = method.__name__.rpartition(".")[2]
            stack.enter_context(patch.object(method, "solve", watched(method.solve, name)))
        yield cost
