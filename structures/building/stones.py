# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones: a polygon of the face of a wall, drawn out over its footprint, as convex solids of the world.

Where a footprint has the whole thickness, a stone is a prism across the wall. At its ends, which other walls and mitres cut at any angle,
it is an upright prism over its plan; under a sloping top there it is the prism across the wall, cut by the upright planes of the plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron, Shell
from structures.building.axes import SAME, Facet
from structures.building.panels import FacetStone
from structures.building.widths import NARROW, fat_pieces
from structures.geometry import polygons
from structures.geometry.compound_block import compound_block
from structures.geometry.convex import halves
from structures.geometry.near_points import first_of_near
from structures.geometry.outer_shell import is_closed, outer_shell
from structures.geometry.prism import between, prism_xz

WELD = 1e-8  # corners closer than this are one [m]


def parts_of(piece: FacetStone, facet: Facet, thickness: float) -> list[Shell]:
    """The convex parts of a stone, in the world."""
    half = 0.5 * thickness
    left, _, right, _ = piece.shape.bounds
    a, b = piece.clean
    if left >= a - SAME and right <= b + SAME:
        return [across(polygon, facet, (-half, half)) for polygon in fat_pieces(piece.shape)]
    found: list[Shell] = []
    level = polygons.is_rectangle(piece.shape)
    narrow = NARROW * thickness  # an end that is cut less obliquely is not for itself
    inner = [s for s, end in ((a, a - left), (b, right - b)) if end > narrow and left < s < right and not level]
    for low, high in pairwise([left, *inner, right]):
        for shape in [piece.shape] if level else polygons.polygons(piece.shape.intersection(polygons.box(low, high))):
            if low >= a - SAME and high <= b + SAME:
                found += [across(polygon, facet, (-half, half)) for polygon in fat_pieces(shape)]
            else:
                found += _at_end(shape, piece.area, facet, half)
    return found


def across(polygon: np.ndarray, facet: Facet, reach: tuple[float, float]) -> Shell:
    """A convex polygon s, z drawn out across a facet, between two n [m]."""
    vertices, faces = prism_xz(polygon, *reach)
    return _placed(vertices, facet), faces


def upright(plan: np.ndarray, low: float, high: float) -> Shell:
    """A convex polygon of the plan (n, 2) drawn up between two heights [m]."""
    return between(*(np.column_stack([plan, np.full(len(plan), z)]) for z in (low, high)))


def _at_end(shape: Polygon, area: Polygon, facet: Facet, half: float) -> Iterator[Shell]:
    """A stone that does not have the whole thickness all along."""
    left, low, right, high = shape.bounds
    plans = [ring for part in polygons.polygons(area.intersection(polygons.box(left, right))) for ring in fat_pieces(part)]
    if polygons.is_rectangle(shape):
        for plan in plans:
            yield upright(facet.place(plan), low, high)
        return
    for polygon in fat_pieces(shape):
        for plan in plans:
            block: Block | None = Block("", *prism_xz(polygon, -half, half), 1.0)
            for p, q in zip(plan, np.roll(plan, -1, axis=0), strict=True):
                if abs(q[1] - p[1]) < SAME and abs(abs(p[1]) - half) < SAME:
                    continue
                out = np.array([q[1] - p[1], p[0] - q[0], 0.0]) / np.hypot(*(q - p))
                block = halves(block, out, float(out[:2] @ p))[0] if block is not None else None
            if block is not None:
                yield _placed(block.vertices, facet), block.faces


def _placed(local: np.ndarray, facet: Facet) -> np.ndarray:
    """World corners (n, 3) of s, n, z."""
    return np.column_stack([facet.place(local[:, :2]), local[:, 2]])


def stone(name: str, parts: Sequence[Shell], density: float, group: str) -> Block:
    """One block of convex parts that touch, whether or not they share whole faces."""
    with suppress(InputError):
        whole = compound_block(name, parts, density, group)
        if is_closed(whole.faces):
            return whole
    solids = tuple(Polyhedron(*part) for part in parts)
    shell = outer_shell(solids)
    return Block(name, shell.vertices, shell.faces, density, group, parts=solids)


def welded(blocks: Sequence[Block]) -> list[Block]:
    """The blocks with corners that rounding parts made equal to the bit."""
    shells = [vertices for block in blocks for vertices in (block.vertices, *(part.vertices for part in block.parts))]
    points = np.concatenate(shells)
    points = points[first_of_near(points, WELD)]
    ends = np.cumsum([len(shell) for shell in shells])
    moved = iter(np.split(points, ends[:-1]))
    made = []
    for block in blocks:
        vertices = next(moved)
        parts = tuple(Polyhedron(next(moved), part.faces) for part in block.parts)
        made.append(replace(block, vertices=vertices, parts=parts))
    return made
