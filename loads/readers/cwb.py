# SPDX-License-Identifier: GPL-3.0-or-later
"""Central Weather Bureau (Taiwan): ``#SampleRate(Hz)``, ``#AmplitudeUnit``, ``#DataSequence: Time U(+); N(+); E(+)``, then this table."""

from __future__ import annotations

import re

from loads.readers.channels import evenly, pick
from loads.readers.heading import RecordHeading, columns
from loads.readers.quantity import of_format
from loads.readers.source import RawRecord, Reader, Request, Source

HEADING = 150  # lines in which keys are looked for
RATE, SEQUENCE = "#SAMPLERATE", "#DATASEQUENCE"
ALIKE = 1e-3  # of the step: rate and times agree so far


def recognises(source: Source) -> bool:
    """True when the heading of Taiwan's weather bureau gives rate and sequence of the columns."""
    return RecordHeading.split(source, "CWB", HEADING).has(SEQUENCE, RATE)


def read(source: Source, request: Request) -> RawRecord:
    """Read one component."""
    heading = RecordHeading.split(source, "CWB", HEADING)
    titles = [re.sub(r"\([^)]*\)", "", word).strip() for word in re.split(r"[;\s]+", heading.find(SEQUENCE)[1]) if word.strip()]
    column = pick(titles[1:], request.column, source.error)
    rate, unit = heading.positive(RATE), heading.find("#AMPLITUDEUNIT")[1].split()
    first = 1 + max(index for index, line in enumerate(source.lines[:HEADING]) if line.startswith("#"))
    times, written = columns(source, first, [0, column + 1], len(titles)).T
    values, step, notes = evenly(source, times, written, first)
    if abs(step * rate - 1.0) > ALIKE:
        raise source.error(f"{rate:g} samples a second, but the times are {step:g} s apart: correct the file", heading.find(RATE)[0])
    name, stated = titles[column + 1], of_format("CWB")
    return RawRecord(values, step, float(times[0]), unit[0].rstrip(".") if unit else None, name, column, stated, notes=notes)


FORMATS = {"cwb": Reader(recognises, read, about="text of three components", by="Central Weather Bureau, Taiwan", takes=("column",))}
