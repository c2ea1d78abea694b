# SPDX-License-Identifier: GPL-3.0-or-later
"""Shells as contact detection wants them: one face per plane, no corner in the middle of an edge.

A face that a file gives in pieces (two triangles for a rectangle) would meet its neighbour in pieces too, and its inner
edges would pass for edges of the block. Coplanar faces that share an edge are therefore merged, and vertices that then
lie on fewer than three faces, which is in the middle of an edge or of a face, are dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces
from masonry_cd.mechanics.model.polygon import loop_normal
from structures.geometry.loops import open_edges, single_loop

COPLANAR = 1e-6  # relative to the size of the block
TABLED = 1_000_000  # heights of corners over planes that are held at a time


def merge_coplanar(blocks: Sequence[Block]) -> list[Block]:
    """Merge the coplanar faces of checked convex blocks; blocks with parts, and sound ones, are returned as they are."""
    return [block if block.parts or block.radius else _with_merged_faces(block) for block in blocks]


def _with_merged_faces(block: Block) -> Block:
    vertices = block.vertices
    normals = np.array([loop_normal(vertices[list(face)]) for face in block.faces])
    first = vertices[[face[0] for face in block.faces]]
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    used = np.zeros((len(block.faces), len(vertices)), dtype=bool)
    for number, face in enumerate(block.faces):
        used[number, list(face)] = True
    group = _groups(block, normals, np.einsum("fi,fi->f", normals, first), COPLANAR * size)
    plain = (group == np.arange(len(group))).all()
    if plain and (used.sum(axis=0) >= 3).all():
        return block
    faces = merged(block.faces, group)
    degree = np.bincount([i for face in faces for i in face], minlength=len(vertices))
    kept = np.flatnonzero(degree >= 3)
    renumbered = {int(old): new for new, old in enumerate(kept)}
    faces = tuple(tuple(renumbered[i] for i in face if i in renumbered) for face in faces)
    if min(map(len, faces)) < 3:  # a sliver as thin as the tolerance
        return block
    return replace(block, vertices=vertices[kept], faces=faces)


def _groups(block: Block, normals: np.ndarray, offsets: np.ndarray, tolerance: float) -> np.ndarray:
    """For each face (F,) the first one in whose plane it lies, and that lies in its plane; itself where there is none before it."""
    loops = np.array([i for face in block.faces for i in face])
    start = np.cumsum([0, *(len(face) for face in block.faces)])
    corners, count = block.vertices[loops], len(block.faces)
    group, some = np.empty(count, dtype=np.int64), max(1, TABLED // len(loops))
    for k in range(0, count, some):
        own, mine = slice(k, min(k + some, count)), slice(start[k], start[min(k + some, count)])
        off = np.maximum.reduceat(
            np.abs(normals[own] @ corners.T - offsets[own, None]), start[:-1], axis=1
        )  # of all faces from these planes
        back = np.maximum.reduceat(np.abs(normals @ corners[mine].T - offsets[:, None]), start[own] - start[k], axis=1).T
        coplanar = (np.maximum(off, back) <= tolerance) & (normals[own] @ normals.T > 1.0 - COPLANAR)
        coplanar[np.arange(own.stop - k), np.arange(k, own.stop)] = True  # also where it is warped by more than that
        group[own] = np.argmax(coplanar, axis=1)  # of a convex block, coplanar faces always touch
    return group


def merged(faces: Faces, group: np.ndarray) -> Faces:
    """One loop for each group of faces: their directed edges without those that occur in both directions.

    Groups that make no single loop, as nearly coplanar ones may not, stay apart.
    """
    loops: list[tuple[int, ...]] = []
    for number in np.unique(group):
        members = [faces[f] for f in np.flatnonzero(group == number)]
        loop = single_loop(sorted(open_edges(members)), preferred=members[0][0])
        loops += members if loop is None else [loop]
    return tuple(loops)
