# SPDX-License-Identifier: GPL-3.0-or-later
"""Agreement of the cracks of a run with a crack map drawn of the real wall, as lengths in the elevation.

With D the lines that were drawn, C those of the joints that are cracked at a frame, and B_w(X) all that lies within w of X,

    found  = |D in B_w(C)| / |D|        share of the drawn length that has a computed crack within w
    false  = |C outside B_w(D)| / |C|   share of the computed length that has no drawn one within w

w is at most the size of a stone: a crack one course away is another crack. A model in which every joint cracks finds all and is false for
most of its length: the two are read together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results

Polyline = Sequence[tuple[float, float]]
VISIBLE = 1e-3  # [m]: narrower cracks are seldom drawn
ROUND = 16  # segments of a quarter circle about the end of a line: the area within w is 0.2 % short


class CrackAgreement(NamedTuple):
    """How far computed cracks agree with drawn ones."""

    found: float  # share of the drawn length with a computed crack nearby
    false: float  # share of the computed length with no drawn crack nearby
    drawn_length: float  # [m]
    computed_length: float  # [m]


def joint_lines(results: Results, along: Sequence[float]) -> np.ndarray:
    """The joints of a run as lines of the elevation: each between the corners of its interface that lie farthest apart there.

    Args:
        results: of the run.
        along: (3,) the level direction of the elevation; its other axis is z.

    Returns:
        Lines (J, 2, 2) [m], by joint and end the places along that direction and in height.
    """
    joints, axis = results.joints, np.asarray(along, dtype=float)
    flat = np.stack([joints.polygon @ (axis / np.linalg.norm(axis)), joints.polygon[:, 2]], axis=1)
    lines = np.empty((joints.count, 2, 2))
    for j, (first, last) in enumerate(zip(joints.polygon_start[:-1], joints.polygon_start[1:], strict=True)):
        corners = flat[first:last]
        apart = np.square(corners[:, None] - corners[None]).sum(axis=2)
        lines[j] = corners[list(np.unravel_index(np.argmax(apart), apart.shape))]
    return lines


def cracked(results: Results, width: float = VISIBLE, frame: int = -1) -> np.ndarray:
    """The joints (J,) that are open by a width [m] or more at a frame, or have slid by it."""
    return np.maximum(results.joints_at("opening", frame), results.joints_at("sliding", frame)) >= width


def agreement(computed: np.ndarray, drawn: Sequence[Polyline], within: float) -> CrackAgreement:
    """Compare computed cracks with drawn ones.

    Args:
        computed: lines (C, 2, 2) of the joints that cracked [m].
        drawn: polylines in the same elevation, each of two points or more [m].
        within: the largest distance of one crack from the other [m], at most the size of a stone.

    Raises:
        InputError: nothing was drawn, or ``within`` is not above zero.
    """
    import shapely

    if not within > 0.0:
        raise InputError("within", f"must be above 0 m, got {within!r}")
    if not drawn or any(len(line) < 2 for line in drawn):
        raise InputError("drawn", "at least one crack is needed, each with two points or more")
    map_lines = shapely.union_all([shapely.LineString(line) for line in drawn])
    model_lines = shapely.union_all([shapely.LineString(line) for line in computed])
    nearby = map_lines.intersection(model_lines.buffer(within, quad_segs=ROUND)).length
    outside = model_lines.difference(map_lines.buffer(within, quad_segs=ROUND)).length
    computed_length = model_lines.length
    return CrackAgreement(
        nearby / map_lines.length, outside / computed_length if computed_length else 0.0, map_lines.length, computed_length
    )
