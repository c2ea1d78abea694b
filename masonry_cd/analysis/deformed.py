# SPDX-License-Identifier: GPL-3.0-or-later
r"""Where the blocks and the joints' corners are at a frame, seen from the base.

A point X of block b, built at rest, moves rigidly to

    x(X) = R_b (X - c_b) + x_b,

c_b the centre of mass at rest, x_b and R_b the position and rotation of the frame. Seen from the base, which itself rides on the
ground, x is taken back by the motion of a support s, to y = c_s + R_s^T (x - x_s): any will do where all move together, and where they do
not, as when one of them settles, it is the one that moves least (:attr:`masonry_cd.io.results.Results.support`). A picture of a
displacement too small to see shows instead

    X + f (y(X) - X),      f the amplification; f = 1 is the true shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.pauses import plans_of
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedra, Polyhedron, area_vectors
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import next_in_loop
from masonry_cd.mechanics.model.state import rotation_matrices


@dataclass(frozen=True, eq=False)
class Solids:
    """The blocks of a structure at rest in flat arrays: V vertices, F faces, L loop entries."""

    vertices: np.ndarray  # (V, 3) [m]
    vertex_block: np.ndarray  # (V,) block of each vertex
    loops: np.ndarray  # (L,) vertex indices, counted over all blocks
    loop_start: np.ndarray  # (F + 1,)
    face_block: np.ndarray  # (F,) block of each face
    centre: np.ndarray  # (B, 3) centres of mass [m]
    fixed: np.ndarray  # (B,) supports
    round: np.ndarray | None = None  # (B,) spheres, whose facets are drawn without edges; None: there are none
    plan: np.ndarray | None = None  # (B, 2, 2) low and high x, y of the structure of each block [m]; where there are spheres

    @classmethod
    def from_blocks(cls, blocks: Sequence[Block]) -> Solids:
        """Flatten sound blocks."""
        centre = np.array([b.mass_properties.centre for b in blocks])
        made = cls.of([Polyhedron(b.vertices, b.faces) for b in blocks], centre, np.array([b.fixed for b in blocks]))
        spheres = np.array([b.radius > 0.0 for b in blocks])
        return replace(made, round=spheres, plan=plans_of(blocks)) if spheres.any() else made

    @classmethod
    def of(cls, shells: Sequence[Polyhedron], centre: np.ndarray, fixed: np.ndarray) -> Solids:
        """Flatten the shells of B blocks, sound or not, with their centres (B, 3) [m]; ``fixed`` (B,) are supports."""
        flat = Polyhedra.of(shells)
        vertex_block = np.repeat(np.arange(len(shells)), np.diff(flat.vertex_start))
        return cls(flat.vertices, vertex_block, flat.loops, flat.loop_start, flat.owner_of_face(), centre, fixed)

    @cached_property
    def sizes(self) -> np.ndarray:
        """(B, 3) extents of each block along x, y, z at rest [m]."""
        low, high = np.full((len(self.centre), 3), np.inf), np.full((len(self.centre), 3), -np.inf)
        np.minimum.at(low, self.vertex_block, self.vertices)
        np.maximum.at(high, self.vertex_block, self.vertices)
        return high - low

    @cached_property
    def face_normals(self) -> np.ndarray:
        """(F, 3) outward unit normals at rest, by Newell's sum."""
        area = area_vectors(self.vertices, self.loops, self.loop_start)
        length = np.linalg.norm(area, axis=1, keepdims=True)
        return area / np.where(length > 0, length, 1.0)

    def edges(self, smallest_angle: float = 10.0) -> np.ndarray:
        """(E, 2) vertex pairs of the edges where faces meet at more than an angle [degrees], spheres and seams of flat faces left out."""
        following = next_in_loop(self.loop_start)
        a, b = self.loops, self.loops[following]
        face = np.repeat(np.arange(len(self.face_block)), np.diff(self.loop_start))
        order = np.lexsort((np.maximum(a, b), np.minimum(a, b)))
        low, high, face = np.minimum(a, b)[order], np.maximum(a, b)[order], face[order]
        first = np.flatnonzero((low[:-1] == low[1:]) & (high[:-1] == high[1:]))  # a closed shell lists each edge twice, in turn
        cosine = (self.face_normals[face[first]] * self.face_normals[face[first + 1]]).sum(axis=1)
        sharp = first[cosine < np.cos(np.radians(smallest_angle))]
        if self.round is not None:
            sharp = sharp[~self.round[self.vertex_block[low[sharp]]]]
        return np.stack([low[sharp], high[sharp]], axis=1)


@lru_cache(maxsize=2)
def solids_of(blocks: tuple[Block, ...]) -> Solids:
    """The flat arrays of the blocks of a result, made once for all reports on it."""
    return Solids.from_blocks(blocks)


@dataclass(frozen=True, eq=False)
class Pose:
    """Positions relative to the base (B, 3) [m], rotations (B, 3, 3) and strains of all blocks at one time."""

    time: float
    position: np.ndarray
    rotation: np.ndarray
    gradient: np.ndarray | None = None  # (B, 3, 3) of the displacement within each block, body frame; None where none deforms

    @classmethod
    def of(cls, results: Results, solids: Solids, frame: int = -1) -> Pose:
        """The pose of a frame; negative frames count from the end.

        Raises:
            InputError: no such frame.
        """
        frame = frame_index(results, frame)
        base, position = base_at(results, solids, frame), np.asarray(results.position[frame], dtype=float)
        rotation = base.rotations(rotation_matrices(np.asarray(results.orientation[frame], dtype=float)))
        return cls(float(results.time[frame]), base.seen(position), rotation, results.gradient(frame))

    def displacement(self, solids: Solids) -> np.ndarray:
        """(B, 3) of the centres of mass, relative to the base [m]."""
        return self.position - solids.centre

    def moved(self, solids: Solids, points: np.ndarray, block: np.ndarray, factor: float = 1.0) -> np.ndarray:
        """Points (N, 3) given at rest, carried by their blocks (N,), displacements amplified by a factor [m]."""
        arm = points - solids.centre[block]
        if self.gradient is not None:
            arm = arm + np.einsum("nij,nj->ni", self.gradient[block], arm)
        return points + factor * (np.einsum("nij,nj->ni", self.rotation[block], arm) + self.position[block] - points)


def moved_nodes(results: Results, pose: Pose, frame: int, factor: float = 1.0) -> np.ndarray:
    """The nodes of all meshed blocks at a frame, (K, 3), with displacements amplified by a factor [m].

    Raises:
        ValueError: the run kept no meshes.
    """
    if results.meshes is None:
        raise ValueError("no meshes")
    block, rest = results.meshes.block_of_node, results.meshes.nodes
    arm = rest - solids_of(results.blocks).centre[block] + np.asarray(results.node_displacement[frame], dtype=float)
    return np.asarray(rest + factor * (np.einsum("nij,nj->ni", pose.rotation[block], arm) + pose.position[block] - rest))


@dataclass(frozen=True, eq=False)
class Base:
    """Where the support is to which displacements are relative, at one time or at F times."""

    shift: np.ndarray  # (3,) or (F, 3) since the start [m]; zero where there is no support
    centre: np.ndarray  # (3,) as built [m]
    orientation: np.ndarray | None = None  # (4,) or (F, 4); None: it has not turned

    @classmethod
    def of(cls, support: int, centre: np.ndarray, position: np.ndarray, orientation: np.ndarray) -> Base:
        """That of a support, -1 for none, by centres as built (B, 3), positions (..., B, 3) and orientations (..., B, 4) of all blocks."""
        if support < 0:
            return cls(np.zeros((*position.shape[:-2], 3)), np.zeros(3))
        turned = np.asarray(orientation[..., support, :], dtype=float)
        shift = np.asarray(position[..., support, :] - centre[support])
        return cls(shift, centre[support], turned if turned[..., 1:].any() else None)

    @cached_property
    def _rotation(self) -> np.ndarray:
        """(3, 3) or (F, 3, 3)."""
        assert self.orientation is not None
        return rotation_matrices(self.orientation.reshape(-1, 4)).reshape(*self.orientation.shape[:-1], 3, 3)

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., N, 3) of the world as seen from the support [m]."""
        moved = points - self.shift[..., None, :]
        if self.orientation is None:
            return np.asarray(moved)
        return np.asarray(self.centre + np.einsum("...ji,...nj->...ni", self._rotation, moved - self.centre))

    def in_world(self, points: np.ndarray) -> np.ndarray:
        """Where points (N, 3) are that are so seen, at one time [m]."""
        if self.orientation is not None:
            points = self.centre + np.einsum("ij,nj->ni", self._rotation, points - self.centre)
        return np.asarray(points + self.shift)

    def rotations(self, rotation: np.ndarray) -> np.ndarray:
        """Rotations (B, 3, 3) as seen from the support, at one time."""
        return rotation if self.orientation is None else np.einsum("ji,bjk->bik", self._rotation, rotation)

    def orientations(self, orientation: np.ndarray) -> np.ndarray:
        """Quaternions (..., B, 4) as seen from the support."""
        if self.orientation is None:
            return orientation
        w, x, y, z = np.moveaxis(self.orientation, -1, 0)
        conjugate = np.array([[w, x, y, z], [-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])  # (4, 4, ...), from the left
        return np.einsum("ij...,...bj->...bi", conjugate, orientation)


def base_at(results: Results, solids: Solids, frames: int | slice) -> Base:
    """The base at a frame or at some frames."""
    support = results.support
    if support < 0:
        return Base(np.zeros((*np.shape(results.time[frames]), 3)), np.zeros(3))
    place, turned = (np.asarray(every[frames, [support]], dtype=float) for every in (results.position, results.orientation))
    return Base.of(0, solids.centre[[support]], place, turned)


def frame_index(results: Results, frame: int) -> int:
    """A frame as an index from the start.

    Raises:
        InputError: no such frame.
    """
    if not -results.frames <= frame < results.frames:
        raise InputError(f"frame {frame}", f"the result has frames 0 to {results.frames - 1}")
    return frame % results.frames


def joint_frame(results: Results, name: str, frame: int = -1) -> np.ndarray:
    """(J,) a joint measure at one frame; only that row is read."""
    return np.asarray(results.joints_at(name, frame_index(results, frame)), dtype=float)


def joint_corners(joints: Joints, solids: Solids, pose: Pose, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Corners of all interface polygons as block a and as block b carry them, (N, 3) each [m]."""
    sides = np.diff(joints.polygon_start)
    on_a, on_b = np.repeat(joints.block_a, sides), np.repeat(joints.block_b, sides)
    return pose.moved(solids, joints.polygon, on_a, factor), pose.moved(solids, joints.polygon, on_b, factor)


def smallest_gap(joints: Joints, solids: Solids, pose: Pose) -> np.ndarray:
    """(J,) smallest gap over the corners of each joint, along its normal as block a carries it [m].

    Near zero in a hinge, which still touches along an edge; positive only where the blocks have come apart everywhere.
    """
    if joints.count == 0:
        return np.zeros(0)
    return np.asarray(np.minimum.reduceat(corner_gaps(joints, solids, pose), joints.polygon_start[:-1]))


def corner_gaps(joints: Joints, solids: Solids, pose: Pose) -> np.ndarray:
    """(N,) gap at each corner of the joints, along their normals as block a carries them [m]."""
    on_a, on_b = joint_corners(joints, solids, pose)
    normal = np.einsum("jik,jk->ji", pose.rotation[joints.block_a], joints.normal)
    return np.asarray(((on_b - on_a) * np.repeat(normal, np.diff(joints.polygon_start), axis=0)).sum(axis=1))
