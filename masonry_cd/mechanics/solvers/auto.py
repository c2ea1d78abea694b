# SPDX-License-Identifier: GPL-3.0-or-later
"""One solver after the other, the cheap ones first, until the tolerance is reached.

1. The impulses of the last step are tried as they are: at rest they do again. After a step that moved it is ADMM that measures their error.
2. Packed grains, many contacts in space of which most are the only one between their two blocks, are swept. They have neighbours on all
   sides, which fills the factors of the other methods, but few contacts each, so that accelerated sweeps get far; where the scene accepts
   the error that these leave, the step ends.
3. ADMM carries the error through the whole structure at little cost, and solves most steps of structures that stand. How many iterations
   pay before the next method takes over is learnt: after a step that ADMM solved the next one may take FACTOR times as many, after one that
   the others solved a FACTOR-th, but no fewer than these took factorisations, each of which costs more. Some structures want a thousand
   and some hardly any. After a step that none solved it is all: the next one begins with impulses that are worse than usual.
4. Proximal points, by pivoting in a plane and by Newton's method in space, continue from the best so far: they solve what slides or rocks
   as a whole. Pivoting is not asked where friction is ROUGH. In space, where a factorisation may take long, they have as many of them as
   OPERATIONS pay for.
5. The interior point method begins near the impulses of the last step, not where the others got stuck, and ends nearly all that is left.
   Half of its way solves hardly anything: it has all of its factorisations, or, where OPERATIONS do not pay for them, none.
6. A problem without a step before, which is solved once, may take what each method takes by itself.

``python -m benchmarks.constants`` shows what each constant gains.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.mechanics.friction.solver_state import Learnt
from masonry_cd.mechanics.solvers import accelerated, admm, interior, newton, pivoting
from masonry_cd.mechanics.solvers.options import MOST_ITERATIONS, Options

GRAINS, SINGLE = 300, 2.0  # contacts at least, and contacts of a joint in the mean at most, of what is swept
SWEEPS = 4000
MOST, FACTOR = 1000, 4  # iterations of ADMM before the next method, and by what their number changes
ROUGH = 1.0  # friction above which there are several solutions, and pivoting from soft springs may end in one that moves
LAST = 700  # factorisations of the interior point method
OPERATIONS = 2e11  # of the factorisations of a method, at most: some ten seconds

METHODS = {"accelerated": accelerated, "admm": admm, "newton": newton, "pivoting": pivoting, "interior": interior}


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Solve by one method after the other.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` bounds the iterations of all methods together.
        start: its impulse (C, m) is the first iterate, its memory the one of the step before, and so are its iterations.
    """
    if problem.contacts == 0:
        return accelerated.solve(problem, options, start)
    progress, grains = _Progress(problem, options, start), touch_in_points(problem)
    if grains or not progress.moved:
        progress.measure()
    if grains:
        progress.run("accelerated", SWEEPS, progress.last)
        if progress.error <= options.accept:
            return progress.solution()
    cold, budget = start is None, progress.memory.learnt.budget or MOST
    progress.run("admm", budget, progress.last)
    if not progress.methods:  # as in the last step
        return progress.solution()
    if progress.ended:
        budget = min(FACTOR * budget, MOST)
    else:
        spent = _finish(progress, cold)
        budget = min(max(budget // FACTOR, spent, 1), MOST) if progress.error <= options.tolerance else MOST
    learnt = progress.memory.learnt
    if budget != learnt.budget:
        progress.memory = progress.memory.with_learnt(replace(learnt, budget=budget))
    return progress.solution()


def _finish(progress: _Progress, cold: bool) -> int:
    """The methods after ADMM, and their factorisations; without a step before all of them may take what they do by themselves."""
    before = progress.iterations
    if pivoting.applies(progress.problem) and progress.problem.mu.max() <= ROUGH:
        progress.run("pivoting", pivoting.LIMIT, progress.best)
    else:
        progress.run("newton", newton.LIMIT if cold else min(newton.LIMIT, progress.factorisations), progress.best)
    if not progress.ended and (cold or progress.factorisations >= LAST):
        progress.run("interior", interior.MOST if cold else LAST, progress.last)
    spent = progress.iterations - before
    if cold:  # nor is it left worse than by ADMM alone
        progress.memory = progress.memory.with_learnt(Learnt())
        progress.run("admm", admm.LIMIT, progress.last)
    return spent


class _Progress:
    """The best answer so far, and the way to it."""

    def __init__(self, problem: Problem, options: Options, start: Solution | None) -> None:
        self.problem, self.options = problem, options
        self.last = start or Solution(np.zeros((problem.contacts, problem.dimension)), None, 0)
        self.memory = self.last.memory
        self.best, self.iterations, self.methods = self.last, 0, list[str]()
        self.error = inf  # not measured

    @property
    def moved(self) -> bool:
        """Return True if the last step took iterations, so that its impulses will hardly do in this one."""
        return self.last.iterations > 0 and isinstance(self.problem, FrictionProblem)

    def measure(self) -> None:
        """Measure the error of the impulses to begin with."""
        self.error = natural_map_error(self.problem, self.last.impulse, threads=self.options.threads)

    @property
    def ended(self) -> bool:
        """Return True if the tolerance or the limit is reached."""
        return self.error <= self.options.tolerance or self.iterations >= self.options.limit(MOST_ITERATIONS)

    @property
    def factorisations(self) -> float:
        """How many of them OPERATIONS pay for; inf where nothing has been factorised yet."""
        factors, problem = self.memory.factors, self.problem
        if factors is None or not isinstance(problem, FrictionProblem):
            return inf
        return OPERATIONS // max(factors.pattern.operations(problem.unknowns), 1.0)

    def run(self, name: str, limit: float, begin: Solution) -> None:
        """Give a method a number of iterations at most, from the impulses of a solution, unless all has ended."""
        if self.ended or limit < 1:
            return
        limit = min(int(limit), self.options.limit(MOST_ITERATIONS) - self.iterations)
        options = Options(self.options.tolerance, limit, self.options.seed, self.options.threads)
        found = METHODS[name].solve(self.problem, options, Solution(begin.impulse, begin.velocity, 0, memory=self.memory))
        error = found.error
        if error is None:
            error = natural_map_error(self.problem, found.impulse, threads=self.options.threads)
        if error <= self.options.tolerance and found.iterations == 0 and not self.methods:
            self.error = error
            return
        self.memory = found.memory if found.memory.factors is not None else self.memory
        self.iterations += found.iterations
        self.methods.append(name)
        if error < self.error:
            self.best, self.error = found, error

    def solution(self) -> Solution:
        """The best answer, with the memory of all."""
        impulse, velocity = self.best.impulse, self.best.velocity
        if self.best is self.last:
            impulse, velocity = impulse.copy(), self.problem.body_velocity(impulse) if isinstance(self.problem, FrictionProblem) else None
        end = "converged" if self.error <= self.options.tolerance else f"missed, error {self.error:.1e}"
        reason = f"{' + '.join(self.methods) or 'as in the last step'}: {end}"
        return Solution(impulse, velocity, self.iterations, reason, self.memory, self.error)


def touch_in_points(problem: Problem) -> bool:
    """Return True if these are packed grains: many contacts in space, of which most are the only one between their two blocks."""
    if not isinstance(problem, FrictionProblem) or problem.dimension < 3 or problem.contacts < GRAINS:
        return False
    joints = 1 + int((problem.bodies[1:] != problem.bodies[:-1]).any(axis=1).sum())
    return problem.contacts < SINGLE * joints
