# SPDX-License-Identifier: GPL-3.0-or-later
"""Outlines of each wall in the drawing of a plan: its ground, the profile of its top, its openings in elevation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from masonry_cd.mechanics.model.wall_outline import WallOutline
from structures.plans.edges import Edge, angle_between, circle_through

PARTS = 12  # chords of a half circle in a drawing


def outline_of(wall: Mapping[str, Any], reach: tuple[float, float] = (0.0, 0.0)) -> WallOutline:
    """A wall of a building's table as drawn, which goes on beyond the ends of its axis by some lengths [m]."""
    line, length = axis_line(wall["axis"])
    base = float(wall.get("base", 0.0))
    top = wall.get("top") or [[0.0, wall.get("height", 0.0)], [length, wall.get("height", 0.0)]]
    openings = tuple((str(o.get("name") or ""), _shifted(opening_outline(o), base)) for o in wall.get("openings", ()))
    return WallOutline(str(wall["name"]), line, float(wall["thickness"]), _shifted(np.array(top, dtype=float), base), base, openings, reach)


def _shifted(points: np.ndarray, up: float) -> np.ndarray:
    return points + np.array([0.0, up])


def axis_line(axis: Sequence[Any]) -> tuple[np.ndarray, float]:
    """The points (P, 2) of an axis with its arcs as chords, and its length [m]."""
    here = np.array(axis[0], dtype=float)
    points, length = [here], 0.0
    for piece in axis[1:]:
        to = np.array(piece["to"] if isinstance(piece, Mapping) else piece, dtype=float)
        edge = _arc(here, np.array(piece["through"], dtype=float), to) if isinstance(piece, Mapping) else Edge(here, to, "")
        points += [*edge.points()[1:], to]
        length += edge.length
        here = to
    return np.array(points), length


def _arc(start: np.ndarray, through: np.ndarray, end: np.ndarray) -> Edge:
    if math.dist(start, end) < 1e-9:  # a whole circle
        return Edge(start, end, "", 0.5 * (start + through), 2.0 * math.pi)
    centre = circle_through(start, through, end)
    sweep = angle_between(start - centre, through - centre) % (2.0 * math.pi)
    whole = angle_between(start - centre, end - centre) % (2.0 * math.pi)
    return Edge(start, end, "", centre, whole if sweep < whole else whole - 2.0 * math.pi)


def opening_outline(opening: Mapping[str, Any]) -> np.ndarray:
    """Corners (Q, 2) of an opening: distance along the axis, height over the base of its wall [m]."""
    at, half, sill = float(opening["at"]), 0.5 * float(opening["width"]), float(opening.get("sill", 0.0))
    shape = opening.get("shape", "rectangular")
    if shape == "rose":
        return np.array([[at + half * math.cos(a), sill + half + half * math.sin(a)] for a in np.linspace(0.0, 2.0 * math.pi, 4 * PARTS)])
    height = float(opening.get("height") or 4.0 * half)
    head = _head(shape, half, opening.get("rise"))
    spring = sill + height - max([z for _, z in head], default=0.0)
    return np.array([[at - half, sill], [at + half, sill], *([at + x, spring + z] for x, z in head)])


def _head(shape: str, half: float, rise: float | None) -> list[tuple[float, float]]:
    """Return the head of an opening, from its right springing to its left one: x from its middle, height over its springings [m]."""
    if shape == "rectangular" or (shape == "niche" and not rise):
        return [(half, 0.0), (-half, 0.0)]
    if shape == "pointed":
        high = rise or math.sqrt(3.0) * half
        radius = (half**2 + high**2) / (2.0 * half)
        side = [
            (radius * math.cos(a) + half - radius, radius * math.sin(a))
            for a in np.linspace(0.0, math.asin(min(high / radius, 1.0)), PARTS)
        ]
        return [*side, *((-x, z) for x, z in side[::-1])]
    high = half if shape == "round" else rise or half / 3.0
    radius = (half**2 + high**2) / (2.0 * high)
    end = math.asin(min(half / radius, 1.0))
    return [(radius * math.sin(a), radius * math.cos(a) - radius + high) for a in np.linspace(end, -end, 2 * PARTS)]
