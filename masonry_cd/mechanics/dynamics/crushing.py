# SPDX-License-Identifier: GPL-3.0-or-later
r"""Crushing: the pressure of an elastic joint ends at its compressive strength f, and what it is shorter for good stays.

A contact with a share A of the area of its joint carries what its spring and dashpot do (``joint_law.py``), and

    p_n <= h f A,        d' (h f A - p_n) = 0,        d' >= 0,

with its plastic shortening d, which counts as a gap. In the law of the step, w = u + b + C p, a contact that crushes slips along its normal
as one that slides does along the joint: d grows by -theta h w, or -h w where the spring is only just closing (return mapping, Simo &
Taylor, Int. J. Numer. Methods Eng. 22, 1986). What is above f at the end of the step goes the same way. The work of both, p_n / h times d,
is lost.

Which contacts crush is found by Newton's method on their set: those that do have a tangent of SOFT of their stiffness, through the point
where f is reached. The step is solved as it is, by any solver, and again where a contact is on the wrong side of f or too far from it. The
first guess is what crushed in the last step, and mostly right.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.dynamics.step_problem import Solved, SpringWork, StepProblem
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.problem import FrictionProblem

SOFT = 0.02  # tangent of a contact that crushes, as a share of its stiffness: softer ones would hide other errors of the step
NEAR = 2e-3  # share of the strength by which a pressure may be beyond it, or below it while the contact crushes
ROUNDS = 20  # solutions of a step at the most


def solve_crushing(system: System, made: StepProblem, solve: Callable[[StepProblem], Solved]) -> tuple[StepProblem, Solved]:
    """Solve a step whose joints may crush: its problem, with the law of the contacts that do, and the solution.

    The error is the share by which a pressure misses the law, where ROUNDS solutions were not enough and that is larger.
    """
    most = _largest_impulses(system, made)
    if most is None:
        return made, solve(made)
    crushes, shift = made.start.impulse[:, 0] >= most, np.zeros(len(most))
    for _ in range(ROUNDS):
        made = made._replace(problem=_softened(made, most, crushes, shift), crushes=crushes)
        solved = solve(made)
        p = solved.solution.impulse[:, 0]
        soft = made.problem.compliance[:, 0]
        beyond = np.where(np.isfinite(most), p - most, 0.0)
        shortened = np.divide(shift, soft, out=np.zeros(len(soft)), where=soft > 0.0)
        still = np.where(crushes, (1.0 - SOFT) * beyond + shortened, 0.0)  # how fast it is shortened, as an impulse
        limit = np.where(np.isfinite(most), NEAR * most, np.inf)
        wrong = np.where(crushes, still < -limit, beyond > limit)
        off = crushes & ~wrong & (np.abs(beyond) > limit)
        if not (wrong.any() or off.any()):
            return made, solved
        shift = np.where(off, shift + soft * beyond, np.where(wrong, 0.0, shift))
        crushes = crushes ^ wrong
        made = made._replace(start=replace(made.start, impulse=solved.solution.impulse))
    missed = float((np.abs(beyond) / most)[wrong | off].max())
    return made, solved._replace(error=max(solved.error, missed))


def _largest_impulses(system: System, made: StepProblem) -> np.ndarray | None:
    """h f A of each contact, (C,) [N s], infinite where it never crushes; None: no joint does."""
    strength = system.assembly.laws.crushing
    if made.springs is None or not strength.any():
        return None
    f = strength[tuple(made.rows.groups.T)]
    on = made.springs.elastic & (f > 0.0)
    return np.where(on, system.constants.step * f * made.springs.area, np.inf) if on.any() else None


def _softened(made: StepProblem, most: np.ndarray, crushes: np.ndarray, shift: np.ndarray) -> FrictionProblem:
    """The problem whose contacts that crush (C,) reach the impulses ``most`` at the velocities of the elastic law, or ``shift`` later."""
    assert made.springs is not None
    compliance, offset = made.springs.compliance.copy(), made.springs.offset.copy()
    compliance[crushes, 0] /= SOFT
    offset[crushes, 0] += (made.springs.compliance - compliance)[crushes, 0] * most[crushes] + shift[crushes]
    return replace(made.problem, compliance=compliance, offset=offset)


def book_crushing(system: System, made: StepProblem, v: np.ndarray, impulse: np.ndarray, work: SpringWork) -> SpringWork:
    """Account for the springs in a step, crushing included; ``work`` is theirs had nothing been crushed.

    Velocities (F, n) at the end of the step, its impulses (C, m) [N s].
    """
    most = None if made.crushes is None else _largest_impulses(system, made)
    if most is None or made.springs is None or made.crushes is None:
        return work
    springs, rows, h, laws = made.springs, made.rows, system.constants.step, system.assembly.laws
    on = np.flatnonzero(np.isfinite(most) & (impulse[:, 0] > 0.0))
    group, gap, p = tuple(rows.groups[on].T), made.found.gap[rows.active[on]], impulse[on, 0]
    strength, theta = laws.crushing[group], laws.theta[group]
    stiffness = springs.stiffness[on, 0]
    spring = replace(made.problem, compliance=springs.compliance, offset=springs.offset).subset(on)
    w = spring.relative_velocity(v)[:, 0] + springs.compliance[on, 0] * p
    support = rows.offset[on, 0] - np.where(gap > system.constants.closed, gap / h, 0.0)
    u = w - springs.compliance[on, 0] * p - springs.offset[on, 0] + support
    landing = (gap - (1.0 - theta) * h * springs.before[on, 0] > 0.0) & ~springs.bonded[on]
    slipped = np.where(made.crushes[on], np.maximum(0.0, -np.where(landing, 1.0, theta) * h * w), 0.0)
    shortened = -gap - theta * h * u  # at the end, of spring and crushed material together [m]
    rest = shortened - slipped
    beyond = np.maximum(0.0, rest - strength / stiffness)
    force = stiffness * springs.area[on]
    lost = p / h * slipped + force * beyond * (rest - 0.5 * beyond)
    kept = force * (np.maximum(shortened, 0.0) ** 2 - np.maximum(rest - beyond, 0.0) ** 2)
    by = np.zeros(len(made.found.gap))
    by[rows.active[on]] = slipped + beyond
    return work._replace(after=work.after - 0.5 * float(kept.sum()), crushing=float(lost.sum()), crushed=by)
