r"""Non-linear Gauss-Seidel: the method of the contact dynamics literature.

Contact after contact, the impulse is replaced by the exact solution of its law with all others held (Jean, Comput.
Methods Appl. Mech. Engrg. 177, 1999; Jourdan, Alart & Jean, ibid. 155, 1998), without W ever being formed: with M^-1 = L L^T and
G = H L,

    w_c = q_c + G_c y + C_c p_c,     p_c <- law(w_c - (W + C)_cc p_c),     y <- y + G_c^T (new p_c - old p_c).

In one sweep the error propagates by about one joint, so tall stacks need many. The order is drawn anew each sweep, joint by joint (the
contacts of a joint stay together), from a seed: equal seeds give equal bits.

From ``COLOURED`` contacts on, the joints are coloured so that no two of a colour share a moving block; a sweep takes the colours in random
order and the joints of a colour in parallel. The number of contacts decides it, not the number of threads, so threads change no bit.
"""

from __future__ import annotations

import numpy as np
from numba import config, set_num_threads

from masonry_cd.mechanics.friction.local_blocks import local_arrays
from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution, first_impulse
from masonry_cd.mechanics.solvers.local_kernels import nlgs_local
from masonry_cd.mechanics.solvers.nlgs_kernels import (
    NlgsSettings,
    begin_sweeps,
    colour_joints,
    end_sweeps,
    error_after_sweeps,
    nlgs_bodies,
    sweep_coloured,
)
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 10_000  # sweeps
EVERY = 10  # sweeps between two measurements of the error
COLOURED = 5000  # contacts
CHUNK = 32  # joints that a thread takes at a time


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Sweep until the natural map error is below the tolerance, or the limit of sweeps is reached.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts sweeps.
        start: its impulse (C, m) is the first iterate; None starts from zero.
    """
    impulse = first_impulse(problem, start)
    limit = options.limit(LIMIT)
    if isinstance(problem, FrictionProblem) and problem.contacts == 0:  # blocks in the air; nothing is compiled for them
        return Solution(impulse, problem.body_velocity(impulse), 0, _reason(0.0, options))
    if isinstance(problem, FrictionProblem) and problem.contacts >= COLOURED:
        return _solve_coloured(problem, options, impulse, limit)
    settings = NlgsSettings(options.tolerance, limit, options.seed, EVERY)
    if isinstance(problem, FrictionProblem):
        velocity = np.empty(problem.v_free.shape)
        sweeps, error = nlgs_bodies(problem.arrays(), impulse, velocity, settings)
        return Solution(impulse, velocity, sweeps, _reason(error, options))
    given, own = local_arrays(problem)
    sweeps, error = nlgs_local(given, own, impulse, settings)
    return Solution(impulse, None, sweeps, _reason(error, options))


def _solve_coloured(problem: FrictionProblem, options: Options, impulse: np.ndarray, limit: int) -> Solution:
    """Sweep colour by colour, on ``options.threads`` threads."""
    given, velocity, random = problem.arrays(), np.empty(problem.v_free.shape), np.random.default_rng(options.seed)
    scaled, error = begin_sweeps(given, impulse)
    joints = colour_joints(scaled.bodies, len(velocity))
    colours, sweeps = np.flatnonzero(np.diff(joints.colour)), 0
    set_num_threads(max(1, min(options.threads, config.NUMBA_NUM_THREADS)))
    while error > options.tolerance and sweeps < limit:
        for _ in range(min(EVERY, limit - sweeps)):
            sweep_coloured(scaled, joints, random.permutation(colours), CHUNK)
            sweeps += 1
        error = error_after_sweeps(scaled)
    end_sweeps(scaled, given.v_free, impulse, velocity)
    return Solution(impulse, velocity, sweeps, _reason(error, options))


def _reason(error: float, options: Options) -> str:
    """Say how it ended."""
    return "nlgs: converged" if error <= options.tolerance else f"nlgs: sweep limit reached at an error of {error:.1e}"
