# SPDX-License-Identifier: GPL-3.0-or-later
"""Formats of networks: peak, sampling and component of synthetic files of the published layouts; what contradicts itself is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import record_files as files
from command_line import done, masonry_cd
from hostile import refused_at

from loads.picture import file_picture
from loads.readers import READERS, RawRecord, Request, Source, formats, read
from masonry_cd.foundation.errors import InputError

PEAK = float(np.abs(files.WAVE).max())
G = 9.80665
VOLUME = {"usc": ("FILE     1 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:", "COMP  UP          9", "UP"),
          "renadic": ("RENADIC", "COMP NS", "NS"),
          "csmip": ("UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 02/08/94", "CHAN  1:  90 DEG", "90"),
          "bhrc": ("* VOL1DS FILE:  5528/01", "COMP L1", "L1")}  # fmt: skip
FILES: list[tuple[str, str | bytes, str, dict[str, Any], float]] = [
    ("cosmos", files.cosmos(), "340", {}, 1.0),
    ("cosmos", files.cosmos(azimuth=400, unit="g", code=2, values=0.1 * files.WAVE), "Up", {}, 0.1 * G),
    ("cosmos", files.cosmos() + files.cosmos(azimuth=70), "70", {"column": "70"}, 1.0),
    ("csmip", files.csmip2(), "360", {}, 1.0),
    ("csmip", files.csmip2() + files.csmip2("Up", 50.0), "Up", {"column": "up"}, 0.5),
    ("csmip", files.csmip1(), "360", {}, 0.1 * G),
    ("geonet", files.geonet(), "S90E", {"column": "S90E"}, 1.0),
    ("geonet", files.geonet(), "Up", {"column": 1}, 0.5),
    ("smc", files.smc(), "133", {}, 1.0),
    ("smc", files.smc(precise=True), "133", {}, 1.0),
    ("afad", files.afad(), "E-W", {"column": "E-W"}, 0.5),
    ("unam", files.unam(), "N00E", {"column": "n00e"}, 1.0),
    ("cwb", files.cwb(), "E", {"column": "E"}, 0.5),
    ("sac", files.sac("<"), "HNE", {"units": "m/s2"}, 1.0),
    ("sac", files.sac(">"), "HNE", {"units": "m/s2"}, 1.0),
    ("sac", files.sac(scale=2.0), "HNE", {"units": "m/s2", "calibration": 2.0}, 2.0),
    ("esm", files.itaca(), "NS", {}, 1.0),
    ("counted", files.counted(), "", {"units": "m/s2"}, 1.0),
    ("counted", files.counted(f"NPTS {files.COUNT}  200 Hz  cm/s2"), "", {}, 0.01),
    *((name, files.volume(first, line, name != "bhrc", " " if name == "usc" else ""), component, {}, 0.1 * G)
      for name, (first, line, component) in VOLUME.items()),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "component", "keys", "pga"), FILES, ids=[f"{k}-{row[0]}" for k, row in enumerate(FILES)])
def test_peak_sampling_and_component(
    tmp_path: Path, name: str, content: str | bytes, component: str, keys: dict[str, Any], pga: float
) -> None:
    (tmp_path / "quake.dat").write_bytes(content.encode() if isinstance(content, str) else content)
    found = file_picture(tmp_path / "quake.dat", None, correction="none", **keys)
    assert (found.format, found.column, len(found.before.acceleration)) == (name, component, files.COUNT)
    assert found.before.step == pytest.approx(files.STEP, rel=1e-6)
    assert found.before.numbers()["pga"] == pytest.approx(pga * PEAK, rel=1e-3)


def load(folder: Path, content: str | bytes, **request: Any) -> RawRecord:
    (folder / "quake.dat").write_bytes(content.encode() if isinstance(content, str) else content)
    return read(Source.open(folder / "quake.dat", "p"), "auto", Request(**request))[1]


def cut(text: str, lines: int) -> str:
    return "\n".join(text.splitlines()[:lines])


def test_a_velocity_is_refused_and_differentiated_where_asked_for(tmp_path: Path) -> None:
    (tmp_path / "quake.smc").write_text(files.smc("3 VELOCITY"))
    with refused_at("record.quantity"):
        file_picture(tmp_path / "quake.smc", None)
    found = file_picture(tmp_path / "quake.smc", None, quantity="velocity", correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(2.0 * np.pi * 3.0, rel=0.05)  # of a sine, at its start


def test_film_read_at_uneven_times_is_interpolated_and_reported(tmp_path: Path) -> None:
    first, line, _ = VOLUME["usc"]
    uneven = files.TIME + np.where(np.arange(files.COUNT) > 50, 0.008, 0.0)
    (tmp_path / "film.v1").write_text(files.volume(first, line, times=uneven))
    found = file_picture(tmp_path / "film.v1", None, correction="none")
    assert found.before.step == pytest.approx(files.STEP)
    assert found.before.duration == pytest.approx(uneven[-1], abs=files.STEP)
    assert "uneven times, 0.005 to 0.013 s apart: interpolated" in found.notes[0]


def test_counts_of_cosmos_need_a_calibration(tmp_path: Path) -> None:
    text = files.cosmos(unit="counts", code=50, values=np.round(1000.0 * files.WAVE))
    (tmp_path / "quake.v0").write_text(text)
    with refused_at("record.units"):
        file_picture(tmp_path / "quake.v0", None)
    with refused_at("record.calibration"):
        file_picture(tmp_path / "quake.v0", None, units="m/s2")
    found = file_picture(tmp_path / "quake.v0", None, units="m/s2", calibration=1e-3, correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(PEAK, rel=1e-3)


def test_each_file_is_recognised_by_one_strict_format(tmp_path: Path) -> None:
    for name, content, *_ in FILES:
        (tmp_path / "quake.dat").write_bytes(content.encode() if isinstance(content, str) else content)
        source = Source.open(tmp_path / "quake.dat", "p")
        strict = [format_ for format_, reader in READERS.items() if not reader.loose and reader.recognises(source)]
        assert strict == [] if name == "counted" else strict == [name], content[:60]


@pytest.mark.parametrize("heading", ["Tempo [s];Accelerazione [cm/s2]", "Tiempo (seg);Aceleración (cm/seg2)", "tiempo_s;aceleracion_cm_s2"])
def test_headings_in_italian_and_spanish(tmp_path: Path, heading: str) -> None:
    body = "".join(f"{t:.3f};{100.0 * v:.6f}\n" for t, v in zip(files.TIME, files.WAVE, strict=True)).replace(".", ",")
    (tmp_path / "onda.csv").write_text(f"{heading}\n{body}", encoding="utf-8")
    found = file_picture(tmp_path / "onda.csv", None, correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(PEAK, rel=1e-5)


def test_decimal_commas_between_blanks(tmp_path: Path) -> None:
    body = "".join(f"{t:.3f}  {v:.6f}\n" for t, v in zip(files.TIME, files.WAVE, strict=True)).replace(".", ",")
    (tmp_path / "onda.txt").write_text(body)
    found = file_picture(tmp_path / "onda.txt", None, units="m/s2", correction="none")
    assert found.before.numbers()["pga"] == pytest.approx(PEAK, rel=1e-5)
    with pytest.raises(InputError, match=r"0,0[0-9]+ is one number with a decimal comma, or two of a CSV file"):
        load(tmp_path, "\n".join(f"{v:.4f}" for v in files.WAVE).replace(".", ","), time_step=0.01)


def test_formats_are_listed_with_what_is_read_and_who_publishes_them() -> None:
    assert all(about and by for _, about, by in formats())
    shown = done("record", "--formats")
    assert [line.split()[0] for line in shown.output.splitlines()] == sorted(READERS)
    assert masonry_cd("record").exit_code == 2


def test_times_of_film_in_smc(tmp_path: Path) -> None:
    """The rate is unknown: values stand behind their times, which are uneven; what was done to them is said."""
    record = load(tmp_path, files.film())
    assert record.name == "133" and len(record.notes) == 3
    times = record.origin + record.step * np.arange(len(record.values))
    assert record.values == pytest.approx(100.0 * np.interp(times, files.TIME, files.WAVE), abs=0.1 * 100.0 * PEAK)


def test_rows_behind_those_announced_and_text_below_the_rule_of_unam(tmp_path: Path) -> None:
    last = files.unam().splitlines()[-1]
    text = files.unam() + last + "\n" + last + "\n"
    record = load(tmp_path, text, column="N00E")
    assert (len(record.values), len(record.notes)) == (files.COUNT, 1)
    lines = files.unam().splitlines()
    below = next(k for k in range(len(lines) - 1, 0, -1) if lines[k].startswith("---")) + 1
    text = "\n".join([*lines[:below], "   (Gal)     (Gal)     (Gal)", *lines[below:], ""])
    assert len(load(tmp_path, text, column="N00E").values) == files.COUNT


def test_fields_of_csmip_by_the_length_of_a_line(tmp_path: Path) -> None:
    """No format is given; the values touch."""
    text = files.csmip2().replace("(8f10.6)", "")
    assert load(tmp_path, text).values == pytest.approx(load(tmp_path, files.csmip2()).values)


def test_the_first_of_several_series_below_headings_that_count_them(tmp_path: Path) -> None:
    head = f"A PLACE\nSAMPLES/SEC=100 DATA TYPE=AC\nNO OF POINTS=  {files.COUNT}, UNITS=CM/SEC**2, CM/SEC, AND CM\n"
    one = head + "\n".join(files.rows(files.WAVE, 8, "{:9.5f}")) + "\n"
    record = load(tmp_path, one + one.replace("AC", "VL"))
    assert (record.step, record.unit, len(record.values), len(record.notes)) == (0.01, None, files.COUNT, 1)


def test_an_interval_of_nothing_is_refused_with_its_place_in_the_header(tmp_path: Path) -> None:
    text = files.cosmos().replace(f"{1e3 * files.STEP:13.6f}", f"{0.0:13.6f}")
    (tmp_path / "quake.v1").write_text(text)
    with pytest.raises(InputError, match="real-header value 62"):
        read(Source.open(tmp_path / "quake.v1", "p"), "cosmos", Request())
