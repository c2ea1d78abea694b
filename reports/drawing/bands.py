# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joints as bands: what a map draws between the blocks.

A joint seen from the side is a line; to show it, its interface polygon is given a thickness. The band of a joint runs along the
sides of the polygon and fills the space between the two blocks, from the corners as block a carries them to those as block b
does; where they are closer than the line is wide, it is as wide as the line. So a hinge shows as the wedge that it is. The band
stands a little proud of the blocks, or their faces would hide it. Faces that have parted get thin plates instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids, joint_corners
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.parts import Surface, View, ribbon

PROUD = 0.5  # how far a band stands out, in line widths
DASH = 3.0  # length of a dash, in line widths
PLATE = 0.7  # thickness of a plate, in line widths
LIFT = 1e-3  # by which bands stand before the blocks, as a share of the picture's height


@dataclass(frozen=True, eq=False)
class DrawnJoints:
    """J joints as they are drawn, whose polygons have N corners."""

    corners: tuple[np.ndarray, np.ndarray]  # (N, 3) as block a carries them, and as block b does [m]
    start: np.ndarray  # (J + 1,) of the polygons
    blocks: np.ndarray  # (2, J)
    normals: np.ndarray  # (2, J, 3) from a to b, as a carries it and as b does
    shown: np.ndarray  # (J,) bool, those that have a band
    colours: tuple[np.ndarray, np.ndarray]  # (J, 3) uint8, between which its dashes alternate
    width: float  # of a closed joint's band [m]
    parted: np.ndarray  # (2, J) bool, those whose face on a, on b has a plate
    plate: np.ndarray  # (3,) uint8

    @classmethod
    def at(cls, joints: Joints, solids: Solids, pose: Pose, factor: float, width: float) -> DrawnJoints:
        """Joints of which none is shown, in a pose whose displacements are amplified by a factor."""
        blocks, no = np.stack([joints.block_a, joints.block_b]), np.zeros(joints.count, dtype=bool)
        normals = np.stack([np.einsum("jik,jk->ji", pose.rotation[block], joints.normal) for block in blocks])
        corners, white = joint_corners(joints, solids, pose, factor), np.full((joints.count, 3), 255, np.uint8)
        return cls(corners, joints.polygon_start, blocks, normals, no, (white, white), width, np.stack([no, no]), white[:1].ravel())

    @cached_property
    def owner(self) -> np.ndarray:
        """(N,) the joint of each corner, and of the side that begins there."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))

    @cached_property
    def middles(self) -> np.ndarray:
        """(N, 3) corners halfway between the two blocks [m]."""
        return np.asarray((self.corners[0] + self.corners[1]) / 2.0)

    def band_corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners (N, 3) of the bands of all joints, on the side of block a and on that of block b."""
        n = self.normals[0][self.owner]
        half = 0.5 * np.maximum(((self.corners[1] - self.corners[0]) * n).sum(axis=1), self.width)[:, None]
        middle = self._grown(self.middles)
        return middle - half * n, middle + half * n

    def bands(self, hidden: np.ndarray | None = None) -> Bands:
        """The bands of the joints shown; sides hidden (2, N) by block a or b are left out."""
        kept = self.shown[self.owner] if hidden is None else self.shown[self.owner] & ~hidden.any(axis=0)
        return self._sides(*self.band_corners(), kept)

    def plates(self, hidden: np.ndarray | None = None) -> Bands:
        """The plates of faces that have parted; a side that its own block hides is left out."""
        parts = []
        for k in range(2):
            shift = 0.5 * PLATE * self.width * self.normals[k][self.owner]
            middle, kept = self._grown(self.corners[k]), self.parted[k][self.owner]
            parts.append(self._sides(middle - shift, middle + shift, kept if hidden is None else kept & ~hidden[k]))
        return Bands(np.concatenate([p.corners for p in parts]), np.concatenate([p.joint for p in parts]))

    def dashed(self, bands: Bands) -> Surface:
        """The surface of bands, cut into dashes of the joints' colours.

        Every side begins and ends with the first colour, so that short ones show it.
        """
        a0, a1, b1, b0 = (bands.corners[:, k] for k in range(4))
        length = np.maximum(np.linalg.norm(a1 - a0, axis=1), np.linalg.norm(b1 - b0, axis=1))
        first, second = (colour[bands.joint] for colour in self.colours)
        pieces = np.where((first == second).all(axis=1), 1, 2 * np.round(length / (2 * DASH * self.width)).astype(int).clip(0, 500) + 1)
        side = np.repeat(np.arange(len(pieces)), pieces)
        k = np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        low, high = (k / pieces[side])[:, None], ((k + 1) / pieces[side])[:, None]
        quad = [a0[side] + low * (a1 - a0)[side], a0[side] + high * (a1 - a0)[side]]
        quad += [b0[side] + high * (b1 - b0)[side], b0[side] + low * (b1 - b0)[side]]
        colours = np.where((k % 2 == 0)[:, None], first[side], second[side]).astype(np.uint8)
        return ribbon(np.stack(quad, axis=1), colours, lift=LIFT, owner=self.blocks[:, bands.joint[side]])

    def plain(self, bands: Bands) -> Surface:
        """The surface of plates."""
        colours = np.tile(self.plate, (len(bands.joint), 1))
        return ribbon(bands.corners, colours, lift=LIFT, owner=self.blocks[:, bands.joint])

    def _grown(self, corners: np.ndarray) -> np.ndarray:
        """Polygons (N, 3) grown away from their centres."""
        if not len(corners):
            return corners
        arm = corners - self.centres(corners)[self.owner]
        length = np.maximum(np.linalg.norm(arm, axis=1, keepdims=True), 1e-30)
        return np.asarray(corners + PROUD * self.width * np.sqrt(2.0) * arm / length)

    def centres(self, corners: np.ndarray) -> np.ndarray:
        """(J, 3) means of the corners (N, 3) of each polygon."""
        return np.asarray(np.add.reduceat(corners, self.start[:-1]) / np.diff(self.start)[:, None])

    def _sides(self, on_a: np.ndarray, on_b: np.ndarray, kept: np.ndarray) -> Bands:
        """The sides kept (N,) of the prisms between two sets of corners (N, 3)."""
        following = next_in_loop(self.start)
        corners = np.stack([on_a, on_a[following], on_b[following], on_b], axis=1)
        return Bands(corners[kept], self.owner[kept])


@dataclass(frozen=True, eq=False)
class Bands:
    """Sides of drawn polygons: S of them with their four corners, and the joint each belongs to."""

    corners: np.ndarray  # (S, 4, 3): first and second on a, second and first on b [m]
    joint: np.ndarray  # (S,)

    def facing(self, view: View) -> Bands:
        """Those that look at the viewer: outward from the middle of their joint."""
        middle = self.corners.mean(axis=1)
        _, row = np.unique(self.joint, return_inverse=True)
        centre = np.stack([np.bincount(row, axis) for axis in middle.T], axis=1) / np.bincount(row)[:, None]
        normal = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 3] - self.corners[:, 0])
        normal *= np.sign(np.einsum("si,si->s", normal, middle - centre[row]))[:, None]
        seen = normal @ view.towards > 1e-6 * np.linalg.norm(normal, axis=1)
        return Bands(self.corners[seen], self.joint[seen])
