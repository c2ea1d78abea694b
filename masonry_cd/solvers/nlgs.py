r"""Non-linear Gauss-Seidel: the method of the contact dynamics literature.

Contact after contact, the impulse is replaced by the exact answer to the velocity that all the others leave it (Jean, Comput.
Methods Appl. Mech. Engrg. 177, 1999; Jourdan, Alart & Jean, ibid. 155, 1998), without W ever being formed: with M^-1 = L L^T and
G = H L,

    u_c = q_c + G_c y,     p_c <- law(u_c - W_cc p_c),     y <- y + G_c^T (new p_c - old p_c).

One sweep carries news by about one joint, so tall stacks need many. The order is drawn anew each sweep, joint by joint (the
contacts of a joint stay together), from a seed: equal seeds give equal bits.
"""

from __future__ import annotations

import numpy as np

from masonry_cd import coulomb
from masonry_cd.friction import FrictionProblem, LocalProblem, Problem, Solution
from masonry_cd.solvers.options import Options

LIMIT = 10_000  # sweeps
EVERY = 10  # sweeps between two measurements of the error


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
    if isinstance(problem, FrictionProblem):
        velocity = np.empty(problem.v_free.shape)
        sweeps, error = coulomb.nlgs_bodies(*problem.arrays(), impulse, velocity, options.tolerance, limit, options.seed, EVERY)
        return Solution(impulse, velocity, sweeps, _reason(error, options))
    sweeps, error = coulomb.nlgs_local(
        *block_arrays(problem), problem.q, problem.mu, impulse, options.tolerance, limit, options.seed, EVERY
    )
    return Solution(impulse, None, sweeps, _reason(error, options))


def block_arrays(problem: LocalProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """W of a local problem in blocks: data (nnz, m, m), indices, indptr, and its diagonal blocks (C, m, m)."""
    m = problem.dimension
    blocks = problem.w.tobsr((m, m))
    return (
        np.ascontiguousarray(blocks.data, dtype=np.float64),
        blocks.indices.astype(np.int64),
        blocks.indptr.astype(np.int64),
        problem.delassus_diagonal(),
    )


def _reason(error: float, options: Options) -> str:
    """Say how it ended."""
    return "nlgs: converged" if error <= options.tolerance else f"nlgs: sweep limit reached at an error of {error:.1e}"
