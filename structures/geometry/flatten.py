# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that are nearly flat, made flat: blocks of a scan, of millimetres or of single precision.

Faces whose corners all lie within a tolerance of one plane share it, wherever they are on the block. Then the corners move, together and
by the least sum of squares, until each lies in the planes of all its faces: minimise sum |d_i|^2 under n_p . (x_i + d_i) = c_p for every
corner i on plane p, where n_p and c_p are free (Newton's method on the conditions; each step is one sparse system). Edges stay shared,
since it is corners that move. Where a corner has three planes this is their intersection; where it has more, all give way.

A block that is convex within the tolerance, and whose faces contradict each other, becomes the hull of its corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.geometry import Polyhedra, Polyhedron, mass_properties
from structures.geometry.checks import FLATNESS, WARPED, Unsound, check, check_shells, warp
from structures.geometry.convex import ON_PLANE, excess, size_of, split
from structures.geometry.merge_coplanar import merged

SHARE = 1e-3  # of the size of a block, within which its faces are made flat where the scene does not say
LIMIT = 4.0  # corners move by no more than this many tolerances: at sharp edges more than the planes do
REFITS = 8  # of a plane to the faces that lie in it, until they are the same ones
STEPS = 12  # of Newton's method; it takes three where no corner has more than three planes
ROUNDING = 1e-9  # relative to the size of a block: faces of one that is not convex count as flat within this
FLAT = 1e-12  # what is left of the conditions, relative to the size of the block
SLACK = 1e-11  # of conditions that repeat each other, which would make the system singular
MOST = 20_000  # faces of a block, beyond which it is not a stone


def flattened(blocks: Sequence[Block], flatness: float | None) -> tuple[list[Block], float, int]:
    """Make the faces of blocks flat that are nearly so; all others are returned as they are.

    Args:
        blocks: with closed shells and no parts where they are uneven; spheres stay.
        flatness: how far a corner may be off the plane of its face [m]; ``SHARE`` of the size of each block when None.

    Returns:
        the blocks, how far a corner was moved at most [m], and how many blocks were changed.
    """
    out, most, changed = [], 0.0, 0
    for block in blocks:
        within = SHARE * size_of(block) if flatness is None else flatness
        needed = 0.0 if block.radius or block.parts else _tolerance(block, within, flatness or 0.0)
        new, far = _flat(block, needed) if needed else (block, 0.0)
        out.append(new)
        most, changed = max(most, far), changed + (new is not block)
    return out, most, changed


def _tolerance(block: Block, within: float, asked: float) -> float:
    """Within what the faces of a block are to be made flat [m]: zero where they need not, or are farther off.

    A ridge that is higher than those of noise stays, unless the scene asks for as much. One that is sound, of single precision for example,
    is only brought to what counts as flat: a slight ridge of its own stays.
    """
    if within <= 0.0 or not 4 <= len(block.faces) <= MOST:
        return 0.0
    size, off = size_of(block), _off_their_planes(block)
    if off > FLATNESS * size:
        return within if off <= LIMIT * within else 0.0
    uneven = ROUNDING * size < warp(block) < max(WARPED * size, LIMIT * asked)
    if excess(block) <= FLATNESS * size:
        return min(within, FLATNESS * size) if uneven else 0.0
    return within if uneven or not _stands(block) else 0.0


def _off_their_planes(block: Block) -> float:
    """How far a corner is off the plane of its face at most, through the first corner as the check has it [m]."""
    flat = Polyhedra.of([Polyhedron(block.vertices, block.faces)])
    points, counts = flat.vertices[flat.loops], np.diff(flat.loop_start)
    first = np.repeat(points[flat.loop_start[:-1]], counts, axis=0)
    return float(np.abs(np.einsum("li,li->l", points - first, np.repeat(flat.normals, counts, axis=0))).max())


def _flat(block: Block, within: float) -> tuple[Block, float]:
    """A block with flat faces or, where they contradict each other, the hull of its corners; as it is where neither is near enough."""
    moved = _moved(block, within)
    if moved is not None and _stands(moved[0]):
        return moved
    found = _hull(block)
    if found is None:
        return block, 0.0
    hull, far = found
    grown = mass_properties(hull.vertices, hull.faces).volume - mass_properties(block.vertices, block.faces).volume
    if far > within or abs(grown) > within * size_of(block) ** 2:
        return block, 0.0
    moved = _moved(hull, within)
    return moved if moved is not None and _stands(moved[0]) else (hull, far)


def _stands(block: Block) -> bool:
    """Return True if a block passes the checks, split into convex parts if need be."""
    try:
        check_shells([block])
        check([split(block)])
    except Unsound:
        return False
    return True


def _moved(block: Block, within: float) -> tuple[Block, float] | None:
    """A block whose corners have moved into common planes, and how far at most [m]; None where they would have to move too far."""
    size, middle = size_of(block), block.vertices.mean(axis=0)
    points = (block.vertices - middle) / size
    planes = _planes(points, block.faces, within / size)
    corner, plane = _incidences(block.faces, planes)
    found = points
    normal, offset = _fitted(points, corner, plane, planes.max() + 1)
    for _ in range(STEPS):
        left = np.einsum("ki,ki->k", found[corner], normal[plane]) - offset[plane]
        if np.abs(left).max() <= FLAT:
            break
        found, normal, offset = _step(found, normal, offset, corner, plane, left)
        if not np.isfinite(found).all() or np.abs(found - points).max() > 1.0:
            return None
    far = size * float(np.linalg.norm(found - points, axis=1).max())
    left = np.einsum("ki,ki->k", found[corner], normal[plane]) - offset[plane]
    if far <= ROUNDING * size:  # its faces are flat, and lie apart by more than the tolerance
        return block, 0.0
    if far > LIMIT * within or np.abs(left).max() > ON_PLANE:
        return None
    return replace(block, vertices=middle + size * found, faces=merged(block.faces, _connected(block.faces, planes))), far


def _planes(points: np.ndarray, faces: Sequence[Sequence[int]], within: float) -> np.ndarray:
    """The plane of each face (F,), counted from 0: the largest face takes all that lie within a tolerance of it, then the next."""
    flat = Polyhedra.of([Polyhedron(points, tuple(map(tuple, faces)))])
    corners, start = points[flat.loops], flat.loop_start[:-1]
    area = _areas(flat)
    plane, count = np.full(len(faces), -1), 0
    for seed in np.argsort(-area, kind="stable"):
        if plane[seed] >= 0:
            continue
        members = np.zeros(len(faces), dtype=bool)
        members[seed] = True
        for _ in range(REFITS):
            normal, offset = _plane_through(corners[members[flat.face_of_entry()]])
            near = np.maximum.reduceat(np.abs(corners @ normal - offset), start) <= within
            near &= plane < 0
            near[seed] = True
            if (near == members).all():
                break
            members = near
        plane[members] = count
        count += 1
    return plane


def _areas(flat: Polyhedra) -> np.ndarray:
    """Areas of faces (F,), up to a factor."""
    points = flat.vertices[flat.loops]
    first = np.repeat(points[flat.loop_start[:-1]], np.diff(flat.loop_start), axis=0)
    after = np.concatenate([np.arange(a + 1, b + 1) for a, b in zip(flat.loop_start[:-1], flat.loop_start[1:], strict=True)])
    after[flat.loop_start[1:] - 1] = flat.loop_start[:-1]
    crossed = np.cross(points - first, points[after] - first)
    return np.asarray(np.linalg.norm(np.add.reduceat(crossed, flat.loop_start[:-1]), axis=1))


def _plane_through(points: np.ndarray) -> tuple[np.ndarray, float]:
    """The plane of least squares through points (n, 3): its unit normal (3,) and offset."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    return normal, float(normal @ middle)


def _connected(faces: Sequence[Sequence[int]], planes: np.ndarray) -> np.ndarray:
    """A number (F,) that faces share which lie in one plane and meet along edges."""
    owner = {edge: f for f, face in enumerate(faces) for edge in zip(face, (*face[1:], face[0]), strict=True)}
    meeting = [(f, owner[b, a]) for (a, b), f in owner.items() if (b, a) in owner and planes[f] == planes[owner[b, a]]]
    first, second = np.array(meeting, dtype=np.int64).reshape(-1, 2).T
    return connected_components(first, second, len(faces))


def _incidences(faces: Sequence[Sequence[int]], planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each pair of a corner and a plane in which a face of it lies, once: two arrays (K,)."""
    pairs = np.unique([(plane, corner) for plane, face in zip(planes.tolist(), faces, strict=True) for corner in face], axis=0)
    return pairs[:, 1], pairs[:, 0]


def _fitted(points: np.ndarray, corner: np.ndarray, plane: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The planes of least squares through their corners: normals (P, 3) and offsets (P,)."""
    normal, offset = np.zeros((count, 3)), np.zeros(count)
    for p, own in enumerate(np.split(corner, np.searchsorted(plane, np.arange(1, count)))):
        normal[p], offset[p] = _plane_through(points[own])
    return normal, offset


def _step(
    points: np.ndarray, normal: np.ndarray, offset: np.ndarray, corner: np.ndarray, plane: np.ndarray, left: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A step of Newton's method: the least motion of the corners that meets the conditions, linearised in corners and planes.

    The planes turn about two axes across their normals and shift, 3 unknowns each, as a corner has.
    """
    k, v, p = len(corner), len(points), len(normal)
    across = np.linalg.svd(normal[:, None, :])[2][:, 1:]  # (P, 2, 3)
    turned = np.einsum("kai,ki->ka", across[plane], points[corner])
    row = np.repeat(np.arange(k), 3)
    of_corners = sparse.csr_matrix((normal[plane].ravel(), (row, (3 * corner[:, None] + np.arange(3)).ravel())), (k, 3 * v))
    values = np.column_stack([turned, -np.ones(k)])
    of_planes = sparse.csr_matrix((values.ravel(), (row, (3 * plane[:, None] + np.arange(3)).ravel())), (k, 3 * p))
    system = sparse.bmat(
        [
            [sparse.identity(3 * v), None, of_corners.T],
            [None, SLACK * sparse.identity(3 * p), of_planes.T],
            [of_corners, of_planes, -SLACK * sparse.identity(k)],
        ],
        format="csc",
    )
    solved = splu(system).solve(np.concatenate([np.zeros(3 * (v + p)), -left]))
    turns = solved[3 * v : 3 * (v + p)].reshape(p, 3)
    new = normal + np.einsum("pa,pai->pi", turns[:, :2], across)
    length = np.linalg.norm(new, axis=1)
    return points + solved[: 3 * v].reshape(v, 3), new / length[:, None], (offset + turns[:, 2]) / length


def _hull(block: Block) -> tuple[Block, float] | None:
    """The convex hull of a block's corners, in triangles that run counter-clockwise seen from outside; how deep a corner lies in it [m].

    None where they lie in one plane.
    """
    from scipy.spatial import ConvexHull, QhullError  # take as long to load as a small run

    middle = block.vertices.mean(axis=0)
    try:
        found = ConvexHull(block.vertices - middle)
    except QhullError:
        return None
    outward, offset = found.equations[:, :3], found.equations[:, 3]
    deepest = max(0.0, float(np.min(-(block.vertices - middle) @ outward.T - offset, axis=1).max()))
    number = {int(old): new for new, old in enumerate(found.vertices)}
    faces = []
    for triangle, normal in zip(found.simplices, outward, strict=True):
        a, b, c = block.vertices[triangle]
        loop = tuple(number[int(i)] for i in triangle)
        faces.append(loop if np.cross(b - a, c - a) @ normal > 0 else loop[::-1])
    return replace(block, vertices=block.vertices[found.vertices], faces=tuple(faces)), deepest
