# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said while kernels are compiled."""

from __future__ import annotations

import io
import time
from pathlib import Path

import numba
import pytest
from numba.core import event

from masonry_cd.app import compile_progress
from masonry_cd.app.compile_progress import late_methods, shown, time_left
from masonry_cd.foundation import kernel_store


class Terminal(io.StringIO):
    """A stream that takes itself for a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty store, at which is looked often."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compile_progress, "EVERY", 0.01)
    monkeypatch.setattr(kernel_store, "used", set())


def _compile(name: str) -> None:
    kernel_store.write(kernel_store.name_of(name, "a", "float64"), b"code")


def _wait_for(text: str, stream: io.StringIO) -> None:
    for _ in range(500):
        if text in stream.getvalue():
            return
        time.sleep(0.01)
    raise AssertionError(f"{text!r} is not in {stream.getvalue()!r}")


def test_the_first_line_says_how_many_and_how_long_and_later_ones_how_far(store, monkeypatch):
    monkeypatch.setattr(compile_progress, "LINE_SECONDS", 0.0)
    stream = io.StringIO()
    with shown(41, 66.0, "", stream):
        assert stream.getvalue().splitlines()[0] == "compiling 41 kernels, once: about 1 min 6 s"
        _compile("package.first")
        _wait_for("compiling: 1 of 41 kernels, ", stream)


def test_the_time_left_moves_with_what_is_seen():
    assert time_left(60.0, 0.0, 0.0) == 60.0
    assert time_left(60.0, 0.5, 30.0) == pytest.approx(30.0)  # as expected
    assert time_left(60.0, 0.5, 90.0) > time_left(60.0, 0.5, 60.0) > 40.0  # three and two times as slow, and longer while nothing comes
    assert time_left(60.0, 1.0, 500.0) == 0.0


def test_it_is_said_which_kernel_is_at_work(store, monkeypatch):
    monkeypatch.setattr(compile_progress, "LINE_SECONDS", 0.0)
    stream = io.StringIO()
    with shown(41, 66.0, "", stream):
        _wait_for("0 of 41 kernels, about ", stream)  # it listens
        with (
            event.trigger_event("numba:compile", data={"dispatcher": numba.njit(newton_by_team)}),
            event.trigger_event("numba:compile", data={"dispatcher": numba.njit(other)}),
        ):
            _wait_for("0 of 41 kernels, now newton_by_team with other, about ", stream)


def test_a_terminal_gets_a_bar(store, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with shown(41, 66.0, "", stream):
        _compile("package.admm_bodies")
        _wait_for("1 of 41 kernels", stream)
    assert "41 of 41 kernels" in stream.getvalue()


def test_what_this_process_has_just_compiled_is_part_of_the_count(store):
    _compile("package.first")
    stream = io.StringIO()
    with shown(41, 66.0, "", stream):
        assert stream.getvalue() == "compiling 41 kernels, once: about 1 min 6 s\n"


def test_where_some_are_there_nothing_is_said_until_it_takes_long(store, monkeypatch):
    _compile("package.first")
    kernel_store.used.clear()
    stream = io.StringIO()
    with shown(41, 66.0, "", stream):
        pass
    assert stream.getvalue() == ""
    monkeypatch.setattr(compile_progress, "DOUBT", 0.01)
    with shown(41, 66.0, "", stream):
        _wait_for("compiling up to 41 kernels, once: about 1 min 6 s\n", stream)


def test_what_is_compiled_again_in_each_run_is_said_with_the_reason():
    stream = io.StringIO()
    with shown(41, 280.0, "numba 0.99.0 is newer than 0.68, the last that was tried", stream):
        pass
    expected = "compiling 41 kernels, in each run, as numba 0.99.0 is newer than 0.68, the last that was tried: about 4 min 40 s\n"
    assert stream.getvalue() == expected


def test_a_method_that_is_compiled_late_is_said_once_and_does_not_count_as_time_of_the_step(capsys, monkeypatch):
    dispatcher = numba.njit(newton_by_team)
    for heard in (False, True):
        monkeypatch.setattr(late_methods, "heard", heard)
        begin = kernel_store.clock()
        with event.trigger_event("numba:compile", data={"dispatcher": dispatcher}):
            time.sleep(0.05)
            with event.trigger_event("numba:compile", data={"dispatcher": dispatcher}):  # the kernel that the entry calls
                time.sleep(0.05)
            with event.trigger_event("numba:compile", data={"dispatcher": numba.njit(other)}):
                time.sleep(0.05)
        assert (kernel_store.clock() - begin < 0.1) == heard
        assert capsys.readouterr().err == ("compiling Newton's method, which no step needed before\n" if heard else "")


def newton_by_team() -> None:
    """A kernel by the name of one of LATE."""


def other() -> None:
    """A kernel of another name."""
