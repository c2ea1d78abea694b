# SPDX-License-Identifier: GPL-3.0-or-later
"""The lengths of adapting steps: the rules by themselves."""

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.step_control import CALM, QUIET, REPEAT, StepControl

LONGEST = 32


def freely(span: int) -> bool:
    return True


def walk(errors, control=None, end=10_000, room=lambda ticks: 10_000, allows=freely):
    """Steps by the rules, with the local error of each given as a function of its beginning and length: beginnings and lengths."""
    control, ticks, steps = control or StepControl(LONGEST), 0, []
    while ticks < end:
        span = control.next_span(ticks, min(room(ticks), end - ticks), allows)
        while shorter := control.judge(span, errors(ticks, span), False, False):
            span = shorter
        steps.append((ticks, span))
        ticks += span
    return steps


def test_steps_grow_while_it_is_quiet_and_each_begins_at_a_multiple_of_its_length():
    steps = walk(lambda ticks, span: 0.0)
    assert steps[-1][1] == 16  # 10,000 = 312 x 32 + 16
    assert [span for _, span in steps[: 2 * QUIET]] == [1] * (QUIET + 1) + [2] * (QUIET - 1)  # a step of 2 begins at an even tick
    assert all(ticks % span == 0 for ticks, span in steps)
    assert sum(span for _, span in steps) == 10_000
    assert {span for _, span in steps[40:-1]} == {LONGEST}


@pytest.mark.parametrize(("quiet", "span"), [(QUIET - 1, 1), (QUIET, 2)])
def test_a_step_grows_after_a_number_of_quiet_ones_and_not_before(quiet, span):
    control = StepControl(LONGEST, 1)
    for _ in range(quiet):
        control.judge(1, 0.0, False, False)
    assert control.next_span(LONGEST, 99, freely) == span


def test_every_instant_asked_for_is_met():
    stops = np.unique(np.random.default_rng(5).integers(1, 4000, 60)).tolist()
    met = {ticks for ticks, _ in walk(lambda t, s: 0.0, end=4000, room=lambda t: min((x for x in stops if x > t), default=9999) - t)}
    assert set(stops) <= met | {4000}


def test_landing_costs_no_more_than_a_halving_each_and_the_length_comes_back_at_once():
    steps = walk(lambda t, s: 0.0, end=640, room=lambda t: 640 if t >= 333 else 333 - t)
    after = [span for ticks, span in steps if ticks >= 333]
    assert after[:6] == [1, 2, 16, 32, 32, 32]  # 333, 334, 336, 352: up as fast as the multiples let it


def test_an_error_shortens_and_a_gross_one_repeats():
    control = StepControl(LONGEST, 16)
    assert control.judge(16, 0.9, False, False) == 0 and control.span == 16
    assert control.judge(16, 1.1, False, False) == 0 and control.span == 8
    assert control.judge(8, 1.01 * REPEAT, False, False) == 2  # sqrt(4.04): two halvings
    assert control.judge(2, 1e9, False, False) == 1
    assert control.judge(1, 1e9, False, False) == 0  # nothing is shorter
    assert StepControl(LONGEST, 16).judge(16, np.inf, True, True) == 1


def test_what_is_not_quiet_lets_no_step_grow():
    for error, missed, event in ((1.01 * CALM, False, False), (0.0, True, False), (0.0, False, True)):
        control = StepControl(LONGEST, 1)
        for ticks in range(50):
            assert control.next_span(ticks, 99, freely) == 1
            assert control.judge(1, error, missed, event) == 0


def test_a_missed_step_is_made_again_once_in_a_row_of_them():
    control = StepControl(LONGEST, 16)
    assert control.judge(16, 0.1, True, False) == 8
    assert control.judge(8, 0.1, True, False) == 0
    assert control.judge(8, 0.1, True, False) == 0
    assert control.span == 8
    assert control.judge(8, 0.1, False, False) == 0
    assert control.judge(8, 0.1, True, False) == 4


def test_what_the_loads_do_not_allow_is_not_taken():
    control = StepControl(LONGEST, 32, QUIET)
    assert control.next_span(64, 99, lambda span: span <= 4) == 4
    assert (control.span, control.quiet) == (4, 0)


def test_the_order_of_an_impact_and_of_a_smooth_motion_end_within_the_tolerance():
    smooth = walk(lambda ticks, span: (span / 10.0) ** 3)
    assert {span for _, span in smooth[20:-1]} == {8}  # with an error of 0.51; twice as long it would be 4.1
    impact = walk(lambda ticks, span: 100.0 * (ticks <= 5000 < ticks + span) * span)
    assert next(span for ticks, span in impact if ticks <= 5000 < ticks + span) == 1
    assert len(impact) < 450


# --- the keys ---------------------------------------------------------------------------------------------------------------------


def settings(**keys):
    return parse_table(Run, {"duration": 2.0} | keys, "run")


def test_a_number_stays_a_fixed_step():
    run = settings(dt=4e-3)
    assert (run.is_adaptive, run.longest_step, run.longest_ticks, run.steps, run.frame_every) == (False, 4e-3, 1, 500, 5)


def test_the_ladder_halves_down_from_the_longest_step():
    run = settings(dt="auto")
    assert (run.is_adaptive, run.longest_step, run.dt, run.spans) == (True, 1e-2, 1e-2 / 32, (1, 2, 4, 8, 16, 32))
    run = settings(dt="auto", dt_max=2e-2, dt_min=3e-3)
    assert (run.longest_step, run.dt, run.spans) == (2e-2, 5e-3, (1, 2, 4))
    assert settings(dt="auto", dt_max=2e-3, dt_min=2e-3).spans == (1,)


@pytest.mark.parametrize(
    ("frames", "every"), [(50.0, 64), (30.0, 96), (100.0, 32), (150.0, 16), (400.0, 8), (1e6, 1), (1e-300, 20_000_000)]
)
def test_frames_are_at_fixed_times_that_long_steps_meet(frames, every):
    assert settings(dt="auto", frames_per_second=frames).frame_every == every


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        ({"dt": 1e-3, "dt_max": 1e-2}, 'run: dt_max is for dt = "auto" alone, and dt is given as 0.001'),
        ({"dt": 1e-3, "dt_tolerance": 1e-5}, 'run: dt_tolerance is for dt = "auto" alone, and dt is given as 0.001'),
        ({"dt": "auto", "dt_min": 2e-2}, "run: dt_min 0.02 s is above dt_max 0.01 s"),
        ({"dt": "auto", "dt_max": 0.2}, "run.dt_max: input should be less than or equal to 0.1, got 0.2 s"),
        ({"dt": "auto", "dt_max": "long"}, "run.dt_max: input should be a valid number, got 'long'"),
        ({"dt": "auto", "dt_min": -1.0}, "run.dt_min: input should be greater than 0, got -1.0 s"),
        ({"dt": "auto", "dt_tolerance": 0.0}, "run.dt_tolerance: input should be greater than 0, got 0.0 m"),
        ({"dt": "fast"}, "run.dt: input should be a valid number, got 'fast'"),
        ({"dt": "auto", "duration": 1e-4}, "run: duration 0.0001 s is shorter than one step dt 0.0003125 s"),
        ({"dt_max": 1e-2}, "run.dt: missing"),
    ],
)
def test_keys_that_contradict_one_another_are_refused_by_name(keys, line):
    with pytest.raises(InputError) as refused:
        settings(**keys)
    assert str(refused.value) == line
