# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads share the phases of a step, and change no bit of it."""

from __future__ import annotations

import numpy as np
import pytest
from models import stepper, wall

from masonry_cd.mechanics.dynamics import system
from masonry_cd.mechanics.friction.problem import natural_map_error
from masonry_cd.mechanics.linalg.threads import in_shares


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_no_bit(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shaken wall: contacts, their rows, impulses, the error and the tallies are those of one thread."""
    results = []
    for number in (1, threads):
        monkeypatch.setattr(system, "threads_that_pay", lambda *_, number=number: number)
        machine = stepper(wall(6, 8), 40, solver="auto", tolerance=1e-8)
        machine.kick(np.tile([0.3, 0.1, 0.2, 0.0, 0.2, 0.1], (machine.assembly.count, 1)))
        reports = [machine.step() for _ in range(12)]
        last = machine.last
        assert last is not None
        arrays = *last.found, *last.rows.geometry, *(part for part in last.rows if isinstance(part, np.ndarray))
        results.append((*arrays, machine.solution.impulse, machine.detector.tally, [r.error for r in reports]))
    for one, many in zip(*results, strict=True):
        np.testing.assert_array_equal(one, many)
    assert machine.detector.contacts > 100


def test_the_error_is_the_same_by_many_threads() -> None:
    """Contacts are with supports and between blocks, with and without scales."""
    machine = stepper(wall(4, 5), 10, solver="auto", tolerance=1e-6)
    machine.step()
    problem, impulse = machine.friction_problem().problem, 1.1 * machine.solution.impulse
    for scaled in (True, False):
        one = natural_map_error(problem, impulse, scaled)
        assert one > 0.0
        assert [natural_map_error(problem, impulse, scaled, threads) for threads in (2, 3, 5)] == [one] * 3


def test_shares_cover_a_range_once() -> None:
    """Also where there are more threads than items."""
    for threads, count in ((1, 5), (2, 5), (3, 5), (4, 2)):
        shares = in_shares(lambda rank, first, end: (rank, list(range(first, end))), threads, count)
        assert [rank for rank, _ in shares] == list(range(threads))
        assert [item for _, items in shares for item in items] == list(range(count))
