# SPDX-License-Identifier: GPL-3.0-or-later
r"""Driven blocks: the velocity of a guided block along a direction is given, and its reaction found.

A guide prescribes g . v = V with a row g = (d, r x d) of the velocities v of a block, r being the arm from its centre to the guided point
at q_m, and w . e = 0 along each axis e where the block is held from turning. A row enters the block's mass and free velocity before the
contacts are solved,

    M' = M + a g g^T,       M' v_free' = M v_free + a V g,       1 / a = (g M^-1 g^T) / STIFF,

row after row by Sherman & Morrison's formula, so that a contact meets a block that cannot be moved along g: as it meets a support, whose
velocity is given, but for what is left free. The impulse of the guide is that of the balance of momentum, a (V - g . v+), and what it lacks
in V is impulse / a: some 1e-8 of the velocity that the impulse would give the free block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.state import State, rotation_matrices

STIFF = 1e8  # a over the mass that the block opposes along g: beyond 1e11 rounding would show, below 1e5 the lack in V


class Rows(NamedTuple):
    """Rows of one guide, one on each of K free blocks with n unknowns."""

    guide: int
    pushes: bool  # along the direction of the guide; else it holds from turning
    body: np.ndarray  # (K,)
    row: np.ndarray  # (K, n)
    speed: float  # V [m/s, rad/s]
    stiff: np.ndarray  # (K,) a [kg, kg m2]


class Driven(NamedTuple):
    """Motion and forces of the guides of a run in a step, G of them."""

    force: np.ndarray  # (G,) along their directions, mean over the step [N]
    moment: np.ndarray  # (G,) by which they hold from turning, size of the sum over their blocks [N m]
    displacement: np.ndarray  # (G,) of their points along their directions, at the end [m]
    momentum: np.ndarray  # (G,) of all free blocks along their directions, at the end [kg m/s]


def drive(system: System, guides: tuple[Guide, ...], free: Prediction) -> tuple[Prediction, tuple[Rows, ...]]:
    """Take the guides into masses and free velocities; return the rows as well."""
    index, columns, n = system.blocks.free_index, system.blocks.columns, system.unknowns
    inverse, v, made = free.inverse_mass.copy(), free.v_free.copy(), []
    for number, guide in enumerate(guides):
        if not guide.there:
            continue
        body, speed = index[guide.blocks], guide.speed(free.loads.number - 1 + free.loads.ticks)
        for full, pushes in _full_rows(guide, free.rotation, columns):
            row = np.zeros((len(body), n))
            row[:, : len(columns)] = full[:, columns]
            gain = np.sum(free.inverse_mass[body] * row[:, None, :], axis=2)
            stiff = STIFF / np.sum(gain * row, axis=1)
            _add(inverse, v, body, row, speed if pushes else 0.0, stiff)
            made.append(Rows(number, pushes, body, row, speed if pushes else 0.0, stiff))
    momentum = turned_on(system, free, v, np.unique(np.concatenate([guide.blocks for guide in guides])))
    return free._replace(inverse_mass=inverse, v_free=v, angular_momentum=momentum), tuple(made)


def turned_on(system: System, free: Prediction, v: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """The angular momenta (B, 3) of a prediction whose free blocks, some of them (k,), get other velocities v (F, n) [kg m2/s]."""
    momentum, turned = free.angular_momentum.copy(), np.zeros((len(blocks), 3))
    turned[:, system.blocks.columns[system.turning] - 3] = (v - free.v_free)[system.blocks.free_index[blocks]][:, system.turning]
    momentum[blocks] += _turning_momentum(free.rotation[blocks], system.blocks.inertia[blocks], turned)
    return momentum


def _turning_momentum(rotation: np.ndarray, inertia: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """R I R^T w, (K, 3), of rotations (K, 3, 3), inertias (K, 3, 3) in body frames and angular velocities w (K, 3)."""
    own = np.sum(rotation * turning[:, :, None], axis=1)  # R^T w
    own = np.sum(inertia * own[:, None, :], axis=2)
    return np.sum(rotation * own[:, None, :], axis=2)


def guided(system: System, free: Prediction) -> Prediction:
    """A prediction whose guided blocks are driven; where there are none it stays as it is."""
    guides = system.loads.guides
    if not guides:
        return free
    made, rows = drive(system, guides, free)
    return made._replace(driven=rows)


def _full_rows(guide: Guide, rotation: np.ndarray, columns: np.ndarray) -> list[tuple[np.ndarray, bool]]:
    """Rows (K, 6) of (vx, vy, vz, wx, wy, wz): along the direction, then of the axes about which the blocks do not turn."""
    along = np.broadcast_to(guide.direction, guide.arms.shape)
    made = [(np.concatenate([along, np.cross(guide.arms_in_world(rotation), along)], axis=1), True)]
    for axis in columns[columns >= 3] if guide.held else ():
        row = np.zeros((len(guide.blocks), 6))
        row[:, axis] = 1.0
        made.append((row, False))
    return made


def _add(inverse: np.ndarray, v: np.ndarray, body: np.ndarray, row: np.ndarray, speed: float, stiff: np.ndarray) -> None:
    """Put a row on each of some bodies into M'^-1 (F, n, n) and v_free' (F, n), in place."""
    gain = np.sum(inverse[body] * row[:, None, :], axis=2)
    per = 1.0 / (1.0 / stiff + np.sum(gain * row, axis=1))
    v[body] += gain * (per * (speed - np.sum(row * v[body], axis=1)))[:, None]
    inverse[body] -= gain[:, :, None] * gain[:, None, :] * per[:, None, None]


def impulses(rows: Rows, v: np.ndarray) -> np.ndarray:
    """Impulses (K,) of rows that left the bodies with velocities v (F, n) [N s, N m s]."""
    return np.asarray(rows.stiff * (rows.speed - np.sum(rows.row * v[rows.body], axis=1)))


def work_of_guides(driven: tuple[Rows, ...], before: np.ndarray, after: np.ndarray) -> float:
    """Return the work of guides over a step with velocities (F, n) at its beginning and its end [J]."""
    if not driven:
        return 0.0
    mean = 0.5 * (before + after)
    return float(sum(float(np.sum(impulses(rows, after) * np.sum(rows.row * mean[rows.body], axis=1))) for rows in driven))


def measured(system: System, guides: tuple[Guide, ...], driven: tuple[Rows, ...], v: np.ndarray, state: State) -> Driven:
    """Return motion and forces of guides in a step that ended with velocities (F, n) in a state."""
    h, count = system.constants.step, len(guides)
    force, moments = np.zeros(count), np.zeros((count, 3))
    for rows in driven:
        impulse = impulses(rows, v)
        if rows.pushes:
            force[rows.guide] += impulse.sum() / h
        else:
            axis = int(system.blocks.columns[int(np.argmax(rows.row[0]))]) - 3
            moments[rows.guide, axis] += impulse.sum() / h
    rotation = rotation_matrices(state.orientation)
    centre, momentum = system.assembly.centre, np.sum(system.free_mass[:, None] * state.velocity[:, :3], axis=0)
    return Driven(
        force,
        np.sqrt(np.sum(moments * moments, axis=1)),
        np.array([guide.displacement(state.position, rotation, centre) for guide in guides]),
        np.array([float(np.sum(momentum * guide.direction)) for guide in guides]),
    )
