# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of other programs: OFF and PLY. Each runs in a child, see :mod:`structures.files.foreign`.

Both are soups of polygons: a block is a closed shell of them, whether or not shells share corners (:mod:`structures.files.shells`).
Libraries read both, but lose faces of a text that is cut short silently (trimesh 4), or end at an element of edges (meshio 5).
Sources: OFF, Geomview manual; PLY, Turk 1994.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.foreign import FileContents, FileShell, Refused
from structures.files.shells import shells

PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
READ_PLY = ("vertex", "face")


def pieces_of(path: Path, objects: Sequence[tuple[str, np.ndarray, Sequence[Sequence[int]]]]) -> list[FileShell]:
    """A piece for each shell of named objects; the name is that of the object where it has one shell, numbered otherwise.

    Raises:
        Refused: no faces, or one that names a corner that there is not.
    """
    found: list[FileShell] = []
    for name, vertices, loops in objects:
        try:
            made = shells(vertices, loops)
        except ValueError as failure:
            raise Refused(path.name, f"{failure}") from None
        for k, (points, faces) in enumerate(made):
            own = (name if len(made) == 1 else f"{name}.{k}") if name else f"b{len(found)}"
            found.append(FileShell(len(found), own, points, faces))
    if not found:
        raise Refused(path.name, "no faces in it")
    return found


def read_off(path: Path) -> FileContents:
    """The shells of an OFF file.

    Raises:
        Refused: another heading, fewer numbers than it announces.
    """
    words = " ".join(line.split("#")[0] for line in path.read_text(encoding="utf-8", errors="replace").splitlines()).split()
    if not words or words[0].upper() != "OFF":
        kind = f"; {words[0]} has more numbers a corner" if words and words[0].upper().endswith("OFF") else ""
        raise Refused(path.name, f"does not begin with OFF{kind}")
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
        if at != len(words):
            raise IndexError
    except (ValueError, IndexError):
        raise Refused(path.name, "not the counts, corners and faces of an OFF file; faces have no colours here") from None
    return FileContents(pieces_of(path, [("", points, loops)]))


def read_ply(path: Path) -> FileContents:
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
    if rows.get("tristrips"):
        raise Refused(path.name, "strips of triangles are not read; write faces")
    unread = [f"{path.name}: {len(own)} rows of element {name[:40]} not read" for name, own in rows.items() if own and name not in READ_PLY]
    return FileContents(pieces_of(path, [("", points, [[int(i) for i in loop] for loop in loops])]), (), unread)


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
