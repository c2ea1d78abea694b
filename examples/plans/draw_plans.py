# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the plans of three buildings as a surveyor does, in DXF: a parish church, a house in a row, an oratory.

    python examples/plans/draw_plans.py FOLDER

Measures are of the kind that published surveys of such buildings have. The three differ in how they are drawn: the church in metres with
its walls as one outline with the empty spaces within, the house in centimetres with the two faces of every wall as lines and its doors and
windows as blocks, the oratory in millimetres with an outline for each wall and curved faces.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

Point = tuple[float, float]


def new(units: int, layers: Sequence[str]) -> Any:
    """An empty drawing in a unit of $INSUNITS, with layers."""
    import ezdxf

    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = units
    for layer in layers:
        drawing.layers.add(layer)
    return drawing


def outline(space: Any, layer: str, points: Sequence[Sequence[float]]) -> None:
    """A closed outline; the third number of a point is the bulge of the side that begins there."""
    space.add_lwpolyline([(*p, 0.0)[:3] for p in points], format="xyb", close=True, dxfattribs={"layer": layer})


def text(space: Any, layer: str, words: str, place: Point, height: float, turn: float = 0.0) -> None:
    """A text whose lower left corner is a place, turned counter-clockwise [degrees]."""
    space.add_text(words, height=height, rotation=turn, dxfattribs={"layer": layer}).set_placement(place)


def church(path: Path) -> None:
    """A parish church with a tower at its corner; hardly a corner is square. In metres, layers in Italian."""
    drawing = new(6, ("MURI", "APERTURE", "QUOTE", "QUOTATURA"))
    space = drawing.modelspace()
    outline(space, "MURI", [(0.0, 0.0), (16.92, 0.61), (16.92, -3.15), (21.55, -3.02), (21.42, 0.80), (21.15, 9.62), (0.35, 9.28)])
    outline(space, "MURI", [(0.95, 1.02), (20.05, 1.72), (19.85, 8.56), (1.22, 8.25)])
    outline(space, "MURI", [(17.95, -2.08), (20.47, -2.01), (20.38, 0.69), (17.95, 0.62)])
    for points in (
        [(0.02, 3.75), (1.08, 3.71), (1.13, 5.45), (0.09, 5.49)],  # portal
        [(4.6, 0.1), (5.7, 0.14), (5.65, 1.24), (4.55, 1.2)],
        [(10.6, 0.3), (11.7, 0.35), (11.65, 1.45), (10.55, 1.4)],
        [(5.2, 8.25), (6.3, 8.27), (6.28, 9.42), (5.18, 9.4)],
        [(11.7, 8.35), (12.8, 8.37), (12.78, 9.52), (11.68, 9.5)],
    ):
        outline(space, "APERTURE", points)
    marks = (
        ("FACCIATA h=8.25/10.5/8.25", (-0.4, 7.0)), ("LATO SUD h=7.50", (7.0, -0.2)), ("LATO NORD h=7.50", (7.5, 9.8)),
        ("ABSIDE h=7.50", (21.6, 5.0)), ("TORRE S h=15.0", (18.2, -3.5)),
        ("TORRE E h=15.0", (21.75, -1.2)), ("TORRE O h=15.0", (16.0, -1.6)),
        ("h=15.0", (18.6, 1.1)),
    )  # fmt: skip
    for words, place in marks:
        text(space, "QUOTE", words, place, 0.2)
    text(space, "APERTURE", "portale tutto sesto h=3.60; rosone l=1.60 s=5.60", (1.3, 4.5), 0.15)
    for place in ((4.7, 1.35), (10.7, 1.55), (5.2, 7.95), (11.8, 8.05)):
        text(space, "APERTURE", "tutto sesto h=2.20 s=3.75", place, 0.15)
    space.add_line((0.0, -5.0), (21.0, -5.0), dxfattribs={"layer": "QUOTATURA"})
    drawing.saveas(path)


def faces(space: Any, layer: str, runs: Sequence[Sequence[Point]]) -> None:
    """Faces of walls as lines from corner to corner."""
    for run in runs:
        for a, b in pairwise(run):
            space.add_line(a, b, dxfattribs={"layer": layer})


def house(path: Path) -> None:
    """An L-shaped house of two storeys at the end of a row, with the wall that it shares with its neighbour. In centimetres."""
    drawing = new(5, ("WALLS", "DOORS", "WINDOWS", "DOORS_UPPER", "WINDOWS_UPPER", "HEIGHTS", "STAIRS"))
    space = drawing.modelspace()
    faces(space, "WALLS", [[(0, 0), (1120, 0), (1120, 460), (585, 460), (585, 890), (0, 890), (0, 0)]])
    faces(space, "WALLS", [
        [(45, 50), (535, 50), (535, 410), (45, 410), (45, 50)],
        [(580, 50), (1065, 50), (1065, 410), (580, 410), (580, 50)],
        [(45, 455), (535, 455), (535, 840), (45, 840), (45, 455)],
    ])  # fmt: skip
    for name, width in (("DOOR_90", 90), ("WINDOW_100", 100)):
        block = drawing.blocks.new(name)
        for x in (0, width):
            block.add_line((x, 0), (x, 50))
        for y in (0, 50):
            block.add_line((0, y), (width, y))
        for tag in ("H", "S"):
            block.add_attdef(tag, (0, 60 if tag == "H" else 75), dxfattribs={"height": 10})
    entrance, above, doors = ((240, 0), 0), ((235, 0), 0), (((535, 190), 90), ((200, 405), 0))
    windows = (((780, 0), 0), ((800, 410), 0), ((1115, 190), 90), ((240, 840), 0), ((585, 600), 90))
    storeys = (
        ("DOORS", "DOOR_90", 210, 0, (entrance, *doors)), ("WINDOWS", "WINDOW_100", 120, 90, windows),
        ("DOORS_UPPER", "DOOR_90", 210, 310, doors), ("WINDOWS_UPPER", "WINDOW_100", 120, 400, (above, *windows)),
    )  # fmt: skip
    for layer, name, height, sill, openings in storeys:
        for place, turn in openings:
            insert = space.add_blockref(name, place, dxfattribs={"layer": layer, "rotation": turn})
            for tag, value in (("H", height), ("S", sill)):
                insert.add_attrib(tag, f"{value}", place, dxfattribs={"layer": layer})
    for words, place in (
        ("FRONT h=620", (480, -40)), ("PARTY h=620", (-60, 600)), ("END h=620", (1140, 60)), ("YARD h=620", (800, 480)),
        ("COURT h=620", (600, 780)), ("BACK h=620", (300, 910)), ("SPINE h=620", (545, 240)), ("CROSS h=620", (300, 430)),
    ):  # fmt: skip
        text(space, "HEIGHTS", words, place, 15)
    for k in range(9):
        space.add_line((50, 130 + 28 * k), (140, 130 + 28 * k), dxfattribs={"layer": "STAIRS"})
    drawing.saveas(path)


def oratory(path: Path) -> None:
    """An oratory with a round apse and a cross vault over its bay. In millimetres, an outline for each wall."""
    drawing = new(4, ("MURI", "PORTE", "FINESTRE", "VOLTE", "QUOTE"))
    space = drawing.modelspace()
    outline(space, "MURI", [(0, 0), (800, 0), (800, 7400), (0, 7400)])
    outline(space, "MURI", [(800, 0), (7600, 0), (7600, 800), (800, 800)])
    outline(space, "MURI", [(800, 6600), (7600, 6600), (7600, 7400), (800, 7400)])
    outline(space, "MURI", [(6800, 800), (7600, 800), (7600, 6600), (6800, 6600)])
    outline(space, "MURI", [(7600, 1100, 1.0), (7600, 6300), (7600, 5600, -1.0), (7600, 1800)])
    outline(space, "PORTE", [(6800, 2500), (7600, 2500), (7600, 4900), (6800, 4900)])
    outline(space, "PORTE", [(0, 3000), (800, 3000), (800, 4400), (0, 4400)])
    outline(space, "FINESTRE", [(3400, 0), (4200, 0), (4200, 800), (3400, 800)])
    outline(space, "FINESTRE", [(3400, 6600), (4200, 6600), (4200, 7400), (3400, 7400)])
    space.add_line((800, 800), (6800, 6600), dxfattribs={"layer": "VOLTE"})
    space.add_line((800, 6600), (6800, 800), dxfattribs={"layer": "VOLTE"})
    text(space, "VOLTE", "crociera imp. 3.80 f=2.30 sp. 25", (2600, 3900), 150)
    text(space, "PORTE", "tutto sesto 140/280", (900, 3300), 150)
    text(space, "PORTE", "arco trionfale tutto sesto h=4.20 ghiera 35", (5000, 3900), 150)
    for place in ((3400, 900), (3400, 6300)):
        text(space, "FINESTRE", "ribassato h=1.30 s=3.10", place, 150)
    for words, place in (
        ("FACCIATA h=6.6/8.4/6.6", (-500, 5500)), ("SUD h=6.60", (2000, -400)), ("NORD h=6.60", (2000, 7700)),
        ("ABSIDE h=5.60", (10300, 3700)),
    ):  # fmt: skip
        text(space, "QUOTE", words, place, 200)
    text(space, "QUOTE", "ARCO TRIONFALE h=6.60", (7200, 900), 200, 90.0)
    drawing.saveas(path)


PLANS = {"church": church, "house": house, "oratory": oratory}


def main(folder: Path) -> None:
    """Draw them all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in PLANS.items():
        draw(folder / f"{name}.dxf")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
