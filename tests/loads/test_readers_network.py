# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of seismic networks: K-NET and miniSEED against obspy's own samples, the calibration applied once, bad files named."""

from __future__ import annotations

from pathlib import Path

import pytest
from hostile import refused_at
from records import COUNTS, knet

import loads
from loads.readers import RawRecord, Request, Source, read
from masonry_cd.foundation.errors import InputError


def load(folder: Path, text: str | bytes, **request: object) -> tuple[str, RawRecord]:
    file = folder / "quake.dat"
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return read(Source.open(file, "loads[0].path: quake.dat"), "auto", Request(**request))


def test_knet_counts_are_scaled_once(tmp_path: Path) -> None:
    name, record = load(tmp_path, knet())
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


def test_without_obspy_miniseed_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "obspy", None)
    with pytest.raises(InputError, match=r'miniSEED needs obspy, which is not installed: pip install "masonry-cd\[records\]"'):
        load(tmp_path, b"000001D " + bytes(504))
