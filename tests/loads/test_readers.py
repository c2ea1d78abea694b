# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.readers: each format is known by its content, read from a file made here or from obspy's samples, and units are true."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from records import COUNTS, STEP, TIME, WAVE, at2, columns, esm, knet, table

import loads
from loads.motion import STANDARD_GRAVITY as G
from loads.readers import RawRecord, Request, Source, read
from loads.readers.units import acceleration_unit, split_heading
from masonry_cd.foundation.errors import InputError


def load(tmp_path: Path, text: str, name: str = "auto", **request: object) -> tuple[str, RawRecord]:
    file = tmp_path / "quake.dat"
    file.write_text(text)
    return read(Source.open(file, "loads[0].path: quake.dat"), name, Request(**request))


@pytest.mark.parametrize(
    ("text", "request_", "format_", "unit"),
    [
        (at2(), {}, "at2", "G"),
        (at2().replace("NPTS=  40, DT=   .01 SEC", "  40   .0100   NPTS, DT"), {}, "at2", "G"),
        (at2().replace(".01 SEC", ".01SEC,"), {}, "at2", "G"),
        (esm(), {}, "esm", "cm/s^2"),
        (table(), {"column": "ns"}, "csv", "m_s2"),
        (table(), {"column": "NS_m_s2"}, "csv", "m_s2"),
        (table(), {"column": 1}, "csv", "m_s2"),
        (table('"Time (s)";"NS [gal]";"UP [gal]"', ";").replace(".", ","), {"column": "ns"}, "csv", "gal"),
        (table("t\tNS (cm/s2)\tUP (cm/s2)", "\t"), {"column": "NS"}, "csv", "cm/s2"),
        (table(""), {"column": 1}, "csv", None),
        (columns(), {}, "columns", None),
        (columns("% a quake\n# time [s]  acc [g]\n\n"), {}, "columns", "g"),
        (columns("time_ms acc_gal\n", 1000 * TIME), {}, "columns", "gal"),
        ("".join(f"{v}\n" for v in WAVE), {"time_step": STEP}, "columns", None),
        ("acc_g\n" + "".join(f"{v}\n" for v in WAVE), {"time_step": STEP}, "columns", "g"),
    ],
)
def test_formats_are_recognised_by_content_and_read(tmp_path: Path, text: str, request_: dict, format_: str, unit: str | None) -> None:
    found, record = load(tmp_path, text, **request_)
    assert found == format_
    assert record.values == pytest.approx(WAVE, abs=1e-6)
    assert record.step == pytest.approx(STEP)
    assert record.unit == unit
    assert load(tmp_path, text, format_, **request_)[1].values == pytest.approx(record.values)


def test_a_time_column_that_starts_late_is_kept_as_the_record_s_own_time(tmp_path: Path) -> None:
    assert load(tmp_path, columns(time=TIME + 30.0))[1].origin == pytest.approx(30.0)


def test_times_written_with_few_digits_are_even(tmp_path: Path) -> None:
    _, record = load(tmp_path, columns(time=np.round(np.arange(40) / 128.0, 3)))
    assert record.step == pytest.approx(1.0 / 128.0, rel=2e-3)


@pytest.mark.parametrize(
    ("text", "size"),
    [
        *((unit, G) for unit in ("g", "G")), ("mg", 1e-3 * G), ("G/10", 0.1 * G), ("%g", 0.01 * G), ("g%", 0.01 * G), ("in/sec2", 0.0254),
        *((unit, 1.0) for unit in ("m/s2", "M/S^2", "m/s**2", "m/s/s", "m s-2")), ("mm/s2", 0.001),
        *((unit, 0.01) for unit in ("cm/s2", "cm/sec^2", "cm/s²", "Gal", "cm/s/s", "cm/seg2", "cm/sec/sec")),
        *((unit, None) for unit in ("yd/s2", "m/s", "count", "Gallons")),
    ],
)  # fmt: skip
def test_units(text: str, size: float | None) -> None:
    assert acceleration_unit(text) == (None if size is None else pytest.approx(size))


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("ns_m_s2", "ns", "m_s2"),
        ("acc [g]", "acc", "g"),
        ("NS(cm/s2)", "NS", "cm/s2"),
        ("time_s", "time", "s"),
        ("t", "t", None),
        ("vel_cm_s", "vel", "cm_s"),
        ("NS, cm/s", "NS", "cm/s"),
        ("disp_m", "disp", "m"),
        ("sensor g", "sensor g", None),
        ("mean", "mean", None),
    ],
)
def test_headings(heading: str, name: str, unit: str | None) -> None:
    assert split_heading(heading) == (name, unit)


@pytest.mark.parametrize(("ends", "name"), [("A STATION, 090", "090"), ("A STATION, UP", "UP"), ("NS COMPONENT", "NS"), ("A STATION", "")])
def test_the_second_line_of_peer_ends_with_the_component(tmp_path: Path, ends: str, name: str) -> None:
    assert load(tmp_path, at2().replace("05/19/40", f"05/19/40, {ends}"))[1].name == name


def test_exponents_of_fortran_are_numbers(tmp_path: Path) -> None:
    _, plain = load(tmp_path, at2())
    _, double = load(tmp_path, re.sub(r"(\.\d+)E([+-])", r"\1D\2", at2()))
    assert np.array_equal(double.values, plain.values) and double.step == plain.step


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_texts_of_spreadsheets_are_read_by_their_mark(tmp_path: Path, encoding: str) -> None:
    text = "time [s]\tacc [g]\n" + "".join(f"{t:.3f}\t{a:.6f}\n" for t, a in zip(TIME, WAVE, strict=True))
    (tmp_path / "record").write_bytes(text.encode(encoding))
    _, record = read(Source.open(tmp_path / "record", "path"), "auto", Request())
    assert record.values == pytest.approx(WAVE, abs=1e-6) and record.step == pytest.approx(STEP)


def load_network(folder: Path, text: str | bytes, **request: object) -> tuple[str, RawRecord]:
    file = folder / "quake.dat"
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return read(Source.open(file, "loads[0].path: quake.dat"), "auto", Request(**request))


def test_knet_counts_are_scaled_once(tmp_path: Path) -> None:
    name, record = load_network(tmp_path, knet())
    assert name == "knet"
    assert record.values == pytest.approx(COUNTS * 2000.0 / 8388608)
    assert (record.step, record.unit, record.name) == (pytest.approx(0.01), "gal", "N-S")


@pytest.fixture
def samples() -> Path:
    obspy = pytest.importorskip("obspy", reason="obspy, the optional extra records, is not installed")
    folder = Path(obspy.__path__[0]) / "io"
    if not (folder / "nied" / "tests" / "data" / "test.knet").is_file():
        pytest.skip("this obspy came without its sample files")
    return folder


def test_knet_agrees_with_obspy_and_with_the_peak_its_heading_announces(samples: Path) -> None:
    path = samples / "nied" / "tests" / "data" / "test.knet"
    _, record = read(Source.open(path, "p"), "auto", Request())
    trace = pytest.importorskip("obspy").read(str(path), format="KNET")[0]
    assert record.values == pytest.approx(100.0 * trace.stats.calib * trace.data, rel=1e-12)  # obspy's calib is in m/s2 per count
    assert abs(record.values - record.values.mean()).max() == pytest.approx(4.383, abs=5e-4)


def test_miniseed_counts_become_accelerations_by_the_given_calibration(samples: Path, tmp_path: Path) -> None:
    file = tmp_path / "steim2.mseed"
    file.write_bytes((samples / "mseed" / "tests" / "data" / "steim2.mseed").read_bytes())
    name, record = read(Source.open(file, "p"), "auto", Request())
    assert (name, record.name, record.step, len(record.values)) == ("mseed", "NL.HGN.00.BHZ", 0.025, 5980)
    table = {"kind": "record", "path": file.name, "direction": "z", "units": "cm/s2", "calibration": 1e-3}
    with refused_at("loads[0].quantity"):
        loads.build([table], 0.01, 100, (0.0, 0.0, -9.81), tmp_path)
    table["quantity"] = "acceleration"
    before = loads.build([table], 0.01, 100, (0.0, 0.0, -9.81), tmp_path).summary["tables"][0]["before"]
    assert before["pga"] == pytest.approx(1e-5 * abs(record.values).max())
    with refused_at("loads[0].units"):
        loads.build([{k: v for k, v in table.items() if k != "units"}], 0.01, 100, (0.0, 0.0, -9.81), tmp_path)


def test_a_channel_of_miniseed_is_picked_by_its_code(samples: Path) -> None:
    source = Source.open(samples / "mseed" / "tests" / "data" / "two_channels.mseed", "p")
    with pytest.raises(InputError, match=r"several channels; say which by the key column; channels: BW.UH3..EHE, BW.UH3..EHZ"):
        read(source, "auto", Request())
    with pytest.raises(InputError, match='no channel "HNN"'):
        read(source, "auto", Request("HNN"))
    assert read(source, "auto", Request("ehz"))[1].name == "BW.UH3..EHZ"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gaps.mseed", "a gap of 2.06 s in BW.BGLD..EHE at 2.055 s"),
        ("qualityflags.mseed", "an overlap of 2.06 s"),
        ("brokenlastrecord.mseed", "not readable as miniSEED"),
        ("corrupt_one_extra_byte_at_end.mseed", "not readable as miniSEED"),
    ],
)
def test_broken_miniseed_is_refused(samples: Path, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as failure:
        read(Source.open(samples / "mseed" / "tests" / "data" / name, "p"), "auto", Request())
    assert "\n" not in str(failure.value)


@pytest.mark.parametrize(
    ("name", "file", "channel", "step", "count", "peak"),
    [
        ("gse2", "gse2/tests/data/loc_RJOB20050831023349.z", ".RJOB..Z", 0.005, 12000, 103.0),
        ("evt", "kinemetrics/tests/data/BI008_MEMA-04823.evt", ".MEMA..0", 0.004, 5750, 0.0258849674),
        ("evt", "kinemetrics/tests/data/BX456_MOLA-02351.evt", ".MOLA..0", 0.004, 9750, None),
    ],
)
def test_other_archives_of_networks(samples: Path, name: str, file: str, channel: str, step: float, count: int, peak: float) -> None:
    """GSE holds counts, EVT its own calibration: m/s2 by 9.80665."""
    found, record = read(Source.open(samples / file, "p"), "auto", Request(column=0))
    assert (found, record.name, len(record.values), record.counts) == (name, channel, count, name != "evt")
    assert record.step == pytest.approx(step, rel=1e-6) and (record.unit == "m/s2") == (name == "evt")
    assert peak is None or abs(record.values).max() == pytest.approx(peak, rel=1e-8)


@pytest.mark.parametrize(
    "name", ["boa___00_07a.gse", "loc_RNON20040609200559.z", "sta2.gse2", "twiceCHK2.gse2", "loc_RJOB20050831023349.z"]
)
def test_samples_of_gse_are_those_of_obspy(samples: Path, name: str) -> None:
    from obspy import read as read_by_obspy

    source = Source.open(samples / "gse2" / "tests" / "data" / name, "p")
    for k, trace in enumerate(read_by_obspy(samples / "gse2" / "tests" / "data" / name)):
        record = read(source, "gse2", Request(column=k))[1]
        assert record.values.tolist() == trace.data.tolist() and record.step == pytest.approx(trace.stats.delta)


@pytest.mark.parametrize("name", ["broken_head.gse2", "loc_RJOB20050831023349.z.wrong_chksum"])
def test_broken_gse_is_refused_by_its_line(samples: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"p[,:]"):
        read(Source.open(samples / "gse2" / "tests" / "data" / name, "p"), "gse2", Request())


def test_lines_to_skip_keep_their_numbers(tmp_path: Path) -> None:
    """Lines above a record are skipped; a fault below is named by the line of the whole file."""
    (tmp_path / "a.AT2").write_text("Downloaded\nyesterday\n" + at2(), encoding="utf-8")
    assert read(Source.open(tmp_path / "a.AT2", "p", skip=2), "auto", Request())[0] == "at2"
    (tmp_path / "b.AT2").write_text("Downloaded\nyesterday\n" + at2(count="45"), encoding="utf-8")
    with refused_at("p, line 6"):
        read(Source.open(tmp_path / "b.AT2", "p", skip=2), "auto", Request())
    for path, skip in ((tmp_path / "a.AT2", 100), (tmp_path / "c.bin", 1)):
        (tmp_path / "c.bin").write_bytes(b"000001D " + bytes(504))
        with refused_at("p"):
            Source.open(path, "p", skip=skip)


def test_without_obspy_miniseed_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "obspy", None)
    with pytest.raises(InputError, match=r'miniSEED needs obspy, which is not installed: pip install "masonry-cd\[records\]"'):
        load_network(tmp_path, b"000001D " + bytes(504))
