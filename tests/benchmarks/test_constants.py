# SPDX-License-Identifier: GPL-3.0-or-later
"""What constants of ``auto`` gain: all that it spends is counted, and nothing stays switched."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks import constants
from benchmarks.constants import SCENES, SWITCHED, Spent, measure, row, switched
from masonry_cd.mechanics.solvers import auto


def test_all_that_is_spent_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The thrown walls take ADMM, and two of them Newton."""
    spent: dict[str, int] = dict.fromkeys(auto.METHODS, 0)

    def noted(name: str, method: Any) -> SimpleNamespace:
        def solve(*problem: Any) -> Any:
            found = method.solve(*problem)
            spent[name] += found.iterations
            return found

        return SimpleNamespace(solve=solve)

    methods = {name: noted(name, method) for name, method in auto.METHODS.items()}
    monkeypatch.setattr(auto, "METHODS", methods)
    found = measure(SCENES["thrown walls"])
    assert found.iterations == spent
    assert spent["admm"] > 0
    assert found.cost > 0.0
    assert (found.steps, found.missed) == (3, 0)
    assert auto.METHODS is methods


def test_a_switched_constant_shows_in_the_counts_and_is_put_back() -> None:
    """With few iterations of ADMM others have to do more."""
    usual, limit = measure(SCENES["thrown walls"]), auto.MOST
    with switched("MOST", 1):
        other = measure(SCENES["thrown walls"])
    assert other.iterations["newton"] > usual.iterations["newton"]
    assert limit == auto.MOST
    assert measure(SCENES["thrown walls"]).iterations == usual.iterations


def test_a_missed_tolerance_is_counted() -> None:
    """Errors are multiples of the tolerance; the table shows the largest."""
    found = Spent(cost=2e3, seconds=1.0)
    for error in (1e-9, 3e-8, float("nan")):
        found.judge(error, 1e-8)
    assert (found.steps, found.missed, found.error) == (3, 2, pytest.approx(3.0))
    assert row("FACTOR", "tower", found, found).endswith("| 2.0 | 1.00 | 2 of 3 | 3 | 1.00 | 1.00 |")


def test_every_constant_is_there_to_be_switched() -> None:
    for name, value in SWITCHED.items():
        with switched(name, value):  # or else AttributeError
            pass
    assert set(constants.SCENES) >= {"demo", "church", "packed grains", "local"}
