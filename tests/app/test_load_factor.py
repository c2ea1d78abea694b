# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.app.load_factor: a run reports the load factor at which its structure gave way."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from models import box, ground

from masonry_cd.analysis.limit import search
from masonry_cd.app.carried import largest_carried
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import NOT_THE_LEAST, closing_lines, factor_lines
from masonry_cd.app.load_factor import limit_bracket
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import LimitBracket, LoadFactor
from masonry_cd.mechanics.model.blocks import Block
from structures.files import blockfile


def push_over(
    folder: Path, blocks: list[Block], load: str, mu: float, dt: float, seconds: float, solver: str = "nlgs", way: str = "x"
) -> Summary:
    """The summary of a run of some blocks under a table [[loads]]."""
    blockfile.write(folder / "blocks.json", blocks)
    (folder / "scene.toml").write_text(
        f"""
structure = {{kind = "file", path = "blocks.json"}}
material = {{density = 2000.0, friction = {mu}}}
run = {{dt = {dt}, duration = {seconds}, solver = "{solver}", tolerance = 1e-6}}
[[loads]]
direction = "{way}"
{load}
"""
    )
    return run_case(prepare(read_scene(folder / "scene.toml")), folder / "out")


def test_a_block_gives_way_at_its_coefficient_of_friction_or_not_at_all(tmp_path: Path) -> None:
    blocks = [ground(), box("b", (0, -0.2, 0), (0.6, 0.2, 0.2))]  # in the middle of its plate: planar
    push = 'kind = "push"\nrate = 0.1\ninitial = 0.25'
    summary = push_over(tmp_path, blocks, push, 0.3, 5e-3, 1.0)
    factor = summary.load_factor
    assert factor.end == pytest.approx(0.35)
    assert factor.limit == pytest.approx(0.002)  # a hundredth of its height
    assert factor.given_way == pytest.approx(0.3, rel=2e-3)  # however fast the push grows
    assert factor.given_way_time > 0.5
    assert closing_lines(summary)[2].startswith(f"load factor: {factor.given_way:.4g} is the largest that was carried, at ")
    held = push_over(tmp_path, blocks, push, 0.4, 5e-3, 1.0)
    assert held.load_factor.given_way is None
    assert closing_lines(held)[2] == "load factor: 0.35 at the end, and the structure had not given way"
    assert vars(held.load_factor.limit_analysis) == pytest.approx({"least_found": 0.4, "associated": 0.4}, abs=1e-6)
    assert closing_lines(held)[3] == "limit analysis: 0.4; how joints slide makes no difference here"
    assert NOT_THE_LEAST not in closing_lines(held)  # there is one factor only


def test_the_bracket_of_limit_analysis_stands_beside_a_factor_that_sliding_decides() -> None:
    bracket = LimitBracket(least_found=0.3558, associated=0.40369)
    factor = LoadFactor(end=0.4, limit=2e-3, given_way=0.389, given_way_time=1.0, rigid=True, limit_analysis=bracket)
    *_, several, line = factor_lines(factor)
    assert several == NOT_THE_LEAST and "another run.solver or run.seed may find another" in several
    assert line == "limit analysis: 0.3558, the least found without dilation, to 0.4037 (associated)"
    *_, line = factor_lines(factor.model_copy(update={"limit_analysis": LimitBracket(associated=0.40369)}))
    assert line == "limit analysis: 0.4037 at most (associated); no start of the search for the least factor came to an end"


def test_a_slab_wedged_between_cheeks_has_its_least_factor_beside_the_one_of_the_solver(tmp_path: Path) -> None:
    """In space: it leans out alone at b/h = 1/6, and friction on cheeks that nothing presses may bear any multiple."""
    cheeks = [box(name, (x, -0.5, 0.0), (x + 1.0, 1.0, 3.0), fixed=True) for name, x in (("left", -1.5), ("right", 0.5))]
    blocks = [ground(4.0), *cheeks, box("slab", (-0.5, 0.0, 0.0), (0.5, 0.5, 3.0))]
    push = 'kind = "push"\nrate = 0.1\ninitial = 0.1'
    held = push_over(tmp_path, blocks, push, 0.6, 5e-3, 0.01, way="y")
    assert vars(held.load_factor.limit_analysis) == {"least_found": pytest.approx(1.0 / 6.0, rel=1e-3), "associated": None}
    *_, several, line = factor_lines(held.load_factor)
    assert several == NOT_THE_LEAST
    assert line.startswith("limit analysis: 0.1667, the least found without dilation, and none with it that is finite: ")


def test_an_upper_value_is_not_the_least_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "EXACT", -1.0)  # no start comes to an end
    push = 'kind = "push"\nrate = 0.1\ninitial = 0.1'
    held = push_over(tmp_path, [ground(), box("b", (0, -0.2, 0), (0.6, 0.2, 0.2))], push, 0.4, 5e-3, 0.01)
    assert vars(held.load_factor.limit_analysis) == {"least_found": None, "associated": pytest.approx(0.4, abs=1e-6)}


def test_a_factor_on_elastic_joints_is_not_said_to_be_one_of_several() -> None:
    soft, rigid = (factor_lines(LoadFactor(end=0.3, limit=2e-3, rigid=rigid)) for rigid in (False, True))
    assert soft == rigid[:1]


ARCH = """
structure = {kind = "arch", span = 4.0, thickness = 0.6, width = 1.0, voussoirs = 13}
run = {dt = 2e-3, duration = 4.5}
[material]
density = 2000.0
friction = 0.6
joints = {default = {normal_stiffness = 4e10, tangential_stiffness = 1.6e10}}
[[loads]]
kind = "push"
direction = "x"
rate = 0.05
initial = 0.2
"""


def test_an_arch_on_elastic_joints_gives_way_at_the_peak_of_its_curve_and_not_where_its_joints_yield_by_a_limit(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(ARCH)
    case = prepare(read_scene(tmp_path / "scene.toml"))
    found = run_case(case, tmp_path / "out").load_factor
    rigid = limit_bracket(case)
    assert rigid is not None
    assert found.given_way == pytest.approx(rigid.associated, rel=0.02)  # stiff joints: nearly that of rigid blocks
    assert found.given_way < found.end
    assert found.given_way_displacement > found.limit  # elastic joints go as far before


def test_soft_joints_that_move_by_more_than_the_limit_have_not_given_way(tmp_path: Path) -> None:
    soft = ARCH.replace("4e10", "3e7").replace("1.6e10", "1.2e7").replace("initial = 0.2", "peak = 0.18")
    (tmp_path / "scene.toml").write_text(soft)
    found = run_case(prepare(read_scene(tmp_path / "scene.toml")), tmp_path / "out").load_factor
    assert found.given_way is None
    assert factor_lines(found)[0] == "load factor: 0.18 at the end, and the structure had not given way"


def test_what_is_carried_is_the_work_of_the_load_less_what_moves() -> None:
    place = np.linspace(0.0, 0.2, 400)
    capacity = np.interp(place, [0.0, 0.05, 0.2], [0.0, 0.3, 0.1])  # of a structure of a weight of one: elastic, then falling
    applied = np.interp(place, [0.0, 0.05, 0.2], [0.0, 0.3, 0.5])
    kinetic = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(place) * ((applied - capacity)[1:] + (applied - capacity)[:-1]))])
    found = largest_carried(place, place, applied, kinetic, 0.005)
    assert found is not None
    assert found.factor == pytest.approx(0.3, rel=0.05)
    assert place[found.frame] == pytest.approx(0.05, abs=0.02)
    up = place <= 0.05
    assert largest_carried(place[up], place[up], applied[up], kinetic[up], 0.005) is None  # it still carries what is applied
    assert largest_carried(0.01 * place, 0.01 * place, applied, kinetic, 0.005) is None  # nothing has moved


def test_without_a_tilt_or_a_push_there_is_none(tmp_path: Path) -> None:
    shaken = 'kind = "sinusoidal"\namplitude = 0.05\nfrequency = 5.0\nduration = 0.05'
    assert "load_factor" not in push_over(tmp_path, [ground(), box("b", (0, 0, 0), (1, 1, 1))], shaken, 0.6, 5e-3, 0.05)


@pytest.mark.validation
@pytest.mark.parametrize("kind", ["tilt", "push"])
def test_the_dry_wall_of_ferris_and_tin_loi(kind: str, tmp_path: Path, shared: Path) -> None:
    case = json.loads((shared / "validation" / "numbers.json").read_text())["dry_wall_1"]
    length, height = case["unit_length"], case["unit_height"]
    blocks = [ground()]
    for course, row in enumerate(case["rows_bottom_to_top"]):
        edges = np.concatenate([[0.0], np.cumsum(row)]) * length
        for k, (x0, x1) in enumerate(pairwise(edges)):
            blocks.append(box(f"c{course}.{k}", (x0, -0.1, course * height), (x1, 0.1, (course + 1) * height)))
    load = 'kind = "tilt"\nrate = 0.5\ninitial = 31.0' if kind == "tilt" else 'kind = "push"\nrate = 0.01\ninitial = 0.6'
    summary = push_over(tmp_path, blocks, load, 0.65, 2e-3, 6.0, "auto")
    found = summary.load_factor.given_way
    print(f"{kind}: lambda {found:.4f}, exact (associated) {case['lambda_associated_computed']:.4f}")
    assert found == pytest.approx(case["lambda_associated_computed"], rel=0.03)


def test_a_push_on_a_bridge_is_not_compared_with_a_limit_analysis_that_knows_no_fill(tmp_path: Path) -> None:
    scene = """
[structure]
kind = "bridge"
spans = [{span = 4.0, rise = 1.2, thickness = 0.4, voussoirs = 5}]
fill = {passive_shaken = 0.0}
[material]
density = 2000.0
friction = 0.6
[[loads]]
kind = "push"
direction = "x"
rate = 0.05
[[loads]]
kind = "vehicle"
axles = [1e4]
position = 1.0
[run]
dt = 2e-3
duration = 0.01
"""
    (tmp_path / "scene.toml").write_text(scene)
    assert limit_bracket(prepare(read_scene(tmp_path / "scene.toml"))) is None
