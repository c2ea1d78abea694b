# SPDX-License-Identifier: GPL-3.0-or-later
r"""Violations of the contact laws after a step in m/s, and the slip and the opening that come of them.

The natural map error is one number, a share of |q|. Where a light block takes a large force that norm is huge, and what is small compared
with it need not be small compared with the motion. So each step is measured in m/s as well, contact by contact, with the normal and the
tangential residual of Alart & Curnier (Comput. Methods Appl. Mech. Engrg. 92, 1991), both zero exactly at a solution:

    parting    min( w_n, rho p_n )
    slipping   rho p_t - P( rho p_t - w_t ),     P the projection onto the disc of radius mu rho max(p_n, 0)

rho, the sum of 1 / mass of its blocks (and its compliance), makes velocities of impulses. Of a contact that sticks all slip is such a
violation, of one that slides against its friction none.

**False slip** stays in a joint and adds up, in its direction, as long as the detector finds the contact again: false_slip += h slipping.
**False opening** does not: the gap enters the next step, which has to close it again. It is h parting; what closes instead is an overlap.

In a step with impacts solved apart the law holds for the blow alone, see ``impacts.py``, and so does its violation.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.contact_geometry import velocity_between
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.threads import in_shares

UNBONDED = np.zeros(0)


class Violation(NamedTuple):
    """Violation of the contact laws after a step."""

    speed: float = 0.0  # largest violation of a contact [m/s]
    slip: float = 0.0  # largest false slip of a contact so far [m]
    opening: float = 0.0  # largest false opening of a contact in this step [m]
    blocks: tuple[int, int] = (-1, -1)  # of the contact with the largest slip; -1: there is no contact


class FalseSlip(NamedTuple):
    """Where the false slip of a contact comes from and goes to."""

    active: np.ndarray  # (C,) places of the contacts among all that were found
    previous: np.ndarray  # (N,) places of all that were found in the step before; -1: new
    before: np.ndarray  # (N', m - 1) of all contacts of the step before, along t1 and t2 [m]
    after: np.ndarray  # (N, m - 1) of all contacts of this step


def find_violations(
    system: System, made: StepProblem, impulse: np.ndarray, v: np.ndarray, before: np.ndarray
) -> tuple[Violation, np.ndarray]:
    """Return the violation of the contact laws after a step, and the false slip of all its contacts (N, m - 1), one row at least [m].

    Args:
        system: of the run.
        made: the problem of the step.
        impulse: (C, m) of which the law holds [N s].
        v: (F, n) velocities at its end.
        before: false slip of all contacts of the last step [m].
    """
    count, h, problem = made.problem.contacts, system.constants.step, _judged(made, impulse, v).arrays()
    bond = UNBONDED if made.springs is None else made.springs.bond
    after = np.zeros((max(1, len(made.found.gap)), system.rows - 1))
    slips = FalseSlip(made.rows.active, made.found.previous, before, after)
    found = in_shares(lambda _, first, end: violate(problem, bond, slips, impulse, v, h, (first, end)), system.threads_for(count), count)
    speed, slip, opening, worst = found[0]
    for other in found[1:]:
        slip, worst = (other[1], other[3]) if other[1] > slip else (slip, worst)
        speed, opening = max(speed, other[0]), max(opening, other[2])
    first, second = made.rows.blocks[worst].tolist() if worst >= 0 else (-1, -1)
    return Violation(speed, slip, opening, (first, second)), after


def _judged(made: StepProblem, impulse: np.ndarray, v: np.ndarray) -> FrictionProblem:
    """The problem with bonds that soften as if they met their law: next to no stiffness makes metres per second of next to no force."""
    if made.bonds is None:
        return made.problem
    row, offset = made.bonds.rows(made.rows.active)[1], made.problem.offset.copy()
    held = made.problem.subset(row)
    offset[row] -= held.relative_velocity(v) + held.compliance * impulse[row]
    return replace(made.problem, offset=offset)


@entry()
def violate(
    problem: ProblemArrays, bond: np.ndarray, slips: FalseSlip, impulse: np.ndarray, v: np.ndarray, step: float, share: tuple[int, int]
) -> tuple[float, float, float, int]:
    """Fill ``slips.after`` of a share of the contacts of ProblemArrays, its first and its end; impulses (C, m), velocities (F, n), h [s].

    ``bond`` (C,): by which the cones begin below zero [N s]; (0,): at zero.

    Returns the largest violation [m/s], false slip and false opening [m], and the contact with the largest false slip, -1 for none.
    """
    bodies, offset, compliance, m = problem.places, problem.offset, problem.compliance, impulse.shape[1]
    speed, slip, opening, worst = 0.0, -1.0, 0.0, -1  # speed and slip squared
    for c in range(share[0], share[1]):
        w0, w1, w2 = velocity_between(bodies, problem.geometry, c, v)
        p1, p2 = impulse[c, 1], impulse[c, 2] if m == 3 else 0.0
        w0, w1, w2 = w0 + offset[c, 0], w1 + offset[c, 1], w2 + offset[c, 2] if m == 3 else 0.0
        rho = 0.0
        for side in range(2):
            if bodies[c, side] < len(v):
                rho += problem.inverse[bodies[c, side], 0, 0]
        rho_n = rho_t = rho
        if len(compliance):
            w0, w1 = w0 + compliance[c, 0] * impulse[c, 0], w1 + compliance[c, 1] * p1
            w2 += compliance[c, m - 1] * p2
            rho_n, rho_t = rho + compliance[c, 0], rho + compliance[c, 1]
        pressed = impulse[c, 0] + (bond[c] if len(bond) else 0.0)
        parting = min(w0, rho_n * pressed)
        x1, x2, radius = rho_t * p1 - w1, rho_t * p2 - w2, problem.mu[c] * rho_t * max(pressed, 0.0)
        square = x1 * x1 + x2 * x2
        s1, s2 = w1, w2
        if square > radius * radius:
            inside = radius / np.sqrt(square)
            s1, s2 = rho_t * p1 - inside * x1, rho_t * p2 - inside * x2
        speed, opening = max(speed, parting * parting + s1 * s1 + s2 * s2), max(opening, parting)
        at = slips.active[c]
        last = slips.previous[at]
        a1, a2 = step * s1, step * s2
        if last >= 0:
            a1 += slips.before[last, 0]
            a2 += slips.before[last, 1] if m == 3 else 0.0
        slips.after[at, 0] = a1
        if m == 3:
            slips.after[at, 1] = a2
        total = a1 * a1 + a2 * a2
        if total > slip:
            slip, worst = total, c
    return np.sqrt(speed), np.sqrt(max(slip, 0.0)), step * opening, worst
