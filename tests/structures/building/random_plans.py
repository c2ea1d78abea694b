# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans by chance: rooms out of square with walls within, curved ones, crossings, gables and steps.

Openings lie where a person would draw them, clear of other walls, of each other and of the top; in one plan of eight they lie anywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from plans import wall
from shapely.geometry import LineString, Point

CLEAR = 0.25  # masonry between an opening and another wall or opening [m]
SHAPES = ("rectangular", "round", "segmental", "pointed", "rose", "niche")


def plan(seed: int) -> dict[str, Any]:
    """The table of a building; it may be one that cannot be built."""
    random = np.random.default_rng(seed)
    corners = np.array([(0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)]) + random.uniform(-0.7, 0.7, (4, 2))
    course = float(random.choice([0.3, 0.4, 0.5]))
    walls = []
    for k, name in enumerate("abcd"):
        axis: list[Any] = [corners[k].tolist(), corners[(k + 1) % 4].tolist()]
        if random.random() < 0.1:  # bulges outwards
            along = corners[(k + 1) % 4] - corners[k]
            through = 0.5 * (corners[k] + corners[(k + 1) % 4]) + random.uniform(0.08, 0.18) * np.array([along[1], -along[0]])
            axis[1] = {"to": axis[1], "through": through.tolist()}
        walls.append(_wall(random, name, axis))
    share = random.uniform(0.25, 0.75, 2)
    ends = [corners[0] + share[0] * (corners[1] - corners[0]), corners[3] + share[1] * (corners[2] - corners[3])]
    kind = random.choice(["none", "tee", "across", "through"])
    if kind in ("tee", "across"):
        walls.append(_wall(random, "inner", [end.tolist() for end in ends]))
    if kind == "across":
        walls.append(_wall(random, "cross", [(0.5 * (corners[0] + corners[3])).tolist(), (0.5 * (corners[1] + corners[2])).tolist()]))
    if kind == "through":
        beyond = [end + sign * 1.2 * (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0])) for end, sign in zip(ends, (-1, 1), strict=True)]
        walls.append(_wall(random, "through", [end.tolist() for end in beyond]))
    if random.random() > 0.125:
        for one in walls:
            one["openings"] = list(_placed(random, one, [other for other in walls if other is not one]))
    bond = random.choice(["regular", "irregular", "rubble"])
    junction: Any = random.choice(["bonded", "butt", "half"])
    keys = {"walls": walls, "course_height": course, "block_length": float(random.choice([0.5, 0.8, 1.2])), "seed": seed, "bond": str(bond)}
    return keys | {"junction": 0.5 if junction == "half" else str(junction)}


def _wall(random: np.random.Generator, name: str, axis: list[Any]) -> dict[str, Any]:
    """A wall of any thickness and height, level or a gable, with up to two openings anywhere."""
    thickness, height = round(float(random.uniform(0.3, 0.8)), 2), float(random.choice([2.0, 2.4, 2.4, 2.4, 3.3]))
    keys: dict[str, Any] = {}
    straight = not isinstance(axis[1], dict)
    length = float(np.hypot(*(np.array(axis[1]) - axis[0]))) if straight else 4.0
    if straight and random.random() < 0.2:
        keys["top"] = [[0.0, height], [0.5 * length, height + float(random.uniform(0.3, 1.0))], [length, height]]
    elif straight and random.random() < 0.15:
        keys["top"] = [[0.0, height], [0.5 * length, height], [0.5 * length, height + 0.9], [length, height + 0.9]]
    openings = []
    for _ in range(int(random.choice([0, 0, 1, 1, 2]))):
        width = round(float(random.uniform(0.4, 0.8)), 2)
        at, sill = round(float(random.uniform(0.2 * length, 0.8 * length)), 2), float(random.choice([0.0, 0.6, 0.9]))
        opening: dict[str, Any] = {"shape": str(random.choice(SHAPES)), "at": at, "width": width, "sill": sill}
        openings.append(opening if opening["shape"] == "rose" else opening | {"height": round(float(random.uniform(0.8, 1.4)), 2)})
    return wall(name, axis, thickness, height, openings=openings, **keys)


def _placed(random: np.random.Generator, one: dict[str, Any], others: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The openings of a wall that have a place where they can be, put there."""
    taken = _taken(one, others)
    for opening in one["openings"]:
        half = 0.5 * opening["width"] + CLEAR
        free = [(a + half, b - half) for (_, a), (b, _) in pairwise(sorted(taken)) if b - a > 2.0 * half]
        if not free:
            continue
        low, high = free[int(random.integers(len(free)))]
        at = round(float(random.uniform(low, high)), 3)
        head = 0.4 * opening["width"]
        sill = max(opening["sill"], head) if opening["shape"] == "rose" else opening["sill"]
        height = min(opening.get("height", opening["width"]), _top_over(one, at, half) - head - sill)
        if height < opening["width"] * (1.0 if opening["shape"] in ("rose", "pointed") else 0.7):
            continue
        taken.append((at - half, at + half))
        yield opening | {"at": at, "sill": sill} | ({} if opening["shape"] == "rose" else {"height": round(height, 3)})


def _taken(one: dict[str, Any], others: list[dict[str, Any]]) -> list[tuple[float, float]]:
    """Where other walls, and ends, lie along a wall [m]; of a curved one all but the middle of its arc."""
    if isinstance(one["axis"][1], dict):
        arc = _line(one).length
        return [(-1.0, 0.35 * arc), (0.6 * arc, arc)]
    line, found = _line(one), []
    for other in others:
        shared = line.buffer(0.5 * one["thickness"]).intersection(_line(other).buffer(0.5 * other["thickness"] + 1e-3, cap_style="square"))
        if not shared.is_empty:
            places = [line.project(corner) for corner in map(Point, shapely.get_coordinates(shared))]
            found.append((min(places) - CLEAR, max(places) + CLEAR))
    return [*found, (-1.0, CLEAR), (line.length - CLEAR, line.length + 1.0)]


def _line(one: dict[str, Any]) -> LineString:
    start, end = one["axis"]
    return LineString([start, end["through"], end["to"]] if isinstance(end, dict) else [start, end])


def _top_over(one: dict[str, Any], at: float, half: float) -> float:
    """Height of the lowest part of the top over an opening [m]."""
    if "top" not in one:
        return float(one["height"])
    places, heights = zip(*one["top"], strict=True)
    return float(min(np.interp(np.linspace(at - half, at + half, 9), places, heights)))
