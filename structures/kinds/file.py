# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures from a file: blocks in JSON (:mod:`structures.files.blockfile`) or closed shells (:mod:`structures.files.meshfile`)."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.model.blocks import Block, refuse_spheres
from structures import MadeStructure
from structures.files import blockfile, fillfile, meshfile
from structures.files.blockfile import METRES, sound
from structures.files.formats import CAD, endings, format_of
from structures.files.json_object import load
from structures.files.supports import HOW, Rules, with_supports
from structures.geometry.checks import Unsound, check, check_shells, deepest_overlap, refuse_corners
from structures.geometry.flatten import flattened
from structures.geometry.gaps import close_gaps
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.prism import box
from structures.geometry.warped_faces import in_triangles
from structures.kind import StructureKind
from structures.kinds.solid import SUFFIXES
from structures.schema import Height, Length, Table, Thickness

OUTLINED = ("dxf", "lmgc90")  # formats that may hold outlines of blocks


class FileTable(Table):
    """The [structure] table of a block file."""

    path: str
    """of the file of blocks, or of a folder of meshes, relative to the scene file"""
    units: Literal["m", "cm", "mm"] | None = None
    """unit of a mesh that does not state it, such as OBJ, STL or VTU"""
    up: Literal["y", "z"] | None = None
    """which axis of such a file points upwards"""
    fixed: Rules = ()
    """supports: names (* stands for anything), "ground" for what touches it, tables of below, box, group, name, or a list"""
    repair: bool = False
    """merge duplicate corners and correct the orientation of faces of such a file"""
    flatness: Height | None = None
    """faces this near to a plane are made flat; a thousandth of the block when not given"""
    chord: Length | None = None
    """how far flat facets may be off the curved faces of a STEP or BREP file, and straight sides off the arcs of outlines"""
    thickness: Thickness | None = None
    """of the blocks of an elevation, drawn as closed polylines of a DXF or as bodies of LMGC90 in a plane"""
    overlap: Length | None = None
    """blocks of any file may be this deep in each other; the depth is reported"""
    gaps: Length | None = None
    """close gaps up to this width between blocks of any file"""
    fill: str | None = None
    """a file with the fill of a bridge, as build writes it next to blocks in other formats; a block file holds its own"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> MadeStructure:
    """Read the blocks that a [structure] table names, and their fill; the notes say how far closing gaps has moved corners."""
    keys = parse_table(FileTable, table, "structure")
    blocks, notes = _read(keys, density, folder)
    content, source = _fill_of(keys, folder)
    blocks, fills = fillfile.with_fill(blocks, content, source, Path(keys.path).name)
    return MadeStructure(blocks, notes, (), fills)


def _fill_of(keys: FileTable, folder: Path) -> tuple[Mapping[str, Any], str]:
    """Return the fill that files give, and the name of the file that does."""
    path = Path(keys.path)
    is_own = format_of(folder / path) == "json"
    if keys.fill is None:
        return (blockfile.read_fill(folder / path), path.name) if is_own else ({}, path.name)
    if is_own:
        raise InputError("structure.fill", f"belongs to blocks in other formats; {path.name} holds its own")
    if not is_file(folder / keys.fill):
        raise InputError("structure.fill", f'no file "{keys.fill}" in {folder}')
    return load(folder / keys.fill, fillfile.FILLS), Path(keys.fill).name


def _read(keys: FileTable, density: float, folder: Path) -> tuple[list[Block], list[str]]:
    """The blocks, and lines on what was changed in them."""
    path = Path(keys.path)
    if not is_file(folder / path) and not os.path.isdir(folder / path):
        raise InputError("structure.path", f'no file "{path}"' + ("" if path.is_absolute() else f" in {folder}"))
    path = folder / path
    format_ = format_of(path)
    if format_ is None:
        raise InputError(
            "structure.path",
            f'{path.name} is not a file of blocks; kind = "file" reads {endings()}, and kind = "solid" {", ".join(SUFFIXES)}',
        )
    is_mesh = format_ != "json"
    for key in () if is_mesh else ("units", "up", "repair"):
        if key in keys.model_fields_set:
            raise InputError(f"structure.{key}", f"belongs to .obj, .stl, .vtu, .vtm files and other meshes; {path.name} states it itself")
    blocks, notes = _from_mesh(keys, path, density, format_) if is_mesh else (blockfile.read_unchecked(path, density), [])
    for block in blocks:
        refuse_corners(block, path.name)
    blocks = with_supports(blocks, keys.fixed, "structure.fixed", "base" if is_mesh else None)
    blocks, moved, uneven = flattened(blocks, keys.flatness)
    notes += [f"{path.name}: faces of {uneven} blocks made flat, corners moved by at most {length(moved)}"] if uneven else []
    if keys.repair:
        blocks, warped = in_triangles(blocks)
        notes += [f"{path.name}: {warped} warped faces cut into triangles"] if warped else []
    overlap = keys.overlap or 0.0
    if keys.gaps is not None:
        refuse_spheres(blocks, "structure.gaps", "closing gaps between faces")
        check_shells(blocks, path.name)
        try:
            blocks, moved, pairs = close_gaps(blocks, keys.gaps)
        except Unsound as failure:
            raise failure.under(path.name) from None
        notes.append(f"{path.name}: {pairs} pairs of faces brought together, corners moved by at most {moved:.3g} m")
    if is_mesh or keys.gaps is not None:
        blocks = sound(blocks, path.name, overlap)
    else:
        check(blocks, path.name, overlap)
        blocks = merge_coplanar(blocks)
    if overlap:
        depth, pairs = deepest_overlap(blocks)
        notes.append(
            f"{path.name}: {pairs} pairs of blocks overlap, by at most {length(depth)}" if pairs else f"{path.name}: no blocks overlap"
        )
    return blocks, notes


def _from_mesh(keys: FileTable, path: Path, density: float, format_: str) -> tuple[list[Block], list[str]]:
    """Read a mesh file whose unit and axes it states itself, or the table; not checked yet."""
    if keys.chord is not None and format_ not in (*CAD, "dxf"):
        raise InputError("structure.chord", f"belongs to files with curved faces or arcs, .step, .brep and .dxf; {path.name} is none")
    if keys.thickness is not None and format_ not in OUTLINED:
        raise InputError("structure.thickness", f"belongs to outlines, of .dxf files and of LMGC90 in a plane; {path.name} is none")
    loaded = meshfile.load(path, format_, **_asked_of_reader(keys, format_))
    stated = {"units": next((name for name, size in METRES.items() if size == loaded.metres), None), "up": loaded.up}
    notes = [*loaded.notes]
    for key, known in (("units", METRES), ("up", ("y", "z"))):
        asked, own = getattr(keys, key), stated[key]
        known_by_kind = loaded.metres if key == "units" else format_ in CAD  # of CAD models z is up, as where a solid is cut
        if asked is None and own is None and not known_by_kind:
            raise InputError(f"structure.{key}", f"missing; {path.name} does not say it, so take one of {', '.join(known)}")
        if None not in (asked, own) and asked != own:
            if loaded.firm:
                raise InputError(f"structure.{key}", f'"{asked}", but {path.name} says "{own}"; leave the key out')
            notes.append(f'{path.name}: {key} "{asked}" as the scene says, where the file has "{own}"')
    scale = METRES[keys.units] if keys.units else loaded.metres or 1.0
    return meshfile.blocks_of(loaded, path.name, density, scale, keys.up or loaded.up or "z", keys.repair), notes


def _asked_of_reader(keys: FileTable, format_: str) -> dict[str, Any]:
    """The keys of a scene that the reader of a format needs."""
    if format_ in CAD:
        return {"chord": None if keys.chord is None else keys.chord / METRES[keys.units or "m"]}
    if format_ not in OUTLINED:
        return {}
    return {
        "up": keys.up or "z",
        "metres": METRES[keys.units] if keys.units else 0.0,
        "thickness": keys.thickness or 0.0,
        **({"chord": keys.chord or 0.0} if format_ == "dxf" else {}),
    }


def _first_blocks() -> dict[str, str]:
    """A block file: two posts and a lintel on a base."""
    sizes = {
        "base": ((-3.0, -1.5, -0.5), (3.0, 1.5, 0.0)),
        "left": ((-1.6, -0.4, 0.0), (-0.8, 0.4, 2.4)),
        "right": ((0.8, -0.4, 0.0), (1.6, 0.4, 2.4)),
        "lintel": ((-1.8, -0.4, 2.4), (1.8, 0.4, 3.0)),
    }
    blocks = []
    for name, (low, high) in sizes.items():
        vertices, faces = box(low, high)
        plain = {"vertices": vertices.tolist(), "faces": [[int(i) for i in face] for face in faces]}
        blocks.append(json.dumps({"name": name, "fixed": name == "base", "group": name, **plain}))
    return {"blocks.json": '{"units": "m", "blocks": [\n' + ",\n".join(blocks) + "\n]}\n"}


KIND = StructureKind(
    build, FileTable, first={"path": "blocks.json"}, files=_first_blocks, own_densities=True, checks=True, grounded=False, unsupported=HOW
)
