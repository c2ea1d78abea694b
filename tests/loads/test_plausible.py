# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions and sizes that are likely not meant are warned of, with the cause; sound ones are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from places import SHARED

import loads
from loads.signal import flaws

STEP = 0.01
TIME = STEP * np.arange(1001)
SWELL = np.sin(np.pi * TIME / 10.0) ** 2
WAVE = 2.0 * SWELL * np.sin(2 * np.pi * 1.3 * (TIME - 5.0)) * np.cos(np.pi * (TIME - 5.0) / 10.0)


def warnings(folder: Path, values: np.ndarray, unit: str = "m/s2", **keys: object) -> list[str]:
    rows = "".join(f"{t:.2f} {a:.12g}\n" for t, a in zip(TIME, values, strict=True))
    (folder / "quake.txt").write_text(f"# t [s]  a [{unit}]\n{rows}")
    table = {"kind": "record", "path": "quake.txt", "direction": "x", **keys}
    return list(loads.build([table], 1e-3, 12_000, (0.0, 0.0, -9.81), folder).warnings)


def test_a_record_that_swells_and_fades_is_let_pass(tmp_path: Path) -> None:
    assert warnings(tmp_path, WAVE) == []


def test_a_window_that_cuts_the_shaking_is_named_at_both_ends(tmp_path: Path) -> None:
    lines = warnings(tmp_path, WAVE, window=[2.5, 7.1], correction="none")
    assert [line.split(" while")[0] for line in lines] == ["loads[0] the record begins", "loads[0] the record ends"]
    assert "is the window too narrow, or the file cut?" in lines[0]


def test_a_correction_that_makes_the_motion_anew_says_what_it_changed(tmp_path: Path) -> None:
    ramp = 0.1 * (TIME / 5.0 - 1.0)
    (line,) = warnings(tmp_path, WAVE + ramp)
    assert line.startswith("loads[0] the quadratic correction changes ")
    assert "PGD from 1" in line
    assert "with or without the mean of the record: it drifts" in line
    assert warnings(tmp_path, WAVE + ramp, correction="none") == []


def test_the_offset_of_an_instrument_is_no_drift_and_no_shaking_at_the_ends(tmp_path: Path) -> None:
    assert warnings(tmp_path, WAVE + 0.5) == []


def test_an_offset_that_is_kept_is_named_with_the_peak_without_it(tmp_path: Path) -> None:
    (line,) = warnings(tmp_path, WAVE + 0.5, correction="none")
    peak = abs(WAVE - WAVE.mean()).max()
    assert 'correction "none" keeps a mean of 0.5' in line
    assert line.endswith(f"{peak:.4g} without it")
    assert warnings(tmp_path, WAVE + 0.5, correction="none", band=[0.2, 20.0]) == []  # the band-pass has taken it off


@pytest.mark.parametrize("shape", [np.sin, np.ones_like])
def test_a_pulse_that_ends_at_rest_has_no_offset_of_an_instrument(shape: Callable[[np.ndarray], np.ndarray], tmp_path: Path) -> None:
    pulse = np.where(TIME < 4.0, 1.5 * shape(np.pi * TIME / 4.0), 0.0)
    assert warnings(tmp_path, pulse, correction="none") == []


@pytest.mark.parametrize(("offset", "said"), [(0.0, False), (0.5, True)])
def test_peak_and_intensity_are_said_with_and_without_an_offset(tmp_path: Path, offset: float, said: bool) -> None:
    warnings(tmp_path, WAVE + offset)
    loading = loads.build([{"kind": "record", "path": "quake.txt", "direction": "x"}], 1e-3, 12_000, (0.0, 0.0, -9.81), tmp_path)
    assert any("with it" in line and "without it" in line for line in loading.lines) == said
    found = loading.summary["tables"][0]
    assert ("offset" in found) == said
    if said:
        assert found["offset"]["mean"] == pytest.approx(WAVE.mean() + offset)
        assert found["offset"]["pga"] == pytest.approx(abs(WAVE - WAVE.mean()).max())
        assert found["offset"]["arias"] < found["before"]["arias"]


def test_times_that_are_likely_milliseconds_are_asked_about(tmp_path: Path) -> None:
    values = np.sin(np.linspace(0.0, 9.0, 40))
    (tmp_path / "quake.txt").write_text("".join(f"{20 * k} {a:.12g}\n" for k, a in enumerate(values)))
    table = {"kind": "record", "path": "quake.txt", "direction": "x", "units": "m/s2"}
    with refused_at("loads[0].path"):
        loads.build([table], 1e-3, 1000, (0.0, 0.0, -9.81), tmp_path)
    (tmp_path / "quake.txt").write_text("".join(f"{2 * k} {a:.12g}\n" for k, a in enumerate(values)))
    found = loads.build([table], 1e-3, 1000, (0.0, 0.0, -9.81), tmp_path).warnings
    assert any("its samples are 2 s apart" in line and "are its times in seconds?" in line for line in found)


def spiked(*spikes: tuple[int, float]) -> np.ndarray:
    values = WAVE.copy()
    for k, size in spikes:
        values[k] = size
    return values


FLAWS = [
    (spiked((300, 5.0)), "a spike at 3 s sets its PGA of 5 m/s2, which is "),
    (spiked((300, -5.0)), "a spike at 3 s sets its PGA"),
    (spiked((300, 5.0), (301, 4.0)), "a spike at 3 s sets its PGA"),
    (spiked((500, -4.0), (300, 5.0)), "2 spikes at 3, 5 s set its PGA"),
    (np.clip(WAVE, -1.0, 1.0), " peaks of the record are cut off flat, at "),
    (np.clip(WAVE, -9.0, 1.0), " of the record "),
    (np.round(np.clip(WAVE, -1.0, 1.0), 2), " peaks of the record are cut off flat, at "),
    (np.where((TIME >= 4.8) & (TIME < 5.3), 0.0, WAVE), "a gap in the shaking, of up to 0.5 s of one value, at 4.8 s"),
    (np.where((TIME > 4.8) & (TIME < 5.1), WAVE[475], WAVE), "a gap in the shaking, of up to 0.29 s of one value, at 4.81 s"),
]


@pytest.mark.parametrize("keys", [{}, {"scale": 0.1}, {"target_pga": 3.0}])
@pytest.mark.parametrize(("values", "said"), FLAWS, ids=range(len(FLAWS)))
def test_spikes_clipped_peaks_and_gaps_are_named(tmp_path: Path, values: np.ndarray, said: str, keys: dict[str, float]) -> None:
    lines = [
        line for line in warnings(tmp_path, values, correction="none", **keys) if "while the ground" not in line and "mean of" not in line
    ]
    assert len(lines) == 1
    assert said.partition(" of 5 m/s2")[0] in lines[0] if keys else said in lines[0]


def test_a_flaw_outside_of_the_window_is_none(tmp_path: Path) -> None:
    assert not any("spike" in line for line in warnings(tmp_path, spiked((300, 5.0)), window=[3.2, 7.0]))


@pytest.mark.parametrize(
    "values",
    [
        np.round(WAVE, 1),  # a coarse digitiser
        np.round(np.sin(2.0 * np.pi * 0.2 * TIME), 2),  # slow, so that its peaks are flat in two digits
        np.where((TIME > 4.0) & (TIME < 5.0), 1.0, 0.0),
        np.where(TIME < 4.0, np.sin(np.pi * TIME / 2.0), 0.0),
        np.where((TIME > 2.0) & (TIME < 4.0), np.sign(3.0 - TIME), 0.0),
        np.interp(TIME, [0.0, 1.0, 1.5, 2.0, 10.0], [0.0, 0.0, 1.0, 0.0, 0.0]),
        np.where(TIME == 3.0, 1.0, 0.0),
    ],
)
def test_pulses_and_coarse_samples_have_no_flaws(tmp_path: Path, values: np.ndarray) -> None:
    assert [line for line in warnings(tmp_path, values, correction="none") if "spike" in line or "flat" in line or "gap" in line] == []


def test_recorded_motions_have_no_flaws_until_they_are_made() -> None:
    files = sorted((SHARED / "records" / "suite").glob("*.acc"))[::9]
    if not files:
        pytest.skip("the shared records are not there")
    for file in files:
        values = np.loadtxt(file)
        peak = float(np.abs(values).max())
        assert not len(flaws.spikes(values)[0]) and not flaws.flat_tops(values) and not flaws.gaps(values, 0.005, peak), file.name
        at = int(np.argmax(np.abs(values)))
        struck, held = values.copy(), values.copy()
        struck[at + 40], held[at : at + 100] = 1.5 * peak, 0.0
        assert flaws.spikes(struck)[0].tolist() == [at + 40] and flaws.gaps(held, 0.005, peak), file.name
        assert flaws.flat_tops(np.clip(values, -0.6 * peak, 0.6 * peak)), file.name
