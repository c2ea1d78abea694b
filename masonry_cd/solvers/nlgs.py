r"""Non-linear Gauss-Seidel: the method of the contact dynamics literature.

Contact after contact, the impulse is replaced by the exact answer to the velocity that all the others leave it (Jean, Comput.
Methods Appl. Mech. Engrg. 177, 1999; Jourdan, Alart & Jean, ibid. 155, 1998), without W ever being formed: with M^-1 = L L^T and
G = H L,

    w_c = q_c + G_c y + C_c p_c,     p_c <- law(w_c - (W + C)_cc p_c),     y <- y + G_c^T (new p_c - old p_c).

One sweep carries news by about one joint, so tall stacks need many. The order is drawn anew each sweep, joint by joint (the
contacts of a joint stay together), from a seed: equal seeds give equal bits.

From ``COLOURED`` contacts on, the joints are coloured so that no two of a colour share a moving block; a sweep takes the colours in random
order and the joints of a colour in parallel. The number of contacts decides it, not the number of threads, so threads change no bit.
"""

from __future__ import annotations

import numpy as np
from numba import config, set_num_threads

from masonry_cd.friction.coulomb_law import P
from masonry_cd.friction.problem import FrictionProblem, LocalProblem, Problem, Solution
from masonry_cd.solvers.local_kernels import nlgs_local
from masonry_cd.solvers.nlgs_kernels import collect_and_measure, colour_joints, nlgs_bodies, prepare_sweeps, sweep_coloured, velocities
from masonry_cd.solvers.options import Options

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
    impulse = np.zeros((problem.contacts, problem.dimension))
    if start is not None:
        impulse[:] = start.impulse
    limit = LIMIT if options.max_iterations is None else options.max_iterations
    if isinstance(problem, FrictionProblem) and problem.contacts >= COLOURED:
        return _solve_coloured(problem, options, impulse, limit)
    if isinstance(problem, FrictionProblem):
        velocity = np.empty(problem.v_free.shape)
        sweeps, error = nlgs_bodies(*problem.arrays()[:7], impulse, velocity, options.tolerance, limit, options.seed, EVERY)
        return Solution(impulse, velocity, sweeps, _reason(error, options))
    sweeps, error = nlgs_local(*block_arrays(problem), problem.q, problem.mu, impulse, options.tolerance, limit, options.seed, EVERY)
    return Solution(impulse, None, sweeps, _reason(error, options))


def _solve_coloured(problem: FrictionProblem, options: Options, impulse: np.ndarray, limit: int) -> Solution:
    """Sweep colour by colour, on as many threads as asked for."""
    factor, g, index, law = prepare_sweeps(*problem.arrays()[:7], impulse)
    bodies, n = problem.v_free.shape
    start, order, ends = colour_joints(index, bodies)
    colours = np.flatnonzero(np.diff(ends))
    y, velocity, random = np.empty((bodies + 1, n)), np.empty((bodies, n)), np.random.default_rng(options.seed)
    set_num_threads(max(1, min(options.threads, config.NUMBA_NUM_THREADS)))
    error, sweeps = collect_and_measure(g, y, index, law), 0
    while error > options.tolerance and sweeps < limit:
        for _ in range(min(EVERY, limit - sweeps)):
            sweep_coloured(g, y, index, law, start, order, random.permutation(colours), ends[:-1], ends[1:], CHUNK)
            sweeps += 1
        error = collect_and_measure(g, y, index, law)
    impulse[:] = law[:, P : P + problem.dimension]
    velocities(factor, problem.v_free, y, velocity)
    return Solution(impulse, velocity, sweeps, _reason(error, options))


def block_arrays(problem: LocalProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """W of a local problem in blocks: data (nnz, m, m), indices, indptr, and its diagonal blocks (C, m, m).

    Diagonal blocks that are zero are given as those of a typical contact: whatever stands there, the impulse is right when it stays.
    """
    m = problem.dimension
    blocks, own, scales = problem.w.tobsr((m, m)), problem.delassus_diagonal(), problem.scales()
    nothing = np.trace(own, axis1=1, axis2=2) < 0.5 * m * scales
    own[nothing] = scales[nothing, None, None] * np.eye(m)
    return (
        np.ascontiguousarray(blocks.data, dtype=np.float64),
        blocks.indices.astype(np.int64),
        blocks.indptr.astype(np.int64),
        own,
    )


def _reason(error: float, options: Options) -> str:
    """Say how it ended."""
    return "nlgs: converged" if error <= options.tolerance else f"nlgs: sweep limit reached at an error of {error:.1e}"
