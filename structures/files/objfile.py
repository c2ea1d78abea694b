# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of an OBJ, in a child process (:mod:`structures.files.foreign`): its polygons, with their names, groups and materials.

Source: Wavefront, Advanced Visualizer, appendix B1.

Curved surfaces, and files that it calls, would be blocks, too, and are refused by line; lines of other words that could be are counted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from structures.files.foreign import FileContents, FileShell, Refused
from structures.files.shells import shells

ELSEWHERE = ("call", "csh", "surf", "bzp", "bsp", "cdc", "cdp", "res", "con")  # bring faces
LOOKS = (
    "o", "g", "vn", "vt", "s", "mg", "mtllib", "maplib",
    "usemap", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",
    "stech",
)  # fmt: skip
MOST = 5  # words that a line names


def read(path: Path) -> FileContents:
    """Objects (``o``; ``g`` where there are none, else ``usemtl``) with their faces; indices count from one, or back from the end.

    The group of an object is its ``g``, or else its material. A file that names none of them is a soup of closed shells. Where a name
    comes more than once, closed shells are blocks of their own, ``name.0``, ``name.1`` ..., and open ones belong together.

    Raises:
        Refused: a line that is wrong, or brings faces that are not read.
    """
    points: list[list[float]] = []
    objects: dict[str, list[list[list[int]]]] = {}
    groups: dict[str, str] = {}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        raise Refused(path.name, "no text in UTF-8") from None
    named = {line[:2].strip() for line in lines if line[:2] in ("o ", "g ")}
    mark = "o" if "o" in named else "g"
    name, last, unread = "", {"g": "", "usemtl": ""}, Counter[str]()
    for number, line in enumerate(lines, start=1):
        word, *rest = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                if len(rest) < 3:
                    raise Refused(path.name, f"line {number}: a vertex has three coordinates: {line.strip()[:60]}")
                points.append([float(x) for x in rest[:3]])
            elif word == mark:
                name = " ".join(rest) or "b0"
                objects.setdefault(name, []).append([])
            elif word in last:
                last[word] = " ".join(rest)
            elif word == "f":
                corners = [int(corner.split("/")[0]) for corner in rest]
                if len(corners) < 3 or 0 in corners:
                    raise Refused(path.name, f"line {number}: a face has three corners or more, counted from 1: {line.strip()[:60]}")
                objects.setdefault(name, [[]])[-1].append([i - 1 if i > 0 else len(points) + i for i in corners])
                groups.setdefault(name, (last["g"] if mark == "o" else "") or last["usemtl"])
            elif word in ELSEWHERE:
                raise Refused(
                    path.name, f"line {number}: {word} brings faces that are not read; write them as polygons: {line.strip()[:60]}"
                )
            elif word and word not in LOOKS:
                unread[word] += 1
        except ValueError:
            raise Refused(path.name, f"line {number}: no number where one belongs: {line.strip()[:60]}") from None
    found: list[FileShell] = []
    vertices = np.array(points).reshape(-1, 3)
    for name, group, faces in _apart(objects, groups):
        used = sorted({i for face in faces for i in face})
        if used[0] < 0 or used[-1] >= len(vertices):
            raise Refused(path.name, f'block "{name or "b0"}": a face names a vertex outside 1 to {len(vertices)}')
        number_of = {old: new for new, old in enumerate(used)}
        own = (vertices[used], tuple(tuple(number_of[i] for i in face) for face in faces))
        apart = [own] if name else shells(*own)
        found += [FileShell(len(found) + k, name or f"b{k}", *shell, group) for k, shell in enumerate(apart)]
    said = ", ".join(f"{count} of {word[:20]}" for word, count in list(unread.items())[:MOST])
    return FileContents(found, (), [f"{path.name}: lines not read: {said}"] if unread else [])


def _apart(objects: dict[str, list[list[list[int]]]], groups: dict[str, str]) -> Iterator[tuple[str, str, list[list[int]]]]:
    """Names, groups and faces of blocks, from the faces below each mention of a name; what has no faces is none."""
    for name, mentions in objects.items():
        given = [faces for faces in mentions if faces]
        if len(given) > 1 and all(map(_is_closed, given)):
            yield from ((f"{name}.{k}", groups[name], faces) for k, faces in enumerate(given))
        elif given:
            yield name, groups[name], [face for faces in given for face in faces]


def _is_closed(loops: list[list[int]]) -> bool:
    """Return True if each edge has a face on both sides."""
    sides = Counter(frozenset(edge) for loop in loops for edge in zip(loop, (*loop[1:], loop[0]), strict=True))
    return all(count > 1 for count in sides.values())
