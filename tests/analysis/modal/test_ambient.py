# SPDX-License-Identifier: GPL-3.0-or-later
"""Modes identified from ambient records whose modes are known: a chain of masses in closed form, and our own elastic joints."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from hostile import refusal
from models import box, ground, tower
from scipy.signal import cont2discrete, lfilter

from masonry_cd.analysis.modal.ambient import AmbientRecord, identify
from masonry_cd.analysis.modal.ambient_records import read_ambient
from masonry_cd.analysis.modal.measured_modes import mac
from masonry_cd.analysis.modal.modes import modal as modal_modes
from masonry_cd.app.commands.modal import modal
from masonry_cd.foundation.errors import InputError

DAMPING = 0.02
STEP = 0.01  # [s]
MASSES, FIRST = 4, 1.5  # and the first frequency [Hz]


def shaken(frequency: np.ndarray, shapes: np.ndarray, samples: int, seed: int = 1) -> np.ndarray:
    """Accelerations (samples, C) of modes (n,) [Hz] with shapes (n, C) under forces of white noise on all channels, plus 1 % of noise."""
    rng = np.random.default_rng(seed)
    forces = rng.standard_normal((samples, shapes.shape[1])) @ shapes.T
    out = np.zeros((samples, shapes.shape[1]))
    for omega, force, shape in zip(2.0 * np.pi * frequency, forces.T, shapes, strict=True):
        up, down, _ = cont2discrete(([1.0, 0.0, 0.0], [1.0, 2.0 * DAMPING * omega, omega**2]), STEP)
        out += np.outer(lfilter(np.ravel(up), down, force), shape)
    return out + 0.01 * out.std() * rng.standard_normal(out.shape)


def chain() -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and shapes of equal masses on equal springs, of which the first is held: sin((2 k - 1) pi j / (2 n + 1))."""
    odd = (2.0 * np.arange(1, MASSES + 1) - 1.0) * np.pi / (2 * MASSES + 1)
    frequency = np.sin(odd / 2.0)
    shapes = np.sin(np.outer(odd, np.arange(1, MASSES + 1)))
    return FIRST * frequency / frequency[0], shapes / np.linalg.norm(shapes, axis=1, keepdims=True)


def record(values: np.ndarray) -> AmbientRecord:
    """Sensors above one another, along x."""
    count = values.shape[1]
    points = np.column_stack([np.zeros((count, 2)), np.arange(count)])
    names = tuple(f"S{k}" for k in range(count))
    return AmbientRecord(Path("made"), values, STEP, np.arange(count), np.zeros(count, dtype=int), names, points, names)


def written(folder: Path, values: np.ndarray, points: np.ndarray, axes: str = "x") -> dict[str, Path]:
    """The two files of a record: channels by sensor, then by axis, in mm/s2."""
    heads = [f"S{k}_{axis}_mm_s2" for k in range(len(points)) for axis in axes]
    table = np.column_stack([STEP * np.arange(len(values)), 1e3 * values])
    np.savetxt(folder / "ambient.csv", table, "%.8g", ",", header=",".join(["time_s", *heads]), comments="# night\n")
    places = "".join(f"S{k},{100 * x:.12g},{100 * y:.12g},{100 * z:.12g}\n" for k, (x, y, z) in enumerate(points))
    (folder / "sensors.csv").write_text("sensor,x_cm,y_cm,z_cm\n" + places)
    return {"ambient": folder / "ambient.csv", "sensors": folder / "sensors.csv"}


def test_the_modes_of_a_chain_are_found() -> None:
    """Frequencies within 0.5 %, damping within 15 %, MAC above 0.99, none too many and none missed."""
    frequency, shapes = chain()
    found = identify(record(shaken(frequency, shapes, 180_000)), 6, 0.5, 10.0)
    assert [mode.frequency for mode in found.modes] == pytest.approx(frequency, rel=0.005)
    assert [mode.damping for mode in found.modes] == pytest.approx([DAMPING] * MASSES, rel=0.15)
    assert min(mac(mode.shape, shape) for mode, shape in zip(found.modes, shapes, strict=True)) > 0.99
    assert (found.rate, found.rows, found.orders, found.left) == (25.0, 25, 30, 0)
    fewer = identify(record(shaken(frequency, shapes, 60_000)), 2, 0.5, 10.0)
    assert [mode.frequency for mode in fewer.modes] == pytest.approx(frequency[:2], rel=0.005)
    assert fewer.left == MASSES - 2


def test_noise_alone_has_no_mode() -> None:
    with pytest.raises(InputError, match=r"no mode from 0.5 to 10 Hz is stable"):
        identify(record(np.random.default_rng(1).standard_normal((60_000, MASSES))), 6, 0.5, 10.0)


def test_what_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyoma2", None)
    with pytest.raises(
        InputError, match=re.escape('an ambient record needs pyOMA-2, which is not installed: pip install "masonry-cd[oma]"')
    ):
        identify(record(shaken(*chain(), 60_000)), 2, 0.5, 10.0)


def test_a_tower_is_fitted_to_its_record(tmp_path: Path) -> None:
    """From modes of elastic joints to a record, and from that to the modulus, and to files that are read as measured modes."""
    blocks = [ground(), *(box(f"b{k}", (0.0, 0.0, 0.25 * k), (0.5, 0.7, 0.25 * k + 0.25)) for k in range(6))]
    options = {"young": 2e7, "method": "joints", "modes": 4, "pictures": 0}
    modes = modal_modes(blocks, 2e7, method="joints", modes=4)
    corners = modes.points + np.array([0.25, 0.35, 0.125])  # where a mode that turns is seen, too
    channels = modes.field.at(corners)[0][:, :, :2].reshape(4, -1)
    files = written(tmp_path, shaken(modes.frequencies, channels, 90_000), corners, "xy")
    band = {"lowest": 0.5 * modes.frequencies[0], "highest": 1.2 * modes.frequencies[-1]}
    made = modal(blocks, options | files | band | {"young": 1e7, "fit": True, "pictures": 1}, tmp_path / "out")
    joints = made.value["models"]["joints"]
    assert joints["young_pa"] == pytest.approx(2e7, rel=0.01)
    assert [pair["error_percent"] for pair in joints["measured"]] == pytest.approx([0.0] * 4, abs=0.5)
    assert min(pair["mac"] for pair in joints["measured"]) > 0.99
    assert made.value["ambient"]["damping"] == pytest.approx([DAMPING] * 4, rel=0.15)
    assert made.lines[0].startswith("ambient: 900 s of 12 channels at ")
    assert {path.name for path in made.written} >= {"ambient.csv", "stabilisation.png"}
    again = modal(blocks, options | {"reference": tmp_path / "out" / "ambient.csv"}).value["models"]["joints"]
    assert [pair["mac"] for pair in again["measured"]] == pytest.approx([pair["mac"] for pair in joints["measured"]])


RECORD = "time_s,S0_x_mm_s2,S1_x_mm_s2\n0.00,1,2\n0.01,2,3\n0.02,3,1\n0.03,4,2\n0.04,1,5\n"
SENSORS = "sensor,x_m,y_m,z_m\nS0,0,0,0\nS1,0,0,1\n"


@pytest.mark.parametrize(
    ("text", "sensors", "said"),
    [
        (RECORD.replace("time_s", "time"), SENSORS, 'a.csv: the first column should be time_s, got "time"'),
        (RECORD.replace("S1_x_mm_s2", "S1_x"), SENSORS, 'a.csv: column "S1_x": has no unit; write sensor, axis and unit'),
        (RECORD.replace("S1_x_mm_s2", "S1_x_mm"), SENSORS, 'a.csv: column "S1_x_mm": mm is not a unit of acceleration'),
        (RECORD.replace("S1_x_mm_s2", "S1_mm_s2"), SENSORS, 'a.csv: column "S1_mm_s2": names no axis'),
        (RECORD.replace("S1_x", "S0_x"), SENSORS, 'a.csv: column "S0_x_mm_s2": sensor S0 has its x in a column before'),
        (RECORD.replace("2,3\n", "2,three\n"), SENSORS, 'a.csv:3: S1_x_mm_s2: should be a number, got "three"'),
        (RECORD.replace("2,3\n", "2,nan\n"), SENSORS, 'a.csv:3: S1_x_mm_s2: should be a number, got "nan"'),
        (RECORD.replace("2,3\n", "2\n"), SENSORS, "a.csv:3: 2 values under 3 columns"),
        (RECORD.replace("0.02,3,1\n", ""), SENSORS, "a.csv:4: the time advances by 0.02, elsewhere by "),
        (RECORD.replace("0.01,", "0.00,"), SENSORS, "a.csv:3: the time advances by 0, elsewhere by "),
        (re.sub(r",\d+\n", ",3\n", RECORD), SENSORS, 'a.csv: column "S1_x_mm_s2": does not vary'),
        (RECORD, SENSORS.replace("S1", "T1"), 's.csv: has no sensor "S1", which a.csv has'),
        (RECORD, SENSORS.replace("S1", "S0"), "s.csv:3: sensor S0 occurs twice"),
        (RECORD, SENSORS.replace("z_m", "z"), 's.csv: column "z" has no unit; write z_m'),
        (RECORD, SENSORS.replace("S1,0", "S1,"), 's.csv:3: x_m: should be a number, got ""'),
        (RECORD, SENSORS.replace(",z_m", ""), "s.csv:2: 4 values under 3 columns"),
        (RECORD, "sensor,x_m,y_m\nS0,0,0\n", "s.csv: should have the columns sensor, x_m, y_m, z_m, each once"),
        ("time_s\n0\n", SENSORS, "a.csv: has no channel next to the time"),
        ("time_s,S0_x_g\n", SENSORS, "a.csv: holds no record"),
        (RECORD, SENSORS, "a.csv: 0.05 s are too short"),
    ],
)
def test_files_that_are_wrong_are_refused(tmp_path: Path, text: str, sensors: str, said: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    (tmp_path / "s.csv").write_text(sensors)
    message = refusal(tmp_path, lambda: identify(read_ambient(tmp_path / "a.csv", tmp_path / "s.csv"), 2))
    assert message is not None and message.startswith(said) and "\n" not in message, message


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"lowest": 1.0}, "together"),
        ({"ambient": "a.csv"}, "together"),
        ({"ambient": "a.csv", "sensors": "s.csv", "reference": "m.csv"}, "give one of them"),
        ({"fit": True}, "give reference or ambient"),
        ({"ambient": "none.csv", "sensors": "s.csv"}, "cannot be read"),
    ],
)
def test_options_that_are_wrong_are_refused(tmp_path: Path, options: dict[str, object], said: str) -> None:
    message = refusal(tmp_path, lambda: modal(tower(2), {"young": 1e9} | options))
    assert message is not None and said in message, message


@pytest.mark.parametrize("band", [(0.5, 41.0), (5.0, 5.0)])
def test_a_band_that_the_record_cannot_show_is_refused(band: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"is not a band up to 0.4 of the rate, 40 Hz"):
        identify(record(shaken(*chain(), 1000)), 2, *band)
