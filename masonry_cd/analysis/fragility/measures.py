# SPDX-License-Identifier: GPL-3.0-or-later
"""The intensity measures of a table: their units, and what OpenQuake calls them.

The columns are in SI units; OpenQuake takes accelerations in g, velocities in cm/s, and CAV in g s (OpenQuake Engine, reference manual,
intensity measure types).
"""

from __future__ import annotations

import re
from typing import NamedTuple

G = 9.80665  # standard gravity [m/s2]
UNITS = {
    "PGA": "m/s²", "PGV": "m/s", "PGD": "m", "Sa": "m/s²", "AvgSA": "m/s²", "Arias": "m/s", "CAV": "m/s", "D5-95": "s", "Housner": "m",
    "FIV3": "m/s",
}  # fmt: skip
DIRECTIONS = {
    "geometric_mean": "geometric mean",
    "larger": "larger",
    "rotd50": "RotD50",
    "rotd100": "RotD100",
}


class Imt(NamedTuple):
    """An intensity measure as OpenQuake names it."""

    name: str
    unit: str
    factor: float  # from the table's unit


OPENQUAKE = {
    "PGA": Imt("PGA", "g", 1.0 / G),
    "PGV": Imt("PGV", "cm/s", 100.0),
    "PGD": Imt("PGD", "cm", 100.0),
    "AvgSA": Imt("AvgSA", "g", 1.0 / G),
    "Arias": Imt("IA", "m/s", 1.0),
    "CAV": Imt("CAV", "g s", 1.0 / G),
    "D5-95": Imt("RSD595", "s", 1.0),
}


def base(measure: str) -> str:
    """``Sa`` of ``Sa(0.5):rotd50``."""
    return re.split(r"[(:]", measure, maxsplit=1)[0].strip()


def unit(measure: str) -> str:
    """Return the unit of the column, empty where it is not known."""
    return UNITS.get(base(measure), "")


def label(measure: str) -> str:
    """For an axis: ``PGA, RotD50 [m/s²]``."""
    name, _, direction = measure.partition(":")
    known = unit(measure)
    return name + (f", {DIRECTIONS.get(direction, direction)}" if direction else "") + (f" [{known}]" if known else "")


def with_unit(value: float, measure: str) -> str:
    """``2.4 m/s²``"""
    return f"{value:.3g} {unit(measure)}".strip()


def openquake(measure: str) -> Imt | None:
    """Return the name of a measure in OpenQuake; None where its name and unit there are not known."""
    if base(measure) == "Sa":
        period = re.match(r"Sa\(\s*([^,)]+?)\s*\)", measure)  # of five per cent of damping only
        return Imt(f"SA({period.group(1)})", "g", 1.0 / G) if period else None
    return OPENQUAKE.get(base(measure))
