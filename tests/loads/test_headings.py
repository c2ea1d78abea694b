# SPDX-License-Identifier: GPL-3.0-or-later
"""Headings that count the values and give their step, and the text of web services: a count is no rate, and contradictions are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import record_files as files
from hostile import refused_at
from places import SHARED

from loads.picture import file_picture
from loads.readers import RawRecord, Request, Source, read
from masonry_cd.foundation.errors import InputError

N, STEP, VALUES = files.COUNT, files.STEP, files.WAVE
BODY = "\n".join(" ".join(f"{v:.6f}" for v in VALUES[i : i + 5]) for i in range(0, N, 5)) + "\n"
head, tspair, START = files.announced, files.tspair, files.START


def load(folder: Path, text: str, **request: object) -> tuple[str, RawRecord]:
    (folder / "quake.txt").write_text(text)
    return read(Source.open(folder / "quake.txt", "p"), "auto", Request(**request))


@pytest.mark.parametrize(
    "heading",
    [
        f"{N} SAMPLES AT 200 HZ",
        f"200 Hz, {N} samples",
        f"{N} samples at 200 samples per second",
        f"{N} points, 200 pts/sec",
        f"NPTS {N}, 200 sps",
        f"DT = 0.005\n{N} SAMPLES",
        f"{N} SAMPLES\nDT = 0.005 SEC",
        f"{N} values, dt (ms) = 5",
        f"SAMPLING INTERVAL: 5 ms\nNUMBER OF SAMPLES: {N}",
        f"SAMPLING RATE (HZ): 200\nSAMPLES: {N}",
        f"{N} SAMPLES, FILTERED 0.1 TO 25 HZ, SAMPLED AT 200 HZ",
        f"BAND-PASS 0.1-25 HZ\n{N} 0.005",
        f"{N} 0.005",
        f"INSTRUMENT 25 HZ\n{N} SAMPLES AT 200 HZ",
    ],
)
def test_count_and_step_are_read_from_the_heading(tmp_path: Path, heading: str) -> None:
    name, record = load(tmp_path, f"A RECORD, ACCELERATION IN M/S2\n{heading}\n{BODY}")
    assert (name, record.unit) == ("counted", "M/S2")
    assert record.step == pytest.approx(STEP)
    assert record.values == pytest.approx(VALUES, abs=1e-6)


@pytest.mark.parametrize(
    "heading",
    [
        f"{N} SPS",  # one number that would be count and rate
        f"{N} HZ",
        f"{N} SAMPLES",
        f"{N} SAMPLES, RATE 200",
        f"{N} SAMPLES\nFILTERED 0.1-25 HZ",
    ],
)
def test_a_heading_without_one_step_is_refused(tmp_path: Path, heading: str) -> None:
    text = f"A RECORD, ACCELERATION IN M/S2\n{heading}\n{BODY}"
    with pytest.raises(InputError):
        load(tmp_path, text)
    with pytest.raises(InputError, match="by another number, one step or rate"):
        read(Source.open(tmp_path / "quake.txt", "p"), "counted", Request())
    assert load(tmp_path, text, layout="series", time_step=STEP)[1].values == pytest.approx(VALUES, abs=1e-6)


@pytest.mark.parametrize(
    "heading", [f"{N} SAMPLES AT 200 HZ, DT = 0.01", f"DT = 0.01\n{N} SAMPLES AT 200 HZ", f"DT = 0.01\n{N} 0.005", f"{N} 0.005\n100 SPS"]
)
def test_a_heading_that_contradicts_itself_is_refused_with_both_steps(tmp_path: Path, heading: str) -> None:
    with pytest.raises(InputError, match=r"line \d: .* 0.005 and 0.01 s"):
        load(tmp_path, f"A RECORD, ACCELERATION IN M/S2\n{heading}\n{BODY}")


@pytest.mark.parametrize("heading", [f"{N} SAMPLES AT {N} HZ", f"{N} SPS\n{N} SAMPLES"])
def test_one_number_as_count_and_rate_is_refused(tmp_path: Path, heading: str) -> None:
    with pytest.raises(InputError, match=f"line \\d: .* {N} as the number of values and as their rate"):
        load(tmp_path, f"A RECORD, ACCELERATION IN M/S2\n{heading}\n{BODY}")


def test_pairs_below_their_count_and_step(tmp_path: Path) -> None:
    pairs = "".join(f"{t:.3f} {v:.6f}\n" for t, v in zip(files.TIME + 2.0, VALUES, strict=True))
    name, record = load(tmp_path, f"{N} 0.005\n{pairs}")
    assert (name, record.origin, record.step) == ("counted", 2.0, 0.005)
    assert record.values == pytest.approx(VALUES, abs=1e-6)
    for wrong in (f"{N} 0.01", f"{N} 0.0051"):
        with pytest.raises(InputError):
            load(tmp_path, f"{wrong}\n{pairs}")


@pytest.mark.parametrize("text", [head() + BODY, tspair(), files.slist(), head(start=f"{START}Z") + "\n" + BODY])
def test_the_text_of_web_services_is_a_channel_with_its_rate_and_unit(tmp_path: Path, text: str) -> None:
    name, record = load(tmp_path, text)
    assert (name, record.name, record.unit, record.counts) == ("timeseries", "XX.SITE..HNE", "M/S**2", False)
    assert record.step == pytest.approx(STEP)
    assert record.values == pytest.approx(VALUES, abs=1e-6)
    found = file_picture(tmp_path / "quake.txt", None, correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(np.abs(VALUES).max(), rel=1e-5)


def test_channels_are_picked_and_pieces_put_together(tmp_path: Path) -> None:
    half = "\n".join(f"{v:.6e}" for v in VALUES[:50]) + "\n"
    rest = "\n".join(f"{v:.6e}" for v in VALUES[50:]) + "\n"
    later = head(count=N - 50, start="2021-03-04T05:06:07.250000") + rest
    text = head(count=50) + half + head(channel="HNZ") + BODY + later
    with pytest.raises(InputError, match=r"several channels; .*XX.SITE..HNE, XX.SITE..HNZ"):
        load(tmp_path, text)
    assert load(tmp_path, text, column="HNE")[1].values == pytest.approx(VALUES, abs=1e-6)
    with pytest.raises(InputError, match=r"a gap of 1 s in XX.SITE..HNE at 0.245 s"):
        load(tmp_path, text.replace("07.250000", "08.250000"), column="HNE")


@pytest.mark.parametrize(("kind", "unit"), [("INTEGER", ", COUNTS"), ("FLOAT", ", Counts"), ("INTEGER", "")])
def test_counts_of_such_a_text_need_a_calibration(tmp_path: Path, kind: str, unit: str) -> None:
    counts = "\n".join(f"{v:.0f}" for v in 1000.0 * VALUES) + "\n"
    (tmp_path / "quake.txt").write_text(head(kind=kind, unit=unit) + counts)
    with refused_at("record.calibration"):
        file_picture(tmp_path / "quake.txt", None, units="m/s2")
    found = file_picture(tmp_path / "quake.txt", None, units="m/s2", calibration=1e-3, correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(np.abs(VALUES).max(), rel=2e-3)


def test_a_velocity_of_such_a_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "quake.txt").write_text(head(unit=", M/S", channel="HHE") + BODY)
    with refused_at("record.quantity"):
        file_picture(tmp_path / "quake.txt", None)


def table(times: np.ndarray, values: np.ndarray, form: str = "{:.2f},{:.6f}") -> str:
    return "".join(form.format(t, v) + "\n" for t, v in zip(times, values, strict=True))


def test_lines_above_the_headings_give_step_and_unit(tmp_path: Path) -> None:
    body = "".join(f"{v:.6f},{-v:.6f}\n" for v in VALUES)
    record = load(tmp_path, f"SITE 7,,\nSAMPLING RATE=200Hz,,\nUNIT=gal(cm/s/s),,\nNS,EW\n{body}", column="EW")[1]
    assert (record.step, record.unit, record.name) == (STEP, "gal", "EW")
    assert record.values == pytest.approx(-VALUES, abs=1e-6)
    with pytest.raises(InputError, match="no time column; give the key time_step"):
        load(tmp_path, f"SITE 7,,\n{N} SAMPLES,,\nNS,EW\n{body}", column="EW")
    with pytest.raises(InputError, match=r"steps of 0.005 and 0.01 s; the key time_step decides"):
        load(tmp_path, f"SAMPLING RATE=200Hz,,\nDT=0.01,,\nNS,EW\n{body}", column="EW")


def test_the_one_acceleration_of_several_quantities_is_taken(tmp_path: Path) -> None:
    head = "time [s],{} [m/s2],velocity [m/s],displacement [m]\n"
    body = "".join(f"{t:.3f},{v:.6f},1.0,2.0\n" for t, v in zip(files.TIME, VALUES, strict=True))
    assert load(tmp_path, head.format("a") + body)[1].values == pytest.approx(VALUES, abs=1e-6)
    with pytest.raises(InputError, match="several components"):
        load(tmp_path, head.format("a").replace("velocity [m/s]", "b [m/s2]") + body)


def test_times_with_too_few_digits_are_those_of_a_whole_rate(tmp_path: Path) -> None:
    times, values = STEP * np.arange(400), np.sin(0.3 * np.arange(400))
    record = load(tmp_path, "t,a [m/s2]\n" + table(times, values))[1]
    assert (record.step, record.values) == (STEP, pytest.approx(values, abs=1e-6))
    assert "200 samples a second" in record.notes[0]
    assert load(tmp_path, "t,a [m/s2]\n" + table(times, values), time_step=STEP)[1].step == STEP
    with pytest.raises(InputError, match="the key time_step is given, but the file has a column"):
        load(tmp_path, "t,a [m/s2]\n" + table(times, values), time_step=0.01)
    for gone in (200, 50, 380):
        with pytest.raises(InputError, match="the time does not advance"):
            load(tmp_path, "t,a [m/s2]\n" + table(np.delete(times, range(gone, gone + 4)), np.delete(values, range(gone, gone + 4))))
    for wrong in (np.delete(times, 200), np.insert(times, 200, times[200])):
        with pytest.raises(InputError, match="the time"):
            load(tmp_path, "t,a [m/s2]\n" + table(2.0 * wrong, np.zeros(len(wrong))))


def test_fields_of_a_fortran_format_may_touch(tmp_path: Path) -> None:
    text = files.fortran()
    lines = text.splitlines()[1:]
    name, record = load(tmp_path, text)
    assert (name, record.step, record.unit) == ("fixed", STEP, "G")
    assert record.values == pytest.approx(VALUES, abs=1e-6)
    with pytest.raises(InputError, match=r'line 3: "-?O'):
        load(tmp_path, text.replace(lines[1], lines[1].replace("0.", "O.", 1)))
    with pytest.raises(InputError, match=r"steps of 0\.005 and 0\.01 s"):
        load(tmp_path, text.replace("UNITS", "100 SPS, UNITS"))


CASES = SHARED / "cases" / "records"
READ: list[tuple[str, dict[str, object]]] = [
    ("count_before_rate.txt", {}),
    ("slist.ascii", {}),
    ("count_and_step_above_pairs.txt", {"units": "g"}),
    ("cosmos_raw.V0c", {"calibration": 1e-5, "units": "m/s2"}),
    ("usc_volume2.s0a", {}),
    ("jma_like.csv", {"column": "NS"}),
    ("text_above_heading.txt", {}),
    ("fixed_width_8f9.acc", {}),
    ("rounded_times.csv", {}),
    ("rounded_times.csv", {"time_step": 0.005}),
    ("tabs_below_blanks.bbp", {"column": "N-S"}),
]


@pytest.mark.skipif(not CASES.is_dir(), reason="the shared files are not there")
@pytest.mark.parametrize(("name", "keys"), READ)
def test_files_of_the_wild_give_the_series_that_was_written(name: str, keys: dict[str, object]) -> None:
    found = file_picture(CASES / name, None, correction="none", **keys)
    numbers = found.before.numbers()
    assert (len(found.before.acceleration), found.before.step) == (1600, pytest.approx(0.005, rel=1e-4))
    assert (numbers["pga"], numbers["pgv"]) == (pytest.approx(1.762, abs=6e-4), pytest.approx(0.131, abs=6e-4))
