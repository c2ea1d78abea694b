# SPDX-License-Identifier: GPL-3.0-or-later
"""The shell of convex parts that lie on each other face on face, but need not share whole faces.

What of a face lies on another part is taken away, and what is left falls into convex pieces. Corners that lie within an edge of another
face are put into it, so that each edge has one face on either side. Where the parts meet in an edge alone, four faces meet there: the edge
gets a corner in its middle for each two of them between which the parts lie, so that each belongs to two faces.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from masonry_cd.mechanics.model.geometry import Faces, Polyhedron
from masonry_cd.mechanics.model.polygon import loop_normal, loop_planes
from structures.geometry.compound_block import GRID
from structures.geometry.near_points import numbered

ON = 1e-6  # planes closer than this are one [m]
OPPOSITE = -1.0 + 1e-9  # cosine of the angle between the normals of two faces that lie on each other
FINE = 1e-9  # corners closer than this are one where faces are compared: sides that rounding parts would puzzle it otherwise [m]
LEAST_AREA = 1e-9  # what of a face is smaller is rounding [m2]

Edge = tuple[int, int]


def outer_shell(parts: Sequence[Polyhedron]) -> Polyhedron:
    """The outer faces of convex parts."""
    loops = [[part.vertices[list(face)] for face in part.faces] for part in parts]
    planes = [loop_planes(own) for own in loops]
    outer = list[np.ndarray]()
    for k, own in enumerate(loops):
        for loop, normal, offset in zip(own, *planes[k], strict=True):
            hidden = [loops[j][i] for j in range(len(parts)) if j != k for i in _facing(planes[j], normal, offset)]
            outer += list(_left(loop, normal, hidden)) if hidden else [loop]
    points, numbers = numbered(np.concatenate(outer), GRID)
    ends = np.cumsum([len(loop) for loop in outer])[:-1]
    faces = [tuple(dict.fromkeys(own.tolist())) for own in np.split(numbers, ends)]
    faces = [_without_spurs(_with_corners_between(points, face)) for face in faces if len(face) > 2]
    return _parted(points, [face for face in faces if face])


def is_closed(faces: Faces) -> bool:
    """Return True if each edge has one face on either side."""
    edges = [edge for face in faces for edge in pairwise([*face, face[0]])]
    return len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)


def _facing(planes: tuple[np.ndarray, np.ndarray], normal: np.ndarray, offset: float) -> list[int]:
    """Numbers of the planes that are one with another and look the other way."""
    normals, offsets = planes
    return np.flatnonzero((normals @ normal < OPPOSITE) & (np.abs(offsets + offset) < ON)).tolist()


def _left(loop: np.ndarray, normal: np.ndarray, hidden: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """Convex pieces of what other faces in its plane leave of a face; itself where they lie next to it."""
    import shapely

    from structures.geometry.polygons import convex_pieces, polygons

    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    plane = np.stack([first, np.cross(normal, first)], axis=1)
    whole = shapely.Polygon((loop - loop[0]) @ plane)
    others = shapely.union_all([shapely.Polygon((other - loop[0]) @ plane) for other in hidden], grid_size=FINE)
    left = shapely.difference(whole, others, grid_size=FINE)
    if left.area > whole.area - LEAST_AREA:
        yield loop
        return
    for polygon in polygons(left):
        yield from (loop[0] + piece @ plane.T for piece in convex_pieces(polygon))


def _with_corners_between(points: np.ndarray, face: tuple[int, ...]) -> tuple[int, ...]:
    """A face with the points that lie within its edges as corners."""
    found = list[int]()
    for a, b in pairwise([*face, face[0]]):
        along = points[b] - points[a]
        length = math.sqrt(along @ along)
        share = (points - points[a]) @ along / length**2
        off = np.abs(points - points[a] - share[:, None] * along).max(axis=1)
        within = np.flatnonzero((off < GRID) & (share * length > GRID) & (share * length < length - GRID))
        found += [a, *within[np.argsort(share[within])].tolist()]
    return tuple(found)


def _without_spurs(face: tuple[int, ...]) -> tuple[int, ...]:
    """A face without edges that it runs along to and fro, as a sliver thinner than the grid does; nothing where no other is left."""
    loop, here = list(face), 0
    while len(loop) > 2 and here < len(loop):
        if loop[here - 1] == loop[(here + 1) % len(loop)]:
            for k in sorted((here, (here + 1) % len(loop)), reverse=True):
                del loop[k]
            here = 0
        else:
            here += 1
    return tuple(loop) if len(loop) > 2 else ()


def _parted(points: np.ndarray, faces: Sequence[tuple[int, ...]]) -> Polyhedron:
    """Faces with edges in which more than two of them meet parted by corners in their middles."""
    meeting: dict[Edge, list[tuple[int, bool]]] = {}  # by edge, numbers of faces and whether they run along it
    for f, face in enumerate(faces):
        for a, b in pairwise([*face, face[0]]):
            meeting.setdefault((min(a, b), max(a, b)), []).append((f, a < b))
    middles: dict[tuple[int, Edge], int] = {}
    added = list[np.ndarray]()
    for edge, around in meeting.items():
        if len(around) > 2:
            for pair in _pairs(points, faces, edge, around):
                middles |= {(f, edge): len(points) + len(added) for f in pair}
                added.append(0.5 * (points[edge[0]] + points[edge[1]]))
    made: list[tuple[int, ...]] = []
    for f, face in enumerate(faces):
        new = list[int]()
        for a, b in pairwise([*face, face[0]]):
            middle = middles.get((f, (min(a, b), max(a, b))))
            new += [a] if middle is None else [a, middle]
        made.append(tuple(new))
    return _used(np.concatenate([points, np.reshape(added, (-1, 3))]), made)


def _pairs(points: np.ndarray, faces: Sequence[tuple[int, ...]], edge: Edge, around: Sequence[tuple[int, bool]]) -> list[tuple[int, int]]:
    """Faces about an edge two by two, the parts between them: turned about it, one that runs along it follows on its fellow."""
    along = points[edge[1]] - points[edge[0]]
    along /= math.sqrt(along @ along)
    side = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    angles = []
    for f, forward in around:
        into = np.cross(loop_normal(points[list(faces[f])]), along) * (1.0 if forward else -1.0)
        angles.append(math.atan2(into @ np.cross(along, side), into @ side))
    turned = [around[k] for k in np.argsort(angles)]
    return [(turned[k - 1][0], f) for k, (f, forward) in enumerate(turned) if forward]


def _used(points: np.ndarray, faces: Faces | list[tuple[int, ...]]) -> Polyhedron:
    used = sorted({i for face in faces for i in face})
    number = {old: new for new, old in enumerate(used)}
    return Polyhedron(points[used], tuple(tuple(number[i] for i in face) for face in faces))
