# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls of several leaves: layers of stones through the thickness, tied by through-stones, and walls with a core between two leaves.

Head joints of leaves behind each other are a quarter of a block apart. In every n-th course all leaves have one set of joints, and every
n-th stone there is a through-stone. Leaves next to a core have one set of joints throughout, and the stones at both ends reach through it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise

import numpy as np

from masonry_cd.mechanics.model.geometry import Shell
from structures.building.axes import SAME, Leg
from structures.building.footprints import BuildingPlan
from structures.building.frames import Frame
from structures.building.panels import FacetStone, Laying, lay, running
from structures.building.slivers import Stone
from structures.building.stones import across
from structures.building.widths import fat_pieces
from structures.courser.wall_plan import CORE


def stones(plan: BuildingPlan, number: int, laying: Laying, frames: Sequence[Frame]) -> Iterator[Stone]:
    """The stones of a straight leg, leaf by leaf."""
    leg, leaves = plan.legs[number], laying.leaves
    assert leaves is not None
    foot = int(np.argmin(np.abs(laying.beds - leg.base)))
    tied: list[FacetStone] = []
    for k, reach in enumerate(pairwise(leaves.bounds.tolist())):

        def shift(course: int, k: int = k) -> float:
            return running(course) + (0.0 if leaves.core or leaves.ties(course - foot) else 0.25 * k)

        pieces = lay(plan, number, 0, laying, frames, shift)
        tied = tied or [piece for piece in pieces if leaves.ties(piece.course - foot)]
        pieces = [piece for piece in pieces if not leaves.ties(piece.course - foot)] + tied
        for course, row in groupby(pieces, key=lambda piece: piece.course):
            for i, piece in enumerate(row):
                through = leaves.ties(course - foot) and i % leaves.through == 0
                through = through or (leaves.core and _is_at_end(piece, leg))
                if k and (through or (k == 1 and leaves.hollow)):
                    continue
                parts = _parts(piece, leg, (leaves.bounds[0], leaves.bounds[-1]) if through else reach)
                label = f"{i + 1}" if through else f"{i + 1}.{'abcdefgh'[k]}"
                yield Stone(number, course, parts, 0.0, label, CORE if leaves.core and k == 1 else "")


def _is_at_end(piece: FacetStone, leg: Leg) -> bool:
    """Return True if a stone reaches an end of its leg."""
    left, _, right, _ = piece.shape.bounds
    return left < SAME or right > leg.facets[0].length - SAME


def _parts(piece: FacetStone, leg: Leg, reach: tuple[float, float]) -> tuple[Shell, ...]:
    """The convex parts of a stone between two n [m]."""
    return tuple(across(polygon, leg.facets[0], reach) for polygon in fat_pieces(piece.shape))
