# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings, vaults and columns of a plan, from what is drawn on their layers and the texts next to it, as tables of a building."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from structures.plans import marks
from structures.plans.axes import WallAxis
from structures.plans.edges import Edge, edges_of, polygon
from structures.plans.entities import INSERT, PATH, Entity
from structures.plans.marks import Marks

TOUCHING = 0.02  # lines on a layer of openings this near to each other draw one opening [m]
NEAR = 0.3  # an opening this far off every wall lies in none [m]
NARROWEST = 0.08  # m
DOOR, WINDOW, SILL = 2.1, 1.2, 0.9  # heights and sill where no text says them [m]
READ_AT = 1.5  # a text further away than this belongs to something else [m]
STACKED = 0.3  # things over one another are as near to a text, but for this [m]
ALIKE = 0.001  # numbers of two texts that differ by less are one [m]
ROUND = 0.03  # share by which the radius of a round column may vary


class Drawn(NamedTuple):
    """Something on a layer of openings, vaults or columns."""

    handles: tuple[str, ...]
    layer: str
    shape: Any  # of shapely: a polygon of what is closed, else lines
    paths: tuple[Entity, ...]
    text: str = ""  # the name and the attributes of its insert

    @property
    def attributes(self) -> list[str]:
        """Attributes of its insert, TAG=value each."""
        return self.text.splitlines()[1:]

    def distance(self, line: Any) -> float:
        """From a line of shapely, as of a text [m]."""
        return float(self.shape.convex_hull.distance(line))


def drawn(entities: Sequence[Entity], inserts: bool = True) -> list[Drawn]:
    """Group the drawn entities: every insert is one thing, every closed path, and every cluster of open ones that touch."""
    import shapely

    found, loose = [], []
    own: dict[str, list[Entity]] = {e.handle: [] for e in entities if inserts and e.kind == INSERT}
    texts = {e.handle: e.text for e in entities if e.kind == INSERT}
    for entity in entities:
        if entity.kind != PATH or not len(entity.points):
            continue
        if entity.owner in own:
            own[entity.owner].append(entity)
        elif entity.closed:
            found.append(Drawn((entity.handle,), entity.layer, polygon(edges_of(entity)), (entity,)))
        else:
            loose.append(entity)
    for handle, paths in own.items():
        if paths:
            layer = next(e.layer for e in entities if e.handle == handle)
            found.append(Drawn((handle,), layer, shapely.union_all([_line(p) for p in paths]), tuple(paths), texts[handle]))
    found = [one for one in found if not one.shape.is_empty]
    free = []
    for path in loose:
        inside = next((k for k, one in enumerate(found) if one.shape.distance(_line(path)) < TOUCHING and not one.text), None)
        if inside is None:
            free.append(path)
        else:
            found[inside] = found[inside]._replace(handles=(*found[inside].handles, path.handle))
    return found + _clusters(free)


def _clusters(paths: Sequence[Entity]) -> list[Drawn]:
    import shapely

    if not paths:
        return []
    lines = [_line(path) for path in paths]
    grown = shapely.union_all([line.buffer(TOUCHING, quad_segs=2) for line in lines])
    parts = list(grown.geoms) if hasattr(grown, "geoms") else [grown]
    members: list[list[int]] = [[] for _ in parts]
    for k, line in enumerate(lines):
        members[next((j for j, part in enumerate(parts) if part.intersects(line)), 0)].append(k)
    return [
        Drawn(
            tuple(paths[k].handle for k in own),
            paths[own[0]].layer,
            shapely.union_all([lines[k] for k in own]),
            tuple(paths[k] for k in own),
        )
        for own in members
        if own
    ]


def _line(path: Entity) -> Any:
    import shapely

    edges = edges_of(path)
    corners = [corner for edge in edges for corner in edge.points()] + ([edges[-1].end] if edges else [])
    return shapely.LineString(corners) if len(corners) > 1 else shapely.Point(path.points[0, :2])


class Fitted(NamedTuple):
    """An opening in its wall."""

    wall: int
    at: float
    width: float
    across: tuple[float, float]  # its extent across the wall, from the axis to the left [m]


def fit(one: Drawn, walls: Sequence[WallAxis]) -> Fitted | None:
    """The wall that a drawn opening lies in and its extent along it, or None."""
    for distance in (TOUCHING, NEAR):
        best: Fitted | None = None
        for k, wall in enumerate(walls):
            clip = one.shape.intersection(wall.ground(distance))
            if clip.is_empty:
                continue
            corners = _coordinates(clip)
            along = [wall.along(corner) for corner in corners]
            width = max(along) - min(along)
            if width > NARROWEST and (best is None or width > best.width):
                best = Fitted(k, 0.5 * (max(along) + min(along)), width, _across(wall, corners))
        if best is not None:
            return best
    return None


def _coordinates(shape: Any) -> np.ndarray:
    import shapely

    return shapely.get_coordinates(shape)


def _across(wall: WallAxis, corners: np.ndarray) -> tuple[float, float]:
    import shapely

    line = wall.line
    out = []
    for corner in corners:
        s = line.project(shapely.Point(corner))
        a, b = (np.array(line.interpolate(x).coords[0]) for x in (max(0.0, s - 1e-3), min(line.length, s + 1e-3)))
        d, to = (b - a) / math.dist(a, b), corner - 0.5 * (a + b)
        out.append(float(d[0] * to[1] - d[1] * to[0]))
    return min(out), max(out)


def neighbour_of(text: Entity, read: Marks, things: Sequence[Drawn], taken: Mapping[str, Sequence[str]]) -> Drawn | None:
    """The thing that a text belongs to: the nearest; of several over one another that one which it fits, and that has none yet.

    Args:
        text: that stands next to it.
        read: what it says.
        things: of one kind.
        taken: texts that things have, by their first handle.
    """
    line = text.line
    apart = [one.distance(line) for one in things]
    nearest = min(range(len(things)), key=lambda k: apart[k], default=None)
    if nearest is None or apart[nearest] > READ_AT:
        return None
    place = things[nearest].shape.convex_hull
    over = [k for k, one in enumerate(things) if apart[k] < apart[nearest] + STACKED and one.shape.convex_hull.intersects(place)]
    layered = any(things[k].layer == text.layer for k in over)

    def misfit(k: int) -> tuple[bool, bool, bool, bool, int, float]:
        own = marks.read("\n".join(things[k].attributes)).numbers
        width = float(np.ptp(_coordinates(things[k].shape), axis=0).max())
        said = read.numbers | ({} if read.pair is None else _with_pair(read, width))
        return (
            any(abs(own[key] - said[key]) > ALIKE for key in own.keys() & said.keys()),
            layered and things[k].layer != text.layer,
            {"height", "sill"} <= own.keys(),
            read.pair is not None and min(abs(value - width) for value in read.pair) > _near(width),
            len(taken.get(things[k].handles[0], ())),
            apart[k],
        )

    return things[min(over, key=misfit)]


def opening_tables(fitted: Fitted, one: Drawn, texts: Sequence[str], thickness: float) -> tuple[list[dict[str, Any]], list[str], list[str]]:
    """The openings that a drawn one stands for, one above the other where its text has several parts.

    Args:
        fitted: where it lies.
        one: as drawn; the attributes of its insert come before texts, the name of the insert and its layer after them.
        texts: next to it; parts between semicolons are openings one above the other.
        thickness: of the wall [m].

    Returns:
        their tables, what was taken for granted, and what texts or attributes say that is not taken.
    """
    groups: list[list[str]] = [[]]
    for part in (part for text in texts for part in text.split(";") if part.strip()):
        read = marks.read(part)
        whole = read.pair or ("sill" in read.numbers and (read.shape or {"height", "width"} & set(read.numbers)))
        if whole and groups[-1]:
            groups.append([])
        groups[-1].append(part)
    attributes = "\n".join(one.attributes) if len(groups) == 1 else ""  # which are of one opening
    named = "\n".join([*one.text.splitlines()[:1], *([] if attributes else one.attributes), one.layer])
    tables, assumed, dropped = [], [], []
    for group in groups:
        said = [text for text in (attributes, *group) if text]
        table, more = _opening_table(fitted, [marks.read(text) for text in said], marks.read(named), thickness)
        tables.append(table)
        assumed += more
        dropped += [line for text in said for line in _not_taken(text, fitted.width, table)]
    return tables, assumed, dropped


def _not_taken(text: str, width: float, table: Mapping[str, Any]) -> list[str]:
    """Return the words on an opening that a text has, other than its table."""
    read = marks.read(text)
    numbers = _with_pair(read, width)
    pair = {} if read.pair is None or "sill" not in read.numbers else {"width": read.pair[0]}
    differ = [
        f"{key} {value:g} m, where {table[key]:g} m is taken"
        for key, value in (pair | numbers).items()
        if key in ("width", "height", "sill", "rise")
        and key in table
        and abs(table[key] - value) > (_near(width) if key in pair else ALIKE)
    ]
    return [f'"{" ".join(text.split())[:40]}" says {said}' for said in differ]


def _opening_table(fitted: Fitted, adjacent: Sequence[Marks], own: Marks, thickness: float) -> tuple[dict[str, Any], list[str]]:
    every = [*adjacent, own]
    numbers: dict[str, float] = {}
    for read in reversed(every):
        numbers |= _with_pair(read, fitted.width)
    shape = next((read.shape for read in every if read.shape), "rectangular")
    kind = next((read.kind for read in every if read.kind), "")
    name = next((read.name for read in adjacent if read.name and not read.kind), "")
    assumed = []
    if "sill" not in numbers and kind == "window":
        numbers["sill"] = SILL
        assumed.append(f"sill {SILL:g} m")
    if "height" not in numbers and shape != "rose":
        numbers["height"] = WINDOW if numbers.get("sill") else DOOR
        assumed.append(f"height {numbers['height']:g} m")
    table: dict[str, Any] = {"name": name} if name else {}
    table |= {
        "shape": shape,
        "at": _rounded(fitted.at),
        "width": numbers.get("width", _rounded(fitted.width)),
        "sill": numbers.get("sill", 0.0),
    }
    table |= {key: numbers[key] for key in ("height", "rise", "ring") if key in numbers and not (key == "height" and shape == "rose")}
    if shape == "niche":
        table["depth"] = numbers.get("depth", _rounded(min(fitted.across[1] - fitted.across[0], 0.7 * thickness)))
        table["side"] = "left" if sum(fitted.across) > 0.0 else "right"
    return table, assumed


def _with_pair(read: Marks, width: float) -> dict[str, float]:
    """The numbers of marks, a pair among them: the one of the two that is the width as drawn is not a height."""
    if read.pair is None:
        return read.numbers
    a, b = read.pair
    near = _near(width)
    if "sill" in read.numbers:  # so that the pair is none of height and sill: a width and a height, in this order unless the drawing has it
        return read.numbers | {"height": a if abs(b - width) < near <= abs(a - width) else b}
    if abs(b - width) < near and abs(a - width) >= near:
        return read.numbers | {"height": a}
    if abs(a - width) < near:
        return read.numbers | {"height": b}
    return read.numbers | {"height": a, "sill": b}


def _near(width: float) -> float:
    """Return the tolerance on a width that a text gives against the one that is drawn [m]."""
    return max(0.06, 0.08 * width)


def _rounded(value: float) -> float:
    return round(float(value), 4)


def vault_table(one: Drawn, texts: Sequence[Marks]) -> dict[str, Any] | str:
    """The table of a vault whose bay is drawn, by its outline or its diagonals; or what it lacks."""
    numbers: dict[str, float] = {}
    for read in texts:
        numbers |= read.numbers
    shape = next((read.vault for read in texts if read.vault), "barrel" if one.shape.geom_type == "Polygon" else "cross")
    if "springing" not in numbers and "level" not in numbers:
        return "no text within 1.5 m says its springing, imp. 4.50"
    hull = one.shape.minimum_rotated_rectangle
    if hull.geom_type != "Polygon":
        return "it encloses no bay"
    corners = [[_rounded(x), _rounded(y)] for x, y in list(hull.exterior.coords)[:4]]
    name = next((read.name for read in texts if read.name and not read.vault), "")
    table: dict[str, Any] = {"name": name} if name else {}
    table |= {"shape": shape, "corners": corners, "springing": numbers.get("springing", numbers.get("level", 0.0))}
    return table | {key: numbers[key] for key in ("rise", "thickness") if key in numbers}


def column_table(one: Drawn, texts: Sequence[Marks], height: float | None) -> dict[str, Any] | str:
    """The table of a column or pier that is drawn; or what it lacks."""
    numbers: dict[str, float] = {}
    for read in texts:
        numbers |= read.numbers
    tall = numbers.get("height", height)
    if tall is None:
        return "no text within 1.5 m says its height, h=4.20"
    if one.shape.geom_type != "Polygon":
        return "its outline is not closed"
    centre, edges = np.array(one.shape.centroid.coords[0]), [edge for path in one.paths for edge in edges_of(path)]
    table: dict[str, Any] = {"at": [_rounded(x) for x in centre], "height": tall}
    if "base" in numbers:
        table["base"] = numbers["base"]
    return table | section(edges, centre, one.shape)


def section(edges: Sequence[Edge], centre: np.ndarray, shape: Any) -> dict[str, Any]:
    """Round or square, its size, and how it is turned [degrees]."""
    reach = np.hypot(*(np.concatenate([edge.points() for edge in edges]) - centre).T)
    if any(edge.centre is not None for edge in edges) or (len(edges) > 5 and np.ptp(reach) < 2.0 * ROUND * reach.mean()):
        return {"section": "round", "size": _rounded(2.0 * math.sqrt(shape.area / math.pi))}
    long = max(edges, key=lambda edge: edge.length)
    along = long.end - long.start
    angle = math.degrees(math.atan2(along[1], along[0])) % 90.0
    turned = 0.0 if min(angle, 90.0 - angle) < 0.01 else round(angle, 3)
    return {"section": "square", "size": _rounded(math.sqrt(shape.area))} | ({"turned": turned} if turned else {})
