# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[records]`` of a study file."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from loads.readers import FormatName
from loads.signal.accelerogram import Accelerogram
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.fields import Instant, Number, Table
from masonry_cd.foundation.units import Unit

GROUPS = ("motion", "component")
PASSED_ON = (  # to each load of kind "record"
    *("format", "column", "units", "quantity", "layout"),
    *("taper", "resample", "band", "band_order", "correction"),
)


class Trim(Table):
    """Which part of a motion is used, by how its Arias intensity builds up; its components are cut alike."""

    arias: list[Annotated[Number, Field(ge=0, le=1)]]
    """[from, to], shares of the end value, as [0.001, 0.999]; of all components that shake, added up."""
    before: Instant = 0.0
    """Additional time before it."""
    after: Instant = 0.0
    """Additional time after it."""

    @field_validator("arias")
    @classmethod
    def _two(cls, value: list[float]) -> list[float]:
        if len(value) != 2 or not value[0] < value[1]:
            raise ValueError("should be two shares [from, to], from < to")
        return value


class RecordsTable(Table):
    """The table ``[records]``: files of a folder, or seeds of a load that draws its motion."""

    folder: str | None = None
    """Folder of the files, relative to the study file."""
    pattern: str = r"(?P<motion>.+)_(?P<component>[^_]+)\.[^.]+"
    """Regular expression that the name of a file matches as a whole; its groups are motion and component."""
    x: list[str] = Field(default_factory=list)
    """Components that shake along x: of each motion the first that it has."""
    y: list[str] = Field(default_factory=list)
    """Components that shake along y."""
    z: list[str] = Field(default_factory=list)
    """Components that shake along z."""
    shake: list[Literal["x", "y", "z"]] | None = None
    """Axes along which the base moves; all that are given. Measures may take the others too."""
    exclude: list[str] = Field(default_factory=list)
    """Motions that are left out; * stands for anything."""
    rotate: Annotated[Number, Unit("degrees")] = 0.0
    """Turns the horizontal pair about z, counter-clockwise seen from above; [vary] may vary "records.rotate"."""
    scale: Annotated[Number, Field(gt=0)] = 1.0
    """Factor on all motions that are not scaled to a level."""
    factors: Annotated[dict[str, Annotated[Number, Field(gt=0)]], Field(min_length=1)] | None = None
    """The only motions used, each with its own factor in addition to scale; masonry-cd select writes them."""
    dt: Annotated[Number, Unit("s"), Field(gt=0)] | None = None
    """Time step, where the files have no times."""
    units: str | None = None
    """Units of the values, where the files do not say: "m/s2", "g"."""
    quantity: Literal["acceleration", "velocity", "displacement"] | None = None
    """Quantity of the values, where they are not accelerations, or where the files leave it open."""
    layout: Literal["columns", "series", "pairs"] | None = None
    """Layout of tables of numbers that could be read in several ways."""
    format: FormatName = "auto"
    """Format of the files; recognised by their content when "auto"."""
    column: str | int | None = None
    """Column of files with several: a heading, or a place counted from 0."""
    window: Annotated[list[Number], Unit("s")] | None = None
    """Part of all motions to use, [from, to]."""
    trim: Trim | None = None
    """Part of each motion by its Arias intensity, instead of a window."""
    rest: Instant = 0.0
    """How long each run goes on after its motion."""
    duration: Literal["record", "scene"] = "record"
    """Duration of runs: that of their motions, or run.duration of the scene."""
    taper: Instant = 0.0
    """Length over which the acceleration rises and falls at the ends of the window."""
    resample: Annotated[Number | Literal["run"], Unit("s")] | None = None
    """Time step to resample to, or "run" for that of the run."""
    band: Annotated[list[Number], Unit("Hz")] | None = None
    """Corners of a band-pass, [from, to]."""
    band_order: Annotated[int, Field(strict=True, ge=1, le=8)] = 4
    """Order of the band-pass."""
    correction: Literal["none", "linear", "quadratic", "cubic"] = "quadratic"
    """Correction of the baseline."""
    key: str | None = None
    """Instead of a folder: key of the scene by whose values motions differ, "loads[0].seed"."""
    values: list[Any] | None = None
    """Values of that key, one motion for each."""

    @field_validator("pattern")
    @classmethod
    def _is_pattern(cls, value: str) -> str:
        try:
            names = re.compile(value).groupindex
        except re.error as failure:
            raise ValueError(f"no regular expression: {failure}") from None
        except RecursionError:
            raise ValueError("no regular expression: brackets nested too deep") from None
        missing = [name for name in GROUPS if name not in names]
        if missing:
            raise ValueError(f"has no group (?P<{missing[0]}>...); it needs both {' and '.join(GROUPS)}")
        return value

    @model_validator(mode="after")
    def _consistent(self) -> RecordsTable:
        if (self.folder is None) == (self.key is None):
            raise ValueError("give folder, or key and values")
        if (self.key is None) != (self.values is None):
            raise ValueError("values: missing" if self.values is None else "values: belongs to key")
        if self.values is not None and (not self.values or len({repr(value) for value in self.values}) < len(self.values)):
            raise ValueError("values: should be values, each once")
        if self.key is not None and self.factors is not None:
            raise ValueError("factors: of the motions of a folder; leave it out")
        if self.folder is not None and not (self.x or self.y or self.z):
            raise ValueError('x: missing; which components shake along x, as ["NS", "H1"]')
        if self.shake is not None and not self.shake:
            raise ValueError("shake: names no axis; leave it out for all that are given")
        for axis in self.shake or ():
            if not getattr(self, axis):
                raise ValueError(f'shake: names "{axis}", of which no components are given')
        if self.window is not None and self.trim is not None:
            raise ValueError("give window or trim, not both")
        if self.folder is not None:
            parse_table(Accelerogram, {"path": "", **self.load_keys(None)}, "")
        return self

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that have components."""
        return tuple(axis for axis in "xyz" if getattr(self, axis))

    @property
    def shaken(self) -> tuple[str, ...]:
        """The axes along which the base moves."""
        return self.axes if self.shake is None else tuple(axis for axis in "xyz" if axis in self.shake)

    def load_keys(self, window: tuple[float, float] | None) -> dict[str, Any]:
        """The keys of ``kind = "record"`` that all components share."""
        default = Accelerogram.model_fields
        keys = {key: getattr(self, key) for key in PASSED_ON if getattr(self, key) != default[key].default}
        if self.dt is not None:
            keys["time_step"] = self.dt
        chosen = window if window is not None else self.window
        return keys if chosen is None else keys | {"window": list(chosen)}
