# SPDX-License-Identifier: GPL-3.0-or-later
"""Assessments: the levels of each assumption are scenes that can be run, and differ from the base case in that alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import masonry_cd, refusal
from typer.testing import Result

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.app.case import structure_of
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.model.masonry_kinds import KINDS
from masonry_cd.studies.assess.command import check_statics
from masonry_cd.studies.assess.plan import AssessPlan
from masonry_cd.studies.assess.task import assess_task
from masonry_cd.studies.study.checks import scene_of_run
from masonry_cd.studies.study.task import Outcome, Task

WALL: dict[str, Any] = {
    "structure": {"kind": "wall", "length": 2.0, "height": 1.5, "thickness": 0.3, "course_height": 0.5},
    "material": {"density": 2000.0, "friction": 0.5},
    "loads": [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 1}],
    "run": {"dt": 2e-3, "duration": 0.5, "tolerance": 1e-5},
}


def scene(**changes: Any) -> Scene:
    """The wall, with other tables."""
    return parse_scene(dump_toml(WALL | changes), Path("wall.toml"), called="wall")


def levels(plan: AssessPlan) -> dict[str, list[str]]:
    """Names of the levels by assumption."""
    return {one.name: [level.name for level in one.levels] for one in plan.known}


def of_level(plan: AssessPlan, name: str, level: str) -> Scene:
    """The scene of a level, read as a worker reads it."""
    (run,) = [run for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == "level" and part.values() == {name: level}]
    return scene_of_run(plan.maker.tables(run.asked))


# --- levels ---------------------------------------------------------------------------------------------------------------------------


def test_a_scene_without_masonry_is_rigid_and_varied_over_what_stone_has() -> None:
    plan = AssessPlan(scene())
    found = levels(plan)
    assert found["joint stiffness"] == ["E 3.3 GPa", "E 1.5 GPa", "E 0.7 GPa"]
    soft = of_level(plan, "joint stiffness", "E 0.7 GPa")
    assert soft.material.joint_moduli == pytest.approx((0.7e9, 0.7e9 / 3.0), rel=0.01)
    assert soft.material.block_density == 2000.0
    assert found["damping"] == ["0 %", "2 %", "5 %"]
    damped = of_level(plan, "damping", "5 %")
    assert damped.material.joint_moduli == of_level(plan, "joint stiffness", "E 1.5 GPa").material.joint_moduli
    assert damped.material.joints["default"].damping == 0.05


def test_a_named_masonry_gives_its_own_range() -> None:
    plan = AssessPlan(scene(material={"masonry": "squared stone", "friction": 0.5}))
    assert levels(plan)["joint stiffness"] == ["rigid", "E 3.3 GPa", "E 2.4 GPa"]
    least = of_level(plan, "joint stiffness", "E 2.4 GPa").material
    assert least.joint_moduli == pytest.approx([1e6 * KINDS["squared stone"].young.least, 1e6 * KINDS["squared stone"].rigidity.least])
    assert of_level(plan, "joint stiffness", "rigid").material.joint_moduli is None
    assert levels(plan)["damping"] == ["2 %", "5 %"]
    assert of_level(plan, "damping", "2 %").material.joint_moduli == plan.maker.study.scene.material.joint_moduli


def test_stated_stiffnesses_give_way_and_the_rest_of_the_law_stays() -> None:
    law = {"normal_stiffness": 1e10, "cohesion": 1e5, "damping": 0.05, "damping_frequency": 5.0}
    plan = AssessPlan(scene(material=WALL["material"] | {"joints": {"wall-wall": law}}))
    rigid = of_level(plan, "joint stiffness", "rigid").material
    assert (rigid.joints["wall-wall"].normal_stiffness, rigid.joints["wall-wall"].damping) == (None, 0.0)
    assert rigid.joints["wall-wall"].cohesion == 1e5
    soft = of_level(plan, "joint stiffness", "E 0.7 GPa").material
    assert soft.joints["wall-wall"].normal_stiffness is None
    assert soft.joints["wall-wall"].damping == 0.05
    assert of_level(plan, "damping", "0 %").material.joints["wall-wall"].damping == 0.0


@pytest.mark.parametrize(
    ("friction", "ranges", "low", "high"),
    [
        (0.5, None, 0.4, 0.6),
        ({"wall-wall": 0.5, "default": 0.8}, None, {"wall-wall": 0.4, "default": 0.64}, {"wall-wall": 0.6, "default": 0.96}),
        (0.5, [0.35, 0.7], 0.35, 0.7),
        (
            {"wall-wall": 0.5, "default": 0.8},
            {"wall-wall": [0.3, 0.9]},
            {"wall-wall": 0.3, "default": 0.8},
            {"wall-wall": 0.9, "default": 0.8},
        ),
    ],
)
def test_friction_has_twenty_per_cent_or_the_range_of_the_scene(friction: Any, ranges: Any, low: Any, high: Any) -> None:
    stated = {} if ranges is None else {"assess": {"friction": ranges}}
    plan = AssessPlan(scene(material={"density": 2000.0, "friction": friction}, **stated))
    ends = [of_level(plan, "friction", level).material.friction for level in levels(plan)["friction"]]
    assert ends == [pytest.approx(low), pytest.approx(high)]


def test_a_scene_may_state_e_and_damping_and_leave_out_what_is_known() -> None:
    stated = {"young": ["1 GPa", "2 GPa"], "damping": [0.0, 0.1], "leave_out": ["bond", "tolerance"], "members": 4}
    plan = AssessPlan(scene(assess=stated))
    assert levels(plan)["joint stiffness"] == ["E 2 GPa", "E 1.5 GPa", "E 1 GPa"]
    assert levels(plan)["damping"] == ["0 %", "10 %"]
    assert "tolerance" not in levels(plan)
    assert [one.why for one in plan.left_out if one.name == "tolerance"] == ["left out by the scene, assess.leave_out"]
    assert sum(part.kind == "ensemble" for part in plan.parts) == 3


def test_smaller_blocks_are_built_and_kinds_without_a_size_are_named() -> None:
    plan = AssessPlan(scene())
    counts = [len(structure_of(of_level(plan, "block size", level)).blocks) for level in ("x 0.7", "x 1.4")]
    assert counts[0] > len(structure_of(plan.maker.study.scene).blocks) > counts[1]
    assert ("bond", 'a structure of kind "wall" has no key for its bond') in [(one.name, one.why) for one in plan.left_out]


def test_larger_blocks_that_find_no_place_are_left_out_and_the_plan_says_why() -> None:
    church = {"kind": "church", "block_length": 2.0, "width": 6.0, "length": 14.0, "height": 6.0, "thickness": 0.9, "tower": False}
    openings = {"door_width": 1.6, "door_height": 2.5, "windows": 0, "course_height": 0.75, "apse_radius": 2.2, "apse_height": 3.5}
    plan = AssessPlan(scene(structure=church | openings))
    assert levels(plan)["block size"] == ["x 0.7"]
    (left,) = (one for one in plan.left_out if one.name.startswith("block size"))
    assert left.name == "block size x 1.4"
    assert left.why == "structure.block_length: must be at most a third of the width, 2 m, got 2.8"
    known = AssessPlan(scene(structure=church | openings, assess={"leave_out": ["block size"]}))
    assert [one.name for one in known.left_out if one.name.startswith("block size")] == ["block size"]


def test_bonds_that_soften_and_stones_that_crack_are_varied_and_every_level_can_be_built() -> None:
    law = {"normal_stiffness": 2e10, "cohesion": 1.5e5, "tension": 1e5, "fracture_energy": 0.4, "shear_fracture_energy": 60.0}
    stones = {"tensile_strength": 2e6, "young": 2e10, "fracture_energy": 100.0}
    plan = AssessPlan(scene(material=WALL["material"] | {"joints": law, "stones": stones}))
    found = levels(plan)
    assert found["joint stiffness"] == ["x 2"]
    assert found["bond energy"] == ["x 2"]
    assert {"joint stiffness x 0.5", "bond energy x 0.5"} <= {one.name for one in plan.left_out}  # less than their springs store
    assert found["stone strength"] == ["whole", "x 0.7", "x 1.4"]
    weak = of_level(plan, "stone strength", "x 0.7").material.stones["default"]
    assert (weak.tensile_strength, weak.fracture_energy) == pytest.approx((1.4e6, 49.0))
    assert not of_level(plan, "stone strength", "whole").material.stones
    for name in ("joint stiffness", "bond energy", "stone strength"):
        for level in found[name]:
            structure_of(of_level(plan, name, level))


def test_stones_that_follow_the_masonry_keep_its_modulus_where_joints_become_rigid() -> None:
    plan = AssessPlan(scene(material={"masonry": "squared stone", "friction": 0.5, "stones": {"tensile_strength": 2e6}}))
    rigid = of_level(plan, "joint stiffness", "rigid")
    assert rigid.material.stones["default"].young == plan.maker.study.scene.material.joint_moduli[0]
    structure_of(rigid)


def test_stones_of_a_kind_are_varied_about_its_strength_and_keep_its_modulus() -> None:
    plan = AssessPlan(scene(material={"masonry": "squared stone", "friction": 0.5, "stones": {"kind": "limestone"}}))
    own = plan.maker.study.scene.material.stones["default"]
    assert of_level(plan, "stone strength", "x 0.7").material.stones["default"].strength == pytest.approx(0.7 * own.strength)
    assert of_level(plan, "joint stiffness", "rigid").material.stones["default"].modulus == own.modulus


def test_half_a_time_step_and_a_tenth_of_the_tolerance() -> None:
    plan = AssessPlan(scene())
    assert of_level(plan, "time step", "1 ms").run.dt == 1e-3
    assert of_level(plan, "tolerance", "1e-06").run.tolerance == pytest.approx(1e-6)
    adaptive = AssessPlan(scene(run={"dt": "auto", "duration": 0.5}))
    halved, base = of_level(adaptive, "time step", "up to 5 ms").run, adaptive.maker.study.scene.run
    assert (halved.longest_step, halved.dt) == (0.5 * base.longest_step, 0.5 * base.dt)


BY_PAIR = {"wall-base": {"cohesion": 1e4, "tension": 0.0}}


@pytest.mark.parametrize(
    ("material", "base", "coarser", "finer"),
    [
        ({"joints": {"normal_stiffness": 1e10}}, "9", ["5", "7"], ["11", "15"]),
        ({"masonry": "solid brick"}, "9", ["5", "7"], ["11", "15"]),
        ({"masonry": "solid brick", "joints": BY_PAIR}, "9", ["5", "7"], ["11", "15"]),
        ({"joints": {"normal_stiffness": 1e10, "joint_points": 7}}, "7", ["5"], ["11", "15"]),
        ({"joints": {"normal_stiffness": 1e10, "compressive_strength": 5e6}}, "11", ["5", "7"], ["15"]),
        ({"joints": {"wall-wall": {"normal_stiffness": 1e10, "joint_points": 3}, "default": {}}}, "3", [], ["5", "7", "11", "15"]),
    ],
)
def test_points_of_elastic_joints_are_varied_and_coarser_ones_do_not_count(material, base, coarser, finer) -> None:
    plan = AssessPlan(scene(material=WALL["material"] | material))
    (known,) = (one for one in plan.known if one.name == "joint points")
    assert known.base == base
    assert [level.name for level in known.levels if level.coarser] == coarser
    assert [level.name for level in known.levels if not level.coarser] == finer
    for level in known.levels:
        varied = of_level(plan, "joint points", level.name)
        laws, elastic = structure_of(varied).assembly.laws, structure_of(varied).assembly.laws.elastic
        assert set(laws.points[elastic].astype(int)) == {int(level.name)}


@pytest.mark.parametrize(("law", "why"), [({}, "rigid"), ({"normal_stiffness": 1e10, "joint_points": 15}, "15")])
def test_points_are_left_out_of_rigid_joints_and_of_those_with_the_most(law: dict[str, Any], why: str) -> None:
    plan = AssessPlan(scene(material=WALL["material"] | {"joints": law}) if law else scene())
    assert [why in one.why for one in plan.left_out if one.name == "joint points"] == [True]


def test_rigid_joints_lose_what_only_springs_have() -> None:
    law = {"normal_stiffness": 1e10, "joint_points": 7, "cohesion": 1e5, "tension": 1e4}
    plan = AssessPlan(scene(material=WALL["material"] | {"joints": law}), all_pairs=True)
    rigid = of_level(plan, "joint stiffness", "rigid").material.joints["default"]
    assert (rigid.normal_stiffness, rigid.joint_points, rigid.tension, rigid.cohesion) == (None, None, None, 1e5)
    assert not [1 for part in plan.parts if part.values() == {"joint stiffness": "rigid", "joint points": "15"}]


# --- runs -----------------------------------------------------------------------------------------------------------------------------


def test_each_run_is_named_by_its_scene_and_the_base_case_is_first() -> None:
    plan = AssessPlan(scene())
    assert plan.parts[0].kind == "base"
    shared = {
        run.name
        for part, run in zip(plan.parts, plan.runs, strict=True)
        if part.values() in ({"damping": "0 %"}, {"joint stiffness": "E 1.5 GPa"})
    }
    assert len(shared) == 1  # joints of the mean E without damping are one run
    assert len({run.name for run in plan.runs}) == len(plan.runs) - 1
    again = AssessPlan(scene(assess={"leave_out": ["friction"]}))
    assert again.runs[0].name == plan.runs[0].name  # what is varied is not part of a scene that runs
    assert not scene_of_run(plan.maker.tables(plan.runs[0].asked)).until_still  # as the scene is
    graded = AssessPlan(scene(report={"damage": True}))
    assert scene_of_run(graded.maker.tables(graded.runs[0].asked)).until_still


def test_members_of_the_ensemble_differ_by_a_billionth() -> None:
    plan = AssessPlan(scene())
    amplitudes = [plan.maker.tables(run.asked)["loads"][0]["amplitude"] for run in plan.runs[:8]]
    assert amplitudes == pytest.approx([0.2 * (1.0 + k * 1e-9) for k in range(8)], rel=1e-14)
    assert len(set(amplitudes)) == 8


def test_a_scene_without_a_motion_of_the_base_is_set_in_motion() -> None:
    settles = {"kind": "settlement", "supports": "base", "displacement": 1e-3, "duration": 1.0}
    plan = AssessPlan(scene(loads=[settles]))
    seeds = [plan.maker.tables(run.asked)["run"].get("first_velocities") for run in plan.runs[:3]]
    assert seeds == [None, {"size": 1e-9, "seed": 1}, {"size": 1e-9, "seed": 2}]


def test_all_pairs_have_two_levels_of_each_two() -> None:
    plan = AssessPlan(
        scene(material={"masonry": "solid brick", "friction": 0.5}, assess={"leave_out": ["block size", "joint points", "time step"]}),
        all_pairs=True,
    )
    pairs = [part.values() for part in plan.parts if part.kind == "pair"]
    assert {"joint stiffness": "E 1.2 GPa", "friction": "0.4"} in pairs
    assert {"joint stiffness": "rigid", "damping": "5 %"} not in pairs  # rigid joints do not vibrate
    assert len(pairs) == 2 * 2 + (2 * 2 - 2) + 2 + 2 * 2 + 2 + 2
    for part, run in zip(plan.parts, plan.runs, strict=True):
        if part.kind == "pair":
            scene_of_run(plan.maker.tables(run.asked))


# --- all at once ----------------------------------------------------------------------------------------------------------------------


def test_all_properties_vary_at_once_and_settings_of_the_computation_do_not() -> None:
    plan = AssessPlan(scene(assess={"samples": 20}), at_once=True)
    drawn = [(part, run) for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == "global"]
    assert len(drawn) == 20
    assert [one.name for one in plan.unknown] == ["joint stiffness", "friction", "block size", "damping"]
    for part, run in drawn:
        made, u = scene_of_run(plan.maker.tables(run.asked)), dict(zip((one.name for one in plan.unknown), part.at, strict=True))
        assert made.material.joint_moduli[0] == pytest.approx(0.7e9 * (3.3 / 0.7) ** u["joint stiffness"])
        assert made.material.friction == pytest.approx(0.4 + 0.2 * u["friction"])
        assert made.material.joints["default"].damping == pytest.approx(0.05 * u["damping"])
        assert (made.run.dt, made.run.tolerance) == (2e-3, 1e-5)
    more = AssessPlan(scene(assess={"samples": 30}), at_once=True)
    assert {run.name for run in plan.runs} < {run.name for run in more.runs}
    assert len(AssessPlan(scene(), at_once=True).parts) == len(AssessPlan(scene()).parts) + 40
    rigid = AssessPlan(scene(assess={"leave_out": ["joint stiffness"]}), at_once=True)
    assert [one.name for one in rigid.unknown] == ["friction", "block size"]


def test_changes_of_one_structure_follow_each_other() -> None:
    plan = AssessPlan(scene_bridge(), all_pairs=True)
    pairs = {tuple(part.values().items()): run for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == "pair"}
    size, bond = ("block size", "x 0.7"), ("bond", "rings as one")
    both = plan.maker.tables(pairs[size, bond].asked)["structure"]["spans"][0]
    assert (both["rings"], both["voussoirs"]) == (1, 10)


def test_fewer_than_two_properties_are_refused() -> None:
    with pytest.raises(InputError, match=r"assess\.leave_out: fewer than two properties are left to vary at once"):
        AssessPlan(scene(limit={"push": "y"}, loads=[], assess={"leave_out": ["block size"]}), at_once=True)


def test_indices_of_a_load_factor_are_on_the_page_and_in_the_files(tmp_path: Path) -> None:
    tables = WALL | {"limit": {"push": "y"}, "loads": [], "assess": {"samples": 20}, "material": {"density": 2000.0, "friction": 0.15}}
    result = command(tmp_path, tables, "--workers", "1", "--global")
    assert result.exit_code == 0, result.output
    assert "all at once, 20 runs: load factor: of its variance friction 100 %" in result.stdout  # it slides before it overturns
    facts = json.loads((tmp_path / "out" / "assess.json").read_text())
    first = {one["property"]: one["first"] for one in facts["found"]["indices"]}
    assert first == pytest.approx({"friction": 1.0, "block size": 0.0}, abs=0.03)
    assert "All varied together" in (tmp_path / "out" / "assess.html").read_text()
    assert (tmp_path / "out" / "assess_global.png").is_file()
    single = command(tmp_path, tables, "--workers", "1")
    assert single.exit_code == 0, single.output
    assert not (tmp_path / "out" / "assess_global.png").exists()
    assert "sampled" not in json.loads((tmp_path / "out" / "assess.json").read_text())


def test_a_run_answers_with_residual_opening_and_grade(tmp_path: Path) -> None:
    plan = AssessPlan(
        scene(run={"dt": 4e-3, "duration": 0.02, "longest": 0.04}, limit={"push": "y"}, loads=[WALL["loads"][0] | {"cycles": 0.01}])
    )
    outcome = assess_task(Task("a", plan.maker.tables(plan.runs[0].asked), 60.0))
    row = outcome.row
    assert row.done
    assert row.number("grade") == "D0"
    assert row.number("residual_opening") <= row.number("max_opening")
    assert row.number("load_factor") == pytest.approx(0.3 / 1.5, rel=1e-3)  # thickness over height: it overturns
    assert "limit" not in plan.maker.tables(plan.runs[1].asked)  # of the ensemble: statics does not change


def test_joints_that_do_not_settle_take_the_weight_at_once_and_the_row_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def run(task: Task) -> Outcome:
        asked.append(task.tables["run"].get("settle", True))
        reason = 'run.settle: block "b" does not come to rest under its weight' if asked[-1] else ""
        return Outcome(task.name, RunRow("failed" if reason else "done", reason, 1.0))

    monkeypatch.setattr("masonry_cd.studies.assess.task.run_task", run)
    row = assess_task(Task("a", {"run": {"dt": 1e-3}}, 60.0)).row
    assert asked == [True, False]
    assert (row.status, row.remark) == ("done", "weight at once")


# --- the command ----------------------------------------------------------------------------------------------------------------------

STATIC = {"limit": {"push": "y"}, "loads": [], "assess": {"leave_out": ["block size"]}}


def command(folder: Path, tables: dict[str, Any], *options: str) -> Result:
    """The command on a scene next to its results."""
    (folder / "scene.toml").write_text(dump_toml(tables), encoding="utf-8")
    return masonry_cd("assess", folder / "scene.toml", "-o", folder / "out", *options)


def test_a_scene_of_limit_analysis_has_its_factor_assessed_and_goes_on(tmp_path: Path) -> None:
    result = command(tmp_path, WALL | STATIC, "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "load factor" in result.stdout
    assert "not varied: joint stiffness: limit analysis is of rigid blocks at rest" in result.stdout
    facts = json.loads((tmp_path / "out" / "assess.json").read_text())
    assert {one["status"] for one in facts["members"]} == {"done"}
    assert {"assess.png", "assess.html", "assess.csv"} <= {file.name for file in (tmp_path / "out").iterdir()}
    again = command(tmp_path, WALL | STATIC, "--workers", "1")
    assert "3 runs, 0 still to run" in again.stderr
    other = command(tmp_path, WALL | STATIC | {"material": {"density": 2000.0, "friction": 0.6}})
    assert other.exit_code == 2
    assert "holds another study" in other.stderr


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"loads": [{"kind": "sinusoidal", "amplitude": 0.1}]}, "loads[0].direction"),
        ({"structure": {"kind": "wall", "lenght": 1.0}}, "structure.lenght"),
        (STATIC | {"limit": {}, "loads": [{"kind": "sinsoidal"}]}, "loads[0].kind"),
        (STATIC | {"limit": {"push": "q"}}, "limit.push"),
    ],
)
def test_a_scene_that_cannot_be_run_is_refused_before_its_levels(tmp_path: Path, changes: dict[str, Any], key: str) -> None:
    found = refusal(command(tmp_path, WALL | changes, "--workers", "1"))
    assert f"{key}: " in str(found)
    assert not (tmp_path / "out").exists()


def test_a_scene_without_steps_is_refused_by_its_key() -> None:
    tables = {key: value for key, value in (WALL | STATIC).items() if key != "run"}
    with pytest.raises(InputError) as refused:
        AssessPlan(parse_scene(dump_toml(tables), Path("wall.toml"), called="wall"))
    assert refused.value.faults[0].text.startswith("run: ")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, ["assess.young[0] = 2600 Pa: ", "material.density = 2 kg/m3: "]),
        ({"quiet_checks": ["assess.young", "material.density"]}, []),
        ({"quiet_checks": ["assess.young"]}, ["material.density = 2 kg/m3: "]),
    ],
)
def test_values_that_are_likely_in_another_unit_draw_their_line_before_any_run_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], said: list[str]
) -> None:
    monkeypatch.setattr("masonry_cd.studies.study.study_case._Making.execute", lambda *_: None)
    doubtful = WALL | {"material": {"density": 2.0, "friction": 0.5}, "assess": {"young": [2600, 3e9]}} | changes
    result = command(tmp_path, doubtful, "-q")
    shown = [line.partition("warning: ")[2] for line in result.stderr.splitlines() if "quiet_checks" in line]
    assert [line.startswith(begin) for line, begin in zip(shown, said, strict=True)] == [True] * len(said)


BRIDGE: dict[str, Any] = {
    "structure": {
        "kind": "bridge",
        "abutments": [{"rigid": False, "width": 2.0}],
        "spans": [{"span": 4.0, "rise": 1.2, "thickness": 0.4, "voussoirs": 7, "rings": 2}],
    },
    "material": {"density": 2000.0, "friction": 0.6},
    "loads": [{"kind": "vehicle", "axles": [1e5], "position": 1.0}],
    "limit": {"live": [0], "starts": 1},
    "run": {"dt": 2e-3, "duration": 0.5},
}


def scene_bridge(**changes: Any) -> Scene:
    return parse_scene(dump_toml(BRIDGE | changes), Path("bridge.toml"), called="bridge")


def test_fill_block_size_and_rings_of_a_bridge_are_varied_and_the_load_factor_follows_them() -> None:
    plan = AssessPlan(scene_bridge())
    assert {one.name: [level.name for level in one.levels] for one in plan.known} == {
        "friction": ["0.48", "0.72"],
        "block size": ["x 0.7", "x 1.4"],
        "bond": ["rings as one"],
        "fill resistance": ["none", "twice"],
        "fill spread": ["2:1"],
        "fill pressure": ["active", "none"],
        "fill angle": ["25 degrees", "35 degrees"],
    }
    by_level = {tuple(part.values().items()): run for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == "level"}
    factors = [
        limit_case(scene_of_run(plan.maker.tables(by_level[(level,)].asked))).whole.analysis.governing.factor
        for level in (("fill resistance", "none"), ("fill angle", "25 degrees"), ("fill angle", "35 degrees"), ("fill resistance", "twice"))
    ]
    assert factors == sorted(factors)
    assert factors[0] < 0.9 * factors[-1]


def test_what_has_no_effect_is_left_out_with_the_reason() -> None:
    structure = {**BRIDGE["structure"], "abutments": [{"rigid": True}]}
    plan = AssessPlan(scene_bridge(structure=structure, loads=[], limit={"push": "x"}, assess={"leave_out": ["fill angle"]}))
    left = {one.name: one.why for one in plan.left_out}
    assert left["fill spread"] == "no vehicle stands on it"
    assert left["fill pressure"] == "it presses nothing that may move"
    assert left["fill angle"] == "left out by the scene, assess.leave_out"
    assert "fill resistance" in [one.name for one in plan.known]


@pytest.mark.parametrize("vehicle", [{"position": 1.0}, {}])
def test_statics_are_checked_with_the_fill_and_with_a_vehicle_that_has_no_place_yet(vehicle: dict[str, float]) -> None:
    check_statics(AssessPlan(scene_bridge(loads=[{"kind": "vehicle", "axles": [1e5], **vehicle}])))
