# SPDX-License-Identifier: GPL-3.0-or-later
"""A team of threads of which one ends with an error."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from threading import Thread
from typing import Any

import numpy as np
import pytest

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.linalg.threads import ThreadTeam, run_by_team, wait

LONG = 20.0  # that a thread may wait for the others, were it not for the error: it would wait for ever [s]


@entry()
def meet_again(team: ThreadTeam, meetings: int, failing: int, when: int) -> int:
    """Meet the others some times; one thread ends with an error instead of coming to one of the meetings."""
    for k in range(meetings):
        if team.rank == failing and k == when:
            raise ValueError("a matrix of no size")
        wait(team)
    return meetings


def outcome(*arguments: object) -> object:
    """Return the outcome of a kernel for a team, result or error, in a thread of its own, so that one that hangs fails the test."""
    found: list[object] = []

    def ask() -> None:
        try:
            found.append(run_by_team(*arguments))  # type: ignore[arg-type]
        except BaseException as error:
            found.append(error)

    thread = Thread(target=ask, daemon=True)
    thread.start()
    thread.join(LONG)
    assert found, "the team hangs"
    return found[0]


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("failing", [0, 1])
def test_an_error_in_one_thread_ends_the_team_with_its_message(size: int, failing: int) -> None:
    for when in (0, 1, 7):
        error = outcome(meet_again, size, 8, failing, when)
        assert isinstance(error, ValueError) and str(error) == "a matrix of no size"
    assert outcome(meet_again, size, 1000, -1, 0) == 1000, "the next team is not the worse for it"


def test_an_error_before_a_kernel_is_reached_ends_the_team() -> None:
    def member(team: ThreadTeam, meetings: int) -> int:
        if team.rank == 1:
            raise MemoryError("no memory")
        return meet_again(team, meetings, -1, 0)

    assert isinstance(outcome(member, 2, 3), MemoryError)


def test_a_thread_that_cannot_be_had_ends_the_team(monkeypatch: pytest.MonkeyPatch) -> None:
    usual, given = ThreadPoolExecutor.submit, []

    def only_one(pool: ThreadPoolExecutor, *call: Any) -> Future[Any]:
        given.append(call)
        if len(given) > 1:
            raise RuntimeError("can't start new thread")
        return usual(pool, *call)

    monkeypatch.setattr(ThreadPoolExecutor, "submit", only_one)
    error = outcome(meet_again, 3, 5, -1, 0)
    assert isinstance(error, RuntimeError) and "can't start" in str(error)


def test_threads_come_to_what_one_does() -> None:
    assert outcome(meet_again, 1, 5, -1, 0) == 5 == int(np.int64(5))
