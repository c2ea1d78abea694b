# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls, openings and columns of a building model as tables of a building; what else it has is listed.

A wall is straight and of one thickness: its plan is a rectangle, whose middle line is the axis, and its side, a convex figure, has the top.
Walls one above the other, of one plan, are one wall through the floors between them. Axes are then drawn out to where walls meet, as those
of a drawing are (:mod:`structures.plans.axes`). Slabs and roofs are listed as the tables that they would be, since a model does not say
what they weigh.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.geometry import sixfold_volumes
from structures.files.foreign import piece_of, word_of
from structures.plans.axes import WallAxis, walls_of
from structures.plans.bands import WallStretch, merged
from structures.plans.edges import Edge
from structures.plans.ifc_file import COLUMNS, OPENINGS, READ, ROOFS, SLABS, WALLS
from structures.plans.places import place
from structures.plans.recognised import Left, Recognised, axis_of

ALIKE = 0.02  # by how much a volume may differ from that of the wall or column that it is taken for
LEVEL = 0.01  # heights that differ by less are one [m]
THROUGH = 0.6  # of the height of a floor between two walls over one another, at most [m]
NICHE = 0.9  # of the thickness of its wall: an opening that goes less deep is a niche
EDGE = 1e-3  # corners this near to the end of an opening are those of its jambs [m]
FLAT = 0.02  # rise of a head, below which it is straight [m]
ROUND, SQUARE = 0.05, 0.05  # by how much a head may be off half a circle, and the sides of a pier off each other, as shares
DIGITS = 4  # of lengths in the plan [m]


class Element(NamedTuple):
    """An element of the model, in the world [m]."""

    kind: str  # class of IFC
    guid: str
    name: str
    storey: str
    host: str  # of an opening, the wall's guid
    points: np.ndarray  # (V, 3)
    volume: float  # [m3]

    @property
    def low(self) -> float:
        """z of its foot [m]."""
        return float(self.points[:, 2].min())

    @property
    def high(self) -> float:
        """z of its top [m]."""
        return float(self.points[:, 2].max())

    def left(self, why: str) -> Left:
        """As something that is not understood."""
        return Left(self.guid, self.storey or "no storey", f'{self.kind} "{self.name}"', why)


class _Straight(NamedTuple):
    """A wall of the model, or several over one another."""

    elements: tuple[Element, ...]
    start: np.ndarray  # (2,) of its middle line [m]
    end: np.ndarray
    thickness: float
    base: float
    top: np.ndarray  # (n, 2) distance along the middle line, z [m]


def element_of(kind: str, guid: str, name: str, storey: str, host: str, vertices: Any, faces: Any) -> Element:
    """An element of a reader's answer.

    Raises:
        ValueError, TypeError: no answer of ours, or places that are no numbers.
    """
    kind, guid, storey, host = map(word_of, (kind, guid, storey, host))
    shape = piece_of(0, name, vertices, faces)
    if kind not in READ or not len(shape.vertices) or not np.isfinite(shape.vertices).all():
        raise ValueError(f"{kind} {guid} has places that are no numbers")
    corners = (shape.vertices - shape.vertices.mean(axis=0))[np.array(shape.faces, dtype=np.int64).reshape(-1, 3)]
    return Element(kind, guid, shape.name, storey, host, shape.vertices, abs(float(sixfold_volumes(corners).sum())) / 6.0)


def read_model(elements: Sequence[Element], source: str) -> Recognised:
    """The tables of a model.

    Raises:
        InputError: no wall comes out; walls in line of other heights.
    """
    left: list[Left] = []
    notes: list[str] = []
    straight = [made for element in elements if element.kind == WALLS and (made := _straight(element, left)) is not None]
    if not straight:
        raise InputError(source, f"no straight wall of one thickness in it; {left[0].drawn_as}: {left[0].why}")
    straight = _stacked(straight, notes, source)
    walls, tables, names = walls_of(_bands(straight), None), list[dict[str, Any]](), set[str]()
    for k, wall in enumerate(walls):
        own = [straight[int(handle)] for handle in wall.handles]
        name = _name(own[0].elements[0].name, f"w{k + 1}", names)
        tables.append({"name": name, "axis": axis_of(wall), "thickness": _rounded(wall.thickness), **_heights(wall, own, source)})
    homes = {e.guid: k for k, wall in enumerate(walls) for handle in wall.handles for e in straight[int(handle)].elements}
    for element in elements:
        if element.kind == OPENINGS:
            home = homes.get(element.host)
            opening = "its wall is not read" if home is None else _opening(element, walls[home], tables[home]["base"])
            if isinstance(opening, str):
                left.append(element.left(opening))
            elif home is not None:
                tables[home].setdefault("openings", []).append(opening)
    for table in tables:
        table.get("openings", []).sort(key=lambda opening: (opening["at"], opening["sill"]))
    columns = [column for element in elements if element.kind == COLUMNS and (column := _column(element, left)) is not None]
    notes += [_slab_line(element, source) for element in elements if element.kind in (SLABS, ROOFS)]
    return Recognised({"walls": tables, **({"columns": columns} if columns else {})}, notes, left, {})


def _straight(element: Element, left: list[Left]) -> _Straight | None:
    """A wall that is straight and of one thickness; what is none is left."""
    import shapely

    hull = shapely.MultiPoint(element.points[:, :2]).minimum_rotated_rectangle
    if hull.geom_type != "Polygon":
        left.append(element.left("has no thickness"))
        return None
    corners = np.array(hull.exterior.coords)[:4]
    sides = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    k = int(np.argmax(sides))
    start, end = (0.5 * (corners[i % 4] + corners[j % 4]) for i, j in ((k, k + 3), (k + 1, k + 2)))
    thickness, length = float(sides[(k + 1) % 4]), float(sides[k])
    along = (element.points[:, :2] - start) @ ((end - start) / length)
    side = shapely.MultiPoint(np.column_stack([along, element.points[:, 2]])).convex_hull
    if side.geom_type != "Polygon" or abs(side.area * thickness - element.volume) > ALIKE * side.area * thickness:
        left.append(element.left("is not straight and of one thickness, or its side is hollow"))
        return None
    ring = np.array(shapely.geometry.polygon.orient(side).exterior.coords)[:-1]
    foot = ring[ring[:, 1] < element.low + LEVEL]
    if len(foot) < 2 or np.ptp(foot[:, 0]) < length - LEVEL:
        left.append(element.left("its foot is not level"))
        return None
    top = ring[ring[:, 1] >= element.low + LEVEL]
    return _Straight((element,), start, end, thickness, element.low, top[np.argsort(top[:, 0], kind="stable")])


def _stacked(walls: Sequence[_Straight], notes: list[str], source: str) -> list[_Straight]:
    """Walls of one plan, the one on the other or on a floor between them, as one wall."""
    out: list[_Straight] = []
    for wall in sorted(walls, key=lambda one: one.base):
        k = next((k for k, below in enumerate(out) if _carries(below, wall)), None)
        if k is None:
            out.append(wall)
            continue
        below = out[k]
        gap = wall.base - float(below.top[:, 1].max())
        if gap > LEVEL:
            names = f'"{below.elements[-1].name}" and "{wall.elements[0].name}"'
            notes.append(f"{source}: walls {names} are one through the {gap:.2f} m of floor between them")
        swapped = math.dist(below.start, wall.start) > math.dist(below.start, wall.end)
        top = wall.top * [-1.0, 1.0] + [math.dist(wall.start, wall.end), 0.0] if swapped else wall.top
        out[k] = below._replace(elements=(*below.elements, *wall.elements), top=top[np.argsort(top[:, 0], kind="stable")])
    return out


def _carries(below: _Straight, wall: _Straight) -> bool:
    """True if a wall of one plan with another ends where that one begins, or a floor below it."""
    along, against = (math.dist(below.start, a) + math.dist(below.end, b) for a, b in ((wall.start, wall.end), (wall.end, wall.start)))
    level = float(np.ptp(below.top[:, 1])) < LEVEL
    gap = wall.base - float(below.top[:, 1].max())
    return level and min(along, against) < 2.0 * LEVEL and abs(below.thickness - wall.thickness) < LEVEL and -LEVEL < gap < THROUGH


def _bands(walls: Sequence[_Straight]) -> list[WallStretch]:
    """The bands of walls; those in line and of one height as one."""
    by_height: dict[tuple[int, int], list[WallStretch]] = {}
    for k, wall in enumerate(walls):
        low, high = float(wall.top[:, 1].min()), float(wall.top[:, 1].max())
        key = (round(wall.base / LEVEL), round(high / LEVEL)) if high - low < LEVEL else (-1, k)
        by_height.setdefault(key, []).append(WallStretch(Edge(wall.start, wall.end, str(k)), wall.thickness, (str(k),)))
    return [band for group in by_height.values() for band in merged(group, None, ())]


def _name(written: str, usual: str, taken: set[str]) -> str:
    """A name as a plan may have it, each once: what is none of it becomes a line."""
    bare = re.sub(r"[.\s*]+", "_", "".join(c for c in written if c.isprintable())).strip("_")[:50] or usual
    name = next(own for own in (bare, *(f"{bare}_{k}" for k in range(2, len(taken) + 3))) if own not in taken)
    taken.add(name)
    return name


def _heights(wall: WallAxis, own: Sequence[_Straight], source: str) -> dict[str, Any]:
    """Base, and height or the profile of the top, of a wall made of some of the model.

    Raises:
        InputError: of other heights.
    """
    first = own[0]
    level = all(np.ptp(one.top[:, 1]) < LEVEL and abs(one.base - first.base) < LEVEL for one in own)
    heights = [float(one.top[:, 1].max()) - one.base for one in own]
    if len(own) > 1 and (not level or max(heights) - min(heights) > LEVEL):
        names = ", ".join(f'"{one.elements[0].name}"' for one in own)
        where = place(wall.pieces[0].end)
        raise InputError(source, f"walls {names} go on in one line, but in other heights, at {where}: give them one, or another thickness")
    base = {"base": _rounded(first.base)}
    if level:
        return {**base, "height": _rounded(heights[0])}
    ends = [wall.along(point.tolist()) for point in (first.start, first.end)]
    share = (ends[1] - ends[0]) / math.dist(first.start, first.end)
    profile = sorted((ends[0] + share * s, z - first.base) for s, z in first.top.tolist())
    inner = [(s, z) for s, z in profile if LEVEL < s < wall.length - LEVEL]
    whole = [(0.0, profile[0][1]), *inner, (wall.length, profile[-1][1])]
    return {**base, "top": [[_rounded(s), _rounded(z)] for s, z in whole]}


def _opening(element: Element, wall: WallAxis, base: float) -> dict[str, Any] | str:
    """The table of an opening; or why it is none."""
    along = np.array([wall.along(point) for point in element.points[:, :2].tolist()])
    low, high = float(along.min()), float(along.max())
    width, height, sill = high - low, element.high - element.low, element.low - base
    if width < LEVEL or high > wall.length - LEVEL or low < LEVEL:
        return "it lies at the end of its wall, or beyond"
    across = _across(element, wall)
    height += min(sill, 0.0)  # it reaches below the foot of the wall
    table: dict[str, Any] = {"at": _rounded(0.5 * (low + high)), "width": _rounded(width)}
    table |= {"sill": _rounded(max(sill, 0.0)), "height": _rounded(height)}
    half = 0.5 * wall.thickness
    depth = min(across[1], half) - max(across[0], -half)
    if depth < NICHE * wall.thickness:
        return {"shape": "niche", **table, "depth": _rounded(depth), "side": "left" if sum(across) > 0.0 else "right"}
    jambs = element.points[(along < low + EDGE) | (along > high - EDGE), 2]
    rise = element.high - float(jambs.max())
    if rise < FLAT:
        return {"shape": "rectangular", **table}
    if abs(rise - 0.5 * width) < ROUND * width:
        return {"shape": "round", **table}
    return {"shape": "segmental" if rise < 0.5 * width else "pointed", **table, "rise": _rounded(rise)}


def _across(element: Element, wall: WallAxis) -> tuple[float, float]:
    """Extent of an opening across its wall, from the axis to the left [m]."""
    piece = min(wall.pieces, key=lambda one: math.dist(0.5 * (one.start + one.end), element.points[:, :2].mean(axis=0)))
    d = (piece.end - piece.start) / math.dist(piece.start, piece.end)
    over = (element.points[:, :2] - piece.start) @ np.array([-d[1], d[0]])
    return float(over.min()), float(over.max())


def _column(element: Element, left: list[Left]) -> dict[str, Any] | None:
    """The table of an upright column or pier, round or square; what is none is left."""
    import shapely

    plan = shapely.MultiPoint(element.points[:, :2]).convex_hull
    tall = element.high - element.low
    if plan.geom_type != "Polygon" or abs(plan.area * tall - element.volume) > ALIKE * element.volume:
        left.append(element.left("is not an upright column of one section"))
        return None
    box = np.array(plan.minimum_rotated_rectangle.exterior.coords)[:4]
    a, b = (float(math.dist(box[k], box[k + 1])) for k in (0, 1))
    if abs(a - b) > SQUARE * max(a, b):
        left.append(element.left(f"is neither round nor square, {a:.2f} by {b:.2f} m: a wall"))
        return None
    centre, size = plan.centroid.coords[0], math.sqrt(plan.area)
    table: dict[str, Any] = {"at": [_rounded(x) for x in centre], "base": _rounded(element.low), "height": _rounded(tall)}
    if plan.area < (1.0 - SQUARE) * a * b:
        return {**table, "section": "round", "size": _rounded(2.0 * math.sqrt(plan.area / math.pi))}
    turned = math.degrees(math.atan2(*(box[1] - box[0])[::-1])) % 90.0
    return {**table, "section": "square", "size": _rounded(size), **({"turned": round(turned, 3)} if LEVEL < turned < 90.0 - LEVEL else {})}


def _slab_line(element: Element, source: str) -> str:
    """A slab or a roof as the table that it would be."""
    x, y = element.points[:, :2].mean(axis=0)
    if element.kind == ROOFS:
        return f'{source}: roof "{element.name}" up to {element.high:.2f} m: give it as [[structure.roofs]], with its walls, rise and mass'
    measures = f"height = {element.high:.3g}, thickness = {element.high - element.low:.3g}, inside = [{x:.4g}, {y:.4g}]"
    return f'{source}: slab "{element.name}": give it as [[structure.floors]] with {measures}, its walls and its mass'


def _rounded(value: float) -> float:
    return round(float(value), DIGITS) + 0.0
