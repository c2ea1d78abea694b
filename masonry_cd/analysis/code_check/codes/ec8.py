# SPDX-License-Identifier: GPL-3.0-or-later
"""Eurocode 8: the force on a part by EN 1998-1:2004, 4.3.5.2, against the factor of the mechanism over the confidence factor of EN 1998-3.

EN 1998-3:2005 has no method for mechanisms of rigid bodies; how a mechanism becomes an acceleration is that of the Italian Circolare.
"""

from __future__ import annotations

import math

import numpy as np

from masonry_cd.analysis.code_check.code import Code
from masonry_cd.analysis.code_check.floors import part_acceleration
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import BUILDING, CodeCheck, CodeQuantity, Working, capacity_rows, linear, put_capacity
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import LINEAR
from masonry_cd.analysis.limit.oscillator import Oscillator

EDITION = "EN 1998-1:2004, 4.3.5.2, with EN 1998-3:2005"
BY_ITALY = "Circolare 7/2019"
PART = "EN 1998-1, 4.3.5.2"
TABLE = capacity_rows(
    f"{BY_ITALY} [C8.7.1.1]", f"{BY_ITALY} [C8.7.1.5]", "EN 1998-3, table 3.1", f"{BY_ITALY} [C8.7.1.3]", f"{BY_ITALY} [C8.7.1.4]"
) | {
    "z": CodeQuantity("m", PART, "height at which the mechanism is held, above the foundation"),
    "H": CodeQuantity("m", PART, "height of the building"),
    "z/H": CodeQuantity("", PART, "height of the mechanism over that of the building", "z / H"),
    "Ta": CodeQuantity("s", PART, "period of the part"),
    "T1": CodeQuantity("s", PART, "period of the building"),
    "Ta/T1": CodeQuantity("", PART, "period of the part over that of the building", "Ta / T1"),
    "Sa g": CodeQuantity("m/s2", PART, "acceleration of the part", "ag S max(1, 3 (1 + z/H) / (1 + (1 - Ta/T1)^2) - 0.5)"),
    "qa": CodeQuantity("", "EN 1998-1, 4.3.5.4", "behaviour factor of the part"),
    "a asked": CodeQuantity("m/s2", PART, "acceleration over qa, the importance factor of the part being 1", "Sa g / qa"),
}


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism by accelerations; there is no check by displacements."""
    made = Working(ground.rows, TABLE)
    starts = put_capacity(made, oscillator, table.confidence_factor)
    ground.put(made)
    there, formula = ground.peak, "ag S"
    if table.height:
        assert table.building_height is not None and table.building_period is not None
        made.part = BUILDING
        made.put("z", table.height)
        made.put("H", table.building_height)
        share = made.put("z/H", table.share)
        own = made.put("Ta", table.element_period or 0.0)
        ratio = made.put("Ta/T1", own / made.put("T1", table.building_period))
        there, formula = part_acceleration(ground.peak, share, ratio), ""
    made.part = LINEAR
    made.put("Sa g", there, formula or None)
    q = made.put("qa", table.behaviour_factor)
    asked = made.put("a asked", there / q)
    note = "Eurocode 8 of 2004 and 2005 has no check by displacements of such mechanisms"
    verdict = linear(oscillator, asked, starts, PART, q, table.element_period or 0.0)
    return CodeCheck("EC8", EDITION, "", ground.words, tuple(made.steps), (verdict,), (note,))


def raised(table: CheckTable, ground: Ground, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """S_a g [m/s2] of parts with some periods at the height of a table, (n,), and the displacement that goes with it [m]."""
    shares = periods / (table.building_period or 1.0)
    found = np.array([part_acceleration(ground.peak, table.share, ratio) for ratio in shares.tolist()])
    return found, found * (periods / (2.0 * math.pi)) ** 2


CODES = {"EC8": Code(check, PART, parts_vibrate="above the ground", raised=raised)}
