# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of bits: it passes on what it saved, and tells which number has changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.bits import baseline
from benchmarks.bits.__main__ import check, main, save
from benchmarks.bits.cases import CASES, Case, Solve
from benchmarks.bits.runs import run_case


@pytest.fixture
def tiny(block_on_plate) -> Case:
    """A block on a plate, and one problem of it, solved without its bodies."""
    scene = block_on_plate(friction="friction = 0.3", duration="duration = 0.03")
    return Case(scene, ("run.tolerance=1e-6",), dump=5, solves=(Solve("nlgs", local=True),))


@pytest.mark.slow(reason="runs scenes by the command, each in a process of its own")
def test_a_scene_that_is_saved_is_found_the_same_and_a_changed_number_is_reported(tiny, tmp_path, capsys):
    file, found = tmp_path / "bits.json", run_case(tiny)
    assert not [name for name in found if "seconds" in name or "version" in name]
    for name in (
        "result.h5/velocity", "result.h5/energy/kinetic", "result.h5/attributes/scene", "summary.json/solver.error_max",
        "joints.csv/max_opening", "problem_5.npz/H_data", "problem_5/local-nlgs/iterations",
    ):  # fmt: skip
        assert name in found
    baseline.save(file, "tiny", found)
    assert check({"tiny": tiny}, file) == 0  # runs it again
    assert "all 1 scenes are the same to the bit" in capsys.readouterr().out
    found["problem_5/local-nlgs/r"][1, 0] *= 1.0 + 1e-15
    lines = baseline.differences(file, "tiny", found)
    assert len(lines) == 1
    assert lines[0].startswith(f"problem_5/local-nlgs/r: first in row 1 of {len(found['problem_5/local-nlgs/r'])}, by ")


def test_one_bit_is_reported_with_its_row_and_size(tmp_path):
    file = tmp_path / "bits.json"
    numbers, words = np.arange(12.0).reshape(4, 3), np.array([b"a", b"b"])
    baseline.save(file, "made", {"numbers": numbers, "words": words})
    assert baseline.differences(file, "made", {"numbers": numbers.copy(), "words": words.copy()}) == []
    after = numbers.copy()
    after[2, 1] = np.nextafter(after[2, 1], 8.0)
    size = f"{after[2, 1] - numbers[2, 1]:.3g}"
    lines = baseline.differences(file, "made", {"numbers": after, "words": words})
    assert lines == [f"numbers: first in row 2 of 4, by {size}, 8.1e-17 of the largest"]
    lines = baseline.differences(file, "made", {"numbers": -0.0 * numbers + numbers, "more": words})
    assert lines == ["more: new", "words: gone"]
    assert baseline.differences(file, "other", {}) == ["not in the baseline"]


@pytest.mark.parametrize(
    ("before", "after", "lines"),
    [
        ([0.0, 1.0], [-0.0, 1.0], "first in row 0 of 2, by the sign of a zero or the bits of a NaN"),
        ([0.0, np.nan], [0.0, 1.0], "first in row 1 of 2, was nan, is 1.0"),
        ([0.0, 1.0], [0.0, 1.0, 2.0], "was f(2,), is f(3,); the rows of both agree"),
        ([b"x", b"y"], [b"x", b"z"], "first in row 1 of 2, was y, is z"),
        ([[1.0]], [1.0], "was f(1, 1), is f(1,)"),
        (3.0, 4.0, "was 3.0, is 4.0"),
    ],
)
def test_what_differs_is_described(before, after, lines):
    assert baseline.describe(np.array(before), np.array(after)) == lines


def test_a_scene_that_fails_counts_as_a_difference(tmp_path, capsys):
    missing = {"missing": Case(tmp_path / "missing.toml")}
    file = tmp_path / "bits.json"
    assert save(missing, file) == 1
    baseline.save(file, "missing", {})
    assert check(missing, file) == 1
    assert "no such scene file" in capsys.readouterr().out


def test_the_scenes_are_there_and_a_missing_baseline_is_reported(tmp_path, capsys):
    assert all(case.scene.is_file() for case in CASES.values())
    used = {case.scene for case in CASES.values()}
    assert set(Path(baseline.__file__).parent.glob("*.toml")) == used
    with pytest.raises(SystemExit) as end:
        main(["check", "--file", str(tmp_path / "none.json")])
    assert end.value.code == 2
    assert "no baseline; make one" in capsys.readouterr().err
