# SPDX-License-Identifier: GPL-3.0-or-later
r"""The stiffness of joints by the masonry around them, so that a wall of rigid blocks bends and shears as a continuum of moduli E and G.

**Normal.** The deformation of two blocks is gathered in the joint between them. With the distances l_a and l_b of both centroids from the
joint along its normal, per area

    k_n = 1 / (l_a / E_a + l_b / E_b)

(Lemos, Int. J. Archit. Herit. 1, 2007). A support does not deform, its l is 0. So the size of the blocks drops out.

**Tangential.** k_t = f / (l_a / G_a + l_b / G_b). A column shears as the continuum with f = 1. In a wall a block turns by phi while its
neighbours move by grad u d, the slips of bed and head joints add up, and phi takes the value by which the energy

    1/2 P (u_x,z + phi)^2 + 1/2 Q (u_z,x - phi)^2        is least:        1 / G_wall = 1 / P + 1 / Q.

P = f G are the slips of the bed itself. Q holds the block against turning by what is next to it: with the vectors d_i between the centroids
of the blocks of its joints, t across n, and its volume V,

    Q = sum_i A_i kappa_i (t . d_i)^2 / (2 V),        kappa_i = k_n c^2 + k_t (1 - c^2),        c = n_i . n.

Head joints add f G, so straight bond needs f = 2. Beds that blocks of length a and height b share by halves add E a^2 / (4 b^2), since they
part on one side of a block that turns and close on the other: in running bond f comes down to 1 for long blocks. With Q = G (q_0 + q_1 f),
G_wall = G asks for

    q_1 f^2 - (1 + q_1 - q_0) f - q_0 = 0.

At an edge, f is that of a block inside: q is related to the faces that have joints. As joints across n cover less than one of two faces, f
tends to that of a column. Both directions in a joint have the stiffness of the one in which its blocks are held best: in a wall of one
leaf that along the wall; across it, where f = 1 would do, bending is what counts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

THINNEST = 0.01  # share of a block's size that l is at the least: the centroid of a compound block may lie in the plane of its joint
ALONE = 1e-6  # share of the faces across a joint that have joints of their own, below which a block stands in a column
ROUND = 1e-9  # share of q by which it may differ between directions and count as the same in all


class _Sides(NamedTuple):
    """The S sides of joints whose blocks deform, ordered by block."""

    joint: np.ndarray  # (S,)
    block: np.ndarray  # (S,)
    half: np.ndarray  # (S,) distance of the block's centroid from the joint along the normal [m]


def joint_stiffness(assembly: Assembly, joints: Joints, young: np.ndarray, shear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal and tangential stiffness per area of each joint, (J,) each [N/m3]; infinite where neither block deforms.

    Args:
        assembly: the blocks.
        joints: of them at rest.
        young: E of each block (B,) [Pa]; infinite of one whose joints do not deform for it. Supports never do.
        shear: G likewise.
    """
    young, shear = (np.where(assembly.unyielding, np.inf, modulus) for modulus in (young, shear))
    half = _half_lengths(assembly, joints)
    both = np.stack([joints.block_a, joints.block_b], axis=1)
    with np.errstate(divide="ignore"):  # of two blocks that do not deform: infinite
        normal, plain = (1.0 / (half / modulus[both]).sum(axis=1) for modulus in (young, shear))
    joint, side = np.nonzero(np.isfinite(shear[both]))
    order = np.argsort(both[joint, side], kind="stable")
    joint, side = joint[order], side[order]
    asked = _bond_factors(assembly, joints, _Sides(joint, both[joint, side], half[joint, side]), normal, plain, shear)
    total, count = (np.bincount(joint, weights, joints.count) for weights in (asked, None))
    return normal, plain * np.where(count > 0, total / np.maximum(count, 1), 1.0)


def _half_lengths(assembly: Assembly, joints: Joints) -> np.ndarray:
    """Distances of the centroids of both blocks from each joint, along its normal, (J, 2) [m]."""
    middle, least = joints.centres(), THINNEST * libm.cbrt(assembly.volume)
    along = [
        np.maximum(np.abs(np.einsum("ji,ji->j", middle - assembly.centre[side], joints.normal)), least[side])
        for side in (joints.block_a, joints.block_b)
    ]
    return np.stack(along, axis=1)


def _bond_factors(
    assembly: Assembly, joints: Joints, sides: _Sides, normal: np.ndarray, plain: np.ndarray, shear: np.ndarray
) -> np.ndarray:
    """f as the block of each side asks for it, (S,); k_n and, for f = 1, k_t (J,) [N/m3] of the joints, G (B,) [Pa] of the blocks."""
    own, other = _pairs_by_block(sides.block)
    i, block = sides.joint[other], sides.block[own]
    n, neighbour = joints.normal[sides.joint[own]], joints.normal[i]
    axes = _across(n)
    square = np.einsum("pi,pi->p", n, neighbour) ** 2  # c^2
    reach = np.einsum("pki,pi->kp", axes, _between(assembly, joints, shear)[i])  # t . d_i
    of_both = np.isfinite(shear[joints.block_a] + shear[joints.block_b])[i]
    weight = np.where(of_both, 0.5, 1.0) * joints.area[i] / (assembly.volume[block] * shear[block])
    covered = joints.area[i] * sides.half[other] / assembly.volume[block]

    def sums(values: np.ndarray) -> np.ndarray:
        return np.bincount(own, values, len(sides.block))

    q_0 = [sums(weight * normal[i] * square * reach[j] * reach[k]) for j, k in ((0, 0), (0, 1), (1, 1))]
    q_1 = [sums(weight * plain[i] * (1.0 - square) * reach[j] * reach[k]) for j, k in ((0, 0), (0, 1), (1, 1))]
    c, s = _held_best(*(a + b for a, b in zip(q_0, q_1, strict=True)))
    along = c[own, None] * axes[:, 0] + s[own, None] * axes[:, 1]
    faces = sums(covered * np.einsum("pi,pi->p", along, neighbour) ** 2)  # 1: both faces across t have joints, 1/2: one
    beds = sums(covered * square)
    at_best = [c * c * q[0] + 2.0 * c * s * q[1] + s * s * q[2] for q in (q_0, q_1)]
    in_wall = _factor(at_best[0] / beds, at_best[1] / np.maximum(faces, ALONE))
    return np.asarray(np.where(faces > ALONE, 1.0 + (in_wall - 1.0) * np.minimum(1.0, 2.0 * faces), 1.0))


def _factor(q_0: np.ndarray, q_1: np.ndarray) -> np.ndarray:
    """The root f > 0 of the equation at the head of this file; 1 where nothing is next to the block."""
    b = 1.0 + q_1 - q_0
    root = b + np.sqrt(b * b + 4.0 * q_1 * q_0)
    return np.where(q_1 > ALONE, root / (2.0 * np.maximum(q_1, ALONE)), 1.0)


def _between(assembly: Assembly, joints: Joints, shear: np.ndarray) -> np.ndarray:
    """d_i from the centroid of the first block of each joint to that of the second, (J, 3) [m]; the joint for one that does not deform."""
    middle = joints.centres()
    ends = [np.where(np.isfinite(shear[side])[:, None], assembly.centre[side], middle) for side in (joints.block_a, joints.block_b)]
    return ends[1] - ends[0]


def _pairs_by_block(block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of sides of one block, itself with itself included, the first ascending: two arrays (P,); ``block`` (S,) is ascending."""
    first = np.searchsorted(block, block)
    count = np.searchsorted(block, block, side="right") - first
    own = np.repeat(np.arange(len(block)), count)
    within = np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count)
    return own, first[own] + within


def _across(n: np.ndarray) -> np.ndarray:
    """Two unit vectors across each of the normals (P, 3), (P, 2, 3)."""
    helper = np.zeros_like(n)
    helper[np.arange(len(n)), np.abs(n).argmin(axis=1)] = 1.0
    first = np.cross(n, helper)
    first /= np.sqrt(np.einsum("pi,pi->p", first, first))[:, None]
    return np.stack([first, np.cross(n, first)], axis=1)


def _held_best(xx: np.ndarray, xy: np.ndarray, yy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine (S,) of the direction in which tensors of two dimensions are largest; the first axis where all are alike."""
    apart, size = np.sqrt((xx - yy) ** 2 + 4.0 * xy * xy), xx + yy
    cosine = np.where(apart > ROUND * size, (xx - yy) / np.where(apart > 0.0, apart, 1.0), 1.0)  # of twice the angle
    c = np.sqrt(0.5 * (1.0 + cosine))
    return c, np.where(xy < 0.0, -1.0, 1.0) * np.sqrt(np.maximum(0.0, 0.5 * (1.0 - cosine)))
