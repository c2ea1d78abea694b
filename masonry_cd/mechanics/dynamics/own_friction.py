# SPDX-License-Identifier: GPL-3.0-or-later
r"""Coefficients of friction that change from step to step: by slip rate, pressure, direction of the joint, or whatever a function knows.

The coefficients of a step follow from the state at its beginning, so that its problem is that of Coulomb with constant coefficients. The
scheme is then of first order in them: a coefficient that depends on the speed lags by one step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import MotionState, System


class SlidingContacts(NamedTuple):
    """The C contacts of a step as a law of friction sees them, at its beginning."""

    blocks: np.ndarray  # (C, 2) numbers of the blocks
    point: np.ndarray  # (C, 3) [m]
    normal: np.ndarray  # (C, 3) from the second block to the first
    speed: np.ndarray  # (C,) at which the faces slide along each other [m/s]
    force: np.ndarray  # (C,) pressing them together in the last step [N]; zero of new contacts
    friction: np.ndarray  # (C,) coefficients of the scene
    time: float  # [s]
    step: float  # [s]


FrictionLaw = Callable[[SlidingContacts], Any]


def with_friction(system: System, last: MotionState, made: StepProblem, law: FrictionLaw) -> StepProblem:
    """The problem of a step with the coefficients that a law gives.

    Raises:
        InputError: other than C finite numbers of zero or more.
    """
    rows, h, state = made.rows, system.constants.step, last.state
    point, normal = made.found.point[rows.active], rows.frame[:, 0]
    arm = point[:, None] - made.predicted.state.position[rows.blocks]
    velocity = state.velocity[rows.blocks]
    at_point = velocity[..., :3] + np.cross(velocity[..., 3:], arm)
    apart = at_point[:, 0] - at_point[:, 1]
    along = apart - np.einsum("cd,cd->c", apart, normal)[:, None] * normal
    seen = SlidingContacts(
        rows.blocks, point, normal, np.linalg.norm(along, axis=1), np.maximum(rows.start[:, 0], 0.0) / h, rows.mu, state.time, h
    )
    given = np.asarray(law(seen), dtype=np.float64)
    if given.shape != rows.mu.shape or not np.isfinite(given).all() or (given < 0.0).any():
        raise InputError(
            "friction", f"at {state.time:g} s: {len(rows.mu)} finite coefficients of zero or more are needed, one for each contact"
        )
    mu = np.ascontiguousarray(given)
    return made._replace(rows=rows._replace(mu=mu), problem=replace(made.problem, mu=mu))
