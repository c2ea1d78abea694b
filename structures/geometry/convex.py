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
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.model.blocks import Block, refuse_spheres
from masonry_cd.model.geometry import Faces, Polyhedron, sixfold_volumes, triangles
from masonry_cd.model.polygon import clip, loop_normal, loop_planes
from structures.geometry.checks import FLATNESS
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.prism import box

ON_PLANE = 1e-6  # relative to the size of the block: corners closer to a plane than this lie on it
MOST_PARTS = 500  # a block that needs more is no stone but a scan


@dataclass(frozen=True, eq=False)
class Cell:
    """A convex polyhedron, and the polygons (n, 3) of the shell inside it."""

    vertices: np.ndarray
    faces: Faces
    pieces: list[np.ndarray]


def split(block: Block) -> Block:
    """Give a block without parts the convex parts that it needs, and convex faces; a convex one is returned as it is.

    Args:
        block: closed, outward, with planar faces (:func:`structures.geometry.checks.check_shells`); its faces need not be convex.

    Raises:
        RuntimeError: more than MOST_PARTS parts; names the block.
    """
    if block.parts or is_convex(block):
        return block
    size = _size(block)
    inside = [part for part in _cells(block, ON_PLANE * size) if _winding(block, part.vertices.mean(axis=0)) > 0.5]
    parts = tuple(_finished(cell, block, ON_PLANE * size) for cell in inside)
    faces = tuple(loop for face in block.faces for loop in _convex_loops(block.vertices, face))
    return replace(block, faces=faces, parts=parts)


def halves(block: Block, normal: np.ndarray, offset: float) -> tuple[Block | None, Block | None]:
    """A convex block cut by the plane ``normal . x = offset`` [m]: what lies below it and above it, None where nothing does."""
    on = ON_PLANE * _size(block)
    cell = Cell(block.vertices, block.faces, [])
    sides = _below(cell, normal, offset, on), _below(cell, -normal, -offset, on)
    if sides[0] is None or sides[1] is None:
        return (block, None) if sides[1] is None else (None, block)
    refuse_spheres([block], "structure: cutting by a plane")
    below, above = (_finished(side, block, on) for side in sides if side is not None)
    return replace(block, vertices=below.vertices, faces=below.faces), replace(block, vertices=above.vertices, faces=above.faces)


def is_convex(block: Block) -> bool:
    """Whether no vertex lies outside the plane of any face, to the tolerance of :mod:`structures.geometry.checks`."""
    normals, offsets = loop_planes([block.vertices[list(face)] for face in block.faces])
    return bool((block.vertices @ normals.T - offsets).max() <= FLATNESS * _size(block))


def _size(block: Block) -> float:
    return float(np.linalg.norm(np.ptp(block.vertices, axis=0)))


def _cells(block: Block, on: float) -> list[Cell]:
    """Cut the space around a block by the planes of its faces until no cell holds a piece of the shell."""
    low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
    room = 0.1 * np.linalg.norm(high - low)
    vertices, faces = box(tuple(low - room), tuple(high + room))
    todo, done = [Cell(vertices, faces, [block.vertices[list(face)] for face in block.faces])], []
    while todo:
        cell = todo.pop()
        if not cell.pieces:
            done.append(cell)
            if len(done) > MOST_PARTS + len(block.faces):
                raise RuntimeError(f'block "{block.name}": not convex, and cannot be split into {MOST_PARTS} convex parts or fewer')
            continue
        normal, offset = _best_plane(cell.pieces, on)
        todo += [side for side in (_below(cell, normal, offset, on), _below(cell, -normal, -offset, on)) if side is not None]
    return done


def _best_plane(pieces: list[np.ndarray], on: float) -> tuple[np.ndarray, float]:
    """The plane of the piece that splits the fewest others; of equals, the one that leaves the halves most alike."""
    normals, offsets = loop_planes(pieces)
    start = np.cumsum([0, *(len(piece) for piece in pieces[:-1])])
    heights = np.einsum("vi,pi->vp", np.concatenate(pieces), normals) - offsets  # (points, planes)
    above = np.maximum.reduceat(heights, start) > on
    below = np.minimum.reduceat(heights, start) < -on
    splits, even = (above & below).sum(axis=0), np.abs(above.sum(axis=0) - below.sum(axis=0))
    best = int(np.lexsort((even, splits))[0])
    return normals[best], float(offsets[best])


def _below(cell: Cell, normal: np.ndarray, offset: float, on: float) -> Cell | None:
    """The part of a cell below a plane; None where nothing of it is."""
    heights = _heights(cell.vertices, normal, offset)
    if heights.min() >= -on:
        return None
    pieces = [cut for piece in cell.pieces if (cut := _polygon_below(piece, _heights(piece, normal, offset), on)) is not None]
    if heights.max() <= on:
        return Cell(cell.vertices, cell.faces, pieces)
    loops = [cut for face in cell.faces if (cut := _polygon_below(cell.vertices[list(face)], heights[list(face)], on)) is not None]
    points, index = _numbered(np.concatenate(loops), on)
    ends = np.cumsum([len(loop) for loop in loops])
    faces = [tuple(dict.fromkeys(map(int, part))) for part in np.split(index, ends[:-1])]
    edges = {edge for face in faces for edge in zip(face, face[1:] + face[:1], strict=True)}
    after = {b: a for a, b in edges if (b, a) not in edges}  # the rim, run the other way round, is the new face
    rim = [next(iter(after))]
    while after[rim[-1]] != rim[0]:
        rim.append(after[rim[-1]])
    return Cell(points, (*faces, tuple(rim)), pieces)


def _heights(points: np.ndarray, normal: np.ndarray, offset: float) -> np.ndarray:
    """Distances (n,) of points (n, 3) from a plane [m]; BLAS would round otherwise on another processor."""
    return np.asarray(np.sum(points * normal, axis=1) - offset)


def _polygon_below(polygon: np.ndarray, heights: np.ndarray, on: float) -> np.ndarray | None:
    """What of a polygon (n, 3) lies below a plane; None where nothing does, or it lies in the plane."""
    return None if heights.min() >= -on else clip(polygon, -heights, on)


def _numbered(points: np.ndarray, on: float) -> tuple[np.ndarray, np.ndarray]:
    """Points closer than a tolerance once, and the number of each."""
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= on
    used, index = np.unique(np.argmax(near, axis=1), return_inverse=True)
    return points[used], index


def _convex_loops(vertices: np.ndarray, face: tuple[int, ...]) -> list[tuple[int, ...]]:
    """A face as it is where its loop is convex, else its triangles, by cutting off ear after ear, the roundest first."""
    corners = vertices[list(face)]
    normal = loop_normal(corners)
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turns = np.cross(before, after) @ normal
    if (turns >= -1e-9 * np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)).all():
        return [face]
    left, out = list(face), []
    while len(left) > 3:
        ears = [(left[k - 1], left[k], left[(k + 1) % len(left)]) for k in range(len(left))]
        roundness = [_roundness(vertices, ear, [i for i in left if i not in ear], normal) for ear in ears]
        best = int(np.argmax(roundness))
        out.append(ears[best])
        del left[best]
    return [*out, (left[0], left[1], left[2])]


def _roundness(vertices: np.ndarray, ear: tuple[int, int, int], others: list[int], normal: np.ndarray) -> float:
    """Twice the area of a triangle over the square of its longest side; negative where it is no ear: turned over, or not empty."""
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
