# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/fragility/rates.py: fragilities of a made study over a hazard of one power law, whose frequencies have a closed form."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from made_study import Made, write_study_folder
from studied import undrawn

import masonry_cd as mc
from masonry_cd.analysis.fragility.bootstrap import band
from masonry_cd.analysis.fragility.findings import findings_in
from reports.study.outputs import write_study

K0, K = 5e-4, 2.2
INTENSITY = np.exp(np.linspace(-10.0, 10.0, 41))
HAZARD = {"measure": "PGA", "intensity": INTENSITY.tolist(), "frequency": (K0 * INTENSITY**-K).tolist(), "notes": []}
LOSSES = {"cracked": 0.1, "collapse": 0.8}
SPACE = "{http://openquake.org/xmlns/nrml/0.5}"


def closed(theta: np.ndarray, beta: np.ndarray) -> np.ndarray:
    return K0 * theta**-K * np.exp(0.5 * (K * beta) ** 2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study over the hazard, written once, without pictures."""
    more = {"hazard": HAZARD, "loss_ratios": LOSSES}
    made = write_study_folder(tmp_path_factory.mktemp("study"), Made(records=20, by_friction=0.2, more=more))
    with undrawn():
        write_study(made)
    return made


def test_a_rate_and_its_band_are_the_closed_form_of_the_fit_and_of_its_replicates(folder: Path):
    found = findings_in(folder)
    assert [rate.limit for rate in found.rates] == ["cracked", "collapse"]
    for fit, rate in zip(found.first_fits, found.rates, strict=True):
        assert rate.most == pytest.approx(float(closed(fit.theta, fit.beta)), rel=1e-9) == pytest.approx(rate.least, rel=1e-9)
        fitted = np.where(np.isfinite(fit.replicated.beta), closed(fit.replicated.theta, np.nan_to_num(fit.replicated.beta)), np.nan)
        assert rate.band == pytest.approx(band(fitted), rel=1e-6) and not rate.is_bounded
        assert rate.row()["probability_50_years"] == pytest.approx(1.0 - np.exp(-50.0 * rate.most))
    light, heavy = (rate.most for rate in found.rates)
    assert found.annual_loss == pytest.approx(0.1 * light + 0.7 * heavy)


def test_files_and_python_have_them(folder: Path):
    facts = json.loads((folder / "fragility.json").read_text(encoding="utf-8"))
    rates = findings_in(folder).rates
    assert [one["frequency"] for one in facts["frequencies"]] == pytest.approx([rate.most for rate in rates], rel=1e-5)
    assert facts["hazard"]["measure"] == "PGA" and json.loads((folder / "summary.json").read_text())["annual_loss"] > 0.0
    table = mc.open_study(folder).frequencies
    assert table.loc["collapse", "frequency"] == pytest.approx(rates[1].most)
    assert "Annual frequencies" in (folder / "study.html").read_text(encoding="utf-8")


def test_losses_at_an_intensity_are_shares_of_runs_that_add_up_to_one(folder: Path):
    function = ElementTree.parse(folder / "vulnerability.xml").getroot().find(f"{SPACE}vulnerabilityModel/{SPACE}vulnerabilityFunction")
    assert function is not None and function.get("dist") == "PM"
    rows = {float(one.get("lr", "nan")): np.array(one.text.split(), dtype=float) for one in function.iter(f"{SPACE}probabilities")}
    levels = 9.80665 * np.array(function.findtext(f"{SPACE}imls").split(), dtype=float)
    assert list(rows) == [0.0, 0.1, 0.8] and sum(rows.values()) == pytest.approx(1.0, abs=1e-5)
    collapse = findings_in(folder).first_fits[1]
    assert rows[0.8] == pytest.approx(collapse.curve.probability(levels)[0], abs=1e-4)


def test_where_the_rows_end_within_what_contributes_both_bounds_are_said(tmp_path: Path):
    rows = slice(18, 22)
    short = HAZARD | {key: HAZARD[key][rows] for key in ("intensity", "frequency")}
    found = findings_in(write_study_folder(tmp_path / "a", Made(records=20, by_friction=0.2, more={"hazard": short})))
    exact = [float(closed(fit.theta, fit.beta)) for fit in found.first_fits]
    assert len(exact) == 2
    for rate, truth in zip(found.rates, exact, strict=True):
        assert rate.least < truth < rate.most and rate.is_bounded and "at least" in rate.line


def test_a_hazard_of_another_measure_is_said_and_gives_no_rates(tmp_path: Path):
    found = findings_in(
        write_study_folder(tmp_path / "a", Made(records=20, by_friction=0.2, more={"hazard": HAZARD | {"measure": "Sa(0.5)"}}))
    )
    assert not found.rates and any("the hazard is of Sa(0.5)" in line for line in found.warnings)
