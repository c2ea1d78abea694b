# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of seismic networks and instruments through obspy (the optional extra ``records``): miniSEED and Kinemetrics EVT.

A file of miniSEED holds channels of counts, or of physical values, and names neither unit nor calibration: those stand in the metadata of
the station. So the key ``units`` is needed, and ``calibration`` where the values are counts: motion = count * calibration, in ``units``.
obspy keeps a factor of its own (``calib``) and does not apply it; a calibration is applied once, here. An EVT gives volts of full scale and
volts per g of each channel, by which obspy makes m/s2 of the counts, with a g of 9.81.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Mapping
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

from loads.motion import STANDARD_GRAVITY
from loads.readers.pieces import joined, of_channel_asked, of_traces
from loads.readers.source import RawRecord, Reader, Request, Source
from masonry_cd.foundation.errors import in_a_line
from masonry_cd.foundation.extras import require

GRAVITY_OF_OBSPY = 9.81  # [m/s2]


class Archive(NamedTuple):
    """A format that obspy reads."""

    title: str
    beginning: re.Pattern[bytes]  # of its files
    reader: str  # module:function of obspy
    keywords: Mapping[str, bool] = {}
    unit: str | None = None  # of what the reader returns; None of counts
    factor: float = 1.0  # on that


ARCHIVES = {
    "mseed": Archive("miniSEED", re.compile(rb"\d{6}[DRQM][ \0]|MS\x03"), "obspy.io.mseed.core:_read_mseed"),
    "evt": Archive(
        "Kinemetrics EVT",
        re.compile(rb"K(?:\x01..\0\0\0\x01(?:\x07\xf8|\x0a\xb0)|\0..\x01\0\0\0(?:\xf8\x07|\xb0\x0a))", re.DOTALL),
        "obspy.io.kinemetrics.core:read_evt",
        {"apply_calib": True},
        "m/s2",
        STANDARD_GRAVITY / GRAVITY_OF_OBSPY,
    ),
}


def recognises(name: str, source: Source) -> bool:
    """True for the bytes of a file of a format."""
    return bool(ARCHIVES[name].beginning.match(source.data))


def read(name: str, source: Source, request: Request) -> RawRecord:
    """Read one channel of a file of a format."""
    archive = ARCHIVES[name]
    if not recognises(name, source):
        raise source.error(f"not a file of {archive.title}")
    if request.calibration is not None and archive.unit is not None:
        raise source.error(f"the key calibration is given, but {archive.title} holds that of its counts: the values are in {archive.unit}")
    pieces = of_traces(_open(archive, source), source.error)
    if archive.unit is not None:
        pieces = [piece._replace(values=archive.factor * piece.values, unit=archive.unit, counts=False) for piece in pieces]
    return joined(of_channel_asked(pieces, request.column, source.error), source.error, request.calibration)


def _open(archive: Archive, source: Source) -> list[Any]:
    """The traces of the file, by channel."""
    require(f"{source.label}: {archive.title}", "obspy")
    module, _, function = archive.reader.partition(":")
    reader = getattr(import_module(module), function)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # obspy only warns of broken records, and returns what is left
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.filterwarnings("ignore", "(?s).*Unmatched raw value")  # of a setting of the instrument
            stream = reader(io.BytesIO(source.data), **archive.keywords)
    except Exception as failure:  # of many kinds, obspy's own and those of its C library
        raise source.error(f"not readable as {archive.title} ({in_a_line(failure)})") from None
    if not stream:
        raise source.error("no samples in the file")
    return sorted(stream, key=lambda trace: trace.id)


def _reader(name: str, about: str, by: str) -> Reader:
    return Reader(partial(recognises, name), partial(read, name), about=about, by=by, takes=("column", "calibration"))


FORMATS = {
    "mseed": _reader("mseed", "miniSEED 2 and 3, by channel (extra records)", "networks of the FDSN"),
    "evt": _reader("evt", "EVT, m/s2 by its own calibration (extra records)", "Kinemetrics Altus instruments"),
}
