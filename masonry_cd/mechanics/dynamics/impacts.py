# SPDX-License-Identifier: GPL-3.0-or-later
r"""Impacts apart from forces, so that the weight passes from contact to contact at the right moment.

The gap over the step, u_n + g/h >= 0, spreads the impulse J of an impact over two steps: (1 - f) J at the q_m before the gap closes, f J
at the next one, where f in [0, 1] is the time from q_m to the impact over h. That is exact in the motion of the gap. But solved in one go
with the weight, the first part already lifts the contacts that carry the weight until the impact, and gravity turns the block about
its new edge a step too soon: a rocking block loses 1 % of its speed too much at each impact. So in a step with an impact

    1. forces    all contacts that are closed, with gravity                    M v' = M v_free + H^T p'
    2. impacts   all contacts, from v' on, without further gravity             M v+ = M v'     + H^T p''

This hands the weight over half a step after q_m instead of f steps after it. What is left, (f - 1/2) p' of the contacts that the impact
opens, is added to the free velocity of the next step. Free rocking is so met to 1 % of the angle at dt = 1 ms instead of 9 %.

The weight passes on within the joint that is hit. Of all other joints the law holds for the impulse of the whole step, as it does of
elastic and bonded contacts: they carry in the first solve what they would without an impact, so that the others get their share, and are
solved again in the second, with both. Otherwise the blow alone would part and shift joints under thrust until the next step, which the
thrust closes within microseconds: an arch that shakes at 0.25 g so opened by a third too much at dt = 0.25 ms.

The solver remembers the two apart (see ``islands.py``): what it has learnt and what it can use again fits the last impacts best.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.islands import FORCES, IMPACTS
from masonry_cd.mechanics.friction.contact_geometry import add_impulse_of_side, form_of, velocity_between
from masonry_cd.mechanics.friction.operators import ProblemArrays, triple_of
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.linalg.triples import scaled

FAST = 3.0  # impacts faster than this many times g h count
AT_ONCE = 1e-6  # gaps that close within this share of the step are closed
LIFTED = 0.01  # contacts that part faster than this share of the fastest impact are opened by it
CLOSED = 2.0  # gaps below this many times g h^2 count as closed: gravity alone closes them within about a step

Solve = Callable[[FrictionProblem, Solution, str], Solution]  # problem, start, and FORCES or IMPACTS


@dataclass(frozen=True, eq=False)
class ImpactStep:
    """The outcome of a step with impacts."""

    solution: Solution  # impulses of both solves together
    error: float  # the larger natural map error of the two
    carried_impulse: np.ndarray  # (F, n) generalised impulse for the next step
    forces: FrictionProblem  # the two problems as they were solved
    impacts: FrictionProblem
    blow: np.ndarray  # (C, m) impulses of the impacts, and of the contacts whose law holds for the whole step [N s]


def open_contacts(
    problem: FrictionProblem, gap: np.ndarray, pair: np.ndarray, step: float, gravity: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """The contacts (C,) that are open at q_m, if one of them is about to be hit, and those of the joints that are hit, (C,).

    None if the step has no impact that matters.

    Contacts of one pair that are hit together stay together: a block that lands flat lands on all its corners.

    Args:
        problem: of the step.
        gap: (C,) at q_m [m].
        pair: (C,) which pair of parts a contact belongs to.
        step: h [s].
        gravity: magnitude of the body acceleration [m/s2].
    """
    is_open, struck = np.empty(len(gap), dtype=np.bool_), np.empty(len(gap), dtype=np.bool_)
    hit = find_impacts(problem.arrays(), gap, pair, step, gravity, is_open, struck)
    return (is_open, struck) if hit else None


def open_among(
    kept: np.ndarray, problem: FrictionProblem, gap: np.ndarray, pair: np.ndarray, step: float, gravity: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """:func:`open_contacts` among some contacts (indices); the others, of elastic and bonded joints, count as neither open nor hit."""
    among = open_contacts(problem.subset(kept), gap[kept], pair[kept], step, gravity)
    if among is None:
        return None
    is_open, struck = np.zeros((2, len(gap)), dtype=np.bool_)
    is_open[kept], struck[kept] = among
    return is_open, struck


@entry()
def find_impacts(
    problem: ProblemArrays, gap: np.ndarray, pair: np.ndarray, step: float, gravity: float, is_open: np.ndarray, struck: np.ndarray
) -> bool:
    """Fill ``is_open`` and ``struck`` (C,), see :func:`open_contacts`; return whether there is an impact.

    Contacts of ProblemArrays, those of a pair one after the other; gaps (C,) [m], pairs (C,), h [s], gravity [m/s2].
    """
    count, any_hit, first = len(gap), False, 0
    while first < count:
        last, hit = first, False
        while last < count and pair[last] == pair[first]:
            # negative: the gap closes before the next q_m
            ahead = problem.offset[last, 0] + velocity_between(problem.places, problem.geometry, last, problem.free)[0]
            closing = max(gap[last], 0.0) / step - ahead
            is_open[last] = closing > FAST * gravity * step and ahead < 0.0  # for now: whether it is hit hard
            hit = hit or (is_open[last] and gap[last] > AT_ONCE * closing * step)
            last += 1
        for c in range(first, last):
            is_open[c] = (hit and is_open[c]) or gap[c] > CLOSED * gravity * step * step
            struck[c] = hit
        any_hit = any_hit or hit
        first = last
    return any_hit


def solve_apart(
    problem: FrictionProblem, is_open: np.ndarray, whole: np.ndarray, gap: np.ndarray, step: float, start: Solution, solve: Solve
) -> ImpactStep:
    """Solve the forces of the closed contacts, then the impacts on what they leave.

    Args:
        problem: of the step.
        is_open: (C,) from :func:`open_contacts`.
        whole: (C,) contacts whose law holds for the whole step.
        gap: (C,) [m].
        step: h [s].
        start: impulses (C, m) and velocities to start from.
        solve: the solver, its options bound.
    """
    closed = ~is_open
    forces = problem.subset(closed)
    first = solve(forces, Solution(start.impulse[closed], start.velocity, 0), FORCES)
    force, guess = np.zeros_like(start.impulse), np.zeros_like(start.impulse)
    force[closed] = first.impulse
    guess[whole], force[whole] = force[whole], 0.0
    impacts = replace(problem, v_free=problem.body_velocity(force))
    second = solve(impacts, Solution(guess, None, 0), IMPACTS)
    error = max(error_of(forces, first), error_of(impacts, second))
    carried = carried_impulse(impacts.arrays(), gap, is_open, impacts.body_velocity(second.impulse), force, second.impulse, step)
    reason = first.reason if first.reason == second.reason else f"{first.reason}; impacts: {second.reason}"
    total = Solution(force + second.impulse, None, first.iterations + second.iterations, reason)
    return ImpactStep(total, error, carried, forces, impacts, second.impulse)


def error_of(problem: FrictionProblem, solution: Solution) -> float:
    """The natural map error, measured unless the solver had to."""
    return natural_map_error(problem, solution.impulse) if solution.error is None else solution.error


@entry()
def carried_impulse(
    problem: ProblemArrays,
    gap: np.ndarray,
    is_open: np.ndarray,
    after: np.ndarray,
    force: np.ndarray,
    blow: np.ndarray,
    step: float,
) -> np.ndarray:
    """(f - 1/2) H^T p' of the contacts that the impacts open, (F, n), with f of the hardest blow on either body of the contact.

    ProblemArrays of the impacts; gaps (C,) [m], contacts that are open at q_m (C,), velocities with the blows (F, n), impulses p' of the
    forces and of the blows (C, m) [N s], h [s].
    """
    before, bodies, geometry, offset = problem.free, problem.places, problem.geometry, problem.offset
    count, supports, out = len(gap), len(before), np.zeros_like(before)
    closing = np.zeros(count)  # speed at which the gap closes before the blow; of other contacts than those that are hit zero
    hardest, moment = np.zeros(supports + 1), np.full(supports + 1, 0.5)  # by body; the last entry stands for all supports
    for c in range(count):
        if is_open[c] and blow[c, 0] > 0.0:
            closing[c] = max(0.0, gap[c] / step - offset[c, 0] - velocity_between(bodies, geometry, c, before)[0])
            for body in bodies[c]:
                if body < supports and closing[c] > 0.0 and blow[c, 0] >= hardest[body]:
                    hardest[body], moment[body] = blow[c, 0], gap[c] / (step * closing[c])
    fastest = closing.max() if count else 0.0
    if fastest == 0.0:
        return out
    for c in range(count):
        if is_open[c] or force[c, 0] <= 0.0:
            continue
        parting = offset[c, 0] + velocity_between(bodies, geometry, c, after)[0]
        if len(problem.compliance):
            parting += problem.compliance[c, 0] * blow[c, 0]
        if parting <= LIFTED * fastest:
            continue
        first, second = bodies[c]
        f = moment[first] if hardest[first] >= hardest[second] else moment[second]
        impulse = scaled(f - 0.5, triple_of(force, c, len(problem.m)))
        for side in range(2):
            if bodies[c, side] < supports:
                add_impulse_of_side(form_of(geometry), geometry, c, side, bodies[c, side], out.shape[1], impulse, out)
    return out
