# SPDX-License-Identifier: GPL-3.0-or-later
"""Shells of scans whose edges have more than two faces, made manifold where it takes no guess.

Faces that hang together by edges of two faces make a patch. A patch is left out where three faces meet, or one, if fewer such edges are
left without it: a fin that hangs on a shell, or a wall inside it; of equals the one without which the shell is largest. Where four faces or
more meet, as where a surface touches itself along an edge, those are neighbours that enclose the stone between them
(:mod:`structures.files.shells`), and each side gets corners of its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from masonry_cd.mechanics.model.geometry import sixfold_volumes, triangles
from structures.files.shells import neighbours

Loops = list[list[int]]
MOST = 200  # patches of a shell that are looked at: one with more is not a stone with a fin


def without_fins(vertices: np.ndarray, loops: Loops) -> Loops:
    """Loops without patches that hang on a shell, or stand within it."""
    while any(len(own) > 2 for own in _edges(loops).values()):
        bad, patches = _odd(loops), _patches(loops)
        if not bad or not 1 < len(patches) <= MOST:
            break
        rest = [[loop for k, loop in enumerate(loops) if k not in patch] for patch in patches]
        best = min(rest, key=lambda left: (_odd(left), -_extent(vertices, left)))
        if _odd(best) >= bad or not best:
            break
        loops = best
    return loops


def outwards(vertices: np.ndarray, loops: Loops) -> Loops:
    """Loops in which patches that are closed by themselves, and meet others along edges, run counter-clockwise seen from outside."""
    edges = _edges(loops)
    if not any(len(own) > 2 for own in edges.values()):
        return loops
    out = list(loops)
    for patch in _patches(loops):
        own = [loops[face] for face in sorted(patch)]
        if any(len(faces) % 2 for faces in _edges(own).values()):
            continue
        corners = vertices[triangles(tuple(map(tuple, own)))]
        if float(sixfold_volumes(corners - vertices.mean(axis=0)).sum()) < 0.0:
            for face in patch:
                out[face] = loops[face][::-1]
    return out


def apart_at_edges(vertices: np.ndarray, loops: Loops) -> tuple[np.ndarray, Loops]:
    """Corners (V, 3) and loops, in which no edge has more than two faces where they could be paired; loops run alike already."""
    if not any(len(own) > 2 for own in _edges(loops).values()):
        return vertices, loops
    leader = {(face, corner): (face, corner) for face, loop in enumerate(loops) for corner in loop}

    def first(wedge: tuple[int, int]) -> tuple[int, int]:
        while leader[wedge] != wedge:
            wedge = leader[wedge]
        return wedge

    for a, b, one, other in neighbours(vertices, loops).tolist():
        for corner in (a, b):
            leader[first((one, corner))] = first((other, corner))
    number = {wedge: k for k, wedge in enumerate(dict.fromkeys(map(first, leader)))}
    used = np.array([corner for _, corner in number])
    return vertices[used], [[number[first((face, corner))] for corner in loop] for face, loop in enumerate(loops)]


def _edges(loops: Sequence[Sequence[int]]) -> dict[frozenset[int], list[int]]:
    """The faces at each edge."""
    found: dict[frozenset[int], list[int]] = defaultdict(list)
    for face, loop in enumerate(loops):
        for a, b in zip(loop, (*loop[1:], loop[0]), strict=True):
            found[frozenset((a, b))].append(face)
    return found


def _odd(loops: Loops) -> int:
    """At how many edges the number of faces is odd."""
    return sum(len(own) % 2 for own in _edges(loops).values())


def _patches(loops: Loops) -> list[set[int]]:
    """Faces that hang together by edges of two faces."""
    adjacent: dict[int, list[int]] = defaultdict(list)
    for own in _edges(loops).values():
        if len(own) == 2:
            adjacent[own[0]].append(own[1])
            adjacent[own[1]].append(own[0])
    found, seen = [], set[int]()
    for start in range(len(loops)):
        patch, queue = set[int](), [] if start in seen else [start]
        while queue:
            face = queue.pop()
            if face not in patch:
                patch.add(face)
                queue += adjacent[face]
        seen |= patch
        found += [patch] if patch else []
    return found


def _extent(vertices: np.ndarray, loops: Loops) -> float:
    """Volume of the box around the corners that are used."""
    corners = vertices[sorted({corner for loop in loops for corner in loop})]
    return float(np.prod(np.ptp(corners, axis=0))) if len(corners) else 0.0
