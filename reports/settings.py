# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[report]`` of a scene: what is drawn and written after the run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from masonry_cd.analysis.damage.grades import Grades
from masonry_cd.foundation import plugins
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.extensions import Entries
from masonry_cd.foundation.fields import Flag, Number, Table
from masonry_cd.foundation.table_schema import table_of_its_own
from masonry_cd.foundation.units import Unit


def _list_of_numbers(value: object) -> object:
    """A list as a tuple; of anything else it is said what it should be."""
    if isinstance(value, list):
        return tuple(value)
    raise ValueError("should be a list of numbers, [1.0, 2.5]")


def _outputs_by_name(schema: dict[str, Any]) -> None:
    """Adds our outputs that a key of their own name asks for to the JSON schema."""
    for name, output in OUTPUTS.items():
        if output.asked is None and name not in Report.model_fields:
            said = "; ".join(f"{file}: {meaning}" for file, meaning in output.files.items())
            schema["properties"][name] = {"type": "boolean", "default": False, "description": f"Write {said}."}
    schema["additionalProperties"] = False


def _words(value: object) -> object:
    """A line of text."""
    if not isinstance(value, str):
        raise ValueError('should be a string, "..."')
    if not value.strip() or len(value) > LONGEST_WORDS or any(ord(letter) < 32 for letter in value):
        raise ValueError(f"should be one line of 1 to {LONGEST_WORDS} characters")
    return value.strip()


OUTPUTS: Entries[Any] = Entries("reports.outputs", "OUTPUTS")  # an Output of reports/files.py each, which gets these settings
LONGEST_WORDS = 200  # letters of a line of the title block
Words = Annotated[str, BeforeValidator(_words), Field(min_length=1, max_length=LONGEST_WORDS)]


class Report(Table):
    """The table ``[report]``: what is drawn after the run. An output without a field here is requested by its name, see
    :mod:`reports.files`."""

    model_config = ConfigDict(extra="allow", json_schema_extra=_outputs_by_name)

    project: Words | None = None
    """Project in the title block of the page and its PDF."""
    client: Words | None = None
    """Client of the report; in the title block."""
    author: Words | None = None
    """Person responsible for the report; in the title block."""
    date: Words | None = None
    """Date of the report, as it is to be printed; the day on which the page is written when not given."""
    crack_map: Flag = False
    """Draw crack_map.png."""
    vector: Flag = False
    """Draw crack_map.svg and crack_map.pdf, in which blocks and joints are polygons that print sharp at any size."""
    view: Literal["auto", "front", "back", "side", "left", "top", "isometric"] = "auto"
    """View of the picture."""
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
    """Lower bound of the last class of colours of the crack map."""
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

    @classmethod
    def further_keys(cls) -> tuple[str, ...]:
        """The names of outputs that have no field here: ours and those of packages."""
        own = (name for name, output in OUTPUTS.items() if output.asked is None and name not in cls.model_fields)
        return (*own, *plugins.names("reports"))

    @model_validator(mode="after")
    def _names_of_outputs(self) -> Report:
        given = self.model_extra or {}
        known = self.further_keys() if given else ()
        wrong: list[Any] = []
        for name, value in given.items():
            if name not in known or not isinstance(value, bool):
                wrong.append({"type": "bool_type" if name in known else "extra_forbidden", "loc": (name,), "input": value})
        if wrong:
            raise ValidationError.from_exception_data("report", wrong)
        return self

    @property
    def by_name(self) -> tuple[str, ...]:
        """The outputs without a field here that the scene asks for."""
        return tuple(name for name, asked in (self.model_extra or {}).items() if asked)

    @property
    def asks(self) -> bool:
        """Return True if anything is to be written in addition to joints.csv."""
        return bool(self.damage or self.html or self.crack_map or self.vector or self.times or self.animation or self.by_name)


def report_of(tables: Mapping[str, Any], **changes: object) -> Report:
    """The table ``[report]`` of a scene's tables, with the changes that are not None."""
    table = tables.get("report", {})
    return parse_table(Report, table | {key: value for key, value in changes.items() if value is not None}, "report")
