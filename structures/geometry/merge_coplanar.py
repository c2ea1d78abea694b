"""Shells as contact detection wants them: one face per plane, no corner in the middle of an edge.

A face that a file gives in pieces (two triangles for a rectangle) would meet its neighbour in pieces too, and its inner
edges would pass for edges of the block. Coplanar faces that share an edge are therefore merged, and vertices that then
lie on fewer than three faces, which is in the middle of an edge or of a face, are dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.model.blocks import Block
from masonry_cd.model.geometry import Faces
from masonry_cd.model.polygon import loop_normal

COPLANAR = 1e-6  # relative to the size of the block


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
    # off[i, j]: how far face j strays from the plane of face i
    heights = np.abs(normals @ vertices.T - np.einsum("fi,fi->f", normals, first)[:, None])
    off = np.where(used[None, :, :], heights[:, None, :], 0.0).max(axis=2)
    coplanar = (np.maximum(off, off.T) <= COPLANAR * size) & (normals @ normals.T > 1.0 - COPLANAR)
    group = np.argmax(coplanar, axis=1)  # of a convex block, coplanar faces always touch
    plain = (group == np.arange(len(group))).all()
    if plain and (used.sum(axis=0) >= 3).all():
        return block
    faces = _merged(block.faces, group)
    degree = np.bincount([i for face in faces for i in face], minlength=len(vertices))
    kept = np.flatnonzero(degree >= 3)
    renumbered = {int(old): new for new, old in enumerate(kept)}
    faces = tuple(tuple(renumbered[i] for i in face if i in renumbered) for face in faces)
    return replace(block, vertices=vertices[kept], faces=faces)


def _merged(faces: Faces, group: np.ndarray) -> Faces:
    """One loop for each group of faces: their directed edges without those that occur in both directions."""
    loops = []
    for number in np.unique(group):
        members = [faces[f] for f in np.flatnonzero(group == number)]
        edges = {(a, b) for face in members for a, b in zip(face, face[1:] + face[:1], strict=True)}
        after = {a: b for a, b in edges if (b, a) not in edges}
        loop = [members[0][0] if members[0][0] in after else min(after)]
        while after[loop[-1]] != loop[0]:
            loop.append(after[loop[-1]])
        loops.append(tuple(loop))
    return tuple(loops)
