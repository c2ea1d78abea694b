# SPDX-License-Identifier: GPL-3.0-or-later
"""Ensembles over settings: members differ by their amplitude alone, biases show, and the cheapest setting without one is named."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from block_files import cuboid
from command_line import masonry_cd
from places import EXAMPLES
from studied import SCENE, row_names, write_scene
from typer.testing import Result

from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.app.scene import read_scene
from masonry_cd.studies.accuracy.ensemble import (
    COLUMNS,
    MEASURES,
    EnsemblePlan,
    EnsembleRow,
    Setting,
    chance,
    good_enough,
    lines_of,
    member_cells,
    settings_of,
    spreads_of,
)
from masonry_cd.studies.study.task import Task, run_task


def members(values: np.ndarray, seconds: float) -> tuple[RunRow, ...]:
    """Runs whose measures are all the same number."""
    rest = {"grade": "D1", "collapsed_blocks": 0, "steps": 100, "steps_missed": 0, "error_max": 1e-6}
    columns = [COLUMNS[key] for key in MEASURES]
    return tuple(RunRow(DONE, numbers=rest | dict.fromkeys(columns, float(v)), timing={"processor": seconds}) for v in values)


def row(values: np.ndarray, finest: np.ndarray, seconds: float, tolerance: float) -> EnsembleRow:
    own = members(values, seconds)
    return EnsembleRow(Setting("auto", 4e-3, tolerance), own, spreads_of(own, members(finest, 8.0)), finest=values is finest)


def test_a_bias_is_unlikely_and_equal_samples_are_certain():
    random = np.random.default_rng(3)
    first, second = random.normal(size=12), random.normal(size=12)
    assert chance(first, first[::-1]) == 1.0
    assert chance(first, second) > 0.05
    assert chance(first, second + 3.0) < 1e-3


def test_members_differ_by_their_amplitude_and_keep_their_setting(tmp_path: Path):
    """Runs of one length: what would end them at rest is taken out."""
    write_scene(tmp_path, SCENE.replace("tolerance = 1e-6", "longest = 5.0\nuntil_still = true"))
    settings = settings_of(("nlgs",), (1e-2, 5e-3), (1e-6,))
    plan = EnsemblePlan(read_scene(tmp_path / "scene.toml"), settings, 3)
    scenes = [plan.maker.tables(run.asked) for run in plan.runs]
    assert [tables["run"]["dt"] for tables in scenes] == [1e-2, 5e-3] * 3
    assert [tables["loads"][0]["amplitude"] for tables in scenes[::2]] == pytest.approx(
        [0.4, 0.4 * (1 + 1e-9), 0.4 * (1 + 2e-9)], rel=1e-14
    )
    assert len({tables["loads"][0]["amplitude"] for tables in scenes}) == 3
    found = member_cells(run_task(Task("a", scenes[0], 60.0)).row)
    assert (found["steps"], found["steps_missed"], found["collapsed_blocks"]) == (50, 0, 0)
    assert found["displacement_max"] == pytest.approx(found["sliding_max"], rel=1e-3)
    assert found["sliding_max"] > 1e-3 > found["opening_max"]
    assert found["seconds"] > 0.0 and found["drift"] >= 0.0


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
    assert str(rows[1].setting) in lines_of("A scene", rows)[-1]
    assert "only the finest" in lines_of("A scene", [rows[0], rows[2]])[-1]


def test_a_difference_that_matters_to_nobody_is_no_bias():
    """All members agree to 1e-9, and the settings differ by 1 %: beyond all chance, and still of no account."""
    finest = 0.05 * (1.0 + 1e-9 * np.arange(8))
    close, off = row(1.01 * finest, finest, 1.0, 1e-3), row(1.03 * finest, finest, 1.0, 1e-3)
    assert close.spreads["opening_max"].chance < 0.01
    assert [close.biased, off.biased] == [False, True]


@pytest.mark.slow(reason="starts workers several times")
def test_a_row_per_setting_and_one_per_run_which_are_kept(tmp_path: Path):
    """With more members the new ones are made; another scene is refused."""
    out = tmp_path / "out"

    def measured(count: int, *more: object) -> Result:
        words = ("--ensemble", count, "--workers", 2, "--duration", 0.05, "--tolerances", "1e-8,1e-4", *more)
        return masonry_cd("accuracy", EXAMPLES / "arch.toml", "-o", out, *words)

    def table(name: str) -> list[dict[str, str]]:
        with (out / name).open(encoding="utf-8") as file:
            return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]

    done = measured(4)
    assert done.exit_code == 0, done.output
    rows, whole, kept = table("accuracy.csv"), table("members.csv"), row_names(out)
    assert [(float(row["tolerance"]), row["finest"]) for row in rows] == [(1e-4, "False"), (1e-8, "True")]
    assert all(row["grades"] == "4 D0" for row in rows)
    assert all(rows[1][f"{key}_chance"] == "1" for key in MEASURES)
    assert len(whole) == len(kept) == 8
    found = json.loads((out / "accuracy.json").read_text(encoding="utf-8"))
    assert found["lines"][-1].startswith("good enough: ") and found["lines"][-1] in done.output
    assert (out / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert "10 runs, 2 of them to be made" in measured(5).stderr
    assert {name: row_names(out)[name] for name in kept} == kept
    assert [row for row in table("members.csv") if row["member"] != "4"] == whole
    other = measured(5, "--set", "material.friction=0.7")
    assert other.exit_code == 2 and "of another scene" in other.stderr


def test_blocks_that_are_wrong_are_reported_before_anything_is_written(tmp_path: Path):
    (tmp_path / "scene.toml").write_text(SCENE)
    block = cuboid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)) | {"name": "b", "fixed": True}
    block["faces"] = block["faces"][:-1]
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": [block]}))
    done = masonry_cd("accuracy", tmp_path / "scene.toml", "-o", tmp_path / "out", "--ensemble", 4)
    assert (done.exit_code, len(done.stderr.splitlines())) == (2, 1)
    assert 'block "b"' in done.stderr and "open" in done.stderr
    assert not (tmp_path / "out").exists()
