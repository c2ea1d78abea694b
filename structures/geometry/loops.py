# SPDX-License-Identifier: GPL-3.0-or-later
"""Loops of corners, put together from directed edges."""

from __future__ import annotations

from collections.abc import Sequence


def open_edges(faces: Sequence[tuple[int, ...]]) -> list[tuple[int, int]]:
    """The directed edges of some faces that have no other among them on their far side."""
    edges = {edge for face in faces for edge in zip(face, face[1:] + face[:1], strict=True)}
    return [(a, b) for a, b in edges if (b, a) not in edges]


def single_loop(edges: Sequence[tuple[int, int]], preferred: int = -1) -> tuple[int, ...] | None:
    """The corners that directed edges pass through, each once.

    Args:
        preferred: the corner to begin with, if it is one of them; else the first.

    Returns:
        None where the edges are fewer than three, meet in a corner, leave a gap, or make several loops.
    """
    after = dict(edges)
    if len(after) < len(edges) or len(after) < 3:
        return None
    loop = [preferred if preferred in after else edges[0][0]]
    while len(loop) < len(after):
        corner = after.get(loop[-1])
        if corner is None or corner == loop[0]:
            return None
        loop.append(corner)
    return tuple(loop) if after.get(loop[-1]) == loop[0] else None
