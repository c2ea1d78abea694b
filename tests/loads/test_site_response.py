# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.site_response: closed form of a layer on rock, soil that softens against another program, and the lines on a record."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loads
from loads.signal.baseline import integrate
from loads.signal.site_response import SiteTable, surface_motion
from masonry_cd.foundation.errors import InputError

ROCK = {"shear_velocity": 760.0, "density": 2300.0, "damping": 0.01}
SOILS = [
    {"thickness": 5.0, "shear_velocity": 180.0, "density": 1800.0, "plasticity_index": 15.0},
    {"thickness": 10.0, "shear_velocity": 240.0, "density": 1900.0, "plasticity_index": 30.0},
    {"thickness": 15.0, "shear_velocity": 320.0, "density": 2000.0, "plasticity_index": 0.0},
]
STEP = 0.01
TIME = STEP * np.arange(2001)
WAVE = 0.8 * np.sin(np.pi * TIME / 20.0) ** 2 * (np.sin(2 * np.pi * 1.3 * TIME) + 0.6 * np.sin(2 * np.pi * 3.1 * TIME + 0.4))  # [m/s2]


def site(*layers: dict[str, float], **keys: Any) -> SiteTable:
    return SiteTable.model_validate({"layers": layers, "bedrock": ROCK, **keys})


@pytest.mark.parametrize("damping", [0.005, 0.02, 0.1])
def test_a_damped_layer_on_elastic_rock_amplifies_as_in_closed_form(damping: float) -> None:
    # Kramer, Geotechnical Earthquake Engineering, 1996, section 7.2.1.4: 1 / (cos k H + i alpha sin k H), alpha the ratio of impedances
    high, velocity, density = 20.0, 200.0, 1900.0
    rock = np.zeros(8192)
    rock[4000:4002] = 1.0, -0.4
    own = {"thickness": high, "shear_velocity": velocity, "density": density, "damping": damping}
    made = surface_motion(site(own), integrate(rock, 0.005), 0, "loads[0]")
    frequency = np.fft.rfftfreq(len(rock), 0.005)
    used = (frequency > 0.1) & (frequency < 25.0)
    gain = (np.fft.rfft(made.history.acceleration) / np.fft.rfft(rock))[used]
    soil, below = (v * np.sqrt(np.sqrt(1.0 - 4.0 * d**2) + 2j * d) for v, d in ((velocity, damping), (760.0, 0.01)))
    kh, alpha = 2.0 * np.pi * frequency[used] * high / soil, density * soil / (2300.0 * below)
    closed = 1.0 / (np.cos(kh) + 1j * alpha * np.sin(kh))
    assert abs(gain / closed - 1.0).max() < 1e-3
    assert made.facts["frequency"] == pytest.approx(frequency[used][abs(closed).argmax()], rel=0.02)
    assert made.facts["gain"] == pytest.approx(abs(closed).max(), rel=1e-3)


def test_soil_that_softens_comes_out_as_in_another_program() -> None:
    # pyStrata 0.5.4: curves of Darendeli, strain ratio 0.65, the same parts and complex modulus, until nothing changes by 0.01 %
    made = surface_motion(site(*SOILS), integrate(WAVE, STEP), 0, "loads[0]")
    assert made.facts["converged"]
    assert not made.warnings
    assert abs(made.history.acceleration).max() == pytest.approx(2.064695, rel=1e-3)
    theirs = {"strain": [4.88665e-4, 6.42165e-4, 5.70178e-4], "modulus": [0.550794, 0.641193, 0.589264]}
    theirs["damping"] = [0.0804326, 0.0617091, 0.0665407]
    for name, values in theirs.items():
        assert [layer[name] for layer in made.facts["layers"]] == pytest.approx(values, rel=5e-3)


def test_water_takes_stress_and_softens_and_stronger_shaking_softens_more() -> None:
    def softest(size: float, **keys: Any) -> float:
        layers = surface_motion(site(*SOILS, **keys), integrate(size * WAVE, STEP), 0, "loads[0]").facts["layers"]
        return float(min(layer["modulus"] for layer in layers))

    assert softest(1e-4) > 0.99
    assert softest(1.0) < softest(0.3) < softest(1e-4)
    assert softest(0.3, water_depth=0.0) < softest(0.3)


def scene(folder: Path, **keys: Any) -> loads.Loading:
    (folder / "quake.txt").write_text("".join(f"{t:.2f} {a:.12g}\n" for t, a in zip(TIME, WAVE, strict=True)))
    table = {"kind": "record", "path": "quake.txt", "units": "m/s2", "direction": "x", **keys}
    return loads.build([table], 5e-3, 4400, (0.0, 0.0, -9.81), folder)


def test_a_record_goes_through_the_site_at_its_size_and_says_so(tmp_path: Path) -> None:
    table = {"layers": SOILS, "bedrock": ROCK}
    rock, soft = scene(tmp_path, target_pga=1.0), scene(tmp_path, target_pga=1.0, site=table)
    found = soft.summary["tables"][0]
    assert found["site"]["rock_pga"] == pytest.approx(rock.summary["tables"][0]["after"]["pga"]) == pytest.approx(1.0)
    assert found["after"]["pga"] == pytest.approx(found["site"]["pga_ratio"])
    assert found["after"]["pga"] > 1.2
    assert abs(found["after"]["end_displacement"]) < 1e-10
    assert abs(np.diff(soft.support_velocity[:, 0, 0])).max() / 5e-3 == pytest.approx(found["after"]["pga"], rel=0.01)
    assert any("site: PGA 1 m/s2 on rock" in line and "times as much" in line for line in soft.lines)
    assert any("layers shear by up to 0.0" in line for line in soft.lines)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"layers": [*SOILS]}, r"site\.bedrock"),
        ({"layers": [], "bedrock": ROCK}, r"site\.layers"),
        ({"layers": [{**SOILS[0], "plasticity_index": None}], "bedrock": ROCK}, "give damping, or plasticity_index"),
        ({"layers": [{**SOILS[0], "density": 900.0}], "bedrock": ROCK, "water_depth": 0.0}, "the water bears all above it"),
        ({"layers": [{**SOILS[0], "shear_velocity": 60.0}], "bedrock": ROCK}, r"layers\[0\]: shears by [0-9.]+ %, beyond 1 %"),
    ],
)
def test_sites_that_are_none_and_soil_that_yields_are_refused_by_their_key(tmp_path: Path, table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        scene(tmp_path, target_pga=3.0, site=table)
    assert "loads[0].site" in str(caught.value)
