"""Picks the solver, by what the last steps cost, and hands over when one gets stuck.

ADMM carries news through the structure in every iteration and is cheap by the iteration; Newton is dear by the iteration but needs few,
also where much slides or lifts off, if it starts close. So a step begins with the one that did better in the steps before (ADMM at first,
the other one is tried again now and then), within a limit at which Newton would surely have been cheaper. What is not solved then
goes to the other one, and on in turns with growing limits; each starts from the best impulses so far.

Costs are counted, not timed: floating-point operations by the pattern of the factorisation. The choice, and with it every bit of the
result, is then the same on every machine.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.friction import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.solvers import admm, newton, nlgs
from masonry_cd.solvers.options import Options
from masonry_cd.solvers.pattern import Pattern

ROUNDS = 5  # turns of ADMM and Newton before giving up
NEWTON_LIMIT = 16
TRIAL = 50  # steps between two trials of the solver that is not preferred
ADMM, NEWTON = 0, 1
NAMES = ("admm", "newton")


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Solve by the method that promises to be cheapest, then by the others.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` bounds the iterations of all methods together.
        start: its impulse (C, m) is the first iterate, its memory the one of the step before.
    """
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    tally = _recall(start)
    first = ADMM if start is None else _prefer(tally)
    costs = _costs(problem, start)
    best, total, limits = start, 0, (_limit(costs), NEWTON_LIMIT)
    spent = [0.0, 0.0]
    memory: dict[str, np.ndarray] = {} if start is None else start.memory
    error, story = np.inf, []
    for turn in range(2 * ROUNDS):
        method = (first + turn) % 2
        limit = limits[method] * (1 + turn // 2 * 2)
        if options.max_iterations is not None:
            limit = min(limit, options.max_iterations - total)
        begin = None if best is None else Solution(best.impulse, None, 0, memory=memory)
        found = (newton if method == NEWTON else admm).solve(problem, replace(options, max_iterations=limit), begin)
        memory, total = found.memory, total + found.iterations
        spent[method] += costs[method] * found.iterations
        story.append(NAMES[method])
        found_error = natural_map_error(problem, found.impulse)
        if found_error < error or best is None:
            best, error = found, found_error
        if error <= options.tolerance or total == options.max_iterations:
            break
    assert best is not None
    _learn(tally, first, spent)
    best.iterations, best.memory = total, memory | {"auto_tally": tally}
    best.reason = _reason(story, error, options)
    return best


def _recall(start: Solution | None) -> np.ndarray:
    """(3,) mean cost of steps begun with ADMM and with Newton, nan if unknown, and the number of steps."""
    if start is not None and "auto_tally" in start.memory:
        return start.memory["auto_tally"].copy()
    return np.array([np.nan, np.nan, 0.0])


def _prefer(tally: np.ndarray) -> int:
    """The method to begin with."""
    other_is_due = int(tally[2]) % TRIAL == TRIAL - 1
    cheaper = NEWTON if tally[NEWTON] < tally[ADMM] else ADMM
    return 1 - cheaper if other_is_due else cheaper


def _learn(tally: np.ndarray, first: int, spent: list[float]) -> None:
    """Take the cost of a step into account. If the other method had to help, what that took is a first guess of its own cost."""
    tally[2] += 1.0
    if sum(spent) == 0.0:  # nothing happened, nothing learnt
        return
    tally[first] = sum(spent) if np.isnan(tally[first]) else 0.8 * tally[first] + 0.2 * sum(spent)
    if spent[1 - first] > 0.0 and not spent[1 - first] > tally[1 - first]:
        tally[1 - first] = spent[1 - first]


def _costs(problem: Problem, start: Solution | None) -> tuple[float, float]:
    """Operations of one iteration of ADMM and of one of Newton, from the pattern of the last step's factorisation."""
    if not isinstance(problem, FrictionProblem):
        return 1.0, 10.0
    memory = admm.Memory.read(start.memory) if start is not None else None
    n, rows = problem.v_free.shape[1], problem.contacts * problem.dimension
    pattern = memory.pattern if memory is not None else Pattern.of(len(problem.v_free), problem.bodies[:, 0], problem.bodies[:, 1])
    below = np.diff(pattern.column).astype(float)
    iteration = 8.0 * rows * n + 4.0 * n * n * below.sum()
    return iteration, iteration + 2.0 * n**3 * float(below @ (below + 1.0)) + 8.0 * rows * n * n


def _limit(costs: tuple[float, float]) -> int:
    """Iterations of ADMM after which Newton would have been cheaper."""
    return int(np.clip(10.0 * costs[NEWTON] / costs[ADMM], 50, 200))


def _reason(story: list[str], error: float, options: Options) -> str:
    """What was tried, and how it ended."""
    tried = " + ".join(story[:2]) + (" and so on" if len(story) > 2 else "")
    return f"{tried}: converged" if error <= options.tolerance else f"{tried}: missed, error {error:.1e}"
