# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of a 3MF, in a child process (:mod:`structures.files.foreign`): its objects as often as its build places them, by their names.

It states its unit, and z is up. Shapes that are no meshes, objects in other parts of the package and required extensions are refused.
Source: 3MF core specification 1.3.
"""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree  # in a child, whose memory and time are limited

import numpy as np

from structures.files.foreign import FileContents, Refused
from structures.files.surface_readers import pieces_of

UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
RELATIONSHIPS = "_rels/.rels"
LOOKS = ("/material/", "/production/", "/core/")  # within the names of extensions that leave shapes as they are
SHAPES = ("beamlattice", "booleans", "displacementmesh", "levelset", "volumetricstack")
DEEPEST = 50  # objects within objects


def read(path: Path) -> FileContents:
    """The objects of a 3MF, placed by its build; the figure is the metres of its unit.

    Raises:
        Refused: no model in it, or one that is no 3MF.
    """
    unread: Counter[str] = Counter()
    try:
        with zipfile.ZipFile(path) as whole:
            data = whole.read(_start_part(whole))
        root = ElementTree.fromstring(data)
        _refuse_extensions(path, root, data)
        objects = {item.get("id"): item for item in root.iter() if _tag(item) == "object"}
        used: set[str] = set()
        found = [
            made
            for item in root.iter()
            if _tag(item) == "item"
            for made in _object(path, objects, item, _place(item.get("transform")), used, 0)
        ]
    except (StopIteration, KeyError, ValueError, TypeError, zipfile.BadZipFile, ElementTree.ParseError):
        raise Refused(path.name, "not the objects and the build of a 3MF file") from None
    unit = root.get("unit", "millimeter")
    if unit not in UNITS:
        raise Refused(path.name, f'its unit "{unit[:40]}" is none of {", ".join(UNITS)}')
    left = sum(number not in used for number in objects)
    unread.update({"objects that its build does not place": left} if left else {})
    return FileContents(pieces_of(path, found), (UNITS[unit],), [f"{path.name}: {count} {what} not read" for what, count in unread.items()])


def _start_part(whole: zipfile.ZipFile) -> str:
    """The name of the model with which a package begins, by its relationships, or else the first there is."""
    names = whole.namelist()
    if RELATIONSHIPS in names:
        for item in ElementTree.fromstring(whole.read(RELATIONSHIPS)).iter():
            target = str(item.get("Target", "")).lstrip("/")
            if str(item.get("Type", "")).lower().endswith("3dmodel") and target in names:
                return target
    return next(name for name in names if name.lower().endswith(".model"))


def _refuse_extensions(path: Path, root: Any, data: bytes) -> None:
    """Refuse a file that needs an extension which would change its shapes; that is the rule of 3MF."""
    spaces = dict(found for _, found in ElementTree.iterparse(io.BytesIO(data), events=("start-ns",)))
    for prefix in root.get("requiredextensions", "").split():
        space = spaces.get(prefix, prefix)
        if not any(word in space for word in LOOKS):
            raise Refused(path.name, f"needs the extension {space[:80]} of 3MF, which is not read; write it without")


def _tag(item: Any) -> str:
    return str(item.tag).rpartition("}")[2]


def _place(text: str | None) -> np.ndarray:
    """The matrix (4, 3) of 3MF: rows times it, the last of them the translation."""
    return np.vstack([np.eye(3), np.zeros(3)]) if text is None else np.array(text.split(), dtype=float).reshape(4, 3)


def _object(
    path: Path, objects: Any, placed: Any, place: np.ndarray, used: set[str], depth: int
) -> Iterator[tuple[str, np.ndarray, list[list[int]]]]:
    """The meshes of the object that an item or a component places, and of those that it is made of.

    Raises:
        Refused: it stands in another part of the package, or has a shape besides its mesh.
    """
    if depth > DEEPEST:
        raise ValueError("nested too deep")
    number = placed.get("objectid")
    if any(key.rpartition("}")[2] == "path" for key in placed.attrib):
        raise Refused(path.name, f"object {number} is in another part of the package, which is not read; write one model")
    item = objects[number]
    used.add(number)
    name = item.get("name") or f"object{number}"
    if other := next((_tag(part) for part in item.iter() if _tag(part) in SHAPES), None):
        raise Refused(path.name, f'object "{name[:40]}": {other} is not read; write plain meshes')
    points = [[float(v.get(axis)) for axis in "xyz"] for v in item.iter() if _tag(v) == "vertex"]
    loops = [[int(t.get(f"v{k}")) for k in (1, 2, 3)] for t in item.iter() if _tag(t) == "triangle"]
    if points:
        turned = np.array(points) @ place[:3] + place[3]
        yield name, turned, loops if np.linalg.det(place[:3]) > 0.0 else [loop[::-1] for loop in loops]
    for part in (p for p in item.iter() if _tag(p) == "component"):
        inner = _place(part.get("transform"))
        both = np.vstack([inner[:3] @ place[:3], inner[3] @ place[:3] + place[3]])
        yield from _object(path, objects, part, both, used, depth + 1)
