# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[report]`` of a scene: what is drawn and written after the run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from masonry_cd.analysis.damage.grades import Grades
from masonry_cd.foundation import plugins
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.fields import Flag, Number, Table
from masonry_cd.foundation.table_schema import table_of_its_own
from masonry_cd.foundation.units import Unit
from reports.extra import EXTRA


def _list_of_numbers(value: object) -> object:
    """A list as a tuple; of anything else it is said what it should be."""
    if isinstance(value, list):
        return tuple(value)
    raise ValueError("should be a list of numbers, [1.0, 2.5]")


def _names_of_extra(value: object) -> object:
    """Names of further reports, as a tuple."""
    names = tuple(value) if isinstance(value, list) else ("",)
    unknown = next((name for name in names if name not in EXTRA and name not in plugins.names("reports")), None)
    if unknown is not None:
        known = ", ".join([*EXTRA, *plugins.names("reports")])
        raise ValueError(f"should be a list of names of {known}" + (f', "{unknown}" is none' if unknown else ""))
    return names


def _known_extra(schema: dict[str, Any]) -> None:
    """What the JSON schema says of them."""
    schema["items"] = {"enum": [*EXTRA]}


def _words(value: object) -> object:
    """A line of text."""
    if not isinstance(value, str):
        raise ValueError('should be a text, "..."')
    if not value.strip() or len(value) > LONGEST_WORDS or any(ord(letter) < 32 for letter in value):
        raise ValueError(f"should be one line of 1 to {LONGEST_WORDS} letters")
    return value.strip()


LONGEST_WORDS = 200  # letters of a line of the title block
Words = Annotated[str, BeforeValidator(_words), Field(min_length=1, max_length=LONGEST_WORDS)]


class Report(Table):
    """The table ``[report]``: what is drawn after the run."""

    project: Words | None = None
    """Of the title block of the page and its PDF."""
    client: Words | None = None
    """For whom the report is; of the title block."""
    author: Words | None = None
    """Who answers for it; of the title block."""
    date: Words | None = None
    """Of the report, as it is to be printed; the day on which the page is written when not given."""
    crack_map: Flag = False
    """Draw crack_map.png."""
    vector: Flag = False
    """Draw crack_map.svg and crack_map.pdf, in which blocks and joints are polygons that print sharp at any size."""
    view: Literal["auto", "front", "back", "side", "left", "top", "isometric"] = "auto"
    """From where."""
    scale: Annotated[Number, Field(gt=0)] | None = None
    """Amplification of the displacements in it; picked so that they are visible when not given."""
    opened: Annotated[Number, Unit("m"), Field(gt=0)] = 1e-4
    """Smallest opening of a joint that counts as opened."""
    slid: Annotated[Number, Unit("m"), Field(gt=0)] = 1e-4
    """Smallest sliding of a joint that counts as slid."""
    damage: Flag = False
    """Write the damage by part: damage.csv, damage_history.csv, hinges.csv, drift.csv, damage.json."""
    grades: Annotated[dict[str, Any], Field(json_schema_extra=table_of_its_own(Grades))] = Field(default_factory=dict)
    """Thresholds and labels of the grades D0 to D5; checked by the package reports."""
    largest: Annotated[Number, Unit("m"), Field(gt=0)] = 0.05
    """Where the last class of the crack map's colours begins."""
    cut: str = ""
    """Plane by which the crack map is cut: "y=1.5", in m, "y=150 cm", or "y" for the middle."""
    thrust: Flag = False
    """Draw the line of thrust in it."""
    times: Annotated[tuple[Annotated[Number, Field(ge=0)], ...], Unit("s"), BeforeValidator(_list_of_numbers)] = ()
    """Draw crack maps at these times as well."""
    animation: Flag = False
    """Draw crack_map.gif."""
    html: Flag = False
    """Write report.html, a page that shows the run."""

    stress: Flag = False
    """Keep the mean stress of the blocks and the largest compression of the joints; write stress.csv, joint_stress.csv,
    element_stress.csv where blocks are meshed, and stress_map.png. A ``material.compressive_strength`` asks for it as well."""
    extra: Annotated[tuple[str, ...], BeforeValidator(_names_of_extra), Field(json_schema_extra=_known_extra)] = ()
    """Further reports by name: "energy" draws energy.png, what was put in, where it went, the balance."""

    @property
    def asks(self) -> bool:
        """Whether anything is to be written beside joints.csv."""
        return self.damage or self.html or self.draws or bool(self.extra)

    @property
    def draws(self) -> bool:
        """Whether a picture of the structure is to be drawn; what extra reports need, they say themselves."""
        return self.crack_map or self.vector or bool(self.times) or self.animation


def report_of(tables: Mapping[str, Any], **changes: object) -> Report:
    """The table ``[report]`` of a scene's tables, with the changes that are not None."""
    table = tables.get("report", {})
    return parse_table(Report, table | {key: value for key, value in changes.items() if value is not None}, "report")
