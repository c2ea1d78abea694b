"""What steps cost, counted and not timed: equal on every machine, so that a table shows how uneven the steps of a run are.

A step counts with what the methods did in it, iterations by the weights of ``auto``, and with a constant per contact for all else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from unittest.mock import patch

import numpy as np

from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.solvers import Options, accelerated, admm, auto, interior, newton, nlgs, pivoting

BESIDE = 0.6  # of a step for each contact: detection, assembly, update and account [us]


@dataclass
class CountedCost:
    """Costs of steps in microseconds of the machine that the weights of ``auto`` were fitted on."""

    steps: list[float] = field(default_factory=list)
    _now: float = 0.0

    def end_step(self, contacts: int) -> None:
        """Take in a step with so many contacts."""
        self.steps.append(self._now + BESIDE * contacts)
        self._now = 0.0

    @property
    def worst(self) -> float:
        """That of the most expensive step in times of the median, but for the first one, which starts cold; 1 without any other."""
        costs = np.array(self.steps[1:])
        return float(costs.max() / np.median(costs)) if len(costs) and costs.max() > 0.0 else 1.0

    def add(self, weight: float, iterations: int) -> None:
        """Count iterations."""
        self._now += weight * iterations


@contextmanager
def counted() -> Iterator[CountedCost]:
    """Count what the methods do while the body runs; the body ends the steps."""
    cost = CountedCost()

    def watched(solve: Callable[..., Solution], weight: Callable[[FrictionProblem, Pattern], float]) -> Callable[..., Solution]:
        def call(problem: FrictionProblem, options: Options, start: Solution | None = None) -> Solution:
            found = solve(problem, options, start)
            if found.iterations:
                last = admm.Memory.read(found.memory) or admm.Memory.read(start.memory if start else {})
                cost.add(weight(problem, _pattern(problem, start) if last is None else last.pattern), found.iterations)
            return found

        return call

    by_method = (  # pivoting in space leaves a problem to the interior point method, which counts by itself: auto asks it in a plane alone
        (admm, lambda problem, pattern: float(auto.work(problem, pattern) @ auto.ITERATION[auto.ADMM])),
        (newton, lambda problem, pattern: float(auto.work(problem, pattern) @ auto.ITERATION[auto.NEWTON])),
        (interior, lambda problem, pattern: float(auto.work(problem, pattern) @ auto.ITERATION[auto.NEWTON])),
        (pivoting, lambda problem, pattern: float(auto.work(problem, pattern) @ auto.ITERATION[auto.NEWTON])),
        *((sweeps, lambda problem, pattern: auto.sweep(problem)) for sweeps in (nlgs, accelerated)),
    )
    with ExitStack() as stack:
        for method, weight in by_method:
            stack.enter_context(patch.object(method, "solve", watched(method.solve, weight)))
        yield cost


def _pattern(problem: FrictionProblem, start: Solution | None) -> Pattern:
    """The pattern of a factorisation, made for the count."""
    return admm.recall(problem.arrays(), start)[0].pattern
