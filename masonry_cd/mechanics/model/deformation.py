# SPDX-License-Identifier: GPL-3.0-or-later
r"""Blocks of one strain each: the shapes that they take, their mass and their stiffness.

A point X of the block, seen from its centre in the principal axes P of its inertia, comes to

    x + R P (I + G(e)) P^T X,        e = (e_xx, e_yy, e_zz, g_yz, g_xz, g_xy),

with the position x and the rotation R of a rigid block and a small strain e that turns with it (the pseudo-rigid bodies of Cohen &
Muncaster, 1988; Shi's discontinuous deformation analysis, 1988, has the same unknowns). A shear strain g of the axes i and j moves the
block by

    G_ij = g E_i / (E_i + E_j),        G_ji = g E_j / (E_i + E_j),        E_i = integral of rho X_i^2,

which turns it by nothing in the mean: the six shapes have no momentum and no angular momentum, neither of each other, so that the mass
matrix of a block is that of the rigid one next to a diagonal one,

    M_e = (E_x, E_y, E_z, E_y E_z / (E_y + E_z), E_x E_z / (E_x + E_z), E_x E_y / (E_x + E_y)),

whatever its rotation. The stiffness is the volume times Hooke's law of an isotropic solid, the same in any axes. What rotation adds to the
strain, and strain to the inertia, is of the size of the strain and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks, Elasticity

STRAINS = 6  # of a block
SHEARS = ((1, 2), (0, 2), (0, 1))  # axes of the shear strains, in their order
ROUNDING = 1e-12  # share of the trace below which a product of inertia is rounding
SWEEPS = 10  # of Jacobi's rotations; they converge quadratically


@dataclass(frozen=True, eq=False)
class Deformation:
    """The D blocks that deform, of B."""

    block: np.ndarray  # (D,) their numbers
    axes: np.ndarray  # (D, 3, 3) principal axes of inertia in the body frame, by column
    share: np.ndarray  # (D, 3) E_i / (E_i + E_j) of the shear strains
    mass: np.ndarray  # (D, 6) diagonal [kg m2]
    stiffness: np.ndarray  # (D, 6, 6) [J]
    retardation: np.ndarray  # (D,) viscosity over stiffness [s]
    volume: np.ndarray  # (D,) [m3]
    theta: float  # of the strains over the time step
    mesh_size: np.ndarray  # (D,) of the blocks that are meshed, see warping.py [m]; 0: one strain is all
    room: int = 0  # unknowns of a block at the least, where blocks are meshed

    def turned(self, rotation: np.ndarray) -> Deformation:
        """A deformation whose principal axes are turned with the body frames by (B, 3, 3)."""
        return replace(self, axes=rotation[self.block] @ self.axes)

    def without_swing(self) -> Deformation:
        """A deformation with all motion damped that a step does not resolve, and without viscosity: for finding rest."""
        return replace(self, theta=1.0, retardation=np.zeros_like(self.retardation))

    def maps(self, rotation: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Return the maps of points of the body frames to the world, (B, 3, 3), with rotations (B, 3, 3) and strains (B, 6 and more)."""
        out = rotation.copy()
        fill_maps(self.block, self.axes, self.share, rotation, strain, out)
        return out

    def gradients(self, strain: np.ndarray) -> np.ndarray:
        """Gradients of the displacement within the blocks, body frame, (B, 3, 3), with strains (B, 6); zero of rigid blocks."""
        return self.maps(np.broadcast_to(np.eye(3), (len(strain), 3, 3)), strain) - np.eye(3)


def deformation_of(
    fixed: np.ndarray, group_of: np.ndarray, groups: Sequence[str], inertia: np.ndarray, volume: np.ndarray, material: ElasticBlocks
) -> Deformation | None:
    """The blocks that deform by a material; None: all are rigid.

    Args:
        fixed: (B,) supports, which stay rigid.
        group_of: (B,) index into groups.
        groups: their names.
        inertia: (B, 3, 3) about the centres of mass, body frame [kg m2].
        volume: (B,) [m3].
        material: the keys.

    Raises:
        InputError: a key names a group that does not exist, or gives a group that deforms no value.
    """
    laws = [material.of_group(group, groups) for group in groups]
    block = np.array([b for b, group in enumerate(group_of) if laws[group] is not None and not fixed[b]], dtype=np.int64)
    if not len(block):
        return None
    chosen = [law for law in (laws[group_of[b]] for b in block) if law is not None]
    spread = 0.5 * np.trace(inertia[block], axis1=1, axis2=2)[:, None, None] * np.eye(3) - inertia[block]  # integral of rho X X^T
    axes, second = principal_axes(spread)
    pair = np.array([[(e[i], e[j]) for i, j in SHEARS] for e in second])
    shear = pair.prod(axis=2) / pair.sum(axis=2)
    return Deformation(
        block=block,
        axes=axes,
        share=pair[:, :, 0] / pair.sum(axis=2),
        mass=np.concatenate([second, shear], axis=1),
        stiffness=volume[block][:, None, None] * np.array([hooke(law) for law in chosen]),
        retardation=np.array([law.retardation for law in chosen]),
        volume=volume[block],
        theta=material.strain_theta,
        mesh_size=np.array([law.mesh_size for law in chosen]),
    )


def hooke(law: Elasticity) -> np.ndarray:
    """Hooke's law of an isotropic solid, (6, 6) [Pa]: stresses xx, yy, zz, yz, xz, xy by the strains, shear strains as angles."""
    lame, shear = law.young * law.poisson / ((1.0 + law.poisson) * (1.0 - 2.0 * law.poisson)), 0.5 * law.young / (1.0 + law.poisson)
    out = np.zeros((6, 6))
    out[:3, :3] = lame
    out[[0, 1, 2], [0, 1, 2]] += 2.0 * shear
    out[[3, 4, 5], [3, 4, 5]] = shear
    return out


def principal_axes(tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal axes (D, 3, 3), by column, and values (D, 3) of symmetric tensors, by Jacobi's rotations.

    Each rotation is the smaller of the two that take a product of inertia away, so axis i stays near axis i of the frame; and one of the
    frame that is principal but for rounding stays as it is, as the normal of a scene in a plane.
    """
    values, axes = tensor.copy(), np.tile(np.eye(3), (len(tensor), 1, 1))
    smallest = ROUNDING * np.trace(tensor, axis1=1, axis2=2)
    for i, j in SWEEPS * SHEARS:
        product = np.where(np.abs(values[:, i, j]) > smallest, values[:, i, j], 0.0)
        slope = 0.5 * (values[:, j, j] - values[:, i, i])
        root = np.abs(slope) + np.sqrt(slope * slope + product * product)
        tangent = np.where(slope < 0.0, -product, product) / np.where(root > 0.0, root, 1.0)
        cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
        _rotate(values, i, j, cosine, tangent * cosine)
        _rotate(values.transpose(0, 2, 1), i, j, cosine, tangent * cosine)
        _rotate(axes, i, j, cosine, tangent * cosine)
    return axes, np.ascontiguousarray(values[:, [0, 1, 2], [0, 1, 2]])


def _rotate(matrix: np.ndarray, i: int, j: int, cosine: np.ndarray, sine: np.ndarray) -> None:
    """Turn the columns i and j of matrices (D, 3, 3), in place."""
    first, second = matrix[:, :, i].copy(), matrix[:, :, j].copy()
    matrix[:, :, i] = cosine[:, None] * first - sine[:, None] * second
    matrix[:, :, j] = sine[:, None] * first + cosine[:, None] * second


@entry()
def fill_maps(block: np.ndarray, axes: np.ndarray, share: np.ndarray, rotation: np.ndarray, strain: np.ndarray, out: np.ndarray) -> None:
    """Fill the maps (B, 3, 3) of the blocks (D,) that deform, see the head of this file; strains (B, 6), rotations (B, 3, 3)."""
    turn, stretched = np.empty((3, 3)), np.empty((3, 3))
    for d in range(len(block)):
        b = block[d]
        _stretch(strain[b], share[d], stretched)
        _multiply(rotation[b], axes[d], turn)
        for i in range(3):
            for j in range(3):
                total = 0.0
                for k in range(3):
                    for l in range(3):  # noqa: E741
                        total += turn[i, k] * stretched[k, l] * axes[d, j, l]
                out[b, i, j] = total


@borrower()
def _stretch(e, share, out):
    """Fill out (3, 3) with I + G(e), see the head of this file."""
    out[0, 0], out[1, 1], out[2, 2] = 1.0 + e[0], 1.0 + e[1], 1.0 + e[2]
    out[1, 2], out[2, 1] = share[0] * e[3], (1.0 - share[0]) * e[3]
    out[0, 2], out[2, 0] = share[1] * e[4], (1.0 - share[1]) * e[4]
    out[0, 1], out[1, 0] = share[2] * e[5], (1.0 - share[2]) * e[5]


@borrower()
def _multiply(a, b, out):
    """out = a b of (3, 3) each."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
