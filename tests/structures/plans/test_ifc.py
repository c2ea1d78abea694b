# SPDX-License-Identifier: GPL-3.0-or-later
"""Models in IFC as plans: walls with axis, thickness, height and openings; what is not understood is listed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import done
from ifc_files import Model, house

import structures
from masonry_cd.foundation.errors import InputError
from structures.plans import FilePlan, open_plan

pytest.importorskip("ifcopenshell", reason="models in IFC need the extra ifc")

ARC = [(0.5 + 0.5 * math.cos(a), 1.5 + 0.5 * math.sin(a)) for a in np.linspace(0.0, math.pi, 19)[1:-1].tolist()]
HEADS = {
    "round": ([(0, 0), (1.0, 0), (1.0, 1.5), *ARC, (0, 1.5)], 2.0),
    "segmental": ([(0, 0), (1.0, 0), (1.0, 1.5), (0.75, 1.65), (0.5, 1.7), (0.25, 1.65), (0, 1.5)], 1.7),
    "pointed": ([(0, 0), (1.0, 0), (1.0, 1.5), (0.5, 2.4), (0, 1.5)], 2.4),
}


def plan(folder: Path, model: Model) -> FilePlan:
    model.write(folder / "a.ifc")
    return open_plan(folder / "a.ifc", {})


def room() -> Model:
    model = Model()
    model.wall("south", (0.0, 0.2), (6.0, 0.2), 0.4, 0.0, 3.0)
    model.wall("north", (0.0, 3.8), (6.0, 3.8), 0.4, 0.0, 3.0)
    return model


def test_a_house_of_two_storeys(tmp_path: Path) -> None:
    """Walls over one another are one, ends meet at middle lines, the gable is the top of its wall; the volume is that of the model."""
    found = plan(tmp_path, house())
    walls = {wall["name"]: wall for wall in found.tables["walls"]}
    assert {name: (wall["thickness"], wall["base"], wall.get("height")) for name, wall in walls.items()} == {
        "south_ground": (0.4, 0.0, 5.6), "north_ground": (0.4, 0.0, 5.6), "west_ground": (0.4, 0.0, 5.6), "east": (0.4, 0.0, None),
    }  # fmt: skip
    assert walls["south_ground"]["axis"] == [[0.2, 0.2], [5.8, 0.2]] and walls["east"]["axis"] == [[5.8, 0.2], [5.8, 3.8]]
    assert walls["east"]["top"] == [[0.0, 5.6], [0.2, 5.6], [1.8, 6.8], [3.4, 5.6], [3.6, 5.6]]
    window, door = walls["south_ground"]["openings"]
    assert (door["at"], door["width"], door["sill"], door["height"]) == (2.8, 1.0, 0.0, 2.1)
    assert (window["at"], window["width"], window["sill"], window["height"]) == (1.2, 0.8, 3.9, 1.2)
    said = "\n".join(found.notes)
    assert "1 IfcStair not read" in said and 'slab "floor"' in said and "0.30 m of floor" in said and found.left == []
    blocks = structures.build({"kind": "building", "plan": "a.ifc", "course_height": 0.3, "block_length": 0.8}, 2000.0, tmp_path)
    outer, inner = 6.0 * 4.0 - 5.2 * 3.2, 0.4 * (1.0 * 2.1 + 0.8 * 1.2)
    gable = 0.4 * 0.5 * 3.2 * 1.2
    assert sum(b.mass_properties.volume for b in blocks if not b.fixed) == pytest.approx(5.6 * outer - inner + gable, rel=2e-3)


def test_the_plan_is_written_to_be_corrected_and_builds_the_same(tmp_path: Path) -> None:
    house().write(tmp_path / "house.ifc")
    scene = "material = {density = 1800.0, friction = 0.6}\nrun = {dt = 1e-3, duration = 0.1}\n"
    scene += 'structure = {kind = "building", plan = "%s", block_length = 0.8}\n'
    (tmp_path / "a.toml").write_text(scene % "house.ifc", encoding="utf-8")
    done("build", tmp_path / "a.toml", "-o", tmp_path / "a")
    (tmp_path / "b.toml").write_text(scene % "a/plan.json", encoding="utf-8")
    done("build", tmp_path / "b.toml", "-o", tmp_path / "b")
    first, second = (json.loads((tmp_path / name / "blocks.json").read_text(encoding="utf-8")) for name in ("a", "b"))
    assert first["blocks"] == second["blocks"]


@pytest.mark.parametrize("shape", HEADS)
def test_heads_of_openings(tmp_path: Path, shape: str) -> None:
    model = room()
    outline, height = HEADS[shape]
    model.opening(model.wall("west", (0.2, 0.4), (0.2, 3.6), 0.4, 0.0, 3.0), outline, (0.5, 1.5, 0.2), 0.6, (0, 1, 0))
    model.opening(model.wall("east", (5.8, 0.4), (5.8, 3.6), 0.4, 0.0, 3.0), outline, (6.1, 1.5, 0.2), 0.6, (0, 1, 0))
    openings = [wall["openings"][0] for wall in plan(tmp_path, model).tables["walls"] if "openings" in wall]
    assert [(one["shape"], one["at"], one["width"], one["sill"], one["height"]) for one in openings] == 2 * [(shape, 1.8, 1.0, 0.2, height)]
    assert all(one.get("rise", 0.5) == pytest.approx(height - 1.5) for one in openings)


def test_an_opening_that_does_not_go_through_is_a_niche(tmp_path: Path) -> None:
    model = room()
    model.opening(model.wall("west", (0.2, 0.4), (0.2, 3.6), 0.4, 0.0, 3.0), HEADS["round"][0], (0.15, 1.5, 0.2), 0.3, (0, 1, 0))
    (niche,) = next(wall["openings"] for wall in plan(tmp_path, model).tables["walls"] if "openings" in wall)
    assert (niche["shape"], niche["depth"]) == ("niche", 0.15) and niche["side"] in ("left", "right")


def test_columns_and_what_is_not_understood(tmp_path: Path) -> None:
    model = room()
    octagon = [(0.3 * math.cos(a), 0.3 * math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 25)[:-1]]
    model.add("IfcColumn", "round", model.prism(octagon, 3.0), "ground", (2.0, 2.0, 0.0))
    model.add("IfcColumn", "square", model.prism([(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)], 3.0), "ground", (4.0, 2.0, 0.0))
    model.add("IfcColumn", "oblong", model.prism([(0, 0), (0.9, 0), (0.9, 0.5), (0, 0.5)], 3.0), "ground", (3.0, 2.0, 0.0))
    model.add("IfcWall", "bent", model.prism([(9, 0), (12, 0), (12, 3), (11.6, 3), (11.6, 0.4), (9, 0.4)], 3.0))
    model.opening(model.add("IfcSlab", "floor", model.prism([(0, 0), (1, 0), (1, 1)], 0.2)), HEADS["round"][0], (0, 0, 0), 0.1)
    found = plan(tmp_path, model)
    columns = found.tables["columns"]
    assert [(c["section"], c["at"]) for c in columns] == [("round", [2.0, 2.0]), ("square", [4.25, 2.25])]
    assert columns[0]["size"] == pytest.approx(0.6, rel=0.02) and columns[1]["size"] == 0.5
    assert [one.drawn_as for one in found.left] == ['IfcWall "bent"', 'IfcColumn "oblong"'] or len(found.left) == 2
    assert "1 IfcOpeningElement in what is not a wall not read" in "\n".join(found.notes)


def _cut(text: str) -> str:
    return text[: len(text) // 2]


@pytest.mark.parametrize("change", [_cut, lambda text: "no model", lambda text: text.replace("IFCWALL", "IFCBEAM")])
def test_models_that_cannot_be_read_are_refused_in_a_line(tmp_path: Path, change: Any) -> None:
    room().write(tmp_path / "b.ifc")
    (tmp_path / "a.ifc").write_text(change((tmp_path / "b.ifc").read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.ifc") as refused:
        open_plan(tmp_path / "a.ifc", {})
    assert "\n" not in str(refused.value)


def test_walls_in_line_are_one_where_they_are_of_one_height(tmp_path: Path) -> None:
    model = room()
    model.wall("more", (6.0, 0.2), (9.0, 0.2), 0.4, 0.0, 3.0)
    model.wall("low", (6.0, 3.8), (9.0, 3.8), 0.4, 0.0, 2.0)
    walls = plan(tmp_path, model).tables["walls"]
    assert sorted((wall["axis"], wall["height"]) for wall in walls) == [
        ([[0.0, 0.2], [9.0, 0.2]], 3.0), ([[0.0, 3.8], [6.0, 3.8]], 3.0), ([[6.0, 3.8], [9.0, 3.8]], 2.0),
    ]  # fmt: skip


def test_walls_that_go_on_round_a_bend_in_other_heights_are_refused(tmp_path: Path) -> None:
    model = room()
    model.wall("low", (6.0, 0.2), (9.0, 1.2), 0.4, 0.0, 2.0)
    with pytest.raises(InputError, match=r'"south".*"low"|"low".*"south"'):
        plan(tmp_path, model)
