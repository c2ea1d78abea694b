# SPDX-License-Identifier: GPL-3.0-or-later
"""Record files of each format, as text: 40 samples of one wave; and a folder of motions to choose from."""

from __future__ import annotations

from pathlib import Path

import numpy as np

STEP = 0.01
WAVE = np.round(np.sin(np.linspace(0.0, 12.0, 40)), 6)
TIME = STEP * np.arange(len(WAVE))


def at2(values: np.ndarray = WAVE, count: str = "40", step: str = ".01", unit: str = "G", what: str = "ACCELERATION TIME SERIES") -> str:
    rows = [" ".join(f"{v: .7E}" for v in values[i : i + 5]) for i in range(0, len(values), 5)]
    return (
        "\n".join(["PEER DATABASE", "A, QUAKE, 05/19/40", f"{what} IN UNITS OF {unit}", f"NPTS=  {count}, DT=   {step} SEC", *rows]) + "\n"
    )


def esm(values: np.ndarray = WAVE, **change: str) -> str:
    heading = {
        "EVENT_NAME": "A QUAKE",
        "SAMPLING_INTERVAL_S": "0.010000",
        "NDATA": "40",
        "STREAM": "HNN",
        "UNITS": "cm/s^2",
        "DATA_TYPE": "ACCELERATION",
    }
    lines = [f"{key}: {value}" for key, value in (heading | change).items()]
    return "\n".join([*lines, "USER1: ", *(f"{v:.6f}" for v in values)]) + "\n"


def table(heading: str = "time_s,ns_m_s2,up_m_s2", delimiter: str = ",") -> str:
    rows = [delimiter.join(f"{x:.6g}" for x in row) for row in zip(TIME, WAVE, 0.5 * WAVE, strict=True)]
    return "\n".join([heading, *rows] if heading else rows) + "\n"


def columns(comment: str = "# synthetic\n", time: np.ndarray = TIME) -> str:
    return comment + "".join(f" {t:.8g}   {v:.6f}\n" for t, v in zip(time, WAVE, strict=True))


COUNTS = np.round(1000.0 * np.sin(np.linspace(0.0, 9.0, 40))).astype(int) - 500
HEADING = {
    "Origin Time": "1996/08/11 03:12:00",
    "Station Code": "AKT013",
    "Record Time": "1996/08/11 03:12:39",
    "Sampling Freq(Hz)": "100Hz",
    "Duration Time(s)": "0.4",
    "Dir.": "N-S",
    "Scale Factor": "2000(gal)/8388608",
    "Max. Acc. (gal)": "0.3",
    "Memo.": "",
}


def knet(**change: str | None) -> str:
    heading = [f"{key:18}{value}".rstrip() for key, value in (HEADING | change).items() if value is not None]
    return "\n".join([*heading, *("".join(f"{c:9d}" for c in COUNTS[i : i + 8]) for i in range(0, 40, 8))]) + "\n"


def wrapped(values: np.ndarray, width: int, between: str = "  ") -> str:
    return "".join(between.join(f"{v:.6f}" for v in values[i : i + width]) + "\n" for i in range(0, len(values), width))


def side_by_side(*columns: np.ndarray, between: str = "  ") -> str:
    return "".join(between.join(f"{v:.6f}" for v in row) + "\n" for row in zip(*columns, strict=True))


def suite_motion(k: int, step: float = 0.01, duration: float = 4.0) -> np.ndarray:
    """Noise under an envelope, unlike that of other numbers, its spectrum highest at another period [m/s2]."""
    random, times = np.random.default_rng(k), step * np.arange(round(duration / step))
    rates = 0.7 * 20.0 ** random.random(30)  # [Hz]
    sines = [min(1.0, f / 2.0) * random.uniform(0.5, 1.5) * np.sin(2.0 * np.pi * f * times + random.uniform(0.0, 6.3)) for f in rates]
    return np.round(0.35 * np.sum(sines, axis=0) * np.sin(np.pi * times / duration) ** 2, 6)


def write_suite(folder: Path, count: int = 12) -> None:
    """Motions m00_NS.acc, m00_EW.acc, m01_NS.acc ... of one column, and a catalogue of them, records.csv."""
    folder.mkdir(parents=True)
    rows = ["motion,event,magnitude,distance_km"]
    for k in range(count):
        for i, component in enumerate(("NS", "EW")):
            (folder / f"m{k:02d}_{component}.acc").write_text("".join(f"{a:.6f}\n" for a in suite_motion(2 * k + i)))
        rows.append(f"m{k:02d},event{k // 2},{5.5 + 0.1 * k:.1f},{5 + 3 * k}")
    (folder / "records.csv").write_text("\n".join(rows) + "\n")
