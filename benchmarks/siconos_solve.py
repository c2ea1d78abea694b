# SPDX-License-Identifier: GPL-3.0-or-later
r"""Solve a friction problem file with Siconos and write down its answer.

    python siconos_solve.py problem.npz solution.npz --solver NSGS --tolerance 1e-8

This file runs under the Python that has Siconos (Debian: the system's, package ``python3-siconos``) and needs numpy and scipy besides.
The problem: u = W r + q in CSR arrays W_data, W_indices, W_indptr, with q, mu, rows (n, t1, t2) per contact. Solver options are those
of Siconos but for the tolerance, on its own error measure |F_nat| / |q|, and the limit of iterations. Only the solve is timed.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy import sparse
from siconos import numerics


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Solve a friction problem file with Siconos.")
    parser.add_argument("problem")
    parser.add_argument("solution")
    parser.add_argument("--solver", default="NSGS")
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--max-iterations", type=int, default=1_000_000)
    given = parser.parse_args()
    with np.load(given.problem) as file:
        q, mu = file["q"].ravel(), file["mu"].ravel()
        w = sparse.csr_matrix((file["W_data"], file["W_indices"], file["W_indptr"]), shape=(q.size, q.size)).tocsc()
    w.indices, w.indptr = w.indices.astype(np.int64), w.indptr.astype(np.int64)  # as Siconos wants them
    problem = numerics.FrictionContactProblem(3, len(mu), w, q, mu)
    options = numerics.SolverOptions(getattr(numerics, f"SICONOS_FRICTION_3D_{given.solver}"))
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = given.max_iterations
    options.dparam[numerics.SICONOS_DPARAM_TOL] = given.tolerance
    reaction, velocity = np.zeros(q.size), np.zeros(q.size)
    begin = time.perf_counter()
    status = numerics.fc3d_driver(problem, reaction, velocity, options)
    seconds = time.perf_counter() - begin
    iterations = int(options.iparam[numerics.SICONOS_IPARAM_ITER_DONE])
    np.savez(given.solution, r=reaction.reshape(-1, 3), seconds=seconds, iterations=iterations, status=status)


if __name__ == "__main__":
    main()
