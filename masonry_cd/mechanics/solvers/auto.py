"""Picks the solver by what the last steps cost, and continues with another one where it gets stuck.

**The rule.**

1. The impulses of the last step are tried as they are: at rest they do again. The error that they leave adds up from step to step, so a
   step that begins close to the solution (NEARLY) is solved DEEPER than asked, and so is the next, in at most DEEP_LIMIT iterations: ten
   more, for thousands of steps that then need none. Where the step after it begins beyond the tolerance all the same, as in a structure
   that sways, that was in vain, and only every LOOK-th step is tried so. Where the last start was FAR off, only every LOOK-th is measured.
2. A step begins with ADMM or with Newton's method, whichever cost less when a step last began with it. An ADMM iteration propagates the
   error through the whole structure and is cheap; a Newton iteration is expensive, but few are needed if it starts close. Steps 4, 16, 64,
   256 ... begin with the other one, unless a single iteration of it costs more than a step of the first. What ADMM does not solve at the
   cost of GLANCE iterations of Newton, nor Newton in NEWTON_LIMIT, passes to the other one. After a step that Newton did not end it is
   not asked, but in every LOOK-th step. Where the error is then CLOSE to the tolerance ADMM goes on, for as long as it gets on, to the cost
   of WORTH iterations of Newton: it creeps to 1e-3 at a tenth of what other methods take, but hardly ever to 1e-8.
3. What neither solves (a structure that slides or rocks as a whole) goes to pivoting if it is in a plane and not ROUGH, and to the interior
   point method, which comes first from nothing.
   Both start near the impulses of the last step, not where the others got stuck, within a BUDGET; then comes Newton again. Structures slide
   for many steps: after a step that these solved (but for the first of all, which begins without impulses) at a cost that rule 5 allows
   they come first; and every LOOK-th step begins as usual, to see whether the sliding is over, but ADMM does not go on in it.
4. Packed grains have neighbours on all sides, which fills the factors, but few contacts each, so that accelerated sweeps get far. From
   GRAINS contacts on, where most pairs of blocks touch in a single point, a step begins with them, in GRAIN_TURNS turns of GRAIN_TURN
   sweeps. With much friction these creep or go round in circles: between two turns that end CLOSE Newton has one, at no more than their
   cost, if it ended the last step that it was asked in, and in every LOOK-th step. What they leave goes the way of 2 and 3 only where the
   scene does not accept it: no method gets far.
5. A step that has cost PATIENCE times what steps usually do, and more than is CHEAP, ends where its error is small enough for the scene to
   accept (``run.accept``). It counts as one that missed its tolerance. What a method costs that begins for a trial is not the step's.

**Costs** are counted, not timed: contacts, and operations by the pattern of the factorisation, each with a weight. The choice, and with it
every bit of the result, is then the same on every machine. ``python -m benchmarks.constants`` shows what each constant gains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from math import nan

import numpy as np

from masonry_cd.mechanics.friction.local_blocks import in_elimination_order, local_arrays
from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.solvers import accelerated, admm, interior, newton, pivoting
from masonry_cd.mechanics.solvers.options import MOST_ITERATIONS, Options

ADMM, NEWTON, INTERIOR, ACCELERATED, PIVOTING = 0, 1, 2, 3, 4
METHODS = (admm, newton, interior, accelerated, pivoting)
NAMES = ("admm", "newton", "interior", "accelerated", "pivoting")

LAST = (INTERIOR, PIVOTING)  # methods for structures that slide or rock as a whole

# At rest. Errors are natural map errors, as multiples of the tolerance.
NEARLY = 10.0  # error at the start below which a step is solved deeper than asked
DEEPER = 1e-4  # error down to which it is solved
AGAIN = 10.0  # times that error: at which the impulses of a step solved deeper do for the next one; from farther it is solved deeper too
DEEP_LIMIT = 60  # iterations for that; most steps need ten more than usual
ROUNDING = 1e-13  # natural map error, not a multiple, that is not worth reaching for
FAR = 1e3  # error at the last start looked at, above which only every LOOK-th start is measured: a measurement costs an iteration or two
LOOK = 8  # steps

# Which of ADMM and Newton comes first.
TRIALS = tuple(4**k for k in range(1, 16))  # steps that begin with the other one

# Limits of a turn, in iterations.
GLANCE = 10.0  # of Newton, at whose cost ADMM is left at first: what costs more Newton may do for less
CLOSE = 100.0  # error, in tolerances, from which ADMM goes on
WORTH = 120.0  # and at whose cost it is given up: what the interior point method's first start may cost
NEWTON_LIMIT = 16

# Packed grains.
GRAINS = 300  # contacts; with fewer all methods are cheap
SINGLE = 2.0  # contacts of a joint in the mean, below which they touch in points
GRAIN_TURNS, GRAIN_TURN = 4, 1000  # turns, and sweeps of each; after a turn an error may do, see PATIENCE

# What a step may cost.
PATIENCE = 8.0  # times the usual cost of a step, after which an error will do that the scene accepts
CHEAP = 1e5  # a tenth of a second, which a step may always cost
RATE, MORE = 1 / 16, 3.0  # of what is learnt about the usual cost from a step, and the most that it counts, in times of it

ROUGH = 1.0  # friction above which pivoting is not asked: there are several solutions, and from soft springs it may end in one that moves

# Costs, in microseconds on the machine of the fit: of a call of ADMM and of Newton, and of an iteration, by what :func:`work` counts, by
# ``benchmarks.costs`` fitted to 14 shaken scenes of 1 to 5,008 blocks in a plane and in space. They meet most of what was measured to 15 %.
# New factors and measurements of the error are in the iterations.
CALL = ((35.0, 0.02, 0.01, 0.0), (22.0, 0.0, 0.0074, 0.0))
ITERATION = ((3.3, 0.014, 0.001, 0.0), (0.2, 0.049, 0.019, 1.3e-4))
Costs = tuple[float, float, float, float]  # of an iteration of ADMM and of Newton, and of a call
SWEEP = 0.002  # of an accelerated sweep for an entry of H on one side
BUDGET = 1e6  # that the interior point method may spend on a step, but for its first start: about a second
COLD_BUDGET = 1e7  # for a problem without a step before, which is solved once


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Solve by the method that promises to be cheapest, then by the others.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` bounds the iterations of all methods together.
        start: its impulse (C, m) is the first iterate, its memory the one of the step before.
    """
    if problem.contacts == 0:
        return accelerated.solve(problem, options, start)
    known, deeper = Experience.recall(start), max(DEEPER * options.tolerance, ROUNDING)
    error = np.inf
    if start is not None and (known.error <= FAR * options.tolerance or known.steps % LOOK == 0):
        error = known.error = natural_map_error(problem, start.impulse, threads=options.threads)
        known.in_vain = error > options.tolerance if known.deeper else known.in_vain
        if error <= (AGAIN * deeper if known.deeper else options.tolerance):
            known.deeper = False
            velocity = problem.body_velocity(start.impulse) if isinstance(problem, FrictionProblem) else None
            return Solution(start.impulse.copy(), velocity, 0, "as in the last step: converged", known.beside(start.memory), error)
    search = _Search(problem, options, start, known.allowance())
    if touch_in_points(problem):
        known.deeper = False
        _solve_grains(search, known)
    if search.ended:
        known.learn(ADMM, (0.0, 0.0), search.cost)
    else:
        _solve_by_factors(search, known, start, error)
    return search.solution(known)


def _solve_grains(search: _Search, known: Experience) -> None:
    """Give accelerated sweeps their turns, and between them Newton, which may cost as much.

    Newton's pattern is made anew in each step, of the contacts that there are: that of all that ever touched would fill up.
    """
    problem, options = search.problem, search.options
    search.turn(ACCELERATED, GRAIN_TURN)
    if search.ended:
        return
    limit = 0
    if not known.stalls or known.steps % LOOK == 0:
        search.costs, search.memory = _costs(problem, known, None)
        limit = min(int(GRAIN_TURN * sweep(problem) / search.costs[NEWTON]), NEWTON_LIMIT)
    for _ in range(GRAIN_TURNS - 1):
        if limit and search.error <= CLOSE * options.tolerance:
            search.turn(NEWTON, limit)
        search.turn(ACCELERATED, GRAIN_TURN)
    known.stalls = known.stalls if search.stalled is None else search.stalled
    search.accepted |= search.error <= options.accept


def _solve_by_factors(search: _Search, known: Experience, start: Solution | None, error: float) -> None:
    """Give the methods that factorise their turns; ``error`` is that of the start, where it was measured."""
    problem, options = search.problem, search.options
    search.costs, search.memory = costs, _ = _costs(problem, known, start)
    nearly = error <= NEARLY * options.tolerance and not search.iterations[ACCELERATED] and not (known.in_vain and known.steps % LOOK)
    known.deeper = nearly and error > options.tolerance
    usual = not known.slides or known.steps % LOOK == 0
    wanted = known.first()
    opening, hard = openings(wanted, costs, known), partial(turns, problem, costs, start is None)
    first, limit = opening[0]
    search.on_trial = first if usual and first == wanted != known.cheaper() else None
    if nearly:
        search.turn(first, min(limit, DEEP_LIMIT), max(DEEPER * options.tolerance, ROUNDING))
        opening = [turn for turn in opening if turn[0] != NEWTON or not search.stalled]
    search.turns(opening if usual else hard())
    if usual and not known.slides and search.error <= CLOSE * options.tolerance:
        search.turn(ADMM, iterations_worth(WORTH, costs))
    if not search.ended:
        search.turns(hard() if usual else opening)
    if usual:
        known.slides = known.steps > 0 and search.asked_last and search.solved_at_a_usual_cost
        known.stalls = known.stalls if search.stalled is None else search.stalled
    known.learn(first, [spent(costs, method, search.iterations[method]) for method in (ADMM, NEWTON)], search.cost)


@dataclass(slots=True)
class Experience:
    """What is learnt from step to step; the memory of a solution carries it."""

    cost: list[float] = field(default_factory=lambda: [nan, nan])  # of the last step begun with ADMM and with Newton, nan if there was none
    steps: int = 0  # that needed iterations
    contacts: int = -1  # for which the costs of calls and iterations were counted
    costs: Costs = (0.0, 0.0, 0.0, 0.0)
    deeper: bool = False  # whether the last step was solved deeper than asked, because it began close to the solution
    error: float = 0.0  # at the last start looked at
    slides: bool = False  # whether one of the LAST methods solved the last step begun as usual, not the first, at a usual cost
    stalls: bool = False  # whether Newton did not end the last step in which it had a turn before them
    usual: float = 0.0  # cost of a step, where one that costs more is counted as MORE times as much; 0: none but the first was solved
    in_vain: bool = False  # whether the step after the last one solved deeper began beyond the tolerance

    @classmethod
    def recall(cls, start: Solution | None) -> Experience:
        """That of the step before, or a new one."""
        if start is None or "auto_tally" not in start.memory:
            return cls()
        admm_cost, newton_cost, steps, contacts, *costs, deeper, error, slides, stalls, usual, vain = start.memory["auto_tally"].tolist()
        counted, flags = (costs[0], costs[1], costs[2], costs[3]), (bool(slides), bool(stalls), usual, bool(vain))
        return cls([admm_cost, newton_cost], int(steps), int(contacts), counted, bool(deeper), error, *flags)

    def beside(self, memory: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The memory of the methods, and this one (14,)."""
        learnt = (self.deeper, self.error, self.slides, self.stalls, self.usual, self.in_vain)
        return memory | {"auto_tally": np.array((*self.cost, self.steps, self.contacts, *self.costs, *learnt), dtype=float)}

    def first(self) -> int:
        """The method to begin with: the cheaper one; in a trial the other, unless a single iteration of it costs more than the step."""
        cheaper = self.cheaper()
        hopeless = spent(self.costs, 1 - cheaper, 1) > self.cost[cheaper]
        return 1 - cheaper if self.steps in TRIALS and not hopeless else cheaper

    def cheaper(self) -> int:
        """The method that cost less when a step last began with it."""
        return NEWTON if self.cost[NEWTON] < self.cost[ADMM] else ADMM

    def allowance(self) -> float:
        """What a step may cost whose error is small enough to be accepted."""
        return max(PATIENCE * self.usual, CHEAP) if self.usual else np.inf

    def learn(self, first: int, costs: Sequence[float], whole: float) -> None:
        """Take in what ADMM and Newton cost in a step, and the ``whole`` of it.

        If the other one of the two had to help, that is a first guess of its cost in its own turn.
        """
        other = 1 - first
        if self.steps > 0:  # the first one starts cold
            self.usual += RATE * (min(whole, MORE * self.usual) - self.usual) if self.usual else whole
        self.steps += 1
        if sum(costs) > 0.0:  # else nothing happened
            self.cost[first] = sum(costs)
        if costs[other] > 0.0 and not costs[other] > self.cost[other]:
            self.cost[other] = costs[other]


class _Search:
    """The best answer so far, and the way to it."""

    def __init__(self, problem: Problem, options: Options, start: Solution | None, allowance: float) -> None:
        self.problem, self.options, self.allowance = problem, options, allowance
        self.memory: dict[str, np.ndarray] = {} if start is None else start.memory
        self.costs: Costs = (0.0, 0.0, 0.0, 0.0)  # until a method that factorises has its turn
        self.start, self.best = start or Solution(np.zeros((problem.contacts, problem.dimension)), None, 0), start
        self.error, self.accepted = np.inf, False
        self.stalled: bool | None = None  # whether Newton, where it had a turn before the LAST, did not end the step
        self.iterations = [0] * len(METHODS)  # by method
        self.on_trial: int | None = None  # the method that begins the step for a trial
        self.story: list[str] = []

    @property
    def ended(self) -> bool:
        """Whether the tolerance or a limit is reached."""
        return self.accepted or self.error <= self.options.tolerance or sum(self.iterations) >= self.options.limit(MOST_ITERATIONS)

    @property
    def asked_last(self) -> bool:
        """Whether one of the methods for structures that slide or rock as a whole had a turn."""
        return any(self.iterations[method] for method in LAST)

    @property
    def cost(self) -> float:
        """What all turns cost so far."""
        admm, newton, interior, sweeps, pivoting = self.iterations
        cost = spent(self.costs, ADMM, admm) + spent(self.costs, NEWTON, newton + interior + pivoting)
        return cost + sweeps * sweep(self.problem) if sweeps else cost

    @property
    def of_the_step(self) -> float:
        """What the turns cost but for a trial, which the steps after it gain by."""
        return self.cost if self.on_trial is None else self.cost - spent(self.costs, self.on_trial, self.iterations[self.on_trial])

    @property
    def solved_at_a_usual_cost(self) -> bool:
        """Whether the tolerance is reached, for what is allowed to a step whose error will do."""
        return self.error <= self.options.tolerance and self.of_the_step <= self.allowance

    def enough(self, method: int) -> int:
        """Iterations of a method until the step has cost what is allowed."""
        each = self.costs[ADMM] if method == ADMM else sweep(self.problem) if method == ACCELERATED else self.costs[NEWTON]
        return int(min(max(self.allowance - self.of_the_step, 0.0) / each, MOST_ITERATIONS))

    def turns(self, plan: list[tuple[int, int]]) -> None:
        """Give methods with their limits of iterations their turns, one after the other."""
        for method, limit in plan:
            if self.ended:
                return
            self.turn(method, limit)

    def turn(self, method: int, limit: int, tolerance: float | None = None) -> None:
        """Give a method its turn, from the best impulses so far; the LAST from those of the step before, unless sweeps were made.

        Where the error will do, it has no more than the step is allowed.
        """
        if self.ended:
            return
        tolerance = self.options.tolerance if tolerance is None else tolerance
        enough = self.enough(method) if method in LAST or self.error <= self.options.accept else MOST_ITERATIONS
        if self.error <= self.options.accept:
            limit = min(limit, enough)
            if limit < (interior.TURN if method in LAST else 1):
                self.accepted = True
                return
        if self.options.max_iterations is not None:
            limit = min(limit, self.options.max_iterations - sum(self.iterations))
        begin = self.start if method in LAST and not self.iterations[ACCELERATED] else self.best or self.start
        begin = Solution(begin.impulse, begin.velocity, 0, memory=self.memory)
        options = Options(tolerance, limit, self.options.seed, self.options.threads, self.options.accept, enough)
        found = METHODS[method].solve(self.problem, options, begin)
        self.memory = found.memory or self.memory
        self.iterations[method] += found.iterations
        self.story.append(NAMES[method])
        error = natural_map_error(self.problem, found.impulse, threads=self.options.threads)
        if method == NEWTON and not self.asked_last:
            self.stalled = error > self.options.tolerance
        if error < self.error or self.best is None:
            self.best, self.error = found, error

    def solution(self, known: Experience) -> Solution:
        """The best answer, with the memory of all."""
        assert self.best is not None
        tried = " + ".join(self.story[:5]) + (" and so on" if len(self.story) > 5 else "")
        end = "converged" if self.error <= self.options.tolerance else f"missed, error {self.error:.1e}"
        reason, memory = f"{tried}: {end}", known.beside(self.memory)
        return Solution(self.best.impulse, self.best.velocity, sum(self.iterations), reason, memory, self.error)


def spent(costs: Costs, method: int, iterations: int) -> float:
    """Cost of a call of ADMM or Newton and its iterations."""
    return costs[2 + method] + iterations * costs[method] if iterations else 0.0


def sweep(problem: Problem) -> float:
    """Cost of an accelerated sweep."""
    return SWEEP * max(entries(problem), 1)


def work(problem: Problem, pattern: Pattern) -> np.ndarray:
    """Work of a call or an iteration, (4,): one; contacts; entries of H on one side, or a third of those of W, with which less is done;
    operations of a factorisation divided by the unknowns per body, or contact."""
    n, share = (problem.unknowns, 1.0) if isinstance(problem, FrictionProblem) else (problem.dimension, 1.0 / 3.0)
    return np.array([1.0, problem.contacts, share * entries(problem), pattern.operations(n) / n])


def touch_in_points(problem: Problem) -> bool:
    """Whether these are packed grains: many contacts in space, of which most are the only one between their two blocks."""
    if not isinstance(problem, FrictionProblem) or problem.dimension < 3 or problem.contacts < GRAINS:
        return False
    joints = 1 + int((problem.bodies[1:] != problem.bodies[:-1]).any(axis=1).sum())
    return problem.contacts < SINGLE * joints


def entries(problem: Problem) -> int:
    """Number of entries of H on one side, or of W."""
    if isinstance(problem, FrictionProblem):
        return problem.contacts * problem.dimension * problem.unknowns
    return int(problem.w.nnz)


def openings(first: int, costs: Costs, known: Experience) -> list[tuple[int, int]]:
    """How a step begins: ADMM and Newton with their limits of iterations, in their order."""
    both = [(ADMM, iterations_worth(GLANCE, costs)), (NEWTON, NEWTON_LIMIT)]
    if known.stalls and known.steps % LOOK:
        return both[:1]
    return both if first == ADMM else both[::-1]


def iterations_worth(newton: float, costs: Costs) -> int:
    """Iterations of ADMM that cost as much as some of Newton."""
    return max(int(newton * costs[NEWTON] / costs[ADMM]), 1)


def turns(problem: Problem, costs: Costs, cold: bool) -> list[tuple[int, int]]:
    """How it goes on if that does not solve it: methods with their limits of iterations, in their order.

    Args:
        problem: to be solved.
        costs: of ADMM and Newton.
        cold: whether there is no step before.
    """
    budget = COLD_BUDGET if cold else BUDGET
    one_start = interior.affordable(0.0)  # iterations
    pivots = [(PIVOTING, one_start)] if pivoting.applies(problem) and problem.mu.max() <= ROUGH else []
    if cold and pivots:  # from nothing the interior point method mostly needs one start, and half as many factorisations
        pivots = [(INTERIOR, one_start), *pivots]
    return [*pivots, (INTERIOR, interior.affordable(budget / costs[NEWTON])), (NEWTON, NEWTON_LIMIT)]


def _costs(problem: Problem, known: Experience, start: Solution | None) -> tuple[Costs, dict[str, np.ndarray]]:
    """Costs by the pattern of the last step's factorisation, counted anew only when the number of contacts changes; and the memory to begin
    with, which holds the pattern if it had to be made for that."""
    memory = {} if start is None else start.memory
    if known.contacts != problem.contacts:
        if not isinstance(problem, FrictionProblem):
            _, pattern = in_elimination_order(local_arrays(problem)[0])
        else:
            last = admm.Memory.read(memory)
            if last is None:
                last, *_ = admm.recall(problem.arrays(), start)
                memory = memory | last.arrays()
            pattern = last.pattern
        known.contacts, known.costs = problem.contacts, tuple(np.sum(np.array(ITERATION + CALL) * work(problem, pattern), axis=1).tolist())
    return known.costs, memory
