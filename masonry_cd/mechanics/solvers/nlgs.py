# SPDX-License-Identifier: GPL-3.0-or-later
r"""Non-linear Gauss-Seidel: the method of the contact dynamics literature.

Contact after contact, the impulse is replaced by the exact solution of its law with all others held (Jean, Comput.
Methods Appl. Mech. Engrg. 177, 1999; Jourdan, Alart & Jean, ibid. 155, 1998), without W ever being formed: with M^-1 = L L^T and
G = H L,

    w_c = q_c + G_c y + C_c p_c,     p_c <- law(w_c - (W + C)_cc p_c),     y <- y + G_c^T (new p_c - old p_c).

In one sweep the error propagates by about one joint, so tall stacks need many. The joints are taken in an order that is drawn again in each
sweep from a seed: equal seeds give equal bits. From COLOURED contacts on they are coloured so that no two of a colour share a moving block;
then the colours come in random order, and the joints of a colour in parallel. The number of contacts decides it, so threads change no bit.
Fewer joints go one by one: colour by colour a pile of 14 rough balls was left at 2e-6 after 10,000 sweeps, where joint by joint it took 720
to 1e-9. The best impulses measured are the answer.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.friction.law_terms import PARTS
from masonry_cd.mechanics.friction.problem import Problem, Solution, first_impulse
from masonry_cd.mechanics.linalg.threads import run_by_team
from masonry_cd.mechanics.solvers.nlgs_kernels import (
    ColouredJoints,
    SweepHistory,
    SweepSettings,
    colour_joints,
    end_sweeps,
    sweep_bodies,
)
from masonry_cd.mechanics.solvers.nlgs_sweep import scaled_problem
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 10_000  # sweeps
COLOURED = 5000  # contacts
EVERY = 10  # sweeps between two measurements of the error, which decide on restarts of the extrapolation, too


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Sweep until the natural map error is below the tolerance, or the limit of sweeps is reached.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts sweeps.
        start: its impulse (C, m) is the first iterate; None starts from zero.
    """
    return solve_by_sweeps("nlgs", False, problem, options, start)


def solve_by_sweeps(name: str, extrapolated: bool, problem: Problem, options: Options, start: Solution | None) -> Solution:
    """:func:`solve` by sweeps extrapolated as accelerated.py says, or plain; ``name`` is the solver's, for the reason."""
    impulse = first_impulse(problem, start)
    settings = SweepSettings(options.tolerance, options.limit(LIMIT), EVERY, extrapolated, options.seed)
    if problem.contacts == 0:  # blocks in the air; nothing is compiled for them
        return Solution(impulse, problem.body_velocity(impulse), 0, options.reason(name, 0.0), error=0.0)
    given, velocity = problem.arrays(), np.empty(problem.v_free.shape)
    scaled = scaled_problem(given, impulse)
    joints, threads = colour_joints(scaled.problem.places, len(velocity)), options.threads
    if len(given.coupling.indptr) or (not extrapolated and problem.contacts < COLOURED):
        count = len(joints.order)
        joints, threads = ColouredJoints(joints.start, np.arange(count), np.arange(count + 1)), 1  # a colour for each
    history = SweepHistory(np.empty_like(impulse), np.empty_like(scaled.y), np.empty_like(impulse), np.empty(PARTS))
    sweeps, error = run_by_team(sweep_bodies, threads, scaled, joints, history, settings)
    end_sweeps(scaled, given.free, impulse, velocity)
    return Solution(impulse, velocity, sweeps, options.reason(name, error, "sweep limit reached"), error=error)
