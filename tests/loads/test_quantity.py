# SPDX-License-Identifier: GPL-3.0-or-later
"""Velocities and displacements are refused, or differentiated on request; flaws and cuts of records are named, sound ones are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from places import SHARED
from records import at2, esm

import loads
from loads.readers import RawRecord, quantity
from loads.readers.pieces import of_processing
from loads.signal import flaws
from loads.signal.accelerogram import Accelerogram, Processed, process
from loads.signal.series import Keys, accelerations, derivative
from masonry_cd.foundation.errors import InputError

STEP = 0.01
TIME = STEP * np.arange(40)


def processed(folder: Path, text: str, **keys: object) -> Processed:
    (folder / "quake.dat").write_text(text)
    return process(Accelerogram(path="quake.dat", **keys), folder, 1e-3, "loads[0]")


def rows(heading: str, values: np.ndarray = TIME) -> str:
    return heading + "\n" + "".join(f"{t:.2f},{v:.9g}\n" for t, v in zip(TIME, values, strict=True))


VELOCITY = [
    (at2(what="VELOCITY TIME SERIES", unit="CM/S"), "line 3"),
    (at2(what="VELOCITY TIME HISTORY", unit="CM/SEC."), "line 3"),
    (at2(what="VEL TIME SERIES", unit="CM/S"), "line 3"),
    (at2().replace("ACCELERATION TIME SERIES IN UNITS OF G", "TIME SERIES OF VELOCITY"), "line 3"),
    (at2().replace("ACCELERATION TIME SERIES IN UNITS OF G", "CORRECTED, CM/SEC"), 'its unit "CM/SEC"'),
    (esm(DATA_TYPE="VELOCITY", UNITS="cm/s"), "line 6, DATA_TYPE"),
    (esm(DATA_TYPE="VELOCITY"), "contradicts itself: of velocity by line 6, DATA_TYPE, of acceleration by its unit"),
    (esm(DATA_TYPE="", UNITS="cm/s"), 'its unit "cm/s"'),
    (esm(DATA_TYPE="", UNITS="", STREAM="HHN"), "channel HHN, that of a high-gain seismometer"),
    (rows("time_s,vel_cm_s"), 'the column "vel_cm_s"'),
    (rows("t,NS (m/s)"), 'its unit "m/s"'),
    (rows("t,NS cm/s"), 'its unit "cm/s"'),
    (rows("t,velocity"), 'the column "velocity"'),
    (rows("t,velocità"), 'the column "velocità"'),
    (rows("t,vitesse"), 'the column "vitesse"'),
    (rows("t,cm/s"), 'its unit "cm/s"'),
    (rows("t,HHE"), "channel HHE"),
    (rows("t,IV.AQU..EHZ"), "channel EHZ"),
    (rows("# velocity time series, corrected"), 'the line "# velocity time series, corrected"'),
    (rows("# channel HHE"), "channel HHE"),
    (rows("# dt 0.01, units: CM/S"), 'the line "# dt 0.01, units: CM/S"'),
]


@pytest.mark.parametrize(("text", "why"), VELOCITY)
def test_a_record_of_velocity_is_refused_with_what_says_so(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(InputError) as failure:
        processed(tmp_path, text)
    assert why in str(failure.value)
    if "contradicts" not in why:
        assert str(failure.value).startswith("loads[0].quantity: missing, and quake.dat is a record of velocity (")
        assert 'quantity = "velocity" differentiates it' in str(failure.value)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (at2(what="DISPLACEMENT TIME SERIES", unit="CM"), "displacement"),
        (esm(DATA_TYPE="DISPLACEMENT", UNITS="cm"), "displacement"),
        (rows("t,disp [mm]"), "displacement"),
        (rows("t,spostamento"), "displacement"),
    ],
)
def test_so_is_one_of_displacement(tmp_path: Path, text: str, word: str) -> None:
    with pytest.raises(InputError, match=f"is a record of {word}"):
        processed(tmp_path, text)


@pytest.mark.parametrize(
    "heading",
    [
        "t,a [g]",
        "# shear wave velocity Vs30 = 360 m/s\nt,a [g]",
        "# peak velocity 12 cm/s\nt,a [g]",
        "# velocity and displacement\nt,a [g]",
    ],
)
def test_accelerations_are_let_pass(tmp_path: Path, heading: str) -> None:
    assert processed(tmp_path, rows(heading)).quantity == "acceleration"


def test_differentiated_on_request_the_peak_is_that_of_the_motion(tmp_path: Path) -> None:
    """v = V sin^2(pi t / T) sin(w t), and its derivatives in closed form; a twentieth of the sampling rate."""
    t, w, big = STEP * np.arange(801), 2.0 * np.pi * 5.0, 8.0
    swell = np.sin(np.pi * t / big) ** 2
    v = 0.1 * swell * np.sin(w * t)
    a = 0.1 * (w * swell * np.cos(w * t) + np.pi / big * np.sin(2.0 * np.pi * t / big) * np.sin(w * t))
    (tmp_path / "v.csv").write_text("t,v_cm_s\n" + "".join(f"{x:.2f},{100.0 * y:.12g}\n" for x, y in zip(t, v, strict=True)))
    found = process(Accelerogram(path="v.csv", quantity="velocity"), tmp_path, 1e-3, "loads[0]")
    assert found.before.acceleration == pytest.approx(a, abs=1e-4 * abs(a).max())
    assert found.before.numbers()["pgv"] == pytest.approx(abs(v).max(), rel=0.01)
    assert found.numbers()["quantity"] == "velocity"
    d = np.cumsum(v) * STEP
    (tmp_path / "d.csv").write_text("t,d_mm\n" + "".join(f"{x:.2f},{1000.0 * y:.14g}\n" for x, y in zip(t, d, strict=True)))
    twice = process(Accelerogram(path="d.csv", quantity="displacement"), tmp_path, 1e-3, "loads[0]")
    assert twice.before.numbers()["pga"] == pytest.approx(abs(a).max(), rel=0.01)


@pytest.mark.parametrize("share", [0.05, 0.1, 0.2, 0.25])
def test_the_slope_is_right_up_to_half_the_nyquist_frequency(share: float) -> None:
    w = 2.0 * np.pi * share
    k = np.arange(400)
    assert derivative(np.sin(w * k), 1.0)[100:300] == pytest.approx(w * np.cos(w * k[100:300]), abs=0.006 * w)
    assert derivative(2.0 + 3.0 * k, 0.5) == pytest.approx(np.full(400, 6.0), abs=1e-9)


@pytest.mark.parametrize(
    ("code", "wanted"),
    [("HNE", "acceleration"), ("EHZ", "velocity"), ("HHE", "velocity"), ("bhz", "velocity"), ("HGN", "acceleration"), ("GPZ", "velocity")]
    + [("HLE", ""), ("LDO", ""), ("HXE", None), ("N-S", None), ("", None), ("HN", None), ("ACCX", None)],
)
def test_channel_codes(code: str, wanted: str | None) -> None:
    found = quantity.of_channel(code)
    assert (found.quantity if found else None) == wanted


@pytest.mark.parametrize(
    ("done", "wanted"),
    [
        (("differentiate(method='gradient')",), "acceleration"),
        (("integrate(method='cumtrapz')",), "displacement"),
        (("remove_response(output='ACC')", "integrate(method='cumtrapz')"), "velocity"),
        (("differentiate(method='gradient')",) * 2, ""),
        (("detrend(type='linear')",), "velocity"),
    ],
)
def test_what_was_done_to_a_velocity_says_what_it_is(done: tuple[str, ...], wanted: str) -> None:
    found = of_processing(done, quantity.of_channel("HHE"))
    assert found is not None and found.quantity == wanted


def raw(code: str, counts: bool = False) -> RawRecord:
    return RawRecord(np.sin(20.0 * TIME), STEP, 0.0, None, code, stated=quantity.of_channel(code), counts=counts)


@pytest.mark.parametrize(
    ("code", "keys", "message"),
    [
        ("HHE", Keys(units="m/s2"), "w.quantity: missing, and f is a record of velocity (channel HHE"),
        ("HHE", Keys(units="m/s"), "w.quantity: missing"),
        ("HHE", Keys("velocity", "m/s2"), 'w.units: "m/s2" is a unit of acceleration, but f is one of velocity (quantity = "velocity")'),
        ("HHE", Keys("velocity"), "w.units: missing, and f does not name its unit; give one of m/s, cm/s, mm/s, nm/s, in/s, kine"),
        ("HNE", Keys(units="cm/s"), 'w.units: "cm/s" is a unit of velocity, but f is one of acceleration (channel HNE'),
        ("HLE", Keys(units="m/s2"), "w.quantity: missing, and f is of channel HLE, that of a low-gain sensor"),
        ("LDO", Keys(units="m/s2"), "w.quantity: missing, and f is of channel LDO, that of a pressure sensor; say which"),
        ("", Keys(units="cm/s"), 'w.quantity: missing, and f is a record of velocity (units = "cm/s")'),
        ("", Keys(), "w.units: missing, and f does not name its unit; give one of m/s2"),
        ("", Keys(units="furlong"), 'w.units: unknown unit "furlong"; known: m/s2, '),
    ],
)
def test_keys_and_channel_have_to_agree(code: str, keys: Keys, message: str) -> None:
    with pytest.raises(InputError) as failure:
        accelerations(raw(code), keys, "w", "f")
    assert str(failure.value).startswith(message)


def test_a_channel_whose_response_has_been_taken_out_is_what_the_user_says() -> None:
    found, was = accelerations(raw("HHE"), Keys("acceleration", "cm/s2"), "w", "f")
    assert was == "acceleration"
    assert found == pytest.approx(0.01 * np.sin(20.0 * TIME))


def test_a_heading_is_not_overruled(tmp_path: Path) -> None:
    with refused_at("loads[0].quantity"):
        processed(tmp_path, at2(), quantity="velocity")


def test_counts_need_a_statement_of_what_they_mean() -> None:
    with refused_at("w.calibration"):
        accelerations(raw("HNE", counts=True), Keys(units="m/s2"), "w", "f")
    assert accelerations(raw("HNE", counts=True), Keys(units="m/s2", calibration=1.0), "w", "f")[1] == "acceleration"


@pytest.mark.parametrize(("values", "step", "message"), [(1e300, 0.01, "an acceleration of 1e"), (1.0, 1e-300, "a time step of 1e-300 s")])
def test_numbers_that_no_motion_has_are_refused(values: float, step: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        accelerations(RawRecord(np.full(40, values), step, 0.0, "m/s2"), Keys(), "w", "f")


TIME_PLAUSIBLE = STEP * np.arange(1001)
SWELL = np.sin(np.pi * TIME_PLAUSIBLE / 10.0) ** 2
WAVE = 2.0 * SWELL * np.sin(2 * np.pi * 1.3 * (TIME_PLAUSIBLE - 5.0)) * np.cos(np.pi * (TIME_PLAUSIBLE - 5.0) / 10.0)


def warnings(folder: Path, values: np.ndarray, unit: str = "m/s2", **keys: object) -> list[str]:
    rows = "".join(f"{t:.2f} {a:.12g}\n" for t, a in zip(TIME_PLAUSIBLE, values, strict=True))
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
    ramp = 0.1 * (TIME_PLAUSIBLE / 5.0 - 1.0)
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
    pulse = np.where(TIME_PLAUSIBLE < 4.0, 1.5 * shape(np.pi * TIME_PLAUSIBLE / 4.0), 0.0)
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
    (np.where((TIME_PLAUSIBLE >= 4.8) & (TIME_PLAUSIBLE < 5.3), 0.0, WAVE), "a gap in the shaking, of up to 0.5 s of one value, at 4.8 s"),
    (
        np.where((TIME_PLAUSIBLE > 4.8) & (TIME_PLAUSIBLE < 5.1), WAVE[475], WAVE),
        "a gap in the shaking, of up to 0.29 s of one value, at 4.81 s",
    ),
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
        np.round(np.sin(2.0 * np.pi * 0.2 * TIME_PLAUSIBLE), 2),  # slow, so that its peaks are flat in two digits
        np.where((TIME_PLAUSIBLE > 4.0) & (TIME_PLAUSIBLE < 5.0), 1.0, 0.0),
        np.where(TIME_PLAUSIBLE < 4.0, np.sin(np.pi * TIME_PLAUSIBLE / 2.0), 0.0),
        np.where((TIME_PLAUSIBLE > 2.0) & (TIME_PLAUSIBLE < 4.0), np.sign(3.0 - TIME_PLAUSIBLE), 0.0),
        np.interp(TIME_PLAUSIBLE, [0.0, 1.0, 1.5, 2.0, 10.0], [0.0, 0.0, 1.0, 0.0, 0.0]),
        np.where(TIME_PLAUSIBLE == 3.0, 1.0, 0.0),
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
