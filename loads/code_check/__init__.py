"""The check of a mechanism by the kinematic approach of codes: what it bears, what an earthquake asks of it, and every value between.

table.py     the keys of [limit.check]
ground.py    the motion of the ground: the spectrum of a code, or that of a record
floors.py    its motion at a height of a building
steps.py     values with symbol, unit and clause; verdicts
ntc2018.py   Circolare 7 of 2019, C8.7.1.2.1
ntc2008.py   Circolare 617 of 2009, C8A.4
ec8.py       EN 1998-1:2004, 4.3.5, with the confidence factor of EN 1998-3:2005
"""

from __future__ import annotations

from pathlib import Path

from loads.code_check import ec8, ntc2008, ntc2018
from loads.code_check.ground import ground_of
from loads.code_check.steps import CodeCheck
from loads.code_check.table import CheckTable
from masonry_cd.limit.oscillator import Oscillator

CODES = {"NTC2018": ntc2018.check, "NTC2008": ntc2008.check, "EC8": ec8.check}


def code_check(table: CheckTable, oscillator: Oscillator, folder: Path) -> CodeCheck:
    """Check a mechanism.

    Args:
        table: what is asked.
        oscillator: of the mechanism.
        folder: from which the path of a record is read.

    Raises:
        InputError: a record that cannot be read.
    """
    return CODES[table.code](table, oscillator, ground_of(table, folder))
