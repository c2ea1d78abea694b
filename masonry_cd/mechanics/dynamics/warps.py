# SPDX-License-Identifier: GPL-3.0-or-later
r"""The warps of meshed blocks in the step: what contacts see of them.

A point X of a surface moves with its facet. Seen from the centre of the block, without its strain, it is at Y, which lies on a facet with
the nodes k and the barycentric coordinates l_k; so with the shapes w of the block's mesh (``model/warping.py``), its rotation R and its
warps q,

    X = x + map Y + R sum_k l_k w_k q,        the row of H along t is        sign t . R sum_k l_k w_k.

Detection knows the block with its strain only, so the gap that it finds is less the warp of one surface, and more by that of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.facets import Facets
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.planar import Plane
from masonry_cd.mechanics.model.block_mesh import BlockMesh, block_mesh
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.deformation import Deformation
from masonry_cd.mechanics.model.geometry import Polyhedron, inverse_row
from masonry_cd.mechanics.model.warping import mesh_stiffness, warp_shapes

UNKNOWNS = (8, 10, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768)  # of a block: kernels are compiled for each


class WarpArrays(NamedTuple):
    """The meshes as the kernels read them: G of them, with N nodes and T facets of d corners together, and r warps at the most."""

    mesh: np.ndarray  # (B,) of each block; -1: it has none
    node_start: np.ndarray  # (G + 1,)
    nodes: np.ndarray  # (N, 3) from the centre of the block, body frame [m]
    shapes: np.ndarray  # (N, 3, r)
    facet_start: np.ndarray  # (G + 1,)
    facets: np.ndarray  # (T, d) nodes, counted over all meshes


class Touch(NamedTuple):
    """Where both sides of C contacts lie on facets of d corners; forces have one side."""

    node: np.ndarray  # (C, 2, d) nodes, counted over all meshes; -1: the block has no mesh
    share: np.ndarray  # (C, 2, d) barycentric coordinates


@dataclass(frozen=True, eq=False)
class Warps:
    """The meshes of the blocks of a scene."""

    meshes: tuple[BlockMesh, ...]  # G
    of_block: np.ndarray  # (B,) which a block has; -1: none
    arrays: WarpArrays
    facets: Facets  # as detection reads them

    @classmethod
    def of(cls, assembly: Assembly, plane: Plane | None, others: int) -> Warps | None:
        """Those of an assembly, whose blocks have other unknowns, as many as given; None: no block is meshed.

        Raises:
            InputError: a block cannot be meshed.
        """
        deformation = assembly.deformation
        if deformation is None or not deformation.mesh_size.any():
            return None
        meshes, of_block = _meshes(assembly, deformation, plane)
        arrays = _arrays(meshes, of_block, _count(meshes, others, deformation.room))
        return cls(meshes, of_block, arrays, Facets.of(assembly.shapes, meshes, of_block))

    @property
    def count(self) -> int:
        """Warps r of a block, with those that it has no use for."""
        return int(self.arrays.shapes.shape[2])

    def stiffness(self, b: int, law: np.ndarray, gradients: np.ndarray) -> np.ndarray:
        """That of the strains of block b, with displacement gradients (s, 3, 3), and of all its warps, (s + r, s + r) [J] per volume."""
        mesh, shapes = self.meshes[self.of_block[b]], self.shapes(b)
        strained = np.einsum("kij,nj->nik", gradients, mesh.nodes)
        return mesh_stiffness(mesh, law, np.concatenate([strained, shapes], axis=2))

    def shapes(self, b: int) -> np.ndarray:
        """Those of block b, (N, 3, r)."""
        g = self.of_block[b]
        return self.arrays.shapes[self.arrays.node_start[g] : self.arrays.node_start[g + 1]]

    def farthest(self, warp: np.ndarray) -> float:
        """The largest displacement of a node, or its speed, in warps or their rates (B, r)."""
        return float(farthest_node(self.arrays, warp))

    def touches(self, bodies: np.ndarray, point: np.ndarray, position: np.ndarray, maps: np.ndarray, plane: int) -> Touch:
        """Where points (C, 3) [m] lie on the surfaces of two blocks each (C, 2), or of one (C, 1); ``plane``: its axis, -1 in space."""
        shape = (*bodies.shape, self.arrays.facets.shape[1])
        touch = Touch(np.full(shape, -1), np.zeros(shape))
        fill_touches(self.arrays, bodies, point, position, maps, plane, touch)
        return touch

    def forces(self, acting: tuple[np.ndarray, np.ndarray], touch: Touch, rotation: np.ndarray) -> np.ndarray:
        """Return the forces along the warps of all blocks, (B, r) [N]: blocks (N,) and forces (N, 3) in the world, rotations (B, 3, 3).

        One that acts inside a block pulls at the nearest place of its surface, ``touch``.
        """
        blocks, force = acting
        out, on = np.zeros((len(self.of_block), self.count)), self.of_block[blocks] >= 0
        own = np.einsum("nji,nj->ni", rotation[blocks[on]], force[on])
        moved = np.einsum("nk,nkir->nir", touch.share[on, 0], self.arrays.shapes[touch.node[on, 0]])
        np.add.at(out, blocks[on], np.einsum("ni,nir->nr", own, moved))
        return out


def warps_of(assembly: Assembly, plane: Plane | None, others: int) -> int:
    """How many warps r :class:`Warps` would have, by the numbers of nodes alone; 0: no block is meshed.

    Raises:
        InputError: a block cannot be meshed.
    """
    deformation = assembly.deformation
    if deformation is None or not deformation.mesh_size.any():
        return 0
    return _count(_meshes(assembly, deformation, plane)[0], others, deformation.room)


def _count(meshes: tuple[BlockMesh, ...], others: int, room: int) -> int:
    """How many warps fill the unknowns of a block, next to ``others``, up to the next of UNKNOWNS that is no less than ``room``."""
    least = max(room, others + max(mesh.warps for mesh in meshes))
    return next(n for n in UNKNOWNS if n >= least) - others


def _meshes(assembly: Assembly, deformation: Deformation, plane: Plane | None) -> tuple[tuple[BlockMesh, ...], np.ndarray]:
    """The meshes of an assembly, and which of them each block has (B,), -1 for none."""
    meshes: dict[int, BlockMesh] = {}
    of_block = np.full(assembly.count, -1)
    for b, size in zip(deformation.block, deformation.mesh_size, strict=True):
        if size > 0.0:
            block = assembly.blocks[b]
            shell = Polyhedron(block.vertices - assembly.centre[b], block.faces)
            mesh = block_mesh(block.name, shell, float(size), -1 if plane is None else plane.axis)
            of_block[b] = list(meshes).index(id(mesh)) if id(mesh) in meshes else len(meshes)
            meshes[id(mesh)] = mesh
    return tuple(meshes.values()), of_block


def _arrays(meshes: tuple[BlockMesh, ...], of_block: np.ndarray, count: int) -> WarpArrays:
    """The arrays of the kernels, with a given number of warps."""
    shapes = [warp_shapes(mesh) for mesh in meshes]
    node_start = np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)])
    return WarpArrays(
        mesh=of_block,
        node_start=node_start,
        nodes=np.concatenate([mesh.nodes for mesh in meshes]),
        shapes=np.concatenate([np.pad(own, ((0, 0), (0, 0), (0, count - own.shape[2]))) for own in shapes]),
        facet_start=np.cumsum([0, *(len(mesh.facets) for mesh in meshes)]),
        facets=np.concatenate([mesh.facets + start for mesh, start in zip(meshes, node_start[:-1], strict=True)]),
    )


@entry()
def farthest_node(arrays: WarpArrays, warp: np.ndarray) -> float:
    """The largest displacement of a node with warps (B, r) [m]."""
    largest = 0.0
    for b in range(len(arrays.mesh)):
        g = arrays.mesh[b]
        if g < 0:
            continue
        for n in range(arrays.node_start[g], arrays.node_start[g + 1]):
            total = 0.0
            for d in range(3):
                moved = 0.0
                for k in range(warp.shape[1]):
                    moved += arrays.shapes[n, d, k] * warp[b, k]
                total += moved * moved
            largest = max(largest, total)
    return np.sqrt(largest)


@entry()
def fill_touches(
    arrays: WarpArrays, bodies: np.ndarray, point: np.ndarray, position: np.ndarray, maps: np.ndarray, plane_axis: int, touch: Touch
) -> None:
    """Fill ``touch`` with the nearest facets of points (C, 3) on blocks (C, 2); positions (B, 3) [m] and maps (B, 3, 3)."""
    arm, inner, share = np.empty(3), np.empty(3), np.empty(3)
    for c in range(len(bodies)):
        for side in range(bodies.shape[1]):
            b = bodies[c, side]
            g = arrays.mesh[b]
            if g < 0:
                continue
            for k in range(3):
                arm[k] = 0.0 if k == plane_axis else point[c, k] - position[b, k]
            for k in range(3):
                x, y, z = inverse_row(maps, b, k)
                inner[k] = 0.0 if k == plane_axis else x * arm[0] + y * arm[1] + z * arm[2]
            least = np.inf
            for f in range(arrays.facet_start[g], arrays.facet_start[g + 1]):
                distance = _on_facet(arrays.nodes, arrays.facets[f], inner, share)
                if distance < least:
                    least = distance
                    for k in range(arrays.facets.shape[1]):
                        touch.node[c, side, k], touch.share[c, side, k] = arrays.facets[f, k], share[k]


@borrower()
def _on_facet(nodes, facet, at, share):
    """Fill ``share`` with the barycentric coordinates of the place of a segment or triangle below a point (3,); its squared distance."""
    uu, uv, vv, uw, vw = 0.0, 0.0, 0.0, 0.0, 0.0
    for d in range(3):
        u, w = nodes[facet[1], d] - nodes[facet[0], d], at[d] - nodes[facet[0], d]
        v = nodes[facet[len(facet) - 1], d] - nodes[facet[0], d]
        uu, uv, vv, uw, vw = uu + u * u, uv + u * v, vv + v * v, uw + u * w, vw + v * w
    if len(facet) == 2:
        share[1], share[2] = uw / uu, 0.0
    else:
        det = uu * vv - uv * uv
        share[1], share[2] = (uw * vv - vw * uv) / det, (vw * uu - uw * uv) / det
    share[0] = 1.0 - share[1] - share[2]
    total = 0.0
    for k in range(len(facet)):  # outside, a place on the edge or so
        share[k] = max(share[k], 0.0)
        total += share[k]
    distance = 0.0
    for k in range(len(facet)):
        share[k] /= total
    for d in range(3):
        off = at[d]
        for k in range(len(facet)):
            off -= share[k] * nodes[facet[k], d]
        distance += off * off
    return distance


@entry()
def warped_gaps(arrays: WarpArrays, found: ContactSet, own: np.ndarray, touch: Touch, rotation: np.ndarray, warp: np.ndarray) -> np.ndarray:
    """Gaps of contacts found [m], those ``own`` (C,) with warps (B, r) of their blocks, of rotations (B, 3, 3)."""
    out, along, row = found.gap.copy(), np.empty(3), np.empty(warp.shape[1])
    for c in range(len(own)):
        at = own[c]
        for side in range(2):
            b = found.bodies[at, side]
            if arrays.mesh[b] < 0:
                continue
            _turned_back(rotation, b, found.normal[at], along)
            _fill_row(arrays.shapes, touch.node[c, side], touch.share[c, side], along, 1.0 - 2.0 * side, row)
            for k in range(len(row)):
                out[at] += row[k] * warp[b, k]
    return out


@entry()
def fill_warp_rows(arrays: WarpArrays, touch: Touch, rotation: np.ndarray, rows: ContactRows) -> None:
    """Fill the last r columns of H of all contacts, see the head of this file; rotations (B, 3, 3) at q_m."""
    jacobian, along = rows.geometry.jacobian, np.empty(3)
    first = jacobian.shape[3] - arrays.shapes.shape[2]
    for c in range(len(rows.active)):
        for side in range(2):
            b = rows.blocks[c, side]
            for i in range(jacobian.shape[2]):
                row = jacobian[c, side, i, first:]
                if arrays.mesh[b] < 0:
                    row[:] = 0.0
                    continue
                _turned_back(rotation, b, rows.frame[c, i], along)
                _fill_row(arrays.shapes, touch.node[c, side], touch.share[c, side], along, 1.0 - 2.0 * side, row)


@borrower()
def _turned_back(rotation, b, unit, along):
    """Fill along (3,) with a unit vector (3,) in the body frame of block b."""
    for i in range(3):
        along[i] = rotation[b, 0, i] * unit[0] + rotation[b, 1, i] * unit[1] + rotation[b, 2, i] * unit[2]


@borrower()
def _fill_row(shapes, node, share, along, sign, row):
    """Fill row (r,) with how a place on a facet moves along a direction (3,) of the body frame with each warp, times a sign."""
    for k in range(len(row)):
        row[k] = 0.0
    for n in range(len(node)):
        for d in range(3):
            factor = sign * share[n] * along[d]
            for k in range(len(row)):
                row[k] += factor * shapes[node[n], d, k]
