# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls under their fill: ratios in closed form, and a line that names the wall, the ratio and the key."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from bridge_scenes import SPAN, bridge
from command_line import masonry_cd

from masonry_cd.mechanics.model.blocks import Assembly
from structures import MadeStructure, retaining, site

WALLS: dict[str, Any] = {"thickness": 0.9, "wing_length": 2.0, "course_height": 0.5, "unit_length": 1.0}


def walled(friction: float, **keys: Any) -> tuple[MadeStructure, dict[str, retaining.Weakest]]:
    made, _ = bridge(SPAN, width=4.0, cover=0.5, walls={**WALLS, **keys.pop("walls", {})}, **keys)
    assembly = Assembly.from_blocks(made.blocks, friction)
    return made, {weakest.group: weakest for weakest in retaining.weakest_of(assembly, made.fills[0])}


def test_an_upright_wall_overturns_by_its_thickness_squared_over_its_height_squared() -> None:
    made, found = walled(2.0)
    height = made.fills[0].level  # wing walls stand on the level of the springings
    wing = found["wing1_front"]
    assert not wing.slides
    assert wing.depth == pytest.approx(height)
    assert wing.ratio == pytest.approx(2000.0 * 0.9**2 / 2.0 / (2000.0 * height**2 / 6.0))
    assert found["wing2_back"].ratio == pytest.approx(wing.ratio)


def test_it_slides_by_friction_where_that_is_less() -> None:
    made, found = walled(0.1)
    wing = found["wing1_front"]
    assert wing.slides
    assert wing.ratio == pytest.approx(0.1 * 0.9 / (0.5 * made.fills[0].level))


def test_a_stone_is_pressed_on_all_its_faces_and_one_in_the_air_on_none() -> None:
    """A face cut in two triangles, as a file may have it, and one above the road change nothing."""
    made, whole = walled(2.0)
    fill = made.fills[0]
    halves = [f._replace(corners=f.corners[[0, k, k + 1]]) for f in fill.faces if f.kind == "wall" for k in range(1, len(f.corners) - 1)]
    above = [half._replace(corners=half.corners - [0.0, 0.0, half.corners[:, 2].min() - fill.level]) for half in halves[:1]]
    others = [f for f in fill.faces if f.kind != "wall"]
    assembly = Assembly.from_blocks(made.blocks, 2.0)
    cut = {one.group: one.ratio for one in retaining.weakest_of(assembly, replace(fill, faces=(*others, *halves, *above)))}
    assert cut == pytest.approx({group: one.ratio for group, one in whole.items()})
    assert retaining.weakest_of(assembly, replace(fill, faces=(*others, *above))) == []


def test_a_parapet_holds_a_wall_down() -> None:
    made, found = walled(2.0, walls={"parapet_height": 1.0, "parapet_thickness": 0.3})
    height = made.fills[0].level
    moment = 2000.0 * (height * 0.9**2 / 2.0 + 1.0 * 0.3**2 / 2.0)
    assert found["wing1_front"].ratio == pytest.approx(moment / (2000.0 * height**3 / 6.0))


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"walls": {"thickness": 0.4}}, "of the active pressure, K_a; structure.walls.thickness"),
        ({"walls": {"thickness": 0.8}}, "of the pressure at rest, K_0, but 1.2 of K_a"),
        ({"walls": {"thickness": 1.4}}, ""),
        ({"walls": {"thickness": 0.4}, "fill": {"pressure": "none"}}, ""),
    ],
)
def test_a_line_names_walls_ratio_and_key(keys: dict[str, Any], said: str) -> None:
    made, _ = walled(0.6, **keys)
    lines = retaining.warnings(Assembly.from_blocks(made.blocks, 0.6), made.fills)
    assert bool(lines) == bool(said)
    assert all("wall overturns under its fill" in line for line in lines)
    if said:
        assert '"wing1_front", "wing1_back", "wing2_front"' in " ".join(lines) or '"spandrel_front", "spandrel_back"' in lines[0]
        assert any(said in line for line in lines)


def test_fill_of_a_file_has_the_key_of_its_own() -> None:
    made, _ = walled(0.6, walls={"thickness": 0.4})
    fill = replace(made.fills[0], where="blocks.json: fills[0]")
    assert "blocks.json: fills[0].pressure" in retaining.warnings(Assembly.from_blocks(made.blocks, 0.6), [fill])[0]


def test_one_of_several_bridges_is_named_by_its_own_table() -> None:
    own = {"kind": "bridge", "spans": [SPAN], "width": 4.0}
    two = [{**own, "name": "a"}, {**own, "name": "b", "at": [0.0, 50.0, 1.0], "rotate": 30.0, "walls": {"thickness": 0.4}}]
    made = site.build(two, 2000.0, Path())
    (line,) = retaining.warnings(Assembly.from_blocks(made.blocks, 0.6), made.fills)
    assert line.startswith('"b.spandrel_front", "b.spandrel_back": dry and by itself, the wall overturns')
    assert "structures[1].walls.thickness" in line


def test_build_warns_and_goes_on(tmp_path: Path) -> None:
    scene = tmp_path / "bridge.toml"
    scene.write_text(
        '[structure]\nkind = "bridge"\nspans = [{span=4.0,rise=1.5,thickness=0.4,voussoirs=7}]\n[structure.walls]\nunit_length = 1.5\n'
        "course_height = 0.7\n[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 1.0\n"
    )
    answer = masonry_cd("build", scene, "-o", tmp_path / "out", "--no-picture")
    assert answer.exit_code == 0, answer.output
    assert 'warning: "spandrel_front", "spandrel_back": dry and by itself, the wall overturns under its fill' in answer.output
    assert (tmp_path / "out" / "blocks.json").is_file()
