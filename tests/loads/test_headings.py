# SPDX-License-Identifier: GPL-3.0-or-later
"""Headings that count and time the values, and tables that could be read in two ways: what contradicts itself is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import record_files as files
from hostile import refused_at
from places import SHARED
from records import side_by_side, wrapped

from loads.picture import file_picture
from loads.readers import RawRecord, Request, Source, read
from loads.readers.wrapped import is_in_reading_order
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


TWO_STEPS, TWICE = "0.005 and 0.01 s", f"{N} as the number of values and as their rate"


@pytest.mark.parametrize(
    ("heading", "both"),
    [
        (f"{N} SAMPLES AT 200 HZ, DT = 0.01", TWO_STEPS),
        (f"DT = 0.01\n{N} SAMPLES AT 200 HZ", TWO_STEPS),
        (f"DT = 0.01\n{N} 0.005", TWO_STEPS),
        (f"{N} 0.005\n100 SPS", TWO_STEPS),
        (f"{N} SAMPLES AT {N} HZ", TWICE),
        (f"{N} SPS\n{N} SAMPLES", TWICE),
    ],
)
def test_a_heading_that_contradicts_itself_is_refused_by_its_line(tmp_path: Path, heading: str, both: str) -> None:
    with pytest.raises(InputError, match=f"line \\d: .* {both}"):
        load(tmp_path, f"A RECORD, ACCELERATION IN M/S2\n{heading}\n{BODY}")


def test_eight_values_are_the_fewest_below_their_count(tmp_path: Path) -> None:
    few, enough = (f"A RECORD, ACCELERATION IN M/S2\n{n} 0.005\n" + "".join(f"{v:.6f}\n" for v in VALUES[:n]) for n in (7, 8))
    assert load(tmp_path, enough)[0] == "counted"
    with pytest.raises(InputError):
        load(tmp_path, few)


def test_a_million_samples_a_second_are_the_most_of_a_web_service(tmp_path: Path) -> None:
    text = head() + BODY
    assert load(tmp_path, text.replace("200 sps", "1000000 sps"))[1].step == 1e-6
    with pytest.raises(InputError, match="line 1"):
        load(tmp_path, text.replace("200 sps", "1000001 sps"))


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
    name, other = load(tmp_path, "t,a [m/s2]\n" + table(times, values), time_step=0.01)
    assert (name, other.step, len(other.notes)) == ("csv", 0.01, 1) and other.values == pytest.approx(values, abs=1e-6)
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


STEP_WRAPPED = 0.01
TIME = STEP_WRAPPED * np.arange(402)
QUAKE = np.round(np.sin(np.pi * TIME / 4.02) ** 2 * (np.sin(21.0 * TIME) + 0.4 * np.sin(47.0 * TIME + 1.0)), 6)
OTHER = np.round(np.sin(np.pi * TIME / 4.02) ** 2 * (np.sin(26.0 * TIME + 2.0) + 0.4 * np.sin(39.0 * TIME)), 6)


def load_wrapped(folder: Path, text: str, **request: object) -> RawRecord:
    return load(folder, text, **request)[1]


@pytest.mark.parametrize("width", [2, 3, 5, 8, 10])
@pytest.mark.parametrize("between", ["  ", ",", ";"])
def test_a_series_of_several_values_a_line_is_refused_and_read_on_request(tmp_path: Path, width: int, between: str) -> None:
    text = wrapped(QUAKE, width, between)
    for request in ({"column": 0, "time_step": STEP_WRAPPED}, {"time_step": STEP_WRAPPED}, {"column": 1}, {}):
        with pytest.raises(InputError, match=f'{width} columns that could be one series, .* the key layout decides: "series" reads'):
            load_wrapped(tmp_path, text, **request)
    record = load_wrapped(tmp_path, text, layout="series", time_step=STEP_WRAPPED)
    assert record.values == pytest.approx(QUAKE, abs=1e-9)
    assert record.step == STEP_WRAPPED


BETWEEN_COMMAS = wrapped(QUAKE[:400], 8, ",")
NUMBERED = "".join(f"{line} {k + 1}\n" for k, line in enumerate(wrapped(QUAKE[:400], 8).splitlines()))
TIMED = side_by_side(TIME[:400:8], *(QUAKE[k:400:8] for k in range(8)))


@pytest.mark.parametrize(
    ("text", "keys", "words"),
    [
        (BETWEEN_COMMAS.replace("\n", ",\n"), {"column": 0}, "8 columns that could be one series"),
        ("Acceleration,of,station,X,comp,NS,run,1b\n" + BETWEEN_COMMAS, {"column": 0}, "8 columns that could be one series"),
        (NUMBERED, {"column": 0}, "8 columns before the numbers of the lines that could be one series"),
        (NUMBERED, {"layout": "series"}, "each line ends with its time or number"),
        (TIMED, {"column": 1}, "8 columns behind the times that could be one series"),
        (TIMED, {"layout": "series"}, "each line begins with its time"),
        (side_by_side(TIME, QUAKE), {"column": 0}, "column 0 is the time"),
    ],
)
def test_what_stands_around_a_series_does_not_hide_it_and_is_no_part_of_it(tmp_path: Path, text: str, keys: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_wrapped(tmp_path, text, time_step=STEP_WRAPPED, **keys)


def test_columns_that_are_asked_for_are_read_even_where_they_could_be_a_series(tmp_path: Path) -> None:
    record = load_wrapped(tmp_path, wrapped(QUAKE[:400], 8), layout="columns", column=2, time_step=STEP_WRAPPED)
    assert record.values == pytest.approx(QUAKE[2:400:8], abs=1e-9)


def test_text_above_a_series_is_passed_over(tmp_path: Path) -> None:
    record = load_wrapped(tmp_path, "Gemona 1976 NS\n" + wrapped(QUAKE, 8, ", "), layout="series", time_step=STEP_WRAPPED)
    assert record.values == pytest.approx(QUAKE, abs=1e-9)
    with pytest.raises(InputError, match=r'8 columns below a heading of 3; layout = "series" reads one series'):
        load_wrapped(tmp_path, "Gemona 1976 NS\n" + wrapped(QUAKE, 8), time_step=STEP_WRAPPED)


@pytest.mark.parametrize(
    "columns",
    [(QUAKE, OTHER), (QUAKE, OTHER, 0.5 * QUAKE), (QUAKE, 0.3 * OTHER), (QUAKE, QUAKE), (QUAKE, np.round(0.98 * QUAKE, 6), OTHER)],
)
def test_components_side_by_side_stay_columns(tmp_path: Path, columns: tuple[np.ndarray, ...]) -> None:
    assert load_wrapped(tmp_path, side_by_side(*columns), column=1, time_step=STEP_WRAPPED).values == pytest.approx(columns[1], abs=1e-6)
    assert load_wrapped(tmp_path, side_by_side(TIME, *columns), column=1).values == pytest.approx(columns[0], abs=1e-6)


def test_a_heading_that_names_units_makes_columns(tmp_path: Path) -> None:
    text = "ns_m_s2 ew_m_s2\n" + wrapped(QUAKE, 2)
    assert load_wrapped(tmp_path, text, column="ew", time_step=STEP_WRAPPED).values == pytest.approx(QUAKE[1::2], abs=1e-9)


def pairs(width: int) -> str:
    flat = np.column_stack([TIME, QUAKE])[:400].ravel()
    return "".join("  ".join(f"{v:.6f}" for v in flat[i : i + 2 * width]) + "\n" for i in range(0, len(flat), 2 * width))


@pytest.mark.parametrize("heading", ["", "time acc time acc time acc time acc\n"])
def test_pairs_in_reading_order_are_refused_and_read_on_request(tmp_path: Path, heading: str) -> None:
    for column in (1, 3, None):
        with pytest.raises(
            InputError, match=r'pairs side by side that could be one record; the key layout decides: "pairs" reads it as one'
        ):
            load_wrapped(tmp_path, heading + pairs(4), column=column)
    record = load_wrapped(tmp_path, heading + pairs(4), layout="pairs")
    assert record.values == pytest.approx(QUAKE[:400], abs=1e-9)
    assert record.step == pytest.approx(STEP_WRAPPED)


def test_pairs_that_go_down_and_on_in_the_next_columns(tmp_path: Path) -> None:
    text = side_by_side(TIME[:201], QUAKE[:201], TIME[201:], QUAKE[201:])
    with pytest.raises(InputError, match="pairs side by side"):
        load_wrapped(tmp_path, text, column=1)
    assert load_wrapped(tmp_path, text, layout="pairs").values == pytest.approx(QUAKE, abs=1e-9)


def test_pairs_whose_last_line_is_short(tmp_path: Path) -> None:
    flat = np.column_stack([TIME, QUAKE]).ravel()
    text = "".join("  ".join(f"{v:.6f}" for v in flat[i : i + 8]) + "\n" for i in range(0, len(flat), 8))
    assert len(load_wrapped(tmp_path, text, layout="pairs").values) == 402


def test_components_with_times_of_their_own_take_the_times_next_to_them(tmp_path: Path) -> None:
    text = side_by_side(TIME, QUAKE, 2.0 * TIME + 5.0, OTHER)
    other = load_wrapped(tmp_path, text, column=3)
    assert (other.step, other.origin) == (pytest.approx(2 * STEP_WRAPPED), pytest.approx(5.0))
    assert load_wrapped(tmp_path, text, column=1).step == pytest.approx(STEP_WRAPPED)
    with pytest.raises(InputError, match="column 2 is the time; columns are counted from 0: 1, 3"):
        load_wrapped(tmp_path, text, column=2)
    headed = load_wrapped(tmp_path, "time,ns,time,ew\n" + side_by_side(TIME, QUAKE, 2.0 * TIME, OTHER, between=","), column="ew")
    assert headed.step == pytest.approx(2 * STEP_WRAPPED)


def test_time_step_wins_over_times_of_columns_and_of_pairs(tmp_path: Path) -> None:
    """Two columns, uneven ones among them, and pairs: a note says what the times of the file are, where they differ."""
    uneven = np.sort(np.round(TIME + 0.3 * STEP_WRAPPED * np.sin(np.arange(len(TIME))), 6))
    for text, keys in (
        (side_by_side(TIME, QUAKE), {}),
        ("time,acc\n" + side_by_side(uneven, QUAKE, between=","), {}),
        (side_by_side(TIME, QUAKE), {"layout": "pairs"}),
    ):
        record = load_wrapped(tmp_path, text, time_step=2.0 * STEP_WRAPPED, **keys)
        assert record.step == 2.0 * STEP_WRAPPED and record.values == pytest.approx(QUAKE, abs=1e-6)
        assert len(record.notes) == 1 and "time_step" in record.notes[0]
    assert load_wrapped(tmp_path, side_by_side(TIME, QUAKE), time_step=STEP_WRAPPED).notes == ()


def test_noise_and_short_tables_show_nothing() -> None:
    rng = np.random.default_rng(3)
    assert not is_in_reading_order(rng.normal(size=(3, 4)))
    assert sum(is_in_reading_order(rng.normal(size=(400, 3))) for _ in range(20)) == 0
