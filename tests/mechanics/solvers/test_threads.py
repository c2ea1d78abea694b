# SPDX-License-Identifier: GPL-3.0-or-later
"""How many threads a problem gets."""

import pytest

from masonry_cd.mechanics.solvers import cores, options, threads_that_pay


def test_threads_grow_with_the_contacts_up_to_the_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts in a plane count a third of those in space; as many are taken as requested, as far as there are cores."""
    monkeypatch.setattr(options, "cores", lambda: 4)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    assert [threads_that_pay(None, contacts, 3) for contacts in (0, 3_000, 7_000, 12_000, 10**6)] == [1, 1, 2, 3, 4]
    assert [threads_that_pay(None, contacts, 2) for contacts in (7_000, 21_000, 36_000)] == [1, 2, 3]
    assert [threads_that_pay(asked, 10, 3) for asked in (1, 3, 1000)] == [1, 3, 4]


def test_a_share_of_the_cores_is_kept_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """OMP_NUM_THREADS bounds the default number of threads, not what a scene requests; a value that is not a number is ignored."""
    monkeypatch.setattr(options, "cores", lambda: 4)
    for value, taken in (("1", 1), ("3", 3), ("64", 4), ("", 4), ("many", 4), ("0", 1), ("4,2", 4)):
        monkeypatch.setenv("OMP_NUM_THREADS", value)
        assert threads_that_pay(None, 10**6, 3) == taken
        assert threads_that_pay(2, 10**6, 3) == 2


def test_there_is_a_core() -> None:
    """The machine's own count."""
    assert cores() >= 1
