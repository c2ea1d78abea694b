# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones as convex parts, cut from each other and put together so that the thinnest part is as thick as can be.

What of a convex part lies outside a convex solid is cut off by one plane of the solid after another. Two parts make one where each lies
within all planes of the other but the one between them. The thinnest part is joined first, to that with which it makes the thickest one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.polygon import loop_area, loop_planes
from structures.geometry.convex import halves
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.outer_shell import outer_shell

Planes = tuple[np.ndarray, np.ndarray]  # normals (F, 3) and offsets (F,) [m] of the faces of a solid, outward
ON = 1e-6  # planes and corners closer than this are one [m]
AREA = 1e-8  # what two parts share less of meets in an edge [m2]
OPPOSITE = -1.0 + 1e-9  # cosine of the angle between the normals of two faces that lie on each other


@dataclass(frozen=True, eq=False)
class ConvexCell:
    """A convex part of a stone: a cell, or two parts as one."""

    normals: np.ndarray  # (F, 3) of the faces, outward
    offsets: np.ndarray  # (F,) [m]
    corners: np.ndarray  # (V, 3), and points on its faces [m]
    cell: Block | None = None
    made_of: tuple[ConvexCell, ...] = ()

    @classmethod
    def of(cls, cell: Block) -> ConvexCell:
        """A convex block."""
        return cls(*planes(cell), cell.vertices, cell)

    @cached_property
    def block(self) -> Block:
        """With one face in each plane."""
        if self.cell is not None:
            return self.cell
        one, other = (part.block for part in self.made_of)
        shell = outer_shell([Polyhedron(part.vertices, part.faces) for part in (one, other)])
        return merge_coplanar([replace(one, vertices=shell.vertices, faces=shell.faces)])[0]

    @cached_property
    def width(self) -> float:
        """Least distance between two planes on both sides of it, along the normal of a face [m]."""
        return float(np.ptp(self.corners @ self.normals.T, axis=0).min())

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of the box about it, and a little more (3,) [m]."""
        return self.corners.min(axis=0) - ON, self.corners.max(axis=0) + ON

    def holds(self, part: ConvexCell) -> bool:
        """Return True if another one is among those that it is made of."""
        return self is part or any(one.holds(part) for one in self.made_of)

    def touches(self, other: ConvexCell) -> bool:
        """Return True if the boxes about both touch."""
        return bool((other.box[1] > self.box[0]).all() and (other.box[0] < self.box[1]).all())

    def faces_on(self, other: ConvexCell) -> list[tuple[int, int]]:
        """Numbers of faces of both that lie in one plane and look at each other."""
        if not self.touches(other):
            return []
        opposite = self.normals @ other.normals.T < OPPOSITE
        near = np.abs(self.offsets[:, None] + other.offsets[None]) < ON
        return [(int(i), int(j)) for i, j in np.argwhere(opposite & near)]

    def contact(self, other: ConvexCell) -> float:
        """Area that both share [m2]."""
        import shapely

        total = 0.0
        for i, j in self.faces_on(other):
            normal = self.normals[i]
            first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
            first /= np.linalg.norm(first)
            plane = np.stack([first, np.cross(normal, first)], axis=1)
            heights = (self, self.offsets[i]), (other, -other.offsets[j])
            on = [part.corners[np.abs(part.corners @ normal - z) < 2.0 * ON] for part, z in heights]
            one, its = (shapely.MultiPoint(points @ plane).convex_hull for points in on)
            total += float(one.intersection(its).area)
        return total

    def united(self, other: ConvexCell) -> ConvexCell | None:
        """Both as one; None where that is not convex."""
        for i, j in self.faces_on(other):
            mine, its = (np.arange(len(part.offsets)) != k for part, k in ((self, i), (other, j)))
            if not (_is_within(other, self.normals[mine], self.offsets[mine]) and _is_within(self, other.normals[its], other.offsets[its])):
                continue
            normals = np.concatenate([self.normals[mine], other.normals[its]])
            offsets = np.append(self.offsets[mine], other.offsets[its])
            kept = _first_of_each(normals, offsets)
            return ConvexCell(normals[kept], offsets[kept], np.concatenate([self.corners, other.corners]), None, (self, other))
        return None


def planes(solid: Polyhedron | Block) -> Planes:
    """The planes of the faces of a solid, the largest first: of small ones rounding turns the normal."""
    loops = sorted((solid.vertices[list(face)] for face in solid.faces), key=loop_area, reverse=True)
    return loop_planes(loops)


def _is_within(part: ConvexCell, normals: np.ndarray, offsets: np.ndarray) -> bool:
    return bool((part.corners @ normals.T - offsets).max() < ON)


def _first_of_each(normals: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Numbers of planes, one of each that are the same."""
    same = (np.abs(normals[:, None] - normals[None]).max(axis=2) < ON) & (np.abs(offsets[:, None] - offsets[None]) < ON)
    return np.flatnonzero(same.argmax(axis=1) == np.arange(len(offsets)))


def outside(part: ConvexCell, solid: Planes, first: np.ndarray) -> list[ConvexCell] | None:
    """Return the rest of a part outside a convex solid, in convex parts; None where they do not meet.

    The planes ``first`` (F,) bool cut before the others. Of these that comes first which leaves the thickest parts: a shallow pocket
    is cut off upright to the face that it is in, not along it.
    """
    rest, beyond = part, list[ConvexCell]()
    left = [(normal, float(offset), bool(early)) for normal, offset, early in zip(*solid, first, strict=True)]
    while True:
        heights = [rest.corners @ normal - offset for normal, offset, _ in left]
        if any(h.min() > -ON for h in heights):
            return None
        left = [plane for plane, h in zip(left, heights, strict=True) if h.max() > ON]
        cuts = []
        for k, (normal, offset, early) in enumerate(left):
            below, above = halves(rest.block, normal, offset)
            if below is None:
                return None
            if above is not None:
                parts = ConvexCell.of(below), ConvexCell.of(above)
                cuts.append((early, round(min(half.width for half in parts), 6), round(parts[0].width, 6), -k, parts))
        if not cuts:
            return beyond
        *_, k, (rest, out) = max(cuts, key=lambda cut: cut[:4])
        beyond.append(out)
        del left[-k]


def cut(parts: Iterable[ConvexCell], normals: np.ndarray, offsets: np.ndarray) -> list[ConvexCell]:
    """Parts cut by planes."""
    found = list(parts)
    for normal, offset in zip(normals, offsets.tolist(), strict=True):
        heights = [part.corners @ normal - offset for part in found]
        found = [
            one
            for part, h in zip(found, heights, strict=True)
            for one in (
                [part] if h.min() > -ON or h.max() < ON else [ConvexCell.of(half) for half in halves(part.block, normal, offset) if half]
            )
        ]
    return found


def joined(parts: Iterable[ConvexCell]) -> list[ConvexCell]:
    """Parts of a stone put together until no two of them make one; the thinnest first."""
    own = dict(enumerate(parts))
    unions: dict[tuple[int, int], ConvexCell | None] = {}  # of pairs that were tried
    found = True
    while found:
        found = False
        for k in sorted(own, key=lambda k: (own[k].width, k)):
            tried = {j: union for j in own if j != k for union in [_union(own, unions, min(j, k), max(j, k))] if union is not None}
            if tried:
                best = max(tried, key=lambda j: (round(tried[j].width, 6), -round(own[j].width, 6), -j))
                own[max(own) + 1] = tried[best]
                del own[k], own[best]
                found = True
                break
    return sorted(own.values(), key=lambda part: part.width)


def _union(parts: Mapping[int, ConvexCell], known: dict[tuple[int, int], ConvexCell | None], j: int, k: int) -> ConvexCell | None:
    """Two parts as one; None where that is not convex."""
    if (j, k) not in known:
        known[j, k] = parts[j].united(parts[k])
    return known[j, k]


def together(parts: Sequence[ConvexCell]) -> list[list[ConvexCell]]:
    """Parts that hang together by more than an edge, in groups."""
    links = [(i, j) for i, j in combinations(range(len(parts)), 2) if parts[i].contact(parts[j]) > AREA]
    first, second = (np.array([link[k] for link in links], dtype=int) for k in (0, 1))
    label = connected_components(first, second, len(parts))
    return [[parts[i] for i in np.flatnonzero(label == k).tolist()] for k in dict.fromkeys(label.tolist())]


def stone_of(block: Block, parts: Sequence[ConvexCell]) -> Block:
    """Convex parts that hang together as one stone, otherwise as a block."""
    first = parts[0].block
    if len(parts) == 1:
        return replace(block, vertices=first.vertices, faces=first.faces, parts=())
    solids = tuple(Polyhedron(part.block.vertices, part.block.faces) for part in parts)
    shell = outer_shell(solids)
    return replace(block, vertices=shell.vertices, faces=shell.faces, parts=solids)
