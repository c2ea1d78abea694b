# SPDX-License-Identifier: GPL-3.0-or-later
"""Entities of a DXF, text or binary, by ezdxf: what stands in its model space, blocks taken apart, in world coordinates seen from above.

Runs in a child process with limits, see :mod:`structures.files.foreign`. Lines and arcs stay what they are, an arc as a bulge (the tangent
of a quarter of its angle); ellipses and splines become chords.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.drawing import DAMAGED, Shown, opened, sheets_line, shown
from structures.files.foreign import FileContents, Refused
from structures.plans.entities import INSERT, MOST_BULGE, OTHER, PATH, TEXT, Entity

MOST = 200_000  # entities of a plan: a drawing of a whole town has as many
LONGEST = 300  # characters of a text that are read: a mark has thirty
FARTHEST = 1e12  # of a place from the origin, in units of the file
LETTER = 0.8  # width of a letter over its height
CHORD = 1e-3  # of the extent of an ellipse or a spline, by which its chords may be off


def read(path: Path) -> FileContents:
    """The entities of a file, its code of units ($INSUNITS), and 1 where the file is damaged and was read as far as it could be.

    Raises:
        Refused: no DXF, or more than a plan has.
    """
    drawing, repaired = opened(path, repair=True)
    entities: list[Entity] = []
    for item in shown(drawing):
        entities += (own := _read_one(item))
        if any(one.kind == PATH and np.abs(one.points[:, 2]).max(initial=0.0) > MOST_BULGE for one in own):
            raise Refused(path.name, f"{item.kind} {item.handle} on layer {item.layer} has a bulge of more than {MOST_BULGE:g}")
        if len(entities) > MOST:
            raise Refused(path.name, f"more than {MOST} entities; keep those of one floor")
    units = drawing.header.get("$INSUNITS", 0)
    return FileContents(entities, [float(units) if isinstance(units, int) else 0.0, float(repaired)], sheets_line(drawing, path.name))


def _read_one(item: Shown) -> list[Entity]:
    """An entity of a file as one or more of ours; what is hidden or damaged as one that is not understood."""
    from ezdxf import DXFError

    if item.hidden or item.damage:
        return [_other(item, item.damage or item.hidden)]
    try:
        return list(_entities(item))
    except DAMAGED + (DXFError,) as failure:
        return [_other(item, f"damaged: {failure}")]


def _entities(item: Shown) -> Iterator[Entity]:
    """An entity of a file as one or more of ours."""
    one, handle, layer, owner, kind = item.entity, item.handle, item.layer, item.owner, item.kind
    read = PATHS.get(kind)
    if read:
        for points, closed, width in read(one):
            yield Entity(PATH, handle, kind, layer, _flat(points), "", closed, width, owner)
    elif kind in ("TEXT", "MTEXT", "ATTDEF"):
        text = one.plain_text() if kind != "ATTDEF" else ""
        yield Entity(TEXT, handle, kind, layer, _flat(_text_line(one, text)), _cut(text), owner=owner)
    elif kind == "INSERT":
        marks = [f"{attribute.dxf.tag}={attribute.dxf.text}" for attribute in one.attribs]
        place = _seen(one, one.dxf.insert)
        yield Entity(INSERT, handle, kind, layer, _flat([(place.x, place.y, 0.0)]), _cut("\n".join([one.dxf.name, *marks])), owner=owner)
    else:
        yield _other(item, "")


def _text_line(one: Any, text: str) -> list[tuple[float, float, float]]:
    """Start and end of a text's line, by the mean width of letters."""
    kind = one.dxftype()
    high = one.dxf.get("char_height" if kind == "MTEXT" else "height", 0.0)
    width = LETTER * high * one.dxf.get("width" if kind != "MTEXT" else "", 1.0) * max(map(len, text.splitlines() or [""]))
    if kind == "TEXT":
        align, place, _ = one.get_placement()
        share = {"C": 0.5, "R": 1.0}.get(align.name.rpartition("_")[2][:1], 0.0) if align.name != "LEFT" else 0.0
    else:
        place, share = one.dxf.insert, (one.dxf.get("attachment_point", 1) - 1) % 3 / 2.0 if kind == "MTEXT" else 0.0
    turn = math.radians(one.get_rotation() if kind == "MTEXT" else one.dxf.get("rotation", 0.0))
    along = (math.cos(turn), math.sin(turn), 0.0)
    ends = [_seen(one, place + type(place)(along) * (part * width)) for part in (-share, 1.0 - share)]
    return [(end.x, end.y, 0.0) for end in ends]


def _other(item: Shown, why: str) -> Entity:
    one = item.entity
    place = next((one.dxf.get(name) for name in ("insert", "start", "defpoint", "location", "center") if one.dxf.hasattr(name)), None)
    points = np.zeros((0, 3)) if place is None else np.array([[place.x, place.y, 0.0]])
    points = points if _are_places(points) else np.zeros((0, 3))
    return Entity(OTHER, item.handle, item.kind, item.layer, points, _cut(why), owner=item.owner)


def _cut(text: str) -> str:
    return text.replace("\0", " ")[:LONGEST]


def _flat(points: Sequence[Sequence[float]]) -> np.ndarray:
    """Points as an array (P, 3).

    Raises:
        ValueError: one is not a place.
    """
    out = np.array(points, dtype=float).reshape(-1, 3)
    if not _are_places(out):
        raise ValueError("places that are no numbers, or beyond all bounds")
    return out


def _are_places(points: np.ndarray) -> bool:
    """Return True if points are numbers, of a size that places have."""
    return bool((np.abs(points) < FARTHEST).all())


def _seen(one: Any, point: Any) -> Any:
    """A point of an entity's own system in that of the world."""
    return one.ocs().to_wcs(point) if one.dxf.hasattr("extrusion") else point


Read = Iterator[tuple[Sequence[Sequence[float]], bool, float]]  # points with bulges, closed, width


def _bulged(one: Any, points: Sequence[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Points with bulges as seen from above: a mirrored system turns the arcs round."""
    system = one.ocs()
    if not system.transform:
        return list(points)
    turn = -1.0 if one.dxf.extrusion.z < 0.0 else 1.0
    placed = [(system.to_wcs((x, y, one.dxf.get("elevation", 0.0) if one.dxftype() == "LWPOLYLINE" else 0.0)), b) for x, y, b in points]
    return [(place.x, place.y, turn * bulge) for place, bulge in placed]


def _lwpolyline(one: Any) -> Read:
    points = one.get_points("xyb")
    widths = [max(pair) for pair in one.get_points("se")]
    yield _bulged(one, points), bool(one.closed), float(one.dxf.get("const_width", 0.0) or (min(widths) if widths else 0.0))


def _polyline(one: Any) -> Read:
    if one.is_poly_face_mesh or one.is_polygon_mesh:
        raise ValueError("a mesh")
    points = [(*tuple(v.dxf.location)[:2], v.dxf.get("bulge", 0.0)) for v in one.vertices]
    if one.is_3d_polyline:
        yield points, bool(one.is_closed), 0.0
    else:
        yield _bulged(one, points), bool(one.is_closed), float(one.dxf.get("default_start_width", 0.0))


def _line(one: Any) -> Read:
    yield [(one.dxf.start.x, one.dxf.start.y, 0.0), (one.dxf.end.x, one.dxf.end.y, 0.0)], False, 0.0


def _arc(one: Any) -> Read:
    sweep = math.radians((one.dxf.end_angle - one.dxf.start_angle) % 360.0) or 2.0 * math.pi
    start, middle, end = (one.dxf.start_angle + share * math.degrees(sweep) for share in (0.0, 0.5, 1.0))
    bulge = math.tan(sweep / 8.0)  # of either half, so that none is more than half a circle
    places = [(*_on_circle(one.dxf.center, one.dxf.radius, angle), bulge) for angle in (start, middle, end)]
    yield _bulged(one, places), False, 0.0


def _circle(one: Any) -> Read:
    places = [(*_on_circle(one.dxf.center, one.dxf.radius, angle), 1.0) for angle in (0.0, 180.0)]
    yield _bulged(one, places), True, 0.0


def _on_circle(centre: Any, radius: float, angle: float) -> tuple[float, float]:
    return centre.x + radius * math.cos(math.radians(angle)), centre.y + radius * math.sin(math.radians(angle))


def _chords(one: Any) -> Read:
    from ezdxf import path

    for curve in path.make_path(one).sub_paths():
        yield from _flattened(curve)


def _flattened(curve: Any) -> Read:
    corners = curve.control_vertices()
    extent = float(np.ptp([tuple(p)[:2] for p in corners], axis=0).max()) if corners else 0.0
    points = [(p.x, p.y, 0.0) for p in curve.flattening(max(CHORD * extent, 1e-9), segments=4)]
    yield points, bool(curve.is_closed), 0.0


def _hatch(one: Any) -> Read:
    from ezdxf import path

    for boundary in one.paths:
        if hasattr(boundary, "vertices"):
            yield _bulged(one, [(x, y, b) for x, y, b in boundary.vertices]), True, 0.0
        elif all(edge.EDGE_TYPE in ("LineEdge", "ArcEdge") for edge in boundary.edges):
            yield _bulged(one, [corner for edge in boundary.edges for corner in _edge(edge)]), True, 0.0
        else:
            for points, _, _ in _flattened(path.from_hatch_boundary_path(boundary, one.ocs(), one.dxf.elevation.z)):
                yield points, True, 0.0


def _edge(edge: Any) -> list[tuple[float, float, float]]:
    """An edge of a hatch by its first corner and its bulge; an arc in two halves."""
    if edge.EDGE_TYPE == "LineEdge":
        return [(edge.start.x, edge.start.y, 0.0)]
    sweep = math.radians((edge.end_angle - edge.start_angle) % 360.0) or 2.0 * math.pi
    angles = [edge.start_angle, edge.start_angle + math.degrees(sweep) / 2.0]
    bulge = math.tan(sweep / 8.0)
    if not edge.ccw:
        angles, bulge = [edge.end_angle, edge.end_angle - math.degrees(sweep) / 2.0], -bulge
    return [(*_on_circle(edge.center, edge.radius, angle), bulge) for angle in angles]


def _corners(one: Any) -> Read:
    points = one.wcs_vertices()
    yield [(p.x, p.y, 0.0) for p in points], True, 0.0


PATHS = {
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _chords,
    "SPLINE": _chords,
    "HATCH": _hatch,
    "SOLID": _corners,
    "TRACE": _corners,
    "3DFACE": _corners,
}
