# SPDX-License-Identifier: GPL-3.0-or-later
"""ESM and ITACA ASCII (DYNA 1.0 to 1.2): a heading of ``KEY: value`` lines, then one acceleration per line.

Needed of the heading: SAMPLING_INTERVAL_S, NDATA, UNITS, and DATA_TYPE where it is given; ITACA 1 names the component COMPONENT instead of
STREAM.
"""

from __future__ import annotations

import re

from loads.readers.quantity import Stated, named, of_channel
from loads.readers.source import RawRecord, Reader, Request, Source, check_count, refuse_keys

KEY = re.compile(r"^([A-Z][A-Z0-9_/^]*):(.*)$")
PEAK = re.compile(r"PG[AVD]_(.+)$")  # the unit of older files stands in the key of their peak: PGA_CM/S^2
HEADING = 100  # lines in which the keys are looked for


def recognises(source: Source) -> bool:
    """True when the heading has the keys of step and count."""
    heading = _heading(source)
    return "SAMPLING_INTERVAL_S" in heading and "NDATA" in heading


def read(source: Source, request: Request) -> RawRecord:
    """Read the record.

    Raises:
        InputError: a missing key, a quantity that is no motion, text among the numbers, a wrong count.
    """
    heading = _heading(source)
    for key in ("SAMPLING_INTERVAL_S", "NDATA"):
        if key not in heading:
            raise source.error(f"no line {key} in the heading of an ESM file")
    refuse_keys(source, request, "ESM")
    line, text = heading["SAMPLING_INTERVAL_S"]
    step = source.number(text, line)
    if step <= 0.0:
        raise source.error(f"the time step SAMPLING_INTERVAL_S must be above zero, got {step:g}", line)
    stated = _stated(source, heading)
    values = source.stream(max(index for index, _ in heading.values()) + 1)
    line, text = heading["NDATA"]
    check_count(source, values, source.number(text, line), line)
    unit = heading.get("UNITS", (0, ""))[1] or next((found[1] for key in heading if (found := PEAK.match(key))), "")
    name = heading.get("STREAM", heading.get("COMPONENT", (0, "")))[1]
    return RawRecord(values, step, 0.0, unit or None, name, stated=stated)


def _stated(source: Source, heading: dict[str, tuple[int, str]]) -> Stated | None:
    """What the record is of, by the line DATA_TYPE, or by the channel where there is none."""
    line, text = heading.get("DATA_TYPE", (0, ""))
    if not text:
        return of_channel(heading.get("STREAM", (0, ""))[1])
    if (quantity := named(text)) and not re.search("SPECTR|RESPONSE", text, re.IGNORECASE):
        return Stated(quantity, f"line {line + 1}, DATA_TYPE", firm=True)
    raise source.error(f"a record of {text.lower()}, where one of acceleration is needed", line)


def _heading(source: Source) -> dict[str, tuple[int, str]]:
    """Key -> (index of its line, value), up to the first line that is none of it."""
    found: dict[str, tuple[int, str]] = {}
    for index, line in enumerate(source.lines[:HEADING]):
        match = KEY.match(line)
        if match is None:
            break
        found[match[1]] = (index, match[2].strip())
    return found


FORMATS = {"esm": Reader(recognises, read, about="DYNA 1.0 to 1.2, ITACA 1 and 2, one component", by="ESM, ITACA (INGV), AFAD (TADAS)")}
