# SPDX-License-Identifier: GPL-3.0-or-later
r"""Modes of the bonded continuum: the blocks as one linearly elastic solid that cannot open.

Second-order tetrahedra (linear ones are 8 to 24 % too stiff for masonry in bending). With the shape functions N_i and
S_ij = int grad N_i (x) grad N_j dV, isotropic elasticity couples node i and node j by the 3 x 3 block

    K_ij = lambda S_ij + mu S_ij^T + mu tr(S_ij) I,        M_ij = I int density N_i N_j dV,

lambda and mu being Lame's constants (Zienkiewicz & Taylor, The Finite Element Method, vol. 1). The sides of the elements are straight and
their mass is consistent, so both integrals are exact. The solid is held where it touches a support.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from masonry_cd.analysis.modal.eigen import ByCholmod, lowest_modes, participation
from masonry_cd.analysis.modal.shapes import QuadraticShapes
from masonry_cd.analysis.modal.solid_mesh import SolidMesh, solid_mesh
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.components import connected_components

CHUNK = 4000  # elements whose matrices are held at a time


def continuum_modes(
    blocks: Sequence[Block],
    young: np.ndarray,
    poisson: float,
    count: int,
    *,
    size: float | None = None,
    order: int = 2,
    held: Mapping[str, np.ndarray] | None = None,
) -> dict[str, object]:
    """The lowest modes of the bonded solid.

    Args:
        blocks: of the structure, supports included.
        young: (B,) modulus of each block [Pa].
        poisson: Poisson's ratio.
        count: requested number of modes.
        size: of the elements [m]; about the thickness of the structure when not given.
        order: 2, or 1 for linear elements.
        held: by group of supports, which of x, y and z they hold, (3,) bool; all three when not given.

    Returns:
        ``frequencies`` (n,) [Hz], ``participation`` (n, 3), ``field`` and ``facts`` of :class:`masonry_cd.analysis.modal.modes.Modes`.

    Raises:
        InputError: the solid cannot be meshed, or a piece of it has no support.
    """
    begin = time.perf_counter()
    material = np.array([[young[i], block.density] for i, block in enumerate(blocks)])
    table, kinds = np.unique(material, axis=0, return_inverse=True)
    mesh = solid_mesh(blocks, kinds.ravel(), size)
    _check_supported(mesh, blocks)
    meshed = time.perf_counter()
    nodes, cells, gradients, volumes, products = _elements(mesh, order)
    stiffness = _stiffness(cells, gradients, volumes, table[mesh.kind, 0], poisson, len(nodes))
    mass = sparse.kron(_scattered(cells, products * table[mesh.kind, 1][:, None, None], len(nodes)), sparse.identity(3), format="csr")
    free = np.flatnonzero(~_held(mesh, nodes, cells, blocks, held or {}).ravel())
    translation = np.tile(np.eye(3), (len(nodes), 1))
    carried = (mass @ translation)[free]
    total = float(np.sum(mass @ translation[:, 0]))
    extent = np.ptp(mesh.points, axis=0).max()
    scale = float(np.max(table[mesh.kind, 0] / table[mesh.kind, 1]) / extent**2)
    pairs = lowest_modes(stiffness[free][:, free], mass[free][:, free], count, scale, ByCholmod)
    values = np.zeros((len(pairs.values), 3 * len(nodes)))
    values[:, free] = pairs.vectors
    facts = {
        "elements": len(cells),
        "order": order,
        "element_size_m": mesh.size,
        "unknowns": len(free),
        "rigid_motions": pairs.rigid,
        "mass_kg": total,
        "seconds_mesh": meshed - begin,
        "seconds": time.perf_counter() - begin,
    }
    field = QuadraticShapes(nodes, cells, values.reshape(len(values), -1, 3))
    return {"frequencies": pairs.frequencies, "participation": participation(pairs, carried, total), "field": field, "facts": facts}


def _elements(mesh: SolidMesh, order: int) -> tuple[np.ndarray, ...]:
    """Nodes (N, 3), cells (T, k), gradients (T, Q, k, 3) and weights (T, Q) for K, and int N_i N_j dV (T, k, k)."""
    require("the bonded continuum", "skfem")
    from skfem import Basis, ElementTetP1, ElementTetP2, MeshTet

    element = ElementTetP2() if order == 2 else ElementTetP1()
    grid = MeshTet(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.tetrahedra.T))
    basis = Basis(grid, element, intorder=2 * order - 2 or 1)
    gradients = np.array([function[0].grad for function in basis.basis]).transpose(2, 3, 0, 1)
    fine = Basis(grid, element, intorder=2 * order)
    shapes = np.array([np.broadcast_to(np.asarray(function[0]), fine.dx.shape) for function in fine.basis])
    products = np.einsum("itq,jtq,tq->tij", shapes, shapes, fine.dx, optimize=True)
    return basis.doflocs.T.copy(), basis.element_dofs.T.copy(), gradients, basis.dx, products


def _stiffness(
    cells: np.ndarray, gradients: np.ndarray, weights: np.ndarray, young: np.ndarray, poisson: float, nodes: int
) -> sparse.csr_matrix:
    """K, (3 N, 3 N), unknown 3 i + a for component a of node i."""
    count, k = cells.shape
    out = sparse.csr_matrix((3 * nodes, 3 * nodes))
    shear = young / (2.0 * (1.0 + poisson))
    volumetric = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    for first in range(0, count, CHUNK):
        part = slice(first, min(first + CHUNK, count))
        flat = gradients[part].reshape(part.stop - first, -1, 3 * k)
        outer = np.matmul((flat * weights[part, :, None]).transpose(0, 2, 1), flat).reshape(-1, k, 3, k, 3)  # S, as (t, i, a, j, b)
        block = volumetric[part, None, None, None, None] * outer
        block += shear[part, None, None, None, None] * outer.transpose(0, 1, 4, 3, 2)
        trace = shear[part, None, None] * np.einsum("tiaja->tij", outer)
        for a in range(3):
            block[:, :, a, :, a] += trace
        unknown = (3 * cells[part, :, None] + np.arange(3)).reshape(-1, 3 * k)
        out = out + _scattered(unknown, block.reshape(-1, 3 * k, 3 * k), 3 * nodes)
    return out


def _scattered(unknown: np.ndarray, blocks: np.ndarray, size: int) -> sparse.csr_matrix:
    """Sum element matrices (T, k, k) into a sparse matrix by their unknowns (T, k)."""
    k = unknown.shape[1]
    rows, columns = np.repeat(unknown, k, axis=1), np.tile(unknown, (1, k))
    return sparse.coo_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), (size, size)).tocsr()


def _held(mesh: SolidMesh, nodes: np.ndarray, cells: np.ndarray, blocks: Sequence[Block], held: Mapping[str, np.ndarray]) -> np.ndarray:
    """Components of nodes on the supports, (N, 3) bool."""
    out = np.zeros((len(nodes), 3), dtype=bool)
    supports = [block for block in blocks if block.fixed]
    between = {}
    if cells.shape[1] == 10:
        pairs = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
        ends = np.sort(cells[:, pairs].reshape(-1, 2), axis=1)
        between = dict(zip(map(tuple, ends.tolist()), cells[:, 4:].ravel().tolist(), strict=True))
    for support, (a, b, c) in zip(mesh.support.tolist(), mesh.triangles.tolist(), strict=True):
        here = [a, b, c]
        if between:
            here += [between[min(pair), max(pair)] for pair in ((a, b), (b, c), (a, c))]
        out[here] |= held.get(supports[support].group, np.ones(3, dtype=bool))
    return out


def _check_supported(mesh: SolidMesh, blocks: Sequence[Block]) -> None:
    """Where there are supports, each piece of the solid must touch one."""
    if not any(block.fixed for block in blocks):
        return
    if not len(mesh.triangles):
        raise InputError("modal", "no free block shares a face with a support")
    label = connected_components(mesh.tetrahedra[:, [0, 0, 0]].ravel(), mesh.tetrahedra[:, 1:].ravel(), len(mesh.points))
    loose = np.setdiff1d(label, label[mesh.triangles.ravel()])
    if len(loose):
        middle = mesh.points[label == loose[0]].mean(axis=0)
        free = [block for block in blocks if not block.fixed]
        nearest = min(free, key=lambda block: float(np.linalg.norm(block.vertices.mean(axis=0) - middle)))
        raise InputError("modal", f'block "{nearest.name}" is bonded to no support, neither itself nor through others')
