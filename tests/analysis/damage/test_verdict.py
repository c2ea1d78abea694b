# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict on a run: by its checks, in place of a grade wherever one stands, and provisional where the end is not final."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.verdict import checks_of
from masonry_cd.analysis.fragility.limits import LimitState, LimitStateTable
from masonry_cd.analysis.outputs.measured import in_short
from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.app.closing_lines import part_lines
from masonry_cd.app.scene import parse_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import Solver
from masonry_cd.mechanics.model.state import State
from masonry_cd.studies.study.task import numbers_of_run
from reports import damage as damage_files
from reports.compare.comparison import compare
from reports.damage import damage_of, write_joint_damage, write_part_damage
from reports.page import write_page
from reports.settings import Report

SOUND: dict[str, Any] = {
    "steps": 200,
    "stopped": "",
    "solver": {"error_max": 1e-9, "error_mean": 1e-10, "steps_missed": 0},
    "closing": {"steps": 0},
    "energy": {"balance_error": 1e-6, "lift_share": 0.0},
    "penetration_max": 1e-6,
    "time_step_remarks": [],
}
BEDS: dict[str, Any] = {"share_least": 0.06, "share": 0.29, "points": 3, "resolved": 0.408, "where": '"a" - "b"'}
SCENE = '[structure]\nkind = "file"\npath = "blocks.json"\n[material]\ndensity = 2000.0\nfriction = 0.6\n'
CUT = "do not rely on this run until the cause is removed: end of the run"


def false(slip: float, moved: float, where: str = "a and b at 1 s") -> dict[str, Any]:
    """A run that moved by ``moved`` [m], of which errors of the contact forces are to blame for some slip [m]."""
    return solver(false_slip_max=slip, false_opening_max=0.0, false_slip_where=where) | {"displacement_max": moved}


def tight(slip: float, moved: float, tolerance: float) -> dict[str, Any]:
    """Return the findings with a tolerance that is known."""
    return false(slip, moved) | {"solver": false(slip, moved)["solver"] | {"tolerance": tolerance}}


def solver(**changes: Any) -> dict[str, Any]:
    return {"solver": SOUND["solver"] | changes}


@pytest.mark.parametrize(
    ("changes", "worst", "why"),
    [
        ({}, "good", ""),
        (solver(steps_missed=1), "look", "1 of 200 steps missed the tolerance"),
        (solver(steps_missed=3), "doubtful", "3 of 200 steps missed the tolerance"),
        (solver(steps_missed=1, error_max=2.0), "doubtful", "an error of 2 at most"),
        (solver(steps_missed=1, error_max=None), "doubtful", "an error of nan at most"),
        ({"closing": {"steps": 2, "jam": "a wedge"}}, "doubtful", "2 steps left contacts closing: a wedge"),
        ({"energy": {"balance_error": 5e-3}}, "look", "open by 0.5 % of the largest work"),
        ({"energy": {"balance_error": None}}, "doubtful", "open by nan %"),
        (
            {"energy": {"balance_error": 1e-10, "lift_share": 0.026}},
            "look",
            "the energy balance closes, and taking overlaps away put in 2.6 % of the largest work",
        ),
        (solver(tolerance=5e-3) | {"energy": {"balance_error": 1e-10, "lift_share": 0.18}}, "doubtful", "set run.tolerance = 0.001"),
        ({"energy": {"balance_error": 1e-10, "lift_share": 0.25}, "displacement_max": 2e-6}, "good", ""),  # of a structure all but at rest
        ({"energy": {"balance_error": 1e-10, "lift_share": 0.25}, "displacement_max": 0.02}, "doubtful", "put in 25 %"),
        ({"penetration_max": 5e-3, "penetration_where": "a and b at 1 s"}, "doubtful", "overlap by up to 5 mm, of a and b at 1 s"),
        ({"penetration_max": 1.5e-3, "displacement_max": 0.095}, "look", "overlap by up to 1.5 mm"),  # of a structure that is thrown about
        ({"penetration_max": 1.5e-3, "displacement_max": 0.02}, "doubtful", "overlap by up to 1.5 mm"),
        ({"penetration_max": 5e-2, "displacement_max": 6.0}, "doubtful", "overlap by up to 50 mm"),
        ({"penetration_max": 5e-3, "collapsed_blocks": 3}, "look", "overlap by up to 5 mm"),  # of what landed
        ({"penetration_max": 5e-2, "collapsed_blocks": 3}, "doubtful", "overlap by up to 50 mm"),
        ({"stopped": "interrupted after step 3"}, "doubtful", "it ended early: interrupted after step 3"),
        ({"provisional": "provisional: still moving"}, "look", "provisional: still moving"),
        ({"time_step_remarks": ["run.dt is coarse"]}, "look", "run.dt is coarse"),
        ({"beds": {"share_least": None, "unresolved": 0}}, "good", ""),  # elastic joints of which none opened
        ({"beds": BEDS | {"unresolved": 2}}, "look", '"a" - "b" on 29 % of it where 3 points resolve 41 %'),
        ({"beds": BEDS | {"unresolved": 0}}, "good", ""),
        ({"loads": {"acted": [{"load": "loads[0]", "measure": "cycles", "share": 0.5}]}}, "look", "50 % of the cycles of loads[0]"),
        ({"loads": {"acted": [{"load": "loads[0]", "measure": "cycles", "share": 0.96}]}}, "good", ""),
        ({"doubts": ["block a falls"]}, "look", "block a falls"),
        ({"doubts": []}, "good", ""),
        ({"shortening_where": "a and b at 1 s", "shortening_max": 1e-3}, "look", "joints shortened by up to 1 mm"),
        ({"crushing_forgotten": 1}, "look", "1 joint"),
        ({"time_step": {"steps_wanted_shorter": 9, "dt_min": 1e-3}}, "look", "9 of 200 steps should have been shorter"),
        (solver(steps_missed=90, error_max=3e-3, error_reached=4.2e-4, tolerance_sound=1e-3), "look", "set run.tolerance = 0.0005"),
        (solver(steps_missed=90, error_max=3e-3, error_reached=9.7e-4, tolerance_sound=1e-3), "look", "set run.tolerance = 0.001"),
        (solver(steps_missed=90, error_max=3e-3, error_reached=2e-3, tolerance_sound=1e-3), "doubtful", "90 of 200 steps missed"),
        (false(1e-5, 1e-2), "good", ""),
        (false(5e-4, 1e-2), "look", "500 um of slip"),
        (false(5e-3, 1e-2), "doubtful", "5 mm of slip"),
        (tight(5e-3, 1e-2, 1e-3), "doubtful", "set run.tolerance = 1e-05"),
        (false(1e-5, 1e-5), "look", "10 um of slip"),  # too little to change a grade
        (false(1e-5, 1e-5, where=""), "good", ""),
    ],
)
def test_the_worst_check_decides_and_gives_its_numbers(changes, worst, why):
    found = checks_of(Summary(**SOUND | changes), Thresholds())
    assert (found.worst, found.is_reliable) == (worst, worst != "doubtful")
    assert why in found.verdict().why and bool(found.verdict().why) == (worst != "good")


def test_a_run_without_numbers_is_unknown_not_good():
    assert checks_of(Summary(), Thresholds()).worst == "unknown"


def blocks() -> list[Any]:
    return [box("base", (0, 0, -0.2), (1, 1, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 0.5), "pier")]


def run_in(folder: Path, ended: bool) -> Path:
    """A stone that has slid by 8 mm, in a run that ended or was cut off."""
    folder.mkdir()
    rest = at_rest(blocks())
    write_run(folder / "result.h5", blocks(), [rest, shifted(rest, 1, (0.008, 0, 0))], scene=SCENE, ended=ended)
    return folder


def test_a_run_that_cannot_be_relied_on_says_so_instead_of_a_grade(tmp_path):
    out = run_in(tmp_path / "cut", ended=False)
    with Results.open(out / "result.h5") as results:
        summary = write_joint_damage(results, out, Report())
        damage = damage_of(results, Report())
        write_part_damage(damage, out)
        write_page(results, out / "report.html", summary, parts=damage)
    assert summary.verdict.verdict == "doubtful"
    assert {row["grade"] for row in damage.parts} == {"not graded"}
    assert damage.parts[-1]["grade_reason"].startswith(CUT)
    with (out / "damage.csv").open(newline="") as file:
        assert {row["grade"] for row in csv.DictReader(file)} == {"not graded"}
    assert {row["grade"] for row in json.loads((out / "damage.json").read_text())["parts"]} == {"not graded"}
    first, *rest = part_lines(in_short(damage.parts))
    assert first.startswith(f"not graded: {CUT}")
    page = (out / "report.html").read_text(encoding="utf-8").partition("<body>")[2].partition('<script type="application/json"')[0]
    assert page.index("Do not rely on this run until the cause is removed") < page.index('<dl class="block">') < page.index("<main>")
    assert page.count('<span class="grade not-graded">not graded</span>') == len(damage.parts) + 1
    for said in ("".join(rest), page.partition('id="grades-title"')[0]):
        assert not any(grade in said for grade in ("D1", "D2", "D3"))


def test_a_comparison_and_a_study_give_it_no_grade(tmp_path):
    cut, ended = run_in(tmp_path / "cut", ended=False), run_in(tmp_path / "ended", ended=True)
    found = compare([cut, ended])
    assert next(values for name, _, values in found.rows if name == "grade") == ["not graded", "D2"]
    assert any(word.startswith(f"cut: not graded: {CUT}") for word in found.words)
    scene = parse_scene(SCENE + "[run]\ndt = 1e-3\nduration = 1.0\n", tmp_path / "scene.toml")
    state = LimitState.of("heavy", LimitStateTable(quantity="grade", at_least="D2"))
    exceeded = []
    for folder in (cut, ended):
        with Results.open(folder / "result.h5") as results:
            summary = write_joint_damage(results, folder, Report()) | Summary(steps=1, solver=Solver(steps_missed=0, error_max=0.0))
        exceeded.append(state.exceeded_by(RunRow(DONE, numbers=numbers_of_run(folder / "result.h5", summary, scene)[0])))
    assert exceeded == [None, True]


def test_groups_that_no_table_of_parts_can_have_are_not_graded(tmp_path):
    named = [box("base", (0, 0, -0.2), (1, 1, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 0.5), "structure")]
    write_run(tmp_path / "result.h5", named, [at_rest(named)], scene=SCENE, ended=True)
    with Results.open(tmp_path / "result.h5") as results:
        assert write_joint_damage(results, tmp_path, Report()).verdict.grade == ""


PAIR = [
    box("base", (-1, 0, -0.5), (3, 1, 0), "base", fixed=True),
    box("lower", (0, 0, 0), (1, 1, 1), "pier"),
    box("upper", (0, 0, 1), (1, 1, 2), "pier"),
]


def moving(linear: tuple[float, float, float] = (0, 0, 0), turning: float = 0.0, base: float = 0.0) -> State:
    """The pier, its upper block slid by 2 mm and moving, on a base that moves along x."""
    state = shifted(at_rest(PAIR), 2, (0.002, 0, 0))
    state.velocity[:, 0] = base
    state.velocity[2, :3] += linear
    state.velocity[2, 4] = turning
    state.orientation[2, [0, 2]] = np.cos(0.1 * turning), np.sin(0.1 * turning)  # by what it turns in 0.2 s
    return state


def results_of(folder: Path, last: State, scene: str = "") -> Results:
    return Results.open(write_run(folder / "result.h5", PAIR, [at_rest(PAIR), last], scene=scene))


@pytest.mark.parametrize(
    ("last", "said"),
    [
        (moving(), ""),
        (moving((0.0009, 0, 0)), ""),
        (moving((0, 0.019, 0)), 'provisional: still moving at 19 mm/s ("upper") at 0.1 s'),
        (moving(turning=0.1), f'provisional: still moving at {100 * np.sqrt(0.75):.3g} mm/s ("upper") at 0.1 s'),
        (moving(base=0.2), "provisional: the base still moving at 200 mm/s at 0.1 s"),
    ],
    ids=["still", "slower than 1 mm/s", "a block moves", "a block turns", "the base moves"],
)
def test_what_moves_at_the_end_is_named(tmp_path: Path, last: State, said: str) -> None:
    with results_of(tmp_path, last) as results:
        assert end_state(results).provisional == said


@pytest.mark.parametrize("still", [True, False], ids=["ended still", "ended by its time"])
def test_a_block_that_rattles_and_goes_nowhere_is_still(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, still: bool) -> None:
    """If the run ended because it was; else two frames alike may be those of a structure that sways."""
    last = at_rest(PAIR)
    last.velocity[2] = 0.007, -0.005, 0.0, 0.0, 0.02, 0.0
    monkeypatch.setattr(Results, "closing", Summary(stopped="", ended_still=still))
    with results_of(tmp_path, last) as results:
        end = end_state(results)
    assert (end.provisional == "") is still
    assert end.end.rattles.startswith('"upper" at ') is still


def test_a_block_that_has_fallen_may_roll(tmp_path: Path) -> None:
    last = shifted(at_rest(PAIR), 2, (2.0, 0, -1.0))
    last.velocity[2, 0] = 0.5
    with results_of(tmp_path, last) as results:
        assert end_state(results).provisional == ""


def test_a_run_that_was_killed_is_provisional(tmp_path: Path) -> None:
    """Its scene is kept, and no closing words."""
    with results_of(tmp_path, moving(), "[run]\ndt = 1e-3\nduration = 9.0\n") as results:
        assert end_state(results).provisional == "provisional: the run was cut off at 0.1 s"


def test_tables_summary_text_and_page_say_so(tmp_path: Path) -> None:
    said = 'provisional: still moving at 19 mm/s ("upper") at 0.1 s'
    with results_of(tmp_path, moving((0, 0.019, 0))) as results:
        summary = damage_files.write_joint_damage(results, tmp_path, Report())
        damage = damage_of(results, Report())
        damage_files.write_part_damage(damage, tmp_path)
        write_page(results, tmp_path / "report.html", parts=damage)
    assert summary.provisional == said
    assert summary.end.speed == pytest.approx(0.019)
    for name in ("joints.csv", "damage.csv"):
        with (tmp_path / name).open(newline="") as file:
            assert {row["provisional"] for row in csv.DictReader(file)} == {said}, name
    assert damage_files.as_json(damage)["provisional"] == said
    assert part_lines(in_short(damage.parts))[-1] == f"grades, mechanisms and residual values are {said}"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Grades and residual values are provisional: still moving at 19 mm" in page
