# SPDX-License-Identifier: GPL-3.0-or-later
"""Velocities and displacements are known by heading, unit or channel code: refused, or differentiated where the user asks for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from records import at2, esm

from loads.readers import RawRecord, quantity
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
