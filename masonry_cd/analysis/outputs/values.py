# SPDX-License-Identifier: GPL-3.0-or-later
"""Values as files have them."""

from __future__ import annotations

import math

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.verdict import NOT_GRADED


def grade_number(grade: str) -> int | None:
    """The number of a grade; None where the run cannot be relied on, so that it was not graded."""
    return None if grade == NOT_GRADED else NAMES.index(grade)


def finite(value: float) -> float | None:
    """A number, or nothing where there is none."""
    return float(value) if math.isfinite(value) else None
