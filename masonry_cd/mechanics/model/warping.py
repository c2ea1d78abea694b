# SPDX-License-Identifier: GPL-3.0-or-later
r"""How a meshed block warps: the shapes that its mesh adds to the uniform strain, and their stiffness.

The nodes X_i of a block of d dimensions move by any d N numbers. Of these, d (d + 1) are the motion of a block of uniform strain
(``deformation.py``): translations, rotations and strains, fields that are linear in X, which uniform-strain elements hold exactly. The
others are the warps: fields w orthogonal to all linear ones, in the metric of the lumped masses, m_i = sum of mass / (d + 1) over the
elements at a node,

    sum_i m_i w_i = 0,        sum_i m_i w_i (x) X_i = 0,

spanned by r = d N - d (d + 1) shapes, orthonormal in the share of the mass at each node. So what best fits a motion of the nodes is its
strain, with the state of a block in one row: the strain, and the warps q as root-mean-square displacements [m]. The mass matrix is

    exact for the linear fields (a mesh of one element is a block of uniform strain), the mass of the block times the unit matrix for warps,

and the stiffness that of the elements, T^T K T with T of all these fields: exact for a mesh, coupled between strain and warps.

The shapes come of Householder's reflections (Golub & Van Loan, Matrix Computations, sect. 5.2).
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.model.block_mesh import BlockMesh

SHEAR_PAIRS = {2: ((0, 1),), 3: ((1, 2), (0, 2), (0, 1))}  # of the coordinates of a mesh, in the order of the strains


def node_shares(mesh: BlockMesh) -> np.ndarray:
    """Share of the block's mass at each node, (N,)."""
    out, corners = np.zeros(len(mesh.nodes)), mesh.elements.shape[1]
    np.add.at(out, mesh.elements, np.repeat(mesh.shares()[:, None] / corners, corners, axis=1))
    return out


def warp_shapes(mesh: BlockMesh) -> np.ndarray:
    """The shapes of the warps, (N, 3, r); none across the plane of a plane scene."""
    dims, weight = mesh.dims, np.sqrt(node_shares(mesh))
    linear = np.concatenate([np.ones((len(mesh.nodes), 1)), mesh.nodes[:, dims] / np.abs(mesh.nodes).max()], axis=1)
    basis = _complement(weight[:, None] * linear) / weight[:, None]  # (N, N - d - 1), of one coordinate
    out = np.zeros((len(mesh.nodes), 3, len(dims) * basis.shape[1]))
    for k, d in enumerate(dims):
        out[:, d, k :: len(dims)] = basis
    return out


def _complement(a: np.ndarray) -> np.ndarray:
    """Orthonormal columns (N, N - p) that are orthogonal to those of a (N, p)."""
    rest, (size, count) = a.copy(), a.shape
    out = np.eye(size)[:, count:]
    reflectors = []
    for k in range(count):
        x = rest[k:, k].copy()
        x[0] += np.copysign(np.sqrt(np.sum(x * x)), x[0])
        x /= np.sqrt(np.sum(x * x))
        rest[k:] -= 2.0 * x[:, None] * np.sum(x[:, None] * rest[k:], axis=0)
        reflectors.append(x)
    for k in range(count - 1, -1, -1):
        x = reflectors[k]
        out[k:] -= 2.0 * x[:, None] * np.sum(x[:, None] * out[k:], axis=0)
    return out


def shape_slopes(mesh: BlockMesh) -> np.ndarray:
    """Gradients of the shapes of the corners of each element, (E, d + 1, d) [1/m]."""
    corners = mesh.nodes[:, mesh.dims][mesh.elements]
    spans = corners[:, 1:] - corners[:, :1]
    inverse = np.linalg.inv(spans)  # (E, d, d): of corners 1 and on, by column
    return np.asarray(np.concatenate([-inverse.sum(axis=2)[:, :, None], inverse], axis=2).transpose(0, 2, 1))


def element_strains(mesh: BlockMesh) -> np.ndarray:
    """Strains of the elements by the displacements of their corners, (E, s, d + 1, d) [1/m]; shear strains as angles."""
    d, gradient = len(mesh.dims), shape_slopes(mesh)
    pairs = (*((i, i) for i in range(d)), *SHEAR_PAIRS[d])
    out = np.zeros((len(gradient), len(pairs), d + 1, d))
    for row, (i, j) in enumerate(pairs):
        out[:, row, :, i] = gradient[:, :, j]
        out[:, row, :, j] = gradient[:, :, i]
    return out


def mesh_stiffness(mesh: BlockMesh, law: np.ndarray, fields: np.ndarray) -> np.ndarray:
    """Stiffness of a mesh for fields of displacements (N, 3, S), (S, S) [J] per volume of the block.

    ``law`` (s, s) [Pa] is Hooke's in the coordinates of the mesh.
    """
    moved = fields[:, mesh.dims][mesh.elements]  # (E, d + 1, d, S)
    strain = np.einsum("esci,ecik->esk", element_strains(mesh), moved)
    stress = np.einsum("st,etk->esk", law, strain) * mesh.shares()[:, None, None]
    return np.asarray(strain.reshape(-1, strain.shape[2]).T @ stress.reshape(-1, strain.shape[2]))
