# SPDX-License-Identifier: GPL-3.0-or-later
"""The load factor at which a structure gives way in a run, and loads of limit analysis whose masses a push moves."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from limit_scenes import pillar, said, scene
from models import GRAVITY, box, ground
from small_runs import ran, write_scene

from masonry_cd.analysis.limit import descent
from masonry_cd.app.carried import largest_carried
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import NOT_THE_LEAST, closing_lines, factor_lines
from masonry_cd.app.load_factor import limit_bracket
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import LimitBracket, LoadFactor
from masonry_cd.limit.case import LimitCase, WantedMechanisms, limit_case
from masonry_cd.mechanics.model.blocks import Block


def push_over(
    folder: Path, blocks: list[Block], load: str, mu: float, dt: float, seconds: float, solver: str = "nlgs", way: str = "x"
) -> Summary:
    """The summary of a run of some blocks under a table [[loads]]."""
    run = f'run = {{dt = {dt}, duration = {seconds}, solver = "{solver}", tolerance = 1e-6}}'
    material = f"material = {{density = 2000.0, friction = {mu}}}"
    return ran(write_scene(folder, blocks, f'{material}\n{run}\n[[loads]]\ndirection = "{way}"\n{load}\n'))


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
    assert closing_lines(held)[3] == "limit analysis: 0.4; dilation of sliding joints makes no difference here"
    assert NOT_THE_LEAST not in closing_lines(held)  # there is one factor only


def test_the_bracket_of_limit_analysis_stands_next_to_a_factor_of_rigid_blocks_that_sliding_decides() -> None:
    bracket = LimitBracket(least_found=0.3558, associated=0.40369)
    factor = LoadFactor(end=0.4, limit=2e-3, given_way=0.389, given_way_time=1.0, rigid=True, limit_analysis=bracket)
    first, several, line = factor_lines(factor)
    assert first.startswith("load factor: 0.389 when a block had moved by more than 2 mm, at 1 s; 0.4 at the end")
    assert (several, line) == (NOT_THE_LEAST, "limit analysis: 0.3558, the least found without dilation, to 0.4037 (associated)")
    *_, line = factor_lines(factor.model_copy(update={"limit_analysis": LimitBracket(associated=0.40369)}))
    assert line.startswith("limit analysis: 0.4037 at most (associated); no start")
    assert NOT_THE_LEAST not in factor_lines(factor.model_copy(update={"rigid": False, "limit_analysis": None}))


def test_a_slab_wedged_between_cheeks_has_its_least_factor_next_to_the_one_of_the_solver(tmp_path: Path) -> None:
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
    monkeypatch.setattr(descent, "EXACT", -1.0)  # no start comes to an end
    push = 'kind = "push"\nrate = 0.1\ninitial = 0.1'
    held = push_over(tmp_path, [ground(), box("b", (0, -0.2, 0), (0.6, 0.2, 0.2))], push, 0.4, 5e-3, 0.01)
    assert vars(held.load_factor.limit_analysis) == {"least_found": None, "associated": pytest.approx(0.4, abs=1e-6)}


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


WIDE, HIGH = 0.5, 1.5  # of the pillar, 0.4 m thick
WEIGHT, LOAD = 2000.0 * GRAVITY * WIDE * 0.4 * HIGH, 4000.0
TOP = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [0, 0, {-LOAD}]\npoint = [0.25, 0, {HIGH}]\n'
CHECK = '[limit.check]\nspectrum = "EC8"\nag = 2.0\n'
MIDDLE = (WEIGHT * 0.5 * HIGH + LOAD * HIGH) / (WEIGHT + LOAD)  # height of the centre of both


def steps(case: LimitCase) -> dict[str, float]:
    assert case.check is not None
    return {step.symbol: step.value for step in case.check.steps}


def test_a_mass_on_a_pillar_is_pushed_with_it_and_is_part_of_its_oscillator(tmp_path: Path) -> None:
    """One body: alpha0 = b/2 over the height of the common centre, e* = 1, and the common centre goes b/2 to where the factor vanishes."""
    case = limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\npush = 'x'\nmasses = [0]\n{CHECK}"))
    made = steps(case)
    assert made["alpha0"] == pytest.approx(0.5 * WIDE / MIDDLE, rel=1e-9)
    assert made["sum P"] == pytest.approx(WEIGHT + LOAD, rel=1e-9) and made["e*"] == pytest.approx(1.0, rel=1e-9)
    theta = math.atan(0.5 * WIDE / MIDDLE)  # both are over the toe
    control = 0.5 * WIDE * (1.0 - math.cos(theta)) + 0.5 * HIGH * math.sin(theta)
    assert made["d0*"] == pytest.approx(control * MIDDLE / (0.5 * HIGH), rel=1e-4)
    assert not any("without mass" in line for line in said(case))


def test_a_force_without_mass_is_said_next_to_a_check(tmp_path: Path) -> None:
    """The push does not move it: it steadies the pillar, and e* is of the block alone."""
    case = limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\npush = 'x'\n{CHECK}displacements = false\n"))
    made = steps(case)
    assert made["alpha0"] == pytest.approx((WEIGHT + LOAD) * 0.5 * WIDE / (WEIGHT * 0.5 * HIGH), rel=1e-9)
    assert made["sum P"] == pytest.approx(WEIGHT, rel=1e-9)
    assert any("loads[0] (point) acts as a force without mass" in line and "limit.masses = [0]" in line for line in said(case))


def test_gravity_on_masses_is_tilted_with_that_of_the_blocks(tmp_path: Path) -> None:
    pushed, tilted = (
        limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\n{way} = 'x'\nmasses = [0]\n")).whole.analysis.associated.factor
        for way in ("push", "tilt")
    )
    assert tilted == pytest.approx(pushed, rel=1e-12)


def test_the_curves_of_masses_and_of_live_loads_are_those_of_the_moved_blocks(tmp_path: Path) -> None:
    """Balance of moments about the toe at every point: a mass goes with its block, as the point of attack of a live load does."""
    side = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [1000.0, 0, 0]\npoint = [0.25, 0, {HIGH}]\n'
    for tables in (f"{TOP}[limit]\npush = 'x'\nmasses = [0]\n", f"{TOP}{side}[limit]\nlive = [1]\n"):
        case = limit_case(scene(tmp_path, pillar(), tables), wanted=WantedMechanisms(curve=True))
        assert case.whole.curve is not None and case.whole.curve.falls
        for k in range(0, len(case.whole.curve.factor), 7):
            stage = case.whole.curve.stages[k]
            top = stage.assembly.blocks[1].vertices
            x, z = top[np.argsort(top[:, 2])[-2:]].mean(axis=0)[[0, 2]] if k == 0 else _top(top)
            centre = stage.assembly.centre[1]
            borne = WEIGHT * (WIDE - centre[0]) + LOAD * (WIDE - x)
            turns = 1000.0 * z if "live" in tables else WEIGHT * centre[2] + LOAD * z
            assert stage.factor == pytest.approx(borne / turns, abs=1e-6)


def _top(corners: np.ndarray) -> tuple[float, float]:
    """Where the middle of the top of the pillar is, x and z: its two pairs of corners farthest from the toe but for the heel."""
    away = np.hypot(corners[:, 0] - WIDE, corners[:, 2])
    order = np.argsort(away)
    some = corners[np.concatenate([order[-2:], order[-4:-2]])]
    return float(some[:, 0].mean()), float(some[:, 2].mean())


def test_masses_count_in_macro_elements(tmp_path: Path) -> None:
    part = '[[limit.mechanism]]\nblocks = ["a"]\ndirection = "x"\nmechanisms = ["overturning"]\n[limit]\nmasses = [0]\n'
    part += f"{CHECK}displacements = false\n"
    case = limit_case(scene(tmp_path, pillar(), TOP + part), wanted=WantedMechanisms(jobs=1))
    first = case.mechanisms[0].row
    assert first["alpha0"] == pytest.approx(0.5 * WIDE / MIDDLE, rel=1e-6) and first["fraction"] == pytest.approx(1.0, rel=1e-6)
