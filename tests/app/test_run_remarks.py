# SPDX-License-Identifier: GPL-3.0-or-later
"""Remarks of a run on its own result: joints that open, crush, shorten or settle, blocks that deform, motion against the contact laws."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from command_line import done, masonry_cd
from hostile import refused_at
from models import box, ground, tower
from small_runs import ran, write_scene

from masonry_cd.analysis.damage.joint_damage import crushing
from masonry_cd.analysis.damage.verdict import beyond_their_law
from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.app.bed_checks import touching_share
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import parse_scene, read_scene
from masonry_cd.app.summary import elasticity_left_out, masses
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.mechanics.dynamics import solving
from masonry_cd.mechanics.model.blocks import Assembly, CarriedLoad
from reports.drawing.palette import CRUSHED
from reports.drawing.parts import painted
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing

DEPTH, WIDTH, HEIGHT = 0.5, 1.0, 2.0  # of a block and its bed [m]
FEW = "material.joints.joint_points=3"
ROCKING = """
material = { density = 2000.0, friction = 0.7, joints = { normal_stiffness = 2e9, damping = 0.1, damping_frequency = 10.0 } }
loads = [{ kind = "pulse", direction = "x", acceleration = 3.0, duration = 0.25 }]
run = { dt = 2e-3, duration = 0.3, tolerance = 1e-7 }
"""


def test_a_bed_touches_over_the_share_that_its_closed_form_gives() -> None:
    share, stiffness, turn = np.array([0.01, 0.2, 0.7]), 2e9 * DEPTH * WIDTH, 1e-3
    force = 0.5 * 2e9 * WIDTH * turn * (share * DEPTH) ** 2
    assert touching_share(force, stiffness * turn * (1.0 - share) * DEPTH) == pytest.approx(share)
    assert touching_share(np.array([0.0, -1.0, 1.0]), np.array([1.0, 1.0, 0.0])).tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("changes", "unresolved"),
    [
        ([FEW], 1),
        ([], 0),  # the points of the default resolve it
        ([FEW, "material.joints.normal_stiffness=1e13"], 0),  # a joint so stiff has its force at the edge
        ([FEW, "loads[0].acceleration=0.4"], 0),  # and this one stays closed
    ],
)
def test_joints_that_open_wider_than_their_points_resolve_are_to_be_looked_at(tmp_path: Path, changes: list[str], unresolved: int) -> None:
    blocks = [box("base", (-1, -1, -1), (2, 2, 0), fixed=True), box("block", (0, 0, 0), (DEPTH, WIDTH, HEIGHT))]
    summary = ran(write_scene(tmp_path, blocks, ROCKING), *changes)
    found = summary.beds
    (check,) = [one for one in summary.verdict.checks if one.check == "Points of open joints"]
    assert (found.unresolved, check.verdict) == (unresolved, "look" if unresolved else "good")
    if unresolved:
        assert summary.verdict.verdict == "look" and (found.points, found.where) == (3, '"base" - "block"')
        assert 0.03 < found.share < found.resolved == pytest.approx(1.0 / np.sqrt(6.0))


CRUSHING = """
run = {dt = 2e-3, duration = 0.2, tolerance = 1e-6}
report = {crack_map = false}
material = {density = 2000.0, friction = 2.0, joints = {normal_stiffness = 1e9, compressive_strength = 2e4}}
loads = [{kind = "pulse", direction = "x", acceleration = 4.5, duration = 0.15}]
"""


def test_crushed_joints_are_counted_tabled_and_marked(tmp_path: Path) -> None:
    summary = ran(write_scene(tmp_path, [ground(), box("b", (-0.25, -0.5, 0.0), (0.25, 0.5, 0.5))], CRUSHING))
    assert summary.joints_crushed == 1 and summary.crushed_where == '"ground" - "b"'
    assert summary.energy.crushing > 0.0 and summary.crushed_max > 1e-6
    with (tmp_path / "out/joints.csv").open() as file:
        assert float(next(csv.DictReader(file))["crushed"]) == float(f"{summary.crushed_max:.9g}")
    with Results.open(tmp_path / "out/result.h5") as results:
        assert np.diff(results.joint_history("crushed")[:, 0]).min() >= 0.0
        scene = crack_scene(results, results.frames - 1, framing(results, [results.frames - 1], MapStyle()))
        assert "crushed (1)" in [sign.text for panel in scene.key for sign in panel.signs]
        assert scene.joints is not None and tuple(scene.joints.colours[1][0]) == tuple(painted(CRUSHED, 1)[0])


def test_a_strength_below_the_stress_of_the_dead_loads_is_refused(tmp_path: Path) -> None:
    """A beam on two stones whose beds bear 29 kPa."""
    stones = [box("west", (-1.0, 0.0, 0.0), (-0.5, 0.5, 0.5)), box("east", (0.5, 0.0, 0.0), (1.0, 0.5, 0.5))]
    scene = write_scene(tmp_path, [ground(), *stones, box("beam", (-1.0, 0.0, 0.5), (1.0, 0.5, 1.0))], CRUSHING)
    with refused_at("material.joints") as refused:
        ran(scene)
    assert refused.match("20 kPa")


def test_crushing_that_is_forgotten_is_counted() -> None:
    """Three joints over three frames: one keeps what it is shorter by, one loses it, one was never crushed."""
    history = np.array([[0.0, 0.0, 0.0], [1e-4, 2e-4, 0.0], [3e-4, 0.0, 0.0]])
    ends = SimpleNamespace(block_a=[0, 0, 0], block_b=[1, 2, 3])
    blocks = [SimpleNamespace(name=name) for name in ("base", "a", "b", "c")]
    results = SimpleNamespace(has_joint_history=lambda name: True, joint_history=lambda name: history, joints=ends, blocks=blocks)
    found = crushing(cast(Results, results))
    assert found.as_dict() == {"joints_crushed": 1, "crushed_max": 3e-4, "crushing_forgotten": 1, "crushed_where": '"base" - "a"'}
    assert "1 joint" in beyond_their_law(found)[0]


@pytest.mark.parametrize("stiffness", [1e6, 1e7])
def test_a_joint_is_shortened_by_the_weight_over_its_stiffness(tmp_path: Path, stiffness: float) -> None:
    """A cube of 1 m sinks by 19.6 mm, more than a hundredth of its width, into a joint of 1 MN/m3, and by a tenth of that into another."""
    text = "material = {density = 2000.0, friction = 0.6, joints = {normal_stiffness = 1e6}}\nrun = {dt = 1e-3, duration = 0.01}"
    scene = write_scene(tmp_path, [box("base", (-1, -1, -1), (2, 2, 0), fixed=True), box("cube", (0, 0, 0), (1, 1, 1))], text)
    summary = ran(scene, f"material.joints.normal_stiffness={stiffness}")
    assert summary.shortening_max == pytest.approx(2000.0 * 9.81 / stiffness, rel=1e-4)
    assert summary.penetration_max == 0.0
    assert ('between "cube" and "base"' in summary.shortening_where) == (stiffness < 5e6)


SETTLING = """\
structure = {kind = "wall", length = 3.0, height = 2.0, thickness = 0.4, course_height = 0.5, unit_length = 1.0, openings = [
  {centre = 0.0, width = 1.0, sill = 0.5, height = 0.5}]}
material = {masonry = {kind = "irregular stone", E = 2e7}, friction = 0.4}
loads = [{kind = "sinusoidal", direction = "x", amplitude = 1e-12, frequency = 2.0, cycles = 1}]
run = {dt = 2e-3, duration = 0.1}
"""


def test_what_opens_while_elastic_joints_take_up_the_weight_is_no_damage(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(SETTLING)
    settled = ran(scene)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        opening = np.array(results.file["joints/opening"])
        assert results.file["joints/contact_area"][0] == pytest.approx(results.joints.area)
    assert opening[0].max() == 0.0 and opening.max() < 1e-6
    assert settled.joints_opened == settled.joints_slid == 0
    shutil.rmtree(tmp_path / "out")
    at_once = ran(scene, "run.settle=false", "run.duration=0.3")
    assert at_once.joints_opened + at_once.joints_slid > 0, "the weight does open joints of this wall, were it to come in the run"


FORCE = 10.0 * 3 * 2000.0 * 0.0625 * 9.81  # ten times the weight of the tower [N]
PUSHED = f"""
material = {{density = 2000.0, friction = 0.6}}
run = {{dt = 1e-3, duration = 0.1, solver = "auto", tolerance = 1e-4, until_still = false}}
report = {{html = true}}
loads = [{{kind = "point", block = "top", force = [{0.1 * FORCE}, 0.0, {-FORCE}]}}]
"""


def run_pushed(folder: Path, *changes: str) -> Summary:
    """The summary of a tower whose top takes a force of a million times its weight, aslant by a tenth, which friction holds."""
    *rest, top = tower(3)
    return ran(write_scene(folder, [*rest, replace(top, density=FORCE / 9.81e6 / 0.0625, name="top")], PUSHED), *changes)


def false_motion(summary: Summary) -> list[str]:
    return [line for line in summary.warnings if line.startswith("violations of the contact laws")]


def test_a_run_says_what_its_errors_come_to_in_metres(tmp_path: Path) -> None:
    summary = run_pushed(tmp_path, "run.tolerance=1e-5")
    solver = summary.solver
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert solver.violation_max == results.per_step("solver/violation").max() > 0.0
        assert solver.false_slip_max == results.per_step("solver/false_slip").max() > 0.0
        assert solver.false_opening_max == results.per_step("solver/false_opening").max()
    assert solver.false_slip_max < 1e-7 and solver.error_max <= 1e-5
    assert not false_motion(summary)
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["solver"]["false_slip_max"] == solver.false_slip_max


def test_a_run_whose_violations_are_its_motion_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "find_overload", lambda *_: None)  # so that the norm hides the light block
    summary = run_pushed(tmp_path)
    solver = summary.solver
    assert solver.steps_missed == 0 and solver.error_max <= 1e-4
    assert solver.false_slip_max > 1e-4 and '"top"' in solver.false_slip_where
    assert len(false_motion(summary)) == 1
    page = (tmp_path / "out" / "report.html").read_text()
    assert '<span class="verdict doubtful">' in page[page.index("Motion against the contact laws</th>") :][:400]


SOFT = 'friction = 0.5\ndeformable.block = "uniform"\nyoung = 1e7\npoisson = 0.0\ndamping = 0.2\ndamping_frequency = 50.0'
MESHED = SOFT.replace('"uniform"', '"tetrahedra"') + "\nmesh_size = 1.0"
OWN_WEIGHT = 2000.0 * 9.81 * 0.4  # of the block over its area [Pa]


@pytest.mark.parametrize(("material", "within"), [(SOFT, 1e-3), (MESHED, 2e-2)], ids=["uniform", "meshed"])
def test_a_block_that_deforms_is_strained_by_half_its_weight_and_drawn_so(
    block_on_plate: Callable[..., Path], tmp_path: Path, material: str, within: float
) -> None:
    """At rest in the end the mean strain is half the weight over E, so the top has sunk by that times the height."""
    summary = ran(block_on_plate(friction=material, report="[report]\nhtml = true\nstress = true"))
    results = Results.open(tmp_path / "out" / "result.h5")
    gradient = results.gradient(results.frames - 1)
    assert gradient is not None and gradient.shape == (2, 3, 3) and not gradient[0].any()
    np.testing.assert_allclose(gradient[1, 2, 2], -0.5 * OWN_WEIGHT / 1e7, rtol=within)
    if material == SOFT:
        solids, pose = solids_of(results.blocks), Pose.of(results, solids_of(results.blocks))
        top = np.flatnonzero((solids.vertex_block == 1) & (solids.vertices[:, 2] > 0.3))
        sunk = (pose.moved(solids, solids.vertices[top], solids.vertex_block[top]) - solids.vertices[top])[:, 2]
        np.testing.assert_allclose(sunk, -0.4 * 0.5 * OWN_WEIGHT / 1e7, rtol=within)
    assert summary.energy.elastic > 0.0 and abs(summary.energy.balance_error) < 1e-9
    said = "elastic, meshed" if material == MESHED else "elastic, with one strain each"
    assert said in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert not [line for line in summary.explanation if line.startswith("strains of blocks: none")]


def test_a_run_of_rigid_blocks_says_that_it_left_strains_out(block_on_plate: Callable[..., Path], tmp_path: Path) -> None:
    summary = ran(block_on_plate(duration="duration = 0.05"))
    assert [line for line in summary.explanation if line.startswith("strains of blocks: none")]
    assert Results.open(tmp_path / "out" / "result.h5").gradient(0) is None


def test_masses_are_those_of_the_free_blocks_by_group_with_what_rides_on_them() -> None:
    """Two cubes of 1 m at 2,000 kg/m3; on one of them ride 500 kg of fill."""
    fill = CarriedLoad(500.0, np.array([0.5, 0.5, 1.2]), np.zeros((3, 3)))
    vault = replace(box("vault", (-1.5, 0, 0), (-0.5, 1, 1)), carried=fill, group="arch")
    said = masses(Assembly.from_blocks([ground(), replace(box("stone", (0, 0, 0), (1, 1, 1)), group="wall"), vault], 0.6))
    assert said == "masses: 4.5 t free to move, arch 2.5 t, wall 2 t; 0.5 t of it is fill that rides on blocks"


WALL = 'structure = { kind = "wall", length = 2.0, height = 1.0, thickness = 0.3, course_height = 0.25, unit_length = 0.5 }\n'
FEW_BLOCKS = WALL.replace("length = 2.0, height = 1.0", "length = 0.5, height = 0.5")
SHAKEN = '[[loads]]\nkind = "sinusoidal"\ndirection = "x"\namplitude = 0.05\nfrequency = 5.0\ncycles = 2\n'
SINKING = '[[loads]]\nkind = "settlement"\nsupports = ["base"]\ndirection = "-z"\ndisplacement = 0.01\nduration = 0.1\n'
RUN = "[run]\ndt = 2e-3\nduration = 0.1\n"
RIGID = "[material]\ndensity = 2000.0\nfriction = 0.6\n"
NAMED = '[material]\nfriction = 0.6\nmasonry = { kind = "squared stone", stiffness = "rigid" }\n'
ELASTIC = '[material]\nfriction = 0.6\nmasonry = "squared stone"\n'


def left_out(text: str, folder: Path) -> Summary:
    return elasticity_left_out(prepare(parse_scene(text, folder / "scene.toml")))


def test_masonry_that_is_named_is_softer_or_stiffer_than_what_is_assumed(tmp_path: Path) -> None:
    assumed, named = (left_out(WALL + material + SHAKEN + RUN, tmp_path) for material in (RIGID, NAMED))
    assert not assumed.elastic_basis.named and named.elastic_basis.named
    ratio = (2243.4 / 2850e6 / (2000.0 / 1500e6)) ** 0.5  # of sqrt(density / E)
    assert named.elastic_period / assumed.elastic_period == pytest.approx(ratio, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        WALL + RIGID + RUN,
        WALL + RIGID + SINKING + RUN,
        WALL + ELASTIC + SHAKEN + RUN,
        WALL + RIGID + "[material.joints]\nnormal_stiffness = 1e10\n" + SHAKEN + RUN,
        FEW_BLOCKS + RIGID + SHAKEN + RUN,
    ],
    ids=["at rest", "settling", "masonry", "stiffness", "few blocks"],
)
def test_nothing_is_said_to_be_left_out_of_other_scenes(text: str, tmp_path: Path) -> None:
    assert left_out(text, tmp_path) == Summary()


def test_a_run_says_last_what_it_leaves_out_and_on_masonry_what_it_takes(tmp_path: Path) -> None:
    scene, out = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text(WALL + RIGID + SHAKEN + RUN)
    result = done("run", scene, "-o", out)
    last, summary = [line for line in result.stdout.splitlines() if not line.startswith("written:")][-1], read_summary(out)
    assert f"{summary.amplification:.2g} times" in last and f"{summary.elastic_period:.2g} s" in last
    scene.write_text(WALL + ELASTIC + SHAKEN + RUN)
    assert masonry_cd("run", scene, "-o", out, "--force").exit_code == 0
    summary = read_summary(out)
    assert summary.masonry["taken"]["E"] == pytest.approx(2.85e9)
    assert not summary.has("elastic_period") and summary.energy.balance_error < 1e-9


def balance_of(folder: Path, *words: str) -> tuple[str, float]:
    """The closing line on the energy of a tower of drums, and the balance in summary.json, relative."""
    tables = 'structure = {kind = "column", drums = 3}\nmaterial = {density = 2200.0, friction = 0.6}\nrun = {dt = 1e-3, duration = 0.1}\n'
    (folder / "tower.toml").write_text(tables)
    result = done("run", folder / "tower.toml", "-o", folder / "out", *words)
    return next(line for line in result.stdout.splitlines() if line.startswith("energy: ")), read_summary(
        folder / "out"
    ).energy.balance_error


def test_the_balance_is_given_in_joules_at_rest_and_as_a_share_of_the_work_of_a_fall(tmp_path: Path) -> None:
    line, relative = balance_of(tmp_path)
    assert float(line.split()[4]) < 1e-6 and line.split()[5] == "J;" and relative < 1e-2
    line, relative = balance_of(tmp_path, "--force", "--set", "run.gravity=[3.0,0.0,-1.0]")
    assert line.endswith(" of the largest work done") and relative < 1e-3


@pytest.mark.parametrize(("gravity", "warned"), [("-9.81", True), ("0.0", False)])
def test_a_structure_without_supports_falls_with_a_warning(block_on_plate, tmp_path: Path, gravity: str, warned: bool) -> None:
    scene = block_on_plate(duration=f"duration = 0.01\ngravity = [0.0, 0.0, {gravity}]")
    blocks = tmp_path / "blocks.json"
    blocks.write_text(blocks.read_text().replace("true", "false"))
    with refused_at(str(scene)):  # a base that is shaken needs a support
        ran(scene)
    assert not (tmp_path / "out").exists()
    text = scene.read_text()
    scene.write_text(text[: text.index("[[loads]]")] + text[text.index("[run]") :])
    summary = run_case(prepare(read_scene(scene)), tmp_path / "out")
    assert any(line.startswith("no block of the structure is fixed") for line in summary.warnings) == warned
