# SPDX-License-Identifier: GPL-3.0-or-later
r"""The mean stress of blocks, from the forces on them: true whatever they are made of.

**Mean-stress theorem** (Signorini, Ann. Sc. Norm. Super. Pisa 2, 1933; Gurtin, The Linear Theory of Elasticity, 1972). In a
block of volume V the balance div sigma + rho (b - a) = 0, times the place X - x from the centre of mass x, integrates to

    V <sigma> = sum_f f (x) (X_f - x)  -  int rho a (x) (X - x) dV,

over the forces f at X_f on its surface (contacts, ends of ties, point loads). A body force b that is the same all over the block has no
moment about x and drops out. Tension is positive. The balance of angular momentum makes the right side symmetric, so its symmetric part is
taken. The velocity in a rigid block is v + W (X - x) with W = [w]x, its angular velocity as a matrix; with the second moments of mass
J = int rho (X - x) (x) (X - x) dV = tr(I)/2 - I, turned with the block,

    int rho a (x) (X - x) dV  =  d/dt (W J) - W J W^T.

Nothing is neglected: the inertia of the rotation is in, that of the translation drops out with b.

**Mean over time.** What is kept is the mean over the time T since the last frame, over all of its steps with their impulses p = h f:

    V T <sigma> = sum over steps, sym [ p (x) (X - x) + h W J W^T ]  -  [ sym W J ] over T.

The force of a rigid impact is not finite; its impulse is, so this mean does not grow as time steps shrink, and none of it falls between
two frames. What an impact carries over to the next step (``impacts.py``) has no place on the block and is left out: half a step's weight.

**Blocks that deform** have the stress of their strain instead, that of their viscosity included: the same in the mean, since the step
solves the equation of motion of the strain (``strain.py``). Of meshed blocks the stress of each element is kept next to it
(``element_stress.py``).

**What contacts leave open.** Of the contacts of a joint only the resultant is determined where blocks are rigid: friction that pulls its
corners apart, or together, moves nothing. Such pairs of forces would stress the blocks at random. So the tangential forces of a pair of
parts act together, where the normal ones cross the joint's plane (which these forces determine); a joint whose friction goes with its
pressure has no other mean. Supports have no stress: what holds them is not part of the model.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays, StepConstants
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.element_stress import ElementStress
from masonry_cd.mechanics.dynamics.free_motion import turned_tensor
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.state import rotation_matrices

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")  # of a symmetric tensor, in the order of VTK


class Sums(NamedTuple):
    """Impulses since the last frame, of B blocks and J joints; they grow in place."""

    virial: np.ndarray  # (B, 6) of the impulses, by COMPONENTS [N m s]
    normal: np.ndarray  # (J,) normal impulse [N s]
    moment: np.ndarray  # (J, 3) times the place from the centre of block a, in its body frame [N m s]


class MeanStress:
    """The mean stress of B blocks and the mean forces of J joints since the last frame.

    Args:
        stepper: whose steps are taken.
        joints: of its assembly.
    """

    def __init__(self, stepper: Stepper, joints: Joints) -> None:
        self._stepper, self._block_a = stepper, joints.block_a.astype(np.int64)
        self._sums = Sums(np.zeros((stepper.assembly.count, 6)), np.zeros(joints.count), np.zeros((joints.count, 3)))
        self._time = np.zeros(1)  # since the last frame [s]
        self._spin = self._spin_now()  # (B, 6) sym W J at the last frame [N m s]
        strains = stepper.system.strains
        self._elements = None if strains is None or strains.warps is None else ElementStress(strains)

    def take_step(self, pair_joint: np.ndarray) -> None:
        """Take the last step of the stepper; ``pair_joint`` names the joint of each pair of parts or -1."""
        stepper, made, system = self._stepper, self._stepper.last, self._stepper.system
        assert made is not None
        now, strains = made.predicted, system.strains
        kept = None if strains is None else self._sums.virial[strains.deformation.block]
        add_contacts(
            made.rows, made.found, system.constants, stepper.solution.impulse, now.state.position, now.rotation, pair_joint,
            self._block_a, self._sums,
        )  # fmt: skip
        spin = 0.5 * (now.state.velocity[:, 3:] + stepper.state.velocity[:, 3:])
        add_kinetic(system.blocks, now.rotation, spin, system.constants.step, self._sums.virial)
        if now.acting is not None:
            self._sums.virial[:] += system.constants.step * symmetric(now.acting.virial(len(now.rotation)))
        if strains is not None:
            assert made.start.velocity is not None
            own = strains.stresses(now.state.strain, made.start.velocity, stepper.motion.v, now.rotation)
            impulse = system.constants.step * strains.deformation.volume[:, None] * symmetric(own)
            self._sums.virial[strains.deformation.block] = kept + impulse
            if self._elements is not None:
                stretches = strains.stretches(now.state.strain, made.start.velocity, stepper.motion.v)
                self._elements.take_step(strains, stretches, now.rotation)
        self._time += system.constants.step

    def stresses(self) -> np.ndarray:
        """(B, 6) mean stress since the last frame, by COMPONENTS [Pa]; NaN of supports, and where no step was made."""
        assembly = self._stepper.assembly
        spent = assembly.volume[:, None] * self._time
        with np.errstate(invalid="ignore"):
            mean = (self._sums.virial - (self._spin_now() - self._spin)) / spent
        return np.where(assembly.fixed[:, None], np.nan, mean)

    def of_elements(self) -> np.ndarray:
        """(E, 6) mean stress since the last frame in the elements of meshed blocks, by COMPONENTS [Pa]; NaN where no step was made."""
        sums = np.zeros((0, 6)) if self._elements is None else self._elements.sums
        with np.errstate(invalid="ignore"):
            return sums / self._time

    def node_displacements(self) -> np.ndarray:
        """(K, 3) how far the nodes of meshed blocks are beyond the rigid blocks now, body frames [m]."""
        strains = self._stepper.system.strains
        if self._elements is None or strains is None:
            return np.zeros((0, 3))
        return self._elements.displacements(strains, self._stepper.state.strain)

    def joint_forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean normal force of each joint since the last frame (J,) [N], and times the place from the centre of block a, in its body
        frame (J, 3) [N m]; zeros where no step was made."""
        time = self._time if self._time[0] > 0.0 else np.ones(1)
        return self._sums.normal / time, self._sums.moment / time

    def begin(self) -> None:
        """Begin again, at a frame."""
        for array in (*self._sums, self._time, *self._of_elements().values()):
            array[...] = 0.0
        self._spin = self._spin_now()

    def _spin_now(self) -> np.ndarray:
        """sym W J of each block, (B, 6) [N m s]; zeros of supports."""
        state, blocks = self._stepper.state, self._stepper.system.blocks
        out = np.zeros((len(state.position), 6))
        fill_spin(blocks, rotation_matrices(state.orientation), state.velocity, out)
        if self._stepper.assembly.deformation is not None:
            out[self._stepper.assembly.deformation.block] = 0.0  # their stress is that of their strain
        return out

    def _of_elements(self) -> dict[str, np.ndarray]:
        """The sums of the elements, where blocks are meshed."""
        return {} if self._elements is None else {"elements": self._elements.sums}

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that later frames depend on, as arrays for a checkpoint."""
        return self._sums._asdict() | {"time": self._time, "spin": self._spin} | self._of_elements()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        for name, array in self.snapshot().items():
            array[...] = arrays[name]


def check_sums(stored: Stored, blocks: int, joints: int, elements: int = 0) -> None:
    """Check what :meth:`MeanStress.restore` takes, of B blocks, J joints and E elements of meshed blocks.

    Raises:
        InputError: an array that no run of this scene leaves.
    """
    for name, shape in (("virial", (blocks, 6)), ("normal", (joints,)), ("moment", (joints, 3)), ("time", (1,)), ("spin", (blocks, 6))):
        stored.real(name, *shape)
    if elements:
        stored.real("elements", elements, 6)
    stored.check_all_read()


def symmetric(tensors: np.ndarray) -> np.ndarray:
    """(B, 6) by COMPONENTS, the symmetric parts of tensors (B, 3, 3)."""
    both = 0.5 * (tensors + tensors.transpose(0, 2, 1))
    return np.stack([both[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))], axis=1)


@entry()
def add_contacts(
    rows: ContactRows,
    found: ContactSet,
    constants: StepConstants,
    impulse: np.ndarray,
    position: np.ndarray,
    rotation: np.ndarray,
    pair_joint: np.ndarray,
    block_a: np.ndarray,
    sums: Sums,
) -> None:
    """Add the impulses (C, m) [N s] of a step to the sums.

    Positions (B, 3) [m] and rotations (B, 3, 3) at q_m; the joint of each pair of parts or -1; block a of each joint (J,).
    """
    count, m = impulse.shape
    place, force, acting = np.empty(3), np.empty(3), np.empty(3)
    first = 0
    while first < count:
        last, weight = first, 0.0
        for d in range(3):
            force[d], acting[d] = 0.0, 0.0
        while last < count and rows.pair[last] == rows.pair[first]:
            weight += abs(impulse[last, 0])
            last += 1
        for c in range(first, last):  # normal impulses where they are; tangential ones together
            share = abs(impulse[c, 0]) / weight if weight > 0.0 else 1.0 / (last - first)
            _place(found, constants, rows.active[c], place)
            for d in range(3):
                acting[d] += share * place[d]
                for i in range(1, m):
                    force[d] += impulse[c, i] * rows.frame[c, i, d]
            for side in range(2):
                _add(sums.virial, rows.blocks[c, side], (1.0 - 2.0 * side) * impulse[c, 0], rows.frame[c, 0], place, position)
            joint = pair_joint[rows.pair[c]]
            if joint >= 0:
                a = block_a[joint]
                sums.normal[joint] += impulse[c, 0]
                for i in range(3):
                    for d in range(3):
                        sums.moment[joint, i] += impulse[c, 0] * rotation[a, d, i] * (place[d] - position[a, d])
        for side in range(2):
            _add(sums.virial, rows.blocks[first, side], 1.0 - 2.0 * side, force, acting, position)
        first = last


@borrower()
def _place(found, constants, contact, place):
    """Fill ``place`` (3,) with the point of a contact found, in the middle plane of a planar scene [m]."""
    for d in range(3):
        place[d] = constants.plane_at if d == constants.plane_axis else found.point[contact, d]


@borrower()
def _add(virial, block, factor, force, place, position):
    """Add sym(factor force (x) (place - x)) to the virial of a block; force and place (3,)."""
    x, y, z = place[0] - position[block, 0], place[1] - position[block, 1], place[2] - position[block, 2]
    fx, fy, fz = factor * force[0], factor * force[1], factor * force[2]
    virial[block, 0] += fx * x
    virial[block, 1] += fy * y
    virial[block, 2] += fz * z
    virial[block, 3] += 0.5 * (fx * y + fy * x)
    virial[block, 4] += 0.5 * (fy * z + fz * y)
    virial[block, 5] += 0.5 * (fx * z + fz * x)


@entry()
def add_kinetic(blocks: BlockArrays, rotation: np.ndarray, spin: np.ndarray, step: float, virial: np.ndarray) -> None:
    """Add h W J W^T of the free blocks to the virial (B, 6); rotations (B, 3, 3), angular velocities (B, 3), h [s]."""
    moments, one, two = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for b in range(spin.shape[0]):
        if blocks.free_index[b] < 0 or (spin[b, 0] == 0.0 and spin[b, 1] == 0.0 and spin[b, 2] == 0.0):
            continue
        _second_moments(rotation[b], blocks.inertia[b], moments)
        _crossed(spin[b], moments, one)  # W J
        for i in range(3):
            for j in range(3):
                moments[i, j] = one[j, i]
        _crossed(spin[b], moments, two)  # W (W J)^T, the transpose of W J W^T, which is symmetric
        virial[b, 0] += step * two[0, 0]
        virial[b, 1] += step * two[1, 1]
        virial[b, 2] += step * two[2, 2]
        virial[b, 3] += step * two[0, 1]
        virial[b, 4] += step * two[1, 2]
        virial[b, 5] += step * two[0, 2]


@entry()
def fill_spin(blocks: BlockArrays, rotation: np.ndarray, velocity: np.ndarray, out: np.ndarray) -> None:
    """Fill sym W J of the free blocks, (B, 6) [N m s]; rotations (B, 3, 3), velocities (B, 6)."""
    moments, turning = np.empty((3, 3)), np.empty((3, 3))
    for b in range(out.shape[0]):
        if blocks.free_index[b] < 0:
            continue
        _second_moments(rotation[b], blocks.inertia[b], moments)
        _crossed(velocity[b, 3:], moments, turning)
        out[b, 0], out[b, 1], out[b, 2] = turning[0, 0], turning[1, 1], turning[2, 2]
        out[b, 3] = 0.5 * (turning[0, 1] + turning[1, 0])
        out[b, 4] = 0.5 * (turning[1, 2] + turning[2, 1])
        out[b, 5] = 0.5 * (turning[0, 2] + turning[2, 0])


@borrower()
def _second_moments(rotation, inertia, out):
    """Fill ``out`` (3, 3) with J = tr(I)/2 - I in the world frame [kg m2]."""
    turned_tensor(rotation, inertia, out)
    half = 0.5 * (out[0, 0] + out[1, 1] + out[2, 2])
    for i in range(3):
        for j in range(3):
            out[i, j] = (half if i == j else 0.0) - out[i, j]


@borrower()
def _crossed(w, tensor, out):
    """Fill ``out`` (3, 3) with w x each column of a tensor (3, 3)."""
    for j in range(3):
        x, y, z = tensor[0, j], tensor[1, j], tensor[2, j]
        out[0, j] = w[1] * z - w[2] * y
        out[1, j] = w[2] * x - w[0] * z
        out[2, j] = w[0] * y - w[1] * x
