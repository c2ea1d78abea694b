# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans of walls along x and y whose openings are keyed to the courses, as the kinds wall, tower and church draw them.

All levels that openings need are beds, so what an opening leaves of a course are trapezoids, and no stone is cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from structures.building import junctions
from structures.building.axes import SAME, legs_of
from structures.building.engine import Walls, blocks_of_walls, refuse
from structures.building.footprints import Plan
from structures.building.frames import Frame
from structures.building.junctions import Junction, Pair
from structures.building.panels import Band, Laying, Leaves, stretches
from structures.building.table import BuildingTable, WallOpeningTable
from structures.geometry.polygons import box
from structures.layout.openings import Closing, close
from structures.layout.wall_plan import Wall

LEAST_JAMB = 0.2  # between an opening and the end of its stretch of a course, in blocks


def build(walls: Sequence[Wall], beds: Sequence[float], unit: float, density: float, bonded: bool = True) -> list[Block]:
    """The blocks of all walls, ``NAME.COURSE.NUMBER``, voussoirs and lintels ``NAME.oOPENING.NUMBER``.

    Args:
        beds: from :func:`structures.layout.wall_plan.levels` [m].
        unit: length of a block [m].
        density: [kg/m3].
        bonded: False makes straight joints where walls meet.

    Raises:
        InputError: an opening that does not lie inside its wall, or walls that cannot meet as they do.
    """
    table = BuildingTable.model_validate({"walls": [_table(wall) for wall in walls]})
    faults: list[str] = []
    legs = [leg for k, keys in enumerate(table.walls) for leg in legs_of(k, keys)]
    plan = Plan(legs, [_in_turns(junction, walls, bonded) for junction in junctions.find(legs, table, faults)])
    refuse(faults)
    layings = [_laying(wall, beds, unit) for wall in walls]
    frames = {(k, 0): _frames(plan, k, wall, layings[k]) for k, wall in enumerate(walls)}
    return blocks_of_walls(Walls(table, plan, frames, layings), density)


def _table(wall: Wall) -> dict[str, Any]:
    """A wall by the middle line of its plan."""
    middle = 0.5 * (wall.near + wall.far)
    axis = [(s, middle) if wall.axis == 0 else (middle, s) for s in (wall.start, wall.end)]
    profile = [(s - wall.start, z - wall.foot) for s, z in wall.profile]
    return {"name": wall.name, "group": wall.group, "axis": axis, "thickness": wall.far - wall.near, "base": wall.foot, "top": profile}


def _in_turns(junction: Junction, walls: Sequence[Wall], bonded: bool) -> Junction:
    """A junction at which walls along x run through in even courses; of unbonded walls the one that goes on, or else that along x."""

    def turned(pair: Pair) -> Pair:
        along_x = int(walls[pair.arms[0].leg].axis == 1)
        goes_on = [arm.end == 0 for arm in pair.arms]
        return replace(
            pair,
            bond="bonded" if bonded else "butt",
            through=along_x if bonded or goes_on[0] == goes_on[1] else goes_on.index(True),
        )

    return replace(junction, pairs=tuple(turned(pair) for pair in junction.pairs))


def _laying(wall: Wall, beds: Sequence[float], unit: float) -> Laying:
    """How a wall is laid: in leaves where it has several, counted from its near face."""
    own = [z for z in beds if wall.foot - SAME < z < wall.top + wall.gable + SAME]
    half = 0.5 * (wall.far - wall.near)
    middle = 0.5 * (wall.near + wall.far)
    bounds = np.linspace(-half, half, wall.leaves + 1) if wall.core is None else np.array([-half, *(n - middle for n in wall.core), half])
    leaves = Leaves(bounds if wall.axis == 0 else -bounds, wall.through, wall.core is not None, wall.hollow) if wall.leaves > 1 else None
    anchor = 0.0 if wall.anchor is None else wall.anchor - wall.start
    return Laying(np.array(beds), (own[-1] - own[0]) / (len(own) - 1), unit, anchor=anchor, keyed=True, leaves=leaves)


def _frames(plan: Plan, number: int, wall: Wall, laying: Laying) -> list[Frame]:
    """The openings of a wall, and the places left out in it.

    Raises:
        InputError: an opening that is not inside the wall, or too near to an end or to another opening.
    """
    first = int(np.argmin(np.abs(laying.beds - wall.foot)))
    last = int(np.argmin(np.abs(laying.beds - (wall.top + wall.gable))))
    own = laying.beds[first : last + 1]
    left_out = [_frame(box(a - wall.start, b - wall.start, low, high)) for a, b, low, high in wall.voids]
    found: list[Frame] = []
    for opening in wall.openings:
        closing = close(opening, own.tolist(), laying.course)
        for j in closing.edges:
            free = [s.band for s in stretches(plan, number, 0, laying, [*left_out, *found], first + j)]
            _refuse_without_room(
                [_moved(band, wall.start) for band in free], closing, j, 0.5 * (own[j] + own[j + 1]), LEAST_JAMB * laying.unit
            )
        found.append(_frame(_hull(closing, own, wall.start), [(kind, polygon - [wall.start, 0.0]) for kind, polygon in closing.pieces]))
    return [*found, *left_out]


def _moved(band: Band, by: float) -> Band:
    return Band(*(s + by for s in band[:4]))


def _hull(closing: Closing, beds: np.ndarray, start: float) -> Polygon:
    """What an opening with its head takes from a wall that starts at a place along it: trapezoids from course to course [m]."""
    c = closing.opening.centre - start
    side = [(h, float(z)) for j in sorted(closing.edges) for h, z in zip(closing.edges[j], beds[j : j + 2], strict=True)]
    return Polygon([*((c + h, z) for h, z in side), *((c - h, z) for h, z in reversed(side))])


def _frame(hull: Polygon, pieces: Sequence[tuple[str, np.ndarray]] = ()) -> Frame:
    """A frame that keeps to the courses."""
    left, low, right, high = hull.bounds
    keys = WallOpeningTable.model_validate({"at": 0.5 * (left + right), "width": right - left, "height": high - low})
    return Frame(keys, "", hull, tuple(pieces), hull, ())


def _refuse_without_room(bands: Sequence[Band], closing: Closing, j: int, z: float, least: float) -> None:
    """Refuse an opening for which no stretch of a course has the length; says where it would fit.

    Raises:
        InputError: names the key.
    """
    (h0, h1), c, key = closing.edges[j], closing.opening.centre, closing.opening.key
    for band in bands:
        space = min(c - h0 - band.left0, c - h1 - band.left1, band.right0 - c - h0, band.right1 - c - h1)
        if space - least >= -SAME:
            return
    half = max(h0, h1) + least
    free = [(max(b.left0, b.left1) + half, min(b.right0, b.right1) - half) for b in bands]
    free = [(low, high) for low, high in free if high >= low]
    if not free:
        widest = max((min(b.right0, b.right1) - max(b.left0, b.left1) for b in bands), default=0.0)
        most = max(0.0, closing.opening.width + widest - 2.0 * half)
        raise InputError(f"{key}width: must be at most {most:.4g} m for the masonry at z = {z:.4g} m, got {closing.opening.width:g}")
    low, high = min(free, key=lambda f: max(f[0] - c, c - f[1]))
    raise InputError(f"{key}centre: must be between {low:.4g} and {high:.4g} m for its head and jambs to stay in the wall, got {c:g}")
