# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings as they come: outlines without their flag, corners that do not quite meet, lines drawn twice, blocks within blocks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from drawings import Drawing, axes

from structures.files.foreign import Refused
from structures.plans.entities import entity_of
from structures.plans.recognised import Recognised

CORNERS = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]
INNER = [(0.5, 0.5), (5.5, 0.5), (5.5, 3.5), (0.5, 3.5)]


def outlines(drawing: Drawing) -> None:
    drawing.outline(CORNERS)
    drawing.outline(INNER)


def without_flag(drawing: Drawing) -> None:
    for points in (CORNERS, INNER):
        drawing.space.add_lwpolyline([*points, points[0]], close=False, dxfattribs={"layer": "WALLS"})


def gaps(drawing: Drawing) -> None:
    """Every line ends 4 mm before its corner."""
    for points in (CORNERS, INNER):
        for (x, y), (u, v) in zip(points, [*points[1:], points[0]], strict=True):
            a, b = 0.004 * (u > x) - 0.004 * (u < x), 0.004 * (v > y) - 0.004 * (v < y)
            drawing.lines((x + a, y + b), (u - a, v - b))


def twice(drawing: Drawing) -> None:
    outlines(drawing)
    for points in (CORNERS, INNER):
        drawing.lines(*points, points[0])


def nested(drawing: Drawing) -> None:
    """The plan as a block in another block, drawn at half its size and turned by a quarter, and put back by the insert."""
    inner = drawing.document.blocks.new("PLAN")
    for points in (CORNERS, INNER):
        inner.add_lwpolyline([(0.5 * y, -0.5 * x) for x, y in points], close=True, dxfattribs={"layer": "WALLS"})
    outer = drawing.document.blocks.new("XREF")
    outer.add_blockref("PLAN", (0, 0), dxfattribs={"layer": "WALLS"})
    drawing.space.add_blockref("XREF", (0, 0), dxfattribs={"layer": "0", "xscale": 2.0, "yscale": 2.0, "rotation": 90.0})


def paper(drawing: Drawing) -> None:
    outlines(drawing)
    drawing.document.paperspace().add_lwpolyline([(0, 0), (9, 0), (9, 9)], close=True, dxfattribs={"layer": "WALLS"})


def walls_of(found: Recognised) -> list[tuple[tuple[float, float], ...]]:
    return sorted(tuple(sorted(tuple(round(c, 2) + 0.0 for c in point) for point in wall["axis"])) for wall in found.tables["walls"])


@pytest.mark.parametrize("draw", [without_flag, gaps, twice, nested, paper])
def test_a_drawing_with_a_quirk_is_the_plan_that_it_shows(draw: Callable[[Drawing], None], tmp_path: Path) -> None:
    plain, quirky = Drawing(), Drawing()
    outlines(plain)
    draw(quirky)
    wanted, found = plain.plan(tmp_path), quirky.plan(tmp_path)
    assert len(wanted.tables["walls"]) == 4
    assert walls_of(found) == walls_of(wanted)
    assert {wall["thickness"] for wall in found.tables["walls"]} == {0.5}


def test_what_a_block_within_a_block_brings_is_read_and_not_listed(tmp_path: Path) -> None:
    drawing = Drawing()
    outlines(drawing)
    leaf = drawing.document.blocks.new("LEAF")
    leaf.add_lwpolyline([(0, 0), (0.9, 0), (0.9, 0.5), (0, 0.5)], close=True)
    drawing.document.blocks.new("DOOR").add_blockref("LEAF", (0, 0))
    drawing.space.add_blockref("DOOR", (2.0, 0.0), dxfattribs={"layer": "DOORS"})
    drawing.space.add_blockref("GONE", (3.0, 0.0), dxfattribs={"layer": "DOORS"})
    found = drawing.plan(tmp_path)
    (opening,) = [opening for wall in found.tables["walls"] for opening in wall.get("openings", ())]
    assert opening["width"] == pytest.approx(0.9)
    assert [left.layer for left in found.left] == ["DOORS"]


def test_an_outline_that_runs_to_and_fro_has_no_part_in_the_ground(tmp_path: Path) -> None:
    drawing = Drawing()
    outlines(drawing)
    drawing.outline([(8.0, 0.0), (10.0, 0.0), (10.0, 1.0), (9.0, 1.0), (9.0, 0.0), (9.0, 2.0), (9.0, 0.5), (8.0, 1.0)])
    drawing.outline([(8.0, 0.0), (12.0, 0.0), (9.0, 0.0)])
    assert len(drawing.plan(tmp_path).tables["walls"]) >= 4


def test_control_characters_of_a_drawing_are_not_shown() -> None:
    row = ("other", "1A", "LI\0NE", "WA\x1bLLS", [[0.0, 0.0, 0.0]], "w\tords\nmore", False, 0.0, "")
    entity = entity_of(*row)
    assert (entity.drawn_as, entity.layer, entity.text) == ("LI?NE", "WA?LLS", "w?ords\nmore")
    assert entity_of(*row[:3], "(" * 3000, *row[4:]).layer == "(" * 255 + "..."


def test_an_arc_whose_bulge_is_none_is_refused_by_its_handle(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.space.add_lwpolyline([(0.0, 0.0, 1e6), (1.0, 0.0, 0.0)], format="xyb", dxfattribs={"layer": "WALLS"})
    with pytest.raises(Refused) as refusal:
        drawing.entities(tmp_path)
    assert "on layer WALLS has a bulge of more than 10000" in refusal.value.text


def test_a_line_beyond_all_bounds_is_left_out_with_its_reason(tmp_path: Path) -> None:
    drawing = Drawing()
    outlines(drawing)
    drawing.lines((0.0, 0.0), (-1e308, 1.0))
    plan = drawing.plan(tmp_path)
    assert len(plan.tables["walls"]) == 4
    assert [left.why for left in plan.left] == ["damaged: places that are no numbers, or beyond all bounds"]


@pytest.mark.parametrize("gap", [0.003, 0.012, 0.019])
def test_ends_that_miss_by_up_to_20_mm_are_brought_to_where_the_lines_cross_and_listed(tmp_path: Path, gap: float) -> None:
    drawing = Drawing()
    for low, high in (((0.0, 0.0), (6.0, 4.0)), ((0.5, 0.5), (5.5, 3.5))):
        (x, y), (u, v) = low, high
        drawing.lines((x + gap, y), (u, y), (u, v), (x, v), (x, y))  # the lower left corner is open
    found = drawing.plan(tmp_path)
    corners = [(0.25, 0.25), (5.75, 0.25), (5.75, 3.75), (0.25, 3.75)]
    assert sorted(axes(found)) == sorted((*sorted(pair), 0.5) for pair in zip(corners, [*corners[1:], corners[0]], strict=True))
    said = [note for note in found.notes if f"{1e3 * gap:.3g} mm" in note]
    assert len(said) == 1 and "x = 0 m, y = 0 m; x = 0.5 m, y = 0.5 m" in said[0]


def test_ends_that_miss_by_more_are_left(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.lines((0.03, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0))
    drawing.lines((0.53, 0.5), (5.5, 0.5), (5.5, 3.5), (0.5, 3.5), (0.5, 0.5))
    assert not [note for note in drawing.plan(tmp_path).notes if " mm" in note]
