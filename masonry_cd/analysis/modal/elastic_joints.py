# SPDX-License-Identifier: GPL-3.0-or-later
r"""Modes of rigid blocks on elastic joints: what a rigid-block model keeps of the elasticity of its stones.

The deformation of two blocks is gathered in the joint between them, by :mod:`masonry_cd.mechanics.model.joint_stiffness`, with
G = E / (2 (1 + nu)). With d(x) = u_b - u_a the relative displacement of the faces,
u = v + theta x (x - c), the energy of a joint is 1/2 int d^T (k_t (1 - n n^T) + k_n n n^T) d dA. Its integrand is
quadratic, and the midpoints of the sides of each triangle of the polygon integrate it exactly.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse

from masonry_cd.analysis.modal.eigen import SHIFT, by_superlu, lowest_modes, participation
from masonry_cd.analysis.modal.shapes import RigidShapes
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.footings import Footings
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
from masonry_cd.mechanics.model.joints import Joints

Stiffness = tuple[np.ndarray, np.ndarray]
ITERATIONS, CLOSE = 8, 0.01  # of the search for one period, and the share of the eigenvalue that ends it: half a per cent of the period


def joint_modes(
    blocks: Sequence[Block],
    young: np.ndarray,
    poisson: float,
    count: int,
    *,
    stiffness: tuple[float, float] | Stiffness | None = None,
    held: Mapping[str, np.ndarray] | None = None,
    footings: Footings | None = None,
) -> dict[str, object]:
    """The lowest modes of rigid blocks on elastic joints.

    Args:
        blocks: of the structure, supports included.
        young: (B,) modulus of each block [Pa].
        poisson: Poisson's ratio.
        count: requested number of modes.
        stiffness: k_n and k_t of all joints, or of each joint (J,), [Pa/m] instead of those that follow from the modulus.
        held: by group of supports, which of x, y and z they hold, (3,) bool; all three when not given.
        footings: blocks on springs of the ground; None: supports hold what stands on them.

    Returns:
        ``frequencies`` (n,) [Hz], ``participation`` (n, 3), ``field`` and ``facts`` of :class:`masonry_cd.analysis.modal.modes.Modes`.

    Raises:
        InputError: a block that no joint ties to a support.
    """
    begin = time.perf_counter()
    assembly = replace(Assembly.from_blocks(blocks, 0.0), footings=footings)
    joints = find_joints(assembly)
    _check_supported(assembly, joints)
    if stiffness is None:
        normal, tangential = joint_stiffness(assembly, joints, young, young / (2.0 * (1.0 + poisson)))
    else:
        normal, tangential = (np.broadcast_to(np.asarray(value, dtype=float), joints.count) for value in stiffness)
    free = np.flatnonzero(~assembly.fixed)
    unknown = (6 * free[:, None] + np.arange(6)).ravel()
    matrix = _stiffness(assembly, joints, normal, tangential, _directions(assembly, joints, held or {}))[unknown][:, unknown]
    mass = _mass(assembly)[unknown][:, unknown]
    carried = mass @ np.tile(np.vstack([np.eye(3), np.zeros((3, 3))]), (len(free), 1))
    total = float(assembly.mass[free].sum())
    pairs = lowest_modes(matrix, mass, count, _scale(assembly, joints, normal))
    motion = pairs.vectors.reshape(len(pairs.values), len(free), 6)
    field = RigidShapes([blocks[int(i)] for i in free], assembly.centre[free], motion[..., :3].copy(), motion[..., 3:].copy())
    facts = {
        "blocks": len(free),
        "joints": joints.count,
        "unknowns": len(unknown),
        "normal_stiffness_pa_m": [float(normal.min()), float(normal.max())],
        "tangential_stiffness_pa_m": [float(tangential.min()), float(tangential.max())],
        "rigid_motions": pairs.rigid,
        "mass_kg": total,
        "seconds": time.perf_counter() - begin,
    }
    return {"frequencies": pairs.frequencies, "participation": participation(pairs, carried, total), "field": field, "facts": facts}


def period_along(assembly: Assembly, joints: Joints, stiffness: Stiffness, direction: np.ndarray) -> float:
    """Period of the lowest mode that a motion of the base along a direction (3,) excites [s]; 0 where joints tie no block to a support.

    Inverse iterations from the rigid shift of all blocks, the first of which gives their deflection under a uniform acceleration, with one
    factor; the last Rayleigh quotient errs by the square of what the shape does.
    """
    free = np.flatnonzero(~assembly.fixed & _tied(assembly, joints))
    if not len(free):
        return 0.0
    unknown = (6 * free[:, None] + np.arange(6)).ravel()
    matrix = _stiffness(assembly, joints, *stiffness, np.ones((joints.count, 3)))[unknown][:, unknown]
    mass = _mass(assembly)[unknown][:, unknown]
    solve = by_superlu(matrix + SHIFT * _scale(assembly, joints, stiffness[0]) * mass)
    shape, value, last = np.tile([*direction, 0.0, 0.0, 0.0], len(free)), 1.0, np.inf
    for _ in range(ITERATIONS):
        shape = solve(mass @ shape)
        shape /= np.sqrt(np.einsum("i,i", shape, mass @ shape))
        value, last = float(np.einsum("i,i", shape, matrix @ shape)), value
        if abs(value - last) < CLOSE * value:
            break
    return 2.0 * np.pi / float(np.sqrt(value))


def _stiffness(assembly: Assembly, joints: Joints, normal: np.ndarray, tangential: np.ndarray, directions: np.ndarray) -> sparse.csr_matrix:
    """K over all blocks, (6 B, 6 B), unknowns d and theta of each block."""
    point, weight, owner = _midpoints(joints)
    n = joints.normal
    law = tangential[:, None, None] * np.eye(3) + (normal - tangential)[:, None, None] * np.einsum("ji,jk->jik", n, n)
    law = law * directions[:, :, None] * directions[:, None, :]
    map_a = -_rigid_map(point - assembly.centre[joints.block_a[owner]])
    map_b = _rigid_map(point - assembly.centre[joints.block_b[owner]])
    both = np.concatenate([map_a, map_b], axis=2)  # (Q, 3, 12)
    part = np.matmul(both.transpose(0, 2, 1), np.matmul(law[owner] * weight[:, None, None], both))
    blocks = np.add.reduceat(part, np.searchsorted(owner, np.arange(joints.count)))
    unknown = np.stack([joints.block_a, joints.block_b], axis=1)[:, :, None] * 6 + np.arange(6)
    unknown = unknown.reshape(-1, 12)
    whole = _spread(blocks, unknown, assembly.count)
    footings = assembly.footings
    if footings is None:
        return whole
    rows = np.concatenate([_rigid_map(footings.arms[:, 0]), np.eye(6)[None, 3:].repeat(len(footings.arms), axis=0)], axis=1)
    own = np.matmul(rows.transpose(0, 2, 1), np.matmul(footings.stiffness, rows))
    return whole + _spread(own, footings.blocks[:, :1] * 6 + np.arange(6), assembly.count)


def _spread(parts: np.ndarray, unknown: np.ndarray, blocks: int) -> sparse.csr_matrix:
    """The sum over all blocks, (6 B, 6 B), of matrices (N, n, n) of some of their unknowns (N, n)."""
    n = unknown.shape[1]
    rows, columns = np.repeat(unknown, n, axis=1), np.tile(unknown, (1, n))
    return sparse.coo_matrix((parts.ravel(), (rows.ravel(), columns.ravel())), (6 * blocks,) * 2).tocsr()


def _midpoints(joints: Joints) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Midpoints of the sides of a fan of triangles in each polygon: places (Q, 3), weights (Q,) [m2] and joints (Q,), ascending."""
    corners = np.diff(joints.polygon_start)
    owner = np.repeat(np.arange(joints.count), corners - 2)
    within = np.concatenate([np.arange(1, c - 1) for c in corners]).astype(np.int64)
    first = joints.polygon_start[owner]
    a, b, c = (joints.polygon[i] for i in (first, first + within, first + within + 1))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    points = np.stack([0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)], axis=1)
    return points.reshape(-1, 3), np.repeat(area / 3.0, 3), np.repeat(owner, 3)


def _rigid_map(arm: np.ndarray) -> np.ndarray:
    """The matrices (Q, 3, 6) of d + theta x arm."""
    out = np.zeros((len(arm), 3, 6))
    out[:, :, :3] = np.eye(3)
    x, y, z = arm.T
    out[:, 0, 4], out[:, 0, 5] = z, -y
    out[:, 1, 3], out[:, 1, 5] = -z, x
    out[:, 2, 3], out[:, 2, 4] = y, -x
    return out


def _mass(assembly: Assembly) -> sparse.csr_matrix:
    """Masses and inertias of all blocks, (6 B, 6 B)."""
    blocks = np.zeros((assembly.count, 6, 6))
    blocks[:, :3, :3] = assembly.mass[:, None, None] * np.eye(3)
    blocks[:, 3:, 3:] = assembly.inertia
    return sparse.bsr_matrix((blocks, np.arange(assembly.count), np.arange(assembly.count + 1))).tocsr()


def _directions(assembly: Assembly, joints: Joints, held: Mapping[str, np.ndarray]) -> np.ndarray:
    """1 where a joint acts in x, y and z, (J, 3); a joint with a support that lets a direction go does not act in it."""
    out = np.ones((joints.count, 3))
    for side in (joints.block_a, joints.block_b):
        for group, axes in held.items():
            if group in assembly.groups:
                on = assembly.fixed[side] & (assembly.group_of[side] == assembly.groups.index(group))
                out[on] *= axes
    return out


def _scale(assembly: Assembly, joints: Joints, normal: np.ndarray) -> float:
    """E / (density length^2) of the structure [1/s2], E from the stiffness of the joints and the sizes of the blocks."""
    free = ~assembly.fixed
    block = float(np.median(np.cbrt(assembly.volume[free])))
    density = float(assembly.mass[free].sum() / assembly.volume[free].sum())
    extent = np.ptp(joints.polygon, axis=0).max()
    return float(np.max(normal)) * block / (density * extent**2)


def _check_supported(assembly: Assembly, joints: Joints) -> None:
    """Where there are supports, joints must tie every block to one."""
    if not assembly.fixed.any():
        return
    loose = np.flatnonzero(~_tied(assembly, joints))
    if len(loose):
        raise InputError("modal", f'block "{assembly.names[loose[0]]}" is tied to no support, neither itself nor through others')


def _tied(assembly: Assembly, joints: Joints) -> np.ndarray:
    """Which blocks joints tie to a support or a footing, (B,) bool; these are."""
    label = connected_components(joints.block_a, joints.block_b, assembly.count)
    return np.isin(label, label[assembly.unyielding])
