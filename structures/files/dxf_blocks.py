# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of a DXF drawing, in a child process (:mod:`structures.files.foreign`).

3DFACEs: closed shells of a layer, within one insert; polyface meshes, meshes without smoothing and, given a thickness, closed polylines: a
block each. The layer is the group, $INSUNITS gives the unit. Inserts place their blocks as often as they stand there
(:mod:`structures.files.drawing`). ACIS solids would be blocks, too, and are refused; what else is drawn, and what is hidden, is counted.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.drawing import DAMAGED, Shown, opened, sheets_line, shown
from structures.files.foreign import FileContents, FileShell, Refused
from structures.files.outlines import KEY, drawn_out, refuse_without_thickness
from structures.files.shells import shells

UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 14: 0.1}  # $INSUNITS -> metres
BINARY = b"AutoCAD Binary DXF"
LAST = 64  # bytes among which the end of a text stands
ACIS = ("3DSOLID", "BODY")
READ = "3DFACEs, polyface meshes and meshes are"
OUTLINES = ("LWPOLYLINE", "POLYLINE")
Loops = list[list[int]]


def read(path: Path, up: str = "z", metres: float = 0.0, thickness: float = 0.0, chord: float = 0.0) -> FileContents:
    """The blocks of a DXF; the figure is the metres of its unit, 0 where it states none.

    Args:
        path: of the file.
        up: axis of the file that points upwards.
        metres: per unit of the file, where the scene says it; 0 for what the file states.
        thickness: of blocks drawn as closed polylines [m]; 0 where these are no blocks.
        chord: how far straight sides may be off the arcs of these [m]; 0 where they may have none.

    Raises:
        Refused: damaged, an ACIS solid, a face or an outline that cannot be read, or no block.
    """
    from ezdxf import DXFError

    _refuse_cut_short(path)
    drawing, _ = opened(path, repair=False)
    stated = UNITS.get(drawing.header.get("$INSUNITS", 0), 0.0)
    unit, outlines = metres or stated or 1.0, 0
    faces: dict[tuple[str, str], list[np.ndarray]] = {}  # loops by insert and layer
    whole: list[tuple[str, np.ndarray, Loops]] = []
    unread: Counter[str] = Counter()
    for item in shown(drawing):
        if item.hidden or item.damage:
            unread[f"{item.kind} on layer {item.layer}: {item.damage or item.hidden}"] += 1
            continue
        try:
            if item.kind == "3DFACE":
                faces.setdefault((item.owner, item.layer), []).append(_turned([_corners(item.entity)], item)[0])
            elif (mesh := _mesh(item.entity)) is not None:
                whole.append((item.layer, mesh[0], _turned(mesh[1], item)))
            elif item.kind in OUTLINES and _is_closed(item.entity):
                outlines += 1
                if thickness:
                    corners, sides = drawn_out(_outline(path, item, chord / unit), thickness / unit, up)
                    whole.append((item.layer, corners, [list(side) for side in sides]))
            elif item.kind in ACIS:
                raise Refused(
                    path.name, f"{item.kind} {item.handle} on layer {item.layer}: an ACIS solid; {READ} read, so save it as a mesh"
                )
            elif item.kind != "INSERT":
                unread[f"{item.kind} on layer {item.layer}"] += 1
        except DAMAGED + (DXFError,):
            raise Refused(path.name, f"{item.kind} {item.handle} on layer {item.layer}: not the corners and faces of one") from None
    for (_, layer), loops in faces.items():
        ends = np.cumsum([len(loop) for loop in loops])
        numbers = [list(range(int(end) - len(loop), int(end))) for end, loop in zip(ends, loops, strict=True)]
        whole.append((layer, np.concatenate(loops), numbers))
    pieces: list[FileShell] = []
    for layer, points, loops_of in whole:
        for corners, own in shells(points, loops_of):
            pieces.append(FileShell(len(pieces), f"b{len(pieces)}", corners, own, layer))
    if outlines and not thickness:
        if not pieces:
            refuse_without_thickness(path.name, outlines, f"closed polyline{'s' if outlines > 1 else ''}")
        unread["closed polylines, which are blocks where structure.thickness is given,"] = outlines
    if thickness and not outlines:
        raise Refused(KEY, f"{path.name} has no closed polyline that it would apply to; leave it out")
    notes = [f"{path.name}: {count} {what} not read" for what, count in unread.items()]
    if not pieces:
        seen = f"; {', '.join(f'{count} {what}' for what, count in list(unread.items())[:3])}" if unread else ""
        raise Refused(path.name, f"no 3DFACE and no polyface mesh in it; lines, polylines and ACIS solids are not read{seen}")
    return FileContents(pieces, (stated,), [*notes, *sheets_line(drawing, path.name)])


def _refuse_cut_short(path: Path) -> None:
    data = path.read_bytes()
    if not data.startswith(BINARY) and data[-LAST:].split()[-2:] != [b"0", b"EOF"]:
        raise Refused(path.name, "does not end with EOF, as a DXF does: cut short")


def _turned(loops: list[Any], item: Shown) -> list[Any]:
    """Loops as they are seen from outside: inserts that mirror turn them round."""
    return [loop[::-1] for loop in loops] if item.mirrored else loops


def _is_closed(polyline: Any) -> bool:
    """True if a polyline comes back to where it begins; meshes are none."""
    if polyline.dxftype() == "POLYLINE":
        if not (polyline.is_2d_polyline or polyline.is_3d_polyline):
            return False
        ends = [vertex.dxf.location for vertex in polyline.vertices]
    else:
        ends = [corner[:2] for corner in polyline.get_points()]
    return bool(len(ends) > 1 + (not polyline.has_arc) and (polyline.is_closed or tuple(ends[0]) == tuple(ends[-1])))


def _outline(path: Path, item: Shown, chord: float) -> np.ndarray:
    """The corners of a closed polyline in space (n, 3), its arcs as chords.

    Raises:
        Refused: arcs, and nothing says how far chords may be off.
    """
    from ezdxf.path import make_path

    line = make_path(item.entity)
    if line.has_curves and not chord:
        raise Refused(
            "structure.chord", f"missing; {item.kind} {item.handle} of {path.name} has arcs: say how far straight sides may be off"
        )
    return np.array([tuple(point) for point in (line.flattening(chord) if line.has_curves else line.control_vertices())], dtype=float)


def _corners(face: Any) -> np.ndarray:
    """The three or four corners of a 3DFACE (n, 3).

    Raises:
        ValueError: fewer, or no numbers.
    """
    points = np.array([tuple(face.dxf.get(f"vtx{k}")) for k in range(4) if face.dxf.hasattr(f"vtx{k}")], dtype=float).reshape(-1, 3)
    kept = [0, *(k for k in range(1, len(points)) if (points[k] != points[k - 1]).any())]
    if len(kept) > 3 and (points[kept[-1]] == points[0]).all():
        kept.pop()
    if len(kept) < 3:
        raise ValueError("two corners")
    return np.asarray(points[kept])


def _mesh(one: Any) -> tuple[np.ndarray, Loops] | None:
    """Corners (V, 3) and faces of a polyface mesh, or of a mesh without smoothing; None of anything else."""
    kind = one.dxftype()
    if kind == "POLYLINE" and one.is_poly_face_mesh:
        corners, faces = one.indexed_faces()
        points = [tuple(vertex.dxf.location) for vertex in corners]
        loops = [list(face.indices) for face in faces]
    elif kind == "MESH" and not one.dxf.get("subdivision_levels", 0):
        points, loops = [tuple(point) for point in one.vertices], [list(face) for face in one.faces]
    else:
        return None
    return np.array(points, dtype=float).reshape(-1, 3), [loop for loop in loops if len(loop) >= 3]
