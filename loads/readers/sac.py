# SPDX-License-Identifier: GPL-3.0-or-later
"""SAC, the binary format of the Seismic Analysis Code: one series.

A header of 70 reals, 40 integers and 192 characters, then the samples in single precision, in either byte order. The header gives the
step, and may say whether samples are displacements, velocities or accelerations; it names no unit that networks keep to, so the key
``units`` is needed. Source: IRIS, "SAC data file format", version 6 and 7.
"""

from __future__ import annotations

import numpy as np

from loads.readers.quantity import Stated, of_channel
from loads.readers.source import RawRecord, Reader, Request, Source

REALS, INTEGERS, TEXT = 70, 40, 192
BYTES = 4 * (REALS + INTEGERS) + TEXT  # of the header
DELTA, SCALE, BEGIN = 0, 3, 5  # places among the reals
VERSION, COUNT, TYPE, QUANTITY, EVEN = 6, 9, 15, 16, 35  # among the integers
CHANNEL = slice(160, 168)  # among the characters: kcmpnm
UNDEFINED = -12345.0
TIME_SERIES = 1  # iftype
QUANTITIES = {6: "displacement", 7: "velocity", 8: "acceleration"}  # idep
FOOTER = {6: 0, 7: 176}  # versions, and the bytes behind the samples
MOST = 2**28  # samples: a header that announces more is none, or read in the wrong order of bytes


def recognises(source: Source) -> bool:
    """True for a header that gives its version and a count of samples."""
    return _order(source) is not None


def read(source: Source, request: Request) -> RawRecord:
    """Read the series."""
    order = _order(source)
    if order is None:
        raise source.error("not a SAC file")
    reals, integers, text = _header(source.data, order)
    if integers[TYPE] != TIME_SERIES or not integers[EVEN]:
        raise source.error("no evenly sampled time series: spectra, xy data and uneven samples are not read")
    count, step, scale = int(integers[COUNT]), float(reals[DELTA]), float(reals[SCALE])
    if not step > 0.0 or not np.isfinite(step):
        raise source.error(f"the time step DELTA must be above zero, got {step:g}")
    held = max(0, len(source.data) - BYTES - FOOTER[int(integers[VERSION])]) // 4
    values = np.frombuffer(source.data, dtype=f"{order}f4", count=held, offset=BYTES).astype(float)
    source.check_count(values, count)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise source.error(f"sample {bad[0] + 1} is not a finite number")
    if scale not in (UNDEFINED, 1.0) and request.calibration is None:
        raise source.error(
            f"SCALE is {scale:g} in its header, which programs apply or not; the key calibration says what one unit means, 1 for as it is"
        )
    factor = 1.0 if request.calibration is None else request.calibration
    begin = 0.0 if reals[BEGIN] == UNDEFINED or not np.isfinite(reals[BEGIN]) else float(reals[BEGIN])
    name = text[CHANNEL].split(b"\0")[0].decode("latin-1").strip().replace("-12345", "")
    quantity = QUANTITIES.get(int(integers[QUANTITY]))
    stated = Stated(quantity, "its header, IDEP", firm=False) if quantity else of_channel(name)
    return RawRecord(factor * values, step, begin, None, name, stated=stated)


def _order(source: Source) -> str | None:
    """The byte order, ``<`` or ``>``; None where the bytes are no SAC file in either."""
    for order in "<>":
        if len(source.data) > BYTES:
            _, integers, _ = _header(source.data, order)
            count = int(integers[COUNT])
            if integers[VERSION] in FOOTER and 1 < count < MOST:
                return order
    return None


def _header(data: bytes, order: str) -> tuple[np.ndarray, np.ndarray, bytes]:
    """Reals (70,), integers (40,), characters."""
    reals = np.frombuffer(data, dtype=f"{order}f4", count=REALS)
    integers = np.frombuffer(data, dtype=f"{order}i4", count=INTEGERS, offset=4 * REALS)
    return reals, integers, data[4 * (REALS + INTEGERS) : BYTES]


FORMATS = {
    "sac": Reader(
        recognises,
        read,
        about="binary, one series; units by key",
        by="Seismic Analysis Code; IRIS/EarthScope and others",
        takes=("calibration",),
    )
}
