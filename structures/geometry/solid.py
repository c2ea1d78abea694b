# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutting a solid into blocks with the OpenCASCADE kernel of gmsh.

A wall, an arcade or an aqueduct is a plane figure of one thickness. Its outline becomes a plane surface, its joints become
lines, and the general fuse of both (``occ.fragment``) splits the surface into the faces of the blocks. The kernel works to
a tolerance of 1e-7 m; the corners it returns are therefore put back onto the points that went in, of which every junction
of joints is one, so that neighbours share their coordinates to the bit and a joint at rest has no gap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.model.polygon import polygon_area

Segment = tuple[tuple[float, float], tuple[float, float]]  # the two ends x, z of a joint [m]

SAME = 1e-9  # coordinates closer than this are one [m]
KERNEL = 1e-6  # how far the kernel may return a corner from where it was put [m]


def cut_solid(outline: np.ndarray, joints: Sequence[Segment]) -> list[np.ndarray]:
    """Cut a plane figure by its joints.

    Args:
        outline: (n, 2) corners x, z of a simple polygon [m].
        joints: straight segments inside it; wherever two of them meet or one meets the outline, an end of one lies.

    Returns:
        The pieces, each counter-clockwise (m, 2) without corners in the middle of a side, by height and then by x.

    Raises:
        RuntimeError: the pieces do not fill the outline, or have corners that are no ends of joints.
    """
    ring = [(outline[i], outline[(i + 1) % len(outline)]) for i in range(len(outline))]
    ends = _unified(np.array([*ring, *joints], dtype=float).reshape(-1, 2))
    points, index = np.unique(ends, axis=0, return_inverse=True)
    lines = index.reshape(-1, 2)
    inner = np.unique(np.sort(lines[len(ring) :], axis=1), axis=0)
    inner = inner[inner[:, 0] != inner[:, 1]]
    corners, loops = _fragment(points, lines[: len(ring)], inner)
    distance, nearest = cKDTree(points).query(corners)
    if distance.max() > KERNEL:
        raise RuntimeError(f"a block has a corner {distance.max():.2g} m away from any end of a joint")
    pieces = [_simplified(points[nearest[loop]]) for loop in loops]
    total, wanted = sum(polygon_area(piece) for piece in pieces), abs(polygon_area(outline))
    if abs(total - wanted) > 1e-9 * wanted:
        raise RuntimeError(f"the blocks fill {total:.12g} m2 of {wanted:.12g} m2")
    return sorted(pieces, key=lambda piece: (piece[0, 1], piece[0, 0]))


def area(outline: np.ndarray, holes: Sequence[np.ndarray] = ()) -> float:
    """Area of a plane figure as the kernel measures it [m2], for checks of what was cut from it."""
    with gmsh_session() as gmsh:
        loops = []
        for polygon in (outline, *holes):
            tags = [gmsh.model.occ.addPoint(x, z, 0.0) for x, z in polygon]
            sides = [gmsh.model.occ.addLine(a, b) for a, b in zip(tags, tags[1:] + tags[:1], strict=True)]
            loops.append(gmsh.model.occ.addCurveLoop(sides))
        return float(gmsh.model.occ.getMass(2, gmsh.model.occ.addPlaneSurface(loops)))


def _unified(ends: np.ndarray) -> np.ndarray:
    """Give coordinates that agree up to rounding one value, so that what is level stays level."""
    out = np.empty_like(ends)
    for axis in range(2):
        values, index = np.unique(ends[:, axis], return_inverse=True)
        new = np.concatenate([[True], np.diff(values) > SAME])
        out[:, axis] = values[new][np.cumsum(new) - 1][index.ravel()]
    return out


def _fragment(points: np.ndarray, ring: np.ndarray, inner: np.ndarray) -> tuple[np.ndarray, list[list[int]]]:
    """Split the surface within the ring by the inner lines: corners (n, 2) and a loop of corners for each piece."""
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        tags = [occ.addPoint(x, z, 0.0) for x, z in points]
        boundary = [occ.addLine(tags[a], tags[b]) for a, b in ring]
        surface = occ.addPlaneSurface([occ.addCurveLoop(boundary)])
        lines = [(1, occ.addLine(tags[a], tags[b])) for a, b in inner]
        if lines:
            occ.fragment([(2, surface)], lines)
        occ.synchronize()
        number: dict[int, int] = {}
        corners: list[np.ndarray] = []
        for _, tag in gmsh.model.getEntities(0):
            number[tag] = len(corners)
            corners.append(gmsh.model.getValue(0, tag, [])[:2])
        ends = {tag: [number[p] for _, p in gmsh.model.getBoundary([(1, tag)], oriented=False)] for _, tag in gmsh.model.getEntities(1)}
        sides = [[ends[abs(c)] for _, c in gmsh.model.getBoundary([face], oriented=True)] for face in gmsh.model.getEntities(2)]
    return np.array(corners), [_chained(side) for side in sides]


def _chained(sides: Sequence[Sequence[int]]) -> list[int]:
    """Order the sides of one piece, pairs of corners, into a loop of corners."""
    neighbours: dict[int, list[int]] = {}
    for a, b in sides:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    if any(len(met) != 2 for met in neighbours.values()):
        raise RuntimeError("the joints do not cut the figure into simple pieces")
    loop = [sides[0][0], sides[0][1]]
    while True:
        first, second = neighbours[loop[-1]]
        following = second if first == loop[-2] else first
        if following == loop[0]:
            return loop
        loop.append(following)


def _simplified(polygon: np.ndarray) -> np.ndarray:
    """Counter-clockwise, from the lowest and then leftmost corner, without corners in the middle of a side."""
    before, after = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    lengths = np.hypot(*before.T) * np.hypot(*after.T)
    kept = polygon[np.abs(turn) > SAME * lengths]
    if polygon_area(kept) < 0:
        kept = kept[::-1]
    start = np.lexsort((kept[:, 0], kept[:, 1]))[0]
    return np.roll(kept, -start, axis=0)
