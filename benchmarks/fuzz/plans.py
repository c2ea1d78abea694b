# SPDX-License-Identifier: GPL-3.0-or-later
"""Good plans of a small building: as tables in JSON, and as a drawing in DXF with outlines, arcs, inserts within inserts and texts."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

from benchmarks.fuzz import texts

PLAN = {
    "units": "m",
    "walls": [
        {"name": "front", "axis": [[0, 0], [5, 0.4]], "thickness": 0.6, "top": [[0, 2.4], [2.5, 3.2], [5, 2.4]], "openings": [
            {"shape": "round", "at": 2.4, "width": 0.8, "height": 1.5},
            {"shape": "niche", "at": 4.0, "width": 0.4, "sill": 0.8, "height": 0.6},
        ]},
        {"name": "side", "axis": [[5, 0.4], [5, 4]], "thickness": 0.5, "height": 2.4},
        {"name": "back", "axis": [[5, 4], {"to": [0, 4], "through": [2.5, 5.2]}], "thickness": 0.5, "height": 2.4},
        {"name": "end", "axis": [[0, 4], [0, 0]], "thickness": 0.5, "height": 2.4},
    ],
    "junctions": [{"walls": ["front", "side"], "bond": 0.5}],
    "columns": [{"at": [2.0, 2.0], "height": 2.0, "size": 0.4}],
    "buttresses": [{"wall": "side", "at": 1.8, "width": 0.5, "depth": 0.4, "height": 1.2, "slope": 0.2}],
}  # fmt: skip
KEYS = 'kind = "building"\nblock_length = 1.2\ncourse_height = 0.6\nplan = '
Pair = tuple[int, object]


def plans() -> Iterator[tuple[str, str, dict[str, bytes]]]:
    """Kind, name of the file that is changed, and all files."""
    for name, content in (("plan.json", json.dumps(PLAN, indent=1)), ("plan.dxf", _dxf())):
        keys = KEYS + f'"{name}"' + ("\nwall_height = 2.4" if name.endswith("dxf") else "")
        yield f"plan {name[5:].upper()}", name, {"scene.toml": texts.scene(structure=keys).encode(), name: content.encode()}


def _dxf() -> str:
    """Two walls as outlines, two faces of a third as lines, a door in a block of a block, marks."""
    door = [
        (0, "BLOCK"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbBlockBegin"),
        (2, "LEAF"),
        (70, 0),
        (10, 0.0),
        (20, 0.0),
        *_outline("0", [(0, 0), (0.9, 0), (0.9, 0.6), (0, 0.6)]),
    ]
    frame = [
        (0, "BLOCK"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbBlockBegin"),
        (2, "DOOR"),
        (70, 0),
        (10, 0.0),
        (20, 0.0),
        *_insert("0", "LEAF", (0.0, 0.0), (1.0, 1.0), 0.0),
    ]
    blocks = [*door, (0, "ENDBLK"), *frame, (0, "ENDBLK")]
    entities = [
        *_outline("WALLS", [(0, 0), (5, 0.4), (5, 1.0), (0, 0.6)]),
        *_outline("WALLS", [(4.4, 0.952), (4.4, 4.0), (5.0, 4.0), (5.0, 1.0)]),
        *_line("WALLS", (0, 0.6), (0, 4.0)), *_line("WALLS", (0.6, 0.65), (0.6, 4.0)), *_line("WALLS", (0, 4.0), (0.6, 4.0)),
        *_insert("DOORS", "DOOR", (2.0, 0.16), (1.1, 1.0), 4.6),
        *_text("HEIGHTS", "FRONT h=2.4/3.2/2.4", (1.0, -0.4)), *_text("HEIGHTS", "h=2.4", (5.2, 2.5)),
        *_text("DOORS", "round h=1.6", (2.3, 0.3)),
    ]  # fmt: skip
    header = [(9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS"), (70, 6)]
    sections = (("HEADER", header), ("BLOCKS", blocks), ("ENTITIES", entities))
    pairs = [pair for name, own in sections for pair in ((0, "SECTION"), (2, name), *own, (0, "ENDSEC"))]
    return "".join(f"{code:>3}\n{value}\n" for code, value in [*pairs, (0, "EOF")])


def _outline(layer: str, points: Sequence[Sequence[float]]) -> list[Pair]:
    found: list[Pair] = [(0, "LWPOLYLINE"), (100, "AcDbEntity"), (8, layer), (100, "AcDbPolyline"), (90, len(points)), (70, 1)]
    for x, y, bulge in ((*point, 0.0)[:3] for point in points):
        found += [(10, x), (20, y), (42, bulge)]
    return found


def _line(layer: str, a: Sequence[float], b: Sequence[float]) -> list[Pair]:
    return [(0, "LINE"), (100, "AcDbEntity"), (8, layer), (100, "AcDbLine"), (10, a[0]), (20, a[1]), (11, b[0]), (21, b[1])]


def _insert(layer: str, name: str, place: Sequence[float], scale: Sequence[float], turn: float) -> list[Pair]:
    own = [(0, "INSERT"), (100, "AcDbEntity"), (8, layer), (100, "AcDbBlockReference"), (2, name)]
    return [*own, (10, place[0]), (20, place[1]), (41, scale[0]), (42, scale[1]), (50, turn)]


def _text(layer: str, words: str, place: Sequence[float]) -> list[Pair]:
    return [(0, "TEXT"), (100, "AcDbEntity"), (8, layer), (100, "AcDbText"), (10, place[0]), (20, place[1]), (40, 0.2), (1, words)]
