# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's folder: what is read and refused, what is written by which design, and that the same folder gives the same bytes."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from xml.etree import ElementTree

import browser
import numpy as np
import pytest
from hostile import refused_at
from made_study import COLLAPSE, Made, rows_of, write_study_folder
from pictures import pixels

from masonry_cd.analysis.fragility.findings import findings_in
from masonry_cd.analysis.fragility.folder import read_study
from masonry_cd.foundation.errors import InputError
from reports.drawing import palette
from reports.drawing.parts import ColourClasses
from reports.study.joint_maps import SHARES
from reports.study.outputs import write_study

SPACE = "{http://openquake.org/xmlns/nrml/0.5}"


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def stripes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study in stripes, written once."""
    folder = write_study_folder(tmp_path_factory.mktemp("study"), Made(records=40, by_friction=0.2), joints=True)
    write_study(folder)
    return folder


def test_stripes_give_the_median_that_they_were_made_with(stripes: Path):
    """The true medians are 3 m/s2 and, where the opening is 1 mm, half of that; 40 records know them within 3 * 0.36 / sqrt(40)."""
    rows = {row["limit_state"]: row for row in table(stripes / "fragility.csv")}
    assert list(rows) == ["cracked", "collapse"]
    for name, theta in (("cracked", 1.5), ("collapse", 3.0)):
        row = rows[name]
        assert (row["measure"], row["method"], row["runs"]) == ("PGA", "mle", "200")
        assert abs(np.log(float(row["theta"]) / theta)) < 3 * 0.36 / np.sqrt(40)
        assert float(row["theta_low"]) < float(row["theta"]) < float(row["theta_high"])
        assert float(row["beta_low"]) < float(row["beta"]) < float(row["beta_high"])
    found = json.loads((stripes / "fragility.json").read_text(encoding="utf-8"))
    assert all(fit["beta_record"] > fit["beta_model"] > 0.05 for fit in found["fits"])


def test_openquake_gets_its_units(stripes: Path):
    row = next(row for row in table(stripes / "fragility.csv") if row["limit_state"] == "collapse")
    theta, beta = float(row["theta"]) / 9.80665, float(row["beta"])
    root = ElementTree.parse(stripes / "fragility.xml").getroot()
    assert root.tag == f"{SPACE}nrml"
    assert root.findtext(f"{SPACE}fragilityModel/{SPACE}limitStates") == "cracked collapse"
    function = root.find(f"{SPACE}fragilityModel/{SPACE}fragilityFunction")
    assert function is not None
    assert (function.get("format"), function.get("shape")) == ("continuous", "logncdf")
    imls = function.find(f"{SPACE}imls")
    assert imls is not None
    assert imls.get("imt") == "PGA"
    params = {found.get("ls"): found for found in function.iter(f"{SPACE}params")}
    mean = theta * np.exp(beta**2 / 2)
    assert float(params["collapse"].get("mean", "nan")) == pytest.approx(mean, rel=1e-4)
    assert float(params["collapse"].get("stddev", "nan")) == pytest.approx(mean * np.sqrt(np.expm1(beta**2)), rel=1e-4)


def test_friction_shows_once_the_intensity_is_taken_out(stripes: Path):
    rows = {(row["variable"], row["quantity"]): row for row in table(stripes / "sensitivity.csv")}
    friction, measure = rows["material.friction", "max_opening"], rows["PGA", "max_opening"]
    assert float(measure["rho"]) > 0.7
    assert measure["given_measure"] == ""
    assert float(friction["given_measure"]) < float(friction["rho"]) < 0
    assert float(friction["low"]) < float(friction["rho"]) < float(friction["high"]) < 0


def test_the_maps_colour_each_joint_by_how_often_it_opened(stripes: Path):
    scale, rows = ColourClasses(SHARES, palette.SHARES, 100.0), table(stripes / "joint_probabilities.csv")
    runs = table(stripes / "runs.csv")
    for j, row in enumerate(rows):
        hits = [float(run["max_opening"]) * 0.5**j >= 1e-4 or (j == 2 and run["collapsed_blocks"] == "1") for run in runs]
        assert float(row["opened"]) == pytest.approx(np.mean(hits), abs=1e-6)
    image = pixels(stripes / "probability_lost.png")
    wanted = scale(np.array([float(rows[2]["lost"])]))[0]
    model = image[:, : image.shape[1] // 2]
    assert (model == wanted).all(axis=2).sum() > 200
    others = [colour for colour in scale.colours if not np.array_equal(colour, wanted)]
    assert max((model == colour).all(axis=2).sum() for colour in others) < 20


def test_the_same_folder_gives_the_same_bytes(tmp_path: Path):
    files = []
    for name in ("a", "b"):
        folder = write_study_folder(tmp_path / name, Made(records=8))
        write_study(folder)
        files.append({path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()})
    assert files[0] == files[1]
    assert {"fragility.csv", "fragility.png", "study.html", "summary.json", "tornado.png"} <= set(files[0])


@pytest.mark.parametrize(
    ("made", "there", "missing"),
    [
        (Made(design="ida", levels=tuple(np.linspace(0.5, 9.0, 18))), {"fragility.csv", "ida.png"}, {"cloud.png", "stripes.png"}),
        (Made(design="cloud", records=20), {"fragility.csv", "cloud.png"}, {"ida.png", "stripes.png"}),
        (Made(design="ensemble", measure=None), {"spread.png", "sensitivity.csv"}, {"fragility.csv", "fragility.png", "ida.png"}),
    ],
)  # fmt: skip
def test_a_design_has_the_files_that_it_allows(made: Made, there: set[str], missing: set[str], tmp_path: Path):
    rows = rows_of(made)
    if made.design == "ida":
        rows = [row | {"material.friction": "0.6"} for row in rows]
    if made.design == "ensemble":
        rows = [row | {"level": "", "motion": ""} for row in rows]
    folder = write_study_folder(tmp_path, made, rows)
    (folder / "ida.png").write_bytes(b"of an earlier call")
    found = write_study(folder)
    written = {path.name for path in folder.iterdir()}
    assert there <= written
    assert not missing & written
    kept = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert set(kept["files"]) <= written
    assert (kept["lines"], kept["warnings"], kept["verdict"]) == (found.lines, found.warnings, found.verdict.as_dict())
    assert kept["files"] == [*(path.name for path in found.files), "study.html"]


def test_ida_and_cloud_find_the_truth_too(tmp_path: Path):
    ida = Made(design="ida", records=40, levels=tuple(0.25 * np.arange(1, 41)))
    write_study(write_study_folder(tmp_path / "ida", ida, [row | {"material.friction": "0.6"} for row in rows_of(ida)]))
    cloud = write_study_folder(tmp_path / "cloud", Made(design="cloud", records=60))
    write_study(cloud)
    found = {(row["limit_state"], row["method"]): row for name in ("ida", "cloud") for row in table(tmp_path / name / "fragility.csv")}
    assert set(found) == {("cracked", "ida"), ("collapse", "ida"), ("cracked", "probit"), ("collapse", "probit"), ("cracked", "cloud")}
    for (limit, _), row in found.items():
        assert abs(np.log(float(row["theta"]) / (1.5 if limit == "cracked" else 3.0))) < 0.25
    assert found["collapse", "ida"]["runs"] == "40"


@pytest.mark.parametrize(
    ("theta", "words"),
    [
        (1e3, "none of 60 runs exceeded it, up to PGA 5 m/s²: no fragility; go higher"),
        (1e-3, "all 60 runs exceeded it, from PGA 1 m/s² on"),
    ],
)
def test_no_collapse_and_all_collapse_are_warned_of(theta: float, words: str, tmp_path: Path):
    folder = write_study_folder(tmp_path, Made(theta=theta))
    found = write_study(folder)
    assert any(line.startswith("collapse (mle)") and words in line for line in found.warnings)
    assert [row["theta"] for row in table(folder / "fragility.csv")] == ["", ""]
    assert not (folder / "fragility.xml").exists()


def test_few_records_are_warned_of_and_runs_that_failed_are_no_data(tmp_path: Path):
    rows = rows_of(Made(records=5))
    rows[0] |= {"status": "failed", "reason": "no solution", "max_opening": "", "collapsed_blocks": ""}
    rows[1] |= {"status": "timeout", "reason": "600 s", "max_opening": "", "collapsed_blocks": ""}
    found = write_study(write_study_folder(tmp_path, Made(records=5), rows))
    counts = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["runs"]
    assert counts == {"planned": 25, "rows": 25, "done": 23, "failed": 1, "timeout": 1}
    assert any("2 of 25 runs failed or timed out" in line for line in found.warnings)
    assert any("5 records, and 10 are wanted" in line for line in found.warnings)
    assert {row["runs"] for row in table(tmp_path / "fragility.csv")} == {"23"}


@pytest.mark.parametrize(
    ("records", "failed", "sure", "words"),
    [
        (12, 0, "good", "nothing in the runs speaks against what is fitted"),
        (5, 0, "look", "5 records, and 10 are wanted"),
        (12, 9, "doubtful", "9 of 60 runs failed or timed out"),
        (1, 5, "unknown", "no verdict: no run has finished"),
    ],
)
def test_the_verdict_says_what_the_runs_bear_out(records: int, failed: int, sure: str, words: str, tmp_path: Path):
    """One run in ten may be lost: fifteen in a hundred leave fits that are biased."""
    rows = [row | ({"status": "failed"} if k < failed else {}) for k, row in enumerate(rows_of(Made(records=records)))]
    found = findings_in(write_study_folder(tmp_path, Made(records=records, limit_states={}), rows)).verdict
    assert found.sure == sure and words in f"{found.words}; {found.why}"


def test_the_verdict_stands_first_on_the_page_and_in_the_summary(stripes: Path):
    found = json.loads((stripes / "summary.json").read_text(encoding="utf-8"))
    page = (stripes / "study.html").read_text(encoding="utf-8")
    assert list(found)[1] == "verdict"
    assert page.index("</h1>") < page.index(f'<span class="verdict {found["verdict"]["sure"]}">') < page.index('<p class="lead">')


def test_records_whose_names_differ_by_an_apostrophe_stay_two(tmp_path: Path):
    names = {"tis": "'tis", "x": "''=x"}  # the second is guarded in the file
    rows = [rows_of(Made(records=3))[0] | {"motion": name} for pair in names.items() for name in pair]
    assert read_study(write_study_folder(tmp_path, Made(), rows)).motions == ("tis", "'tis", "x", "'=x")


def test_grades_are_limit_states_by_their_number(tmp_path: Path):
    made = Made(limit_states={"heavy": {"quantity": "grade", "at_least": "D3"}, "collapse": COLLAPSE})
    write_study(write_study_folder(tmp_path, made))
    rows = table(tmp_path / "fragility.csv")
    assert rows[0]["theta"] == rows[1]["theta"]
    assert rows[0]["exceeded"] == rows[1]["exceeded"]


def test_a_measure_that_the_levels_are_not_of_is_fitted_run_by_run(tmp_path: Path):
    write_study(write_study_folder(tmp_path, Made(records=20, measure="PGV")))
    assert {row["method"] for row in table(tmp_path / "fragility.csv")} == {"probit", "cloud"}
    root = ElementTree.parse(tmp_path / "fragility.xml").getroot()
    imls = root.find(f".//{SPACE}imls")
    assert imls is not None
    assert imls.get("imt") == "PGV"
    assert float(imls.get("maxIML", "nan")) > 10.0  # cm/s


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": 2}, "study.json: format: "),
        ({"title": None}, "study.json: title: "),
        ({"measure": "PGD"}, 'study.json: measure: runs.csv has no column "PGD"'),
        ({"varied": ["material.density"]}, "runs.csv, line 1: not the columns of this study"),
        ({"seed": -1}, "study.json: seed: "),
        ({"limit_states": {"x": {"quantity": "tower.drift", "above": 1}}}, "study.json: limit_states.x.quantity: runs.csv has no column"),
        ({"limit_states": {"x": {"quantity": "max_openin", "above": 1}}}, "study.json: limit_states.x: quantity: "),
        ({"limit_states": {"x": {"quantity": "drift"}}}, "study.json: limit_states.x: above: missing"),
        ({"limit_states": {"x": {"quantity": "grade", "at_least": "D9"}}}, "study.json: limit_states.x: at_least: "),
    ],
)
def test_what_is_broken_is_named_in_a_line(change: dict[str, object], words: str, tmp_path: Path):
    folder = write_study_folder(tmp_path, Made(records=2))
    asked = json.loads((folder / "study.json").read_text(encoding="utf-8")) | change
    (folder / "study.json").write_text(json.dumps(asked), encoding="utf-8")
    with pytest.raises(InputError, match=words) as caught:
        read_study(folder)
    assert "\n" not in str(caught.value)


def test_a_table_that_is_cut_and_a_folder_that_is_none(tmp_path: Path):
    with pytest.raises(InputError, match=r"no study: it has no study\.json"):
        write_study(tmp_path)
    folder = write_study_folder(tmp_path, Made(records=2))
    text = (folder / "runs.csv").read_text(encoding="utf-8")
    (folder / "runs.csv").write_text(text[: len(text) - 120], encoding="utf-8")
    with refused_at("runs.csv, line 11"):
        write_study(folder)


def test_joints_of_another_number_are_refused_and_of_another_shape_left_out(tmp_path: Path):
    folder = write_study_folder(tmp_path, Made(records=3), joints=True)
    files = sorted((folder / "joints").iterdir())
    three = np.full(3, 0.01, dtype=np.float32)
    np.savez(files[1], opening=three, sliding=three, lost=three > 1, shape=8)
    found = write_study(folder)
    assert any("1 runs are left out because their joints differ from those of the first run" in line for line in found.warnings)
    assert {row["runs"] for row in table(folder / "joint_probabilities.csv")} == {"14"}
    np.savez(files[1], opening=three[:2], sliding=three[:2], lost=three[:2] > 1, shape=7)
    with refused_at("joints/00000001.npz"):
        write_study(folder)
    files[1].write_bytes(b"nothing")
    with pytest.raises(InputError, match="cannot be read"):
        write_study(folder)


def test_the_page_asks_for_nothing_and_links_the_runs_that_are_kept(tmp_path: Path):
    made = Made(records=4, more={"title": "An <arch> & its records"})
    folder = write_study_folder(tmp_path, made)
    (folder / "runs" / "00000003").mkdir(parents=True)
    (folder / "runs" / "00000003" / "report.html").write_text("a page", encoding="utf-8")
    write_study(folder)
    page = (folder / "study.html").read_text(encoding="utf-8")
    assert "An &lt;arch&gt; &amp; its records" in page
    assert re.search(r'<dl class="block"><div><dt>Scene</dt><dd>[^<]+</dd></div><div><dt>Program</dt><dd>masonry_cd', page)
    assert re.search(r"<dt>Varied</dt><dd>4 records", page)
    assert re.findall(r'href="([^"]*)"', page) == ["data:,", "runs/00000003/report.html"]
    assert not re.search(r'(src|href)="(?!data:|runs/)', page)
    assert "http://" not in page and "https://" not in page


def test_the_page_sorts_its_runs_and_fits_a_phone(stripes: Path, tmp_path: Path):
    if browser.missing():
        pytest.skip(browser.missing())
    with browser.browser(tmp_path) as window:
        window.open(stripes / "study.html")
        window.run("document.documentElement.style.width = '390px'")  # narrower than a window without a display can be
        assert window.run("return document.body.clientWidth") == 390
        assert window.run("return document.body.scrollWidth") == 390
        for down in (False, True):
            window.run("document.querySelector('.sortable thead th:nth-child(6) button').click()")
            cells = window.run("return [...document.querySelectorAll('.sortable tbody tr')].map((row) => Number(row.cells[5].textContent))")
            assert cells == sorted(cells, reverse=down)
        assert window.complaints() == []
