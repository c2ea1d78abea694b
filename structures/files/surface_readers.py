# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of other programs: OFF, PLY, glTF and GLB, 3MF. Each runs in a child, see :mod:`structures.files.foreign`.

All are soups of polygons: a block is a closed shell of them, whether or not shells share corners (:mod:`structures.files.shells`). glTF
and 3MF name their objects. glTF is in metres with y up, 3MF states its unit; both are turned and scaled by the caller, by what the reader
says. Sources: OFF, Geomview manual; PLY, Turk 1994; glTF 2.0, Khronos; 3MF core specification 1.3.
"""

from __future__ import annotations

import base64
import json
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree  # in a child, whose memory and time are limited

import numpy as np

from structures.files.foreign import Answer, Piece, Refused
from structures.files.shells import shells

PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
GLTF_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
GLTF_WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES = 4  # glTF's mode
GLB = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
UNITS_3MF = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
DEEPEST = 50  # nodes within nodes


def pieces_of(path: Path, objects: Sequence[tuple[str, np.ndarray, Sequence[Sequence[int]]]]) -> list[Piece]:
    """A piece for each shell of named objects; the name is that of the object where it has one shell, numbered otherwise.

    Raises:
        Refused: no faces, or one that names a corner that there is not.
    """
    found: list[Piece] = []
    for name, vertices, loops in objects:
        try:
            made = shells(vertices, loops)
        except ValueError as failure:
            raise Refused(path.name, f"{failure}") from None
        for k, (points, faces) in enumerate(made):
            own = (name if len(made) == 1 else f"{name}.{k}") if name else f"b{len(found)}"
            found.append(Piece(len(found), own, points, faces))
    if not found:
        raise Refused(path.name, "no faces in it")
    return found


def read_off(path: Path) -> Answer:
    """The shells of an OFF file.

    Raises:
        Refused: another heading, fewer numbers than it announces.
    """
    words = " ".join(line.split("#")[0] for line in path.read_text(encoding="utf-8", errors="replace").splitlines()).split()
    if not words or not words[0].upper().endswith("OFF"):
        raise Refused(path.name, "does not begin with OFF")
    try:
        corners, faces = int(words[1]), int(words[2])
        if len(words) < 4 + 3 * corners or corners < 0 or faces < 0:
            raise IndexError
        points = np.array(words[4 : 4 + 3 * corners], dtype=float).reshape(-1, 3)
        at, loops = 4 + 3 * corners, []
        for _ in range(faces):
            size = int(words[at])
            loops.append([int(word) for word in words[at + 1 : at + 1 + size]])
            at += 1 + size
            if size < 3 or len(loops[-1]) < size:
                raise IndexError
    except (ValueError, IndexError):
        raise Refused(path.name, "not the counts, corners and faces of an OFF file; faces have no colours here") from None
    return pieces_of(path, [("", points, loops)]), ()


def read_ply(path: Path) -> Answer:
    """The shells of a PLY, in text or binary.

    Raises:
        Refused: a heading without corners or faces, fewer numbers than it announces.
    """
    head, _, body = path.read_bytes().partition(b"end_header")
    body = body.partition(b"\n")[2]
    lines = head.decode("latin-1").split("\n")
    if not lines[0].startswith("ply"):
        raise Refused(path.name, "does not begin with ply")
    order = next((word for line in lines if line.startswith("format") for word in line.split()[1:2]), "")
    elements = _elements(lines)
    try:
        rows = _text_rows(body, elements) if order == "ascii" else _binary_rows(body, elements, ">" if "big" in order else "<")
        points = np.array([[row[axis] for axis in "xyz"] for row in rows.get("vertex", [])], dtype=float).reshape(-1, 3)
        loops = [row[key] for row in rows.get("face", []) for key in row if key in ("vertex_indices", "vertex_index")]
    except (ValueError, IndexError, KeyError):
        raise Refused(path.name, "not the corners and faces that the heading of a PLY file announces") from None
    return pieces_of(path, [("", points, [[int(i) for i in loop] for loop in loops])]), ()


def _elements(lines: Sequence[str]) -> list[tuple[str, int, list[list[str]]]]:
    """Name, count and properties of the elements of a PLY."""
    found: list[tuple[str, int, list[list[str]]]] = []
    for line in lines:
        words = line.split()
        if words[:1] == ["element"]:
            found.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"] and found:
            found[-1][2].append(words[1:])
    return found


def _text_rows(body: bytes, elements: Sequence[tuple[str, int, list[list[str]]]]) -> dict[str, list[dict[str, Any]]]:
    """The rows of the elements of a text."""
    words = iter(body.decode("latin-1").split())
    made: dict[str, list[dict[str, Any]]] = {}
    for name, count, properties in elements:
        rows = made.setdefault(name, [])
        for _ in range(count):
            row: dict[str, Any] = {}
            for words_of in properties:
                listed = words_of[0] == "list"
                taken = [float(_word(words)) for _ in range(int(_word(words)) if listed else 1)]
                row[words_of[-1]] = taken if listed else taken[0]
            rows.append(row)
    return made


def _word(words: Iterator[str]) -> str:
    word = next(words, None)
    if word is None:
        raise IndexError
    return word


def _binary_rows(body: bytes, elements: Sequence[tuple[str, int, list[list[str]]]], order: str) -> dict[str, list[dict[str, Any]]]:
    """The rows of the elements of binary data."""
    made: dict[str, list[dict[str, Any]]] = {}
    at = 0

    def take(kind: str, count: int) -> np.ndarray:
        nonlocal at
        one = np.dtype(order + PLY_TYPES[kind])
        if count < 0 or at + count * one.itemsize > len(body):
            raise IndexError
        values = np.frombuffer(body, one, count, at)
        at += count * one.itemsize
        return values

    for name, count, properties in elements:
        rows = made.setdefault(name, [])
        for _ in range(count):
            row: dict[str, Any] = {}
            for words in properties:
                if words[0] == "list":
                    row[words[3]] = take(words[2], int(take(words[1], 1)[0])).tolist()
                else:
                    row[words[1]] = float(take(words[0], 1)[0])
            rows.append(row)
    return made


def read_gltf(path: Path) -> Answer:
    """The shells of the meshes of a glTF or GLB, placed by its nodes and named by them.

    Raises:
        Refused: no glTF 2, compressed or missing data.
    """
    data, binary = path.read_bytes(), b""
    if data.startswith(GLB):
        data, binary = _chunks(data)
    try:
        scene = json.loads(data)
        found = [*_placed(path, scene, binary)]
    except (ValueError, KeyError, IndexError, TypeError, AttributeError):
        raise Refused(path.name, "not the nodes, meshes and accessors of a glTF 2.0 file, without compression") from None
    return pieces_of(path, found), ()


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """JSON and binary of a GLB."""
    at = 12
    parts: dict[int, bytes] = {}
    while at + 8 <= len(data):
        size, kind = (int(n) for n in np.frombuffer(data, "<u4", 2, at))
        parts.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    return parts.get(JSON_CHUNK, b""), parts.get(BINARY_CHUNK, b"")


def _placed(path: Path, scene: Any, binary: bytes) -> Iterator[tuple[str, np.ndarray, list[list[int]]]]:
    """The meshes of all nodes: name, corners in the scene, triangles."""
    nodes = scene.get("nodes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    roots = [k for k in range(len(nodes)) if k not in below]
    stack = [(k, np.eye(4), 0) for k in reversed(roots)]
    while stack:
        k, outer, depth = stack.pop()
        if depth > DEEPEST:
            raise ValueError("nested too deep")
        node = nodes[k]
        place = outer @ _matrix(node)
        stack += [(child, place, depth + 1) for child in reversed(node.get("children", []))]
        if "mesh" in node:
            mesh = scene["meshes"][node["mesh"]]
            points, loops = _mesh(path, scene, mesh, binary)
            turned = points @ place[:3, :3].T + place[:3, 3]
            flipped = float(np.linalg.det(place[:3, :3])) < 0.0
            yield str(node.get("name") or mesh.get("name") or ""), turned, [loop[::-1] for loop in loops] if flipped else loops


def _matrix(node: Any) -> np.ndarray:
    """The matrix of a node (4, 4), which glTF writes by columns, or as translation, rotation (x, y, z, w) and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    made = np.eye(4)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    made[:3, :3] = turn * np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=float)
    made[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return made


def _mesh(path: Path, scene: Any, mesh: Any, binary: bytes) -> tuple[np.ndarray, list[list[int]]]:
    """Corners and triangles of all primitives of a mesh."""
    points: list[np.ndarray] = []
    loops: list[list[int]] = []
    for primitive in mesh["primitives"]:
        if primitive.get("mode", TRIANGLES) != TRIANGLES:
            continue
        own = _accessor(path, scene, primitive["attributes"]["POSITION"], binary)
        index = _accessor(path, scene, primitive["indices"], binary).ravel() if "indices" in primitive else np.arange(len(own))
        before = sum(map(len, points))
        loops += (index.astype(np.int64).reshape(-1, 3) + before).tolist()
        points.append(own.astype(float))
    return (np.concatenate(points) if points else np.zeros((0, 3))), loops


def _accessor(path: Path, scene: Any, number: int, binary: bytes) -> np.ndarray:
    """The numbers of an accessor (n, width)."""
    accessor = scene["accessors"][number]
    view = scene["bufferViews"][accessor["bufferView"]]
    data = _buffer(path, scene["buffers"][view["buffer"]], binary)
    one, width = np.dtype(GLTF_TYPES[accessor["componentType"]]), GLTF_WIDTH[accessor["type"]]
    start, stride = view.get("byteOffset", 0) + accessor.get("byteOffset", 0), view.get("byteStride") or one.itemsize * width
    count = int(accessor["count"])
    if count < 0 or start < 0 or stride < one.itemsize * width or start + (count - 1) * stride + one.itemsize * width > len(data):
        raise ValueError("beyond the data")
    return np.ndarray((count, width), one, data, start, (stride, one.itemsize))


def _buffer(path: Path, buffer: Any, binary: bytes) -> bytes:
    """The bytes of a buffer: of the GLB itself, of a data URI, or of a file beside it."""
    uri = buffer.get("uri")
    if uri is None:
        return binary
    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2])
    beside = path.parent / Path(uri).name
    if Path(uri).name != uri or not beside.is_file():
        raise Refused(path.name, f'the file "{uri[:60]}" that it refers to is not beside it')
    return beside.read_bytes()


def read_3mf(path: Path) -> Answer:
    """The objects of a 3MF, placed by its build; the figure is the metres of its unit.

    Raises:
        Refused: no model in it, or one that is no 3MF.
    """
    try:
        with zipfile.ZipFile(path) as whole:
            name = next(name for name in whole.namelist() if name.lower().endswith(".model"))
            root = ElementTree.fromstring(whole.read(name))
        objects = {item.get("id"): item for item in root.iter() if _tag(item) == "object"}
        found = [
            made
            for item in root.iter()
            if _tag(item) == "item"
            for made in _object(objects, item.get("objectid"), _place(item.get("transform")), 0)
        ]
    except (StopIteration, KeyError, ValueError, TypeError, zipfile.BadZipFile, ElementTree.ParseError):
        raise Refused(path.name, "not the objects and the build of a 3MF file") from None
    return pieces_of(path, found), (UNITS_3MF.get(root.get("unit", "millimeter"), 1e-3),)


def _tag(item: Any) -> str:
    return str(item.tag).rpartition("}")[2]


def _place(text: str | None) -> np.ndarray:
    """The matrix (4, 3) of 3MF: rows times it, the last of them the translation."""
    return np.vstack([np.eye(3), np.zeros(3)]) if text is None else np.array(text.split(), dtype=float).reshape(4, 3)


def _object(objects: Any, number: str | None, place: np.ndarray, depth: int) -> Iterator[tuple[str, np.ndarray, list[list[int]]]]:
    """The meshes of an object, and of those that it is made of."""
    if depth > DEEPEST:
        raise ValueError("nested too deep")
    item = objects[number]
    points = [[float(v.get(axis)) for axis in "xyz"] for v in item.iter() if _tag(v) == "vertex"]
    loops = [[int(t.get(f"v{k}")) for k in (1, 2, 3)] for t in item.iter() if _tag(t) == "triangle"]
    if points:
        turned = np.array(points) @ place[:3] + place[3]
        yield item.get("name") or f"object{number}", turned, loops if np.linalg.det(place[:3]) > 0.0 else [loop[::-1] for loop in loops]
    for part in (p for p in item.iter() if _tag(p) == "component"):
        inner = _place(part.get("transform"))
        both = np.vstack([inner[:3] @ place[:3], inner[3] @ place[:3] + place[3]])
        yield from _object(objects, part.get("objectid"), both, depth + 1)
