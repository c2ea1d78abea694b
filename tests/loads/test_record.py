# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.record: a base velocity that starts and ends at rest, in true units, on the run's times; and its picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from pictures import main_colours
from places import SHARED

import loads
from loads.motion import STANDARD_GRAVITY
from loads.picture import AFTER, BEFORE, file_picture, thin_curve
from loads.signal.baseline import integrate
from masonry_cd.foundation.errors import InputError

RECORDS = SHARED / "records"
STEP = 0.01
TIME = STEP * np.arange(1001)
WAVE = 2.0 * np.sin(np.pi * TIME / 10.0) ** 2 * np.sin(2 * np.pi * 1.3 * TIME) + 0.03  # [m/s2], with an offset that drifts


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "quake.txt").write_text("# t [s]  a [m/s2]\n" + "".join(f"{t:.2f} {a:.12g}\n" for t, a in zip(TIME, WAVE, strict=True)))
    return tmp_path


def build(folder: Path, dt: float = 1e-3, seconds: float = 12.0, **keys: object) -> loads.Loading:
    table = {"kind": "record", "path": "quake.txt", "direction": "x", **keys}
    return loads.build([table], dt, round(seconds / dt), (0.0, 0.0, -9.81), folder)


def velocity(folder: Path, **keys: object) -> np.ndarray:
    return build(folder, **keys).support_velocity[:, 0, 0]


def numbers(loading: loads.Loading, when: str = "after") -> dict[str, float]:
    return loading.summary["tables"][0][when]


@pytest.mark.parametrize("correction", ["linear", "quadratic", "cubic"])
def test_a_corrected_record_starts_and_ends_at_rest_where_it_began(folder: Path, correction: str) -> None:
    loading = build(folder, correction=correction)
    v = loading.support_velocity[:, 0, 0]
    assert v[0] == 0.0
    assert abs(v[10001:]).max() < 1e-12
    assert abs(np.trapezoid(v, dx=1e-3)) < 1e-6
    assert abs(numbers(loading, "before")["end_displacement"]) > 1.0
    assert abs(numbers(loading)["end_displacement"]) < 1e-10
    assert "before correction" in loading.lines[1]
    assert f"{correction} correction:" in loading.lines[2]


def test_uncorrected_velocity_is_the_exact_integral_and_fades_out_without_a_jump(folder: Path) -> None:
    loading = build(folder, correction="none")
    v = loading.support_velocity[:, 0, 0]
    assert v[:10001:10] == pytest.approx(integrate(WAVE, STEP).velocity, abs=1e-9)
    assert abs(v[10000]) > 0.2
    assert abs(np.diff(v)).max() < 1.05 * abs(WAVE).max() * 1e-3
    assert (v[11000:] == 0.0).all()
    said = next(line for line in loading.lines if "brought to zero" in line)
    assert float(said.rsplit("end displacement", 1)[1].split()[0]) == pytest.approx(np.trapezoid(v, dx=1e-3), rel=1e-3)


def test_steps_coarser_or_odd_sample_the_same_motion(folder: Path) -> None:
    fine = velocity(folder, dt=1e-3)
    assert velocity(folder, dt=4e-3) == pytest.approx(fine[::4], abs=1e-12)
    coarse = build(folder, dt=0.02)
    assert coarse.support_velocity[:, 0, 0] == pytest.approx(fine[::20], abs=1e-12)
    assert any("run.dt 0.02 s is coarser than the record's 0.01 s: what it holds above 25 Hz is lost" in line for line in coarse.lines)
    assert not any("coarser" in line for line in build(folder).lines)


def test_scale_and_target_pga(folder: Path) -> None:
    once = velocity(folder)
    assert velocity(folder, scale=-2.5) == pytest.approx(-2.5 * once, abs=1e-12)
    loading = build(folder, target_pga=1.5)
    assert numbers(loading)["pga"] == pytest.approx(1.5)
    assert numbers(build(folder))["pga"] / numbers(build(folder))["pgv"] == pytest.approx(1.5 / numbers(loading)["pgv"])


def test_start_shifts_the_record_in_the_run(folder: Path) -> None:
    late = velocity(folder, start=1.5)
    assert not late[:1501].any()
    assert late[1500:] == pytest.approx(velocity(folder)[:10501], abs=1e-12)


def test_window_is_in_the_record_s_own_time(folder: Path) -> None:
    loading = build(folder, window=[2.0, 6.0], correction="none")
    v = loading.support_velocity[:, 0, 0]
    assert v[:4001:10] == pytest.approx(integrate(WAVE[200:601], STEP).velocity, abs=1e-9)
    assert loading.summary["tables"][0]["window"] == pytest.approx([2.0, 6.0])
    assert (velocity(folder, window=[0.0, 10.01]) == velocity(folder)).all()  # 1001 samples may be called 10.01 s long


def test_taper_brings_the_cut_in_smoothly(folder: Path) -> None:
    sharp, soft = (np.diff(velocity(folder, window=[2.1, 6.3], taper=taper))[:20] / 1e-3 for taper in (0.0, 0.5))
    assert abs(sharp[0]) > 0.5
    assert abs(soft[0]) < 0.1


def test_units_of_header_and_key_mean_the_same_motion(folder: Path) -> None:
    rows = "".join(f"{t:.2f} {a / STANDARD_GRAVITY:.12g}\n" for t, a in zip(TIME, WAVE, strict=True))
    (folder / "bare.txt").write_text(rows)
    (folder / "headed.txt").write_text("t a_g\n" + rows)
    wanted = velocity(folder)
    assert velocity(folder, path="bare.txt", units="g") == pytest.approx(wanted, abs=1e-8)
    assert velocity(folder, path="headed.txt") == pytest.approx(wanted, abs=1e-8)
    assert velocity(folder, path="headed.txt", units="G") == pytest.approx(wanted, abs=1e-8)
    with refused_at("loads[0].units"):
        build(folder, path="headed.txt", units="m/s2")
    (folder / "counts.txt").write_text("t a[counts]\n" + rows)
    with refused_at("loads[0].units"):
        build(folder, path="counts.txt")


@pytest.mark.parametrize("keys", [{}, {"correction": "none"}, {"target_pga": 2.0}])
@pytest.mark.parametrize(("value", "said"), [(0.0, "zero"), (0.1, "constant")])
def test_a_record_that_never_changes_is_refused(folder: Path, value: float, said: str, keys: dict[str, object]) -> None:
    (folder / "level.txt").write_text("t a_g\n" + "".join(f"{t:.2f} {value}\n" for t in TIME))
    with pytest.raises(InputError, match=f"level.txt: the record is {said} throughout"):
        build(folder, path="level.txt", **keys)


def recorded(tables: list[dict], seconds: float, dt: float = 1e-3) -> loads.Loading:
    if not RECORDS.is_dir():
        pytest.skip("no recorded accelerograms next to the checkout")
    return loads.build([{"kind": "record", **table} for table in tables], dt, round(seconds / dt), (0.0, 0.0, -9.81), RECORDS)


def test_el_centro_has_its_known_peak() -> None:
    loading = recorded([{"path": "elcentro_1940_NS.AT2", "direction": "x"}], 40.0)
    assert loading.summary["tables"][0]["format"] == "at2"
    assert numbers(loading, "before")["pga"] == pytest.approx(0.319 * STANDARD_GRAVITY, rel=1e-3)
    assert abs(loading.support_velocity[-1]).max() < 1e-12


def test_l_aquila_reads_alike_from_both_formats_and_in_three_components() -> None:
    three = [{"path": "laquila_2009_AQV.csv", "column": c, "direction": d} for c, d in (("ns", "x"), ("we", "y"), ("up", "z"))]
    csv = recorded(three, 46.0)
    ascii_ = recorded([{"path": f"laquila_2009_AQV_{c}.asc", "direction": d} for c, d in (("NS", "x"), ("WE", "y"), ("UP", "z"))], 46.0)
    assert numbers(csv, "before")["pga"] == pytest.approx(5.366, abs=1e-3)
    assert csv.support_velocity == pytest.approx(ascii_.support_velocity, abs=1e-6)
    assert np.ptp(csv.support_velocity, axis=0).min() > 0.2  # all three components shake


def test_rotating_a_pair_keeps_its_length_and_turns_its_direction(folder: Path) -> None:
    rows = "".join(f"{t:.2f} {a:.12g} {0.5 * np.sin(3.0 * t):.12g}\n" for t, a in zip(TIME, WAVE, strict=True))
    (folder / "pair.txt").write_text("t a_m_s2 b_m_s2\n" + rows)

    def pair(angle: float) -> np.ndarray:
        tables = [{"kind": "record", "path": "pair.txt", "column": c, "direction": d, "rotate": angle} for c, d in (("a", "x"), ("b", "y"))]
        return loads.build(tables, 1e-3, 12000, (0.0, 0.0, -9.81), folder).support_velocity[:, 0]

    straight, turned = pair(0.0), pair(30.0)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    assert turned[:, 0] == pytest.approx(c * straight[:, 0] - s * straight[:, 1], abs=1e-12)
    assert turned[:, 1] == pytest.approx(s * straight[:, 0] + c * straight[:, 1], abs=1e-12)
    assert np.linalg.norm(turned, axis=1) == pytest.approx(np.linalg.norm(straight, axis=1), abs=1e-12)
    assert pair(90.0)[:, 1] == pytest.approx(straight[:, 0], abs=1e-12)


def test_band_pass_and_resampling_leave_what_lies_inside_the_band(folder: Path) -> None:
    plain = velocity(folder)
    kept = build(folder, band=[0.05, 25.0], resample=0.005)
    assert kept.summary["tables"][0]["time_step"] == 0.005
    assert kept.support_velocity[:, 0, 0] == pytest.approx(plain, abs=0.02 * abs(plain).max())
    gone = velocity(folder, band=[4.0, 25.0])  # the wave is one of 1.3 Hz
    assert abs(gone).max() < 0.01 * abs(plain).max()
    coarse = build(folder, dt=0.02, resample="run")
    assert coarse.summary["tables"][0]["time_step"] == 0.02
    assert not any("coarser" in line for line in coarse.lines)


def test_an_offset_of_the_instrument_does_not_survive_taper_and_correction(folder: Path) -> None:
    (folder / "offset.txt").write_text(
        "# t [s]  a [m/s2]\n" + "".join(f"{t:.2f} {a + 5.0:.12g}\n" for t, a in zip(TIME, WAVE, strict=True))
    )
    keys: dict = {"taper": 1.0, "band": [0.2, 20.0]}
    assert velocity(folder, path="offset.txt", **keys) == pytest.approx(velocity(folder, **keys), abs=1e-9)


def test_intensity_is_reported(folder: Path) -> None:
    loading = build(folder, scale=2.0)
    assert numbers(loading)["arias"] == pytest.approx(4.0 * numbers(build(folder))["arias"])
    assert 1.0 < numbers(loading)["significant_duration"] < 9.0
    assert any("Arias intensity" in line and "significant duration" in line for line in loading.lines)


TIME_PICTURE = 0.01 * np.arange(1001)
WAVE_PICTURE = 2.0 * np.sin(np.pi * TIME_PICTURE / 10.0) ** 2 * np.sin(2 * np.pi * 1.3 * TIME_PICTURE)


@pytest.fixture
def quake(tmp_path: Path) -> Path:
    file = tmp_path / "quake.txt"
    file.write_text("t a_m_s2\n" + "".join(f"{t:.2f} {a + 0.5:.9g}\n" for t, a in zip(TIME_PICTURE, WAVE_PICTURE, strict=True)))
    return file


def test_a_file_is_drawn_and_its_numbers_returned(quake: Path) -> None:
    picture = quake.with_name("quake.png")
    processed = file_picture(quake, picture, band=[0.1, 25.0], taper=0.5)
    assert {BEFORE, AFTER} <= main_colours(picture)
    numbers = processed.numbers()
    assert numbers["before"]["pga"] == pytest.approx(abs(WAVE_PICTURE + 0.5).max(), rel=1e-6)
    assert numbers["after"]["pga"] == pytest.approx(abs(WAVE_PICTURE).max(), rel=0.02)
    assert abs(numbers["after"]["end_displacement"]) < 1e-12


def test_long_curves_keep_their_peaks_when_thinned() -> None:
    values = np.zeros(300_000)
    values[[77_777, 123_456]] = 3.0, -4.0
    times, drawn = thin_curve(np.arange(300_000.0), values)
    assert len(drawn) <= 20_000
    assert (drawn.max(), drawn.min()) == (3.0, -4.0)
    assert (np.diff(times) >= 0.0).all()


def test_bad_keys_and_places_are_named(quake: Path) -> None:
    with refused_at("record.windw"):
        file_picture(quake, quake.with_name("p.png"), windw=[0, 1])
    with refused_at("no/p.png"):
        file_picture(quake, quake.parent / "no" / "p.png")
    with refused_at("p.tiffany"):
        file_picture(quake, quake.with_name("p.tiffany"))
