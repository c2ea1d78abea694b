# SPDX-License-Identifier: GPL-3.0-or-later
"""Record files of each format, as text: 40 samples of one wave."""

from __future__ import annotations

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
