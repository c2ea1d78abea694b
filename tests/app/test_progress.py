# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of runs and of compiling: lines or a bar, and signals held back to the end of a step."""

from __future__ import annotations

import io
import itertools
import signal
import sys
import time
from pathlib import Path

import numba
import pytest
from numba.core import event

from masonry_cd.app import compile_progress, progress
from masonry_cd.app.compile_progress import late_methods, shown, time_left
from masonry_cd.app.progress import Interrupt, Interrupted, Progress
from masonry_cd.foundation import kernel_store
from masonry_cd.foundation.quantities import force, in_words, length
from masonry_cd.foundation.system import STOPPING


def test_numbers_in_words():
    """Times, forces, and lengths, which below a nanometre get no digits."""
    times = {0.0123: "0.012 s", 12.34: "12.3 s", 59.99: "60.0 s", 245: "4 min 5 s", 7800: "2 h 10 min"}
    assert {seconds: in_words(seconds) for seconds in times} == times
    forces = {1.05e6: "1.05 MN", 999_600.0: "1 MN", 12e3: "12 kN", 3.14159: "3.14 N", 0.0: "0 N"}
    assert {newtons: force(newtons) for newtons in forces} == forces
    lengths = {0.0: "0 m", 2.76e-13: "under 1 nm", -3e-12: "under 1 nm", 1e-9: "1 nm", 9.996e-10: "1 nm", 44.9e-9: "44.9 nm"}
    lengths |= {1.66e-3: "1.66 mm", 2.0: "2 m", 459.0: "459 m", 5800.0: "5.8 km"}
    assert {metres: length(metres) for metres in lengths} == lengths


class Terminal(io.StringIO):
    """Where a person looks on."""

    def isatty(self) -> bool:
        return True


def shown_of(stream: io.StringIO, *done: int, of: int = 200, quiet: bool = False) -> str:
    """The text that a stream gets of a run of some steps."""
    with Progress(of, quiet=quiet, stream=stream) as show:
        for steps in done:
            show(steps)
    return stream.getvalue()


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
@pytest.mark.parametrize("name", ["dumb", "unknown", ""])  # terminals that cannot go back
def test_plain_lines_tell_steps_and_time_left_or_what_is_waited_for(monkeypatch, stream, name):
    monkeypatch.setenv("TERM", name)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    on_its_way, beyond = shown_of(stream(), 50), shown_of(stream(), 250)
    assert on_its_way.startswith("step 50 of 200 (25 %), ") and on_its_way.endswith(" left\n")
    assert beyond.startswith("step 250 of 200, ") and beyond.endswith("so far, until all blocks are still\n")


def test_lines_come_no_more_often_than_asked_and_not_at_all_when_quiet(monkeypatch):
    assert shown_of(io.StringIO(), *range(1, 1001), of=1000) == ""
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    assert shown_of(io.StringIO(), 1, of=10, quiet=True) == ""


def test_a_terminal_gets_a_bar_with_the_time_left(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    said = shown_of(Terminal(), 10, of=10)
    assert "10/10" in said and "100%" in said and "left" in said


@pytest.mark.parametrize("number", STOPPING)
def test_signals_wait_for_the_check_however_many_come(number, request):
    former = signal.signal(number, signal.SIG_DFL)  # or else a signal that nohup has tests ignore stays ignored, as it should
    request.addfinalizer(lambda: signal.signal(number, former))
    stream = io.StringIO()
    with Interrupt(stream) as interrupt:
        interrupt.check()
        for _ in range(3):
            signal.raise_signal(number)
        assert stream.getvalue() == "finishing the step; results are being written\n"
        with pytest.raises(Interrupted) as taken:
            interrupt.check()
        assert taken.value.number == number
        interrupt.at_once = True
        with pytest.raises(Interrupted):
            signal.raise_signal(number)
    assert signal.getsignal(number) == signal.SIG_DFL


class Leaving:
    """Does something while it is taken away, where Python raises nothing."""

    def __init__(self, last):
        self.last = last

    def __del__(self):
        self.last()


def fail():
    raise ValueError("broken")


def test_a_signal_where_nothing_is_raised_is_remembered_without_a_word(monkeypatch):
    said = []
    monkeypatch.setattr(sys, "unraisablehook", said.append)
    with Interrupt(io.StringIO()) as interrupt:
        interrupt.at_once = True
        Leaving(lambda: signal.raise_signal(signal.SIGINT))
        assert not said
        with pytest.raises(Interrupted):
            interrupt.check()
        Leaving(fail)
        assert len(said) == 1
    Leaving(fail)
    assert len(said) == 2


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="the system knows no hangup")
def test_a_run_under_nohup_is_not_stopped_by_its_terminal():
    former = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Interrupt(io.StringIO()) as interrupt:
            signal.raise_signal(signal.SIGHUP)
            interrupt.check()
    finally:
        signal.signal(signal.SIGHUP, former)


def test_of_work_that_grows_no_time_is_promised(monkeypatch):
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    stream = io.StringIO()
    with Progress(0, stream=stream, what="descent") as searched:
        searched.more(3, 0)
        searched.more(0, 1)
    assert "descent: 1 of 3 begun have ended" in stream.getvalue() and "left" not in stream.getvalue()


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty store, at which is looked often."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compile_progress, "EVERY", 0.01)
    monkeypatch.setattr(kernel_store, "used", set())


def _compile(name: str) -> None:
    kernel_store.write(kernel_store.name_of(name, "a", "float64"), b"code")


def _wait_for(text: str, stream: io.StringIO) -> None:
    for _ in range(12_000):  # two minutes, of which a busy machine may need some seconds
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
    dispatcher, now = numba.njit(newton_by_team), itertools.count()  # a clock that goes on by one whenever it is read
    monkeypatch.setattr(compile_progress.time, "perf_counter", lambda: float(next(now)))
    for heard in (False, True):
        monkeypatch.setattr(late_methods, "heard", heard)
        begin = kernel_store.clock()
        with (
            event.trigger_event("numba:compile", data={"dispatcher": dispatcher}),
            event.trigger_event("numba:compile", data={"dispatcher": dispatcher}),  # the kernel that the entry calls
        ):
            for _ in range(50):
                compile_progress.time.perf_counter()
        assert (kernel_store.clock() - begin < 50.0) == heard
        assert capsys.readouterr().err == ("compiling Newton's method, which no step needed before\n" if heard else "")


def newton_by_team() -> None:
    """A kernel by the name of one of LATE."""


def other() -> None:
    """A kernel of another name."""
