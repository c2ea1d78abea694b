# SPDX-License-Identifier: GPL-3.0-or-later
"""SLIST and TSPAIR, the text of the FDSN's web services: channels in pieces, each behind a line that says all about it.

    TIMESERIES XX_SITE__HNE_D, 1600 samples, 200 sps, 2021-03-04T05:06:07.000000, SLIST, FLOAT, M/S**2
    3.810133e-03  4.231205e-03  ...                      SLIST: the samples, several to a line
    2021-03-04T05:06:07.000000  3.810133e-03             TSPAIR: a time and a sample to a line

The name is NETWORK_STATION_LOCATION_CHANNEL_QUALITY. Source: EarthScope, timeseries web service, "ASCII formats".
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from itertools import pairwise

import numpy as np

from loads.readers.pieces import ChannelPiece, joined, of_channel_asked
from loads.readers.source import RawRecord, Reader, Request, Source
from loads.readers.units import measured_by

HEAD, EXAMPLE = "TIMESERIES", "TIMESERIES NET_STA_LOC_CHA_Q, 1600 samples, 200 sps, START, SLIST, FLOAT, M/S**2"
LINE = re.compile(
    r"TIMESERIES\s+(?P<name>\S+?)\s*,\s*(?P<count>\S+)\s+samples?\s*,\s*(?P<rate>\S+)\s+sps\s*,\s*(?P<start>[^,]+?)\s*,"
    r"\s*(?P<layout>SLIST|TSPAIR)\s*,\s*(?P<type>INTEGER|FLOAT|ASCII)\s*(?:,\s*(?P<unit>.*?)\s*)?$",
    re.IGNORECASE,
)
SLACK = 0.5  # of a step: by how much the times of pairs may be off
LONGEST = 300  # characters of a line that announces a piece
FASTEST = 1e6  # samples a second


def recognises(source: Source) -> bool:
    """True when the first line announces a series as these services do."""
    first = next((line for line in source.lines if line.strip()), "")
    return first.upper().startswith(f"{HEAD} ") and "SPS" in first.upper()


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel."""
    heads = [index for index, line in enumerate(source.lines) if line.upper().startswith(HEAD)]
    if not heads:
        raise source.error(f"no line begins with {HEAD}, as that of a series in SLIST or TSPAIR does")
    pieces = [_piece(source, head, after) for head, after in pairwise([*heads, len(source.lines)])]
    channel = of_channel_asked(pieces, request.column, source.error)
    if request.calibration is not None and channel[0].unit is not None:
        raise source.error(f"the key calibration is given, but the samples are in {channel[0].unit}, not in counts")
    return joined(channel, source.error, request.calibration)


def _piece(source: Source, head: int, after: int) -> ChannelPiece:
    """The piece of a channel between two lines."""
    found = LINE.match(source.lines[head].strip()[:LONGEST])
    if found is None:
        raise source.error(f"a line such as {EXAMPLE} belongs here", head)
    rate = source.number(found["rate"], head)
    if not 0.0 < rate <= FASTEST:
        raise source.error(f"{rate:g} samples a second are not possible", head)
    begin, pairs = _seconds(source, found["start"], head), found["layout"].upper() == "TSPAIR"
    rows = [(index, source.lines[index].split()) for index in range(head + 1, after) if source.lines[index].strip()]
    odd = next((index for index, words in rows if pairs and len(words) != 2), None)
    if odd is not None:
        raise source.error("a time and a sample belong on a line of TSPAIR", odd)
    values = np.array([source.number(word, index) for index, words in rows for word in words[pairs:]], dtype=float)
    source.check_count(values, source.number(found["count"], head), head)
    for k, (index, words) in enumerate(rows if pairs else []):
        if abs(_seconds(source, words[0], index) - begin - k / rate) > SLACK / rate:
            raise source.error(f"{words[0]} is not the time of sample {k + 1} at {rate:g} samples a second", index)
    unit = found["unit"] or None
    physical = unit is not None and measured_by(unit) is not None
    counts = bool(unit and unit.upper().startswith("COUNT")) or (not physical and found["type"].upper() == "INTEGER")
    return ChannelPiece(_name(found["name"]), begin, 1.0 / rate, values, counts, unit=None if counts else unit)


def _name(written: str) -> str:
    """``XX_SITE__HNE_D`` as ``XX.SITE..HNE``."""
    words = written.split("_")
    return ".".join(words[:4]) if len(words) >= 4 else written


def _seconds(source: Source, text: str, index: int) -> float:
    """A time in seconds since 1970."""
    try:
        time = datetime.fromisoformat(text.strip().rstrip("Zz"))
    except ValueError:
        raise source.error(f'"{text[:40]}" where a time such as 2021-03-04T05:06:07.000000 belongs', index) from None
    return time.replace(tzinfo=time.tzinfo or UTC).timestamp()


ABOUT = "SLIST and TSPAIR, channels as text"
FORMATS = {"timeseries": Reader(recognises, read, about=ABOUT, by="web services of the FDSN", takes=("column", "calibration"))}
