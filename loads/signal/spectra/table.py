# SPDX-License-Identifier: GPL-3.0-or-later
r"""A table of ordinates over the period, as a uniform hazard spectrum, or the multi-period spectrum of ASCE 7-22, comes.

Between periods above zero ln S is linear in ln T, between zero and the first of them S in T; nothing is read beyond the last one. The
displacement is S (T / 2 pi)^2. Several columns have a damping each: between two of them ln S is linear in ln xi. Beyond them, and of one
column, those of the nearest damping count times r = eta(xi) / eta(xi of the column), the eta of EN 1998-1:2004 and NTC 2018 (3.2.2.2,
3.2.3.2.1). As in these codes damping leaves the peak of the ground as it is: up to the period T_m of the largest ordinate S_m

    S(T, xi) = S(0) + (r S_m - S(0)) (S(T) - S(0)) / (S_m - S(0))       T <= T_m,        r S(T)     T_m <= T
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, WithJsonSchema, model_validator

from loads.motion import strict
from loads.readers.fields import decimal, delimiter_of, split
from loads.readers.source import Source
from loads.readers.units import ACCELERATION, TIME, acceleration_unit, split_heading
from loads.signal.spectra.kind import Fact, SiteKeys, SpectrumKind
from loads.signal.spectra.shape import PEAK, USUAL_DAMPING, CodeQuantity, ElasticSpectrum, common_rows, damping_factor
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Numbers, is_number
from masonry_cd.foundation.units import Unit

CLAUSE = "table"
ROWS = {
    "ag": CodeQuantity("m/s2", CLAUSE, "its ordinate at T = 0"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "ag"),
} | common_rows(CLAUSE)
PER_CENT = re.compile(r"(\d+(?:[.,]\d+)?)\s*%")  # of a heading: the damping of its column
MOST_DAMPED = 0.5


def _columns(value: object) -> tuple[tuple[float, ...], ...] | None:
    """One list of numbers, or several of them."""
    if value is None:
        return None
    rows: list[Any] = list(value) if isinstance(value, (list, tuple)) else []
    rows = [rows] if all(map(is_number, rows)) else rows
    if not rows or not all(isinstance(row, (list, tuple)) and row and all(map(is_number, row)) for row in rows):
        raise ValueError("must be a list of numbers, or such a list for each damping")
    return tuple(tuple(map(float, row)) for row in rows)


_LIST: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 2}
Columns = Annotated[
    tuple[tuple[float, ...], ...],
    BeforeValidator(_columns),
    WithJsonSchema({"anyOf": [_LIST, {"type": "array", "items": _LIST, "minItems": 1}]}),
]


class SpectrumTable(BaseModel):
    """Ordinates over the period, in a file or as they are."""

    model_config = strict

    path: str | None = None
    """Path of a CSV file, relative to the scene file: columns "period [s]" and "acceleration [g]", or several of dampings, "5 % [g]"."""
    period: Annotated[Numbers, Unit("s")] | None = None
    """Or periods, the first of them 0 or more, each longer than the one before."""
    acceleration: Annotated[Columns, Unit("m/s2")] | None = None
    """Ordinates, one for each period; with several dampings a list for each."""
    damping: Annotated[Numbers, Field(max_length=20)] | None = None
    """Damping of these ordinates; 0.05 when not given."""

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.path is None) == (self.period is None) or (self.period is None) != (self.acceleration is None):
            raise ValueError("give path, or period and acceleration")
        if self.period is not None and self.acceleration is not None:
            _check(self.period, self.acceleration, self.damping or (USUAL_DAMPING,))
        return self


class TableKeys(SiteKeys):
    """Keys of a table alone."""

    table: SpectrumTable | None = None
    """Table of ordinates over the period: a path, or period and acceleration."""


class Wrong(ValueError):
    """A fault of a table, at which of its periods."""

    def __init__(self, text: str, place: int | None = None) -> None:
        super().__init__(text)
        self.place = place


def _check(period: Sequence[float], columns: Sequence[Sequence[float]], damping: Sequence[float]) -> None:
    """Raise a :class:`Wrong` on ordinates of which no spectrum can be made."""
    if len(period) < 2:
        raise Wrong("period: two at least are needed", 0)
    for k, (one, before) in enumerate(zip(period, (-1.0, *period[:-1]), strict=True)):
        if one < 0.0:
            raise Wrong(f"period: must be 0 or more, got {one:g} s", k)
        if one <= before:
            raise Wrong(f"period: must be longer than {before:g} s, the one before, got {one:g} s", k)
    for values in columns:
        if len(values) != len(period):
            raise Wrong(f"acceleration: {len(values)} values for {len(period)} periods")
        low = next((k for k, value in enumerate(values) if value <= 0.0), None)
        if low is not None:
            raise Wrong(f"acceleration: must be above 0, got {values[low]:g} m/s2 at {period[low]:g} s", low)
    if len(damping) != len(columns):
        raise Wrong(f"damping: {len(damping)} for {len(columns)} columns of accelerations")
    if not all(0.0 < one <= MOST_DAMPED for one in damping) or len(set(damping)) < len(damping):
        raise Wrong(f"damping: must be above 0, at most {MOST_DAMPED:g}, and each another, got {', '.join(f'{one:g}' for one in damping)}")


@dataclass(frozen=True, eq=False)
class TableSpectrum(ElasticSpectrum):
    """Ordinates, straight between them as the head of this file says."""

    period: np.ndarray  # (n,) from 0 on [s]
    acceleration: np.ndarray  # (d, n) [m/s2]
    damping: np.ndarray  # (d,) ascending
    called: str = "table"

    @classmethod
    def of(cls, table: SpectrumTable, ag: float | None = None, called: str = "table") -> TableSpectrum:
        """The spectrum of a table that is read; where it begins above zero, ag is its ordinate there [m/s2]."""
        period, rows = np.array(table.period), np.array(table.acceleration)
        damping = np.array(table.damping or (USUAL_DAMPING,))
        if period[0] > 0.0:
            period, rows = np.r_[0.0, period], np.c_[np.full(len(rows), ag), rows]
        order = np.argsort(damping)
        return cls(period, rows[order], damping[order], called)

    @property
    def longest(self) -> float:
        """Its last period [s]."""
        return float(self.period[-1])

    def scales_by_eta(self, damping: float) -> bool:
        """True where no column has that damping and none has less or more."""
        return not self.damping[0] <= damping <= self.damping[-1]

    def at(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Pseudo-acceleration at periods (n,) of zero or more [m/s2].

        Raises:
            InputError: a period beyond the last one.
        """
        t, values, first = np.asarray(period, dtype=float), self._ordinates(damping), float(self.period[1])
        if t.size and t.max() > self.longest:
            raise InputError(self.called, beyond(float(t.max()), self.longest))
        logs = np.interp(libm.log(np.maximum(t, first)), libm.log(self.period[1:]), libm.log(values[1:]))
        return np.where(t < first, values[0] + (values[1] - values[0]) * t / first, libm.exp(logs))

    def _ordinates(self, damping: float) -> np.ndarray:
        """Those of a damping, (n,) [m/s2]."""
        k = int(np.searchsorted(self.damping, damping))
        if k < len(self.damping) and self.damping[k] == damping:
            return np.asarray(self.acceleration[k])
        if 0 < k < len(self.damping):
            low, high = libm.log(self.damping[k - 1 : k + 1])
            share = (float(libm.log(np.array([damping]))[0]) - low) / (high - low)
            return np.asarray(libm.exp((1.0 - share) * libm.log(self.acceleration[k - 1]) + share * libm.log(self.acceleration[k])))
        k = min(k, len(self.damping) - 1)
        values, factor = self.acceleration[k], damping_factor(damping) / damping_factor(float(self.damping[k]))
        top, start = int(np.argmax(values)), values[0]
        if top == 0:
            return np.r_[start, factor * values[1:]]
        rise = start + (factor * values[top] - start) * (values[:top] - start) / (values[top] - start)
        return np.r_[rise, factor * values[top:]]


def beyond(period: float, longest: float) -> str:
    """The words on a period that a table does not reach [s]."""
    return f"{period:.4g} s is beyond the spectrum, whose table ends at {longest:g} s"


def read_table(path: Path, label: str, damping: tuple[float, ...] | None = None) -> SpectrumTable:
    """Read a CSV file of ordinates.

    Args:
        path: of the file.
        label: how it is called in messages.
        damping: of the columns whose headings name none; 0.05 when not given.

    Raises:
        InputError: no such file, a heading without a unit, or a value that is wrong; names its line.
    """
    source = Source.open(path, label)
    (head, heading), *lines = source.content()
    delimiter = delimiter_of(source)
    if delimiter is None or not lines:
        raise source.error('no table: a line of headings, "period [s], acceleration [g]", and rows of numbers between commas are needed')
    factors, dampings = _headings(source, split(heading, delimiter), head)
    rows = []
    for index, line in lines:
        fields = split(line, delimiter)
        if len(fields) != len(factors):
            raise source.error(f"{len(fields)} columns, where the headings are {len(factors)}", index)
        rows.append([factor * source.number(decimal(field, delimiter), index) for factor, field in zip(factors, fields, strict=True)])
    if damping and dampings:
        raise InputError(label, "damping: the headings of the file say it")
    period, *columns = zip(*rows, strict=True)
    found = damping or dampings or (USUAL_DAMPING,)
    try:
        _check(period, columns, found)
    except Wrong as wrong:
        raise source.error(str(wrong), None if wrong.place is None else lines[wrong.place][0]) from None
    return SpectrumTable(period=period, acceleration=tuple(columns), damping=found)


def _headings(source: Source, headings: Sequence[str], index: int) -> tuple[list[float], tuple[float, ...]]:
    """Return the unit of each column in SI, and the dampings that the headings name."""
    names, units = zip(*map(split_heading, headings), strict=True)
    time = TIME.get((units[0] or "").lower())
    if time is None or len(headings) < 2:
        raise source.error(f'the first column is called "{headings[0]}"; "period [s]" is needed, then "acceleration [g]"', index)
    factors = [time]
    for heading, unit in zip(headings[1:], units[1:], strict=True):
        size = None if unit is None else acceleration_unit(unit)
        if size is None:
            known = ", ".join(ACCELERATION)
            raise source.error(f'the column "{heading}" has no unit of acceleration, as "acceleration [g]"; known: {known}', index)
        factors.append(size)
    found = [PER_CENT.search(name) for name in names[1:]]
    return factors, tuple(0.01 * float(one[1].replace(",", ".")) for one in found if one)


def _read(keys: Any, folder: Path, where: str) -> Any:
    """The keys with their table read."""
    table = keys.table
    if table.path is not None:
        table = read_table(folder / table.path, f"{where}.table.path: {table.path}", table.damping)
        try:
            _check_start(table, keys.ag)
        except ValueError as wrong:
            raise InputError(where, str(wrong)) from None
    return keys.model_copy(update={"table": table})


def _check_start(table: SpectrumTable, ag: float | None) -> None:
    """Raise unless the peak of the ground is known, once."""
    if table.period is None:
        return
    begins = f"the table begins at {table.period[0]:g} s"
    if table.period[0] > 0.0 and ag is None:
        raise ValueError(f"ag: missing, {begins} and does not have the peak acceleration of the ground")
    if table.period[0] == 0.0 and ag is not None:
        raise ValueError(f"ag: does not apply, {begins} with the peak acceleration of the ground")


def _grown(keys: Any, have: float, want: float) -> Any:
    """The keys of a table all of whose ordinates are those of another ag [m/s2]."""
    columns = tuple(tuple(value * want / have for value in column) for column in keys.table.acceleration)
    return keys.model_copy(
        update={"table": keys.table.model_copy(update={"acceleration": columns}), "ag": None if keys.ag is None else want}
    )


def _facts(keys: TableKeys, found: TableSpectrum) -> Iterator[Fact]:
    yield "ag", float(found.acceleration[0, 0])


def _words(keys: TableKeys) -> str:
    assert keys.table is not None and keys.table.period is not None
    return f" of {len(keys.table.period)} periods up to {keys.table.period[-1]:g} s"


SPECTRA = {
    "table": SpectrumKind(
        TableKeys,
        ("table",),
        lambda keys, vertical, gravity: TableSpectrum.of(keys.table, keys.ag),
        ROWS,
        _facts,
        lambda _, found: float(found.acceleration[0, 0]),
        _grown,
        ("ag",),
        words=_words,
        check=lambda keys: _check_start(keys.table, keys.ag),
        read=_read,
    )
}
