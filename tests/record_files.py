# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthetic files of the networks' formats, each of one wave: as the layouts are published, without any of their data."""

from __future__ import annotations

import numpy as np

COUNT, STEP = 103, 0.005  # the last lines are not full
TIME = STEP * np.arange(COUNT)
WAVE = np.sin(2.0 * np.pi * 3.0 * TIME) * np.exp(-4.0 * TIME)  # its first peak, the largest, is the PGA of all files
SECOND = -0.5 * WAVE


def rows(values: np.ndarray, each: int, form: str) -> list[str]:
    """Numbers in fields, some a line."""
    return ["".join(form.format(v) for v in values[k : k + each]) for k in range(0, len(values), each)]


def cosmos(
    values: np.ndarray = 100.0 * WAVE, unit: str = "cm/sec2", code: int = 4, what: str = "acceleration", kind: int = 1, azimuth: int = 340
) -> str:
    integers, reals = np.full(100, -999), np.full(100, -999.0)
    integers[[1, 2, 53]] = kind, code, azimuth
    reals[61] = 1e3 * STEP
    head = ["Corrected acceleration    (Format v01.20 with 13 text lines) Src: made", *[f"text {k}" for k in range(12)]]
    return "\n".join([
        *head, " 100 Integer-header values follow on  10 lines, Format= (10I8)", *rows(integers, 10, "{:8d}"),
        " 100 Real-header values follow on  17 lines, Format= (6F13.6)", *rows(reals, 6, "{:13.6f}"),
        '  1 Comment line(s) follow, each starting with a "|":', "| made",
        f"  {len(values)}  {what} pts, approx    1 secs, units={unit}({code:02d}),Format=(8F10.5)", *rows(values, 8, "{:10.5f}"),
        "End-of-data for Chan  1 acceleration", "",
    ])  # fmt: skip


def csmip2(name: str = "360 Deg", factor: float = 100.0) -> str:
    text = [f"Corrected accelerogram   58667       Chan  1: {name}         from", "Uncorrected Accelerogram Data      Processed: 08/24/14",
            *[f"text {k}" for k in range(23)]]  # fmt: skip
    series = []
    for what, unit in (("accel", "cm/sec2"), ("veloc", "cm/sec"), ("displ", "cm")):
        scale = factor if what == "accel" else 1e4
        series += [
            f"  {COUNT} points of {what} data equally spaced at  {STEP:.3f} sec, in {unit}. (8f10.6)",
            *rows(scale * WAVE, 8, "{:10.6f}"),
        ]
    return "\n".join(
        [*text, *rows(np.zeros(100, int), 16, "{:5d}"), *rows(np.zeros(100), 8, "{:10.6f}"), *series, "/&  ----------  End of data", ""]
    )


def csmip1() -> str:
    text = [
        "Uncorrected Accelerogram Data             Processed: 02/13/12, CGS",
        *[f"text {k}" for k in range(5)],
        "Chan  1: 360 Deg",
        *["text"] * 6,
    ]
    headers = [*rows(np.zeros(100, int), 16, "{:5d}"), *rows(np.zeros(50), 8, "{:10.6f}")]
    return "\n".join(
        [
            *text,
            *headers,
            f" {COUNT} Accelerogram points at 200 pts/sec in units of g .      Format: (8f9.6)",
            *rows(0.1 * WAVE, 8, "{:9.6f}"),
            "",
        ]
    )


def volume(first: str, component: str, pairs: bool = True, lead: str = "", times: np.ndarray = TIME) -> str:
    """Volume 1: (time, value) pairs, or values alone in E13.6."""
    text = [first, *["text"] * 5, component, *["UNIVERSIDAD DE CHILE - RENADIC" if "RENADIC" in first else "text"] * 3,
            f"NO. OF POINTS = {COUNT:6d}   DURATION = {times[-1]:7.3f} SEC", "UNITS ARE SEC AND G/10", "RMS"]  # fmt: skip
    headers = [*rows(np.zeros(100, int), 16, "{:5d}"), *rows(np.zeros(50), 8, "{:10.3f}")]
    wave = np.interp(times, TIME, WAVE)
    body = rows(np.column_stack([times, wave]).ravel(), 10, "{:7.3f}") if pairs else rows(wave, 10, "{:13.6E}")
    return "\n".join([*text, *headers, *(lead + line for line in body), ""])


def geonet() -> str:
    text = []
    for name, wave in (("S90E", WAVE), ("Up", SECOND)):
        integers, reals = np.zeros(40, int), np.zeros(60)
        integers[33:36], reals[25] = (COUNT, COUNT, 7), STEP
        lines = ["Corrected accelerogram 20161113_110256_XXX_20 GNS Science", *["text"] * 11, f"Component {name}", *["text"] * 3]
        text += [*lines, *rows(integers, 10, "{:8d}"), *rows(reals, 10, "{:8.4f}"), *rows(1000.0 * wave, 10, "{:8.1f}"),
                 *rows(9.0 + wave, 10, "{:8.2f}"), *rows(np.ones(7), 10, "{:8.2f}")]  # fmt: skip
    return "\n".join(text) + "\n"


def smc(first: str = "2 CORRECTED ACCELEROGRAM", precise: bool = False) -> str:
    integers, reals = np.full(48, -32768), np.full(50, 1.7e38)
    integers[15], integers[16], reals[1] = 2, COUNT, 1.0 / STEP
    text = [first, *["*"] * 4, "station = A place                        component=    133", *["*"] * 5]
    number = (lambda v: f"{v:14.7E}") if precise else (lambda v: f"{v:9.4E}".replace("E+0", "E+").replace("E-0", "E-").rjust(10))
    each = 5 if precise else 8
    body = ["".join(map(number, (100.0 * WAVE)[k : k + each])) for k in range(0, COUNT, each)]
    return "\n".join([*text, *rows(integers, 8, "{:10d}"), *rows(reals, 5, "{:15.7E}"), "| made", "|", *body, ""])


def film() -> str:
    """SMC of values at uneven times, one of which repeats, and a line left behind them."""
    integers, reals = np.full(48, -32768), np.full(50, 1.7e38)
    integers[15], integers[16] = 0, 2 * COUNT + 2
    times = np.insert(np.round(TIME + 0.2 * STEP * np.sin(np.arange(COUNT)), 4), 7, 0.0)
    times[7] = times[6]
    pairs = np.column_stack([times, 100.0 * np.insert(WAVE, 7, WAVE[6])]).ravel()
    head = ["1 UNCORRECTED ACCELEROGRAM", *["*"] * 4, "station = A place                        component=    133", *["*"] * 5]
    return "\n".join([*head, *rows(integers, 8, "{:10d}"), *rows(reals, 5, "{:15.7E}"), *rows(pairs, 5, "{:14.7E}"), " 0.0 0.0", ""])


def afad() -> str:
    heading = ["STRONG GROUND MOTION RECORDS OF TURKIYE", "PLACE                   : K\u00fctahya",
               "STATION ID              : 4304", f"NUMBER OF DATA          : {COUNT}",
               f"SAMPLING INTERVAL (sec) : {STEP}", "RAW PGA VALUES (gal)    : (N-S) 1.2 (E-W) 1.2 (U-D) 0.6",
               "       N-S          E-W          U-D"]  # fmt: skip
    return "\n".join([*heading, *rows(np.column_stack([100.0 * WAVE, 100.0 * SECOND, WAVE]).ravel(), 3, "{:13.6f}"), ""])


def unam() -> str:
    rule = "---------+" * 8
    keys = {"ORIENTACION C1-C6 (rumbo;orientacion)": "/V/N00E/N90E", "INTERVALO DE MUESTREO, C1-C6 (s)": f"/{STEP}/{STEP}/{STEP}",
            "NUM. TOTAL DE MUESTRAS, C1-C6": f"/{COUNT}/{COUNT}/{COUNT}", "UNIDADES DE LOS DATOS": "Gal (cm/s/s)"}  # fmt: skip
    lines = ["*" * 80, "INSTITUTO DE INGENIERIA, UNAM", "ARCHIVO ESTANDAR DE ACELERACION:",
             *(f"{key:39}: {value}" for key, value in keys.items()), rule,
             "   CANAL-1   CANAL-2   CANAL-3", "         V      N00E      N90E", rule]  # fmt: skip
    return "\n".join([*lines, *rows(np.column_stack([WAVE, 100.0 * WAVE, 100.0 * SECOND]).ravel(), 3, "{:10.4f}"), ""])


def cwb(rate: float = 200) -> str:
    heading = ["#Earthquake Information", "#StationCode: ILA005", f"#SampleRate(Hz): {rate}", "#AmplitudeUnit:  gal. DCoffset(corr)",
               "#DataSequence: Time U(+); N(+); E(+)",
               "#Data: 4F10.3"]  # fmt: skip
    return "\n".join([*heading, *rows(np.column_stack([TIME, WAVE, 100.0 * WAVE, 100.0 * SECOND]).ravel(), 4, "{:10.3f}"), ""])


def sac(order: str = "<", quantity: int = 8, scale: float = -12345.0, count: int = COUNT) -> bytes:
    reals, integers, text = np.full(70, -12345.0, f"{order}f4"), np.full(40, -12345, f"{order}i4"), bytearray(b"-12345  " * 24)
    reals[[0, 3, 5]] = STEP, scale, 0.0
    integers[[6, 9, 15, 16, 35]] = 6, count, 1, quantity, 1
    text[160:168] = b"HNE     "
    return reals.tobytes() + integers.tobytes() + bytes(text) + WAVE.astype(f"{order}f4").tobytes()


def itaca() -> str:
    keys = {"EVENT_NAME": "A QUAKE", "COMPONENT": "NS", "SAMPLING_INTERVAL_S": f"{STEP}", "NDATA": f"{COUNT}", "PGA_CM/S^2": "1.0",
            "DATABASE_VERSION": "ITACA 1.0", "DATA_TYPE": "UNPROCESSED ACCELERATION"}  # fmt: skip
    return "\n".join([*(f"{key}: {value}" for key, value in keys.items()), *(f"{v:.6f}" for v in 100.0 * WAVE), ""])


def counted(line: str = f"{COUNT} {STEP} 656") -> str:
    return "\n".join(["Time history matched to spectrum: made", line, *rows(WAVE, 5, "{:14.6E}"), ""])


START = "2021-03-04T05:06:07.000000"


def announced(
    layout: str = "SLIST", kind: str = "FLOAT", unit: str = ", M/S**2", channel: str = "HNE", count: int = COUNT, start: str = START
) -> str:
    return f"TIMESERIES XX_SITE__{channel}_D, {count} samples, {1.0 / STEP:g} sps, {start}, {layout}, {kind}{unit}\n"


def slist(values: np.ndarray = WAVE) -> str:
    return announced() + "\n".join([*rows(values, 6, "{:e}  "), ""])


def tspair(values: np.ndarray = WAVE, step: float = STEP) -> str:
    lines = [f"2021-03-04T05:06:{7.0 + step * k:09.6f}  {v:e}\n" for k, v in enumerate(values)]
    return "".join([announced("TSPAIR"), *lines])


def fortran(values: np.ndarray = WAVE) -> str:
    lines = [f"{line:72}{k + 1:8d}" for k, line in enumerate(rows(values, 8, "{:9.6f}"))]
    return "\n".join(["A SHOCK, 8F9.6, DT=0.005 SEC, UNITS G", *lines, ""])
