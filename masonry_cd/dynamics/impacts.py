r"""Impacts apart from forces, so that the weight passes from contact to contact at the right moment.

The gap over the step, u_n + g/h >= 0, spreads the impulse J of an impact over two steps: (1 - f) J at the q_m before the gap closes, f J
at the next one, where f in [0, 1] is the time from q_m to the impact over h. That is exact in the motion of the gap. But solved in one go
with the weight, the first part already lifts the contacts that carry the weight until the impact, and gravity turns the block about
its new edge a step too soon: a rocking block loses 1 % of its speed too much at each impact. So in a step with an impact

    1. forces    all contacts that are closed, with gravity                    M v' = M v_free + H^T p'
    2. impacts   all contacts, from v' on, without further gravity             M v+ = M v'     + H^T p''

This hands the weight over half a step after q_m instead of f steps after it. What is left, (f - 1/2) p' of the contacts that the impact
opens, is added to the free velocity of the next step. Free rocking is so met to 1 % of the angle at dt = 1 ms instead of 9 %.

The weight changes hands within the joint that is hit. Of all other joints the law holds for the impulse of the whole step, as it does of
elastic and bonded contacts: they carry in the first solve what they would without an impact, so that the others get their share, and are
solved anew in the second, with both. Else the blow alone would part and shift joints under thrust until the next step, which the thrust
closes within microseconds: an arch that shakes at 0.25 g so opened by a third too much at dt = 0.25 ms.

The solver remembers the two apart (see ``islands``): in what it has learnt and in what it can use again, the impacts are most like the
last impacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.dynamics.islands import FORCES, IMPACTS
from masonry_cd.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.jit import entry, kernel

FAST = 3.0  # impacts faster than this many times g h count
AT_ONCE = 1e-6  # gaps that close within this share of the step are closed
LIFTED = 0.01  # contacts that part faster than this share of the fastest impact are opened by it
CLOSED = 2.0  # gaps below this many times g h^2 count as closed: gravity alone closes them within about a step


@dataclass(frozen=True, eq=False)
class ImpactStep:
    """The outcome of a step with impacts."""

    solution: Solution  # impulses of both solves together
    error: float  # the larger natural map error of the two
    handover: np.ndarray  # (B, n) generalised impulse for the next step
    forces: FrictionProblem  # the two problems as they were solved
    impacts: FrictionProblem


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
    hit = _impacts(gap, pair, problem.bodies, problem.jacobian, problem.offset, problem.v_free, step, gravity, is_open, struck)
    return (is_open, struck) if hit else None


@entry()
def _impacts(gap, pair, bodies, jacobian, offset, v_free, step, gravity, is_open, struck):
    """Fill ``is_open`` and ``struck`` (C,), see :func:`open_contacts`; return whether there is an impact. The contacts of a pair follow
    each other."""
    contacts, any_hit = len(gap), False
    first = 0
    while first < contacts:
        last, hit = first, False
        while last < contacts and pair[last] == pair[first]:
            is_open[last] = False  # for now: whether it is hit hard
            ahead = offset[last, 0]  # negative when the gap closes before the next q_m
            for side in range(2):
                body = bodies[last, side]
                if body >= 0:
                    for k in range(v_free.shape[1]):
                        ahead += jacobian[last, side, 0, k] * v_free[body, k]
            closing = max(gap[last], 0.0) / step - ahead
            if closing > FAST * gravity * step and ahead < 0.0:
                is_open[last] = True
                hit = hit or gap[last] > AT_ONCE * closing * step
            last += 1
        for c in range(first, last):
            is_open[c] = (hit and is_open[c]) or gap[c] > CLOSED * gravity * step * step
            struck[c] = hit
        any_hit = any_hit or hit
        first = last
    return any_hit


def solve_apart(
    problem: FrictionProblem,
    is_open: np.ndarray,
    whole: np.ndarray,
    gap: np.ndarray,
    step: float,
    start: Solution,
    solve: Callable[[FrictionProblem, Solution, str], Solution],
) -> ImpactStep:
    """Solve the forces of the closed contacts, then the impacts on what they leave.

    Args:
        problem: of the step.
        is_open: (C,) from :func:`open_contacts`.
        whole: (C,) contacts whose law holds for the whole step.
        gap: (C,) [m].
        step: h [s].
        start: impulses (C, m) and velocities to start from.
        solve: the solver, its options bound; it is told whether the problem is of FORCES or IMPACTS.
    """
    closed = ~is_open
    forces = problem.subset(closed)
    first = solve(forces, Solution(start.impulse[closed], start.velocity, 0), FORCES)
    force, guess = np.zeros_like(start.impulse), np.zeros_like(start.impulse)
    force[closed] = first.impulse
    guess[whole], force[whole] = force[whole], 0.0
    impacts = replace(problem, v_free=problem.body_velocity(force))
    second = solve(impacts, Solution(guess, None, 0), IMPACTS)
    error = max(_error(forces, first), _error(impacts, second))
    handover = _handover(impacts, force, second.impulse, is_open, gap, step)
    reason = first.reason if first.reason == second.reason else f"{first.reason}; impacts: {second.reason}"
    total = Solution(force + second.impulse, None, first.iterations + second.iterations, reason)
    return ImpactStep(total, error, handover, forces, impacts)


def _error(problem: FrictionProblem, solution: Solution) -> float:
    """The natural map error, measured unless the solver had to."""
    return natural_map_error(problem, solution.impulse) if solution.error is None else solution.error


def _handover(
    impacts: FrictionProblem, force: np.ndarray, blow: np.ndarray, is_open: np.ndarray, gap: np.ndarray, step: float
) -> np.ndarray:
    """(f - 1/2) H^T p' of the contacts that the impacts open, (B, n), with f of the hardest blow on either body of the contact."""
    a = impacts.arrays()
    out, after = np.zeros_like(a.v_free), impacts.body_velocity(blow)
    _hand_over(a.bodies, a.jacobian, a.offset, impacts.compliance, a.v_free, after, force, blow, is_open, gap, step, out)
    return out


@entry()
def _hand_over(bodies, jacobian, offset, compliance, before, after, force, blow, is_open, gap, step, out):
    """Fill ``out`` (B, n), see :func:`_handover`; ``before`` and ``after`` (B, n) are the velocities without and with the blows."""
    contacts, supports = len(gap), len(out)
    closing = np.zeros(contacts)  # speed at which the gap closes before the blow; of other contacts than those that are hit zero
    hardest, moment = np.zeros(supports + 1), np.full(supports + 1, 0.5)  # by body; the last entry stands for all supports
    for c in range(contacts):
        if is_open[c] and blow[c, 0] > 0.0:
            closing[c] = max(0.0, gap[c] / step - _normal_velocity(bodies[c], jacobian[c], offset[c], before))
            for body in bodies[c]:
                if body >= 0 and closing[c] > 0.0 and blow[c, 0] >= hardest[body]:
                    hardest[body], moment[body] = blow[c, 0], gap[c] / (step * closing[c])
    fastest = closing.max() if contacts else 0.0
    if fastest == 0.0:
        return
    for c in range(contacts):
        if is_open[c] or force[c, 0] <= 0.0:
            continue
        if _normal_velocity(bodies[c], jacobian[c], offset[c], after) + compliance[c, 0] * blow[c, 0] <= LIFTED * fastest:
            continue
        first, second = bodies[c]
        f = moment[first] if hardest[first] >= hardest[second] else moment[second]
        for side in range(2):
            body = bodies[c, side]
            if body >= 0:
                for j in range(out.shape[1]):
                    for i in range(force.shape[1]):
                        out[body, j] += (f - 0.5) * force[c, i] * jacobian[c, side, i, j]


@kernel()
def _normal_velocity(bodies, jacobian, offset, v):
    """u_n of one contact for body velocities v (B, n)."""
    u = offset[0]
    for side in range(2):
        if bodies[side] >= 0:
            for j in range(v.shape[1]):
                u += jacobian[side, 0, j] * v[bodies[side], j]
    return u
