# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls from what is drawn of them: axes, thicknesses and where they meet."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from drawings import HIGH, Drawing, axes, turned

from masonry_cd.foundation.errors import InputError
from structures.plans.keys import PlanKeys

CORNERS = {
    ((0.25, 0.3), (0.25, 4.75), 0.5),
    ((0.25, 0.3), (5.7, 0.3), 0.6),
    ((0.25, 4.75), (5.7, 4.75), 0.5),
    ((5.7, 0.3), (5.7, 4.75), 0.6),
}


def ring(drawing: Drawing) -> None:
    drawing.box((0.0, 0.0), (6.0, 5.0))
    drawing.box((0.5, 0.6), (5.4, 4.5))


def faces(drawing: Drawing) -> None:
    drawing.lines((0, 0), (6, 0), (6, 5), (0, 5), (0, 0))
    drawing.lines((0.5, 0.6), (0.5, 4.5), (5.4, 4.5), (5.4, 0.6), (0.5, 0.6))


def open_faces(drawing: Drawing) -> None:
    drawing.lines((3, 0), (6, 0), (6, 5), (0, 5), (0, 0), (1, 0))
    drawing.lines((3, 0.6), (5.4, 0.6), (5.4, 4.5), (0.5, 4.5), (0.5, 0.6), (1, 0.6))
    drawing.box((1.0, 0.0), (3.0, 0.6), "OPENINGS")


def one_by_one(drawing: Drawing) -> None:
    drawing.box((0.0, 0.0), (0.5, 5.0))
    drawing.box((0.5, 0.0), (6.0, 0.6))
    drawing.box((0.5, 4.5), (5.4, 5.0))
    drawing.box((5.4, 0.6), (6.0, 5.0))


def hatched(drawing: Drawing) -> None:
    ring(drawing)
    hatch = drawing.space.add_hatch(dxfattribs={"layer": "WALLS"})
    hatch.paths.add_polyline_path([(0, 0), (6, 0), (6, 5), (0, 5)])
    hatch.paths.add_polyline_path([(0.5, 0.6), (5.4, 0.6), (5.4, 4.5), (0.5, 4.5)])


@pytest.mark.parametrize("draw", [ring, faces, open_faces, one_by_one, hatched])
def test_four_walls_however_they_are_drawn(draw, tmp_path: Path):
    drawing = Drawing()
    draw(drawing)
    found = drawing.plan(tmp_path)
    assert set(axes(found)) == CORNERS
    assert {one.why for one in found.left} <= {"it is drawn twice, or encloses nothing"}


def test_middle_lines_with_a_width_a_mark_or_the_key_of_the_scene(tmp_path: Path):
    drawing = Drawing()
    drawing.space.add_lwpolyline([(0, 0), (4, 0)], dxfattribs={"layer": "WALLS", "const_width": 0.4})
    drawing.lines((0, 0), (0, 3), layer="AXES")
    drawing.text("t=0.55", (0.1, 1.0))
    drawing.lines((0, 3), (4, 3), layer="AXES")
    found = drawing.plan(tmp_path, PlanKeys(wall_height=5.0, wall_thickness=0.3))
    assert {wall[-1] for wall in axes(found)} == {0.4, 0.55, 0.3}
    short = drawing.plan(tmp_path)
    assert [one.why for one in short.left] == ["no thickness: neither a width, a mark t=0.60 nor structure.wall_thickness"]


@pytest.mark.parametrize("angle", [0.0, 17.0, 90.0, 143.0])
def test_a_wall_that_abuts_ends_on_the_middle_line_of_the_other(angle: float, tmp_path: Path):
    drawing = Drawing()
    outline = [(0, 0), (8, 0), (8, 0.6), (5, 0.6), (5.5, 4), (5.0, 4.1), (4.4, 0.6), (0, 0.6)]
    drawing.outline(turned(outline, angle))
    one, other = sorted(drawing.plan(tmp_path).tables["walls"], key=lambda wall: -wall["thickness"])
    assert one["thickness"] == pytest.approx(0.6)
    a, b = (np.array(p) for p in one["axis"])
    d = (b - a) / math.dist(a, b)
    assert math.dist(a, b) == pytest.approx(8.0, abs=1e-4)
    offsets = [abs(float((np.array(p) - a) @ np.array([-d[1], d[0]]))) for p in other["axis"]]
    assert min(offsets) < 1e-5  # on the middle line
    assert max(offsets) == pytest.approx(3.7, abs=0.1)


def test_walls_of_two_thicknesses_in_line_stay_two_and_what_sticks_out_a_little_is_said(tmp_path: Path):
    drawing = Drawing()
    drawing.outline([(0, 0), (9, 0), (9, 0.6), (6, 0.6), (6, 0.9), (2.5, 0.9), (2.5, 1.0), (2, 1.0), (2, 0.9), (0, 0.9)])
    found = drawing.plan(tmp_path)
    assert sorted(wall["thickness"] for wall in found.tables["walls"]) == [0.6, 0.9]
    assert [note.split(" m2")[1] for note in found.notes] == [" of wall at x = 2.25 m, y = 0.96 m are in no wall"]


def test_a_buttress_is_a_short_wall(tmp_path: Path):
    drawing = Drawing()
    drawing.outline([(0, 0), (9, 0), (9, 0.9), (3, 0.9), (3, 1.7), (2, 1.7), (2, 0.9), (0, 0.9)])
    assert ((2.5, 0.45), (2.5, 1.7), 1.0) in axes(drawing.plan(tmp_path))


def test_an_apse_is_an_arc_whether_drawn_with_bulges_or_chords(tmp_path: Path):
    for chords in (False, True):
        drawing = Drawing()
        drawing.box((0.0, 0.0), (0.8, 8.0))
        if chords:
            angles = np.linspace(-90, 90, 25)
            outer, inner = ([(0.8 + r * np.cos(a), 4 + r * np.sin(a)) for a in np.radians(angles)] for r in (3.0, 2.3))
            drawing.outline([*outer, *inner[::-1]])
        else:
            drawing.outline([(0.8, 1.0, 1.0), (0.8, 7.0), (0.8, 6.3, -1.0), (0.8, 1.7)])
        straight, round_ = drawing.plan(tmp_path).tables["walls"]
        assert straight["axis"] == [[0.4, 0.0], [0.4, 8.0]]
        start, arc = round_["axis"]
        assert math.dist(arc["through"], (0.8, 4.0)) == pytest.approx(2.65, abs=0.01)
        assert 0.7 < start[0] < 0.8  # it reaches a little into the wall that it meets
        assert round_["thickness"] == pytest.approx(0.7, abs=0.01)


def test_a_drawing_without_walls_is_refused_in_one_line(tmp_path: Path):
    drawing = Drawing()
    drawing.box((0, 0), (3, 3), "FURNITURE")
    with pytest.raises(InputError, match=r"plan\.dxf: no wall comes out .* its layers: FURNITURE"):
        drawing.plan(tmp_path)


def test_a_wall_without_a_height_is_a_fault_that_says_its_place(tmp_path: Path):
    drawing = Drawing()
    ring(drawing)
    faults = drawing.plan(tmp_path, HIGH.model_copy(update={"wall_height": None})).faults
    assert faults.keys() == {"w1", "w2", "w3", "w4"}
    assert re.search(r"height of wall w1 at x = 0\.25 m, y = 2\.5.. m nor of 3 others: draw a text", faults["w1"].text)


def test_heights_names_gables_and_steps(tmp_path: Path):
    drawing = Drawing()
    ring(drawing)
    drawing.text("FRONT h=6/8/6", (2.0, -0.3))
    drawing.text("LEFT +5.5", (-0.4, 2.0))
    drawing.text("BACK h=5", (1.0, 5.2))
    drawing.text("h=9", (4.6, 5.2))
    drawing.box((3.5, 0.6), (3.9, 4.5))
    walls = {wall["name"]: wall for wall in drawing.plan(tmp_path).tables["walls"]}
    assert walls["front"]["top"] == [[0.0, 6.0], [2.725, 8.0], [5.45, 6.0]]
    assert walls["left"]["height"] == 5.5
    assert walls["back"]["top"] == [[0.0, 5.0], [3.25, 5.0], [3.25, 9.0], [5.45, 9.0]]  # the wall that meets it stands to the higher part
    assert all("height" in walls[name] for name in walls if name.startswith("w"))
