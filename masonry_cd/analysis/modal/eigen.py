# SPDX-License-Identifier: GPL-3.0-or-later
r"""The lowest modes of free vibration: K phi = lambda M phi with lambda = (2 pi f)^2.

Shift-invert Lanczos (Ericsson & Ruhe, Math. Comput. 35, 1980) looks for the largest eigenvalues 1 / (lambda + s) of
(K + s M)^-1 M. One sparse factor serves all its solves: SuperLU's or, in a fifth of the time but with one more package, Cholesky's by
CHOLMOD. The small shift s keeps the matrix positive definite where the supports leave a rigid motion free; such motions come out with
lambda = 0 and are counted, not listed as modes.

The share of the mass that takes part in mode i when the base moves in direction d is (phi_i^T M r_d)^2 / m for modes scaled to
phi^T M phi = 1, where r_d is the unit translation and m the total mass (Clough & Penzien, Dynamics of Structures, chapter 12).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require

DENSE = 600  # unknowns up to which a dense solver is used
SHIFT = 1e-6  # of the scale that the caller gives
RIGID = 1e-8  # eigenvalues below this share of the scale belong to rigid motions; a column 1,000 times taller than wide lies above it


@dataclass(frozen=True, eq=False)
class Eigenpairs:
    """The lowest n modes of N unknowns."""

    values: np.ndarray  # (n,) (2 pi f)^2 [1/s2], ascending
    vectors: np.ndarray  # (n, N) with phi^T M phi = 1
    rigid: int  # rigid motions that the supports leave free, not listed

    @property
    def frequencies(self) -> np.ndarray:
        """(n,) [Hz]."""
        return np.sqrt(self.values) / (2.0 * np.pi)


Solve = Callable[[np.ndarray], np.ndarray]  # the solution (N,) for a right-hand side (N,)


def by_superlu(matrix: sparse.spmatrix) -> Solve:
    """Solutions with a sparse symmetric positive definite matrix (N, N), by the factor of SuperLU.

    Raises:
        ArithmeticError: the matrix is not positive definite: rows are not exchanged, so its pivots have the signs of its eigenvalues.
    """
    symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    try:
        factor = splu(matrix.tocsc(), **symmetric)
    except RuntimeError as singular:
        raise ArithmeticError(str(singular)) from None
    if factor.U.diagonal().min() <= 0.0:
        raise ArithmeticError("a pivot is not positive")
    return factor.solve


class ByCholmod:
    """Solutions with a sparse symmetric positive definite matrix, by the factor of CHOLMOD; ArithmeticError of one that is not."""

    def __init__(self, matrix: sparse.spmatrix) -> None:
        require("a factor of the modal analysis", "cvxopt")
        import cvxopt
        import cvxopt.cholmod

        lower = sparse.tril(matrix, format="coo")
        rows, columns = (cvxopt.matrix(index.astype(np.int64)) for index in lower.coords)
        self._cvxopt = cvxopt
        packed = cvxopt.spmatrix(cvxopt.matrix(lower.data), rows, columns, matrix.shape)
        self._factor = cvxopt.cholmod.symbolic(packed)
        cvxopt.cholmod.numeric(packed, self._factor)

    def __call__(self, right: np.ndarray) -> np.ndarray:
        """The solution (N,) for a right-hand side (N,)."""
        out = self._cvxopt.matrix(np.ascontiguousarray(right, dtype=float))
        self._cvxopt.cholmod.solve(self._factor, out)
        return np.array(out).ravel()


def lowest_modes(
    stiffness: sparse.csr_matrix, mass: sparse.csr_matrix, count: int, scale: float, factorise: Callable[..., Solve] = by_superlu
) -> Eigenpairs:
    """The lowest modes that are no rigid motions.

    Args:
        stiffness: (N, N) symmetric, positive semidefinite [N/m].
        mass: (N, N) symmetric, positive definite [kg].
        count: requested number of modes; fewer come back where there are fewer unknowns.
        scale: an eigenvalue typical of the structure, E / (density length^2) [1/s2]; shift and threshold are shares of it.
        factorise: makes what solves with a sparse matrix, :func:`by_superlu` or :class:`ByCholmod`.

    Raises:
        InputError: stiffness and mass are so far apart that the factorisation fails.
    """
    size = stiffness.shape[0]
    if size <= DENSE:
        values, columns = linalg.eigh(stiffness.toarray(), mass.toarray())
        rigid = int((values < RIGID * scale).sum())
        return _sorted(stiffness, mass, columns[:, rigid : rigid + count], rigid)
    try:
        solve = factorise(stiffness + SHIFT * scale * mass)
    except ArithmeticError:
        raise InputError("modal", "the stiffness matrix is not positive definite; check for blocks without volume") from None
    inverse = LinearOperator((size, size), matvec=solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(size)  # fixed, so that two runs agree
    wanted, rigid = count, 0
    while True:
        values, columns = eigsh(stiffness, wanted + rigid, mass, sigma=-SHIFT * scale, OPinv=inverse, v0=start)
        columns = columns[:, np.argsort(values)]
        found = int((np.sort(values) < RIGID * scale).sum())
        if found <= rigid:
            return _sorted(stiffness, mass, columns[:, found:][:, :count], found)
        rigid = found


def _sorted(stiffness: sparse.csr_matrix, mass: sparse.csr_matrix, columns: np.ndarray, rigid: int) -> Eigenpairs:
    """Rayleigh quotients of the modes, which square the error of their vectors, in ascending order."""
    generalised = np.einsum("nk,nk->k", columns, mass @ columns)
    columns = columns / np.sqrt(generalised)
    values = np.einsum("nk,nk->k", columns, stiffness @ columns)
    order = np.argsort(values, kind="stable")
    return Eigenpairs(values[order], np.ascontiguousarray(columns[:, order].T), rigid)


def participation(pairs: Eigenpairs, carried: np.ndarray, total: float) -> np.ndarray:
    """Share of the mass that takes part in each mode, (n, 3) for base motion in x, y and z.

    Args:
        pairs: modes of the N free unknowns.
        carried: M r_d at the free unknowns, (N, 3) [kg].
        total: mass of the free blocks [kg].
    """
    return np.asarray((pairs.vectors @ carried) ** 2 / total)
