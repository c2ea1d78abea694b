# SPDX-License-Identifier: GPL-3.0-or-later
"""The first elastic period of the masonry, which rigid joints leave out, and how much it would amplify the motion of the base.

Rigid joints pass the acceleration of the ground on as it is. Masonry of a modulus E sways with a first period T_1 before it cracks, and an
oscillator of that period and 5 % of damping answers with S_a(T_1) where the ground has PGA. The ratio of both says what a run leaves out.
"""

from __future__ import annotations

import numpy as np

from loads.signal.response import response_spectrum
from masonry_cd.analysis.modal.elastic_joints import period_along
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import ElasticBasis
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
from masonry_cd.mechanics.model.joints import Joints

YOUNG, SHEAR = 1.5e9, 0.5e9  # [Pa] where no masonry is named: split stone at its least, solid brick at its mean (Circolare 7/2019, C8.5.I)
DAMPING = 0.05  # of the spectrum, as codes have it
LESSER = 0.05  # share of the power of a motion that its lesser horizontal direction has at the least to be looked at


def elastic_period(assembly: Assembly, joints: Joints, velocity: np.ndarray, dt: float, moduli: tuple[float, float] | None) -> Summary:
    """First elastic period along the motion, and its amplification: of two horizontal directions in which the base moves, that with more.

    Args:
        assembly: blocks on rigid joints.
        joints: of them.
        velocity: (N + 1, 3) of the base [m/s].
        dt: time step [s].
        moduli: E and G of the masonry; None: those assumed here [Pa].

    Returns:
        ``elastic_period``, ``amplification`` and ``elastic_basis``; nothing where no joint ties a block to a support.
    """
    young, shear = moduli or (YOUNG, SHEAR)
    stiffness = joint_stiffness(assembly, joints, np.full(assembly.count, young), np.full(assembly.count, shear))
    acceleration, best, most = np.diff(velocity, axis=0) / dt, Summary(), 0.0
    for direction in _directions(acceleration):
        period = _rounded(period_along(assembly, joints, stiffness, direction))
        along = np.einsum("ki,i->k", acceleration, direction)
        peak = float(np.abs(along).max())
        if period == 0.0 or peak == 0.0:
            continue
        factor = _rounded(float(response_spectrum(along, dt, [period], DAMPING).acceleration[0]) / peak)
        if factor > most:
            basis = ElasticBasis(young=young, named=moduli is not None, direction=tuple(direction.round(6).tolist()))
            best, most = Summary(elastic_period=period, amplification=factor, elastic_basis=basis), factor
    return best


def _rounded(value: float) -> float:
    """To four digits: an estimate, and what factorisations round differently on another processor does not show."""
    return float(f"{value:.4g}")


def _directions(acceleration: np.ndarray) -> list[np.ndarray]:
    """Unit vectors along which a motion (N, 3) is looked at: the principal ones of its horizontal part, or else the vertical."""
    power = np.einsum("ki,kj->ij", acceleration, acceleration)
    xx, xy, yy = power[0, 0], power[0, 1], power[1, 1]
    if xx + yy == 0.0:
        return [np.array([0.0, 0.0, 1.0])]
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    first = np.array([np.cos(angle), np.sin(angle), 0.0])
    second = np.array([-first[1], first[0], 0.0])
    lesser = float(np.einsum("i,ij,j", second, power, second))
    return [first, second] if lesser > LESSER * (xx + yy) else [first]
