# SPDX-License-Identifier: GPL-3.0-or-later
"""A plan and the elevations of its walls as a line drawing in SVG or PNG, in one scale, with names and measures."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.figures import blank
from masonry_cd.mechanics.model.wall_outline import WallOutline
from reports.drawing.figure import save
from reports.drawing.palette import EDGE, FAINT, FAULTY, INK, OPENED, STONE

WIDE = 14.0  # of the drawing [inches]
GAP = 1.5  # between elevations [m]
HAIR = 0.01  # shorter stretches of a wall are not drawn [m]
LETTERS = 150  # of a line below the title
MOST_SAID = 8  # lines on what is wrong


def draw_plan(
    walls: Sequence[WallOutline],
    others: Sequence[tuple[str, np.ndarray]],
    path: Path,
    title: str,
    wrong: Collection[str] = (),
    faults: Sequence[str] = (),
) -> None:
    """Draw a plan into an SVG or PNG, above the elevations of its walls, each seen from its right side.

    Args:
        walls: with what they go on by beyond their axes, so that measures are those of faces, as drawn.
        others: names and corners (Q, 2) of columns and vaults in plan [m].
        path: of the file.
        title: above it.
        wrong: names of walls that are drawn in red.
        faults: lines on what is wrong, below the title.
    """
    figure = blank((WIDE, WIDE))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_aspect("equal")
    grounds = [wall.ground for wall in walls]
    bounds = np.array([ground.bounds for ground in grounds])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    storeys = sorted({wall.storey for wall in walls})
    offset = np.array([float(high[0] - low[0]) + 2.0 * GAP, 0.0])  # from the plan of a storey to the next
    width = max(len(storeys) * offset[0], 1.6 * max(float(high[0] - low[0]), *(_length(wall) for wall in walls)))
    for k, storey in enumerate(storeys):
        own, corner = [(wall, ground) for wall, ground in zip(walls, grounds, strict=True) if wall.storey == storey], low - k * offset
        _fill(axes, [ground for _, ground in own], corner, STONE)
        _fill(axes, [ground for wall, ground in own if wall.name in wrong], corner, FAULTY)
        for wall, _ in own:
            _draw_in_plan(axes, wall, corner)
    for name, ring in others:
        axes.fill(*(ring - low).T, facecolor="none", edgecolor=OPENED, linewidth=0.7, linestyle="--")
        _draw_words(axes, ring.mean(axis=0) - low, name, 7)
    _draw_extents(axes, high - low)
    foot = _elevations(axes, walls, width, -3.0 * GAP, wrong)
    said = [line for fault in faults[:MOST_SAID] for line in textwrap.wrap(fault, LETTERS)]
    letter = (width + 4.0 * GAP) / LETTERS  # a line is about as wide as the drawing
    top = float(high[1] - low[1]) + 2.0 * GAP + 2.2 * letter * len(said)
    axes.set_xlim(-2.0 * GAP, width + 2.0 * GAP)
    axes.set_ylim(foot, top)
    axes.text(-1.5 * GAP, top - 0.2, title, fontsize=15, weight="bold", color=INK, va="top")
    axes.text(-1.5 * GAP, top - 0.2 - 3.0 * letter, "\n".join(said), fontsize=8, color=FAULTY, va="top", linespacing=1.4)
    figure.set_size_inches(WIDE, WIDE * (top - foot) / (width + 4.0 * GAP))
    save(figure, path, title)


def _length(wall: WallOutline) -> float:
    """From end to end [m]."""
    return float(wall.top[-1, 0]) + sum(wall.reach)


def _fill(axes: Any, grounds: Sequence[Any], low: np.ndarray, colour: str) -> None:
    """Polygons of shapely as one."""
    import shapely
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Line

    for part in shapely.get_parts(shapely.union_all(list(grounds), grid_size=1e-4)):
        rings = Line.make_compound_path(*(Line(np.array(ring.coords)[:, :2] - low) for ring in (part.exterior, *part.interiors)))
        axes.add_patch(PathPatch(rings, facecolor=colour, edgecolor=EDGE, linewidth=0.8))


def _draw_in_plan(axes: Any, wall: WallOutline, low: np.ndarray) -> None:
    """Draw the openings of a wall in plan, white, and its name."""
    line = wall.drawn_out - low
    for _, outline in wall.openings:
        start, end = np.clip([outline[:, 0].min() + wall.reach[0], outline[:, 0].max() + wall.reach[0]], 0.0, _length(wall)).tolist()
        if end - start < HAIR:
            continue
        axes.fill(*_band(_between(line, start, end), wall.thickness).T, facecolor="white", edgecolor=EDGE, linewidth=0.6)
    place = _between(line, 0.5 * _length(wall), 0.5 * _length(wall) + HAIR)[0]
    _draw_words(axes, place, f"{wall.name} {wall.thickness:.2f}", 7)


def _band(line: np.ndarray, thickness: float) -> np.ndarray:
    """The ring (2P, 2) around a line."""
    along = np.gradient(line, axis=0)
    along /= np.hypot(*along.T)[:, None]
    left = 0.5 * thickness * np.column_stack([-along[:, 1], along[:, 0]])
    return np.concatenate([line + left, (line - left)[::-1]])


def _between(line: np.ndarray, start: float, end: float) -> np.ndarray:
    """The part of a line between two distances from its start."""
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    inner = at[(at > start) & (at < end)]
    places = np.array([start, *inner, end])
    return np.column_stack([np.interp(places, at, line[:, k]) for k in (0, 1)])


def _draw_extents(axes: Any, size: np.ndarray) -> None:
    """Draw the extent of the axes in plan along x and y."""
    for (a, b), words, turn in (
        (((0.0, -GAP), (size[0], -GAP)), f"{size[0]:.2f}", 0),
        (((-GAP, 0.0), (-GAP, size[1])), f"{size[1]:.2f}", 90),
    ):
        axes.annotate("", a, b, arrowprops={"arrowstyle": "<->", "color": FAINT, "linewidth": 0.7})
        _draw_words(axes, 0.5 * (np.array(a) + np.array(b)), words, 8, turn)


def _elevations(axes: Any, walls: Sequence[WallOutline], width: float, under: float, wrong: Collection[str]) -> float:
    """The elevations in rows below a level; how far down they reach."""
    left, row = 0.0, 0.0
    for wall in walls:
        length, high = _length(wall), float(wall.top[:, 1].max() - wall.base)
        if left > 0.0 and left + length > width:
            left, under, row = 0.0, under - row - 2.0 * GAP, 0.0
        row = max(row, high)
        _draw_elevation(axes, wall, np.array([left + wall.reach[0], under - high - wall.base]), FAULTY if wall.name in wrong else STONE)
        left += length + GAP
    return under - row - 2.0 * GAP


def _draw_elevation(axes: Any, wall: WallOutline, corner: np.ndarray, colour: str) -> None:
    start, end = -wall.reach[0], float(wall.top[-1, 0]) + wall.reach[1]
    tops = [(start, wall.top[0, 1]), *wall.top[1:-1], (end, wall.top[-1, 1])]
    ring = np.array([(start, wall.base), (end, wall.base), *tops[::-1]]) + corner
    axes.fill(*ring.T, facecolor=colour, edgecolor=EDGE, linewidth=0.8)
    for name, outline in wall.openings:
        axes.fill(*(outline + corner).T, facecolor="white", edgecolor=EDGE, linewidth=0.7)
        (left, sill), (right, top) = outline.min(axis=0), outline.max(axis=0)
        words = f"{name}\n{right - left:.2f} x {top - sill:.2f}\n{sill - wall.base:.2f}".lstrip("\n")
        _draw_words(axes, np.array([0.5 * (left + right), 0.5 * (sill + top)]) + corner, words, 6)
    highest = wall.top[int(np.argmax(wall.top[:, 1]))]
    _draw_words(axes, highest + corner + np.array([0.0, 0.3]), f"{highest[1]:+.2f}", 7)
    _draw_words(axes, np.array([0.5 * (start + end), wall.base - 0.6]) + corner, f"{wall.name} {end - start:.2f}", 8)


def _draw_words(axes: Any, place: np.ndarray, words: str, size: float, turn: float = 0.0) -> None:
    under = {"facecolor": "white", "alpha": 0.8, "linewidth": 0.0, "pad": 0.8}
    axes.text(place[0], place[1], words, fontsize=size, color=INK, ha="center", va="center", rotation=turn, bbox=under)
