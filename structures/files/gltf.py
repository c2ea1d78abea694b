# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of a glTF or GLB, in a child process (:mod:`structures.files.foreign`): the meshes of the nodes of its scene, by their names.

It is in metres with y up, by which the caller turns it. What bends a mesh or places it otherwise than by nodes, skins, morph targets and
instances, is refused, as is every extension that a file requires and that could change shapes. Libraries pass these by silently, and
read strips wrongly (trimesh 4). Source: glTF 2.0, Khronos.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.foreign import FileContents, Refused
from structures.files.surface_readers import pieces_of

TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES, STRIPS = 4, (5, 6)  # glTF's modes; points and lines are below
LOOKS = ("KHR_materials", "KHR_texture", "KHR_lights", "EXT_texture", "KHR_xmp", "KHR_mesh_quantization")  # leave shapes as they are
INSTANCES = "EXT_mesh_gpu_instancing"
GLB = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
DEEPEST = 50  # nodes within nodes


def read(path: Path) -> FileContents:
    """The shells of the meshes of a glTF or GLB, placed by its nodes and named by them.

    Raises:
        Refused: no glTF 2, compressed or missing data.
    """
    data, binary = path.read_bytes(), b""
    if data.startswith(GLB):
        data, binary = _chunks(data)
    unread: Counter[str] = Counter()
    try:
        scene = json.loads(data)
        _refuse_required(path, scene)
        found = [*_placed(path, scene, binary, unread)]
    except (ValueError, KeyError, IndexError, TypeError, AttributeError):
        raise Refused(path.name, "not the nodes, meshes and accessors of a glTF 2.0 file, without compression") from None
    return FileContents(pieces_of(path, found), (), [f"{path.name}: {count} {what} not read" for what, count in unread.items()])


def _refuse_required(path: Path, scene: Any) -> None:
    """Refuse a file that needs an extension which is not known, as compression is; that is the rule of glTF."""
    for name in scene.get("extensionsRequired", []):
        if not str(name).startswith(LOOKS):
            raise Refused(path.name, f"needs the extension {str(name)[:60]} of glTF, which is not read; write it without")


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """JSON and binary of a GLB."""
    at = 12
    parts: dict[int, bytes] = {}
    while at + 8 <= len(data):
        size, kind = (int(n) for n in np.frombuffer(data, "<u4", 2, at))
        parts.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    return parts.get(JSON_CHUNK, b""), parts.get(BINARY_CHUNK, b"")


def _placed(path: Path, scene: Any, binary: bytes, unread: Counter[str]) -> Iterator[tuple[str, np.ndarray, list[list[int]]]]:
    """The meshes of the nodes of the scene: name, corners in the scene, triangles; what is not read is counted.

    Raises:
        Refused: a node whose mesh is bent, or placed otherwise than by nodes.
    """
    nodes = scene.get("nodes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    roots = [k for k in range(len(nodes)) if k not in below]
    if scene.get("scenes"):
        roots = list(scene["scenes"][scene.get("scene", 0)].get("nodes", []))
    stack, seen = [(k, np.eye(4), 0) for k in reversed(roots)], set[int]()
    while stack:
        k, outer, depth = stack.pop()
        if depth > DEEPEST:
            raise ValueError("nested too deep")
        node = nodes[k]
        seen.add(k)
        place = outer @ _matrix(node)
        stack += [(child, place, depth + 1) for child in reversed(node.get("children", []))]
        if "mesh" in node:
            mesh = scene["meshes"][node["mesh"]]
            name = str(node.get("name") or mesh.get("name") or "")
            if (why := _bent(node, mesh)) is not None:
                raise Refused(path.name, f'node "{name[:40]}": {why} not read; apply it and write plain meshes')
            points, loops = _mesh(path, scene, mesh, binary, unread)
            turned = points @ place[:3, :3].T + place[:3, 3]
            flipped = float(np.linalg.det(place[:3, :3])) < 0.0
            yield name, turned, [loop[::-1] for loop in loops] if flipped else loops
    elsewhere = sum("mesh" in node for k, node in enumerate(nodes) if k not in seen)
    unread.update({"nodes with a mesh that are in no scene, or another one,": elsewhere} if elsewhere else {})


def _bent(node: Any, mesh: Any) -> str | None:
    """Return what changes the mesh of a node besides its matrix; None where nothing does."""
    if "skin" in node:
        return "a skin is"
    if INSTANCES in node.get("extensions", {}):
        return "its instances are"
    return "morph targets are" if any(node.get("weights", mesh.get("weights", ()))) else None


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


def _mesh(path: Path, scene: Any, mesh: Any, binary: bytes, unread: Counter[str]) -> tuple[np.ndarray, list[list[int]]]:
    """Corners and triangles of all primitives of a mesh."""
    points: list[np.ndarray] = []
    loops: list[list[int]] = []
    for primitive in mesh["primitives"]:
        mode = primitive.get("mode", TRIANGLES)
        if mode in STRIPS:
            raise Refused(path.name, "strips and fans of triangles are not read; write triangles")
        if mode != TRIANGLES:
            unread["primitives of points or lines"] += 1
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
    if "sparse" in accessor or accessor.get("normalized"):
        raise Refused(path.name, f"accessor {number} is sparse or normalised, which is not read; write plain numbers")
    view = scene["bufferViews"][accessor["bufferView"]]
    data = _buffer(path, scene["buffers"][view["buffer"]], binary)
    one, width = np.dtype(TYPES[accessor["componentType"]]), WIDTH[accessor["type"]]
    start, stride = view.get("byteOffset", 0) + accessor.get("byteOffset", 0), view.get("byteStride") or one.itemsize * width
    count = int(accessor["count"])
    if count < 0 or start < 0 or stride < one.itemsize * width or start + (count - 1) * stride + one.itemsize * width > len(data):
        raise ValueError("beyond the data")
    return np.ndarray((count, width), one, data, start, (stride, one.itemsize))


def _buffer(path: Path, buffer: Any, binary: bytes) -> bytes:
    """The bytes of a buffer: of the GLB itself, of a data URI, or of a file next to it."""
    uri = buffer.get("uri")
    if uri is None:
        return binary
    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2])
    neighbour = path.parent / Path(uri).name
    if Path(uri).name != uri or not neighbour.is_file():
        raise Refused(path.name, f'the file "{uri[:60]}" that it refers to is not next to it')
    return neighbour.read_bytes()
