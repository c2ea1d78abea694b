# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of two boxes, one upon the other and sharing its corners, in the formats of other programs, as their layouts are published."""

from __future__ import annotations

import json
import struct
import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np

from structures.geometry.prism import box

SIZES = (2.0, 1.0)  # [m3] of the boxes
SHAPES = [box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0)), box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))]


def _soup() -> tuple[np.ndarray, list[list[int]]]:
    """Corners and triangles of both."""
    points, loops, count = [], [], 0
    for vertices, faces in SHAPES:
        points.append(np.asarray(vertices, dtype=float))
        loops += [[face[0] + count, a + count, b + count] for face in faces for a, b in pairwise(face[1:])]
        count += len(vertices)
    return np.concatenate(points), loops


POINTS, LOOPS = _soup()
HALF = len(LOOPS) // 2


def off() -> str:
    return "\n".join(
        [
            "OFF # made",
            f"{len(POINTS)} {len(LOOPS)} 0",
            *(" ".join(map(str, p)) for p in POINTS),
            *(f"3 {a} {b} {c}" for a, b, c in LOOPS),
            "",
        ]
    )


def ply(binary: str = "") -> bytes:
    head = ["ply", f"format {binary or 'ascii'} 1.0", "comment made", f"element vertex {len(POINTS)}", "property double x",
            "property double y", "property double z",
            f"element face {len(LOOPS)}", "property list uchar int vertex_indices", "end_header", ""]  # fmt: skip
    if not binary:
        body = "\n".join([*(" ".join(map(str, p)) for p in POINTS), *(f"3 {a} {b} {c}" for a, b, c in LOOPS), ""]).encode()
    else:
        order = ">" if "big" in binary else "<"
        body = POINTS.astype(f"{order}f8").tobytes() + b"".join(struct.pack(f"{order}Biii", 3, *loop) for loop in LOOPS)
    return "\n".join(head).encode() + body


def gltf(path: Path, glb: bool = False) -> None:
    """Two nodes of one mesh each, y up; the second box by a translation of its node."""
    meshes, views, accessors, data = [], [], [], b""
    for k, own in enumerate((LOOPS[:HALF], LOOPS[HALF:])):
        points = POINTS[8 * k : 8 * k + 8][:, [0, 2, 1]] * [1.0, 1.0, -1.0] - [0.0, k, 0.0]  # z up to y up
        index = np.array(own) - 8 * k
        for blob, kind, width in ((points.astype("<f4").tobytes(), 5126, "VEC3"), (index.astype("<u2").tobytes(), 5123, "SCALAR")):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(blob)})
            count = len(points) if width == "VEC3" else index.size
            accessors.append({"bufferView": len(views) - 1, "componentType": kind, "count": count, "type": width})
            data += blob
        meshes.append({"primitives": [{"attributes": {"POSITION": 2 * k}, "indices": 2 * k + 1}]})
    scene = {"asset": {"version": "2.0"}, "nodes": [{"name": "lower", "mesh": 0}, {"name": "upper", "mesh": 1, "translation": [0, 1, 0]}],
             "meshes": meshes, "bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": len(data)}]}  # fmt: skip
    if not glb:
        scene["buffers"] = [{"byteLength": len(data), "uri": "boxes.bin"}]
        (path.parent / "boxes.bin").write_bytes(data)
        path.write_text(json.dumps(scene), encoding="utf-8")
        return
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)


def threemf(path: Path) -> None:
    objects = []
    for k, own in enumerate((LOOPS[:HALF], LOOPS[HALF:])):
        corners = "".join(f'<vertex x="{1e3 * x}" y="{1e3 * y}" z="{1e3 * z}"/>' for x, y, z in POINTS[8 * k : 8 * k + 8])
        triangles = "".join(f'<triangle v1="{a - 8 * k}" v2="{b - 8 * k}" v3="{c - 8 * k}"/>' for a, b, c in own)
        objects.append(
            f'<object id="{k + 1}" name="{("lower", "upper")[k]}"><mesh><vertices>{corners}</vertices>'
            f"<triangles>{triangles}</triangles></mesh></object>"
        )
    text = (
        '<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        + "".join(objects) + '</resources><build><item objectid="1"/><item objectid="2"/></build></model>'
    )  # fmt: skip
    with zipfile.ZipFile(path, "w") as whole:
        whole.writestr("3D/3dmodel.model", text)


def dxf(polyface: bool = False) -> str:
    pairs: list[tuple[int, object]] = [
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$INSUNITS"),
        (70, 6),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "ENTITIES"),
    ]
    if polyface:
        for k, (vertices, faces) in enumerate(SHAPES):
            pairs += [(0, "POLYLINE"), (8, ("lower", "upper")[k]), (66, 1), (70, 64)]
            for x, y, z in vertices:
                pairs += [(0, "VERTEX"), (8, "0"), (10, x), (20, y), (30, z), (70, 192)]
            for face in faces:
                pairs += [(0, "VERTEX"), (8, "0"), (10, 0), (20, 0), (30, 0), (70, 128), *((71 + i, c + 1) for i, c in enumerate(face))]
            pairs += [(0, "SEQEND")]
    else:
        for k, (vertices, faces) in enumerate(SHAPES):
            for face in faces:
                pairs += [(0, "3DFACE"), (8, ("lower", "upper")[k])]
                pairs += [(10 * (axis + 1) + i, vertices[corner][axis]) for i, corner in enumerate(face) for axis in range(3)]
    return "".join(f"{code}\n{value}\n" for code, value in [*pairs, (0, "ENDSEC"), (0, "EOF")])


def compas(assembly: bool = True) -> str:
    meshes = []
    for vertices, faces in SHAPES:
        data = {"vertex": {str(k): dict(zip("xyz", map(float, p), strict=True)) for k, p in enumerate(vertices)},
                "face": {str(k): list(face) for k, face in enumerate(faces)}}  # fmt: skip
        meshes.append({"dtype": "compas.datastructures/Mesh", "data": data})
    if not assembly:
        return json.dumps(meshes)
    nodes = {str(k): {"block": mesh, "is_support": k == 0} for k, mesh in enumerate(meshes)}
    return json.dumps({"dtype": "compas_assembly.datastructures/Assembly", "data": {"graph": {"data": {"node": nodes, "edge": {}}}}})


def compas_0(assembly: bool = True) -> str:
    """JSON of COMPAS before 0.16.5, which names no types, and of its assemblies: keys as texts, nodes next to the blocks."""
    meshes = []
    for vertices, faces in SHAPES:
        vertex = {repr(k): dict(zip("xyz", map(float, p), strict=True)) for k, p in enumerate(vertices)}
        face = {repr(k): [repr(i) for i in loop] for k, loop in enumerate(faces)}
        about = {"attributes": {"name": "Block"}, "dva": {"x": 0.0, "y": 0.0, "z": 0.0}, "dea": {}, "dfa": {}}
        meshes.append(about | {"vertex": vertex, "face": face, "facedata": {}, "edgedata": {}, "max_int_key": 7, "max_int_fkey": 5})
    if not assembly:
        return json.dumps(meshes[0])
    nodes = {repr(k): {"is_support": k == 0, "x": 0.0, "y": 0.0, "z": 0.0} for k in range(len(meshes))}
    blocks = {repr(k): mesh for k, mesh in enumerate(meshes)}
    return json.dumps(
        {"attributes": {"name": "Assembly"}, "dna": {"is_support": False}, "dea": {}, "node": nodes, "edge": {}, "blocks": blocks}
    )


def lmgc90(folder: Path) -> None:
    """BODIES.DAT, DRV_DOF.DAT and BULK_BEHAV.DAT; the lower box is a PLANx."""
    points = POINTS[8:] - [0.5, 0.5, 1.5]
    corners = "\n".join(" " * 29 + "  ".join(f"coo{i + 1}= {x: .7E}".replace("E", "D") for i, x in enumerate(p)) for p in points)
    triangles = "\n".join(" " * 29 + "  ".join(f"ver{i + 1}={c - 7:7d}" for i, c in enumerate(loop)) for loop in LOOPS[HALF:])
    body = """$bdyty
 RBDY3      {n}
$blmty
 PLAIN      1  behav  {law}  avrd= 0.0000000D+00  gyrd= 0.0000000D+00
$nodty
 NO6xx      1                coo1= {x: .7E}  coo2= 0.5000000D+00  coo3= {z: .7E}
                             coo4= 0.0000000D+00  coo5= 0.0000000D+00  coo6= 0.0000000D+00
$tacty
{shape}
$$$$$$
"""
    plane = " PLANx      1  color  BASEx  axe1= 0.1000000D+01  axe2= 0.5000000D+00  axe3= 0.5000000D+00"
    solid = f" POLYR      1  color  BLUEx  nb_vertex=      8    nb_faces=     12\n{corners}\n{triangles}"
    text = body.format(n=1, law="TDURx", x=1.0, z=0.5, shape=plane) + body.format(n=2, law="PDURx", x=0.5, z=1.5, shape=solid)
    (folder / "BODIES.DAT").write_text("! File BODIES\n" + text)
    driven = "\n".join(f" vlocy  {k}   0.0 0.0 0.0 0.0 0.0 0.0" for k in range(1, 7))
    (folder / "DRV_DOF.DAT").write_text(f"$bdyty\n RBDY3      1\n$nodty\n NO6xx      1\n$dofty\n{driven}\n$$$$$$\n")
    (folder / "BULK_BEHAV.DAT").write_text("$behav  lawty\n TDURx  RIGID  Umas= 2.500D+03\n$behav  lawty\n PDURx  RIGID  Umas= 1.900D+03\n")


def threedec() -> str:
    vertices, faces = SHAPES[1]
    loops = " ...\n".join("face " + " ".join("({:g},{:g},{:g})".format(*vertices[i]) for i in face) for face in faces)
    bricks = "model new\n; made\nblock create brick 0 2 0 1 0 1 group 'base'\n"
    return f"{bricks}block create polyhedron {loops} group \"stone\"\nblock fix range group 'base'\n"


PRISM = """block create brick 0 2 0 1 0 1
block create prism face-1 (0,0,1) (1,0,1) (1,0,2) (0,0,2) face-2 (0,1,1) (1,1,1) (1,1,2) (0,1,2)
block fix range position-z 0 1
"""


def vrml() -> str:
    """The upper box moved up to the lower one by a transformation."""
    shapes = []
    for (vertices, faces), name, up in zip(SHAPES, ("lower", "upper"), (0.0, 0.5), strict=True):
        points = ", ".join(" ".join(map(str, (x, y, z - up))) for x, y, z in vertices)
        index = ", ".join(f"{', '.join(map(str, face))}, -1" for face in faces)
        solid = f"Shape {{ geometry IndexedFaceSet {{ coord Coordinate {{ point [ {points} ] }} coordIndex [ {index} ] }} }}"
        shapes.append(f"DEF {name} Transform {{ translation 0 0 {up} children [ {solid} ] }}")
    return "#VRML V2.0 utf8\n" + "\n".join(shapes) + "\n"


def msh() -> str:
    """A hexahedron of gmsh (2.2) each, in two physical groups; the boxes share corners."""
    order = (0, 1, 3, 2, 4, 5, 7, 6)
    corners = [sorted(range(8), key=lambda k, own=vertices: (own[k][2], own[k][1], own[k][0])) for vertices, _ in SHAPES]
    nodes = [vertices[k] for (vertices, _), own in zip(SHAPES, corners, strict=True) for k in own]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "lower"', '3 2 "upper"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes)), *(f"{k + 1} {x} {y} {z}" for k, (x, y, z) in enumerate(nodes)), "$EndNodes", "$Elements", "2"]
    lines += [f"{k + 1} 5 2 {k + 1} {k + 1} " + " ".join(str(8 * k + i + 1) for i in order) for k in range(2)]
    return "\n".join([*lines, "$EndElements", ""])


def elevation() -> str:
    """Both boxes as closed polylines of a DXF."""
    pairs: list[tuple[int, object]] = [
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$ACADVER"),
        (1, "AC1015"),
        (9, "$INSUNITS"),
        (70, 6),
        (0, "ENDSEC"),
    ]
    pairs += [(0, "SECTION"), (2, "ENTITIES")]
    for k, (low, high) in enumerate((((0, 0), (2, 1)), ((0, 1), (1, 2)))):
        pairs += [(0, "LWPOLYLINE"), (5, f"A{k}"), (100, "AcDbEntity"), (8, ("lower", "upper")[k]), (100, "AcDbPolyline"), (90, 4), (70, 1)]
        for x, y in (low, (high[0], low[1]), high, (low[0], high[1])):
            pairs += [(10, float(x)), (20, float(y))]
    return "".join(f"{code}\n{value}\n" for code, value in [*pairs, (0, "ENDSEC"), (0, "EOF")])


SETS = """new
poly region 1 prism &
a (0,0,0) (2,0,0) (2,0,2) (0,0,2) b (0,1,0) (2,1,0) (2,1,2) (0,1,2)
jset dip 0 dd 0 spac 0.5 num 3 org 0 0 0.5
jset dip 90 dd 90 org 1 0 0
fix range z 0 0.5
"""
