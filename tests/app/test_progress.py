# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress: plain lines where there is no terminal, and signals held back to the end of a step."""

from __future__ import annotations

import io
import signal
import sys

import numpy as np
import pytest

from masonry_cd.app import progress
from masonry_cd.app.progress import Interrupt, Interrupted, Progress
from masonry_cd.app.step_costs import AFTER, REST, SETTLING, STRONG, StepCosts, motion_classes
from masonry_cd.foundation.quantities import force, in_words, length
from masonry_cd.foundation.system import STOPPING


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.0123, "0.012 s"), (12.34, "12.3 s"), (59.99, "60.0 s"), (245, "4 min 5 s"), (7800, "2 h 10 min")]
)
def test_times_in_words(seconds, words):
    assert in_words(seconds) == words


@pytest.mark.parametrize(("value", "words"), [(1.05e6, "1.05 MN"), (999_600.0, "1 MN"), (12e3, "12 kN"), (3.14159, "3.14 N"), (0.0, "0 N")])
def test_forces_in_words(value, words):
    assert force(value) == words


@pytest.mark.parametrize(
    ("done", "begin", "end"),
    [(50, "step 50 of 200 (25 %), ", " left\n"), (250, "step 250 of 200, ", "so far, until all blocks are still\n")],
)
def test_plain_lines_tell_steps_and_time_left_or_what_is_waited_for(monkeypatch, done, begin, end):
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    stream = io.StringIO()
    with Progress(200, stream=stream) as show:
        show(done)
    assert stream.getvalue().startswith(begin)
    assert stream.getvalue().endswith(end)


def test_lines_come_no_more_often_than_asked_and_not_at_all_when_quiet(monkeypatch):
    stream = io.StringIO()
    with Progress(1000, stream=stream) as show:
        for done in range(1, 1001):
            show(done)
    assert stream.getvalue() == ""
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    with Progress(10, quiet=True, stream=stream) as show:
        show(1)
    assert stream.getvalue() == ""


def test_a_terminal_gets_a_bar_with_the_time_left(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    stream = Terminal()
    with Progress(10, stream=stream) as show:
        show(10)
    assert "10/10" in stream.getvalue()
    assert "100%" in stream.getvalue()
    assert "left" in stream.getvalue()


@pytest.mark.parametrize("name", ["dumb", "unknown", ""])
def test_a_terminal_that_cannot_go_back_gets_plain_lines(monkeypatch, name):
    monkeypatch.setenv("TERM", name)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    with Progress(200, stream=stream) as show:
        show(50)
    assert stream.getvalue().startswith("step 50 of 200 (25 %), ")


def test_the_time_left_follows_the_shaking_to_come():
    """Quiet for a fifth, then strong, then quiet: steps cost eight times as much while the base shakes, and half of that later."""
    dt, steps = 0.01, 2000
    time = dt * np.arange(steps + 1)
    velocity = np.where((time > 5.0) & (time < 9.0), np.sin(2 * np.pi * 2.0 * time), 0.0)[:, None, None] * [1.0, 0.0, 0.0]
    classes = motion_classes(velocity, dt)
    assert set(classes[:480]) == {REST}
    assert set(classes[520:900]) == {STRONG}
    assert set(classes[980:]) == {AFTER}, "blocks rock on for half a second"
    seconds, costs, ratios = np.choose(classes, [1e-3, 8e-3, 8e-3, 8e-3, 4e-3]), StepCosts(classes), []
    for k in range(steps - 1):
        costs.add(k + 1, seconds[k])
        ratios.append(costs.seconds_left() / seconds[k + 1 :].sum())
    assert min(ratios[steps // 5 :]) > 0.5
    assert max(ratios[steps // 5 :]) < 2.0
    alike = np.cumsum(seconds)[:-1] / np.arange(1, steps) * np.arange(steps - 1, 0, -1) / np.cumsum(seconds[::-1])[::-1][1:]
    assert min(alike[steps // 5 :]) < 0.3, "as if all steps cost alike"


def test_supports_that_move_apart_count_as_shaking_while_they_do():
    """A footing that sinks for three seconds of ten, and accelerates in the first and the last half second of these alone."""
    dt, steps = 0.01, 1000
    time = dt * np.arange(steps + 1)
    speed = np.clip(np.minimum(time - 2.0, 5.0 - time) / 0.5, 0.0, 1.0)
    velocity = np.zeros((steps + 1, 2, 3))
    velocity[:, 1, 2] = -0.01 * speed
    classes = motion_classes(velocity, dt)
    assert set(classes[:200]) == {REST}
    assert set(classes[215:500]) == {SETTLING}
    assert set(classes[560:]) == {AFTER}
    together = np.repeat(velocity[:, 1:], 2, axis=1)  # all of them: nothing is strained but by the acceleration
    assert set(motion_classes(together, dt)[310:440]) == {AFTER}
    assert STRONG in motion_classes(together, dt)


def ratios_of_time_left(classes, seconds):
    """Of the time left to what it is in truth, after each step but the last twentieth of the time."""
    costs, ratios = StepCosts(classes), []
    left = np.cumsum(seconds[::-1])[::-1]
    for k in range(int(np.searchsorted(-left, -0.05 * left[0])) - 1):
        costs.add(k + 1, seconds[k])
        ratios.append(costs.seconds_left() / left[k + 1])
    return np.array(ratios)


def test_the_first_steps_of_a_settlement_do_not_throw_the_estimate():
    """Costs as measured on a wall one of whose footings sinks, in half of the run: its load passes over to the others in seven steps."""
    classes, seconds = np.full(1000, REST, np.int8), np.full(1000, 0.5e-3)
    classes[511:], seconds[501:] = SETTLING, 1.2e-3
    seconds[501:508] = 5.7e-3
    found = ratios_of_time_left(classes, seconds)[200:]
    assert 0.5 < found.min() <= found.max() < 2.0


def test_what_has_cracked_costs_more_at_rest_than_what_has_not():
    """Costs as measured on a mortar wall: after the shaking, steps are as expensive as during it."""
    classes, seconds = np.full(3000, STRONG, np.int8), np.full(3000, 1.7e-3)
    classes[1249:], seconds[1249:] = AFTER, 1.5e-3
    found = ratios_of_time_left(classes, seconds)
    assert 0.5 < found.min() <= found.max() < 2.0


def test_steps_that_the_loads_jump_over_cost_nothing():
    costs = StepCosts(np.zeros(100, dtype=np.int8))
    costs.add(1, 2.0)
    assert costs.seconds_left() == pytest.approx(198.0)
    costs.add(91, 2.0)
    assert costs.seconds_left() == pytest.approx(18.0)


def test_steps_that_adapt_share_their_cost_among_those_of_the_loads():
    costs = StepCosts(np.zeros(100, dtype=np.int8), adaptive=True)
    costs.add(8, 2.0)
    costs.add(10, 0.5)
    assert costs.seconds_left() == pytest.approx(90 * 0.25, rel=0.05)


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


def test_lengths_below_a_nanometre_are_not_given_digits():
    assert [length(value) for value in (0.0, 2.76e-13, -3e-12, 1e-9, 9.996e-10, 44.9e-9, 1.66e-3, 2.0, 459.0, 5800.0)] == [
        "0 m", "under 1 nm", "under 1 nm", "1 nm", "1 nm", "44.9 nm", "1.66 mm", "2 m", "459 m", "5.8 km",
    ]  # fmt: skip
