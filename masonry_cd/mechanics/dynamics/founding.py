# SPDX-License-Identifier: GPL-3.0-or-later
r"""Footings: springs and dashpots of the ground, implicit in the step and solved before the contacts.

With the displacement d and the velocity w of a footing relative to the ground (see model/footings.py), w = J v - V, where V is the velocity
of the ground at the middle of the base, springs K and dashpots C give over a step the impulse of the generalised midpoint rule,

    p = -h K (d + h theta w_m) - h C w_m,        w_m = (1 - theta) w + theta w+.

d + h (1 - theta) w is the displacement d_m at q_m, so that this is

    p = p_0 - A J v+,        A = h theta (C + h theta K),
    p_0 = -h K (d_m - h (1 - theta)^2 w) - h (1 - theta) C w + A V+,

and the footing enters the contact problem, as a guided block does, with another mass and free velocity,

    M' = M + J^T A J,        M' v_free' = M v_free + J^T p_0:

no stiffness limits the step, and no solver knows of the ground. theta = 1/2 keeps the energy of the springs.

**Energy.** With means of both ends of the step, the footing gets p . (w + V). p . V is the work of the base; -p . w fills the springs,
1/2 d . K d, and the dashpots, h w . C w_m, which is what the ground takes away. What is left over, by theta above 1/2, by turns that are
not small and by lifts out of overlaps, counts as damping.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.driving import turned_on
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.step_problem import GroundWork
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.model.footings import Footings
from masonry_cd.mechanics.model.state import State, rotation_matrices


class Founded(NamedTuple):
    """The P footings of a step, F free blocks with n unknowns each."""

    footings: Footings
    body: np.ndarray  # (P,) places among the free blocks
    rows: np.ndarray  # (P, 6, k) J, of the unknowns of rigid blocks
    constant: np.ndarray  # (P, 6) p_0
    taken: np.ndarray  # (P, 6, 6) A
    before: np.ndarray  # (P, 6) w
    ground: np.ndarray  # (P, 2, 6) V at the beginning and the end of the step
    arms: np.ndarray  # (P, 2, 3) at q_m, world frame [m]

    def velocity(self, v: np.ndarray) -> np.ndarray:
        """J v (P, 6) of velocities v (F, n)."""
        return _times(self.rows, v[self.body, : self.rows.shape[2]])

    def reactions(self, v: np.ndarray, blocks: int) -> np.ndarray:
        """Impulses p of the ground on footings and their moments about the centres of the supports below, (B, 6), of B blocks.

        The new velocities are v (F, n).
        """
        out, given = np.zeros((blocks, 6)), self.constant - _times(self.taken, self.velocity(v))
        moment = given[:, 3:] + np.cross(self.arms[:, 1], given[:, :3])
        out[self.footings.blocks[:, 1]] = np.concatenate([given[:, :3], moment], axis=1)
        return out


def found(system: System, footings: Footings, free: Prediction) -> Prediction:
    """A prediction whose footings feel the ground."""
    h, theta, columns = system.constants.step, system.settings.theta, system.blocks.columns
    blocks, state, n = footings.blocks, free.state, len(columns)  # footings are rigid: n is what they have of the unknowns
    body, arms = system.blocks.free_index[blocks[:, 0]], footings.arms_in_world(free.rotation[blocks])
    full, after = _rows(arms), np.zeros((len(blocks), 6))
    moved = free.loads.support_after[system.assembly.support_of[blocks[:, 1]]]
    after[:, : moved.shape[1]] = moved
    own, ground = np.swapaxes(_times(full, state.velocity[blocks]), 0, 1)
    ground, before = np.stack([ground, _times(full[:, 1], after)], axis=1), own - ground
    taken = h * theta * (footings.damping + h * theta * footings.stiffness)
    away = footings.displacements(state.position, state.orientation, arms) - h * (1.0 - theta) ** 2 * before
    force = _times(footings.stiffness, away) + (1.0 - theta) * _times(footings.damping, before)
    constant = _times(taken, ground[:, 1]) - h * force
    rows = full[:, 0][:, :, columns]
    back = np.swapaxes(rows, 1, 2)
    inverse, v = free.inverse_mass.copy(), free.v_free.copy()
    mass = np.linalg.inv(inverse[body, :n, :n])
    impulse = _times(mass, v[body, :n]) + _times(back, constant)
    held = np.linalg.inv(mass + np.matmul(back, np.matmul(taken, rows)))
    inverse[body, :n, :n] = 0.5 * (held + np.swapaxes(held, 1, 2))
    v[body, :n] = _times(held, impulse)
    momentum = turned_on(system, free, v, blocks[:, 0])
    made = Founded(footings, body, rows, constant, taken, before, ground, arms)
    return free._replace(inverse_mass=inverse, v_free=v, angular_momentum=momentum, founded=made)


def work_of_ground(system: System, founded: Founded, stored: float, v: np.ndarray, end: State) -> GroundWork:
    """Return the work of the ground in a step to a state with velocities v (F, n), from a stored energy of its springs [J]."""
    theta, now = system.settings.theta, founded.velocity(v)
    given, after = founded.constant - _times(founded.taken, now), now - founded.ground[:, 1]
    mean, at_rule = 0.5 * (founded.before + after), (1.0 - theta) * founded.before + theta * after
    left = stored_in_ground(founded.footings, end)
    radiated = system.constants.step * float(np.sum(mean * _times(founded.footings.damping, at_rule)))
    base, taken = float(np.sum(given * founded.ground.mean(axis=1))), -float(np.sum(given * mean))
    return GroundWork(base, stored, left, radiated, taken - radiated - (left - stored))


def stored_in_ground(footings: Footings, state: State) -> float:
    """Energy of the springs of footings in a state [J]."""
    arms = footings.arms_in_world(rotation_matrices(state.orientation[footings.blocks.ravel()]).reshape(-1, 2, 3, 3))
    moved = footings.displacements(state.position, state.orientation, arms)
    return 0.5 * float(np.sum(moved * _times(footings.stiffness, moved)))


def _rows(arms: np.ndarray) -> np.ndarray:
    """(..., 6, 6) that take velocities of blocks to those at arms (..., 3) [m]: v + w x arm, w."""
    out = np.zeros((*arms.shape[:-1], 6, 6))
    out[..., range(6), range(6)] = 1.0
    x, y, z = arms[..., 0], arms[..., 1], arms[..., 2]
    out[..., 0, 4], out[..., 0, 5] = z, -y
    out[..., 1, 3], out[..., 1, 5] = -z, x
    out[..., 2, 3], out[..., 2, 4] = y, -x
    return out


def _times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Products (..., m) of matrices (..., m, n) and vectors (..., n)."""
    return np.asarray(np.matmul(matrix, vector[..., None])[..., 0])
