# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of walls from the texts next to them: one for the whole wall, a gable, or steps at the walls that meet it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from structures.plans.axes import WallAxis
from structures.plans.marks import Marks

AWAY = 0.8  # a text further than this from the faces of a wall is of something else [m]


class Note(NamedTuple):
    """A text next to a wall."""

    at: float  # distance along the axis [m]
    marks: Marks
    handle: str


def nearest_wall(text: Any, walls: Sequence[WallAxis]) -> int | None:
    """The wall next to whose face the line of a text stands, or in which it does."""
    apart = [wall.ground().distance(text) for wall in walls]
    if not apart or min(apart) > AWAY:
        return None
    middle = text.centroid
    among = [k for k, distance in enumerate(apart) if distance < min(apart) + 0.05]
    return min(among, key=lambda k: walls[k].line.distance(middle))


def height_keys(wall: WallAxis, k: int, walls: Sequence[WallAxis], notes: Sequence[Note], default: float | None) -> dict[str, Any] | None:
    """The keys ``base`` and ``height`` or ``top`` of a wall; None where nothing says its height."""
    base = next((note.marks.numbers["base"] for note in notes if "base" in note.marks.numbers), 0.0)
    keys: dict[str, Any] = {"base": base} if base else {}
    for note in notes:
        if note.marks.profile:
            stations = np.linspace(0.0, wall.length, len(note.marks.profile))
            return keys | {"top": [[_within(float(s), wall), z] for s, z in zip(stations, note.marks.profile, strict=True)]}
    tall = [(note.at, _height(note.marks, base)) for note in notes if _height(note.marks, base)]
    if not tall:
        return None if default is None else keys | {"height": default}
    if len({height for _, height in tall}) == 1:
        return keys | {"height": tall[0][1]}
    top = _steps(wall, k, walls, tall)
    return keys | ({"height": top[0][1]} if len(top) == 2 and top[0][1] == top[1][1] else {"top": top})


def _within(s: float, wall: WallAxis) -> float:
    """A place along a wall to a tenth of a millimetre, and never beyond its end [m]."""
    return min(round(s, 4), math.floor(1e6 * wall.length) / 1e6)


def _height(marks: Marks, base: float) -> float:
    """Over the base; 0 where the marks say none."""
    return round(marks.numbers.get("height", marks.numbers["level"] - base if "level" in marks.numbers else 0.0), 4)


def _steps(wall: WallAxis, k: int, walls: Sequence[WallAxis], tall: Sequence[tuple[float, float]]) -> list[list[float]]:
    """The profile of a wall of several heights: each stretch between walls that meet it has that of the nearest text in it, or near it."""
    met = sorted(_crossings(wall, k, walls))
    bounds = [(0.0, 0.0), *met, (wall.length, 0.0)]
    heights = []
    for (low, _), (high, _) in pairwise(bounds):
        within = [pair for pair in tall if low <= pair[0] <= high] or list(tall)
        heights.append(min(within, key=lambda pair: abs(pair[0] - 0.5 * (low + high)))[1])
    top = [[0.0, heights[0]]]
    for (station, half), before, after in zip(met, heights[:-1], heights[1:], strict=True):
        if before != after:
            place = round(station + (half if before > after else -half), 4)  # the wall that meets it there stands to the greater height
            top += [[place, before], [place, after]]
    return [*top, [_within(wall.length, wall), heights[-1]]]


def _crossings(wall: WallAxis, k: int, walls: Sequence[WallAxis]) -> list[tuple[float, float]]:
    """Distances along the axis at which others end on it or cross it, each with half the thickness of the other."""
    import shapely

    found = []
    for j, other in enumerate(walls):
        if j == k or not wall.line.buffer(1e-3).intersects(other.line):
            continue
        place = shapely.shortest_line(wall.line, other.line).coords[0]
        at = wall.along(place)
        if 0.5 * other.thickness < at < wall.length - 0.5 * other.thickness:
            found.append((at, 0.5 * other.thickness))
    return found
