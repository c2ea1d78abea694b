# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks to and from the data of COMPAS (compas.dev), as its JSON files hold them; the package itself is not needed.

COMPAS writes an object as ``{"dtype": "compas.datastructures/Mesh", "data": {...}}``; models of compas_dem, compas_assembly and the like
hold such meshes among their elements. What is read is every mesh, wherever it stands, by its vertices and faces.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.mechanics.model.blocks import Block
from structures.files.program_readers import with_supports

MESH = "compas.datastructures/Mesh"
SUPPORT = "is_support"  # attribute of what stands fast


def to_compas(blocks: Sequence[Block]) -> list[dict[str, Any]]:
    """Blocks as a list of meshes; ``json.dump`` writes what ``compas.json_load`` reads. Attributes: name, group, density, is_support.

    Raises:
        InputError: a sphere, which is not a mesh.
    """
    return [_mesh(block) for block in blocks]


def _mesh(block: Block) -> dict[str, Any]:
    if block.radius:
        raise InputError("to_compas", f'block "{block.name}" is a sphere, which is not a mesh')
    data = {
        "attributes": {"name": block.name, "group": block.group, "density": block.density, SUPPORT: block.fixed},
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "default_edge_attributes": {},
        "default_face_attributes": {},
        "vertex": {str(i): dict(zip("xyz", map(float, corner), strict=True)) for i, corner in enumerate(block.vertices)},
        "face": {str(i): [int(v) for v in loop] for i, loop in enumerate(block.faces)},
        "facedata": {},
        "edgedata": {},
        "max_vertex": len(block.vertices) - 1,
        "max_face": len(block.faces) - 1,
    }
    return {"dtype": MESH, "data": data, "name": block.name}


def from_compas(source: Any) -> list[dict[str, Any]]:
    """The meshes of COMPAS data as blocks for ``structure={"blocks": ...}``: dicts with name, vertices, faces, and what else they state.

    Args:
        source: a JSON file of COMPAS; its content, as ``json.load`` gives it; or objects of COMPAS themselves, which have ``__data__``.

    A mesh, or what holds it, that says ``is_support`` is fixed. Lengths are taken to be metres. Meshes without a name are called ``b0``,
    ``b1`` ... in their order, and a name that came before gets its number behind it.

    Raises:
        InputError: no file, no JSON, or no mesh in it.
    """
    where = "from_compas"
    if isinstance(source, str | os.PathLike):
        where = os.fspath(source)
        try:
            source = json.loads(read_text(Path(source)))
        except ValueError as failure:
            raise InputError(where, f"no JSON: {failure}") from None
    found: list[dict[str, Any]] = []
    names: set[str] = set()
    for i, (data, support) in enumerate(_meshes(source, False)):
        block = _block(data, support, i, where)
        if block["name"] in names:
            block["name"] = f"{block['name']}_{i}"
        names.add(block["name"])
        found.append(block)
    if not found:
        raise InputError(where, "no mesh of COMPAS is in it")
    return found


def _meshes(value: Any, support: bool) -> Iterator[tuple[Mapping[str, Any], bool]]:
    """The data of all meshes in a value, and whether they, or what holds them, stand fast."""
    value = getattr(value, "__data__", value)
    if isinstance(value, Mapping):
        value = with_supports(value)
        attributes = value.get("attributes")
        for table in (value, attributes, value.get("data")):
            if isinstance(table, Mapping) and SUPPORT in table:
                support = bool(table[SUPPORT])
        if isinstance(value.get("vertex"), Mapping) and isinstance(value.get("face"), Mapping):
            yield value, support
            return
        for item in value.values():
            yield from _meshes(item, support)
    elif isinstance(value, Sequence) and not isinstance(value, str | bytes):
        for item in value:
            yield from _meshes(item, support)


def _block(data: Mapping[str, Any], support: bool, index: int, where: str) -> dict[str, Any]:
    """The data of a mesh as a block."""
    attributes = data.get("attributes") or {}
    name = str(attributes.get("name") or f"b{index}")
    try:
        corners = {str(key): [float(corner[axis]) for axis in "xyz"] for key, corner in data["vertex"].items()}
        place = {key: i for i, key in enumerate(corners)}
        faces = [[place[str(vertex)] for vertex in loop] for loop in data["face"].values()]
    except (KeyError, TypeError, ValueError) as reason:
        raise InputError(where, f'mesh {index}, "{name}": its vertices and faces do not fit together ({reason!r})') from None
    made: dict[str, Any] = {"name": name, "vertices": list(corners.values()), "faces": faces, "fixed": support}
    for key, kind in (("group", str), ("density", float)):
        if attributes.get(key) is not None:
            made[key] = kind(attributes[key])
    return made
