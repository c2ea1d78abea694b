# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of a run's numbers: a file adds one to all that shows numbers, and each is what it says."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis import outputs
from masonry_cd.analysis.damage.part_damage import part_damage
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.app.scene import parse_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.state import State
from masonry_cd.studies.study.task import of_run
from reports.compare.comparison import compare
from reports.damage import write_joint_damage
from reports.page import section, write_page
from reports.settings import Report

SCENE = '[structure]\nkind = "file"\npath = "b.json"\n[material]\ndensity = 2000.0\nfriction = 0.6\n'
COMPUTED = {"steps": 1, "solver": {"steps_missed": 0, "error_max": 0.0}}
RUN = "[run]\ndt = 1e-3\nduration = 0.2\n"
PUSH = '[[loads]]\nkind = "push"\ndirection = "x"\nrate = 0.1\n'
DOCS = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "write_output_reference.py"))
LOWEST = """
from masonry_cd.analysis.outputs import Number
NUMBERS = {"lowest": Number("lowest corner", "of all blocks at the end", lambda run: float(run.results.position[-1, :, 2].min()), unit="m")}
"""
WHERE = """
from reports.page.section import Section
SECTIONS = {"where": Section("Where <it> ended", lambda context: {"z": 0.5, "who": "<b>"}, template="<p>{{ who }} at {{ z }} m</p>")}
"""


def blocks() -> list:
    return [box("base", (0, 0, -0.2), (1, 1, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 0.5), "pier")]


def moving(speeds: list[float]) -> list[State]:
    """A stone with these speeds along x, a tenth of a second apart; the base stands."""
    states = []
    for speed in speeds:
        state = shifted(at_rest(blocks()), 1, (0.001, 0.0, 0.0))
        state.velocity[1, 0] = speed
        states.append(state)
    return states


def measured(folder: Path, speeds: list[float], scene: str = SCENE) -> dict:
    with Results.open(write_run(folder / "result.h5", blocks(), moving(speeds), scene=scene, ended=True)) as results:
        run = Measured(results, summary=Summary(**COMPUTED, provisional=""))
        return {key: number.compute(run) for key, number in outputs.NUMBERS.items()}


def test_the_base_shear_is_what_the_supports_give_the_blocks(tmp_path):
    """0.3 m/s in a tenth of a second is 3 m/s2 on all of the mass."""
    assert measured(tmp_path, [0.0, 0.1, 0.4, 0.4])["base_shear_max"] == pytest.approx(3.0 / 9.80665)


def test_a_load_on_the_blocks_leaves_no_base_shear(tmp_path):
    assert measured(tmp_path, [0.0, 0.1, 0.4], SCENE + PUSH)["base_shear_max"] is None


@pytest.fixture
def add(tmp_path, monkeypatch) -> Iterator:
    """Put a module into a package, as if its file lay there."""
    added = []

    def put(package, name: str, source: str) -> None:
        folder = tmp_path / package.__name__
        folder.mkdir()
        (folder / f"{name}.py").write_text(source, encoding="utf-8")
        monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
        added.append(f"{package.__name__}.{name}")

    yield put
    for name in added:
        sys.modules.pop(name, None)


def test_one_file_adds_a_number_to_all_that_shows_numbers(add, tmp_path):
    add(outputs, "lowest", LOWEST)
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        folder.mkdir()
        with Results.open(write_run(folder / "result.h5", blocks(), moving([0.0, 0.0]), scene=SCENE + RUN, ended=True)) as results:
            summary = write_joint_damage(results, folder, Report())
            write_page(results, folder / "report.html", summary, parts=part_damage(results))
    assert summary.lowest == pytest.approx(-0.1)
    row, _, _ = of_run(folder / "result.h5", summary | Summary(**COMPUTED), parse_scene(SCENE + RUN, tmp_path / "scene.toml"))
    assert row["lowest"] == summary.lowest
    assert ("lowest corner", "m", [pytest.approx(-0.1)] * 2) in compare(folders).rows
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<dt>lowest corner</dt>" in page
    assert "| lowest corner | `lowest` | m | of all blocks at the end |" in DOCS["reference"]()


def test_one_file_adds_a_section_to_the_page(add, tmp_path):
    import reports.page

    add(reports.page, "where", WHERE)
    assert "where" in section.KNOWN
    with Results.open(write_run(tmp_path / "result.h5", blocks(), moving([0.0, 0.0]), scene=SCENE)) as results:
        write_page(results, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert '<h2 id="where-title">Where &lt;it&gt; ended</h2>' in text and "<p>&lt;b&gt; at 0.5 m</p>" in text
    assert text.index('id="tables-title"') < text.index('id="where-title"')


def test_names_and_units_are_said_once_for_each_number():
    for key, number in outputs.NUMBERS.items():
        assert number.name and number.meaning and set(number.places) <= set(outputs.FORMATS), key
        assert (number.unit == "m") == (number.shown == ("mm", 1e3)), key
    assert next(iter(outputs.numbers_in(outputs.STUDY))) == "max_opening"  # with which the results of runs.csv begin
    assert [*outputs.numbers_in(outputs.SUMMARY)][:3] == ["displacement_max", "opening_max", "sliding_max"]
    assert len(np.unique([number.name for number in outputs.NUMBERS.values()])) == len(outputs.NUMBERS)


def test_the_reference_is_up_to_date():
    assert DOCS["PAGE"].read_text(encoding="utf-8") == DOCS["reference"](), "python docs/write_output_reference.py"
