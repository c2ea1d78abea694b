# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files of blocks are read, by their ending or by what they hold, and what is written.

An ending that is known decides. Any other file is taken for what its first bytes say it is; where they say nothing, the list is named.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NamedTuple

from masonry_cd.foundation.errors import InputError
from structures.files.mesh_readers import HEAD as STL_HEAD
from structures.files.mesh_readers import TRIANGLE

OLD_COMPAS = re.compile(rb'"(?:dva|dea|dna|max_int_key|vertex|halfedge)"\s*:')  # keys of its JSON before it named its types
LOOKED_AT = 4096  # bytes of a file of an unknown ending
PACKAGE = "structures.files."


class Format(NamedTuple):
    """A format of files of blocks."""

    endings: tuple[str, ...]
    about: str  # what is a block in it
    reader: str = ""  # module:function of the child process; empty for those that are read here
    written: bool = False


FORMATS = {
    "json": Format((".json",), "a block file; the only one that keeps everything", written=True),
    "obj": Format((".obj",), "an object a block; g, or else usemtl, is its group", f"{PACKAGE}objfile:read", written=True),
    "stl": Format((".stl",), "a closed shell a block, solids of a text apart", f"{PACKAGE}mesh_readers:read_stl", written=True),
    "ply": Format((".ply",), "a closed shell a block", f"{PACKAGE}surface_readers:read_ply"),
    "off": Format((".off",), "a closed shell a block", f"{PACKAGE}surface_readers:read_off"),
    "gltf": Format((".gltf", ".glb"), "a mesh of a node a block; metres, y up", f"{PACKAGE}gltf:read"),
    "3mf": Format((".3mf",), "an object of the build a block; states its unit, z up", f"{PACKAGE}threemf:read"),
    "vrml": Format((".wrl", ".vrml", ".wrz"), "a face set a block, as often as it is placed; metres, y up", f"{PACKAGE}vrml:read"),
    "vtu": Format(
        (".vtu",), "a volume cell a block, or those of one number in the array block", f"{PACKAGE}mesh_readers:read_vtu", written=True
    ),
    "vtp": Format((".vtp",), "a closed shell a block", f"{PACKAGE}mesh_readers:read_vtp"),
    "vtm": Format((".vtm",), "a data set a block", f"{PACKAGE}mesh_readers:read_vtm", written=True),
    "vtkhdf": Format((".vtkhdf",), "as VTU", f"{PACKAGE}mesh_readers:read_vtkhdf", written=True),
    "msh": Format((".msh",), "a volume of gmsh; its physical group is its group", f"{PACKAGE}mesh_readers:read_msh", written=True),
    "dxf": Format(
        (".dxf",),
        "3DFACEs: a closed shell of a layer; polyface mesh, mesh, closed polyline of a thickness: each a block; layers are groups",
        f"{PACKAGE}dxf_blocks:read",
    ),
    "compas": Format(
        (".compas",), "JSON of COMPAS: each mesh or polyhedron a block, is_support a support", f"{PACKAGE}program_readers:read_compas"
    ),
    "lmgc90": Format(
        (),
        "BODIES.DAT with DRV_DOF.DAT and BULK_BEHAV.DAT in its folder: POLYR, PLANx; POLYG, JONCx of a thickness",
        f"{PACKAGE}program_readers:read_lmgc90",
    ),
    "step": Format((".step", ".stp"), "a solid a block, by its label; states its unit", f"{PACKAGE}cad_solids:read"),
    "brep": Format((".brep",), "a solid a block", f"{PACKAGE}cad_solids:read"),
    "3dec": Format((".3ddat", ".3dec"), "block create brick, prism, polyhedron; joint sets; block fix range", f"{PACKAGE}decks_3dec:read"),
}
FOLDER = "folder"  # of meshes
FORMATS[FOLDER] = Format((), "a folder of meshes without a unit: a file a stone, by its name", f"{PACKAGE}stone_folder:read")
CAD = {"step": b"ISO-10303-21", "brep": b"DBRep_DrawableShape"}  # marks by which their content is known


def format_of(path: Path) -> str | None:
    """The name of a file's format; None where neither its ending nor its content says it.

    Raises:
        InputError: not readable.
    """
    if os.path.isdir(path):  # as Path.is_dir, and False of a name that is too long
        return FOLDER
    known = next((name for name, format_ in FORMATS.items() if path.suffix.lower() in format_.endings), None)
    if known not in (None, "json"):
        return known
    try:
        with path.open("rb") as file:
            head = file.read(LOOKED_AT)
        size = path.stat().st_size
    except OSError as failure:
        raise InputError("structure.path", f"{path.name}: cannot be read, {failure.strerror}") from None
    for name, mark in CAD.items():
        if mark in head[:200]:
            return name
    found = _by_content(head, size)
    return found if known is None or found == "compas" else known


def _by_content(head: bytes, size: int) -> str | None:
    """The format that the first bytes of a file speak of."""
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    lower = text.lower()
    lines = [line.strip() for line in lower.splitlines()]
    if text.startswith((b"{", b"[")):
        if b'"asset"' in head and b'"accessors"' in head:
            return "gltf"
        typed = (b'"dtype"' in head or b'"datatype"' in head) and b'"blocks"' not in head
        if typed or OLD_COMPAS.search(head):
            return "compas"
        return "json" if text.startswith(b"{") else None
    marks = ((b"glTF", "gltf"), (b"AutoCAD Binary DXF", "dxf"), (b"ply", "ply"), (b"\x89HDF", "vtkhdf"), (b"PK\x03\x04", "3mf"))
    if found := next((name for mark, name in marks if text.startswith(mark)), None):
        return found
    if lower.startswith((b"<?xml", b"<vtkfile")):
        kinds = ((b"unstructuredgrid", "vtu"), (b"polydata", "vtp"), (b"vtkmultiblockdataset", "vtm"))
        return next((name for mark, name in kinds if b'type="' + mark in lower), None)
    if text.startswith(b"#VRML"):
        return "vrml"
    if text.startswith(b"$MeshFormat"):
        return "msh"
    if b"$bdyty" in head:
        return "lmgc90"
    if lines[:1] and lines[0].split()[:1] in ([b"off"], [b"coff"], [b"noff"]):
        return "off"
    if lines[:2] in ([b"0", b"section"], [b"999", b""]) or (lines[:1] == [b"0"] and b"section" in lines[1:2]):
        return "dxf"
    if lower.startswith(b"solid") and b"facet" in lower:
        return "stl"
    if any(line.startswith((b"block create", b"poly brick", b"poly prism", b"poly face", b"poly reg")) for line in lines):
        return "3dec"
    if sum(line.startswith(b"v ") for line in lines) >= 3:
        return "obj"
    count = int.from_bytes(head[80:STL_HEAD], "little") if len(head) >= STL_HEAD else -1
    return "stl" if count > 0 and size == STL_HEAD + TRIANGLE * count else None


def listed() -> list[str]:
    """A line for each format: name, endings, what is a block in it, whether it is written, too."""
    rows = []
    for name, format_ in FORMATS.items():
        endings = ", ".join(format_.endings) or ("a folder" if name == FOLDER else "by content")
        rows.append(f"{name:7} {endings:14} {'read, written' if format_.written else 'read':13} {format_.about}")
    rows.append(f'{"solid":7} {".step .brep .geo":14} {"read":13} kind = "solid": a CAD model, cut into stones')
    rows.append(f"{'step':7} {'.step .brep':14} {'written':13} a solid a block, for CAD programs; .step keeps names and groups")
    return rows


def endings() -> str:
    """All endings, for a message."""
    return ", ".join(ending for format_ in FORMATS.values() for ending in format_.endings)
