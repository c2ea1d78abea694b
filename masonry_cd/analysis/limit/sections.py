# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joints that crush: their sections, cut into cells of uniform stress.

A joint without tension bears stresses 0 <= sigma <= f on its area A. A rectangle b x t then carries N with

    |M| <= N b / 2 (1 - N / (f b t)),

the stress block of which lies at the edge. **Cells** c, which the joint's polygon is cut into, carry forces 0 <= N_c <= f A_c in their
centroids x_c: every such field is one that the joint bears, so their resultants lie inside its domain, whatever the polygon and about
whatever axis it bends. Under a mechanism in which the joint closes by a(x) = a_0 + a_1 . x, the field of most work is f where a > 0; cells
that are cut along a = 0 make it exactly. So cells are cut where a mechanism asks for it, and there alone.

A bond of tensile strength f_t bears -f_t <= sigma <= f: the same cells with f + f_t, from the uniform field -f_t on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.interfaces import Interfaces
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import clip_loops

NEAR_EDGE = (0.02, 0.06, 0.15, 0.3, 0.5)  # first cuts, shares of the depth from either edge: the domain is 2 % short at first
IN_SPACE = (0.1,)  # fewer along either axis: their number goes with the square
SLIVER = 1e-9  # share of a section's area below which a cell is none
HALVINGS = 50  # of the range in which the edge of a stress block is looked for


@dataclass(frozen=True, eq=False)
class Cells:
    """K convex polygons in the planes of their sections."""

    corners: np.ndarray  # (L, 2) along the axes of the section, over its size
    start: np.ndarray  # (K + 1,)
    owner: np.ndarray  # (K,) section

    @property
    def area(self) -> np.ndarray:
        """(K,) over the squares of the sizes."""
        return self._moments()[0]

    @property
    def centroid(self) -> np.ndarray:
        """(K, 2)."""
        area, first = self._moments()
        return first / area[:, None]

    def _moments(self) -> tuple[np.ndarray, np.ndarray]:
        """Areas (K,) and first moments (K, 2), by fans of triangles about the first corners."""
        loop = np.repeat(np.arange(len(self.owner)), np.diff(self.start))
        origin = self.corners[self.start[:-1]]
        here = self.corners - origin[loop]
        after = np.roll(here, -1, axis=0)
        after[self.start[1:] - 1] = 0.0
        twice = here[:, 0] * after[:, 1] - after[:, 0] * here[:, 1]
        area = 0.5 * np.bincount(loop, twice, minlength=len(origin))
        first = np.stack([np.bincount(loop, twice * part, minlength=len(origin)) for part in (here + after).T], axis=1) / 6.0
        return np.abs(area), origin * np.abs(area)[:, None] + first * np.sign(area)[:, None]

    def beyond(self, normal: np.ndarray, offset: np.ndarray) -> Cells:
        """Return the cells where normal . x >= offset, of lines (S, 2) and (S,) in the sections; slivers are left out."""
        loop = np.repeat(self.owner, np.diff(self.start))
        distance = np.einsum("ld,ld->l", self.corners, normal[loop]) - offset[loop]
        corners, start, rows = clip_loops(self.corners, self.start, distance)
        left = Cells(corners, start, self.owner[rows])
        return left.only(left.area > SLIVER)

    def only(self, which: np.ndarray) -> Cells:
        """Some of them (K,) bool."""
        sides = np.diff(self.start)
        return Cells(self.corners[np.repeat(which, sides)], np.concatenate([[0], np.cumsum(sides[which])]), self.owner[which])

    def cut(self, normal: np.ndarray, offset: np.ndarray) -> Cells:
        """All of them, those that lines (S, 2) and (S,) cross in two; a line without a normal crosses nothing."""
        crossed = (normal != 0.0).any(axis=1)[self.owner]
        whole, asked = self.only(~crossed), self.only(crossed)
        parts = [whole, asked.beyond(normal, offset), asked.beyond(-normal, -offset)]
        starts = [np.diff(part.start) for part in parts]
        owner = np.concatenate([part.owner for part in parts])
        return Cells(np.concatenate([part.corners for part in parts]), np.concatenate([[0], np.cumsum(np.concatenate(starts))]), owner)


@dataclass(frozen=True, eq=False)
class Sections:
    """S sections with n levers each: one in a plane, two in space; the closing rate is a_0 + a_1 . x, x over the size of the section."""

    joint: np.ndarray  # (S,)
    strength: np.ndarray  # (S,) f + f_t [Pa]
    tension: np.ndarray  # (S,) f_t [Pa]
    origin: np.ndarray  # (S, 3) [m]
    axes: np.ndarray  # (S, 2, 3) unit vectors in the plane of the joint, that of bending first
    size: np.ndarray  # (S,) [m]
    levers: int  # n
    outline: Cells  # S, the polygons themselves
    cells: Cells

    @property
    def force(self) -> np.ndarray:
        """(K,) what each cell bears at most [N]."""
        return self.cells.area * (self.strength * self.size**2)[self.cells.owner]

    @property
    def area(self) -> np.ndarray:
        """(S,) [m2]."""
        return self.outline.area * self.size**2

    def basis(self, points: np.ndarray, owner: np.ndarray) -> np.ndarray:
        """(1, x) at points (P, 3) of sections (P,): what a closing rate at them is made of, (P, 1 + n)."""
        arm = points - self.origin[owner]
        along = np.einsum("pd,ped->pe", arm, self.axes[owner])[:, : self.levers] / self.size[owner, None]
        return np.concatenate([np.ones((len(points), 1)), along], axis=1)

    def closing(self, rate: np.ndarray) -> np.ndarray:
        """(S,) the largest closing rate at a corner, of rates (S, 1 + n); below zero none."""
        at = rate[self.outline.owner.repeat(np.diff(self.outline.start))]
        value = at[:, 0] + np.einsum("ln,ln->l", at[:, 1:], self.outline.corners[:, : self.levers])
        return np.maximum.reduceat(value, self.outline.start[:-1])

    def only(self, which: np.ndarray) -> Sections:
        """Some of them (S,) bool, with their cells."""
        number = np.cumsum(which) - 1
        outline, cells = self.outline.only(which), self.cells.only(which[self.cells.owner])
        return replace(
            self, joint=self.joint[which], strength=self.strength[which], tension=self.tension[which], origin=self.origin[which],
            axes=self.axes[which], size=self.size[which], outline=replace(outline, owner=number[outline.owner]),
            cells=replace(cells, owner=number[cells.owner]),
        )  # fmt: skip

    def cut_for(self, rate: np.ndarray, normal_force: np.ndarray, which: np.ndarray) -> Sections:
        """Cells cut where a mechanism asks for it: along a = 0, and along the edge of the stress block of the force that is borne.

        Args:
            rate: (S, 1 + n) a_0 and a_1.
            normal_force: (S,) what the cells bear together [N].
            which: (S,) sections that are cut.
        """
        normal = np.zeros((len(self.joint), 2))
        normal[which, : self.levers] = rate[which, 1:]
        length = np.linalg.norm(normal, axis=1)
        turns = length > 0.0
        normal[turns] /= length[turns, None]
        neutral = np.where(turns, -rate[:, 0] / np.where(turns, length, 1.0), 0.0)
        cells = self.cells.cut(normal, neutral)
        return replace(self, cells=cells.cut(normal, self._block_edge(normal, normal_force / (self.strength * self.size**2))))

    def _block_edge(self, normal: np.ndarray, area: np.ndarray) -> np.ndarray:
        """(S,) the offset beyond which lies an area (S,) of each section, along normals (S, 2), by halving."""
        reach = np.einsum("ld,ld->l", self.outline.corners, normal[np.repeat(self.outline.owner, np.diff(self.outline.start))])
        low, high = np.minimum.reduceat(reach, self.outline.start[:-1]), np.maximum.reduceat(reach, self.outline.start[:-1])
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            left = self.outline.beyond(normal, middle)
            there = np.bincount(left.owner, left.area, minlength=len(area))
            low, high = np.where(there > area, middle, low), np.where(there > area, high, middle)
        return low


def sections(assembly: Assembly, joints: Joints, points: Interfaces, axis: int | None) -> Sections | None:
    """The sections of the joints with points that have a compressive strength, None of none; ``axis`` as of :func:`interfaces`."""
    rows = assembly.rows(joints.block_a, joints.block_b)
    strength, tension = assembly.laws.crushing[rows], assembly.laws.tension[rows]
    first = np.full(joints.count, -1)
    first[points.joint[::-1]] = np.arange(points.count)[::-1]
    chosen = np.flatnonzero((strength > 0.0) & (first >= 0))
    if not len(chosen):
        return None
    frame = points.frame[first[chosen]]
    axes = frame[:, 1:] if axis is None else np.stack([frame[:, 1], np.cross(frame[:, 0], frame[:, 1])], axis=1)
    loops = [joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]] for j in chosen]
    origin, size = np.array([loop.mean(axis=0) for loop in loops]), np.sqrt(joints.area[chosen])
    flat = [(loop - origin[s]) @ axes[s].T / size[s] for s, loop in enumerate(loops)]
    outline = Cells(np.concatenate(flat), np.concatenate([[0], np.cumsum([len(loop) for loop in loops])]), np.arange(len(chosen)))
    levers = 2 if axis is None else 1
    total = strength[chosen] + tension[chosen]
    return Sections(chosen, total, tension[chosen], origin, axes, size, levers, outline, _first_cells(outline, levers))


def _first_cells(outline: Cells, levers: int) -> Cells:
    """Sections cut across each lever, finely near the edges, where stress blocks of small forces lie."""
    shares = NEAR_EDGE if levers == 1 else IN_SPACE
    cells = outline
    for lever in range(levers):
        low, high = (part.reduceat(outline.corners[:, lever], outline.start[:-1]) for part in (np.minimum, np.maximum))
        normal = np.zeros((len(low), 2))
        normal[:, lever] = 1.0
        for share in (*shares, *(1.0 - share for share in shares if share < 0.5)):
            cells = cells.cut(normal, low + share * (high - low))
    return cells
