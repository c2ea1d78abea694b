# SPDX-License-Identifier: GPL-3.0-or-later
r"""The friction problem of one time step, its solution, and the error measures, outside any solver.

Find velocities v and contact impulses p such that

    M v = M v_free + H^T p,      w = H v + b + C p,      K* contains w + mu |w_t| n,  K contains p,  the two orthogonal,

with K the product of Coulomb's cones |p_t| <= mu p_n, K* its dual |w_t| <= w_n / mu (De Saxce & Feng, Math. Comput.
Modelling 28, 1998). b holds the velocity of the supports and, on the normal, the gap over the time step. C >= 0 is diagonal: zero for rigid
contacts, for which w = u = H v + b; for elastic ones the velocity that a unit impulse takes out of w, so that w = 0 is a spring. In the
impulses alone, with the Delassus operator W = H M^-1 H^T and q = H v_free + b:

    w = (W + C) p + q.

**Natural map error.** With d_c = trace(W_cc + C_cc) / m per contact (m = 3, planar 2) and r = p sqrt(d), z = w / sqrt(d):

    error = | r - P_K( r - (z + mu |z_t| n) ) | / | q / sqrt(d) |

It has no unit, does not change when masses or lengths are rescaled, and is zero exactly at a solution. Norms over all
contacts; if q = 0 the numerator alone is the error. The rounding error of r is added, or else impulses that have grown without bound
(a block between closing supports) would hide every residual. The measure of the literature, without the scaling (d_c = 1), stands
next to it (Acary, Bremond & Huber, "On solving contact problems with Coulomb friction", 2018).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.coupling import UNCOUPLED, Coupling
from masonry_cd.mechanics.friction.law_terms import add_velocities, error_norms, new_velocity
from masonry_cd.mechanics.friction.operators import ProblemArrays, fill_places_and_scales
from masonry_cd.mechanics.friction.solver_state import SolverState
from masonry_cd.mechanics.linalg.small_blocks import EPSILON, FULL, size_tuple

if TYPE_CHECKING:
    from scipy import sparse


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """A friction problem over bodies: C contacts with m rows each, B free bodies with n unknowns each.

    In space m = 3 (normal, two tangents) and n = 6, in a plane m = 2 and n = 3; bodies that deform have more unknowns.
    """

    inverse_mass: np.ndarray  # (B, n, n) blocks of M^-1, symmetric positive definite
    v_free: np.ndarray  # (B, n) velocities without contact [m/s, rad/s]
    bodies: np.ndarray  # (C, 2) candidate and antagonist body; -1: a support, its velocity is in the offset
    geometry: Geometry  # frames and arms of the contacts, or their rows of H
    offset: np.ndarray  # (C, m) b [m/s]
    mu: np.ndarray  # (C,) coefficients of friction
    compliance: np.ndarray  # (C, m) diagonal of C, not negative [m/s per N s], zeros: rigid contacts; (0, m): all are rigid
    width: np.ndarray | None = None  # (B,) unknowns of each body, all of unit mass; the rows of others are zero, see condensation.py

    @property
    def contacts(self) -> int:
        """Number of contacts C."""
        return len(self.mu)

    @property
    def dimension(self) -> int:
        """Rows per contact m."""
        return int(self.offset.shape[1])

    @property
    def unknowns(self) -> int:
        """Unknowns of a body, those of bodies of unit mass in the mean."""
        return int(self.v_free.shape[1]) if self.width is None else max(int(self.width.mean()), 1)

    def arrays(self) -> ProblemArrays:
        """The problem as the compiled kernels take it."""
        return self._arrays

    @cached_property
    def _arrays(self) -> ProblemArrays:
        """The arrays in the order and layout of the compiled kernels: contiguous, so that each kernel is compiled once.

        If all contacts are rigid the compliance is left out, as (0, m): the kernels then save reading it.
        """
        compliance = self.compliance if len(self.compliance) and self.compliance.any() else self.compliance[:0]
        n = self.v_free.shape[1]
        out = ProblemArrays(
            np.ascontiguousarray(self.inverse_mass, dtype=np.float64),
            np.empty((0, n, n)),
            np.ascontiguousarray(self.v_free, dtype=np.float64),
            np.empty((self.contacts, 2), np.int64),
            FULL,
            Geometry(*(np.ascontiguousarray(array, dtype=np.float64) for array in self.geometry)),
            np.ascontiguousarray(self.offset, dtype=np.float64),
            np.ascontiguousarray(self.mu, dtype=np.float64),
            np.ascontiguousarray(compliance, dtype=np.float64),
            FULL if self.width is None else np.append(self.width, 0),
            np.empty(self.contacts),
            UNCOUPLED[self.dimension],
            size_tuple(self.dimension),
            np.zeros(n) if self.geometry.is_by_rows else size_tuple(n),
        )
        fill_places_and_scales(np.ascontiguousarray(self.bodies, dtype=np.int64), out)
        return out

    @cached_property
    def jacobian(self) -> np.ndarray:
        """H by contact and body, (C, 2, m, n)."""
        return self.geometry.rows(self.bodies)

    def relative_velocity(self, v: np.ndarray) -> np.ndarray:
        """u = H v + b, (C, m), for body velocities (B, n)."""
        u = np.array(self.offset, dtype=np.float64, order="C")
        add_velocities(self.arrays(), np.ascontiguousarray(v, dtype=np.float64), u)
        return u

    def body_velocity(self, impulse: np.ndarray) -> np.ndarray:
        """v = v_free + M^-1 H^T p, (B, n), for impulses (C, m)."""
        v = np.empty(self.v_free.shape)
        new_velocity(self.arrays(), np.ascontiguousarray(impulse, dtype=np.float64), v)
        return v

    def free_relative_velocity(self) -> np.ndarray:
        """q = H v_free + b, (C, m)."""
        return self.relative_velocity(self.v_free)

    def apply(self, impulse: np.ndarray) -> np.ndarray:
        """w = (W + C) p + q, (C, m): the velocity that the law is about."""
        u = self.relative_velocity(self.body_velocity(impulse))
        return u + self.compliance * impulse if len(self.compliance) else u

    def delassus_diagonal(self) -> np.ndarray:
        """W_cc + C_cc, (C, m, m)."""
        out = np.zeros((self.contacts, self.dimension, self.dimension))
        if len(self.compliance):
            out += self.compliance[:, :, None] * np.eye(self.dimension)
        for side in range(2):
            on = self.bodies[:, side] >= 0
            h = self.jacobian[on, side]
            out[on] += np.einsum("cik,ckl,cjl->cij", h, self.inverse_mass[self.bodies[on, side]], h)
        return out

    def subset(self, kept: np.ndarray) -> FrictionProblem:
        """The problem with some of its contacts only: a mask (C,) or their indices."""
        return replace(
            self, bodies=self.bodies[kept], geometry=self.geometry.of(kept), offset=self.offset[kept], mu=self.mu[kept],
            compliance=self._compliance_of(kept),
        )  # fmt: skip

    def part(self, contacts: np.ndarray, blocks: np.ndarray, place: np.ndarray) -> FrictionProblem:
        """The problem of some blocks (indices) and the contacts (indices) on them; ``place`` (B,): their places among those blocks."""
        bodies = self.bodies[contacts]
        return FrictionProblem(
            self.inverse_mass[blocks], self.v_free[blocks], np.where(bodies >= 0, place[bodies], -1), self.geometry.of(contacts),
            self.offset[contacts], self.mu[contacts], self._compliance_of(contacts), None if self.width is None else self.width[blocks],
        )  # fmt: skip

    def _compliance_of(self, contacts: np.ndarray) -> np.ndarray:
        """That of some contacts, a mask or their indices."""
        return self.compliance[contacts] if len(self.compliance) else self.compliance

    def jacobian_matrix(self) -> sparse.csr_matrix:
        """H as a sparse matrix (C m, B n)."""
        from scipy import sparse  # a run has no use for it

        m, n = self.dimension, self.v_free.shape[1]
        rows, columns, data = [], [], []
        for side in range(2):
            on = np.flatnonzero(self.bodies[:, side] >= 0)
            row, column = on[:, None, None] * m + np.arange(m)[:, None], self.bodies[on, side][:, None, None] * n + np.arange(n)
            rows.append(np.broadcast_to(row, (len(on), m, n)).ravel())
            columns.append(np.broadcast_to(column, (len(on), m, n)).ravel())
            data.append(self.jacobian[on, side].ravel())
        entries = (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.csr_matrix(entries, (self.contacts * m, self.v_free.size))

    def to_local(self) -> LocalProblem:
        """The problem in the impulses alone, with W + C assembled as a sparse matrix."""
        from scipy import sparse

        h, n, blocks = self.jacobian_matrix(), self.v_free.shape[1], len(self.inverse_mass)
        inverse = sparse.bsr_matrix((self.inverse_mass, np.arange(blocks), np.arange(blocks + 1)), (blocks * n, blocks * n))
        delassus = h @ inverse @ h.T
        if self.compliance.any():  # not of (0, m)
            delassus += sparse.diags(self.compliance.ravel())
        return LocalProblem(delassus.tocsr(), self.free_relative_velocity(), self.mu)


@dataclass(frozen=True, eq=False)
class LocalProblem:
    """A friction problem in the impulses alone: u = W p + q. W may be slightly unsymmetric, as published ones are.

    To the solvers it is one over bodies, see operators.py: each contact has its own, which moves as the contact does.
    """

    w: sparse.csr_matrix  # (C m, C m)
    q: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)

    @property
    def contacts(self) -> int:
        """Number of contacts C."""
        return len(self.mu)

    @property
    def dimension(self) -> int:
        """Rows per contact m."""
        return int(self.q.shape[1])

    @property
    def bodies(self) -> np.ndarray:
        """The body of each contact, and none, (C, 2)."""
        return np.column_stack([np.arange(self.contacts), np.full(self.contacts, -1)])

    @property
    def v_free(self) -> np.ndarray:
        """The velocities of the bodies without contact, (C, m): q."""
        return self.q

    def arrays(self) -> ProblemArrays:
        """The problem as the compiled kernels take it."""
        return self._arrays

    @cached_property
    def _arrays(self) -> ProblemArrays:
        contacts, m = self.q.shape
        unit, nothing, scales, blocks = np.eye(m), np.zeros((contacts, m)), self.scales(), self.w.tobsr((m, m))
        jacobian = np.zeros((contacts, 2, m, m))
        jacobian[:, 0] = unit
        indptr, places = blocks.indptr.astype(np.int64), np.column_stack([np.arange(contacts), np.full(contacts, contacts)])
        data = blocks.data / np.repeat(scales, np.diff(indptr))[:, None, None]
        return ProblemArrays(
            scales[:, None, None] * unit, np.empty((0, m, m)), np.ascontiguousarray(self.q, dtype=np.float64), places, FULL,
            Geometry.by_rows(jacobian), nothing, np.ascontiguousarray(self.mu, dtype=np.float64), nothing[:0], FULL, scales,
            Coupling(np.ascontiguousarray(data), blocks.indices.astype(np.int64), indptr), size_tuple(m), np.zeros(m),
        )  # fmt: skip

    def body_velocity(self, impulse: np.ndarray) -> np.ndarray:
        """The velocities of the bodies, (C, m), for impulses (C, m): those of the contacts."""
        return self.apply(impulse)

    def free_relative_velocity(self) -> np.ndarray:
        """q, (C, m)."""
        return self.q

    def apply(self, impulse: np.ndarray) -> np.ndarray:
        """u = W p + q, (C, m)."""
        return (self.w @ impulse.ravel()).reshape(self.q.shape) + self.q

    def delassus_diagonal(self) -> np.ndarray:
        """W_cc, (C, m, m)."""
        m = self.dimension
        blocks = self.w.tobsr((m, m))
        blocks.sort_indices()
        row = np.repeat(np.arange(self.contacts), np.diff(blocks.indptr))
        out = np.zeros((self.contacts, m, m))
        on = blocks.indices == row
        out[row[on]] = blocks.data[on]
        return out

    def scales(self) -> np.ndarray:
        """d_c, (C,): trace(W_cc) / m, and the mean of the others where that is zero: no impulse changes the velocity of such a contact."""
        d = np.trace(self.delassus_diagonal(), axis1=1, axis2=2) / self.dimension
        nothing = d <= EPSILON * d.max(initial=0.0)
        d[nothing] = d[~nothing].mean() if not nothing.all() else 1.0
        return d


Problem = FrictionProblem | LocalProblem


@dataclass(eq=False)
class Solution:
    """Result of a solver. Its reason on convergence is for readers: its impulses are judged by :func:`natural_map_error`."""

    impulse: np.ndarray  # (C, m) p [N s]
    velocity: np.ndarray | None  # (B, n) v; None: that of the impulse
    iterations: int
    reason: str = ""  # why it stopped or which solver was picked, for the results
    memory: SolverState = field(default_factory=SolverState)  # what the same solver may start from next time
    error: float | None = None  # natural map error of the impulse to rounding, where it was measured on the way


def first_impulse(problem: Problem, start: Solution | None) -> np.ndarray:
    """Impulses (C, m) to begin with and to overwrite: those of another solution, or zeros [N s].

    Raises:
        ValueError: the other solution is one of other contacts.
    """
    shape = problem.contacts, problem.dimension
    if start is None:
        return np.zeros(shape)
    if start.impulse.shape != shape:
        raise ValueError(f"impulses {start.impulse.shape} of a problem of {shape[0]} contacts")
    return np.array(start.impulse, dtype=np.float64, order="C")


def natural_map_error(problem: Problem, impulse: np.ndarray, scaled: bool = True, threads: int = 1) -> float:
    """The natural map error of impulses (C, m), see the head of this file.

    w is computed from the impulses, w = (W + C) p + q, so the equation of motion holds by construction. Compiled, since it is asked once
    or twice per time step; ``threads`` that share the work change no bit.
    """
    if problem.contacts == 0:
        return 0.0
    impulse = np.ascontiguousarray(impulse, dtype=np.float64)
    given = problem.arrays() if scaled else problem.arrays()._replace(d=np.ones(problem.contacts))
    residual, size = error_norms(given, impulse, threads)
    return float(residual / size if size > 0.0 else residual)
