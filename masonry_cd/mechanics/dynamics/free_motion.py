# SPDX-License-Identifier: GPL-3.0-or-later
r"""Predict: the blocks at q_m, and the velocities that they would have at the end of the step without contact.

    q_m    = q + h (1 - theta) v
    v_free = v + h M^-1 f(q_m, v)

with gravity, forces on single blocks and ties in f, and what an impact of the last step has left over. The free rotation keeps the angular
momentum L and takes the inertia of the middle of the motion from q_m to the next q_m,

    w = I(exp(h w / 2) q_m)^-1 L,

the implicit midpoint rule, which is reversible, so that a tumbling block does not gain energy (Simo & Wong, Int. J. Numer. Methods Eng. 31,
1991).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays
from masonry_cd.mechanics.dynamics.strain import Strains
from masonry_cd.mechanics.dynamics.system import MotionState, StepLoads, System
from masonry_cd.mechanics.model.block_forces import Acting
from masonry_cd.mechanics.model.state import State, fill_rotations

if TYPE_CHECKING:
    from masonry_cd.mechanics.dynamics.linked_bodies import Linked


class MidpointPose(NamedTuple):
    """Where the blocks are at q_m and how they would move on, as the kernel writes it."""

    position: np.ndarray  # (B, 3) [m]
    orientation: np.ndarray  # (B, 4)
    rotation: np.ndarray  # (B, 3, 3)
    inverse_mass: np.ndarray  # (F, n, n)
    v_free: np.ndarray  # (F, n) [m/s, rad/s]


class Prediction(NamedTuple):
    """The blocks at q_m, and their motion without contact."""

    loads: StepLoads
    state: State  # at q_m, with the velocities of the beginning of the step
    rotation: np.ndarray  # (B, 3, 3) body to world, at q_m
    inverse_mass: np.ndarray  # (F, n, n)
    v_free: np.ndarray  # (F, n) [m/s, rad/s]
    angular_momentum: np.ndarray  # (B, 3) with what forces and the carried impulse add [kg m2/s]
    pull: float  # largest acceleration of a block by gravity and forces [m/s2]
    tensions: np.ndarray  # (T,) of the ties [N]
    yielded: np.ndarray  # (T,) by how much they are longer for good, by settling and by yielding [m]
    maps: np.ndarray  # (B, 3, 3) body to world with the strains, at q_m; the rotations where no block deforms
    swelling: float = 0.0  # distance that the strains may close within the step [m]
    acting: Acting | None = None  # forces on single blocks
    force_impulse: np.ndarray | None = None  # (F, n) generalised impulse of the forces on single blocks
    carried_impulse: np.ndarray | None = None  # (F, n) of the last step, as far as it is taken
    driven: tuple[Any, ...] = ()  # rows of guided blocks, see driving.py
    linked: Linked | None = None  # what links make of the step
    founded: Any = None  # footings of the step, see founding.py; None: there are none


def predict(system: System, last: MotionState, loads: StepLoads) -> Prediction:
    """Move the blocks to q_m, and find their free velocities."""
    h, blocks, now, momentum = system.constants.step, system.blocks, last.state, last.angular_momentum
    state = State(now.time, now.position.copy(), now.orientation.copy(), now.velocity, now.strain)
    bodies, n = len(system.reach), system.unknowns
    rotation, inverse_mass, v_free = np.empty((len(momentum), 3, 3)), np.empty((bodies, n, n)), np.empty((bodies, n))
    at_q_m = MidpointPose(state.position, state.orientation, rotation, inverse_mass, v_free)
    move_freely(blocks, state.velocity, momentum, loads.acceleration, h, system.settings.theta, at_q_m)
    free = Prediction(loads, state, rotation, inverse_mass, v_free, momentum, system.gravity, last.tensions, last.yielded, rotation)
    if system.strains is not None:
        free = _with_strains(system, system.strains, last, free)
    free = _with_carried_impulse(system, _with_forces(system, free), last.carried_impulse)
    return free if system.absent is None else _without(system.absent, system.free, free)


def _without(absent: np.ndarray, is_free: np.ndarray, free: Prediction) -> Prediction:
    """Blocks that are absent, (B,) bool, stay where they are, whatever would act on them."""
    v, momentum = free.v_free.copy(), free.angular_momentum.copy()
    v[absent[is_free]], momentum[absent] = 0.0, 0.0
    impulse = free.force_impulse
    if impulse is not None:
        impulse = np.where(absent[is_free, None], 0.0, impulse)
    return free._replace(v_free=v, angular_momentum=momentum, force_impulse=impulse)


def _with_strains(system: System, strains: Strains, last: MotionState, free: Prediction) -> Prediction:
    """Move the strains to q_m, and fill in their free rates and what stands for their mass; those of rigid blocks stay zero."""
    state = free.state
    strains.fill_free(state.strain, last.v, free.inverse_mass, free.v_free)
    state.strain = strains.at_q_m(state.strain, last.v)
    swelling = 4.0 * system.constants.step * strains.fastest(last.v, system.reach) + 2.0 * strains.farthest(state.strain)
    return free._replace(maps=strains.deformation.maps(free.rotation, state.strain), swelling=swelling)


def _with_forces(system: System, free: Prediction) -> Prediction:
    """Add the impulses of the forces on single blocks."""
    forces = system.loads.forces
    if forces is None:
        return free
    position, velocity, count = free.state.position, free.state.velocity, len(free.rotation)
    yielded = forces.yields(position, free.maps, free.yielded)
    acting = forces.acting(position, free.maps, velocity, free.loads.number, free.loads.ticks, yielded)
    wrench = acting.wrench(count)[system.free]
    pushed = np.sqrt(wrench[:, 0] ** 2 + wrench[:, 1] ** 2 + wrench[:, 2] ** 2) / system.assembly.mass[system.free]
    pull = system.gravity + float((pushed if acting.moment is None else pushed + acting.turning(system.assembly)[system.free]).max())
    impulse = np.zeros_like(free.v_free)
    impulse[:, : len(system.blocks.columns)] = system.constants.step * wrench[:, system.blocks.columns]
    if system.strains is not None:
        warped = _along_warps(system, system.strains, free, acting)
        along = system.strains.forces(acting.virial(count), warped, free.rotation, free.maps)
        system.strains.set_unknowns(impulse, system.constants.step * along)
    moved = _pushed(system, free, impulse, np.einsum("bij,bj->bi", free.inverse_mass, impulse))
    return moved._replace(pull=pull, acting=acting, tensions=acting.tension, yielded=yielded, force_impulse=impulse)


def _along_warps(system: System, strains: Strains, free: Prediction, acting: Acting) -> np.ndarray:
    """Return the work of forces on single blocks along their warps, (B, r) [N]."""
    position, warps = free.state.position, strains.warps
    if warps is None:
        return np.zeros((len(position), 0))
    touch = warps.touches(acting.block[:, None], position[acting.block] + acting.arm, position, free.maps, system.constants.plane_axis)
    return warps.forces((acting.block, acting.force), touch, free.rotation)


def _with_carried_impulse(system: System, free: Prediction, carried: np.ndarray | None) -> Prediction:
    """Add what an impact of the last step left over.

    It is the weight of half a step at most. Where the impulses of the last step were those of a jam, self-balanced and of any size, the
    part of them that is carried over must not become motion: no block gets more than gravity gives it in a step.
    """
    if carried is None:
        return free
    gain = np.einsum("bij,bj->bi", free.inverse_mass, carried)
    _, speed = system.speeds(gain)
    share = np.minimum(1.0, free.pull * system.constants.step / np.maximum(speed, 1e-300))[:, None]
    return _pushed(system, free, share * carried, share * gain)._replace(carried_impulse=share * carried)


def _pushed(system: System, free: Prediction, impulse: np.ndarray, gain: np.ndarray) -> Prediction:
    """Add a generalised impulse (F, n) and the velocities that it gives (F, n)."""
    momentum = free.angular_momentum.copy()
    momentum[system.turning_axes] += impulse[:, system.turning]
    return free._replace(v_free=free.v_free + gain, angular_momentum=momentum)


# --- kernels ---------------------------------------------------------------------------------------------------------------


@entry()
def drift(position, orientation, velocity, time):
    """Move positions (B, 3) and orientations (B, 4) in place with constant velocity (B, 6) for a time [s]; q <- exp(w t / 2) q."""
    for b in range(position.shape[0]):
        for d in range(3):
            position[b, d] += time * velocity[b, d]
        wx, wy, wz = velocity[b, 3], velocity[b, 4], velocity[b, 5]
        speed = np.sqrt(wx * wx + wy * wy + wz * wz)
        if speed == 0.0:
            continue
        half = 0.5 * time * speed
        c, s = math.cos(half), math.sin(half) / speed
        x, y, z = s * wx, s * wy, s * wz
        qw, qx, qy, qz = orientation[b]
        pw = c * qw - x * qx - y * qy - z * qz
        px = c * qx + x * qw + y * qz - z * qy
        py = c * qy + y * qw + z * qx - x * qz
        pz = c * qz + z * qw + x * qy - y * qx
        scale = 1.0 / np.sqrt(pw * pw + px * px + py * py + pz * pz)
        orientation[b, 0], orientation[b, 1], orientation[b, 2], orientation[b, 3] = pw * scale, px * scale, py * scale, pz * scale


@entry()
def move_freely(
    blocks: BlockArrays,
    velocity: np.ndarray,
    momentum: np.ndarray,
    acceleration: np.ndarray,
    step: float,
    theta: float,
    moved: MidpointPose,
) -> None:
    """Move the blocks to q_m, from where they are in ``moved``, and fill M^-1 and the free velocities, see the head of this file.

    Velocities (B, 6) at the beginning of the step [m/s, rad/s], angular momenta (B, 3), one body acceleration (3,) [m/s2].
    """
    drift(moved.position, moved.orientation, velocity, step * (1.0 - theta))
    rotation, inverse_mass, v_free = moved.rotation, moved.inverse_mass, moved.v_free
    fill_rotations(moved.orientation, rotation)
    mass, inverse_inertia, free_index, columns = blocks.mass, blocks.inverse_inertia, blocks.free_index, blocks.columns
    full = np.zeros((6, 6))
    free = np.empty(6)
    for b in range(rotation.shape[0]):
        i = free_index[b]
        if i < 0:
            continue
        for d in range(3):
            full[d, d] = 1.0 / mass[b]
            free[d] = velocity[b, d] + step * acceleration[d]
        turned_tensor(rotation[b], inverse_inertia[b], full[3:, 3:])
        _midpoint_rotation(full[3:, 3:], momentum[b], step, columns.shape[0] == 3, free[3:])
        for j in range(columns.shape[0]):
            v_free[i, j] = free[columns[j]]
            for k in range(columns.shape[0]):
                inverse_mass[i, j, k] = full[columns[j], columns[k]]


@entry()
def angular_momenta(blocks: BlockArrays, rotation: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Angular momenta I w (B, 3) [kg m2/s] of blocks with rotations (B, 3, 3) and velocities (B, 6)."""
    momentum, world = np.empty((len(rotation), 3)), np.empty((3, 3))
    for b in range(len(rotation)):
        turned_tensor(rotation[b], blocks.inertia[b], world)
        for d in range(3):
            momentum[b, d] = world[d, 0] * velocity[b, 3] + world[d, 1] * velocity[b, 4] + world[d, 2] * velocity[b, 5]
    return momentum


@borrower()
def _midpoint_rotation(inverse_inertia, momentum, step, planar, w):
    """Solve w = I(exp(h w / 2) q_m)^-1 L for w (3,) by fixed point; about a fixed axis, as in a plane, I does not change.

    ``inverse_inertia`` (3, 3) is that of the orientation q_m in the world frame, ``momentum`` (3,) is L.
    """
    for d in range(3):
        w[d] = inverse_inertia[d, 0] * momentum[0] + inverse_inertia[d, 1] * momentum[1] + inverse_inertia[d, 2] * momentum[2]
    if planar:
        return
    for _ in range(50):
        speed = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        if step * speed < 1e-14:
            return
        ax, ay, az = w[0] / speed, w[1] / speed, w[2] / speed
        c, s = math.cos(0.5 * step * speed), math.sin(0.5 * step * speed)
        lx, ly, lz = _turn(momentum[0], momentum[1], momentum[2], ax, ay, az, c, -s)  # L seen by the body as it is at q_m
        bx = inverse_inertia[0, 0] * lx + inverse_inertia[0, 1] * ly + inverse_inertia[0, 2] * lz
        by = inverse_inertia[1, 0] * lx + inverse_inertia[1, 1] * ly + inverse_inertia[1, 2] * lz
        bz = inverse_inertia[2, 0] * lx + inverse_inertia[2, 1] * ly + inverse_inertia[2, 2] * lz
        x, y, z = _turn(bx, by, bz, ax, ay, az, c, s)
        change = abs(x - w[0]) + abs(y - w[1]) + abs(z - w[2])
        w[0], w[1], w[2] = x, y, z
        if change <= 1e-14 * speed:
            return


@borrower()
def _turn(x, y, z, ax, ay, az, c, s):
    """Rodrigues' rotation of (x, y, z) about the unit axis a by the angle with cosine c and sine s; three numbers."""
    along = (1.0 - c) * (ax * x + ay * y + az * z)
    return (
        c * x + s * (ay * z - az * y) + along * ax,
        c * y + s * (az * x - ax * z) + along * ay,
        c * z + s * (ax * y - ay * x) + along * az,
    )


@borrower()
def turned_tensor(r, tensor, out):
    """Fill out (3, 3) with R T R^T."""
    for i in range(3):
        a0 = r[i, 0] * tensor[0, 0] + r[i, 1] * tensor[1, 0] + r[i, 2] * tensor[2, 0]
        a1 = r[i, 0] * tensor[0, 1] + r[i, 1] * tensor[1, 1] + r[i, 2] * tensor[2, 1]
        a2 = r[i, 0] * tensor[0, 2] + r[i, 1] * tensor[1, 2] + r[i, 2] * tensor[2, 2]
        for j in range(3):
            out[i, j] = a0 * r[j, 0] + a1 * r[j, 1] + a2 * r[j, 2]
