# SPDX-License-Identifier: GPL-3.0-or-later
"""Calibrations from end to end: modal ones against a posterior in closed form, those of runs, their posterior as a distribution."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, masonry_cd
from studied import RECORDS, write_records, write_scene, write_study

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.studies.calibrate.plan import Calibration
from masonry_cd.studies.study.study_case import plan_of
from masonry_cd.studies.study.study_file import read_study

PIER = """\
title = "Pier"
design = "calibrate"
samples = 40
seed = 1
[calibration]
wanted = 30.0
[scene.structure]
kind = "column"
height = 3.0
diameter = 0.6
drums = 4
[scene.material]
masonry = "squared stone"
friction = 0.6
[scene.run]
dt = 1e-3
duration = 1e-3
[vary]
"material.masonry.E" = { distribution = "uniform" }
"material.friction" = { distribution = "uniform", low = 0.4, high = 0.8 }
[[observations]]
what = "frequency"
direction = "x"
value = VALUE
share = 0.02
[[observations]]
what = "frequency"
mode = 3
share = 0.02
"""
RUN = """\
scene = "scene.toml"
design = "calibrate"
samples = 6
seed = 2
[calibration]
rounds = 1
least = 2.0
[vary]
"material.friction" = { distribution = "uniform", low = 0.2, high = 0.4 }
"""


def first_frequency(folder: Path) -> float:
    """First frequency of the pier at the mean modulus of its kind, 2.85 GPa [Hz]."""
    scene = PIER[PIER.index("[scene.structure]") : PIER.index("[vary]")].replace("[scene.", "[")
    (folder / "pier.toml").write_text(scene)
    done("modal", folder / "pier.toml", "-o", folder / "modal", "--method", "joints", "--pictures", "0")
    found = json.loads((folder / "modal" / "modal.json").read_text())["models"]["joints"]
    return float(found["frequency_hz"][int(np.argmax(found["participation"]["x"]))])


def calibrated(folder: Path, text: str, scheduler: str, out: str = "out", code: int = 0) -> Path:
    (folder / "cal.toml").write_text(text)
    result = masonry_cd("calibrate", folder / "cal.toml", "-o", folder / out, "--scheduler", scheduler, "--quiet")
    assert result.exit_code == code, result.output
    return folder / out


@pytest.fixture(scope="module")
def pier(scheduler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pier")
    return calibrated(folder, PIER.replace("VALUE", repr(first_frequency(folder))), scheduler)


def test_one_frequency_fixes_the_modulus_and_says_nothing_of_friction(pier: Path) -> None:
    """All moduli go with E, and frequencies with its root: of a uniform prior the posterior is exp(-(1 - sqrt(E / E0))^2 / (2 s^2))."""
    found = json.loads((pier / "calibrate.json").read_text())
    modulus = np.linspace(2.4e9, 3.3e9, 10001)
    density = np.exp(-0.5 * ((1.0 - np.sqrt(modulus / 2.85e9)) / 0.02) ** 2)
    mean = np.sum(modulus * density) / density.sum()
    std = np.sqrt(np.sum((modulus - mean) ** 2 * density) / density.sum())
    one, other = found["unknowns"]["material.masonry.E"], found["unknowns"]["material.friction"]
    size = found["effective"][-1]
    assert size >= 30.0
    assert one["mean"] == pytest.approx(mean, abs=4.0 * std / size**0.5)
    assert one["std"] == pytest.approx(std, rel=0.3)
    assert other["std"] == pytest.approx(0.4 / 12**0.5, rel=0.2)
    assert found["verdict"]["sure"] == "good"
    assert found["unlearnt"] == ["material.friction"]
    known, predicted = found["observations"]
    assert predicted["median"] / predicted["prior_median"] == pytest.approx(known["median"] / known["prior_median"], rel=5e-3)
    assert "calibrate.png" in {path.name for path in pier.iterdir()}


def test_the_same_command_makes_no_sample_again_and_the_bits_do_not_depend_on_it(pier: Path, scheduler: str) -> None:
    folder, rows = pier.parent, {path: path.stat().st_mtime_ns for path in (pier / "rows").glob("*.json")}
    before = {name: (pier / name).read_bytes() for name in ("samples.csv", "calibrate.json", "calibrate.html")}
    text = (folder / "cal.toml").read_text()
    calibrated(folder, text, scheduler)
    assert {path: path.stat().st_mtime_ns for path in (pier / "rows").glob("*.json")} == rows
    next(iter(rows)).unlink()
    calibrated(folder, text, scheduler)
    assert {name: (pier / name).read_bytes() for name in before} == before
    (folder / "other.toml").write_text(text.replace("mode = 3", "mode = 4"))
    assert masonry_cd("calibrate", folder / "other.toml", "-o", folder / "out").exit_code == 2  # the folder of other observations


def test_a_study_draws_the_posterior_by_its_weights(pier: Path, tmp_path: Path) -> None:
    from pyarrow import parquet

    table = parquet.read_table(pier / "posterior.parquet").to_pydict()
    w = np.array(table.pop("weight"))
    assert w.sum() == pytest.approx(1.0)
    scene = PIER[PIER.index("[scene.structure]") : PIER.index("[vary]")]
    (tmp_path / "study.toml").write_text(f'design = "sample"\nsamples = 400\n{scene}[vary]\nfrom = "{pier / "posterior.parquet"}"\n')
    drawn = [run.asked.values for run in plan_of(tmp_path / "study.toml").runs]
    rows = set(zip(*table.values(), strict=True))
    assert {tuple(values[key] for key in table) for values in drawn} <= rows  # all keys of a row together
    modulus = np.array(table["material.masonry.E"])
    mean = float(np.sum(w * modulus))
    std = float(np.sqrt(np.sum(w * (modulus - mean) ** 2)))
    assert np.mean([values["material.masonry.E"] for values in drawn]) == pytest.approx(mean, abs=0.1 * std)


def test_a_frequency_out_of_reach_is_no_answer_or_one_that_is_not_explained(pier: Path, scheduler: str) -> None:
    folder = pier.parent
    far = (folder / "cal.toml").read_text().replace("share = 0.02", "share = 0.001").replace("samples = 40", "samples = 8")
    text = far.replace("value = ", "value = 1").replace("wanted = 30.0", "rounds = 2")
    (folder / "far").mkdir()
    out = calibrated(folder / "far", text, scheduler, code=1)
    found = json.loads((out / "calibrate.json").read_text())
    assert found["verdict"]["words"] == "refused"
    assert not (out / "posterior.parquet").exists()
    assert not (out / "calibrate.png").exists()


def test_what_a_block_slid_tells_its_friction(scheduler: str, tmp_path: Path) -> None:
    """All kinds of observations of runs, as friction 0.3 has them; blocks of a plate that moves by one cycle."""
    write_scene(tmp_path)
    base = (tmp_path / "scene.toml").read_text() + '[output]\npoint = [{ block = "block", name = "top" }]\n'
    (tmp_path / "scene.toml").write_text(base)
    run_case(prepare(read_scene(tmp_path / "scene.toml", ["material.friction=0.3"])), tmp_path / "truth", pictures=False)
    rows = [line.split(",") for line in (tmp_path / "truth" / "points.csv").read_text().splitlines()]
    time, ux = rows[0].index("time"), rows[0].index("ux")
    (tmp_path / "ux.csv").write_text("time [s],ux [mm]\n" + "".join(f"{row[time]},{1e3 * float(row[ux]):.9g}\n" for row in rows[1:]))
    end, most = float(rows[-1][ux]), max(abs(float(row[ux])) for row in rows[1:])
    observations = (
        f'{{ what = "quantity", quantity = "max_sliding", spread = "lognormal", share = 0.3, value = {most!r} }}',
        f'{{ what = "gauge", gauge = "top", column = "ux", value = {end!r}, error = "{300 * abs(end):.4g} mm" }}',
        '{ what = "history", gauge = "top", column = "ux", file = "ux.csv", error = 0.4 }',
        '{ what = "open", joint = ["plate", "block"], value = false, error = 0.05 }',
        '{ what = "fallen", blocks = ["block"], value = false, error = 0.05 }',
    )
    text = RUN.replace("[calibration]", f"observations = [\n{','.join(observations)}\n]\n[calibration]")
    found = json.loads((calibrated(tmp_path, text, scheduler) / "calibrate.json").read_text())
    one = found["unknowns"]["material.friction"]
    assert one["low"] <= 0.3 <= one["high"]
    assert one["high"] - one["low"] < 0.7 * (one["prior_high"] - one["prior_low"])
    history = found["observations"][2]
    assert history["value"] == 0.0
    assert history["low"] < 0.3 < history["prior_high"]
    assert [one["median"] for one in found["observations"][3:]] == [0.0, 0.0]


def test_motions_and_levels_are_unknowns_as_keys_are(tmp_path: Path) -> None:
    write_records(tmp_path)
    text = RECORDS.replace('"stripes"', '"calibrate"\nsamples = 6').partition("[limit_states]")[0]
    text += '[[observations]]\nwhat = "quantity"\nquantity = "max_sliding"\nshare = 0.2\n'
    write_study(tmp_path, text)
    found = Calibration.of(read_study(tmp_path / "study.toml"))
    assert len(found.places) == 2
    u = np.array([(a, b) for a in (0.1, 0.5, 0.9) for b in (0.1, 0.5, 0.9)])
    asked = [found.asked(one) for one in u]
    values, measured = found.unknowns(asked), found.measured(asked)
    assert set(values) == {"motion", "level"}
    assert found.motion == ("period", "PGA")
    assert measured["PGA"] == values["level"]
    assert measured["period"][0] == measured["period"][1] > 0.0  # whatever the level
    assert len(set(zip(values["motion"], values["level"], strict=True))) == 9
    assert "2 unknowns, 0 observations, 1 more predicted" in found.line
