# SPDX-License-Identifier: GPL-3.0-or-later
r"""The first elastic period of a structure on the stiffness of its joints, and dashpots that damp it by a stated share of critical.

Rigid blocks on elastic joints have the modes of :mod:`masonry_cd.analysis.modal.elastic_joints`. Dashpots in proportion to the springs,
of retardation beta, damp a mode of frequency f by the share zeta = pi f beta of critical: beta = zeta / (pi f1) gives it to the first mode.
A run that stays in a plane has the modes in that plane alone; the first of these counts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.analysis.modal.elastic_joints import joint_modes
from masonry_cd.analysis.modal.shapes import RigidShapes
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.pair_stiffness import stiffness_of_joints
from masonry_cd.mechanics.model.blocks import Assembly

KEY = "material.joints.damping"
AS_RIGID = 1e4  # times the stiffest elastic joint: what a rigid joint counts as, whose own give then changes a period by less than 1e-4
MODES = 12  # looked through first for one in the plane
IN_PLANE = 0.25  # share of a mode's kinetic energy from which it moves in the plane; 0 or 1 but for modes of one frequency, which mix


def damped_at_first_period(assembly: Assembly, across: int | None) -> tuple[Assembly, float]:
    """The blocks with the dashpots of laws whose share of critical holds at the first elastic period, and that period [s].

    Args:
        assembly: with elastic joints.
        across: axis normal to the plane in which the run stays; None in space.

    Raises:
        InputError: blocks that deform, or a block tied to no support, so that there is no such period; names the key.
    """
    if assembly.deformation is not None:
        raise InputError(KEY, "needs damping_frequency as well where blocks deform; the first period is known on elastic joints alone")
    try:
        frequency = first_frequency(assembly, across)
    except InputError as fault:
        raise InputError(KEY, f"needs damping_frequency as well, there is no first elastic period: {fault}") from None
    return replace(assembly, laws=assembly.laws.damped_at(frequency)), 1.0 / frequency


def first_frequency(assembly: Assembly, across: int | None = None) -> float:
    """The lowest frequency of rigid blocks on the joints' own stiffness [Hz], in space or in a plane.

    Raises:
        InputError: no joint has a stiffness, or a block is tied to no support.
    """
    normal, tangential = stiffness_of_joints(assembly, find_joints(assembly))
    if not normal.any():
        raise InputError("", "no joint is elastic")
    stiff = AS_RIGID * float(normal.max())
    stiffness = (np.where(normal > 0.0, normal, stiff), np.where(normal > 0.0, tangential, stiff))
    most, count = 6 * int((~assembly.fixed).sum()), MODES
    while True:
        found = joint_modes(
            assembly.blocks, np.ones(assembly.count), 0.0, min(count, most), stiffness=stiffness, footings=assembly.footings
        )
        fits = np.flatnonzero(_in_plane(assembly, found["field"], across) >= IN_PLANE)
        if len(fits):
            return float(np.asarray(found["frequencies"])[fits[0]])
        if count >= most:
            raise InputError("", "no mode of vibration lies in the plane of the run")
        count *= 4


def _in_plane(assembly: Assembly, field: object, across: int | None) -> np.ndarray:
    """Share of the kinetic energy of each mode in the plane, (n,); one in space."""
    assert isinstance(field, RigidShapes)
    if across is None:
        return np.ones(len(field.translation))
    free = ~assembly.fixed
    moving = assembly.mass[free, None] * field.translation**2  # (n, F, 3)
    turning = field.rotation * np.einsum("bij,nbj->nbi", assembly.inertia[free], field.rotation)
    kept = moving.sum(axis=(1, 2)) - moving[..., across].sum(axis=1) + turning[..., across].sum(axis=1)
    return np.asarray(kept / (moving.sum(axis=(1, 2)) + turning.sum(axis=(1, 2))))
