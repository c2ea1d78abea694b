# SPDX-License-Identifier: GPL-3.0-or-later
"""The selection file: a TOML text that says which records a set is chosen from, and what its spectra should be.

n = 7
[records]       folder, pattern, x ...       # as in a study
[target]        spectrum, ag ..., period     # the code at the site, sigma if need be, and over which periods
[candidates]    catalogue, magnitude ...     # optional: which of the records may be chosen, and how far they are scaled
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from loads.signal.accelerogram import between
from loads.signal.code_spectrum import SiteSpectrum
from loads.signal.directions import AXES, Rule
from loads.signal.spectral_correlation import LONGEST, SHORTEST
from masonry_cd.analysis.accelerogram_rule import RANGE
from masonry_cd.app.scene import Origin
from masonry_cd.app.scene_text import parse_toml, read_text
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.fields import Count, Flag, Span, Table, is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.solvers.options import LARGEST_SEED
from masonry_cd.studies.study.record_tables import RecordsTable

MOST, MOST_SIGMA = 1000, 2.0  # records of a set; standard deviation of ln Sa


def _limits(value: Any) -> tuple[float, float]:
    """The least and the largest factor."""
    given = (1.0, 1.0) if value == "none" else value
    if not (isinstance(given, (list, tuple)) and len(given) == 2 and all(map(is_number, given)) and 0.0 < given[0] <= given[1]):
        raise ValueError(f'must be [least, most], above 0, or "none"; given: {value}')
    return float(given[0]), float(given[1])


def _deviations(value: Any) -> tuple[tuple[float, float], ...]:
    """Pairs of a period and a standard deviation; one at period zero where it is the same at all periods."""
    pairs = [(0.0, value)] if is_number(value) else list(value) if isinstance(value, (list, tuple)) else []
    sound = all(isinstance(pair, (list, tuple)) and len(pair) == 2 and all(map(is_number, pair)) for pair in pairs) and bool(pairs)
    if (
        not sound
        or not all(0.0 <= number <= MOST_SIGMA for _, number in pairs)
        or any(one[0] >= next_[0] for one, next_ in pairwise(pairs))
    ):
        raise ValueError(f"must be a number from 0 to {MOST_SIGMA:g}, or pairs of a period and such a number, as [[0.1, 0.5], [1.0, 0.6]]")
    return tuple((float(period), float(number)) for period, number in pairs)


_NUMBER: dict[str, Any] = {"type": "number"}
_PAIR: dict[str, Any] = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}
Limits = Annotated[tuple[float, float], BeforeValidator(_limits), WithJsonSchema({"anyOf": [_PAIR, {"const": "none"}]})]
Deviations = Annotated[
    tuple[tuple[float, float], ...], BeforeValidator(_deviations), WithJsonSchema({"anyOf": [_NUMBER, {"type": "array", "items": _PAIR}]})
]
Range = tuple[float, float] | None


class TargetTable(SiteSpectrum):
    """The table ``[target]``."""

    period: Span | None = None
    """Period T1 of the structure: spectra are compared from 0.2 to 2 T1."""
    periods: Annotated[Range, Unit("s"), between("seconds", SHORTEST - 1e-9, LONGEST)] = None
    """Range in which they are compared, [from, to], in its place; with both EN 1998-1 is judged from 0.2 to 2 T1 in any case."""
    sigma: Deviations | None = None
    """Standard deviation of ln Sa that the set should have: a number, or pairs [period, number]; the mean alone counts when not given."""
    of: Rule = "x"
    """Component "x", "y" or "z" whose spectrum counts; or both horizontal ones by "geometric_mean", "larger", "rotd50" or "rotd100"."""

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.spectrum is None:
            raise ValueError("spectrum: missing")
        if self.period is None and self.periods is None:
            raise ValueError("period: missing; T1 of the structure, or periods = [from, to]")
        if self.period is not None and (self.judged[0] < SHORTEST or self.judged[1] > LONGEST):
            raise ValueError(f"period: {RANGE[0]:g} and {RANGE[1]:g} T1 must lie from {SHORTEST:g} to {LONGEST:g} s")
        if self.sigma is not None and self.sigma[0][0] > 0.0 and not (self.sigma[0][0] <= self.band[0] < self.band[1] <= self.sigma[-1][0]):
            raise ValueError(f"sigma: its periods must reach from {self.band[0]:g} to {self.band[1]:g} s")
        return self

    @property
    def judged(self) -> tuple[float, float]:
        """Where the rule of EN 1998-1 is judged [s]."""
        if self.period is not None:
            return RANGE[0] * self.period, RANGE[1] * self.period
        assert self.periods is not None
        return self.periods

    @property
    def band(self) -> tuple[float, float]:
        """Where spectra are compared [s]."""
        return self.periods or self.judged

    def deviations(self, periods: np.ndarray) -> np.ndarray | None:
        """Sigma at periods (m,) of the band, straight over ln T between those given; None where the mean alone counts."""
        if self.sigma is None:
            return None
        at, values = np.array(self.sigma).T
        return np.interp(libm.log(periods), libm.log(np.maximum(at, 1e-9)), values)


class CandidatesTable(Table):
    """The table ``[candidates]``."""

    factor: Limits = (0.25, 4.0)
    """Least and largest factor, [least, most], or "none" for records as they are."""
    catalogue: str | None = None
    """CSV file, relative to this one, with a column motion and any of event, magnitude, distance_km and vs30_m_s."""
    magnitude: Annotated[Range, between("magnitudes")] = None
    """Range of magnitudes, [from, to], by the catalogue."""
    distance: Annotated[Range, Unit("km"), between("km")] = None
    """Range of distances from the source, [from, to], by the catalogue."""
    vs30: Annotated[Range, Unit("m/s"), between("m/s")] = None
    """Range of the mean velocity of shear waves in the upper 30 m of the ground, [from, to], by the catalogue."""
    per_event: Annotated[Count, Field(ge=1)] | None = None
    """Largest number of records of one event, by the catalogue."""

    @model_validator(mode="after")
    def _has_catalogue(self) -> Self:
        key = next((key for key in ("magnitude", "distance", "vs30", "per_event") if getattr(self, key) is not None), None)
        if self.catalogue is None and key is not None:
            raise ValueError(f"catalogue: missing; {key} is looked up in it")
        return self


class SelectionTables(Table):
    """The top level of the file."""

    title: str | None = None
    """Title of the picture; the name of the file when not given."""
    n: Annotated[Count, Field(ge=1, le=MOST)]
    """Number of records of the set."""
    seed: Annotated[Count, Field(ge=0, le=LARGEST_SEED)] = 0
    """Seed of the spectra that are simulated and of the sets that are drawn."""
    meet_rule: Flag = False
    """Scale the set up by one factor, if need be, so that it meets EN 1998-1, 3.2.3.1.2."""
    records: RecordsTable
    """Records to choose from, by the keys of a study."""
    target: TargetTable
    """Spectrum that the set should have."""
    candidates: CandidatesTable = Field(default_factory=CandidatesTable)
    """Records that may be chosen, and their factors."""


@dataclass(frozen=True, eq=False)
class Selection:
    """A selection file whose tables are checked."""

    tables: SelectionTables
    given: Mapping[str, Any]  # the table [records] as written
    path: Path
    origin: Origin

    @property
    def title(self) -> str:
        """The title."""
        return self.tables.title or self.path.stem


def read_selection(path: Path) -> Selection:
    """Read and check a selection file.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a value out of range; names file, line and key.
    """
    if not path.exists():
        raise InputError(path, "no such selection file")
    text = read_text(path)
    return selection_of(parse_toml(text, path), path, Origin(text, path))


def selection_of(tables: Mapping[str, Any], path: Path, origin: Origin) -> Selection:
    """Check the tables of a selection, whose paths are relative to the folder of ``path``.

    Raises:
        InputError: see :func:`read_selection`.
    """
    with origin.locating():
        top = parse_table(SelectionTables, tables, "")
        _check(top)
    return Selection(top, tables["records"], path, origin)


def _check(top: SelectionTables) -> None:
    """Check that the tables go together.

    Raises:
        InputError: names the key.
    """
    records, of = top.records, top.target.of
    if records.folder is None:
        raise InputError("records.folder", "missing")
    if records.scale != 1.0 or records.factors is not None:
        raise InputError("records.scale" if records.factors is None else "records.factors", "the selection finds the factors; leave it out")
    if records.resample == "run":
        raise InputError("records.resample", "there is no run here; give the time step")
    for axis in (of,) if of in AXES else AXES[:2]:
        if axis not in records.axes:
            raise InputError("target.of", f'"{of}" is of components {axis}, and [records] has none')
    if top.target.sigma is not None and top.n < 2:
        raise InputError("n", "one record has no standard deviation; 2 or more, or target without sigma")
