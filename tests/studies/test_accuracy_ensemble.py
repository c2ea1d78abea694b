# SPDX-License-Identifier: GPL-3.0-or-later
"""Ensembles over settings: members differ by their amplitude alone, biases show, and the cheapest setting without one is named."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from block_files import cuboid
from places import EXAMPLES
from studied import SCENE
from typer.testing import CliRunner

from masonry_cd.cli.app import app
from masonry_cd.studies.accuracy_ensemble import (
    MEASURES,
    EnsembleRow,
    Setting,
    chance,
    good_enough,
    members_of,
    run_member,
    settings_of,
    spreads_of,
)
from masonry_cd.studies.accuracy_ensemble_case import KEPT, OUTPUTS, lines_of


def masonry_cd(*words: object):
    return CliRunner().invoke(app, [str(word) for word in words])


def members(values: np.ndarray, seconds: float) -> tuple[dict[str, object], ...]:
    """Runs whose measures are all the same number."""
    rest = {"grade": "D1", "collapsed_blocks": 0, "steps": 100, "steps_missed": 0, "error_max": 1e-6, "seconds": seconds}
    return tuple(dict.fromkeys(MEASURES, float(value)) | rest for value in values)


def row(values: np.ndarray, finest: np.ndarray, seconds: float, tolerance: float) -> EnsembleRow:
    best = members(finest, 8.0)
    own = members(values, seconds)
    return EnsembleRow(Setting("auto", 4e-3, tolerance), own, spreads_of(own, best), finest=values is finest)


def test_a_bias_is_unlikely_and_equal_samples_are_certain():
    random = np.random.default_rng(3)
    first, second = random.normal(size=12), random.normal(size=12)
    assert chance(first, first[::-1]) == 1.0
    assert chance(first, second) > 0.05
    assert chance(first, second + 3.0) < 1e-3


def test_members_differ_by_their_amplitude():
    asked = members_of(EXAMPLES / "arch.toml", ["run.duration=0.1"], Setting("admm", 2e-3, 1e-6), 3)
    assert [member.factor for member in asked] == pytest.approx([1.0, 1.0 + 1e-9, 1.0 + 2e-9], rel=1e-14)
    still, strong = (run_member(asked[0]._replace(factor=factor)) for factor in (0.0, 20.0))
    assert still["displacement_max"] < 1e-6 < strong["displacement_max"]
    assert still["steps"] == 50


def test_the_finest_setting_comes_last_once():
    settings = settings_of(("admm", "auto"), (2e-3, 4e-3), (1e-3, 1e-6))
    assert len(settings) == len(set(settings)) == 8
    assert settings[-1] == Setting("admm", 2e-3, 1e-6)


def test_the_cheapest_setting_without_a_bias_is_good_enough():
    random = np.random.default_rng(6)
    finest = 0.05 + 2e-3 * random.standard_normal(10)
    rows = [
        row(1.5 * (0.05 + 2e-3 * random.standard_normal(10)), finest, 1.0, 1e-3),
        row(finest + 1e-4 * random.standard_normal(10), finest, 4.0, 1e-5),
        row(finest, finest, 8.0, 1e-6),
    ]
    assert [one.biased for one in rows] == [True, False, False]
    assert not rows[0].spreads["opening_max"].within
    assert good_enough(rows) is rows[1]
    lines = lines_of("A scene", rows)
    assert "tolerance 0.001: a bias shows, largest displacement +2" in lines[2]
    assert lines[-1].startswith(
        "good enough: auto, dt 4 ms, tolerance 1e-05: no bias shows, 4.0 s of the processor a run, where the finest"
    )
    assert "only the finest" in lines_of("A scene", [rows[0], rows[2]])[-1]


def test_a_difference_that_matters_to_nobody_is_no_bias():
    """All members agree to 1e-9, and the settings differ by 1 %: beyond all chance, and still of no account."""
    finest = 0.05 * (1.0 + 1e-9 * np.arange(8))
    close, off = row(1.01 * finest, finest, 1.0, 1e-3), row(1.03 * finest, finest, 1.0, 1e-3)
    assert close.spreads["opening_max"].chance < 0.01
    assert [close.biased, off.biased] == [False, True]


@pytest.mark.slow(reason="starts two workers")
def test_the_command_writes_a_row_per_setting_and_one_per_run(tmp_path: Path):
    words = ("--ensemble", 4, "--workers", 2, "--duration", 0.05, "--tolerances", "1e-8,1e-4")
    done = masonry_cd("accuracy", EXAMPLES / "arch.toml", "-o", tmp_path, *words)
    assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.glob("[!.]*")} == {*OUTPUTS, KEPT}
    with (tmp_path / "accuracy.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(float(row["tolerance"]), row["finest"]) for row in rows] == [(1e-4, "False"), (1e-8, "True")]
    assert all(row["grades"] == "4 D0" for row in rows)
    assert all(rows[1][f"{key}_chance"] == "1" for key in MEASURES)
    with (tmp_path / "members.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 8
    found = json.loads((tmp_path / "accuracy.json").read_text(encoding="utf-8"))
    assert found["lines"][-1].startswith("good enough: ")
    assert found["lines"][-1] in done.output
    assert (tmp_path / "accuracy.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow(reason="starts workers several times")
def test_runs_that_have_ended_are_kept(tmp_path: Path):
    """After a kill in the middle of a line the missing runs are made, with more members the new ones; another scene is refused."""

    def measured(members: int, *more: object):
        words = ("--ensemble", members, "--duration", 0.05, "--tolerances", "1e-4", *more)
        return masonry_cd("accuracy", EXAMPLES / "arch.toml", "-o", tmp_path, *words)

    def numbers() -> list[dict[str, str]]:
        with (tmp_path / "members.csv").open(encoding="utf-8") as file:
            return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]

    assert "0 of 4 runs left" in measured(4).stderr
    whole, kept = numbers(), tmp_path / KEPT
    lines = kept.read_text().splitlines(keepends=True)
    assert len(lines) == 5
    kept.write_text("".join(lines[:3]) + lines[3][:20])
    again = measured(4)
    assert [line.partition(";")[2] for line in again.stderr.splitlines()] == [" 1 of 4 runs left", " 0 of 4 runs left"]
    assert numbers() == whole
    assert len(measured(5).stderr.splitlines()) == 1
    assert numbers()[:4] == whole and len(numbers()) == 5
    other = measured(5, "--set", "material.friction=0.7")
    assert other.exit_code == 2 and "of another scene, or of one that was changed" in other.stderr
    assert len(measured(5, "--set", "material.friction=0.7", "--force").stderr.splitlines()) == 5


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--ensemble", 3), "--ensemble: 3 members show no bias, however large; at least 4 do"),
        (("--ensemble", 4, "--repeats", 4), "--ensemble and --repeats exclude each other"),
        (("--workers", 2), "--workers: is for --ensemble"),
        (("--ensemble", 4, "--dts", "0.2"), "--dts: 0.2 should be between 0 and 0.1"),
        (("--ensemble", 4, "--solvers", "nlgz"), '--solvers: "nlgz" is unknown'),
        (("--ensemble", 4, "--set", "run.dt=auto"), "run.dt"),
    ],
)
def test_bad_options_are_one_line(words: tuple[object, ...], message: str, tmp_path: Path):
    done = masonry_cd("accuracy", EXAMPLES / "arch.toml", "-o", tmp_path / "out", *words)
    assert done.exit_code == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_blocks_that_are_wrong_are_reported_before_anything_is_written(tmp_path: Path):
    (tmp_path / "scene.toml").write_text(SCENE)
    block = cuboid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)) | {"name": "b", "fixed": True}
    block["faces"] = block["faces"][:-1]
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": [block]}))
    done = masonry_cd("accuracy", tmp_path / "scene.toml", "-o", tmp_path / "out", "--ensemble", 4)
    assert (done.exit_code, len(done.stderr.splitlines())) == (2, 1)
    assert 'block "b"' in done.stderr and "open" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_problem_has_no_ensemble(tmp_path: Path):
    (tmp_path / "problem.npz").write_bytes(b"")
    done = masonry_cd("accuracy", tmp_path / "problem.npz", "-o", tmp_path / "out", "--ensemble", 4)
    assert (done.exit_code, "ensembles are of a scene" in done.stderr) == (2, True)
