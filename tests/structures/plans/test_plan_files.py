# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans as files: DXF in text and binary, units, places far away, JSON and back, and what is not a plan."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from drawings import Drawing

from masonry_cd.foundation.errors import InputError
from structures import plans
from structures.plans.json_plan import read_json, write_json

HIGH = {"wall_height": 5.0}
PLAN = {
    "course_height": 0.3,
    "walls": [
        {"name": "à", "axis": [[0.0, 0.0], {"to": [1.0, 1.0], "through": [0.1, 0.9]}], "thickness": 0.1, "height": "300 cm"},
        {
            "name": "b",
            "axis": [[0.0, 0.0], [1e-7, 3.0]],
            "thickness": 0.5,
            "top": [[0, 1], [1, 2]],
            "openings": [{"at": 0.5, "width": 0.4}],
        },
    ],
    "vaults": [{"shape": "cross", "walls": ["a", "b"], "springing": 1.0}],
}


@pytest.mark.parametrize("binary", [False, True])
def test_text_and_binary_far_from_the_origin_in_millimetres(binary: bool, tmp_path: Path):
    drawing = Drawing()
    drawing.document.header["$INSUNITS"] = 4
    drawing.box((4.5e8, 9.0e7), (4.5e8 + 6000, 9.0e7 + 600))
    drawing.document.saveas(tmp_path / "a.dxf", fmt="bin" if binary else "asc")
    plan = plans.open_plan(tmp_path / "a.dxf", HIGH)
    assert plan.tables["walls"] == [{"name": "w1", "axis": [[0.0, 0.3], [6.0, 0.3]], "thickness": 0.6, "height": 5.0}]
    assert plan.notes == ["a.dxf: its place (450000, 90000) m is the origin of the structure"]


def test_units_are_stated_and_never_guessed(tmp_path: Path):
    drawing = Drawing()
    drawing.box((0, 0), (600, 60))
    drawing.document.header["$INSUNITS"] = 0
    drawing.document.saveas(tmp_path / "a.dxf")
    with pytest.raises(InputError, match=r"structure\.units: missing; a\.dxf does not state its unit"):
        plans.open_plan(tmp_path / "a.dxf", HIGH)
    assert plans.open_plan(tmp_path / "a.dxf", {**HIGH, "units": "cm"}).tables["walls"][0]["thickness"] == 0.6
    drawing.document.header["$INSUNITS"] = 6
    drawing.document.saveas(tmp_path / "a.dxf")
    assert 'units "cm" as the scene says, where the file has "m"' in plans.open_plan(tmp_path / "a.dxf", {**HIGH, "units": "cm"}).notes[0]


def test_layers_of_the_scene(tmp_path: Path):
    drawing = Drawing()
    drawing.box((0, 0), (6, 0.6), "A-STRUCT")
    drawing.document.saveas(tmp_path / "a.dxf")
    assert len(plans.open_plan(tmp_path / "a.dxf", {**HIGH, "layers": {"walls": "a-struct*"}}).tables["walls"]) == 1
    with pytest.raises(InputError, match=r"structure\.layers\.wals: unknown key"):
        plans.open_plan(tmp_path / "a.dxf", {"layers": {"wals": "A"}})


def test_json_comes_back_as_it_was_written(tmp_path: Path):
    write_json(tmp_path / "plan.json", PLAN)
    assert read_json(tmp_path / "plan.json") == PLAN
    assert plans.open_plan(tmp_path / "plan.json", {}).tables == PLAN
    assert (tmp_path / "plan.json").read_text().count("\n") < 25  # a line for what is flat


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.json", "[1]", 'must be an object with the key "walls"'),
        ("a.json", '{"walls": []}', "walls: missing"),
        ("a.json", '{"units": "cm", "walls": [{}]}', "lengths of a plan in JSON are in metres"),
        ("a.json", '{"walls": [\n{"name": "a",}]}', "line 2, column 14"),
        ("a.json", b"\xff\xfe", "no JSON text"),
        ("a.json", "[" * 100_000, "too deep"),
        ("a.dwg", "", "plans are read from .dxf, .ifc and .json; save it as DXF"),
        ("a.dxf", "nothing\n", "is not a DXF file"),
        ("a.dxf", "  0\nSECTION\n  2\nENTITIES\n  0\nLINE\n 10\nx\n", "a.dxf does not state"),
    ],
)
def test_what_is_no_plan_ends_in_one_line(name: str, content: str | bytes, said: str, tmp_path: Path):
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as refused:
        plans.open_plan(tmp_path / name, HIGH)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_keys_of_a_drawing_are_refused_next_to_json(tmp_path: Path):
    (tmp_path / "a.json").write_text(json.dumps(PLAN))
    with pytest.raises(InputError, match=r"structure\.units: belongs to a drawing"):
        plans.open_plan(tmp_path / "a.json", {"units": "cm"})
