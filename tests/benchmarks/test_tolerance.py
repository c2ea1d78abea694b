"""Ensembles over tolerances: members differ by their amplitude alone, and a bias shows in the chance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import EXAMPLES

from benchmarks.tolerance import chance, members, run_member, study


def test_a_bias_is_unlikely_and_equal_samples_are_certain() -> None:
    random = np.random.default_rng(3)
    first, second = random.normal(size=12), random.normal(size=12)
    assert chance(first, first[::-1]) == 1.0
    assert chance(first, second) > 0.05
    assert chance(first, second + 3.0) < 1e-3


def test_members_differ_by_their_amplitude(tmp_path: Path) -> None:
    asked = members(EXAMPLES / "arch.toml", ["run.duration=0.1"], 1e-6, 3)
    assert [member.factor for member in asked] == pytest.approx([1.0, 1.0 + 1e-9, 1.0 + 2e-9], rel=1e-14)
    still, strong = (run_member(asked[0]._replace(factor=factor)) for factor in (0.0, 20.0))
    assert still["displacement_max"] < 1e-6 < strong["displacement_max"]
    assert strong["solver"]["tolerance"] == 1e-6


def test_the_table_has_a_row_per_tolerance_the_tightest_last() -> None:
    lines = study(EXAMPLES / "arch.toml", ["run.duration=0.05"], [1e-8, 1e-4], 2, 1)
    rows = [line.split("|")[1:-1] for line in "\n".join(lines).splitlines()[2:]]
    assert [float(row[0]) for row in rows] == [1e-4, 1e-8]
    assert all(cell.strip().endswith(", 1") for cell in rows[1][1:4])
    assert all("D0" in row[4] for row in rows)
