r"""Static condensation: bodies with many unknowns, of which contacts feel few, replaced by equivalent ones with few.

Of a body with the mass matrix M (n, n) and the rows H of the contacts on it, k of them, the friction problem knows the share

    W = H M^-1 H^T     (k, k),     of rank r <= min(k, n),

of the Delassus operator, and its free velocities H v_free. A block cut into elements has many nodes, most of them inside it or on faces
that touch nothing. A factor of its share, W = L L^T with L (k, r) lower triangular, is the equivalent body: r unknowns y of unit mass, the
rows L in the place of H, and y_free = 0 with H v_free in the offsets,

    M v = M v_free + H^T p,  u = H v + b      <=>      y = L^T p,  u = L y + H v_free + b,

the same problem for the impulses, to rounding, whatever solves it. (A Schur complement of M with the inner nodes eliminated is the same
thing in other unknowns.) With M^-1 = C C^T it is H C = L Q^T, from the rows h C made orthogonal one after another: no digits are lost where
rows nearly repeat, as Cholesky's method would lose half of them. Rows that depend on those before them (two corners of overlaps at one
node, a third contact on a straight edge) add no unknown. Rows come in the order of the contacts, not by their length: from step to step y
then has one meaning as long as the same rows add unknowns, and old factors stay good.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from masonry_cd.friction.operators import ProblemArrays
from masonry_cd.friction.problem import FrictionProblem
from masonry_cd.jit import borrower, entry
from masonry_cd.linalg.small_blocks import STEP, copy_flat, dot, room_for
from masonry_cd.linalg.triangular import add_columns

DEPENDENT = 1e-12  # share of a row, in the norm of M^-1, that may be off those before it without an unknown: rounding leaves 1e-15


class Condensed(NamedTuple):
    """An equivalent friction problem, and what ties it to the one that it stands for."""

    problem: FrictionProblem
    velocity: np.ndarray  # (B, r) what stands for given velocities; (0, r) where none were
    kept: np.ndarray  # (C, 2, m) bool: rows that add an unknown


class _Rows(NamedTuple):
    """What the kernel fills."""

    jacobian: np.ndarray  # (C, 2, m, r) L
    offset: np.ndarray  # (C, m) b, to which H v_free is added
    velocity: np.ndarray  # (B, r) or (0, r)
    kept: np.ndarray  # (C, 2, m)
    width: np.ndarray  # (B,) unknowns of each body


def condense(problem: FrictionProblem, velocity: np.ndarray | None = None) -> Condensed:
    """The equivalent problem; ``velocity`` (B, n): velocities to be put in its unknowns."""
    arrays, (bodies, n), m = problem.arrays(), problem.v_free.shape, problem.dimension
    start, sides = sides_of_bodies(arrays.bodies, bodies)
    most = room_for(min(n, m * int(np.diff(start).max(initial=0))))
    moved = np.empty((0, n)) if velocity is None else velocity - problem.v_free
    rows = _Rows(
        np.zeros((problem.contacts, 2, m, most)), arrays.offset.copy(), np.zeros((len(moved), most)),
        np.zeros((problem.contacts, 2, m), dtype=np.bool_), np.empty(bodies, dtype=np.int64),
    )  # fmt: skip
    fill_rows(arrays, start, sides, moved, rows)
    count = room_for(int(rows.width.max(initial=0)))
    width = np.maximum(-(-rows.width // STEP) * STEP, STEP)
    condensed = replace(
        problem, inverse_mass=_identities(bodies, count), v_free=np.zeros((bodies, count)), jacobian=rows.jacobian[..., :count],
        offset=rows.offset, width=width,
    )  # fmt: skip
    return Condensed(condensed, rows.velocity[:, :count], rows.kept)


@lru_cache(maxsize=4)
def _identities(bodies: int, n: int) -> np.ndarray:
    """Unit masses (B, n, n), the same for each step."""
    out = np.zeros((bodies, n, n))
    out[:, np.arange(n), np.arange(n)] = 1.0
    out.flags.writeable = False
    return out


@entry()
def sides_of_bodies(bodies, count):
    """The sides of contacts (C, 2) on each of the bodies: starts (B + 1,), and 2 c + side, contact by contact."""
    start = np.zeros(count + 1, dtype=np.int64)
    for c in range(len(bodies)):
        for side in range(2):
            if bodies[c, side] >= 0:
                start[bodies[c, side] + 1] += 1
    for b in range(count):
        start[b + 1] += start[b]
    at, sides = start[:-1].copy(), np.empty(start[count], dtype=np.int64)
    for c in range(len(bodies)):
        for side in range(2):
            b = bodies[c, side]
            if b >= 0:
                sides[at[b]] = 2 * c + side
                at[b] += 1
    return start, sides


@entry()
def fill_rows(problem: ProblemArrays, start: np.ndarray, sides: np.ndarray, moved: np.ndarray, rows: _Rows) -> None:
    """L of all bodies by :func:`sides_of_bodies`, row by row; ``moved`` (B, n) are velocities less v_free, or (0, n)."""
    n, room = problem.v_free.shape[1], rows.jacobian.shape[3]
    basis, own, root = np.empty((room, n)), np.empty(n), np.empty((2, n, n))
    for b in range(len(start) - 1):
        rank = 0
        if start[b] < start[b + 1]:
            factorise_mass(problem.inverse_mass[b], n, root[1], root[0])
        for e in range(start[b], start[b + 1]):
            c, side = sides[e] // 2, sides[e] % 2
            for i in range(len(problem.m)):
                row, line = problem.jacobian[c, side, i], rows.jacobian[c, side, i]
                rows.offset[c, i] += dot(row, problem.v_free[b], n)
                add_columns(root.reshape(root.size), 0, n, row, own, problem.n)  # g = C^T h
                size = np.sqrt(dot(own, own, n))
                left = take_off_basis(basis, rank, own, line)
                if not left > DEPENDENT * size or rank == min(n, room):
                    continue
                for k in range(n):
                    basis[rank, k] = own[k] / left
                line[rank] = left
                if len(moved):
                    rows.velocity[b, rank] = (dot(row, moved[b], n) - dot(line, rows.velocity[b], rank)) / left
                rows.kept[c, side, i] = True
                rank += 1
        rows.width[b] = rank


@borrower(fastmath={"contract"})
def factorise_mass(inverse, n, work, out):
    """C of M^-1 = C C^T, lower triangular; ``work`` (n, n) is scratch."""
    copy_flat(inverse, work)
    out[:] = 0.0
    for k in range(n):
        line = work[k]
        scale = 1.0 / np.sqrt(line[k])
        for i in range(k, n):
            line[i] *= scale
            out[i, k] = line[i]
        for i in range(k + 1, n):
            factor, other = line[i], work[i]
            if factor != 0.0:  # what is rigid does not couple with strains
                for j in range(i, n):
                    other[j] -= factor * line[j]


@borrower(fastmath={"contract"})
def take_off_basis(basis, rank, own, line):
    """Fill line (rank,) with the components of own (n,) along a basis, and leave what is across it; returns the length of that.

    Gram and Schmidt, twice, which leaves it across to rounding (Giraud, Langou & Rozloznik, Comput. Math. Appl. 50, 2005).
    """
    n = len(own)
    for j in range(rank):
        line[j] = 0.0
    for _ in range(2):
        for j in range(rank):
            along = dot(basis[j], own, n)
            line[j] += along
            for k in range(n):
                own[k] -= along * basis[j, k]
    return np.sqrt(dot(own, own, n))
