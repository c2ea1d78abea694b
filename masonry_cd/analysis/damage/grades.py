# SPDX-License-Identifier: GPL-3.0-or-later
"""Grades of damage, D0 to D5, by thresholds that the user can set.

The names are those of the European Macroseismic Scale (Gruenthal, ed., EMS-98, Cahiers du Centre Europeen de Geodynamique et de
Seismologie 15, 1998), which describes damage to masonry in words, from hair-line cracks in very few walls (grade 1) over large and
extensive cracks in most walls (3) to total or near total collapse (5), and gives no numbers. The numbers are this program's own defaults,
and every table states them with the grade:

    residual width   opening or sliding of a joint between standing blocks [m]: 0.1, 5, 15 and 25 mm. Of the categories of visible damage of
                     Burland, Broms & de Mello (Behaviour of foundations and structures, Tokyo, 1977; in BRE Digest 251, 1981) these are
                     the lower bounds of 1 (very slight; below lie hair-line cracks, negligible), 3 (moderate), 4 (severe) and 5 (very
                     severe). Category 2 (slight, 1 to 5 mm) is D1 here, too. They are meant for settlement, and their
                     authors warn that width alone is not a measure of damage: so drift and lost volume count as well
    residual drift   of the part (:mod:`masonry_cd.analysis.damage.macro_elements`): 0.3, 0.6 and 1 %, which FEMA 356 (2000, table C1-3)
    gives as typical of unreinforced masonry walls at immediate occupancy, life safety and collapse prevention lost volume      share of the
    part that has fallen: any, 5 % and 50 %

A part has the highest grade one of whose thresholds it reaches; ``inf`` is never reached. Set them in the scene's ``[report.grades]``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, field_validator

from masonry_cd.analysis.verdict import NOT_GRADED
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.fields import is_number
from masonry_cd.foundation.quantities import length
from masonry_cd.foundation.units import Unit

INF = float("inf")
NAMES = ("D0", "D1", "D2", "D3", "D4", "D5")
LABELS = (
    "no damage",
    "negligible to slight damage",
    "moderate damage",
    "substantial to heavy damage",
    "very heavy damage",
    "destruction",
)

REFERENCE = (
    "Grünthal, G. (ed.): European Macroseismic Scale 1998 (EMS-98). Cahiers du Centre Européen de Géodynamique et de Séismologie 15, "
    "Luxembourg, 1998"
)
DESCRIPTIONS = (
    "",
    "No structural damage, slight non-structural damage: hair-line cracks in very few walls; fall of small pieces of plaster only.",
    "Slight structural, moderate non-structural damage: cracks in many walls; fall of fairly large pieces of plaster.",
    "Moderate structural, heavy non-structural damage: large and extensive cracks in most walls; failure of individual non-structural "
    "elements (partitions, gable walls).",
    "Heavy structural, very heavy non-structural damage: serious failure of walls; partial structural failure of roofs and floors.",
    "Very heavy structural damage: total or near total collapse.",
)
"""Descriptions of the grades D0 to D5 of masonry buildings by EMS-98, which does not define a grade 0."""


def _five_rising(value: object) -> object:
    """Five numbers that do not fall, for D1 to D5."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 5:
        raise ValueError("should be five numbers, for D1 to D5; inf for a grade that this measure alone does not reach")
    if any(not (is_number(v) or isinstance(v, float)) or not v > 0 for v in value):
        raise ValueError("should be positive numbers or inf")
    if any(b < a for a, b in pairwise(value)):
        raise ValueError("should not fall from D1 to D5")
    return tuple(float(v) for v in value)


Five = Annotated[tuple[float, float, float, float, float], BeforeValidator(_five_rising)]


class Grades(BaseModel):
    """The table ``[report.grades]``: lower bounds of D1 to D5, and what the grades are called."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    width: Annotated[Five, Unit("m")] = (1e-4, 5e-3, 15e-3, 25e-3, INF)
    """Residual opening or sliding."""
    drift: Five = (INF, 3e-3, 6e-3, 1e-2, INF)
    """Residual drift of the part."""
    lost: Five = (INF, INF, 1e-9, 0.05, 0.5)
    """Share of the volume that has fallen."""
    labels: tuple[str, str, str, str, str, str] = LABELS
    """Labels of D0 to D5."""

    @field_validator("labels", mode="before")
    @classmethod
    def _six(cls, value: object) -> object:
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 6:
            raise ValueError("should be six texts, for D0 to D5")
        return tuple(value)


@dataclass(frozen=True)
class Grade:
    """A grade and what led to it, e.g. ``drift 0.72 % (D3 from 0.6 %)``."""

    number: int
    label: str
    reason: str

    @property
    def name(self) -> str:
        """D0 to D5."""
        return NAMES[self.number]


def read_grades(table: Mapping[str, Any]) -> Grades:
    """Check the table ``[report.grades]``.

    Raises:
        InputError: names the key.
    """
    return parse_table(Grades, table, "report.grades")


def grade_of(width: float, drift: float, lost: float, grades: Grades, what: str = "crack", where: str = "") -> Grade:
    """The grade of a part, and what gives it.

    Args:
        width: residual width of its widest joint [m].
        drift: residual, of the part.
        lost: share of its volume that has fallen.
        grades: the thresholds.
        what: kind of the width, ``opening`` or ``sliding``.
        where: the joint that it is in.
    """
    reached = []
    measures = (
        ("lost volume", lost, grades.lost, percent, ""),  # first: where several give the grade, what has fallen says most
        (what, width, grades.width, length, where),
        ("drift", drift, grades.drift, percent, ""),
    )
    for name, value, bounds, text, place in measures:
        number = max((k for k, bound in enumerate(bounds, start=1) if value >= bound), default=0)
        bound = bounds[number - 1] if number else INF
        begins = text(bound) if bound > 1e-6 else "any"
        reached.append((number, f"{name} {text(value)}{place and f' in {place}'} ({NAMES[number]} from {begins})"))
    number, reason = max(reached, key=lambda pair: pair[0])
    return Grade(number, grades.labels[number], reason if number else "")


def percent(share: float) -> str:
    """A share in per cent."""
    return f"{100 * share:.3g} %"


def grade_number(grade: str) -> int | None:
    """The number of a grade; None where the run cannot be relied on, so that it was not graded."""
    return None if grade == NOT_GRADED else NAMES.index(grade)
