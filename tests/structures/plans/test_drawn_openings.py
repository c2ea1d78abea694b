# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings, vaults and columns from what is drawn on their layers, and what is left over."""

from __future__ import annotations

from pathlib import Path

import pytest
from drawings import Drawing

from structures.plans.recognised import counted


def wall(drawing: Drawing) -> None:
    drawing.box((0.0, 0.0), (10.0, 0.6))


def openings(drawing: Drawing, folder: Path) -> list[dict]:
    wall(drawing)
    return drawing.plan(folder).tables["walls"][0]["openings"]


def test_outlines_with_their_marks(tmp_path: Path):
    drawing = Drawing()
    drawing.box((1.0, 0.0), (2.2, 0.6), "DOORS")
    drawing.text("120/240", (1.2, 0.8), "DOORS")
    drawing.box((4.0, 0.0), (5.0, 0.6), "FINESTRE")
    drawing.text("210/90", (4.2, 0.8), "FINESTRE")
    drawing.box((7.0, 0.0), (8.0, 0.6), "FINESTRE")
    drawing.text("ribassato h=1.5 s=1.0 f=0.2; h=1.2 s=3.5", (7.2, 0.8), "HEIGHTS")
    door, window, low, high = openings(drawing, tmp_path)
    assert door == {
        "shape": "rectangular",
        "at": 1.6,
        "width": 1.2,
        "sill": 0.0,
        "height": 2.4,
    }  # the one that is its width is not a height
    assert window == {"shape": "rectangular", "at": 4.5, "width": 1.0, "sill": 0.9, "height": 2.1}
    assert low == {"shape": "segmental", "at": 7.5, "width": 1.0, "sill": 1.0, "height": 1.5, "rise": 0.2}
    assert high == {"shape": "rectangular", "at": 7.5, "width": 1.0, "sill": 3.5, "height": 1.2}


def test_an_insert_with_its_leaf_and_attributes_is_as_wide_as_its_jambs(tmp_path: Path):
    drawing = Drawing()
    block = drawing.document.blocks.new("DOOR")
    block.add_line((0, 0), (0, 0.6))
    block.add_line((0.9, 0), (0.9, 0.6))
    block.add_line((0, 0.6), (0, 1.5))
    block.add_arc((0, 0.6), 0.9, 0, 90)
    insert = drawing.space.add_blockref("DOOR", (3.0, 0.0), dxfattribs={"layer": "PORTE"})
    insert.add_attrib("H", "205", (3.0, 1.0))
    assert openings(drawing, tmp_path) == [{"shape": "rectangular", "at": 3.45, "width": 0.9, "sill": 0.0, "height": 2.05}]


def test_a_whole_plan_in_a_block_turned_mirrored_and_scaled(tmp_path: Path):
    drawing = Drawing()
    plan = drawing.document.blocks.new("PLAN")
    plan.add_lwpolyline([(0, 0), (1000, 0), (1000, 60), (0, 60)], close=True, dxfattribs={"layer": "WALLS"})
    leaf = drawing.document.blocks.new("LEAF")
    leaf.add_lwpolyline([(0, 0), (100, 0), (100, 60), (0, 60)], close=True)
    plan.add_blockref("LEAF", (200, 0), dxfattribs={"layer": "DOORS"})
    drawing.space.add_blockref("PLAN", (5, 5), dxfattribs={"xscale": -0.01, "yscale": 0.01, "rotation": 90.0})
    (wall,) = drawing.plan(tmp_path).tables["walls"]
    assert wall["axis"] == [[4.7, -5.0], [4.7, 5.0]]
    assert [(o["at"], o["width"]) for o in wall["openings"]] == [(7.5, 1.0)]


def test_what_no_text_says_is_said(tmp_path: Path):
    drawing = Drawing()
    drawing.box((4.0, 0.0), (5.0, 0.6), "WINDOWS")
    wall(drawing)
    found = drawing.plan(tmp_path)
    assert found.tables["walls"][0]["openings"][0]["sill"] == 0.9
    assert ["no text says sill 0.9 m and height 1.2 m of opening WINDOWS" in note for note in found.notes] == [True]


def test_a_niche_lies_on_its_side(tmp_path: Path):
    drawing = Drawing()
    drawing.box((4.0, 0.35), (5.0, 0.6), "NICHES")
    drawing.text("nicchia h=1.5 s=1", (4.1, 0.7), "NICHES")
    (niche,) = openings(drawing, tmp_path)
    assert niche == {"shape": "niche", "at": 4.5, "width": 1.0, "sill": 1.0, "height": 1.5, "depth": 0.25, "side": "left"}


def test_vaults_by_diagonals_or_outline_and_columns(tmp_path: Path):
    drawing = Drawing()
    wall(drawing)
    drawing.lines((0, 0.6), (4, 3.6), layer="VAULTS")
    drawing.lines((0, 3.6), (4, 0.6), layer="VAULTS")
    drawing.text("imp. 3.5 f=1.2", (1.0, 2.0), "VAULTS")
    drawing.box((5, 0.6), (9, 3.6), "VAULTS")
    drawing.text("botte imp. 3", (6.0, 2.0), "VAULTS")
    drawing.space.add_circle((2, 5), 0.3, dxfattribs={"layer": "COLUMNS"})
    drawing.outline([(4, 5), (4.4, 5.3), (4.1, 5.7), (3.7, 5.4)], "COLUMNS")
    tables = drawing.plan(tmp_path).tables
    assert [(v["shape"], v["springing"], v.get("rise")) for v in tables["vaults"]] == [("barrel", 3.0, None), ("cross", 3.5, 1.2)]
    assert {tuple(c) for c in tables["vaults"][1]["corners"]} == {(0.0, 0.6), (4.0, 0.6), (4.0, 3.6), (0.0, 3.6)}
    round_, square = tables["columns"]
    assert (round_["section"], round_["size"], round_["at"]) == ("round", pytest.approx(0.6, abs=2e-3), [2.0, 5.0])
    assert (square["section"], square["size"], square["turned"]) == ("square", 0.5, pytest.approx(36.87, abs=0.01))


def test_nothing_is_dropped_in_silence(tmp_path: Path):
    drawing = Drawing()
    wall(drawing)
    drawing.space.add_point((1, 1), dxfattribs={"layer": "WALLS"})
    drawing.lines((0, 3), (2, 3), layer="WALLS")
    drawing.box((3.0, 4.0), (4.0, 4.6), "DOORS")
    drawing.text("SALA 1", (5, 5))
    drawing.lines((0, 8), (2, 8), layer="FURNITURE")
    drawing.document.layers.add("WALLS-OLD").off()
    drawing.box((0.0, 6.0), (9.0, 6.6), "WALLS-OLD")
    drawing.box((1.0, 2.0), (4.0, 4.0), "VAULTS")
    found = drawing.plan(tmp_path)
    said = {(one.layer, one.drawn_as): one.why for one in found.left}
    assert said == {
        ("WALLS", "POINT"): "POINT is nothing of a plan",
        ("WALLS", "LINE"): "no face next to it makes a wall with it",
        ("DOORS", "LWPOLYLINE"): "no wall within 0.3 m",
        ("HEIGHTS", "TEXT"): '"SALA 1" stands next to nothing',
        ("FURNITURE", "LINE"): "its layer has no meaning in structure.layers",
        ("WALLS-OLD", "LWPOLYLINE"): "its layer is off",
        ("VAULTS", "LWPOLYLINE"): "no text within 1.5 m says its springing, imp. 4.50",
    }
    assert all(one.handle for one in found.left)
    assert len(counted(found.left)) == 7


def stacked(
    drawing: Drawing, *attributes: dict[str, str], layers: tuple[str, str] = ("WINDOWS", "WINDOWS_UPPER"), widths=(1.2, 1.0)
) -> None:
    """Two inserts over one another in the middle of a wall, with the attributes of each."""
    wall(drawing)
    for name, width, layer, own in zip(("LOW", "HIGH"), widths, layers, attributes, strict=True):
        block = drawing.document.blocks.new(name)
        block.add_lwpolyline([(-0.5 * width, 0), (0.5 * width, 0), (0.5 * width, 0.6), (-0.5 * width, 0.6)], close=True)
        insert = drawing.space.add_blockref(name, (5.0, 0.0), dxfattribs={"layer": layer})
        for tag, value in own.items():
            insert.add_attrib(tag, value, (5.0, 0.3))


@pytest.mark.parametrize(
    ("attributes", "texts", "found"),
    [  # width, height and sill of the lower and the upper one
        (({}, {"H": "140", "S": "410"}), (("120/140 dav. 90", "HEIGHTS"),), [(1.2, 1.4, 0.9), (1.0, 1.4, 4.1)]),
        (({"H": "140", "S": "90"}, {}), (("100/140 dav. 410", "HEIGHTS"),), [(1.2, 1.4, 0.9), (1.0, 1.4, 4.1)]),
        (({}, {}), (("100/130 dav. 410", "HEIGHTS"), ("120/140 dav. 90", "HEIGHTS")), [(1.2, 1.4, 0.9), (1.0, 1.3, 4.1)]),  # by width
        (({}, {}), (("h=1.3 s=4.1", "WINDOWS_UPPER"), ("h=1.4 s=0.9", "WINDOWS")), [(1.2, 1.4, 0.9), (1.0, 1.3, 4.1)]),  # by layer
    ],
)
def test_a_text_belongs_to_one_of_two_openings_over_one_another(tmp_path: Path, attributes, texts, found) -> None:
    drawing = Drawing()
    stacked(drawing, *attributes)
    for k, (words, layer) in enumerate(texts):
        drawing.text(words, (4.6, 0.8 + 0.2 * k), layer)
    plan = drawing.plan(tmp_path)
    assert [(o["width"], o["height"], o["sill"]) for o in plan.tables["walls"][0]["openings"]] == found
    assert plan.notes == []


def test_attributes_come_before_a_text_and_what_is_not_taken_is_said(tmp_path: Path) -> None:
    drawing = Drawing()
    stacked(drawing, {"H": "140", "S": "90"}, {"H": "140", "S": "410"})
    drawing.text("h=2.2 dav. 90", (4.6, 0.8))
    plan = drawing.plan(tmp_path)
    assert [(o["height"], o["sill"]) for o in plan.tables["walls"][0]["openings"]] == [(1.4, 0.9), (1.4, 4.1)]
    (note,) = plan.notes
    assert "h=2.2 dav. 90" in note and "height 2.2 m" in note and "1.4 m" in note


def test_a_width_that_is_not_the_drawn_one_is_said(tmp_path: Path) -> None:
    drawing = Drawing()
    wall(drawing)
    drawing.box((4.0, 0.0), (5.0, 0.6), "FINESTRE")
    drawing.text("150/140 dav. 90", (4.2, 0.8), "FINESTRE")
    plan = drawing.plan(tmp_path)
    assert plan.tables["walls"][0]["openings"] == [{"shape": "rectangular", "at": 4.5, "width": 1.0, "sill": 0.9, "height": 1.4}]
    assert "width 1.5 m" in plan.notes[0] and "1 m" in plan.notes[0]
