# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene file: what it means, and that every slip of the pen is reported in one line that names it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from masonry_cd.app.scene import read_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.solvers import SOLVERS

GOOD = """\
title = "A test"
[structure]
kind = "arch"
radius = 10.0

[material]
density = 2200
friction = 0.6

[[loads]]
kind = "gravity"

[[loads]]
kind = "sinusoidal"
amplitude = 0.2

[run]
dt = 1e-3
duration = 8.0

[report]
crack_map = true
"""


@pytest.fixture
def write(tmp_path: Path):
    def _write(text: str) -> Path:
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return _write


def test_reads_every_table_and_keeps_the_text(write):
    scene = read_scene(write(GOOD))
    assert scene.title == "A test"
    assert scene.structure == {"kind": "arch", "radius": 10.0}
    assert (scene.material.density, scene.material.friction) == (2200.0, 0.6)
    assert [load["kind"] for load in scene.loads] == ["gravity", "sinusoidal"]
    assert scene.run == Run(dt=1e-3, duration=8.0)
    assert scene.run.gravity == (0.0, 0.0, -9.81)
    assert scene.report.crack_map
    assert scene.text == GOOD


def test_the_title_falls_back_on_the_file_name(write):
    assert read_scene(write(GOOD.partition("\n")[2])).title == "scene"


def test_friction_by_pairs_of_groups(write):
    scene = read_scene(write(GOOD.replace("friction = 0.6", "friction.arch-base = 0.9\nfriction.default = 0.5")))
    assert scene.material.friction == {"arch-base": 0.9, "default": 0.5}


def test_joint_laws_by_pairs_of_groups_or_one_for_all(write):
    one = read_scene(write(GOOD.replace("[[loads]]", "[material.joints]\nnormal_stiffness = 1e10\n\n[[loads]]", 1)))
    assert one.material.joints["default"].stiffness == (1e10, 1e10 / 2.4)
    tables = (
        "[material.joints.arch-base]\ncohesion = 2e5\n[material.joints.arch-arch]\nnormal_stiffness = 1e9\ntangential_stiffness = 1e8\n"
    )
    pairs = read_scene(write(GOOD.replace("[[loads]]", f"{tables}\n[[loads]]", 1))).material.joints
    assert (pairs["arch-base"].stiffness, pairs["arch-base"].cohesion) == ((0.0, 0.0), 2e5)
    assert pairs["arch-arch"].stiffness == (1e9, 1e8)
    assert read_scene(write(GOOD)).material.joints == {}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            "[material.joints]\nnormal_stifness = 1e9",
            ':10: material.joints.default.normal_stifness: unknown key (did you mean "normal_stiffness"?)',
        ),
        (
            "[material.joints.arch-base]\ncohesion = -1.0",
            ":11: material.joints.arch-base.cohesion: input should be greater than or equal to 0",
        ),
        ("[material.joints.arch-base]\ntheta = 0.4", ":11: material.joints.arch-base.theta: input should be greater than or equal to 0.5"),
        ("[material.joints]\ntangential_stiffness = 1e9", "material.joints.default: tangential_stiffness needs normal_stiffness"),
        (
            "[material.joints]\nnormal_stiffness = 5e-324",
            "material.joints.default.normal_stiffness: input should be greater than or equal to 1",
        ),
        (
            "[material.joints]\nnormal_stiffness = 1e9\ndamping_frequency = 5",
            "material.joints.default: damping_frequency needs damping beside",
        ),
        ("[material.joints]\ndamping = 0.05\ndamping_frequency = 5", "material.joints.default: damping needs normal_stiffness"),
        ("[material.joints]\ncompressive_strength = 0", "material.joints.default.compressive_strength: input should be greater than 0"),
        ("[material.joints]\ncompressive_strength = inf", "material.joints.default.compressive_strength: input should be a finite number"),
        ("[material.joints]\ntension = 1e5", "material.joints.default: tension needs normal_stiffness"),
        (
            "[material.joints]\ntheta = 0.5\n[material.joints.arch-base]\ntheta = 0.6",
            'material.joints: holds keys of one law ("theta") and tables',
        ),
    ],
)
def test_bad_joint_laws_are_named_in_one_line(write, table, message):
    with pytest.raises(InputError) as caught:
        read_scene(write(GOOD.replace("[[loads]]", f"{table}\n\n[[loads]]", 1)))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("duration", "dt", "steps"), [(8.0, 1e-3, 8000), (0.3, 0.1, 3), (1.0, 0.03, 34), (0.7, 0.007, 100)])
def test_steps_cover_the_duration_in_spite_of_rounding(duration, dt, steps):
    assert Run(dt=dt, duration=duration).steps == steps


def test_frames_are_a_whole_number_of_steps_apart():
    assert Run(dt=1e-3, duration=1.0, frames_per_second=100).frame_every == 10
    assert Run(dt=0.05, duration=1.0, frames_per_second=100).frame_every == 1


@pytest.mark.parametrize(("frames_per_second", "dt"), [(1e-308, 1e-3), (5e-324, 1e-3), (50.0, 5e-324), (1e-6, 1e-3)])
def test_frames_further_apart_than_any_run_is_long(frames_per_second, dt):
    run = Run(dt=dt, duration=10.0 * dt, frames_per_second=frames_per_second)
    assert run.frame_every > run.steps


def test_overrides_are_toml_values_and_else_text(write):
    changes = ["run.dt=2e-3", "loads[1].amplitude=0.5", "run.solver=nlgs", "run.gravity=[0, 0, -1.62]", "material.friction.arch-base=0.4"]
    scene = read_scene(write(GOOD.replace("friction = 0.6", "friction.default = 0.6")), changes)
    assert scene.run.dt == 2e-3
    assert scene.loads[1]["amplitude"] == 0.5
    assert scene.run.solver == "nlgs"
    assert scene.run.gravity == (0, 0, -1.62)
    assert scene.material.friction == {"default": 0.6, "arch-base": 0.4}


def test_the_text_kept_in_the_results_is_that_of_the_changed_scene(write, tmp_path):
    changed = read_scene(write(GOOD), ["run.dt=2e-3", 'structure.note=a "quoted" word'])
    again = tmp_path / "again.toml"
    again.write_text(changed.text)
    repeat = read_scene(again)
    assert (repeat.run, repeat.structure, repeat.loads) == (changed.run, changed.structure, changed.loads)
    assert "--set run.dt=2e-3" in changed.text.splitlines()[0]


def test_toml_written_reads_back_the_same():
    tables = {
        "title": 'a "b" \\ é',
        "structure": {"kind": "file", "on": True, "size": [1, 2.5, -3e-9], "at": {"x y": 1, "deep": {"z": "1"}}, "none": []},
        "loads": [{"kind": "a"}, {"kind": "b", "direction": [1.0, 0.0, 0.0]}],
    }
    assert tomllib.loads(dump_toml(tables)) == tables


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("dt = 1e-3", "dt = 1e-3\ndurration = 3"), 'scene.toml:19: run.durration: unknown key (did you mean "duration"?)'),
        (("[run]", "[rnu]"), 'rnu: unknown key (did you mean "run"?)'),
        (("dt = 1e-3", "dt = -1e-3"), "scene.toml:18: run.dt: input should be greater than 0, got -0.001"),
        (("dt = 1e-3", "dt = 1"), "run.dt: input should be less than or equal to 0.1"),
        (("dt = 1e-3", 'dt = "1 mm"'), 'run.dt: "mm" is no unit of a time; write a number in s, or one with its unit, "5 ms"'),
        (("dt = 1e-3", "dt = nan"), "run.dt: input should be"),
        (("dt = 1e-3", "dt = true"), "run.dt: input should be a valid number"),
        (("duration = 8.0", "duration = 1e-4"), "shorter than one step"),
        (("density = 2200", "density = -2.2"), "scene.toml:7: material.density: should be between 0.1 and 1e+06 kg/m3, got -2.2"),
        (("friction = 0.6", "friction = 35"), "material.friction: a coefficient of friction (no angle) should be between 0 and 20, got 35"),
        (("friction = 0.6", "friction.arch-base = -1"), 'material.friction: "arch-base": a coefficient'),
        (("friction = 0.6", "friction = 'high'"), "material.friction: should be a number"),
        (("density = 2200\n", ""), "material.density: missing"),
        (('[[loads]]\nkind = "gravity"\n\n[[loads]]', "[loads]"), "loads: every load is a table of its own, headed [[loads]]"),
        (("crack_map = true", "crack_map = 3"), "report.crack_map: input should be a valid boolean"),
        (("crack_map = true", "crack_map = 'yes'"), "report.crack_map: input should be a valid boolean, got 'yes'"),
        (("duration = 8.0", "duration = 1e12"), "run: duration 1e+12 s takes 1e+15 steps of dt 0.001 s; at most 2e+07"),
        (
            ("[run]\ndt", "[run]\nsolver = 'nlgz'\ndt"),
            "run.solver: input should be 'accelerated', 'admm', 'auto', 'interior', 'newton', 'nlgs' or 'pivoting', got 'nlgz'",
        ),
        (
            ("[run]\ndt", f"[run]\nseed = {2**63}\ndt"),
            "run.seed: input should be less than or equal to 9223372036854775807, got 9223372036854775808",
        ),
        (
            ("[run]\ndt", "[run]\nmax_iterations = 1000000001\ndt"),
            "run.max_iterations: input should be less than or equal to 1000000000, got",
        ),
        (("[run]\ndt", "[run]\ngravity = -9.81\ndt"), "run.gravity: should be three numbers [x, y, z], got -9.81"),
        (("radius = 10.0", "radius = 10.0 m"), 'statement (a number with its unit stands in quotes: "30 mm")'),
        (
            ("radius = 10.0", "radius = 10,0"),
            "scene.toml:4: not valid TOML: expected newline or end of document after a statement (a number has a",
        ),
        (("radius = 10.0", "radius = .5"), "invalid value (a number has digits on both sides of its point: 0.5)"),
        (("radius = 10.0", "radius = 10.\nrise = 2"), "statement (a number has digits on both sides of its point: 0.5)"),
        (("radius = 10.0", "radius = ten"), 'invalid value (a text stands in quotes: "x")'),
        (("radius = 10.0", "radius = True"), "invalid value (yes and no are written true and false)"),
        (("radius = 10.0", 'path = "C:\\drawings"'), "in a string (a path is written with /, or in single quotes)"),
        (("radius = 10.0", "radius = 10.0\nradius = 11.0"), "scene.toml:5: not valid TOML: cannot overwrite a value"),
    ],
)
def test_bad_scenes_are_named_in_one_line(write, change, message):
    with pytest.raises(InputError) as caught:
        read_scene(write(GOOD.replace(*change)))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("run.dtt=1e-3", "run.dtt: unknown key"),
        ("rnu.dt=1e-3", 'rnu: unknown key (did you mean "run"?)'),
        ("run.dt", "--set run.dt: write key=value"),
        ("=3", "write key=value"),
        ("loads[7].amplitude=1", "there is no loads[7] in the scene"),
        ("loads.amplitude=1", "a list is addressed as loads[0].amplitude"),
        ("run.dt=fast", "run.dt: input should be a valid number, got 'fast'"),
    ],
)
def test_bad_overrides_are_named_in_one_line(write, override, message):
    with pytest.raises(InputError) as caught:
        read_scene(write(GOOD), [override])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mark_of_the_encoding_at_the_head_is_no_error(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert read_scene(path).run.duration == 8.0


def test_a_missing_file_a_folder_and_a_binary_file(tmp_path):
    with pytest.raises(InputError, match="no such scene file"):
        read_scene(tmp_path / "none.toml")
    with pytest.raises(InputError, match="is a folder"):
        read_scene(tmp_path)
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        read_scene(tmp_path / "b.toml")


def located(scene, place, text):
    """The error of a place as a command shows it."""
    with pytest.raises(InputError) as caught, scene.locating():
        raise InputError(place, text)
    return caught.value


def test_errors_of_other_packages_get_file_and_line(write):
    scene = read_scene(write(GOOD))
    assert str(located(scene, "loads[1].amplitude", "must be positive")).endswith("scene.toml:15: loads[1].amplitude: must be positive")
    assert str(located(scene, "loads[1].frequency", "missing")).endswith("scene.toml:13: loads[1].frequency: missing")
    assert str(located(scene, "record.csv:7", "not a number")) == "record.csv:7: not a number"


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_scene_takes_every_solver(write, solver):
    assert read_scene(write(GOOD), [f"run.solver={solver}"]).run.solver == solver


def test_these_solvers_come_with_the_program():
    assert set(SOLVERS) == {"accelerated", "admm", "auto", "interior", "newton", "nlgs", "pivoting"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("run.dt=-1",), "--set run.dt=-1: run.dt: input should be greater than 0"),
        (("run.dt=1e-3", "run.dt=7"), "--set run.dt=7: run.dt: input should be less than or equal to 0.1"),
        (('material.friction={x="a"}',), '--set material.friction={x="a"}: material.friction: "x": should be a number'),
        (("run.dt=1e-3", "material.density=-2"), "--set material.density=-2: material.density: should be between"),
        (("run.duration=1e12",), "scene.toml:17 with --set run.duration=1e12: run: duration 1e+12 s takes"),
        (("report.opened=0",), "--set report.opened=0: report.opened: "),
    ],
)
def test_errors_of_a_change_name_it(write, changes, message):
    with pytest.raises(InputError) as caught:
        read_scene(write(GOOD), changes)
    assert message in str(caught.value)


def test_an_error_elsewhere_names_its_line_in_the_file_whatever_was_changed(write):
    with pytest.raises(InputError, match=r"scene\.toml:18: run\.dt: input should be greater than 0"):
        read_scene(write(GOOD.replace("dt = 1e-3", "dt = -1e-3")), ["run.seed=3"])
    scene = read_scene(write(GOOD), ["run.seed=3", "structure.thickness=-1"])
    assert str(located(scene, "structure.radius", "bad")).endswith("scene.toml:4: structure.radius: bad")
    assert str(located(scene, "structure.radius[1]", "bad")).endswith("scene.toml:4: structure.radius[1]: bad")  # item of a list
    assert str(located(scene, "structure.thickness", "bad")) == "--set structure.thickness=-1: structure.thickness: bad"
