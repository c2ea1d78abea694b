# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume 1 of BHRC (Iran): values alone, ten a line, see :mod:`.usc`."""

from __future__ import annotations

from functools import partial

from loads.readers.source import Reader, begins
from loads.readers.usc import read_volume

MARK = begins("* VOL1DS FILE")
READ = partial(read_volume, kind="BHRC", pairs=False)
BY = "BHRC/ISMN, Iran"
FORMATS = {"bhrc": Reader(MARK, READ, about="Volume 1 (VOL1DS), three components", by=BY, takes=("column",))}
