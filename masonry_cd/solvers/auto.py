"""Picks the solver by what the last steps cost, and goes on with another one where it gets stuck.

**Order.** An ADMM iteration propagates the error through the whole structure and is cheap; a Newton iteration is expensive but few are
needed, also where much slides or lifts off, if it starts close. So a step begins with the one that did better in the steps before (ADMM at
first; the other one is tried again now and then), within a limit at which the other would surely have been cheaper, and goes on with the
other. What neither solves (a structure that slides or rocks as a whole) goes to the interior point method, which starts near the impulses
of the last step, not where the others got stuck, and from there to Newton again; a local problem then to long runs of ADMM and Newton.
While a structure slides or rocks this happens in step after step; then the interior point method comes first, and only every LOOK-th step
begins as usual, to see whether it is over.

**At rest.** First the impulses of the last step are tried as they are: at rest they may do again, and then nothing else is done. The error
that they leave adds up from step to step, so a step that begins close to the solution (NEARLY) is solved DEEPER than asked: ten iterations
more, for thousands of steps that then need none. So is the step after it, since the impulses of the first one also had to stop the motion
that was left.

**Packed grains** have neighbours on all sides, which fills the factors, but few contacts each, so that sweeps of Gauss-Seidel get far.
Where thousands of them cost less than half of the interior point method's first start, they and Newton come after it, and then it goes on
from there; before it if it costs far more than a step may, and in place of Newton's first turn if that costs more than they do. A settled
packing of 945 spheres with 2,046 contacts: 450 iterations of the interior point method end at 5e-4 after 6 s, 3,000 sweeps at 5e-5 after
0.2 s. A problem without a step before, which is solved once, gets LONG sweeps at the end.

**Trials.** A method that has not run for a while warms up in a few steps: Newton finds out how stiff it may begin, ADMM's factors and k are
out of date. So a trial goes on, for up to WARM steps, as long as each is cheaper than the one before, and its last one counts.

**Costs** are counted, not timed: contacts, and operations by the pattern of the factorisation, each with a weight. The choice, and with it
every bit of the result, is then the same on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan

import numpy as np

from masonry_cd.friction.local_blocks import in_elimination_order, local_arrays
from masonry_cd.friction.problem import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.linalg.ordering import Pattern
from masonry_cd.solvers import admm, interior, newton, nlgs
from masonry_cd.solvers.options import Options

ADMM, NEWTON, INTERIOR, NLGS = 0, 1, 2, 3
METHODS = (admm, newton, interior, nlgs)
NAMES = ("admm", "newton", "interior", "nlgs")

# At rest. Errors are natural map errors, as multiples of the tolerance.
NEARLY = 10.0  # error at the start below which a step is solved deeper than asked
DEEPER = 1e-4  # error down to which it is solved
AGAIN = 10.0  # times that error: at which the impulses of a step solved deeper do for the next one; from farther it is solved deeper too
ROUNDING = 1e-13  # natural map error, not a multiple, that is not worth reaching for
DEEP_LIMIT = 60  # iterations of a step solved deeper; most need ten more than usual
FAR = 1e3  # error at the last start looked at, above which only every LOOK-th start is measured: a measurement costs an iteration or two
LOOK = 8  # steps

# While a structure slides.
STUCK = 0.5  # share of the last steps begun as usual that needed the interior point method, above which it comes first
STUCK_MEMORY = 0.5  # weight of the steps before in that share

# Which of ADMM and Newton comes first.
MEMORY = (0.8, 0.2)  # weights of the steps before and of this one in the mean cost of a step
TRIAL = 100  # steps between two trials of the other one, times the ratio of their costs: trials then cost about 1 % whatever it is
EARLY = 5  # steps before the first trial
WARM = 3  # steps of a trial
HOPELESS = 4.0  # times the cost of the preferred one: a first step that ends a trial
WARMER = 0.8  # times the cost of the step before: a step that lets a trial go on

# Limits of a turn, in iterations.
ADMM_LIMIT = (50, 200)  # least and most of a first turn
WORTH = 10.0  # iterations of Newton; what costs more of ADMM's is given up: Newton would surely have been cheaper
NEWTON_LIMIT = 16
NEWTON_FINISH = 40  # after sweeps or the interior point method, from which it starts close
LONG_RUNS: tuple[tuple[int, int], ...] = ((ADMM, 600), (NEWTON, 40), (ADMM, 1200), (NEWTON, 40))  # of local problems, at the end
SWEEPS = (2000, 20000)  # sweeps: fewer lead nowhere, more are not made
LONG = 100_000  # sweeps at the end, for a problem without a step before

# Costs, in microseconds on the machine of the fit: of a call of ADMM and of Newton, and of an iteration, by what :func:`work` counts, by
# ``benchmarks.costs`` fitted to 14 shaken scenes of 1 to 5,008 blocks in a plane and in space. They meet most of what was measured to 15 %.
# New factors and measurements of the error are in the iterations.
CALL = ((35.0, 0.02, 0.01, 0.0), (22.0, 0.0, 0.0074, 0.0))
ITERATION = ((3.3, 0.014, 0.001, 0.0), (0.2, 0.049, 0.019, 1.3e-4))
Costs = tuple[float, float, float, float]  # of an iteration of ADMM and of Newton, and of a call
SWEEP = 0.002  # of a sweep of Gauss-Seidel for an entry of H on one side, or of W
BUDGET = 1e6  # that the interior point method may spend on a step, but for its first start, and sweeps: about a second
FIRST = 10.0  # times as much for a problem without a step before; beyond so many times the budget it does not come before sweeps
SWEEP_SHARE = 0.5  # of the interior point method's first start, or of the budget, that sweeps may cost


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Solve by the method that promises to be cheapest, then by the others.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` bounds the iterations of all methods together.
        start: its impulse (C, m) is the first iterate, its memory the one of the step before.
    """
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    tally, deeper = Tally.recall(start), max(DEEPER * options.tolerance, ROUNDING)
    error = np.inf
    if start is not None and (tally.error <= FAR * options.tolerance or tally.steps % LOOK == 0):
        error = tally.error = natural_map_error(problem, start.impulse)
        if error <= (AGAIN * deeper if tally.deeper else options.tolerance):
            tally.deeper = False
            velocity = problem.body_velocity(start.impulse) if isinstance(problem, FrictionProblem) else None
            return Solution(start.impulse.copy(), velocity, 0, "as in the last step: converged", tally.beside(start.memory), error)
    costs, memory = _costs(problem, tally, start)
    first = ADMM if start is None else _prefer(tally, costs)
    search = _Search(problem, options, start, memory)
    if error <= NEARLY * options.tolerance:
        search.turn(first, min(_limits(costs)[first], DEEP_LIMIT), deeper)
    tally.deeper = options.tolerance < error <= NEARLY * options.tolerance
    slides = tally.stuck > STUCK and tally.steps % LOOK != 0
    for method, limit in _turns(problem, first, costs, start is None, slides):
        if search.ended:
            break
        search.turn(method, limit)
    if not slides:
        tally.stuck = STUCK_MEMORY * tally.stuck + (1.0 - STUCK_MEMORY) * float(search.iterations[INTERIOR] + search.iterations[NLGS] > 0)
    _learn(tally, first, [_spent(costs, method, search.iterations[method]) for method in (ADMM, NEWTON)])
    return search.solution(tally)


@dataclass(slots=True)
class Tally:
    """What is learnt from step to step."""

    mean: list[float]  # cost of steps begun with ADMM and with Newton, nan if unknown
    steps: int = 0
    contacts: int = -1  # for which the costs were counted
    costs: Costs = (0.0, 0.0, 0.0, 0.0)
    deeper: bool = False  # whether the last step was solved deeper than asked, because it began close to the solution
    error: float = 0.0  # at the last start looked at
    stuck: float = 0.0  # share of the last steps that needed more than ADMM and Newton
    until_trial: float = EARLY  # steps until the next trial
    trial: int = 0  # which step of a trial the next one is, or 0

    @classmethod
    def recall(cls, start: Solution | None) -> Tally:
        """That of the step before, or a new one."""
        if start is None or "auto_tally" not in start.memory:
            return cls([nan, nan])
        admm_mean, newton_mean, steps, contacts, *rest = start.memory["auto_tally"].tolist()
        deeper, error, stuck, until_trial, trial = rest[4:]
        costs = (rest[0], rest[1], rest[2], rest[3])
        return cls([admm_mean, newton_mean], int(steps), int(contacts), costs, bool(deeper), error, stuck, until_trial, int(trial))

    def beside(self, memory: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The memory of the methods, and this one (13,)."""
        own = (*self.mean, self.steps, self.contacts, *self.costs, self.deeper, self.error, self.stuck, self.until_trial, self.trial)
        return memory | {"auto_tally": np.array(own, dtype=float)}


class _Search:
    """The best answer so far, and the way to it."""

    def __init__(self, problem: Problem, options: Options, start: Solution | None, memory: dict[str, np.ndarray]) -> None:
        self.problem, self.options, self.memory = problem, options, memory
        self.start, self.best = start or Solution(np.zeros((problem.contacts, problem.dimension)), None, 0), start
        self.error = np.inf
        self.iterations = [0, 0, 0, 0]  # by method
        self.story: list[str] = []

    @property
    def ended(self) -> bool:
        """Whether the tolerance or the limit of iterations is reached."""
        return self.error <= self.options.tolerance or sum(self.iterations) == self.options.max_iterations

    def turn(self, method: int, limit: int, tolerance: float | None = None) -> None:
        """Give a method its turn, from the best impulses so far; the interior point method from those of the last step, but for sweeps."""
        tolerance = self.options.tolerance if tolerance is None else tolerance
        if self.options.max_iterations is not None:
            limit = min(limit, self.options.max_iterations - sum(self.iterations))
        begin = self.start if method == INTERIOR and not self.iterations[NLGS] else self.best or self.start
        begin = Solution(begin.impulse, begin.velocity, 0, memory=self.memory)
        options = Options(tolerance, limit, self.options.seed, self.options.threads)
        found = METHODS[method].solve(self.problem, options, begin)
        self.memory = found.memory or self.memory
        self.iterations[method] += found.iterations
        self.story.append(NAMES[method])
        error = natural_map_error(self.problem, found.impulse)
        if error < self.error or self.best is None:
            self.best, self.error = found, error

    def solution(self, tally: Tally) -> Solution:
        """The best answer, with the memory of all."""
        assert self.best is not None
        tried = " + ".join(self.story[:4]) + (" and so on" if len(self.story) > 4 else "")
        end = "converged" if self.error <= self.options.tolerance else f"missed, error {self.error:.1e}"
        reason, memory = f"{tried}: {end}", tally.beside(self.memory)
        return Solution(self.best.impulse, self.best.velocity, sum(self.iterations), reason, memory, self.error)


def _prefer(tally: Tally, costs: Costs) -> int:
    """The method to begin with; now and then the other one, unless a single iteration of it costs more than the steps of the first."""
    cheaper = NEWTON if tally.mean[NEWTON] < tally.mean[ADMM] else ADMM
    other = 1 - cheaper
    tally.until_trial -= 1.0
    if not tally.trial and tally.until_trial <= 0.0 and not _spent(costs, other, 1) > tally.mean[cheaper]:
        tally.trial = 1
    return other if tally.trial else cheaper


def _learn(tally: Tally, first: int, spent: list[float]) -> None:
    """Take the cost of a step into account. If the other method had to help, what that took is a first guess of its own cost."""
    tally.steps += 1
    mean, cost, before, other = tally.mean, sum(spent), tally.mean[first], 1 - first
    if cost == 0.0:  # nothing happened, nothing learnt
        return
    cold = tally.steps == 2  # the step before was the first
    mean[first] = cost if tally.trial or cold or isnan(before) else MEMORY[0] * before + MEMORY[1] * cost
    if spent[other] > 0.0 and not spent[other] > mean[other]:
        mean[other] = spent[other]
    if not tally.trial:
        return
    limit = HOPELESS * mean[other] if tally.trial == 1 else WARMER * before
    if tally.trial == WARM or spent[other] > 0.0 or cost < mean[other] or cost > limit:
        tally.until_trial, tally.trial = TRIAL * max(cost / mean[other], 1.0), 0
    else:
        tally.trial += 1


def _spent(costs: Costs, method: int, iterations: int) -> float:
    """Cost of a call of ADMM or Newton and its iterations."""
    return costs[2 + method] + iterations * costs[method] if iterations else 0.0


def work(problem: Problem, pattern: Pattern) -> np.ndarray:
    """Work of a call or an iteration, (4,): one; contacts; entries of H on one side, or a third of those of W, with which less is done;
    operations of a factorisation divided by the unknowns per body, or contact."""
    n, share = (problem.v_free.shape[1], 1.0) if isinstance(problem, FrictionProblem) else (problem.dimension, 1.0 / 3.0)
    return np.array([1.0, problem.contacts, share * entries(problem), pattern.operations(n) / n])


def entries(problem: Problem) -> int:
    """Number of entries of H on one side, or of W."""
    if isinstance(problem, FrictionProblem):
        return problem.contacts * problem.dimension * problem.v_free.shape[1]
    return int(problem.w.nnz)


def _turns(problem: Problem, first: int, costs: Costs, cold: bool, slides: bool) -> list[tuple[int, int]]:
    """Methods with their limits of iterations, the usual ones first; the interior point method first while a structure slides.

    Args:
        problem: to be solved.
        first: ADMM or NEWTON, which begins.
        costs: of the two.
        cold: whether there is no step before.
        slides: whether the last steps needed the interior point method.
    """
    limits, other, budget = _limits(costs), 1 - first, FIRST * BUDGET if cold else BUDGET
    one_start = interior.affordable(0.0)  # iterations
    start_cost, sweep_cost = one_start * costs[NEWTON], SWEEP * max(entries(problem), 1)
    sweeps = min(int((SWEEP_SHARE * start_cost if cold else min(SWEEP_SHARE * start_cost, budget)) / sweep_cost), SWEEPS[1])
    packed = sweeps >= SWEEPS[0]

    usual = [(first, limits[first])]
    if not (packed and other == NEWTON and sweeps * sweep_cost < limits[NEWTON] * costs[NEWTON]):
        usual.append((other, limits[other]))
    hard = [(INTERIOR, interior.affordable(budget / costs[NEWTON])), (NEWTON, NEWTON_FINISH)]
    if packed:
        hard = [(NLGS, sweeps), (NEWTON, NEWTON_FINISH), *hard]
        if start_cost <= FIRST * budget:
            hard = [(INTERIOR, one_start), *hard]
    last = [] if isinstance(problem, FrictionProblem) else list(LONG_RUNS)
    if cold:
        last += [(NLGS, min(int(SWEEP_SHARE * budget / sweep_cost), LONG)), (NEWTON, NEWTON_FINISH)]
        last += [(INTERIOR, one_start), (NEWTON, NEWTON_FINISH)]
    return [*hard, *usual, *last] if slides else [*usual, *hard, *last]


def _costs(problem: Problem, tally: Tally, start: Solution | None) -> tuple[Costs, dict[str, np.ndarray]]:
    """Costs by the pattern of the last step's factorisation, counted anew only when the number of contacts changes; and the memory to begin
    with, which holds the pattern if it had to be made for that."""
    memory = {} if start is None else start.memory
    if tally.contacts != problem.contacts:
        if not isinstance(problem, FrictionProblem):
            _, pattern = in_elimination_order(local_arrays(problem)[0])
        else:
            last = admm.Memory.read(memory)
            if last is None:
                last, *_ = admm.recall(problem.arrays().bodies, len(problem.v_free), problem.v_free.shape[1], start)
                memory = memory | last.arrays()
            pattern = last.pattern
        tally.contacts, tally.costs = problem.contacts, tuple((np.array(ITERATION + CALL) @ work(problem, pattern)).tolist())
    return tally.costs, memory


def _limits(costs: Costs) -> tuple[int, int]:
    """Iterations of a first turn of ADMM, after which Newton would have been cheaper, and of Newton."""
    least, most = ADMM_LIMIT
    return min(max(int(WORTH * costs[NEWTON] / costs[ADMM]), least), most), NEWTON_LIMIT
