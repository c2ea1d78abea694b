# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether what a run leaves is final, and what the tables, the page and the picture say where it is not."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.outputs.measured import in_short
from masonry_cd.app.closing_lines import part_lines
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.state import State
from reports import damage as damage_files
from reports.damage import damage_of
from reports.page.build import write_page
from reports.settings import Report

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
    assert part_lines(in_short(damage.parts))[-1] == f"grades, mechanisms and what is left are {said}"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "What is left is provisional" in page
    table = page[page.index('<div class="scroll parts"') :]
    heads, cells = (
        table[: table.index("</thead>")].count("<th "),
        table[table.index("<tbody>") : table.index("</tr>", table.index("<tbody>"))],
    )
    assert heads == cells.count("<td") + cells.count("<th "), "each column has a heading"
    assert "Grades and what is left are provisional: still moving at 19 mm" in page


def test_nothing_is_said_where_all_is_still(tmp_path: Path) -> None:
    with results_of(tmp_path, moving()) as results:
        summary = damage_files.write_joint_damage(results, tmp_path, Report())
        damage = damage_of(results, Report())
        write_page(results, tmp_path / "report.html", parts=damage)
    assert summary.provisional == ""
    assert "provisional" not in (tmp_path / "joints.csv").read_text()
    assert "provisional" not in "".join(part_lines(in_short(damage.parts)))
    assert "provisional" not in (tmp_path / "report.html").read_text(encoding="utf-8").partition("<script")[0]
