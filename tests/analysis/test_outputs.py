# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of a run's numbers: a file adds one to all that shows numbers, and each is what it says."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis import outputs
from masonry_cd.analysis.damage.part_damage import part_damage
from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.analysis.outputs.folders import FOLDERS, files_of
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.pushover import PushCurve
from masonry_cd.app.commands.modal import METHODS
from masonry_cd.app.scene import parse_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.limit.curve import CURVE_OUTPUTS
from masonry_cd.limit.vehicle import CROSSING_OUTPUTS
from masonry_cd.mechanics.model.state import State
from masonry_cd.studies.study.task import numbers_of_run
from reports.assess import outputs as assess
from reports.compare.comparison import compare
from reports.damage import write_joint_damage
from reports.page import section, write_page
from reports.settings import Report
from reports.study.joint_maps import TABLE
from reports.study.outputs import FILES

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
    row, _, _ = numbers_of_run(folder / "result.h5", summary | Summary(**COMPUTED), parse_scene(SCENE + RUN, tmp_path / "scene.toml"))
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


def test_what_writes_a_file_finds_it_declared():
    assert {*CURVE_OUTPUTS, *CROSSING_OUTPUTS, "limit.json", "mechanisms.csv", "limit.html"} <= {*files_of("limit")}
    assert {f"{what}_{method}.{form}" for what, form in (("shapes", "csv"), ("modes", "png")) for method in METHODS} <= {*files_of("modal")}
    assert {assess.CSV, assess.FILE, assess.PICTURE, "assess_global.png", assess.PAGE} == {*files_of("assess")}
    assert {TABLE, "fragility.csv", "study.html"} <= {*FILES}
    assert "runs.csv" not in FILES  # which a study makes run by run, and no report takes away
    assert all(meaning for files in FOLDERS.values() for meaning in files.values())


FOUND: dict[str, Any] = {
    "stands": True, "bears_nothing": False, "no_finite_factor": False, "associated": 0.25, "verdict": None, "certificate": {"gap": 1e-12},
    "least": {"factor": 0.24, "agreeing": 4, "starts": 4}, "assumed": {"rows": [], "decides": None, "range": None, "brief": []},
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "grade", "sure"),
    [
        ({}, "load factor 0.24", "good"),
        ({"least": {"factor": 0.20, "agreeing": 1, "starts": 9}}, "load factor 0.2", "look"),
        ({"least": {"factor": 0.20, "agreeing": 1, "starts": 1}}, "load factor 0.2", "look"),  # one start agrees with nothing
        (
            {"least": {"factor": 0.2499, "agreeing": 1, "starts": 9}},
            "load factor 0.2499",
            "good",
        ),  # next to the upper value
        ({"least": None}, "load factor at most 0.25", "look"),
        ({"certificate": {"gap": 0.1}}, "load factor 0.25", "doubtful"),
        ({"no_finite_factor": True, "associated": None, "certificate": None}, "load factor 0.24", "look"),
        ({"no_finite_factor": True, "associated": None, "certificate": None, "least": None}, "no finite load factor", "look"),
        ({"stands": False}, "does not stand", "doubtful"),
        ({"bears_nothing": True}, "has no resistance to this load", "good"),
        ({"verdict": {"state": "NOT satisfied", "confidence": "certain", "because": "", "reason": "too little"}}, "NOT satisfied", "good"),
        ({"verdict": {"state": "not decided", "confidence": "doubtful", "because": "no search", "reason": ""}}, "not decided", "look"),
    ],
)
def test_the_factor_and_how_sure_it_is(changes, grade, sure):
    found = on_the_whole(FOUND | changes)
    assert (found.grade, found.sure) == (grade, sure)
    assert found.line.startswith(f"verdict: {grade}")


FORCE, YIELDS, END = 1000.0, 1e-3, 1e-2  # [N], [m]


def pushed(yields: float) -> PushCurve:
    """A push at one speed, whose force grows in proportion up to a displacement and then stays."""
    u = np.linspace(0.0, END, 2001)[1:]
    force = FORCE * np.minimum(1.0, u / yields) if yields else np.full(len(u), FORCE)
    return PushCurve("wall", "push", (1.0, 0.0, 0.0), np.arange(1.0, 2001.0), u, force, np.zeros(2000), np.zeros(2000))


def test_an_elastic_and_plastic_push_has_its_stiffness_and_is_its_own_idealisation() -> None:
    found = pushed(YIELDS).numbers()
    assert found.peak_force == FORCE
    assert found.stiffness == pytest.approx(FORCE / YIELDS, rel=0.02)
    assert found.bilinear.yield_force == pytest.approx(FORCE, rel=0.01)
    assert found.bilinear.ductility == pytest.approx(END / YIELDS, rel=0.05)


def test_a_rigid_push_has_a_peak_and_neither_stiffness_nor_ductility() -> None:
    found = pushed(0.0).numbers()
    assert found.peak_force == FORCE
    assert found.stiffness is None
    assert found.bilinear is None


@pytest.mark.parametrize("left", [0.0, 3e-7, -3e-7])
def test_a_cycle_that_ends_at_zero_but_for_rounding_is_whole(left: float) -> None:
    """A friction joint of force F, pushed to u, -u and back: the loop has 4 F u, and an equivalent damping of 2 / pi."""
    u = np.concatenate([np.linspace(0.0, END, 501)[1:], np.linspace(END, -END, 1001)[1:], np.linspace(-END, left, 501)[1:]])
    force = FORCE * np.sign(np.diff(u, prepend=0.0))
    count = len(u)
    (cycle,) = PushCurve("b", "push", (1.0, 0.0, 0.0), np.arange(1.0, count + 1.0), u, force, np.zeros(count), np.zeros(count)).cycles()
    assert cycle.dissipated == pytest.approx(4.0 * FORCE * END, rel=1e-3)
    assert cycle.damping == pytest.approx(2.0 / np.pi, rel=1e-3)
