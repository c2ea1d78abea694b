# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of other programs: DXF drawings, COMPAS JSON, LMGC90 decks, 3DEC decks. Each runs in a child, see :mod:`structures.files.foreign`.

    DXF       3DFACE: closed shells of a layer; polyface mesh: a block each. The layer is the group; $INSUNITS gives the unit
    COMPAS    every mesh or polyhedron within the file, by name; ``is_support`` of it or of the node around it
    LMGC90    BODIES.DAT: a RBDY3 with one POLYR or PLANx each; colour is the group. Beside it DRV_DOF.DAT (all six velocities driven: a
              support) and BULK_BEHAV.DAT (densities)
    3DEC      block create brick | prism | polyhedron, with ``group``; block fix range group | position

Sources: AutoCAD DXF reference; COMPAS 1 and 2 documentation; LMGC90 user guide; 3DEC 5 and 7 command reference.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.foreign import Answer, Faces, Piece, Refused
from structures.files.shells import shells

UNITS_DXF = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 14: 0.1}  # $INSUNITS -> metres
POLYFACE, CORNER, FACE = 64, 64, 128  # flags of POLYLINE and VERTEX
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?"
DRIVEN = 6  # velocities of a rigid body
BOX = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # faces of corners x, y, z by bits 4, 2, 1
DEEPEST = 60
FLATTENED = 1e-12  # determinant of a transformation that leaves no volume


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8-sig", errors="replace")


# --- DXF ------------------------------------------------------------------------------------------------------------------------------


def read_dxf(path: Path) -> Answer:
    """The blocks of a DXF in text; the figure is the metres of its unit, 0 where it states none.

    Raises:
        Refused: binary, no pairs of code and value, or no 3DFACE and no polyface mesh.
    """
    lines = _text(path).splitlines()
    try:
        pairs = [(int(code), value.strip()) for code, value in zip(lines[::2], lines[1::2], strict=False)]
    except ValueError:
        raise Refused(path.name, "not the codes and values of a DXF in text") from None
    if (0, "EOF") not in pairs[-1:]:
        raise Refused(path.name, "does not end with EOF, as a DXF does: cut short")
    faces: dict[str, list[np.ndarray]] = {}
    found: list[tuple[str, np.ndarray, list[list[int]]]] = []
    try:
        for kind, entity in _entities(pairs):
            if kind == "3DFACE":
                faces.setdefault(_first(entity, 8, "0"), []).append(_corners(entity))
            elif kind == "POLYFACE":
                found.append(_polyface(entity))
    except (ValueError, IndexError, KeyError):
        raise Refused(path.name, "a 3DFACE or a polyface mesh with codes that are no numbers, or with too few of them") from None
    for layer, loops in faces.items():
        ends = np.cumsum([len(loop) for loop in loops])
        found.append(
            (layer, np.concatenate(loops), [list(range(int(end) - len(loop), int(end))) for end, loop in zip(ends, loops, strict=True)])
        )
    pieces: list[Piece] = []
    for layer, points, loops_of in found:
        for points_of, own in shells(points, loops_of):
            pieces.append(Piece(len(pieces), f"b{len(pieces)}", points_of, own, layer))
    if not pieces:
        raise Refused(path.name, "no 3DFACE and no polyface mesh in it; lines, polylines and ACIS solids are not read")
    unit = next((int(b[1]) for a, b in pairwise(pairs) if a == (9, "$INSUNITS") and b[1].isdigit()), 0)
    return pieces, (UNITS_DXF.get(unit, 0.0),)


def _entities(pairs: Sequence[tuple[int, str]]) -> Iterator[tuple[str, list[tuple[int, str]]]]:
    """Entities and their pairs; a polyface mesh comes whole, with the pairs of its vertices, apart by their code 0."""
    starts = [k for k, (code, _) in enumerate(pairs) if code == 0]
    mesh: list[tuple[int, str]] | None = None
    for begin, end in zip(starts, [*starts[1:], len(pairs)], strict=True):
        kind, own = pairs[begin][1], list(pairs[begin + 1 : end])
        if kind == "POLYLINE":
            mesh = own if int(_first(own, 70, "0")) & POLYFACE else None
        elif kind == "VERTEX" and mesh is not None:
            mesh += [(0, "VERTEX"), *own]
        elif kind == "SEQEND" and mesh is not None:
            yield "POLYFACE", mesh
            mesh = None
        elif kind == "3DFACE":
            yield kind, own


def _first(entity: Sequence[tuple[int, str]], code: int, default: str) -> str:
    return next((value for own, value in entity if own == code), default)


def _corners(entity: Sequence[tuple[int, str]]) -> np.ndarray:
    """The three or four corners of a 3DFACE."""
    values = dict(entity)
    points = np.array([[float(values[code + k]) for code in (10, 20, 30)] for k in range(4) if 10 + k in values])
    kept = [0, *(k for k in range(1, len(points)) if (points[k] != points[k - 1]).any())]
    if len(kept) > 3 and (points[kept[-1]] == points[0]).all():
        kept.pop()
    if len(kept) < 3:
        raise ValueError("two corners")
    return np.asarray(points[kept])


def _polyface(entity: Sequence[tuple[int, str]]) -> tuple[str, np.ndarray, list[list[int]]]:
    """Layer, corners and faces of a polyface mesh."""
    starts = [k for k, pair in enumerate(entity) if pair == (0, "VERTEX")]
    points, loops = [], []
    for begin, end in zip(starts, [*starts[1:], len(entity)], strict=True):
        own = entity[begin + 1 : end]
        flag = int(_first(own, 70, "0"))
        if flag & FACE and not flag & CORNER:
            corners = [abs(int(value)) - 1 for code, value in own if code in (71, 72, 73, 74) and int(value) != 0]
            loops.append(corners)
        elif flag & FACE:
            points.append([float(_first(own, code, "0")) for code in (10, 20, 30)])
    return _first(entity, 8, "0"), np.array(points).reshape(-1, 3), [loop for loop in loops if len(loop) >= 3]


# --- COMPAS ---------------------------------------------------------------------------------------------------------------------------


def read_compas(path: Path) -> Answer:
    """Every mesh and polyhedron of a COMPAS file.

    Raises:
        Refused: no JSON, no mesh in it, or a transformation that is none or whose meshes stand elsewhere in the file.
    """
    try:
        content = json.loads(_text(path))
        pieces: list[Piece] = []
        for name, support, matrix, mesh in _meshes(path, content, "", False, np.eye(4), 0):
            points, loops = _of_mesh(mesh)
            mirrored = np.linalg.det(matrix) < 0.0
            moved = points if np.array_equal(matrix, np.eye(4)) else points @ matrix[:3, :3].T + matrix[:3, 3]
            for points_of, faces in shells(moved, [loop[::-1] for loop in loops] if mirrored else loops):
                pieces.append(Piece(len(pieces), name or f"b{len(pieces)}", points_of, faces, fixed=support))
    except (ValueError, KeyError, TypeError, IndexError, RecursionError):
        raise Refused(path.name, "not the vertices and faces of COMPAS meshes") from None
    if not pieces:
        raise Refused(path.name, "no mesh and no polyhedron of COMPAS in it")
    return _named_apart(pieces), ()


def _meshes(path: Path, item: Any, name: str, support: bool, place: np.ndarray, depth: int) -> Iterator[tuple[str, bool, np.ndarray, Any]]:
    """Name, support, placing matrix (4, 4) and data of the meshes within an object, from the outside inwards."""
    if depth > DEEPEST:
        raise ValueError("nested too deep")
    if isinstance(item, list):
        for part in item:
            yield from _meshes(path, part, name, support, place, depth + 1)
    if not isinstance(item, dict):
        return
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


def _transformation(item: Mapping[str, Any], where: str) -> np.ndarray:
    """The matrix (4, 4) by which an element is placed in what it stands in.

    Raises:
        Refused: it is no affine one, or flattens.
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
        raise Refused(where, "its transformation is no affine matrix of 4 x 4")
    return out


def _of_mesh(mesh: Any) -> tuple[np.ndarray, list[list[int]]]:
    """Corners and faces of a mesh by keys, or of a polyhedron by places."""
    if "vertices" in mesh:
        return np.array(mesh["vertices"], dtype=float).reshape(-1, 3), [[int(i) for i in loop] for loop in mesh["faces"]]
    place = {str(key): k for k, key in enumerate(mesh["vertex"])}
    points = [[float(entry.get(axis, 0.0)) for axis in "xyz"] for entry in mesh["vertex"].values()]
    faces = [[place[str(key)] for key in (loop.values() if isinstance(loop, dict) else loop)] for loop in mesh["face"].values() if loop]
    return np.array(points).reshape(-1, 3), faces


def _named_apart(pieces: Sequence[Piece]) -> list[Piece]:
    """Pieces of one name numbered, since the name of a block is its own."""
    count: dict[str, int] = {}
    for piece in pieces:
        count[piece.name] = count.get(piece.name, 0) + 1
    seen: dict[str, int] = {}
    made = []
    for piece in pieces:
        seen[piece.name] = seen.get(piece.name, 0) + 1
        made.append(piece._replace(name=piece.name if count[piece.name] == 1 else f"{piece.name}.{seen[piece.name] - 1}"))
    return made


# --- LMGC90 ---------------------------------------------------------------------------------------------------------------------------


def read_lmgc90(path: Path) -> Answer:
    """The rigid bodies of a BODIES.DAT.

    Raises:
        Refused: no rigid body in space, one without a node or of another contactor, numbers that do not fit.
    """
    density = _densities(path.parent / "BULK_BEHAV.DAT")
    driven = _driven(path.parent / "DRV_DOF.DAT")
    pieces: list[Piece] = []
    for number, text in _bodies(_text(path)):
        where = f"{path.name}: RBDY3 {number}"
        node = re.search(r"\$nodty(.*?)\$tacty", text, re.DOTALL)
        shape = re.search(r"\$tacty\s+(\w+)\s+\d+\s+color\s+(\S+)(.*)", text, re.DOTALL)
        if node is None or shape is None:
            raise Refused(where, "no node or no contactor")
        coordinates = _values(node[1], "coo")[:3]
        if len(coordinates) < 3:
            raise Refused(where, "no three coordinates of its node")
        behaviour = re.search(r"\bbehav\s+(\S+)", text)
        points, faces = _contactor(where, shape[1], shape[3])
        law = density.get(behaviour[1] if behaviour else "", 0.0)
        pieces.append(Piece(len(pieces), f"RBDY3_{number}", points + np.array(coordinates), faces, shape[2], number in driven, law))
    if not pieces:
        raise Refused(path.name, "no RBDY3, the rigid body of LMGC90 in space")
    return pieces, ()


def _bodies(text: str) -> Iterator[tuple[int, str]]:
    """Number and text of each rigid body in space."""
    for part in text.split("$bdyty")[1:]:
        if match := re.match(r"\s+RBDY3\s+(\d+)(.*)", part, re.DOTALL):
            yield int(match[1]), match[2]


def _values(text: str, key: str) -> list[float]:
    """The numbers ``coo1= 1.0D+00 coo2= ...`` of a text."""
    return [float(value.upper().replace("D", "E")) for value in re.findall(rf"\b{key}\d\s*=\s*({NUMBER})", text)]


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
    if re.search(r"\bcolor\b", text):
        raise Refused(where, "several contactors; one POLYR or PLANx is read")
    points = np.array(_values(text, "coo")).reshape(-1, 3) if len(_values(text, "coo")) % 3 == 0 else np.zeros((0, 3))
    corners = [int(value) - 1 for value in _values(text, "ver")]
    announced = [int(value) for value in re.findall(r"nb_(?:vertex|faces)\s*=\s*(\d+)", text)]
    if len(announced) != 2 or announced != [len(points), len(corners) // 3] or len(corners) % 3:
        raise Refused(where, "not as many corners and faces as it announces")
    if corners and (min(corners) < 0 or max(corners) >= len(points)):
        raise Refused(where, "a face names a corner that there is not")
    return points, tuple((corners[k], corners[k + 1], corners[k + 2]) for k in range(0, len(corners), 3))


def _driven(path: Path) -> set[int]:
    """Bodies all of whose velocities are driven."""
    if not path.is_file():
        return set()
    return {number for number, text in _bodies(_text(path)) if len(set(re.findall(r"\bvlocy\s+(\d)", text))) >= DRIVEN}


def _densities(path: Path) -> dict[str, float]:
    """Behaviour -> density [kg/m3]."""
    if not path.is_file():
        return {}
    found = re.findall(rf"^\s*(\S+)\s+\S+\s+Umas\s*=\s*({NUMBER})", _text(path), re.MULTILINE)
    return {name: float(value.upper().replace("D", "E")) for name, value in found}


# --- 3DEC -----------------------------------------------------------------------------------------------------------------------------


def read_3dec(path: Path) -> Answer:
    """The blocks that a deck creates by its commands; other commands are passed over.

    Raises:
        Refused: a block of another kind, numbers that do not fit, none at all.
    """
    text = re.sub(r"(?:\.\.\.|&)\s*\n", " ", _text(path))  # continued lines
    pieces: list[Piece] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split(";")[0].replace("(", " ").replace(")", " ").replace(",", " ").split()
        lower = [word.lower() for word in words]
        if lower[:2] == ["block", "create"] or lower[:1] == ["poly"]:
            kind, rest = (
                (lower[2:3] or [""])[0] if lower[0] == "block" else (lower[1:2] or [""])[0],
                words[3 if lower[0] == "block" else 2 :],
            )
            pieces.append(_created(f"{path.name}: line {number}", kind, rest, len(pieces)))
        elif lower[:2] == ["block", "fix"] or lower[:1] == ["fix"]:
            pieces = [piece._replace(fixed=piece.fixed or _in_range(piece, lower, words)) for piece in pieces]
    if not pieces:
        raise Refused(path.name, "no command block create in it")
    return pieces, ()


def _created(where: str, kind: str, words: Sequence[str], count: int) -> Piece:
    """The block of one command."""
    group = ""
    if kind not in ("brick", "prism", "polyhedron", "face", "reg"):
        raise Refused(where, f"a block {kind or 'of no kind'} that is not read; brick, prism and polyhedron are")
    if "group" in [word.lower() for word in words]:
        at = [word.lower() for word in words].index("group")
        group, words = " ".join(words[at + 1 : at + 2]).strip("'\""), [*words[:at], *words[at + 2 :]]
    sets: list[list[float]] = [[]]
    for word in words:
        if re.fullmatch(NUMBER, word):
            sets[-1].append(float(word.lower().replace("d", "e")))
        elif re.fullmatch(r"face(?:-?\d)?|a|b", word.lower()):
            sets.append([])
        else:
            raise Refused(where, f'"{word[:40]}" where numbers of a block belong')
    if kind == "brick" and len(sets[0]) == 6:
        low, high = np.array(sets[0][::2]), np.array(sets[0][1::2])
        points = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        return Piece(count, f"b{count}", points, BOX, group)
    loops = [np.array(one).reshape(-1, 3) for one in sets if one and len(one) % 3 == 0 and len(one) >= 9]
    if len(loops) != sum(map(bool, sets)):
        raise Refused(where, "a face has three corners or more, three coordinates each")
    if kind == "prism" and len(loops) == 2 and len(loops[0]) == len(loops[1]):
        near, far = loops
        n = len(near)
        loops = [near, far, *(np.array([near[k], near[(k + 1) % n], far[(k + 1) % n], far[k]]) for k in range(n))]
    elif kind in ("brick", "prism") or len(loops) < 4:
        raise Refused(where, "a brick has six numbers, a prism two faces of as many corners, a polyhedron four faces or more")
    return Piece(count, f"b{count}", *_outward(loops), group)


def _outward(loops: Sequence[np.ndarray]) -> tuple[np.ndarray, Faces]:
    """Corners and faces of a convex solid, each turned outwards."""
    centre = np.concatenate(loops).mean(axis=0)
    points, one = np.unique(np.concatenate(loops), axis=0, return_inverse=True)
    faces, at = [], 0
    for loop in loops:
        own = tuple(int(i) for i in one.ravel()[at : at + len(loop)])
        at += len(loop)
        area = np.cross(loop - loop[0], np.roll(loop, -1, axis=0) - loop[0]).sum(axis=0)
        faces.append(own if float(area @ (loop.mean(axis=0) - centre)) > 0.0 else own[::-1])
    return points, tuple(faces)


def _in_range(piece: Piece, lower: Sequence[str], words: Sequence[str]) -> bool:
    """Whether a block is in the range of a command: all blocks, a group, or between two coordinates of its centre."""
    if "range" not in lower:
        return True
    rest, names = list(lower[lower.index("range") + 1 :]), list(words[lower.index("range") + 1 :])
    centre = 0.5 * (piece.vertices.min(axis=0) + piece.vertices.max(axis=0))
    inside = bool(rest)
    while rest:
        if rest[0] == "group" and len(rest) > 1:
            inside &= piece.group == names[1].strip("'\"")
            rest, names = rest[2:], names[2:]
        elif (
            (axis := re.fullmatch(r"(?:position-)?([xyz])", rest[0])) and len(rest) > 2 and all(re.fullmatch(NUMBER, w) for w in rest[1:3])
        ):
            inside &= float(rest[1]) <= centre["xyz".index(axis[1])] <= float(rest[2])
            rest, names = rest[3:], names[3:]
        else:
            return False
    return inside
