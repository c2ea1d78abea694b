# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume 1 of RENADIC (Chile), see :mod:`.usc`."""

from __future__ import annotations

from functools import partial

from loads.readers.source import Reader, Source, begins
from loads.readers.usc import COUNT, TEXT, read_volume


def recognises(source: Source) -> bool:
    """True when the first lines name the network and a number of points."""
    return begins("RENADIC", TEXT)(source) and any(COUNT.search(line) for line in source.lines[:TEXT])


READ, BY = partial(read_volume, kind="RENADIC"), "RENADIC, Universidad de Chile"
FORMATS = {"renadic": Reader(recognises, READ, about="Volume 1, three components", by=BY, takes=("column",))}
