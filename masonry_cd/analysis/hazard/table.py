# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[hazard]``: how often the ground of a site shakes how strongly, and the life of the building that stands there.

Return periods as national tools print them, or a curve of frequencies, in the scene or in a file; and with neither a reference life alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.analysis.hazard.curve import PGA, Hazard
from masonry_cd.analysis.hazard.files import read_hazard
from masonry_cd.analysis.hazard.life import Life
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

Positive = Annotated[Number, Field(gt=0.0)]
PERIOD_ROWS, CURVE_ROWS = ("return_period", "ag", "f0", "tc_star"), ("intensity", "frequency", "probability")
ON_ROCK = Usual(0.15, 15.0, "hazard maps give 0.15 m/s2 (0.015 g) at 30 years to 15 at 2475", ACCELERATIONS)


class HazardTable(Table):
    """The keys of the table."""

    path: Annotated[str, Field(min_length=1)] | None = None
    """CSV file with the rows: columns return_period_years and ag_g or ag_m_s2, f0, tc_star_s; or intensity_g or intensity_m_s2 with
    frequency_per_year or probability; or a hazard curve of OpenQuake."""
    return_period: list[Positive] | None = None
    """Return periods [years] of a table, rising."""
    ag: list[Annotated[Positive, Unit("m/s2"), ON_ROCK]] | None = None
    """Peak ground acceleration on rock at each of them."""
    f0: list[Positive] | None = None
    """F0 of NTC at each of them."""
    tc_star: list[Annotated[Positive, Unit("s")]] | None = None
    """T*_C of NTC at each of them."""
    measure: Annotated[str, Field(min_length=1)] = PGA
    """Intensity measure of a curve, as a study names it: "PGA", "Sa(0.5)"."""
    intensity: list[Annotated[Positive, Unit("m/s2")]] | None = None
    """Intensities of a curve, rising; of other measures than accelerations numbers in their SI unit."""
    frequency: list[Positive] | None = None
    """Mean annual frequency at which each of them is exceeded, falling."""
    probability: list[Annotated[Number, Field(gt=0.0, lt=1.0)]] | None = None
    """In place of frequency: the probability that each of them is exceeded within ``years``."""
    years: Positive | None = None
    """Time within which these probabilities are meant [years]."""
    lon: Annotated[Number, Unit("degrees"), Field(ge=-180.0, le=180.0)] | None = None
    """Longitude of the site in a file of OpenQuake with several."""
    lat: Annotated[Number, Unit("degrees"), Field(ge=-90.0, le=90.0)] | None = None
    """Latitude of the site."""
    nominal_life: Annotated[Number, Field(ge=10.0, le=1000.0)] = 50.0
    """V_N [years]."""
    use_class: Literal["I", "II", "III", "IV"] = "II"
    """Class of use of NTC 2018, C_U = 0.7, 1, 1.5 and 2: farms, dwellings, crowds, strategic buildings."""

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        given = [name for name in ("path", "return_period", "intensity") if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"{given[1]}: does not apply next to {given[0]}")
        rows, form = self.rows, given[0] if given else ""
        known = {"return_period": PERIOD_ROWS, "intensity": CURVE_ROWS}.get(form, ())
        if stray := [name for name in rows if name not in known]:
            raise ValueError(f"{stray[0]}: does not apply {f'next to {form}' if form else 'without return_period or intensity'}")
        if (self.lon is None) != (self.lat is None) or (self.lon is not None and self.path is None):
            raise ValueError("lon: a site in a file has lon and lat; other rows are of one site")
        if "measure" in self.model_fields_set and form in ("return_period", ""):
            raise ValueError("measure: a table of return periods is of ag, PGA on rock")
        if self.years is not None and self.probability is None and self.path is None:
            raise ValueError("years: belongs to probability")
        if rows:
            check_rows(rows, self.years)
        return self

    @property
    def rows(self) -> dict[str, list[float]]:
        """The lists that are given, by key."""
        found = {name: getattr(self, name) for name in (*PERIOD_ROWS, *CURVE_ROWS)}
        return {name: values for name, values in found.items() if values is not None}


def check_rows(rows: Mapping[str, Sequence[float]], years: float | None) -> None:
    """Refuse columns that are no hazard.

    Raises:
        ValueError: names the column.
    """
    first = "return_period" if "return_period" in rows else "intensity"
    if first not in rows:
        raise ValueError("return_period: missing; give return_period with ag, or intensity with frequency or probability")
    other = "ag" if first == "return_period" else "frequency"
    if (other in rows) + ("probability" in rows) != 1:
        raise ValueError("ag: missing" if other == "ag" else "frequency: give frequency or probability, one of the two")
    if "probability" in rows and years is None:
        raise ValueError("years: missing; within which the probabilities are meant")
    for name, values in rows.items():
        if len(values) != len(rows[first]):
            raise ValueError(f"{name}: has {len(values)} values, and {first} has {len(rows[first])}")
        steps = np.diff(np.asarray(values, dtype=float))
        wrong = {"return_period": steps <= 0.0, "ag": steps <= 0.0, "intensity": steps <= 0.0}.get(name)
        wrong = steps > 0.0 if wrong is None and name in ("frequency", "probability") else wrong
        if wrong is not None and wrong.any():
            k, way = int(np.flatnonzero(wrong)[0]), "fall or stay" if name in ("frequency", "probability") else "rise"
            raise ValueError(f"{name}: should {way} from row to row, and {values[k + 1]:g} follows {values[k]:g}")
    if len(rows[first]) < 2:
        raise ValueError(f"{first}: two rows are needed, or more")


def hazard_of(table: HazardTable, folder: Path) -> Hazard:
    """The hazard that a table gives; ``folder``: where the path of a file begins.

    Raises:
        InputError: a file that cannot be read, or holds no hazard.
    """
    rows, measure, years, notes = table.rows, table.measure, table.years, tuple[str, ...]()
    if table.path is not None:
        file = folder / table.path
        found = read_hazard(file, None if table.lon is None or table.lat is None else (table.lon, table.lat))
        stated = measure if "measure" in table.model_fields_set else None
        if found.measure and stated and same_measure(stated) != same_measure(found.measure):
            raise InputError("hazard.measure", f'"{stated}" is required, and {file} is of {found.measure}')
        rows, measure, years, notes = found.rows, found.measure or measure, found.years or years, found.notes
        try:
            check_rows(rows, years)
        except ValueError as failure:
            raise InputError(file, str(failure)) from None
    return _hazard(rows, same_measure(measure), years, Life(table.nominal_life, table.use_class), notes)


def _hazard(rows: Mapping[str, Sequence[float]], measure: str, years: float | None, life: Life, notes: tuple[str, ...]) -> Hazard:
    """A hazard of rows that are checked."""
    columns = {name: np.array(values, dtype=float) for name, values in rows.items()}
    if "return_period" in columns:
        more = (columns.get("f0"), columns.get("tc_star"))
        return Hazard(PGA, columns["ag"], 1.0 / columns["return_period"], *more, life, notes)
    if not columns:
        return Hazard(measure, np.zeros(0), np.zeros(0), life=life, notes=notes)
    often = columns.get("frequency")
    if often is None:
        often = np.array([-math.log1p(-each) / (years or 1.0) for each in rows["probability"]])
    return Hazard(measure, columns["intensity"], often, life=life, notes=notes)


def same_measure(name: str) -> str:
    """A measure without blanks and with numbers as short as they can be: "Sa(0.50)" is "Sa(0.5)"."""
    head, bracket, rest = "".join(name.split()).partition("(")
    inside, _, end = rest.partition(")")
    try:
        numbers = ",".join(f"{float(word):.15g}" for word in inside.split(","))
    except ValueError:
        return "".join(name.split())
    return f"{head}({numbers}){end}" if bracket else head
