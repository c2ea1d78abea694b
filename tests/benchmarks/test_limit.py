# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis beside the dynamics: the bracket of a held push holds the factor of limit analysis."""

from __future__ import annotations

import pytest
from models import box, ground

from benchmarks import limit
from benchmarks.held_push import bracket
from masonry_cd.analysis.limit.analysis import Options, analyse
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly


@pytest.mark.parametrize("jobs", [1, pytest.param(3, marks=pytest.mark.slow(reason="three processes, each loads the program"))])
def test_the_bracket_of_the_dynamics_holds_the_factor_of_a_pillar(jobs: int) -> None:
    assembly = Assembly.from_blocks([ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.0)), box("b", (0, -0.2, 1), (0.5, 0.2, 2))], 0.6)
    found = analyse(assembly, find_joints(assembly), limit.push(assembly, limit.WAYS["x"]), Options(starts=0)).associated.factor
    assert found == pytest.approx(0.25, abs=1e-9)
    seen = bracket(assembly, limit.WAYS["x"], (1.1 * found, 1.2 * found), 0.01, jobs)
    assert seen.low is not None and seen.high is not None
    assert seen.low < 1.001 * found < 1.001 * seen.high  # a hair above its factor a pillar is too slow to be seen
    assert seen.high - seen.low <= 0.0101 * 1.2 * found
    assert all((trial.factor < 1.001 * found) == (trial.verdict == "stands") for trial in seen.trials.values() if trial.verdict != "left")


def test_what_is_no_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        limit.main(["pyramid"])
    assert refused.value.code == 2
    assert "no such kind: pyramid" in capsys.readouterr().err


@pytest.mark.parametrize("wrong", [["--jobs", "0"], ["--within", "nan"], ["--starts", "-1"], ["--between", "0.3", "0.2"]])
def test_trials_that_would_never_end_are_refused(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        limit.main(["arch", *wrong])
    assert refused.value.code == 2
    assert wrong[0] in capsys.readouterr().err
