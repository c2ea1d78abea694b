# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten dry walls of sawn granite, pushed to and fro at three stresses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from masonry_cd.studies.laboratory.case import Case, Found
from masonry_cd.studies.laboratory.granite_walls import ASSUMED, SAWN, SOURCE, UNKNOWN, compare


def compute(folder: Path, say: Callable[[str], object]) -> Found:
    """The dry walls."""
    return compare([SAWN], folder, say)


CASE = Case(
    "cyclic_walls",
    "Ten dry walls pushed to and fro",
    SOURCE,
    ASSUMED,
    UNKNOWN,
    "Rigid peaks agree at all three stresses within 5 %, elastic ones are 5 to 10 % below, as these walls rocked: N L / (2 H) with little "
    "taken away by the rounding of the toe. The joints are two to three times too stiff: dry beds touch at few points and close as "
    "they are pressed, so that a wall that opens from the start shows less than the E that it was found to have under full pressure. "
    "Prisms of dry bricks have curves that bend upwards at first, and 62 % less stiffness than those in mortar (Lin, Totoev, Liu & "
    "Wei, Materials 8(12), 2015). `joints.normal_stiffness`, or `masonry.E`, takes the lower value where it is known; it does not "
    "grow with the pressure.",
    compute,
)
