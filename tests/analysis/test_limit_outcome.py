# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict on a limit analysis: of its check, or of its factor with how well the searches agree."""

from __future__ import annotations

from typing import Any

import pytest

from masonry_cd.analysis.limit.outcome import on_the_whole

FOUND: dict[str, Any] = {
    "stands": True, "bears_nothing": False, "no_finite_factor": False, "associated": 0.25, "verdict": None, "certificate": {"gap": 1e-12},
    "least": {"factor": 0.24, "agreeing": 4, "starts": 4}, "without": [],
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "grade", "sure"),
    [
        ({}, "load factor 0.24", "good"),
        ({"least": {"factor": 0.20, "agreeing": 1, "starts": 9}}, "load factor 0.2", "look"),
        ({"least": {"factor": 0.20, "agreeing": 1, "starts": 1}}, "load factor 0.2", "look"),  # one start agrees with nothing
        (
            {"least": {"factor": 0.2499, "agreeing": 1, "starts": 9}},
            "load factor 0.2499",
            "good",
        ),  # next to the upper value
        ({"least": None}, "load factor at most 0.25", "look"),
        ({"certificate": {"gap": 0.1}}, "load factor 0.25", "doubtful"),
        ({"no_finite_factor": True, "associated": None, "certificate": None}, "load factor 0.24", "look"),
        ({"no_finite_factor": True, "associated": None, "certificate": None, "least": None}, "no finite load factor", "look"),
        ({"stands": False}, "does not stand", "doubtful"),
        ({"bears_nothing": True}, "bears no such load", "good"),
        ({"verdict": {"state": "NOT satisfied", "confidence": "certain", "because": "", "reason": "too little"}}, "NOT satisfied", "good"),
        ({"verdict": {"state": "not decided", "confidence": "doubtful", "because": "no search", "reason": ""}}, "not decided", "look"),
    ],
)
def test_the_factor_and_how_sure_it_is(changes, grade, sure):
    found = on_the_whole(FOUND | changes)
    assert (found.grade, found.sure) == (grade, sure)
    assert found.line.startswith(f"verdict: {grade}")
