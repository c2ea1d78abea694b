# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks that are not convex, split exactly into convex parts.

Space is cut by the planes of the block's own faces, one after another (a binary space partition: Fuchs, Kedem & Naylor, SIGGRAPH 1980).
Each cell keeps the pieces of faces that still lie inside it. A cell without any lies wholly inside or outside the block, which the
winding number of the shell about its centre tells (van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30, 1983). The cells inside are
convex, fill the block and do not overlap: no volume is gained or lost, as it is where hulls stand for the parts.

Of the planes of a cell the one that splits the fewest pieces of faces is taken first, so an L makes two parts and a U three.

Its shell keeps its corners, but faces that are not convex become triangles: whoever draws a face or integrates over it may fan it out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_cd.mechanics.model.blocks import Block, refuse_spheres
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron, sixfold_volumes, triangles
from masonry_cd.mechanics.model.polygon import clip, clip_loops, loop_area, loop_normal, loop_planes
from structures.geometry.checks import FLATNESS, WARPED, Unsound, check, warp
from structures.geometry.loops import open_edges, single_loop
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.near_points import numbered
from structures.geometry.prism import box
from structures.size import MOST_BENT

ON_PLANE = 1e-6  # relative to the size of the block: corners closer to a plane than this lie on it
MOST_PARTS = 500  # a block that needs more is not a stone but a scan
MOST_FACES = 5_000  # of a block that is not convex: the tables of their sides take 50 MB
WORK = 500_000  # entries of tables of sides for each face of a block, of some 4 ns each
FEW = 1_000  # faces: a block with fewer may take the work of these
CUT = 250_000  # entries that take as long as cutting one cell
FACE = 1_500  # entries that take as long as cutting one face of a cell
TABLED = 1_000_000  # heights of corners over planes that are held at a time


class _Unsplit(ValueError):
    """Why a block cannot be cut, for the user."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """N polygons of a shell inside a cell, and how they lie to each other's planes."""

    loops: list[np.ndarray]  # N of (n, 3) [m]
    normal: np.ndarray  # (N, 3)
    offset: np.ndarray  # (N,) [m]
    above: np.ndarray  # (N, N) whether anything of polygon i lies above the plane of polygon j
    below: np.ndarray  # (N, N)

    @classmethod
    def of(cls, loops: list[np.ndarray], on: float) -> Pieces:
        """From polygons; corners within ``on`` [m] of a plane lie in it."""
        normal, offset = loop_planes(loops)
        return cls(loops, normal, offset, *_sides(loops, normal, offset, on))


@dataclass(frozen=True, eq=False)
class Cell:
    """A convex polyhedron, and the pieces of the shell inside it."""

    vertices: np.ndarray
    faces: Faces
    pieces: Pieces | None = None


def split(block: Block) -> Block:
    """Give a block without parts the convex parts that it needs, and convex faces; a convex one is returned as it is.

    Args:
        block: closed, outward, with planar faces (:func:`structures.geometry.checks.check_shells`); its faces need not be convex.

    Raises:
        Unsound: more than MOST_PARTS parts, or faces so warped that no sound parts come of it; names the block.
    """
    if block.parts or is_convex(block):
        return block
    on = ON_PLANE * size_of(block)
    try:
        with np.errstate(invalid="ignore"):  # faces without area, which the check refuses, have no plane
            faces = tuple(loop for face in block.faces for loop in _convex_loops(block.vertices, face))
            inside = [part for part in _cells(block, on) if _winding(block, part.vertices.mean(axis=0)) > 0.5]
            parts = tuple(_finished(cell, block, on) for cell in inside)
            whole = replace(block, faces=faces, parts=parts)
            if not parts:
                raise _Unsplit("its shell encloses nothing")
            check([whole])
    except (_Unsplit, Unsound) as failure:
        raise Unsound(f'block "{block.name}"', _why(block, failure), [block.name]) from None
    return whole


def _why(block: Block, failure: Exception) -> str:
    """The line for a block that cannot be split: what is wrong with its faces as they were given, and what would help."""
    line, remedy = "not convex, and cannot be split into convex parts", "give it as convex blocks"
    size, off = size_of(block), warp(block)
    reasons = [str(failure)] if isinstance(failure, _Unsplit) else []
    if ON_PLANE * size < off < WARPED * size:
        hull = "give its convex hull, " if excess(block) < WARPED * size else ""
        flat = f"{1e3 * ON_PLANE * size:.2g} mm would count as flat"
        reasons.append(f"its faces are warped by up to {1e3 * off:.3g} mm ({flat}); make them flat, {hull}or {remedy}")
        return f"{line}: {', and '.join(reasons)}"
    return f"{line}: {', '.join(reasons) or 'its faces pass through each other, or make slivers'}; {remedy}"


def halves(block: Block, normal: np.ndarray, offset: float) -> tuple[Block | None, Block | None]:
    """A convex block cut by the plane ``normal . x = offset`` [m]: what lies below it and above it, None where nothing does.

    Raises:
        Unsound: its faces are too warped to be cut; names the block.
    """
    return below(block, normal, offset), below(block, -normal, -offset)


def below(block: Block, normal: np.ndarray, offset: float) -> Block | None:
    """The part of a convex block below a plane; the block where all of it is, None where nothing is.

    Raises:
        Unsound: its faces are too warped to be cut; names the block.
    """
    on = ON_PLANE * size_of(block)
    try:
        side = _below(Cell(block.vertices, block.faces), normal, offset, on)
        if side is None or side.vertices is block.vertices:
            return None if side is None else block
        refuse_spheres([block], "structure", "cutting by a plane")
        made = _finished(side, block, on)
    except _Unsplit:
        raise Unsound(
            f'block "{block.name}"',
            f"cannot be cut by a plane: its faces are warped by up to {1e3 * warp(block):.3g} mm; make them flat",
            [block.name],
        ) from None
    return replace(block, vertices=made.vertices, faces=made.faces)


def is_convex(block: Block) -> bool:
    """Return True if no vertex lies outside the plane of any face, to the tolerance of :mod:`structures.geometry.checks`."""
    return excess(block) <= FLATNESS * size_of(block)


def excess(block: Block) -> float:
    """How far a vertex lies outside the plane of a face at most [m]; NaN where a face has no area, and so no plane."""
    with np.errstate(invalid="ignore"):
        normals, offsets = loop_planes([block.vertices[list(face)] for face in block.faces])
    some = max(1, TABLED // len(block.vertices))
    portions = (slice(k, k + some) for k in range(0, len(normals), some))
    return max(float((block.vertices @ normals[own].T - offsets[own]).max()) for own in portions)


def size_of(block: Block) -> float:
    """The diagonal of the box around a block [m]."""
    return float(np.linalg.norm(np.ptp(block.vertices, axis=0)))


def _cells(block: Block, on: float) -> list[Cell]:
    """Cut the space around a block by the planes of its faces until no cell holds a piece of the shell.

    It ends: the piece whose plane cuts a cell is in neither half, and another is in each half at most once.
    """
    if len(block.faces) > MOST_FACES:
        raise _Unsplit(f"it has {len(block.faces)} faces, more than {MOST_FACES}")
    low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
    room = 0.1 * np.linalg.norm(high - low)
    vertices, faces = box(tuple(low - room), tuple(high + room))
    whole = Pieces.of([block.vertices[list(face)] for face in block.faces], on)
    todo, done, left = [Cell(vertices, faces, whole)], [], WORK * max(len(block.faces), FEW)
    while todo:
        cell = todo.pop()
        if cell.pieces is None:
            done.append(cell)
            if len(done) > MOST_PARTS + len(block.faces):
                raise _Unsplit(f"it takes more than {MOST_PARTS}")
            continue
        left -= CUT + FACE * len(cell.faces) + len(cell.pieces.loops) ** 2
        if left < 0:
            raise _Unsplit(f"it takes too many cuts for its {len(block.faces)} faces")
        best = _best_plane(cell.pieces)
        normal, offset = cell.pieces.normal[best], float(cell.pieces.offset[best])
        todo += [side for side in (_below(cell, normal, offset, on, best), _below(cell, -normal, -offset, on, best)) if side is not None]
    return done


def _best_plane(pieces: Pieces) -> int:
    """The piece whose plane splits the fewest others; of equals, the one that leaves the halves most alike."""
    splits = (pieces.above & pieces.below).sum(axis=0)
    even = np.abs(pieces.above.sum(axis=0) - pieces.below.sum(axis=0))
    return int(np.lexsort((even, splits))[0])


def _sides(loops: Sequence[np.ndarray], normal: np.ndarray, offset: np.ndarray, on: float) -> tuple[np.ndarray, np.ndarray]:
    """Which polygons (N,) reach above and below which planes (M,), two tables (N, M)."""
    start, points = _starts(loops)[:-1], np.concatenate(loops)
    above, below = np.empty((2, len(loops), len(offset)), dtype=bool)
    some = max(1, TABLED // len(points))
    for k in range(0, len(offset), some):
        heights = np.einsum("vi,pi->vp", points, normal[k : k + some]) - offset[k : k + some]
        above[:, k : k + some] = np.maximum.reduceat(heights, start) > on
        below[:, k : k + some] = np.minimum.reduceat(heights, start) < -on
    return above, below


def _pieces_below(pieces: Pieces, normal: np.ndarray, offset: float, on: float, own: int) -> Pieces | None:
    """Return the share of some pieces below the plane of one of them; None where nothing lies there."""
    start = _starts(pieces.loops)
    heights = _heights(np.concatenate(pieces.loops), normal, offset)
    stays, crosses = np.minimum.reduceat(heights, start[:-1]) < -on, np.maximum.reduceat(heights, start[:-1]) > on
    stays[own] = False
    loops = {k: pieces.loops[k] for k in np.flatnonzero(stays).tolist()}
    for k in np.flatnonzero(stays & crosses).tolist():
        loops[k] = clip(pieces.loops[k], -heights[start[k] : start[k + 1]], on)
        if len(loops[k]) < 3 or loop_area(loops[k]) == 0.0:  # bounds nothing
            del loops[k]
    if not loops:
        return None
    kept = np.array(list(loops))
    rows, left = np.ix_(kept, kept), list(loops.values())
    out = Pieces(left, pieces.normal[kept], pieces.offset[kept], pieces.above[rows], pieces.below[rows])
    new = np.flatnonzero(crosses[kept])
    if len(new):
        clipped = [left[k] for k in new]
        out.normal[new], out.offset[new] = loop_planes(clipped)
        out.above[new], out.below[new] = _sides(clipped, out.normal, out.offset, on)
        out.above[:, new], out.below[:, new] = _sides(left, out.normal[new], out.offset[new], on)
    return out


def _below(cell: Cell, normal: np.ndarray, offset: float, on: float, own: int = -1) -> Cell | None:
    """The part of a cell below a plane, that of its piece ``own``; None where nothing of it is."""
    heights = _heights(cell.vertices, normal, offset)
    if heights.min() >= -on:
        return None
    pieces = None if cell.pieces is None else _pieces_below(cell.pieces, normal, offset, on, own)
    if heights.max() <= on:
        return Cell(cell.vertices, cell.faces, pieces)
    corners, start = np.array([i for face in cell.faces for i in face]), _starts(cell.faces)
    reaching = np.minimum.reduceat(heights[corners], start[:-1]) < -on  # the other faces lie above or in the plane
    corners, counts = corners[np.repeat(reaching, np.diff(start))], np.diff(start)[reaching]
    cut, ends, _ = clip_loops(cell.vertices[corners], np.cumsum([0, *counts]), -heights[corners], on)
    points, index = numbered(cut, on)
    faces = [tuple(dict.fromkeys(part.tolist())) for part in np.split(index, ends[1:-1])]
    rim = single_loop([(b, a) for a, b in open_edges(faces)])
    if rim is None:  # where faces are warped, or slivers
        raise _Unsplit("its faces cut each other into slivers")
    return Cell(points, (*(face for face in faces if len(face) > 2), rim), pieces)


def _starts(loops: Sequence[Any]) -> np.ndarray:
    return np.cumsum([0, *map(len, loops)])


def _heights(points: np.ndarray, normal: np.ndarray, offset: float) -> np.ndarray:
    """Distances (n,) of points (n, 3) from a plane [m]; BLAS would round otherwise on another processor."""
    return np.asarray(np.sum(points * normal, axis=1) - offset)


def _convex_loops(vertices: np.ndarray, face: tuple[int, ...]) -> list[tuple[int, ...]]:
    """A face as it is where its loop is convex, else its triangles, by cutting off ear after ear, the roundest first."""
    corners = vertices[list(face)]
    normal = loop_normal(corners)
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turns = np.cross(before, after) @ normal
    if (turns >= -1e-9 * np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)).all():
        return [face]
    if len(face) > MOST_BENT:
        raise _Unsplit(f"a face that is not convex has {len(face)} corners, at most {MOST_BENT} are cut into triangles")
    left, out = list(face), []
    while len(left) > 3:
        ears = [(left[k - 1], left[k], left[(k + 1) % len(left)]) for k in range(len(left))]
        roundness = [_roundness(vertices, ear, [i for i in left if i not in ear], normal) for ear in ears]
        best = int(np.argmax(roundness))
        out.append(ears[best])
        del left[best]
    return [*out, (left[0], left[1], left[2])]


def _roundness(vertices: np.ndarray, ear: tuple[int, int, int], others: list[int], normal: np.ndarray) -> float:
    """Twice the area of a triangle over the square of its longest side; negative where it is not an ear: turned over, or not empty."""
    corners = vertices[list(ear)]
    sides = np.roll(corners, -1, axis=0) - corners
    longest = float((sides * sides).sum(axis=1).max())
    area = float(np.cross(sides[0], sides[1]) @ normal)
    if area <= 1e-9 * longest:
        return -1.0
    inward = np.cross(normal, sides)
    depth = (vertices[others][:, None] - corners) * inward
    return -1.0 if (depth.sum(axis=2) >= -1e-9 * longest).all(axis=1).any() else area / longest


def _winding(block: Block, point: np.ndarray) -> float:
    """How often the shell winds about a point: 1 inside, 0 outside."""
    corners = (block.vertices - point)[triangles(block.faces)]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    below = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
    return sum(map(math.atan2, sixfold_volumes(corners), below)) / (2.0 * math.pi)


def _finished(cell: Cell, block: Block, on: float) -> Polyhedron:
    """A cell with its corners put back onto those of the block where they meet, and one face per plane."""
    apart = np.linalg.norm(cell.vertices[:, None] - block.vertices[None], axis=2)
    nearest = apart.argmin(axis=1)
    vertices = np.where((apart.min(axis=1) <= 10 * on)[:, None], block.vertices[nearest], cell.vertices)
    (part,) = merge_coplanar([Block(block.name, vertices, cell.faces, block.density)])
    return Polyhedron(part.vertices, part.faces)
