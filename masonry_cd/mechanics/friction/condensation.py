# SPDX-License-Identifier: GPL-3.0-or-later
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

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.small_blocks import STEP, dot, room_for
from masonry_cd.mechanics.linalg.sorting import sorted_by

DEPENDENT = 1e-12  # share of a row, in the norm of M^-1, that may be off those before it without an unknown: rounding leaves 1e-15


class Condensed(NamedTuple):
    """An equivalent friction problem, and what ties it to the one that it stands for."""

    problem: FrictionProblem
    velocity: np.ndarray  # (B, r) what stands for given velocities; (0, r) where none were
    kept: np.ndarray  # (C, 2, m) bool: rows that add an unknown


class _Rows(NamedTuple):
    """Arrays that the kernel fills."""

    jacobian: np.ndarray  # (C, 2, m, r) L
    offset: np.ndarray  # (C, m) b, to which H v_free is added
    velocity: np.ndarray  # (B, r) or (0, r)
    kept: np.ndarray  # (C, 2, m)
    width: np.ndarray  # (B,) unknowns of each body


def condense(problem: FrictionProblem, velocity: np.ndarray | None = None) -> Condensed:
    """The equivalent problem; ``velocity`` (B, n): velocities to be put in its unknowns."""
    arrays, (bodies, n), m = problem.arrays(), problem.v_free.shape, problem.dimension
    start, sides = sides_of_bodies(arrays.places, bodies)
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
        problem, inverse_mass=identities(bodies, count), v_free=np.zeros((bodies, count)),
        geometry=Geometry.by_rows(rows.jacobian[..., :count]), offset=rows.offset, width=width,
    )  # fmt: skip
    return Condensed(condensed, rows.velocity[:, :count], rows.kept)


@lru_cache(maxsize=4)
def identities(bodies: int, n: int) -> np.ndarray:
    """Unit masses (B, n, n), the same for each step. Nothing writes to them; were they marked so, every solver would be compiled again."""
    out = np.zeros((bodies, n, n))
    out[:, np.arange(n), np.arange(n)] = 1.0
    return out


@entry()
def sides_of_bodies(bodies, count):
    """The sides of contacts (C, 2) on each of ``count`` bodies: starts (B + 1,), and 2 c + side, contact by contact.

    Other numbers than 0 to B - 1 are supports.
    """
    key = np.empty(bodies.size, dtype=np.int64)
    for c in range(len(bodies)):
        for s in range(2):
            key[2 * c + s] = bodies[c, s] if 0 <= bodies[c, s] < count else count
    sides, start = sorted_by(key, count + 1)
    return start[:-1], sides


@entry()
def fill_rows(problem: ProblemArrays, start: np.ndarray, sides: np.ndarray, moved: np.ndarray, rows: _Rows) -> None:
    """L of all bodies by :func:`sides_of_bodies`, row by row; ``moved`` (B, n) are velocities less v_free, or (0, n)."""
    n, room, jacobian = problem.free.shape[1], rows.jacobian.shape[3], problem.geometry.jacobian
    basis, along, vector, scratch = np.empty((room, n)), np.empty(room), np.empty(n), np.empty((2, n * n))
    for b in range(len(start) - 1):
        rank, used = 0, unknowns_felt(jacobian, sides[start[b] : start[b + 1]])
        own, root = vector[:used], scratch[0, : used * used].reshape((used, used))
        if start[b] < start[b + 1]:
            factorise_mass(problem.inverse[b], used, scratch[1].reshape((n, n)), root)
        for e in range(start[b], start[b + 1]):
            c, side = sides[e] // 2, sides[e] % 2
            for i in range(len(problem.m)):
                row, line = jacobian[c, side, i], rows.jacobian[c, side, i]
                rows.offset[c, i] += dot(row, problem.free[b], used)
                turn_row(root, row, own)  # g = C^T h
                size = np.sqrt(dot(own, own, used))
                left = take_off_basis(basis, rank, own, line, along)
                if not left > DEPENDENT * size or rank == min(used, room):
                    continue
                for k in range(used):
                    basis[rank, k] = own[k] / left
                line[rank] = left
                if len(moved):
                    rows.velocity[b, rank] = (dot(row, moved[b], used) - dot(line, rows.velocity[b], rank)) / left
                rows.kept[c, side, i] = True
                rank += 1
        rows.width[b] = rank


@borrower()
def unknowns_felt(jacobian, sides):
    """How many unknowns of a body, counted from the first, its contacts feel: what comes after them, as the room that the largest mesh
    leaves in smaller ones, changes nothing of C^T H^T, since C is lower triangular."""
    m, felt = jacobian.shape[2], 0
    for e in sides:
        for i in range(m):
            row = jacobian[e // 2, e % 2, i]
            k = len(row)
            while k > felt and row[k - 1] == 0.0:
                k -= 1
            felt = max(felt, k)
    return felt


@borrower(fastmath={"contract"})
def factorise_mass(inverse, n, work, out):
    """The first n rows and columns of C, M^-1 = C C^T, whose lower triangle goes to ``out`` (n, n); ``work``, as large as M, is scratch."""
    for i in range(n):
        for j in range(i, n):
            work[i, j] = inverse[i, j]
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
def turn_row(root, row, out):
    """out (k,) = C^T h of the first k entries of a row h, for C (k, k) lower triangular."""
    for i in range(len(out)):
        out[i] = 0.0
    for i in range(len(out)):
        factor, line = row[i], root[i]
        if factor != 0.0:
            for k in range(i + 1):
                out[k] += factor * line[k]


@borrower(fastmath={"contract", "reassoc"})
def take_off_basis(basis, rank, own, line, along):
    """Fill line (rank,) with the components of own (n,) along a basis, and leave what is across it; returns the length of that.

    Gram and Schmidt, all components at once, and again, which leaves it across to rounding (Giraud, Langou, Rozloznik & van den Eshof,
    Numer. Math. 101, 2005). Four lines are taken at a time. ``along`` (rank,) is scratch.
    """
    n, fours = len(own), rank - rank % 4
    for j in range(rank):
        line[j] = 0.0
    for _ in range(2):
        for j in range(0, fours, 4):
            b0, b1, b2, b3 = basis[j], basis[j + 1], basis[j + 2], basis[j + 3]
            t0 = t1 = t2 = t3 = 0.0
            for k in range(n):
                x = own[k]
                t0 += b0[k] * x
                t1 += b1[k] * x
                t2 += b2[k] * x
                t3 += b3[k] * x
            along[j], along[j + 1], along[j + 2], along[j + 3] = t0, t1, t2, t3
        for j in range(fours, rank):
            along[j] = dot(basis[j], own, n)
        for j in range(0, fours, 4):
            b0, b1, b2, b3 = basis[j], basis[j + 1], basis[j + 2], basis[j + 3]
            t0, t1, t2, t3 = along[j], along[j + 1], along[j + 2], along[j + 3]
            for k in range(n):
                own[k] -= b0[k] * t0 + b1[k] * t1 + b2[k] * t2 + b3[k] * t3
        for j in range(fours, rank):
            for k in range(n):
                own[k] -= along[j] * basis[j, k]
        for j in range(rank):
            line[j] += along[j]
    return np.sqrt(dot(own, own, n))
