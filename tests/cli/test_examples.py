# SPDX-License-Identifier: GPL-3.0-or-later
"""Every scene in examples/ runs, and one number of each is known beforehand."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from places import EXAMPLES

from loads.motion import STANDARD_GRAVITY
from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.app.case import make_structures, prepare
from masonry_cd.app.limit_table import limit_of
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.studies.calibrate.plan import Calibration
from masonry_cd.studies.calibrate.predicted import PREDICTED, calibrate_task
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.study_case import plan_of
from masonry_cd.studies.study.study_file import read_study
from masonry_cd.studies.study.task import Task, run_task
from structures import kind_of
from structures.macro_elements import macro_elements

GRAVITY = 9.81


def run(name: str, folder: Path, *changes: str) -> Summary:
    """Run an example without its pictures and return its summary."""
    return run_case(prepare(read_scene(EXAMPLES / name, [*changes, "report.crack_map=false"])), folder)


def base_reaction(folder: Path) -> tuple[float, float]:
    """Sum of the normal forces of the joints on fixed blocks in the last frame, and the weight of the free blocks [N]."""
    from masonry_cd.mechanics.model.blocks import Assembly

    with Results.open(folder / "result.h5") as results:
        assembly, joints = Assembly.from_blocks(results.blocks, 0.5), results.joints
        on_base = assembly.fixed[joints.block_a] ^ assembly.fixed[joints.block_b]
        force = results.joint_history("normal_force")[-1]
        return float(force[on_base].sum()), float(assembly.mass[~assembly.fixed].sum() * GRAVITY)


def test_every_example_is_tested_here():
    text = Path(__file__).read_text(encoding="utf-8")
    for scene in EXAMPLES.glob("*.toml"):
        assert f'"{scene.name}"' in text, f"no test runs {scene.name}"


def test_the_parts_of_the_church_are_those_of_practice():
    """In the plan of examples/church_parts.toml; its macro-elements are analysed in tests of their own, on smaller churches."""
    made = make_structures(read_scene(EXAMPLES / "church_parts.toml", []))
    names = " ".join(part.name for part in macro_elements(made[0], kind_of("church").parts))
    assert all(word in names for word in ("facade", "triumphal arch", "apse", "belfry"))


def test_the_check_of_the_church_takes_ag_from_the_hazard_of_its_site():
    check = limit_of(read_scene(EXAMPLES / "church_parts.toml", [])).check
    power = math.log(50.0 / -math.log(0.9) / 201.0) / math.log(475.0 / 201.0)
    assert check is not None and check.ag == pytest.approx(1.48 * (2.0 / 1.48) ** power)
    assert check.tc_star == pytest.approx(0.3 * (0.32 / 0.3) ** power)


def test_the_springings_of_the_arch_carry_its_weight(tmp_path):
    summary = run("arch.toml", tmp_path, "run.duration=0.05", "loads[0].amplitude=0")
    reaction, weight = base_reaction(tmp_path)  # the springing joints of a semicircle are level
    assert reaction == pytest.approx(weight, rel=1e-6)
    assert summary.joints_opened == summary.joints_slid == 0
    assert summary.displacement_max < 1e-6


def test_the_base_of_the_aqueduct_moves_as_the_scene_says(tmp_path):
    summary = run("aqueduct_sinusoidal.toml", tmp_path, "run.duration=0.1")
    assert summary.blocks >= 150
    assert summary.energy.balance_error < 1e-3
    with Results.open(tmp_path / "result.h5") as results:
        fixed = np.array([block.fixed for block in results.blocks])
        moved = results.position[results.frames - 1][fixed, 0] - results.position[0][fixed, 0]
    omega = 2 * math.pi * 1.5
    assert moved == pytest.approx(0.25 / omega * (1 - math.cos(omega * 0.1)), rel=5e-4)  # steps of 4 ms: (omega dt)^2 / 12


@pytest.mark.slow(reason="settles a tower of hundreds of blocks")
def test_the_tower_rests_on_its_joints_before_it_is_shaken(tmp_path):
    larger = ("structure.unit_length=1.0", "structure.course_height=0.6")
    summary = run("tower.toml", tmp_path, *larger, "run.duration=0.03", "report.damage=false", "run.tolerance=1e-6")
    reaction, weight = base_reaction(tmp_path)
    assert reaction == pytest.approx(weight, rel=1e-4)
    assert summary.energy.elastic > 1e3
    with Results.open(tmp_path / "result.h5") as results:
        moved = results.position[results.frames - 1] - results.position[0]
    assert abs(moved).max() < 1e-6  # it settled before, by a millimetre


def test_the_aqueduct_stands_on_its_piers_at_rest(tmp_path):
    summary = run("aqueduct_sinusoidal.toml", tmp_path, "run.duration=0.06", "loads[0].amplitude=0", "run.tolerance=1e-8")
    reaction, weight = base_reaction(tmp_path)
    assert reaction == pytest.approx(weight, rel=1e-6)
    assert summary.displacement_max < 1e-4


@pytest.mark.parametrize(("share", "opened"), [(0.98, 0), (1.1, 4)])
def test_the_trilithon_rocks_beyond_the_slope_of_its_posts(tmp_path, share, opened):
    amplitude = share * GRAVITY * 0.8 / 2.4 / (2 * math.pi * 2.0)
    summary = run("trilithon.toml", tmp_path, f"loads[0].amplitude={amplitude}", "run.duration=1.0")
    assert summary.joints_opened == opened
    assert (summary.displacement_max < 1e-6) == (opened == 0)


def test_the_mortar_wall_stands_on_its_springs_and_no_bond_breaks_at_rest(tmp_path):
    summary = run("mortar_wall.toml", tmp_path, "run.duration=0.05", "loads[0].amplitude=0")
    reaction, weight = base_reaction(tmp_path)
    assert reaction == pytest.approx(weight, rel=1e-5)
    assert summary.joints_bonded == summary.joints
    assert summary.joints_broken == 0
    with Results.open(tmp_path / "result.h5") as results:
        sunk = (results.position[0] - results.position[results.frames - 1])[:, 2]
    assert abs(sunk).max() < 1e-9  # it settled before the run


def test_the_record_shakes_the_aqueduct_at_its_scale(tmp_path, shared):
    record = shared / "records" / "laquila_2009_AQV.csv"
    paths = [f"loads[{i}].path={record}" for i in range(3)]
    summary = run("aqueduct_record.toml", tmp_path, *paths, "run.duration=0.05")
    pga = [table["after"]["pga"] for table in summary.loads.tables if table["kind"] == "record"]
    assert pga == pytest.approx([0.5 * 5.366, 0.5 * 6.507, 0.5 * 5.169], rel=0.02)  # the baseline correction changes it a little
    assert json.loads((tmp_path / "summary.json").read_text())["blocks"] == summary.blocks


@pytest.mark.slow(reason="an aqueduct in space")
def test_the_aqueduct_of_arles_moves_across_twice_as_far_as_along(tmp_path):
    summary = run("aqueduct_arles.toml", tmp_path, "run.duration=0.04", "report.damage=false")
    assert not summary.planar
    assert summary.energy.balance_error < 1e-6
    with Results.open(tmp_path / "result.h5") as results:
        fixed = np.array([block.fixed for block in results.blocks])
        moved = results.position[results.frames - 1][fixed] - results.position[0][fixed]
    omega, size = 2 * math.pi * 1.5, math.hypot(0.5, 1.0)
    far = 0.3 / omega * (1 - math.cos(omega * 0.04))
    assert moved == pytest.approx(np.tile([0.5 / size * far, 1.0 / size * far, 0.0], (len(moved), 1)), rel=5e-4)


@pytest.mark.slow(reason="a church of 500 to 800 blocks")
def test_the_three_naves_stand_at_rest(tmp_path):
    summary = run("church_sine.toml", tmp_path, "run.duration=0.05", "loads[0].amplitude=0", "report.damage=false", "run.tolerance=1e-6")
    reaction, weight = base_reaction(tmp_path)
    assert reaction == pytest.approx(weight, rel=1e-4)
    assert 500 <= summary.blocks <= 800
    assert summary.displacement_max < 1e-6
    assert summary.joints_opened == summary.joints_slid == 0


@pytest.mark.slow(reason="hundreds of spheres between walls")
def test_the_three_leaf_walls_stand_at_rest_and_their_rubble_does_not_count_as_fallen(tmp_path):
    summary = run("three_leaf_wall.toml", tmp_path, "run.duration=0.06", "loads[0].amplitude=0", "report.html=false", "run.tolerance=1e-4")
    assert summary.collapsed_blocks == 0
    assert summary.energy.balance_error < 1e-6
    with Results.open(tmp_path / "result.h5") as results:
        moved = np.linalg.norm(results.position[results.frames - 1] - results.position[0], axis=1)
        rolls = np.array([block.radius > 0.0 for block in results.blocks])
        assert {block.structure for block in results.blocks if block.radius} == {"rubble"}
    assert moved[~rolls].max() < 1e-3
    assert 0.0 < moved[rolls].max() < 0.05


@pytest.mark.slow(reason="hundreds of spheres")
def test_the_spheres_of_the_box_stay_in_it_and_fall_as_bodies_do(tmp_path):
    summary = run("segregation_box.toml", tmp_path, "run.duration=0.03", "report.html=false")
    with Results.open(tmp_path / "result.h5") as results:
        spheres = np.array([block.radius > 0.0 for block in results.blocks])
        last, first = (results.position[frame][spheres] for frame in (results.frames - 1, 0))
        sizes = {block.radius for block in results.blocks if block.radius}
    assert sizes == {0.02, 0.04}
    assert summary.energy.balance_error < 1e-9
    assert np.max(first[:, 2] - last[:, 2]) == pytest.approx(0.5 * GRAVITY * 0.03**2, rel=0.02)
    assert (np.abs(last[:, :2]) < [0.2, 0.12]).all()


@pytest.mark.slow(reason="1.4 s of shaking, until the piers have met")
def test_the_bridge_and_its_fill_stand_until_they_are_shaken(tmp_path):
    summary = run("bridge.toml", tmp_path, "loads[0].amplitude=0", "run.duration=0.2", "report.crack_map=false")
    assert summary.joints_opened == 0
    assert summary.displacement_max < 1e-5


def test_the_skewed_bridge_stands_and_is_shaken_in_three_components(tmp_path):
    """At rest it hardly moves; shaken, it does so along all three axes, and the work of all three motions is in the balance."""
    quiet = [f"loads[{k}].amplitude=0" for k in range(3)]
    still = run("bridge_skewed.toml", tmp_path / "still", *quiet, "run.duration=0.2", "run.until_still=false", "report.crack_map=false")
    assert still.displacement_max < 1e-4 and not still.planar
    shaken = run("bridge_skewed.toml", tmp_path / "shaken", "run.duration=0.624", "run.until_still=false", "report.crack_map=false")
    assert shaken.energy.balance_error < 1e-6
    with Results.open(tmp_path / "shaken" / "result.h5") as results:
        moved = np.abs(results.position[-1] - results.position[0]).max(axis=0)
    assert (moved > 1e-3).all()


def test_the_two_piers_pound_on_one_another_and_every_joule_is_booked(tmp_path):
    summary = run("two_piers.toml", tmp_path, "run.duration=1.4", "run.until_still=false", "report.html=false")
    assert summary.energy.balance_error < 1e-9
    assert summary.planar
    gaps = []
    with Results.open(tmp_path / "result.h5") as results:
        solids = solids_of(results.blocks)
        sides = [np.flatnonzero([b.structure == name and not b.fixed for b in results.blocks]) for name in ("low", "tall")]
        low, tall = (np.isin(solids.vertex_block, side) & (solids.vertices[:, 2] < 4.001) for side in sides)
        for frame in range(results.frames):
            x = Pose.of(results, solids, frame).moved(solids, solids.vertices, solids.vertex_block)[:, 0]
            courses = [(solids.vertices[:, 2] > h - 0.01) & (solids.vertices[:, 2] < h + 0.51) for h in np.arange(0.0, 4.0, 0.5)]
            gaps.append([x[tall & course].min() - x[low & course].max() for course in courses])
    assert gaps[0] == pytest.approx([0.04] * len(courses))
    struck = np.minimum.accumulate(gaps) < 1e-3
    assert struck.any()
    assert np.where(struck, gaps, 0.0).max() > 2e-3  # they part again


@pytest.mark.slow(reason="a whole motion, and a collapse")
def test_the_tied_arch_stands_while_its_tie_yields_and_falls_without_it(tmp_path):
    plain = ("run.until_still=false", "report.html=false", "report.damage=false")
    summary = run("arch_tied.toml", tmp_path / "tied", *plain)
    (tie,) = summary.ties
    assert tie.yielded
    assert tie.tension_max == pytest.approx(9e3)
    assert summary.collapsed_blocks == 0
    loose = run("arch_tied.toml", tmp_path / "loose", *plain, "structure.ties=[]", "loads[0].amplitude=0", "run.duration=1.5")
    assert loose.collapsed_blocks > 5


@pytest.mark.slow(reason="a church in space")
def test_the_ties_of_the_church_bear_their_tension_at_rest(tmp_path):
    summary = run("church_tied.toml", tmp_path, "run.duration=0.05", "loads[0].amplitude=0", "report.damage=false")
    assert [tie.name for tie in summary.ties] == ["nave.1", "nave.2", "nave.3"]
    assert all(tie.tension_end == pytest.approx(10e3, rel=0.02) and not tie.yielded for tie in summary.ties)


@pytest.mark.slow(reason="a house in space")
def test_the_floors_of_the_house_rest_on_its_walls_and_their_anchors_hang_slack(tmp_path):
    summary = run("house_floors.toml", tmp_path, "run.duration=0.05", "loads[0].amplitude=0", "report.damage=false", "run.tolerance=1e-6")
    reaction, weight = base_reaction(tmp_path)
    assert reaction == pytest.approx(weight, rel=2e-3)
    assert len(summary.ties) == 16
    assert all(abs(tie.tension_end) < 100.0 for tie in summary.ties)
    with Results.open(tmp_path / "result.h5") as results:
        names = [block.name for block in results.blocks]
        for name, kilograms in (("floor1", 400.0 * 4.98 * 4.4), ("floor2", 300.0 * 5.4 * 4.4)):
            held = (results.joints.block_a == names.index(name)) | (results.joints.block_b == names.index(name))
            held &= np.abs(results.joints.normal[:, 2]) > 0.99
            above = results.joints.centres()[:, 2] > (2.4 if name == "floor1" else 4.9)  # the wall on its edge
            force = results.joint_history("normal_force")[-1]
            carried = force[held & ~above].sum() - force[held & above].sum()
            assert carried == pytest.approx(GRAVITY * kilograms, rel=0.02)


@pytest.mark.slow(reason="a church in space")
def test_the_three_shocks_follow_one_another_at_their_sizes(tmp_path):
    summary = run("church_three_shocks.toml", tmp_path, "run.duration=0.05", "report.damage=false")
    (sequence,) = summary.loads.tables[:1]
    assert [shock["name"] for shock in sequence["shocks"]] == ["foreshock", "main shock", "aftershock"]
    lengths = [shock["end"] - shock["start"] for shock in sequence["shocks"]]
    assert lengths == pytest.approx([3.0, 3.5, 3.0], abs=0.01)
    assert [b["start"] - a["end"] for a, b in pairwise(sequence["shocks"])] == pytest.approx([2.0, 2.0], abs=0.01)
    pga = [max(component["after"]["pga"] for component in shock["components"]) for shock in sequence["shocks"]]
    assert pga == pytest.approx([1.2 * ag for ag in (1.2, 2.2, 1.7)], rel=0.35)  # S ag on ground B; short periods are not matched


def test_the_study_of_an_arch_has_runs_that_can_be_made() -> None:
    plan = plan_of(EXAMPLES / "study_arch.toml")
    assert len(plan.runs) == len({run.name for run in plan.runs}) == 32
    hazard = plan.maker.study.scene.site
    assert hazard is not None and (hazard.measure, hazard.return_period(2.0).years) == ("ag", pytest.approx(625.0))
    tables = plan.maker.tables(plan.runs[-1].asked)
    assert (tables["loads"][0]["ag"], tables["loads"][0]["seed"]) == (8.0, 7)
    row = run_task(Task("last", tables | {"run": tables["run"] | {"duration": 0.1}}, 60.0)).row
    assert (row.status, row.number("steps")) == ("done", 25)


def test_the_pulse_that_left_the_columns_predicts_what_was_found() -> None:
    found = Calibration.of(read_study(EXAMPLES / "attribute_columns.toml"))
    assert found.motion == ("loads[0].duration", "loads[0].acceleration")
    truth = {"loads[0].acceleration": 0.7 * STANDARD_GRAVITY, "loads[0].duration": 0.7, "loads[0].direction": 40.0}
    row = calibrate_task(found.wanted, Task("truth", found.maker.tables(DesignedRun(values=truth)), 60.0)).row
    for one in found.wanted.observations:
        value = row.number(PREDICTED)[one.title]
        assert value == one.value if one.what == "fallen" else abs(one.off(np.array([value]))[0]) < 2.0


def test_the_buttresses_of_the_arch_bear_its_weight_far_below_the_strength_of_the_stone(tmp_path):
    summary = run("arch_stress.toml", tmp_path, "run.duration=0.04", "loads[0].amplitude=0", "run.tolerance=1e-9")
    with Results.open(tmp_path / "result.h5") as results:
        lowest = [block.name in ("buttress1.1", "buttress2.1") for block in results.blocks]
        vertical = results.stress[results.frames - 1][lowest, 2]
    reaction, weight = base_reaction(tmp_path)
    area, height = 1.4 * 1.0, 0.75  # of a buttress, and of its lowest block
    assert reaction == pytest.approx(weight, rel=1e-6)
    assert -vertical.sum() * area == pytest.approx(weight - area * height * 2200.0 * GRAVITY, rel=1e-4)  # above the middles of the two
    found = summary.stress.strength
    assert found.blocks_above == 0 < found.crushed_share_max < found.ratio_max * 2 < 0.2


@pytest.mark.slow(reason="blocks of each kind of strain, and the run as rigid")
def test_the_aqueduct_with_blocks_that_deform_stands_with_all_its_kinds_of_blocks_and_as_rigid(tmp_path):
    quiet = ("run.duration=0.04", "loads[0].amplitude=0")
    summary = run("aqueduct_deformable.toml", tmp_path / "soft", *quiet)
    reaction, weight = base_reaction(tmp_path / "soft")
    assert reaction == pytest.approx(weight, rel=1e-4)
    assert summary.planar
    assert summary.energy.balance_error < 1e-6
    with Results.open(tmp_path / "soft" / "result.h5") as results:
        strain = np.abs(results.gradient(0)).max(axis=(1, 2))
        group = [block.group for block in results.blocks]
    strained = {name for name, moved in zip(group, strain, strict=True) if moved > 0.0}
    assert strained == set(group) - {"base", "top"}
    assert 1e-6 < strain.max() < 1e-4  # some 0.2 MPa over 10 GPa, settled before the run
    run("aqueduct_deformable.toml", tmp_path / "rigid", *quiet, "material.deformable=rigid")
    with Results.open(tmp_path / "rigid" / "result.h5") as results:
        assert results.gradient(0) is None
