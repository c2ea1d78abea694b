# SPDX-License-Identifier: GPL-3.0-or-later
"""miniSEED, the archive format of seismic networks, through obspy (the optional extra ``records``).

A file holds channels of counts, or of physical values, and names neither unit nor calibration: those stand in the station's metadata. So
the key ``units`` is needed, and ``calibration`` where the values are counts: motion = count * calibration, in ``units``. The code of the
channel says whether the sensor follows the acceleration or the velocity. obspy
keeps a factor of its own (``calib``, 1 unless another program set it) and does not apply it; a calibration is applied once, here.
"""

from __future__ import annotations

import io
import re
import warnings
from itertools import pairwise
from typing import Any

import numpy as np

from loads.readers.quantity import of_channel
from loads.readers.source import RawRecord, Reader, Request, Source, refuse_layout
from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.extras import require

BEGINNINGS = (re.compile(rb"\d{6}[DRQM][ \0]"), re.compile(rb"MS\x03"))  # of files of version 2 and 3


def recognises(source: Source) -> bool:
    """True for the bytes of a miniSEED file."""
    return any(beginning.match(source.data) for beginning in BEGINNINGS)


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel.

    Raises:
        InputError: obspy is not installed, a file cut short, several channels and none named, a gap or an overlap in the channel.
    """
    if request.time_step is not None:
        raise source.error("the key time_step does not apply to miniSEED files, whose header gives it")
    refuse_layout(source, request, "miniSEED")
    if not recognises(source):
        raise source.error("not a miniSEED file")
    traces = _channel(source, _open(source), request.column)
    first = traces[0].stats
    for earlier, later in pairwise(traces):
        lag = float(later.stats.starttime - earlier.stats.endtime) - first.delta
        if later.stats.delta != first.delta:
            raise source.error(f"the sampling of {earlier.id} changes from {first.delta:g} to {later.stats.delta:g} s")
        if abs(lag) > 0.5 * first.delta:
            what = "a gap" if lag > 0.0 else "an overlap"
            raise source.error(f"{what} of {abs(lag):g} s in {earlier.id} at {float(earlier.stats.endtime - first.starttime):g} s")
    values = np.concatenate([np.asarray(trace.data, dtype=float) for trace in traces])
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise source.error(f"sample {bad[0] + 1} of {traces[0].id} is not a finite number")
    factor = 1.0 if request.calibration is None else request.calibration
    counts = request.calibration is None and all(np.issubdtype(np.asarray(trace.data).dtype, np.integer) for trace in traces)
    stated = of_channel(traces[0].id.rpartition(".")[2])
    return RawRecord(factor * values, float(first.delta), 0.0, None, traces[0].id, stated=stated, counts=counts)


def _open(source: Source) -> list[Any]:
    """The traces of the file, in order of channel and time."""
    require(f"{source.label}: miniSEED", "obspy")
    from obspy.io.mseed.core import _read_mseed

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # obspy only warns of broken records, and returns what is left
            stream = _read_mseed(io.BytesIO(source.data))
    except Exception as failure:  # of many kinds, obspy's own and those of its C library
        raise source.error(f"not readable as miniSEED ({' '.join(str(failure).split())[:120]})") from None
    if not stream:
        raise source.error("no samples in the file")
    return sorted(stream, key=lambda trace: (trace.id, trace.stats.starttime))


def _channel(source: Source, traces: list[Any], column: str | int | None) -> list[Any]:
    """The traces of the channel that the user asks for, by its code ("HNE") or its whole name ("IV.AQK..HNE")."""
    names = list(dict.fromkeys(trace.id for trace in traces))
    listed = f"channels: {', '.join(names)}"
    if column is None:
        if len(names) > 1:
            raise source.error(f"several channels; say which by the key column; {listed}")
        return traces
    if isinstance(column, int):
        raise source.error(f'the key column names a channel of miniSEED, such as "HNE"; {listed}')
    word = column.strip().upper()
    fitting = [name for name in names if word in (name.upper(), name.upper().rpartition(".")[2])]
    if len(fitting) != 1:
        why = f'several channels are called "{column}"' if fitting else f'no channel "{column}"{suggest(word, names)}'
        raise source.error(f"{why}; {listed}")
    return [trace for trace in traces if trace.id == fitting[0]]


FORMATS = {"mseed": Reader(recognises, read, about="miniSEED 2 and 3, by channel (extra records)", by="networks of the FDSN")}
