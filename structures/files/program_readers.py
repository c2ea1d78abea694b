# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of other programs: COMPAS JSON and LMGC90 decks. Each runs in a child, see :mod:`structures.files.foreign`.

    COMPAS    every mesh or polyhedron within the file, by name; ``is_support`` of it or of the node around it, or, in assemblies of
              version 0, of its node next to it. Elements with features, which cut their geometry, are refused; frames of their own and
              shapes that are no meshes are counted
    LMGC90    BODIES.DAT: a RBDY3 with one POLYR or PLANx each, or a RBDY2 with one POLYG or JONCx, drawn out by a thickness; colour is the
              group. Next to it DRV_DOF.DAT (all velocities driven: a support) and BULK_BEHAV.DAT (densities). Bodies of other kinds, or
              moved from where they are written, are refused; so are turned ones in space

Sources: COMPAS 0.19, 1 and 2 documentation; LMGC90 user guide.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from structures.files.foreign import Faces, FileContents, FileShell, Refused
from structures.files.outlines import KEY, drawn_out, refuse_without_thickness
from structures.files.shells import shells

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?"
DRIVEN = {"RBDY3": 6, "RBDY2": 3}  # velocities of a rigid body
PLANAR = ("RBDY2",)
MOVED = 1e-9  # in units of the file, or radians: less is none
BOX = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # faces of corners x, y, z by bits 4, 2, 1
DEEPEST = 60
SHAPES = ("Box", "Sphere", "Cylinder", "Cone", "Torus", "Capsule", "Brep", "OCCBrep", "RhinoBrep", "Extrusion")  # of COMPAS: no meshes
FLATTENED = 1e-12  # determinant of a transformation that leaves no volume


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8-sig", errors="replace")


# --- COMPAS ---------------------------------------------------------------------------------------------------------------------------


def read_compas(path: Path) -> FileContents:
    """Every mesh and polyhedron of a COMPAS file.

    Raises:
        Refused: no JSON, no mesh in it, or a transformation that is none or whose meshes stand elsewhere in the file.
    """
    unread: Counter[str] = Counter()
    try:
        content = json.loads(_text(path))
        _count_unread(path, content, unread)
        pieces: list[FileShell] = []
        for name, support, matrix, mesh in _meshes(path, content, "", False, np.eye(4), 0):
            points, loops = _of_mesh(mesh)
            mirrored = np.linalg.det(matrix) < 0.0
            moved = points if np.array_equal(matrix, np.eye(4)) else points @ matrix[:3, :3].T + matrix[:3, 3]
            for points_of, faces in shells(moved, [loop[::-1] for loop in loops] if mirrored else loops):
                pieces.append(FileShell(len(pieces), name or f"b{len(pieces)}", points_of, faces, fixed=support))
    except (ValueError, KeyError, TypeError, IndexError, RecursionError):
        raise Refused(path.name, "not the vertices and faces of COMPAS meshes") from None
    if not pieces:
        raise Refused(path.name, "no mesh and no polyhedron of COMPAS in it")
    return FileContents(pieces, (), [f"{path.name}: {count} {what}" for what, count in unread.items()])


def _count_unread(path: Path, item: Any, unread: Counter[str], depth: int = 0) -> None:
    """Count what of a COMPAS file is geometry, or places it, and is not read.

    Raises:
        Refused: an element whose features would cut its geometry.
    """
    if depth > DEEPEST:
        raise ValueError("nested too deep")
    if isinstance(item, dict):
        kind = str(item.get("dtype", item.get("datatype", ""))).rpartition("/")[2]
        if kind in SHAPES:
            unread[f"{kind} not read; meshes and polyhedra are"] += 1
        if item.get("features") and ("geometry" in item or "transformation" in item):
            raise Refused(
                path.name, f'the element "{str(item.get("name", ""))[:40]}" has features, which are not read; write its model geometry'
            )
        if isinstance(item.get("frame"), dict) and kind not in SHAPES and not _is_world(item["frame"]):
            unread["elements with a frame of their own, which is not read: their meshes stand as they are written"] += 1
    for part in item.values() if isinstance(item, dict) else item if isinstance(item, list) else ():
        if isinstance(part, (dict, list)):
            _count_unread(path, part, unread, depth + 1)


def _is_world(frame: Mapping[str, Any]) -> bool:
    """Return True if a frame is that of the world: at the origin, along its axes."""
    data = frame.get("data", frame)
    given = [data.get(key, own) for key, own in (("point", [0, 0, 0]), ("xaxis", [1, 0, 0]), ("yaxis", [0, 1, 0]))]
    return bool(np.allclose(np.array(given, dtype=float), [[0, 0, 0], [1, 0, 0], [0, 1, 0]]))


def _meshes(path: Path, item: Any, name: str, support: bool, place: np.ndarray, depth: int) -> Iterator[tuple[str, bool, np.ndarray, Any]]:
    """Name, support, placing matrix (4, 4) and data of the meshes within an object, from the outside inwards."""
    if depth > DEEPEST:
        raise ValueError("nested too deep")
    if isinstance(item, list):
        for part in item:
            yield from _meshes(path, part, name, support, place, depth + 1)
    if not isinstance(item, dict):
        return
    item = with_supports(item)
    given = item.get("attributes")
    attributes: dict[str, Any] = given if isinstance(given, dict) else {}
    own = item.get("name") or attributes.get("name") or name
    support = bool(item.get("is_support", attributes.get("is_support", support)))
    own_place = _transformation(item, f'{path.name}: the element "{str(own)[:40]}"')
    place, found = place @ own_place, False
    if (isinstance(item.get("vertex"), dict) and isinstance(item.get("face"), dict)) or (
        isinstance(item.get("vertices"), list) and isinstance(item.get("faces"), list)
    ):
        yield str(own), support, place, item
        return
    for key, part in item.items():
        if key not in ("attributes", "transformation", "frame"):
            inner = str(own) if key in ("data", "value", "block", "geometry", "mesh") else ""
            for mesh in _meshes(path, part, inner or (str(key) if own == "node" else ""), support, place, depth + 1):
                found = True
                yield mesh
    if not found and not np.allclose(own_place, np.eye(4)):
        what = "moves others, which do not stand within it; write their model geometry"
        raise Refused(path.name, f'the element "{str(own)[:40]}" {what}')


def with_supports(item: Mapping[str, Any]) -> dict[str, Any]:
    """An object of COMPAS; of an assembly of version 0, whose nodes lie next to its blocks, with their notes on supports in the blocks."""
    blocks, nodes = item.get("blocks"), item.get("node", item.get("vertex"))
    if not (isinstance(blocks, dict) and isinstance(nodes, dict)):
        return dict(item)
    held = {key for key, node in nodes.items() if isinstance(node, dict) and node.get("is_support")}
    return {**item, "blocks": {key: {**mesh, "is_support": True} if key in held else mesh for key, mesh in blocks.items()}}


def _transformation(item: Mapping[str, Any], where: str) -> np.ndarray:
    """The matrix (4, 4) by which an element is placed in what it stands in.

    Raises:
        Refused: it is not an affine one, or flattens.
    """
    given = item.get("transformation")
    matrix = given.get("data", given).get("matrix") if isinstance(given, dict) else None
    if matrix is None:
        return np.eye(4)
    out = np.array(matrix, dtype=float)
    if (
        out.shape != (4, 4)
        or not np.isfinite(out).all()
        or not np.allclose(out[3], (0.0, 0.0, 0.0, 1.0))
        or not abs(np.linalg.det(out)) > FLATTENED
    ):
        raise Refused(where, "its transformation is not an affine matrix of 4 x 4")
    return out


def _of_mesh(mesh: Any) -> tuple[np.ndarray, list[list[int]]]:
    """Corners and faces of a mesh by keys, or of a polyhedron by places."""
    if "vertices" in mesh:
        return np.array(mesh["vertices"], dtype=float).reshape(-1, 3), [[int(i) for i in loop] for loop in mesh["faces"]]
    place = {str(key): k for k, key in enumerate(mesh["vertex"])}
    points = [[float(entry.get(axis, 0.0)) for axis in "xyz"] for entry in mesh["vertex"].values()]
    faces = [[place[str(key)] for key in (loop.values() if isinstance(loop, dict) else loop)] for loop in mesh["face"].values() if loop]
    return np.array(points).reshape(-1, 3), faces


# --- LMGC90 ---------------------------------------------------------------------------------------------------------------------------


def read_lmgc90(path: Path, up: str = "z", metres: float = 0.0, thickness: float = 0.0) -> FileContents:
    """The rigid bodies of a BODIES.DAT.

    Args:
        path: of the file.
        up: axis of the file that points upwards.
        metres: per unit of the file; 0 where the scene does not say it.
        thickness: of bodies in a plane [m]; 0 where the scene gives none.

    Raises:
        Refused: no rigid body, one without a node or of another contactor, numbers that do not fit; bodies in a plane without thickness.
    """
    density = _densities(path.parent / "BULK_BEHAV.DAT")
    driven = _driven(path.parent / "DRV_DOF.DAT")
    _refuse_moved(path.parent / "DOF.INI")
    whole = _text(path)
    if other := re.search(r"\$bdyty\s+(?!RBDY[23]\b)(\w+)\s+(\d+)", whole):
        raise Refused(path.name, f"{other[1]} {other[2]}: RBDY3 and RBDY2, the rigid bodies of LMGC90, are read alone")
    bodies = [*_bodies(whole)]
    planar = sum(body.kind in PLANAR for body in bodies)
    if planar and not thickness:
        refuse_without_thickness(path.name, planar, "RBDY2")
    if thickness and not planar:
        raise Refused(KEY, f"{path.name} has no RBDY2 that it would apply to; leave it out")
    pieces: list[FileShell] = []
    for kind, number, text in bodies:
        where = f"{path.name}: {kind} {number}"
        node = re.search(r"\$nodty(.*?)\$tacty", text, re.DOTALL)
        shape = re.search(r"\$tacty\s+(\w+)\s+\d+\s+color\s+(\S+)(.*)", text, re.DOTALL)
        if node is None or shape is None:
            raise Refused(where, "no node or no contactor")
        coordinates = _values(node[1], "coo")
        if len(coordinates) < 3:
            raise Refused(where, "no three coordinates of its node")
        if kind in PLANAR:
            points, faces = drawn_out(_outline(where, shape[1], shape[3], coordinates), thickness / (metres or 1.0), up)
        else:
            points, faces = _in_space(where, shape[1], shape[3], coordinates)
        behaviour = re.search(r"\bbehav\s+(\S+)", text)
        law = density.get(behaviour[1] if behaviour else "", 0.0)
        pieces.append(FileShell(len(pieces), f"{kind}_{number}", points, faces, shape[2], (kind, number) in driven.wholly, law))
    if not pieces:
        raise Refused(path.name, "no RBDY3 and no RBDY2, the rigid bodies of LMGC90")
    partly = [f"{path.name}: {len(driven.partly)} bodies are driven in some directions only, which is not read: they are free"]
    return FileContents(pieces, (), partly if driven.partly else [])


class _Body(NamedTuple):
    """A rigid body of a deck."""

    kind: str  # RBDY3 or RBDY2
    number: int
    text: str


class _Driven(NamedTuple):
    """Kinds and numbers of the bodies whose velocities are driven."""

    wholly: frozenset[tuple[str, int]] = frozenset()
    partly: frozenset[tuple[str, int]] = frozenset()


def _refuse_moved(path: Path) -> None:
    """Refuse bodies that a file of their degrees of freedom has away from where BODIES.DAT has them."""
    for kind, number, text in _bodies(_text(path)) if path.is_file() else ():
        moved = [float(value.upper().replace("D", "E")) for value in re.findall(rf"\bX\(\d\)\s*=\s*({NUMBER})", text)]
        if any(abs(value) > MOVED for value in moved):
            raise Refused(
                path.name, f"{kind} {number}: is moved from where BODIES.DAT has it, which is not read; write the bodies as they stand"
            )


def _bodies(text: str) -> Iterator[_Body]:
    """The rigid bodies of a text."""
    for part in text.split("$bdyty")[1:]:
        if match := re.match(r"\s+(RBDY[23])\s+(\d+)(.*)", part, re.DOTALL):
            yield _Body(match[1], int(match[2]), match[3])


def _values(text: str, key: str) -> list[float]:
    """The numbers ``coo1= 1.0D+00 coo2= ...`` of a text."""
    return [float(value.upper().replace("D", "E")) for value in re.findall(rf"\b{key}\d\s*=\s*({NUMBER})", text)]


def _refuse_several(where: str, text: str, kinds: str) -> None:
    if re.search(r"\bcolor\b", text):
        raise Refused(where, f"several contactors; one {kinds} is read")


def _outline(where: str, kind: str, text: str, node: Sequence[float]) -> np.ndarray:
    """Corners (n, 2) of a POLYG or of a JONCx, turned and placed by the node of its body."""
    _refuse_several(where, text, "POLYG or JONCx")
    axes = _values(text, "axe")[:2]
    if kind == "JONCx" and len(axes) == 2:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(axes)
    elif kind == "POLYG":
        values = _values(text, "coo")
        corners = np.array(values).reshape(-1, 2) if len(values) % 2 == 0 else np.zeros((0, 2))
        announced = re.search(r"nb_vertex\s*=\s*(\d+)", text)
        if announced is None or int(announced[1]) != len(corners) or len(corners) < 3:
            raise Refused(where, "not as many corners as it announces")
    else:
        raise Refused(where, f"a contactor {kind}; POLYG and JONCx with two axes are read")
    cos, sin = math.cos(node[2]), math.sin(node[2])
    return np.asarray(corners @ np.array([[cos, sin], [-sin, cos]]) + np.array(node[:2]))


def _in_space(where: str, kind: str, text: str, node: Sequence[float]) -> tuple[np.ndarray, Faces]:
    """Corners and triangles of a POLYR, or the box of a PLANx, placed by the node of its body."""
    if any(node[3:6]):
        raise Refused(where, "its node is turned by coo4 to coo6, which is not read; write its corners as they stand")
    _refuse_several(where, text, "POLYR or PLANx")
    points, faces = _contactor(where, kind, text)
    return points + np.array(node[:3]), faces


def _contactor(where: str, kind: str, text: str) -> tuple[np.ndarray, Faces]:
    """Corners about the node and triangles of a POLYR; the box of a PLANx."""
    if kind == "PLANx":
        axes = _values(text, "axe")[:3]
        if len(axes) < 3:
            raise Refused(where, "a PLANx without three axes")
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        return signs * np.array(axes), BOX
    if kind != "POLYR":
        raise Refused(where, f"a contactor {kind}; POLYR and PLANx are read")
    points = np.array(_values(text, "coo")).reshape(-1, 3) if len(_values(text, "coo")) % 3 == 0 else np.zeros((0, 3))
    corners = [int(value) - 1 for value in _values(text, "ver")]
    announced = [int(value) for value in re.findall(r"nb_(?:vertex|faces?)\s*=\s*(\d+)", text)]
    if len(announced) != 2 or announced != [len(points), len(corners) // 3] or len(corners) % 3:
        raise Refused(where, "not as many corners and faces as it announces")
    if corners and (min(corners) < 0 or max(corners) >= len(points)):
        raise Refused(where, "a face names a corner that does not exist")
    return points, tuple((corners[k], corners[k + 1], corners[k + 2]) for k in range(0, len(corners), 3))


def _driven(path: Path) -> _Driven:
    """Bodies all of whose velocities are driven, and those some of whose are."""
    if not path.is_file():
        return _Driven()
    driven = [(body.kind, body.number, len(set(re.findall(r"\bvlocy\s+(\d)", body.text)))) for body in _bodies(_text(path))]
    wholly = frozenset((kind, number) for kind, number, count in driven if count >= DRIVEN[kind])
    return _Driven(wholly, frozenset((kind, number) for kind, number, count in driven if 0 < count < DRIVEN[kind]))


def _densities(path: Path) -> dict[str, float]:
    """Behaviour -> density [kg/m3]."""
    if not path.is_file():
        return {}
    found = re.findall(rf"^\s*(\S+)\s+\S+\s+Umas\s*=\s*({NUMBER})", _text(path), re.MULTILINE)
    return {name: float(value.upper().replace("D", "E")) for name, value in found}
