"""masonry_cd.app.load_factor: a run reports the load factor at which its structure gave way."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from models import box, ground

from masonry_cd.app.case import prepare
from masonry_cd.app.load_factor import NOT_THE_LEAST, outcome_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.app.summary import closing_lines
from masonry_cd.model.blocks import Block
from structures.files import blockfile


def push_over(folder: Path, blocks: list[Block], load: str, mu: float, dt: float, seconds: float, solver: str = "nlgs") -> dict:
    """The summary of a run of some blocks under a table [[loads]]."""
    blockfile.write(folder / "blocks.json", blocks)
    (folder / "scene.toml").write_text(
        f"""
structure = {{kind = "file", path = "blocks.json"}}
material = {{density = 2000.0, friction = {mu}}}
run = {{dt = {dt}, duration = {seconds}, solver = "{solver}", tolerance = 1e-6}}
[[loads]]
direction = "x"
{load}
"""
    )
    return run_case(prepare(read_scene(folder / "scene.toml")), folder / "out")


def test_a_block_gives_way_at_its_coefficient_of_friction_or_not_at_all(tmp_path: Path) -> None:
    blocks = [ground(), box("b", (0, -0.2, 0), (0.6, 0.2, 0.2))]  # in the middle of its plate: planar
    push = 'kind = "push"\nrate = 0.1\ninitial = 0.25'
    summary = push_over(tmp_path, blocks, push, 0.3, 5e-3, 1.0)
    factor = summary["load_factor"]
    assert factor["end"] == pytest.approx(0.35)
    assert factor["limit"] == pytest.approx(0.002)  # a hundredth of its height
    slip = (6.0 * 0.002 / (0.1 * 9.81)) ** (1 / 3)  # d = rate g t^3 / 6 from lambda = mu on
    assert factor["given_way"] == pytest.approx(0.3 + 0.1 * slip, abs=0.1 * 0.02)  # to a frame
    assert factor["given_way_time"] == pytest.approx(0.5 + slip, abs=0.02)
    assert closing_lines(summary)[1].startswith("load factor: 0.32")
    held = push_over(tmp_path, blocks, push, 0.4, 5e-3, 1.0)
    assert held["load_factor"]["given_way"] is None
    assert closing_lines(held)[1] == "load factor: 0.35 at the end, before a block had moved by more than 2 mm"
    assert closing_lines(held)[2] == NOT_THE_LEAST
    assert held["load_factor"]["limit_analysis"] == pytest.approx({"least_found": 0.4, "associated": 0.4}, abs=1e-6)
    assert closing_lines(held)[3] == "limit analysis: 0.4; how joints slide makes no difference here"


def test_the_bracket_of_limit_analysis_stands_beside_a_factor_that_sliding_decides() -> None:
    factor = {"end": 0.4, "limit": 2e-3, "given_way": 0.389, "given_way_time": 1.0, "rigid": True}
    bracket = {"least_found": 0.3558, "associated": 0.40369}
    *_, line = outcome_lines({"load_factor": factor | {"limit_analysis": bracket}})
    assert line == "limit analysis: 0.3558, the least found without dilation, to 0.4037 (associated)"


def test_a_factor_on_elastic_joints_is_not_said_to_be_one_of_several() -> None:
    factor = {"end": 0.3, "limit": 2e-3, "given_way": None, "given_way_time": None, "rigid": False}
    assert outcome_lines({"load_factor": factor}) == [outcome_lines({"load_factor": factor | {"rigid": True}})[0]]


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
    found = summary["load_factor"]["given_way"]
    print(f"{kind}: lambda {found:.4f}, exact (associated) {case['lambda_associated_computed']:.4f}")
    assert found == pytest.approx(case["lambda_associated_computed"], rel=0.03)
