# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/verdicts.py: a result, and how sure it is."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_code_check import code_check, wall

from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import LITTLE, CheckResult, refused, verdict_of, worst
from masonry_cd.foundation.errors import parse_table


@pytest.mark.parametrize(
    ("capacity", "doubt", "state", "passed", "sure"),
    [
        (0.99, "", "NOT satisfied", False, "certain"), (0.99, "no search", "NOT satisfied", False, "certain"),
        (1.04, "", "not decided", None, f"doubtful: {LITTLE}"), (1.06, "", "satisfied", True, "by search"),
        (9.0, "no search", "not decided", None, "doubtful: no search"),
    ],
)  # fmt: skip
def test_satisfied_needs_a_sure_search_and_a_margin(capacity: float, doubt: str, state: str, passed: bool | None, sure: str) -> None:
    made = CheckResult("linear", 1.0, capacity, "m/s2", "clause", doubt=doubt)
    verdict = verdict_of([made])
    assert (made.state, made.passed) == (state, passed)
    assert (verdict.state, verdict.sure, verdict.numbers()["passed"]) == (state, sure, passed)
    assert made.numbers()["confidence"] == verdict.confidence == sure.partition(":")[0]
    assert made.words.startswith(f"linear check {state}: {capacity:g} m/s2 borne, 1 m/s2 required, ratio {capacity:g}")
    assert ("no search" in made.words) is (state == "not decided" and bool(doubt))


def test_a_share_of_the_mass_taken_on_the_safe_side_leaves_not_satisfied_in_doubt_where_it_decides() -> None:
    """e* = 1 in place of 0.5: a0* is at most twice as large."""
    for capacity, sure in ((0.4, "certain"), (0.6, "doubtful")):
        verdict = verdict_of([CheckResult("linear", 1.0, capacity, "m/s2", "clause", fraction=0.5)])
        assert (verdict.state, verdict.confidence, "e* = 1" in verdict.because) == ("NOT satisfied", sure, sure == "doubtful")


def test_a_check_that_alone_is_satisfied_is_said() -> None:
    linear, displaced = CheckResult("linear", 1.0, 0.5, "m/s2", "a", doubt=""), CheckResult("non-linear", 1.0, 2.0, "m", "b", doubt="")
    verdict = verdict_of([linear, displaced])
    assert (verdict.state, verdict.check, verdict.confidence) == ("NOT satisfied", "linear", "doubtful")
    assert "non-linear" in verdict.because
    assert worst([refused("falls"), verdict, verdict_of([displaced])]) == refused("falls")
    assert refused("falls").confidence == "certain"


def test_without_a_basis_nothing_is_satisfied() -> None:
    made = code_check(parse_table(CheckTable, {"spectrum": "EC8", "ag": 0.1}, "limit.check"), wall(), Path())
    assert {one.state for one in made.verdicts} == {"not decided"}
