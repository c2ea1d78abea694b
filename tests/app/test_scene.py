# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene file: what it means, and that every slip of the pen is reported in one line that names it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hostile import refused_at

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


def test_an_error_elsewhere_names_its_line_in_the_file_whatever_was_changed(write):
    with refused_at("run.dt"):
        read_scene(write(GOOD.replace("dt = 1e-3", "dt = -1e-3")), ["run.seed=3"])
    scene = read_scene(write(GOOD), ["run.seed=3", "structure.thickness=-1"])
    assert str(located(scene, "structure.radius", "bad")).endswith("scene.toml:4: structure.radius: bad")
    assert str(located(scene, "structure.radius[1]", "bad")).endswith("scene.toml:4: structure.radius[1]: bad")  # item of a list
    assert str(located(scene, "structure.thickness", "bad")) == "--set structure.thickness=-1: structure.thickness: bad"
