# SPDX-License-Identifier: GPL-3.0-or-later
"""miniSEED, the archive format of seismic networks, through obspy (the optional extra ``records``).

A file holds channels of counts, or of physical values, and names neither unit nor calibration: those stand in the station's metadata. So
the key ``units`` is needed, and ``calibration`` where the values are counts: motion = count * calibration, in ``units``. obspy
keeps a factor of its own (``calib``, 1 unless another program set it) and does not apply it; a calibration is applied once, here.
"""

from __future__ import annotations

import io
import re
import warnings
from typing import Any

from loads.readers.pieces import joined, of_channel_asked, of_traces
from loads.readers.source import RawRecord, Reader, Request, Source
from masonry_cd.foundation.errors import in_a_line
from masonry_cd.foundation.extras import require

BEGINNINGS = (re.compile(rb"\d{6}[DRQM][ \0]"), re.compile(rb"MS\x03"))  # of files of version 2 and 3


def recognises(source: Source) -> bool:
    """True for the bytes of a miniSEED file."""
    return any(beginning.match(source.data) for beginning in BEGINNINGS)


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel."""
    if not recognises(source):
        raise source.error("not a miniSEED file")
    pieces = of_traces(_open(source), source.error)
    return joined(of_channel_asked(pieces, request.column, source.error), source.error, request.calibration)


def _open(source: Source) -> list[Any]:
    """The traces of the file, by channel."""
    require(f"{source.label}: miniSEED", "obspy")
    from obspy.io.mseed.core import _read_mseed

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # obspy only warns of broken records, and returns what is left
            stream = _read_mseed(io.BytesIO(source.data))
    except Exception as failure:  # of many kinds, obspy's own and those of its C library
        raise source.error(f"not readable as miniSEED ({in_a_line(failure)})") from None
    if not stream:
        raise source.error("no samples in the file")
    return sorted(stream, key=lambda trace: trace.id)


ABOUT = "miniSEED 2 and 3, by channel (extra records)"
FORMATS = {"mseed": Reader(recognises, read, about=ABOUT, by="networks of the FDSN", takes=("column", "calibration"))}
