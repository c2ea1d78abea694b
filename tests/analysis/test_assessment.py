# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines on an assessment: which assumption decides, the effect of chance, which runs have no result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_assessment import KNOWN, LEVELS, made, row, written

from masonry_cd.analysis.assessment.assessment import ANSWERS, LEVEL, KnownAssumption, Member, read_assessment
from masonry_cd.analysis.assessment.verdict import lines_of, on_the_whole, to_pin_down, verdict, warnings_of
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation.errors import InputError

DISPLACEMENT = ANSWERS[0]


def test_what_moves_the_answer_decides_and_what_chance_does_as_well_does_not() -> None:
    assert verdict(made()) == "between D2 and D4; joint stiffness decides; friction, damping, time step and tolerance do not"
    assert [one.name for one in to_pin_down(made())] == ["joint stiffness"]


def test_bars_run_from_the_least_to_the_largest_level() -> None:
    found = made()
    stiffness = found.bar(KNOWN[0], DISPLACEMENT)
    assert (stiffness.low, stiffness.high, stiffness.shows) == (pytest.approx(0.1), pytest.approx(0.24), True)
    damping = found.bar(KNOWN[2], DISPLACEMENT)  # in addition to its own reference: on other joints than those of the base case
    assert (damping.low, damping.high, damping.shows) == (pytest.approx(0.176), pytest.approx(0.18), False)


def test_without_chance_five_per_cent_are_felt() -> None:
    found = made({("friction", "0.4"): 106.0, ("time step", "2 ms"): 104.0}, chance=0.0)
    assert [one.name for one in found.deciding] == ["joint stiffness", "friction"]


def test_runs_that_differ_by_chance_alone_do_not_show_in_19_of_20_cases() -> None:
    random, shown, cases = np.random.default_rng(3), 0, 400
    for _ in range(cases):
        levels = {key: float(value) for key, value in zip(LEVELS, random.normal(100.0, 20.0, len(LEVELS)), strict=True)}
        found = made(levels, chance=0.0)
        members = [row(float(value)) for value in random.normal(100.0, 20.0, 8)]
        rows = [replace(one, row=members[k]) if k < 8 else one for k, one in enumerate(found.members)]
        found = type(found)(found.title, found.scene, found.assumptions, (), tuple(rows))
        shown += found.bar(KNOWN[0], DISPLACEMENT).shows
    assert 0.02 < shown / cases < 0.09


def test_a_time_step_that_decides_is_a_warning_and_nothing_to_pin_down() -> None:
    found = made({("time step", "2 ms"): 300.0})
    assert any(line.startswith("time step change") for line in warnings_of(found))
    assert [one.name for one in to_pin_down(found)] == ["joint stiffness"]
    assert verdict(found).startswith("between D2 and D4; time step and joint stiffness decide; ")


def test_levels_coarser_than_the_base_case_are_shown_and_decide_nothing(tmp_path: Path) -> None:
    points = KnownAssumption("joint points", "9", ("5", "15"), "", True, ("5",))
    base, rows = made(), ((one, row(value)) for one, value in (("5", 900.0), ("15", 101.0)))
    members = (*base.members, *(Member(LEVEL, {"joint points": name}, one) for name, one in rows))
    found = type(base)(base.title, base.scene, (*base.assumptions, points), (), members)
    assert points not in found.deciding and found.range(DISPLACEMENT) == base.range(DISPLACEMENT)
    assert found.level("joint points", "5") in found.members
    assert read_assessment(written(tmp_path, found)).assumptions == found.assumptions


FAILED = RunRow("failed", "blocks overlap", 0.1)


def test_runs_without_data_and_runs_that_missed_are_named() -> None:
    found = made({("friction", "0.4"): FAILED, ("joint stiffness", "E 3.3 GPa"): row(120.0, steps_missed=3)})
    said = warnings_of(found)
    assert "friction 0.4: no result: blocks overlap" in said
    assert "1 run missed the tolerance in some steps (marked *): joint stiffness E 3.3 GPa" in said
    assert found.bar(KNOWN[1], DISPLACEMENT).values == (("0.6", pytest.approx(0.098)),)


def test_an_assumption_all_of_whose_runs_failed_is_no_idle_one() -> None:
    found = made({("friction", "0.4"): FAILED, ("friction", "0.6"): FAILED})
    assert verdict(found).endswith("damping, time step and tolerance do not; nothing is known of friction")


def test_a_run_that_is_not_graded_has_no_part_in_the_range_of_grades() -> None:
    unreliable = row(240.0, grade_number=None, grade="not graded")
    found = made({("joint stiffness", "E 700 MPa"): unreliable, ("damping", "0 %"): 120.0, ("damping", "5 %"): 120.0})
    assert verdict(found).startswith("D2 in all runs that have a grade; ")
    assert any("1 run cannot be relied on and is not graded: joint stiffness E 700 MPa" in line for line in warnings_of(found))


def test_what_a_run_cannot_be_relied_on_for_is_said() -> None:
    found = made({("joint stiffness", "E 700 MPa"): row(240.0, grade_number=None, grade="not graded", doubt="12 mm of false slip")})
    assert any(line.endswith("is not graded: joint stiffness E 700 MPa (12 mm of false slip)") for line in warnings_of(found))
    first, *others = made().members
    base = replace(first, row=row(100.0, grade="not graded", grade_number=None, doubt="9 steps missed"))
    whole = on_the_whole(type(made())("Made", "made.toml", KNOWN, (), (base, *others)))
    assert whole.why.startswith("the base case cannot be relied on (9 steps missed); ")


def test_where_an_assumption_decides_no_single_grade_stands_first() -> None:
    found = on_the_whole(made())
    assert (found.grade, found.sure) == ("between D2 and D4", "look") and found.why.startswith("joint stiffness decides")
    finer = on_the_whole(made({("time step", "2 ms"): 300.0}))
    assert finer.sure == "doubtful" and finer.why.startswith("time step changes the answers")
    idle = dict.fromkeys(LEVELS, 100.0)
    assert on_the_whole(made(idle)).sure == "good" and on_the_whole(made(idle)).grade == "D2 in all runs"


def test_a_pair_that_is_more_than_its_parts_is_named() -> None:
    levels = ("joint stiffness", "E 700 MPa", "friction", "0.4")
    plain = next(line for line in lines_of(made(pairs={levels: 241.0})) if line.startswith("pairs"))
    assert "none of 1 differs" in plain
    more = next(line for line in lines_of(made(pairs={levels: 341.0})) if line.startswith("pairs"))
    assert "joint stiffness E 700 MPa, friction 0.4 (+100 mm)" in more


def test_the_load_factor_of_a_scene_that_is_not_shaken() -> None:
    def only(factor: float) -> RunRow:
        return RunRow("done", seconds=0.1, numbers={"load_factor": factor})

    found = made({key: only(0.3 if key[0] == "friction" else 0.2) for key in LEVELS})
    first, *others = (one for one in found.members if one.kind != "ensemble")
    found = type(found)(found.title, found.scene, found.assumptions, (), (replace(first, row=only(0.2)), *others))
    expected = "load factor between 0.2 and 0.3; friction decides; joint stiffness, damping, time step and tolerance do not"
    assert verdict(found) == expected


def test_it_is_read_as_it_was_written(tmp_path: Path) -> None:
    found = read_assessment(written(tmp_path, made()))
    assert found.as_dict() == made().as_dict()
    with pytest.raises(InputError, match="no assessment was made there"):
        read_assessment(tmp_path / "nothing")
    (tmp_path / "assess.json").write_text('{"title": 1}', encoding="utf-8")
    with pytest.raises(InputError, match="is not an assessment"):
        read_assessment(tmp_path)
