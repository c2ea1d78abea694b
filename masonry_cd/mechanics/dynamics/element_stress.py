# SPDX-License-Identifier: GPL-3.0-or-later
r"""The stress in the elements of meshed blocks, and how far their nodes move beyond the rigid block.

In an element of corners c with the gradients b_c of their shapes, the displacement u of the nodes has the strain

    e = sym sum_c u_c (x) b_c,        sigma = R C e R^T,

with Hooke's law C, that of plane stress in a plane, and the rotation R of the block. Over a step u is that of the strains and warps by
which the equation of motion takes its elastic and viscous forces (:meth:`masonry_cd.mechanics.dynamics.strain.Strains.stretches`), so that
the mean over the elements is the mean stress of the block (``mean_stress.py``). What is kept is the mean over the time since the last
frame, as of the blocks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.strain import Strains
from masonry_cd.mechanics.dynamics.warps import WarpArrays, Warps
from masonry_cd.mechanics.model.block_mesh import BlockMesh
from masonry_cd.mechanics.model.deformation import STRAINS
from masonry_cd.mechanics.model.warping import shape_slopes


class Elements(NamedTuple):
    """The elements of M meshed blocks, one block after the other: K nodes, E elements of d + 1 corners."""

    block: np.ndarray  # (M,) numbers of the blocks
    row: np.ndarray  # (M,) places among the blocks that deform
    node_start: np.ndarray  # (M + 1,)
    element_start: np.ndarray  # (M + 1,)
    corners: np.ndarray  # (E, d + 1) nodes, counted over all blocks
    slopes: np.ndarray  # (E, d + 1, 3) gradients of the corners' shapes, body frame [1/m]
    law: np.ndarray  # (M, 6, 6) stresses by strains xx yy zz yz xz xy, shear strains as angles [Pa]

    @classmethod
    def of(cls, strains: Strains) -> Elements:
        """Those of blocks of which some are meshed."""
        warps, deformation, columns = strains.warps, strains.deformation, strains.arrays.columns
        assert warps is not None
        row = np.flatnonzero(warps.of_block[deformation.block] >= 0)
        own = meshes_of(warps)
        node_start, element_start = starts(own)
        slopes = {id(mesh): np.zeros((*mesh.elements.shape, 3)) for mesh in warps.meshes}
        for mesh in warps.meshes:
            slopes[id(mesh)][:, :, mesh.dims] = shape_slopes(mesh)
        law = np.zeros((len(row), STRAINS, STRAINS))
        s = len(columns)
        law[:, columns[:, None], columns] = strains.stiffness[row, :s, :s] / deformation.volume[row, None, None]
        corners = [mesh.elements + first for mesh, first in zip(own, node_start[:-1], strict=True)]
        every = np.concatenate([slopes[id(mesh)] for mesh in own])
        return cls(deformation.block[row], row, node_start, element_start, np.concatenate(corners), every, law)


class ElementStress:
    """The mean stress of the elements since the last frame."""

    def __init__(self, strains: Strains) -> None:
        self._elements = Elements.of(strains)
        self.sums = np.zeros((len(self._elements.corners), 6))
        """(E, 6) over time, xx yy zz xy yz xz in the world frame [Pa s]; they grow in place."""

    def displacements(self, strains: Strains, strain: np.ndarray) -> np.ndarray:
        """How far the nodes of all meshed blocks are beyond the rigid blocks, body frames, (K, 3) [m], with strains (B, 6 + r)."""
        return node_motion(strains, strain[strains.deformation.block[:, None], strains.columns], self._elements)

    def take_step(self, strains: Strains, stretches: np.ndarray, rotation: np.ndarray) -> None:
        """Take a step with the stretches (D, S) of the blocks that deform and rotations (B, 3, 3)."""
        add_element_stresses(self._elements, node_motion(strains, stretches, self._elements), rotation, strains.step, self.sums)


def meshes_of(warps: Warps) -> list[BlockMesh]:
    """The mesh of each meshed block, in the order of the blocks."""
    return [warps.meshes[g] for g in warps.of_block if g >= 0]


def starts(meshes: list[BlockMesh]) -> tuple[np.ndarray, np.ndarray]:
    """Where the nodes and the elements of each mesh begin in arrays of all, (M + 1,) each."""
    return np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)]), np.cumsum([0, *(len(mesh.elements) for mesh in meshes)])


def elements_of(strains: Strains | None) -> int:
    """How many elements the blocks have."""
    return 0 if strains is None or strains.warps is None else int(starts(meshes_of(strains.warps))[1][-1])


def node_motion(strains: Strains, own: np.ndarray, elements: Elements) -> np.ndarray:
    """The displacements (K, 3) [m] of nodes with the unknown strains and warps (D, S) of the blocks that deform."""
    assert strains.warps is not None
    every = np.zeros((len(strains.arrays.place), STRAINS + strains.arrays.warps))
    every[strains.deformation.block[:, None], strains.columns] = own
    out = np.empty((elements.node_start[-1], 3))
    fill_node_motion(strains.warps.arrays, elements, strains.deformation.gradients(every), every[:, STRAINS:], out)
    return out


@entry()
def fill_node_motion(arrays: WarpArrays, elements: Elements, gradient: np.ndarray, warp: np.ndarray, out: np.ndarray) -> None:
    """Fill out (K, 3) with the displacements of nodes [m]: gradients (B, 3, 3) of the uniform part, and warps (B, r)."""
    for m in range(len(elements.block)):
        b = elements.block[m]
        first = arrays.node_start[arrays.mesh[b]] - elements.node_start[m]
        for n in range(elements.node_start[m], elements.node_start[m + 1]):
            for i in range(3):
                moved = 0.0
                for j in range(3):
                    moved += gradient[b, i, j] * arrays.nodes[first + n, j]
                for k in range(warp.shape[1]):
                    moved += arrays.shapes[first + n, i, k] * warp[b, k]
                out[n, i] = moved


@entry()
def add_element_stresses(elements: Elements, motion: np.ndarray, rotation: np.ndarray, step: float, sums: np.ndarray) -> None:
    """Add h sigma of displacements (K, 3) [m] of nodes to the sums (E, 6); rotations (B, 3, 3), h [s]."""
    g, own, turned = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    strain, stress = np.empty(6), np.empty(6)
    for m in range(len(elements.block)):
        r = rotation[elements.block[m]]
        for e in range(elements.element_start[m], elements.element_start[m + 1]):
            g[:, :] = 0.0
            for c in range(elements.corners.shape[1]):
                for i in range(3):
                    for j in range(3):
                        g[i, j] += motion[elements.corners[e, c], i] * elements.slopes[e, c, j]
            strain[0], strain[1], strain[2] = g[0, 0], g[1, 1], g[2, 2]
            strain[3], strain[4], strain[5] = g[1, 2] + g[2, 1], g[0, 2] + g[2, 0], g[0, 1] + g[1, 0]
            for i in range(6):
                stress[i] = 0.0
                for j in range(6):
                    stress[i] += elements.law[m, i, j] * strain[j]
            own[0, 0], own[1, 1], own[2, 2] = stress[0], stress[1], stress[2]
            own[1, 2], own[0, 2], own[0, 1] = stress[3], stress[4], stress[5]
            own[2, 1], own[2, 0], own[1, 0] = stress[3], stress[4], stress[5]
            for i in range(3):
                for j in range(3):
                    turned[i, j] = own[i, 0] * r[j, 0] + own[i, 1] * r[j, 1] + own[i, 2] * r[j, 2]  # C e R^T
            for k in range(3):
                l = (k + 1) % 3  # noqa: E741
                sums[e, k] += step * (r[k, 0] * turned[0, k] + r[k, 1] * turned[1, k] + r[k, 2] * turned[2, k])
                i, j = min(k, l), max(k, l)  # xy, yz, xz
                sums[e, 3 + k] += step * (r[i, 0] * turned[0, j] + r[i, 1] * turned[1, j] + r[i, 2] * turned[2, j])
