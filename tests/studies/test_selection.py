# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets of records: the best set is found, bits repeat, files do not depend on their order, and a study takes what is chosen."""

from __future__ import annotations

import csv
import json
import math
import shutil
import tomllib
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import records
import studied
from command_line import done, masonry_cd
from places import SHARED

import masonry_cd as mc
from loads.signal.baseline import integrate
from loads.signal.measures import parse, spectrum
from loads.signal.spectral_correlation import correlation
from masonry_cd.analysis.accelerogram_rule import judge
from masonry_cd.analysis.record_sets import Pool, choose, drawn, simulated
from masonry_cd.foundation import libm
from masonry_cd.studies.study.study_case import plan_of

PERIODS = libm.geometric(0.1, 1.0, 30)
SELECT = """\
n = 4
seed = 3
[records]
folder = "suite"
pattern = '(?P<motion>.+)_(?P<component>[^_]+)\\.acc'
x = ["NS"]
y = ["EW"]
units = "m/s2"
dt = 0.01
[target]
spectrum = "EC8"
ag = 2.0
ground = "B"
periods = [0.1, 1.0]
of = "geometric_mean"
[candidates]
factor = [0.3, 5.0]
"""
SUITE = SHARED / "records" / "suite"


def pool(k: int, sigma: float | None = None, limits: tuple[float, float] = (0.0, 0.0), seed: int = 0, per_event: int = 1) -> Pool:
    """Spectra at random, two of each event where two of one may be members."""
    differences = 0.5 * np.cumsum(np.random.default_rng(seed).standard_normal((k, len(PERIODS))), axis=1) / math.sqrt(len(PERIODS))
    return Pool(PERIODS, differences, None if sigma is None else np.full(len(PERIODS), sigma), limits, np.arange(k) // per_event, per_event)


@pytest.fixture
def asked(tmp_path: Path) -> Path:
    """A selection file with its suite."""
    records.write_suite(tmp_path / "suite")
    (tmp_path / "select.toml").write_text(SELECT)
    return tmp_path / "select.toml"


def chosen(path: Path, **changes: str) -> dict[str, Any]:
    """The set chosen by a file some of whose lines are replaced."""
    path.write_text(studied.changed(SELECT, changes), encoding="utf-8")
    return mc.select_records(path)


# --- the search -----------------------------------------------------------------------------------------------------------------------


def test_the_correlation_is_that_of_the_paper() -> None:
    rho = correlation(np.array([0.01, 0.1, 0.15, 0.5, 1.0, 10.0]))
    assert np.allclose(np.diag(rho), 1.0)
    assert np.array_equal(rho, rho.T)
    assert rho[3, 4] == pytest.approx(math.sin(math.pi / 2) - (math.cos(math.pi / 2 - 0.366 * math.log(2.0))))  # C1
    assert rho[0, 1] == pytest.approx(1.0 - 0.105 * (1.0 - 1.0 / (1.0 + math.exp(5.0))) * 0.09 / 0.0901)  # C2
    assert np.all(np.diff(rho[3, 3:]) < 0.0)
    assert np.linalg.eigvalsh(correlation(PERIODS)).min() > -1e-12


def test_simulated_spectra_have_the_distribution() -> None:
    spectra = simulated(pool(2, sigma=0.5), 4000, np.random.default_rng(1))
    assert np.abs(spectra.mean(axis=0)).max() < 0.01
    assert np.abs(spectra.std(axis=0) - 0.5).max() < 0.02
    assert np.abs(np.corrcoef(spectra.T) - correlation(PERIODS)).max() < 0.05


@pytest.mark.parametrize("sigma", [None, 0.0, 0.3])
def test_the_best_of_all_sets_is_found(sigma: float | None) -> None:
    asked = pool(12, sigma)
    d = np.array([asked.differences[list(members)] for members in combinations(range(12), 4)])
    least = asked.misfit(d.sum(axis=1), (d**2).sum(axis=1), 4).min()
    assert choose(asked, 4, 1).misfit == pytest.approx(least, rel=1e-12)


def test_spectra_that_cancel_are_found_among_others_with_their_factors() -> None:
    asked = pool(40, limits=(-2.0, 2.0), seed=5)
    shape = 0.1 * np.sin(np.arange(30))
    asked.differences[[7, 11, 30]] = np.array([shape, -2.0 * shape, shape]) + np.array([[0.5], [-1.0], [1.5]])
    found = choose(asked, 3, 1)
    assert sorted(found.members) == [7, 11, 30]
    assert found.factors[np.argsort(found.members)] == pytest.approx([-0.5 - shape.mean(), 1.0 + 2.0 * shape.mean(), -1.5 - shape.mean()])
    assert found.misfit < 1e-20


@pytest.mark.parametrize("sigma", [None, 0.4])
def test_it_beats_a_thousand_sets_at_random_and_repeats_to_the_bit(sigma: float | None) -> None:
    asked = pool(24, sigma, (-1.0, 1.0), 2)
    found, again, random = choose(asked, 7, 4), choose(asked, 7, 4), np.random.default_rng(0)
    assert found.misfit < 0.5 * min(drawn(asked, 7, random).misfit for _ in range(1000))
    assert np.array_equal(found.members, again.members)
    assert np.array_equal(found.factors, again.factors)
    assert np.all(np.abs(found.factors) <= 1.0)


def test_an_event_gives_no_more_records_than_allowed() -> None:
    asked = pool(20, per_event=2)
    found = choose(Pool(asked.periods, asked.differences, None, (0.0, 0.0), np.arange(20) // 5, 2), 8, 0)
    assert np.bincount(found.members // 5).tolist() == [2, 2, 2, 2]


# --- the rule -------------------------------------------------------------------------------------------------------------------------


def test_the_rule_takes_arithmetic_means_and_its_lift_just_meets_it() -> None:
    target = np.array([1.0, 2.0, 4.0])
    spectra = np.array([[0.5, 2.0, 2.0], [1.0, 2.0, 3.0], [0.6, 2.6, 4.0]])
    rule = judge(np.array([0.0, 0.1, 0.5]), spectra, target)
    assert (rule.least, rule.at, rule.rigid) == pytest.approx((0.75, 0.5, 0.7))
    assert rule.holds == (True, False, False)
    assert rule.lift == pytest.approx(1.0 / 0.7)
    assert judge(np.array([0.0, 0.1, 0.5]), rule.lift * spectra, target).holds == (True, True, True)
    assert judge(np.array([0.0, 0.1, 0.5]), 2.0 * spectra[:2], target).holds == (False, True, True)


# --- from files to a study ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", ["x", "geometric_mean", "rotd50"])
def test_a_spectrum_is_the_measure_period_by_period(rule: str) -> None:
    motion = {axis: integrate(records.suite_motion(k), 0.01) for k, axis in enumerate("xy")}
    found = spectrum(motion, rule, np.array([0.0, 0.2, 1.0]))
    assert found.tolist() == [parse(f"Sa({period:g})", rule=rule).value(motion) for period in (0.0, 0.2, 1.0)]


def test_a_set_is_written_and_a_study_runs_on_it(asked: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(asked.parent)
    done("select", "select.toml", "-o", "out/set")
    found = json.loads(Path("out/set/selection.json").read_text(encoding="utf-8"))
    factors = {row["motion"]: row["factor"] for row in found["motions"]}
    written = tomllib.loads(Path("out/set/selected.toml").read_text(encoding="utf-8"))["records"]
    assert {name: float(f"{factor:.12g}") for name, factor in written["factors"].items()} == factors
    with Path("out/set/selection.csv").open(encoding="utf-8", newline="") as file:
        assert [row["motion"] for row in csv.DictReader(file)] == sorted(factors)
    studied.write_study(asked.parent, 'scene = "scene.toml"\ndesign = "cloud"\nrecords = "out/set/selected.toml"\n[limit_states]\n'
                        'slid = {quantity = "max_sliding", above = 1e-3}\n')  # fmt: skip
    plan = plan_of(asked.parent / "study.toml")
    for run in plan.runs:
        loads = [load for load in plan.maker.tables(run.asked)["loads"] if load["kind"] == "record"]
        assert [load["scale"] for load in loads] == [written["factors"][run.asked.motion]] * 2
        assert {Path(load["path"]).parent for load in loads} == {asked.parent / "suite"}
    with studied.undrawn():
        result = masonry_cd("study", "study.toml", "-o", "out/study", "--scheduler", scheduler)
    assert "4 of 4 runs done" in result.stdout, result.output
    with Path("out/study/runs.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["motion"]: row for row in csv.DictReader(file)}
    assert rows.keys() == factors.keys()
    for name, row in rows.items():
        peak = np.abs(records.suite_motion(2 * int(name[1:]))).max()  # along x, before the baseline is corrected
        assert float(row["PGA"]) == pytest.approx(factors[name] * peak, rel=0.03)


def test_python_gets_the_set_and_the_table_for_a_study(asked: Path) -> None:
    found = chosen(asked)
    assert found["records"]["factors"] == {row["motion"]: row["factor"] for row in found["motions"]}
    first_four = chosen(asked, dt='dt = 0.01\nexclude = ["m0[4-9]", "m1*"]')
    assert found["fit"]["mean_rms"] < 0.8 * first_four["fit"]["mean_rms"]
    t, s = np.array(found["spectra"]["period_s"]), np.array(found["spectra"]["median_m_s2"]) / found["spectra"]["target_m_s2"]
    band = (t >= 0.1) & (t <= 1.0)
    assert np.abs(np.log(s[band])).max() == pytest.approx(abs(found["fit"]["mean_largest"]), abs=0.03)
    assert sorted(path.name for path in asked.parent.iterdir()) == ["select.toml", "suite"]


def test_the_order_of_the_files_does_not_matter(asked: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, listed = chosen(asked), Path.iterdir
    monkeypatch.setattr(Path, "iterdir", lambda self: sorted(listed(self), reverse=True))
    assert chosen(asked) == found


def test_the_set_is_scaled_up_to_meet_the_rule(asked: Path) -> None:
    before = chosen(asked, factor="factor = [0.2, 0.5]")
    assert not before["en_1998_1"]["holds"]
    with pytest.warns(mc.RunWarning, match="raised by"):
        after = chosen(asked, n="n = 4\nmeet_rule = true", factor="factor = [0.2, 0.5]")
    assert after["en_1998_1"]["holds"]
    ratios = [row["factor"] / old["factor"] for row, old in zip(after["motions"], before["motions"], strict=True)]
    assert ratios == pytest.approx([after["lift"]] * 4)
    assert min(after["en_1998_1"]["least"] / 0.9, after["en_1998_1"]["rigid"]) == pytest.approx(1.0)


def test_what_cannot_be_used_is_left_out_and_said(asked: Path) -> None:
    suite = asked.parent / "suite"
    (suite / "m00_NS.acc").write_text("1.0\nx\n")
    (suite / "m01_EW.acc").unlink()
    for component in ("NS", "EW"):
        (suite / f"m02_{component}.acc").write_text("".join(f"{a:.6f}\n" for a in records.suite_motion(4, duration=0.9)))
    left = chosen(asked, factor='factor = [0.3, 5.0]\ncatalogue = "suite/records.csv"\nmagnitude = [5.5, 6.4]\nper_event = 1')["left_out"]
    assert sorted(left) == ["m00", "m01", "m02", "m10", "m11"]
    assert "m00_NS.acc" in left["m00"]
    assert "components NS" in left["m01"]
    assert "longest period" in left["m02"]
    assert "magnitude 6.5" in left["m10"]


def test_sigma_at_periods_is_straight_over_their_logarithm(asked: Path) -> None:
    flat, given = (chosen(asked, of=f'of = "x"\nsigma = {sigma}') for sigma in ("0.4", "[[0.1, 0.4], [0.3, 0.4], [1.0, 0.4]]"))
    assert flat["motions"] == given["motions"]
    assert flat["fit"]["sigma_rms"] < 0.15


@pytest.mark.slow(reason="reads the 80 files of the suite, some 10 s")
@pytest.mark.skipif(not SUITE.is_dir(), reason="needs the suite of 40 motions, which the project does not bring")
def test_forty_motions_match_a_code_and_a_scatter(tmp_path: Path) -> None:
    suite = tmp_path / "suite"
    suite.mkdir()
    for path in SUITE.glob("*.acc"):
        if not path.stem.endswith("UD"):
            shutil.copy(path, suite)
    lines = {
        "x = ": 'x = ["NS", "H1", "Lo"]',
        "y = ": 'y = ["EW", "WE", "H2", "Tr"]',
        "dt": "dt = 0.005",
        "ag": "ag = 2.5",
        "n =": "n = 15",
    }
    found = chosen(tmp_path / "select.toml", **lines, of='of = "geometric_mean"\nsigma = 0.4')
    assert found["candidates"] == 40
    assert found["fit"]["mean_rms"] < 0.05
    assert found["fit"]["sigma_rms"] < 0.05
