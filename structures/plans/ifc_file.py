# SPDX-License-Identifier: GPL-3.0-or-later
"""Elements of a building model in IFC, by ifcopenshell (the optional extra ``ifc``), in a child process (:mod:`structures.files.foreign`).

Each wall, opening, column, slab and roof comes by its class, GlobalId, name, storey and, of an opening, its wall, with its corners and
triangles in metres in the world, z up, walls without their openings cut out. What has a shape and is of another class is counted. The unit
is that of the model. Source: ISO 16739-1 (IFC 4), IFC 2x3.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.extras import require
from structures.files.foreign import Faces, FileContents, Refused

WALLS, OPENINGS, COLUMNS, SLABS, ROOFS = "IfcWall", "IfcOpeningElement", "IfcColumn", "IfcSlab", "IfcRoof"
READ = (WALLS, OPENINGS, COLUMNS, SLABS, ROOFS)
PASSED = (
    "IfcSpatialElement",
    "IfcSpatialStructureElement",
    "IfcAnnotation",
    "IfcGrid",
    "IfcPort",
    "IfcVirtualElement",
)  # are no parts of it
FILLINGS = ("IfcDoor", "IfcWindow")  # of openings
MARK = b"ISO-10303-21"


class Shape(NamedTuple):
    """An element as it is read."""

    kind: str  # class of IFC
    guid: str
    name: str
    storey: str
    host: str  # of an opening, the wall's guid
    vertices: np.ndarray  # (V, 3) [m]
    faces: Faces  # triangles


def read(path: Path) -> FileContents:
    """The elements of a model.

    Raises:
        Refused: no IFC, or no wall in it.
    """
    require(f"{path.name}: IFC", "ifcopenshell")
    import ifcopenshell
    from ifcopenshell import geom

    if not path.read_bytes().lstrip().startswith(MARK):
        raise Refused(path.name, "is not an IFC file in STEP's text (ISO-10303-21); export it as .ifc")
    try:
        model = ifcopenshell.open(str(path))
    except Exception as failure:  # of ifcopenshell, of several kinds
        raise Refused(path.name, f"cannot be read as IFC: {(str(failure).splitlines() or [''])[0]}") from None
    settings: Any = geom.settings()
    for key, value in (("use-world-coords", True), ("disable-opening-subtractions", True), ("weld-vertices", True)):
        settings.set(key, value)
    unread: Counter[str] = Counter()
    shapes = [*_shapes(model, lambda element: geom.create_shape(settings, element), unread)]
    if not any(shape.kind == WALLS for shape in shapes):
        seen = f"; {', '.join(f'{count} {what}' for what, count in unread.items())}" if unread else ""
        raise Refused(path.name, f"no IfcWall with a shape in it{seen}")
    return FileContents(shapes, (), [f"{path.name}: {count} {what} not read" for what, count in sorted(unread.items())])


def _shapes(model: Any, shape_of: Any, unread: Counter[str]) -> Iterator[Shape]:
    """The elements that are read; others with a shape are counted."""
    for element in model.by_type("IfcProduct"):
        kind = next((kind for kind in READ if element.is_a(kind)), "")
        if not kind and (any(_is_of_class(element, other) for other in PASSED) or (any(map(element.is_a, FILLINGS)) and _fills(element))):
            continue
        if element.Representation is None:
            if kind in (WALLS, OPENINGS, COLUMNS):
                unread[f"{element.is_a()} without a shape"] += 1
            continue
        host = _host(element) if kind == OPENINGS else ""
        if not kind or (kind == OPENINGS and not host):
            unread[f"{element.is_a()}{' in what is not a wall' if kind else ''}"] += 1
            continue
        try:
            shape = shape_of(element).geometry
        except Exception:  # of the kernel: the shape is one that it cannot make
            unread[f"{element.is_a()} whose shape cannot be made ({element.GlobalId})"] += 1
            continue
        points = np.array(shape.verts, dtype=float).reshape(-1, 3)
        faces = tuple(tuple(map(int, face)) for face in np.array(shape.faces, dtype=int).reshape(-1, 3))
        if len(points):
            yield Shape(kind, str(element.GlobalId), str(element.Name or ""), _storey(element), host, points, faces)


def _is_of_class(element: Any, kind: str) -> bool:
    """True if an element is of a class, which its schema may not know."""
    try:
        return bool(element.is_a(kind))
    except RuntimeError:
        return False


def _fills(element: Any) -> bool:
    return bool(getattr(element, "FillsVoids", ()))


def _host(opening: Any) -> str:
    """The GlobalId of the wall that an opening is in; empty where it is in none."""
    for relation in getattr(opening, "VoidsElements", ()):
        if relation.RelatingBuildingElement.is_a(WALLS):
            return str(relation.RelatingBuildingElement.GlobalId)
    return ""


def _storey(element: Any) -> str:
    """The name of the storey that holds an element; empty where none does."""
    for relation in getattr(element, "ContainedInStructure", ()):
        return str(relation.RelatingStructure.Name or "")
    return ""
