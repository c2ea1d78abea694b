# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages to the user: one line that a terminal can show."""

from __future__ import annotations

import copy
import pickle

import pytest

from masonry_cd.foundation.errors import LINE, MOST_LINES, Fault, Faults, InputError, WrongKeys, of_each, one_line
from structures.geometry.checks import Unsound


@pytest.mark.parametrize("value", ["a" * 10_000, 'a": {"' * 2_000, "a b " * 3_000, "\x1b[31m" * 2_000])
def test_long_values_are_cut_and_what_is_said_about_them_stays(value):
    shown = one_line(f'modes.csv: unknown column "{value}"; known: mode, frequency_hz')
    assert len(shown) <= LINE + 5
    assert shown.startswith("modes.csv: unknown column ") and shown.endswith("known: mode, frequency_hz")
    assert shown.isprintable()


def test_an_error_has_a_place_and_a_text():
    error = InputError("run.dt", "must be above 0 s, got -1")
    assert (error.place, error.faults, str(error)) == (
        "run.dt",
        (Fault("run.dt", "must be above 0 s, got -1"),),
        "run.dt: must be above 0 s, got -1",
    )
    assert str(error.under("loads[0]")) == "loads[0]: run.dt: must be above 0 s, got -1"
    assert str(InputError("", "no run is open")) == "no run is open"


def test_a_source_stands_before_its_place_and_goes_with_unsourced():
    located = InputError("run.dt", "missing").each(lambda fault: fault._replace(source="a.toml:3"))
    assert str(located) == "a.toml:3: run.dt: missing"
    assert (located.place, str(located.unsourced())) == ("run.dt", "run.dt: missing")


@pytest.mark.parametrize(
    "error",
    [
        InputError("run.dt", "missing"),
        InputError.of([Fault("a", "wrong"), Fault("b", "wrong", "s.toml:1")]),
        WrongKeys([("a", 0)], [Fault("a[0]", "wrong")]),
        Unsound('block "b"', "open", ["b"]),
    ],
)
def test_an_error_survives_the_way_to_another_process(error):
    for same in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(same) is type(error)
        assert (same.faults, str(same)) == (error.faults, str(error))
    assert pickle.loads(pickle.dumps(Unsound("b", "open", ["b"]))).faulty == ("b",)


def test_faults_come_together_each_once_and_a_few_of_many():
    faults = Faults()
    for place in ("a", "b", "a"):
        with faults.of("wall"):
            raise InputError(place, "wrong")
    with pytest.raises(InputError) as caught:
        faults.refuse()
    assert caught.value.lines == ("wall: a: wrong", "wall: b: wrong")
    with pytest.raises(InputError) as many:
        of_each(lambda k: (_ for _ in ()).throw(InputError(f"loads[{k}]", "wrong")), range(40))
    assert len(many.value.faults) == 40 and len(many.value.lines) == MOST_LINES + 1
    assert of_each(lambda k: k * k, range(3)) == [0, 1, 4]
    Faults().refuse()
