# SPDX-License-Identifier: GPL-3.0-or-later
"""The strains of blocks that deform over a step, as ``strain.py`` says, block by block."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.linalg.small_blocks import dot


class StrainLaw(NamedTuple):
    """Constants of the D blocks that deform, with S unknowns each: s strains, and the warps behind them."""

    block: np.ndarray  # (D,) among all blocks
    free: np.ndarray  # (D,) among the free ones
    columns: np.ndarray  # (S,) of the unknowns in a row of the state
    mass: np.ndarray  # (D, S) [kg m2], of warps [kg]
    stiffness: np.ndarray  # (D, S, S) [J]
    inverse: np.ndarray  # (D, S, S) of M^
    across: np.ndarray  # (D, s) the strain across the plane by those in it; (D, 0) in space
    normal: int  # which strain that is; -1: none
    retardation: np.ndarray  # (D,) beta [s]
    theta: float
    step: float  # h [s]


@entry()
def fill_free_strains(
    law: StrainLaw, own: np.ndarray, strain: np.ndarray, v: np.ndarray, inverse_mass: np.ndarray, v_free: np.ndarray
) -> None:
    """Fill in what stands for the mass of the strains in M^-1 (F, n, n), and their rates without contact in v_free (F, n).

    Strains (B, 6 + r) and velocities (F, n) are those at the beginning of the step; ``own`` (F,) is the place of each free block among
    those that deform, -1 where it is rigid: its strains have unit mass and stay zero.
    """
    theta, h, n, size = law.theta, law.step, v.shape[1], len(law.columns)
    first = n - size
    stretch, force = np.empty(size), np.empty(size)
    for f in range(len(v)):
        d = own[f]
        for i in range(n):
            for j in range(first if i >= first else n):
                if i >= first or j >= first:
                    inverse_mass[f, i, j] = 0.0
        for i in range(size):
            for j in range(size):
                inverse_mass[f, first + i, first + j] = law.inverse[d, i, j] if d >= 0 else 1.0 if i == j else 0.0
            v_free[f, first + i] = 0.0
        if d < 0:
            continue
        for i in range(size):
            rate = v[f, first + i]
            stretch[i] = h * strain[law.block[d], law.columns[i]] + h * (theta * h + law.retardation[d]) * rate
        for i in range(size):
            force[i] = dot(law.stiffness[d, i], stretch, size)
        for i in range(size):
            v_free[f, first + i] = v[f, first + i] - dot(law.inverse[d, i], force, size)


@entry()
def move_strains(law: StrainLaw, strain: np.ndarray, v: np.ndarray, time: float) -> None:
    """Move strains (B, 6 + r) in place with velocities (F, n) for a time [s]."""
    first = v.shape[1] - len(law.columns)
    for d in range(len(law.block)):
        row = strain[law.block[d]]
        for i in range(len(law.columns)):
            row[law.columns[i]] += time * v[law.free[d], first + i]
        if law.normal >= 0:
            row[law.normal] = 0.0
            for i in range(law.across.shape[1]):
                row[law.normal] += law.across[d, i] * row[law.columns[i]]


@entry()
def strain_energies(
    law: StrainLaw, before: np.ndarray, after: np.ndarray, v: np.ndarray, v_new: np.ndarray
) -> tuple[float, float, float, float]:
    """Kinetic and elastic energy after a step, the elastic energy before it, and the work that the force of the step took [J].

    Between strains (B, 6 + r) and velocities (F, n).
    """
    theta, size = law.theta, len(law.columns)
    first = v.shape[1] - size
    e, e_new, stretch, rate, rate_new = np.empty(size), np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    kinetic, elastic, elastic_new, taken = 0.0, 0.0, 0.0, 0.0
    for d in range(len(law.block)):
        b, f, beta = law.block[d], law.free[d], law.retardation[d]
        for i in range(size):
            e[i], e_new[i] = before[b, law.columns[i]], after[b, law.columns[i]]
            rate[i], rate_new[i] = v[f, first + i], v_new[f, first + i]
            stretch[i] = theta * e_new[i] + (1.0 - theta) * e[i] + beta * (theta * rate_new[i] + (1.0 - theta) * rate[i])
            kinetic += 0.5 * law.mass[d, i] * rate_new[i] ** 2
        for i in range(size):
            row = law.stiffness[d, i]
            elastic += 0.5 * e[i] * dot(row, e, size)
            elastic_new += 0.5 * e_new[i] * dot(row, e_new, size)
            taken += 0.5 * law.step * (rate[i] + rate_new[i]) * dot(row, stretch, size)
    return kinetic, elastic_new, elastic, taken
