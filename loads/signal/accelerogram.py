# SPDX-License-Identifier: GPL-3.0-or-later
"""From a file to a motion: an accelerogram is read, cut, cleaned, integrated and its baseline corrected, in this order:

    read (units) -> accelerations -> window -> mean off, taper -> resampling -> band-pass -> integration -> baseline correction

Steps that the scene does not request are left out. The mean is taken off only where a taper or a band-pass would turn an offset of the
instrument into a pulse, and not when the baseline is to be left as it is. Integration is exact (``loads.signal.baseline``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, model_validator

from loads.motion import STANDARD_GRAVITY, Positive, describe, strict
from loads.readers import FormatName, RawRecord, Request, Source, read
from loads.readers.units import acceleration_unit, measured_by
from loads.signal.baseline import ORDERS, GroundHistory, correct, integrate
from loads.signal.filters import band_pass, resample, taper_factors
from loads.signal.intensity import arias, in_words, intensity
from loads.signal.series import Keys, accelerations
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant, is_number
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

PEAK = Usual(0.6, 2.0 * STANDARD_GRAVITY, "0.6 m/s2 (0.06 g) harms hardly any masonry, and few records exceed 2 g", ACCELERATIONS)
FEWEST = 8  # samples
LEVEL = 1e-9  # of the largest sample: a record that varies by less is an offset and rounding
OFFSET = 0.02  # of the PGA: means of sound records stay below, also of windows with some shaking left at their ends


def between(what: str, above: float = -np.inf, most: float = np.inf) -> BeforeValidator:
    """Check a key of two numbers in a unit, the first below the second."""

    def read(value: object) -> tuple[float, float] | None:
        if value is None:
            return None
        numbers = list(value) if isinstance(value, (list, tuple)) else []
        if len(numbers) != 2 or not all(map(is_number, numbers)) or not above < numbers[0] < numbers[1] <= most:
            limits = f", from {above:g} to {most:g}" if most < np.inf else f", above {above:g}" if above > -np.inf else ""
            raise ValueError(f"must be [from, to] in {what}, from < to{limits}; given: {value}")
        return float(numbers[0]), float(numbers[1])

    return BeforeValidator(read)


def _column(value: object) -> str | int | None:
    """A heading or a place."""
    if isinstance(value, bool) or not (value is None or isinstance(value, (str, int))):
        raise ValueError("must be the heading of a column, or its place counted from 0")
    return value


def _resampling(value: object) -> float | str | None:
    """A time step or the word for that of the run."""
    number = isinstance(value, (int, float)) and is_number(value) and value > 0.0
    if value is None or value == "run" or number:
        return float(value) if isinstance(value, (int, float)) else None if value is None else "run"
    raise ValueError('must be a time step above zero, in seconds, or "run" for that of the run')


Column = Annotated[str | int | None, BeforeValidator(_column)]
Resampling = Annotated[float | str | None, Unit("s"), BeforeValidator(_resampling)]


class Accelerogram(BaseModel):
    """The keys that say which accelerogram, and what is done to it."""

    model_config = strict

    path: str
    """Path of the record, relative to the scene file."""
    format: FormatName = "auto"
    """Recognised by the content of the file when "auto"."""
    column: Column = None
    """Column of a file with several: its heading, or its place counted from 0; the channel or component of other formats."""
    units: str | None = None
    """Units of the values, where the file does not say, as "m/s2" or "g"."""
    quantity: Literal["acceleration", "velocity", "displacement"] | None = None
    """Quantity of the values, where they are no accelerations, which are then made of them, or where the file leaves it open."""
    layout: Literal["columns", "series", "pairs"] | None = None
    """Layout of a table of numbers that could be read in several ways: side by side, or one series, or (time, value) pairs, several to a
    line."""
    calibration: Annotated[float, Field(gt=0.0)] | None = None
    """Size of one count, in units; of files that hold counts, such as miniSEED."""
    time_step: Annotated[Positive, Unit("s")] | None = None
    """The time step of a file without times, or in place of those of a table."""
    skip: Annotated[int, Field(ge=0)] = 0
    """Lines at the head of the file to pass over."""
    window: Annotated[tuple[float, float] | None, Unit("s"), between("seconds of the record")] = None
    """Part of the record to use, [from, to], in its own time."""
    taper: Instant = 0.0
    """Length over which the acceleration rises and falls at the ends of the window."""
    resample: Resampling = None
    """Time step to resample to, or "run" for that of the run, without aliasing."""
    band: Annotated[tuple[float, float] | None, Unit("Hz"), between("Hz", 0.0)] = None
    """Corners of a zero-phase Butterworth band-pass, [from, to]."""
    band_order: Annotated[int, Field(ge=1, le=8)] = 4
    """Order of the band-pass."""
    correction: Literal["none", "linear", "quadratic", "cubic"] = "quadratic"
    """Correction of the baseline."""


@dataclass(frozen=True, eq=False)
class Processed:
    """An accelerogram before and after, both from rest."""

    before: GroundHistory  # the window as it was read
    after: GroundHistory
    begin: float  # time of the first sample, in the record's own time [s]
    format: str
    column: str
    quantity: str = "acceleration"  # of the samples of the file
    notes: tuple[str, ...] = ()  # what the reader did to them
    unit: str | None = None  # of the samples: that of the file, or a key that names another than m/s2

    def scaled(self, factor: float) -> Processed:
        """Both motions times a factor."""
        return replace(self, before=self.before.scaled(factor), after=self.after.scaled(factor))

    @cached_property
    def about_mean(self) -> GroundHistory:
        """The window as it was read, without its mean: instruments and digitisers have an offset, which is not a motion."""
        values = self.before.acceleration
        return integrate(values - values.mean(), self.before.step)

    def offset(self) -> dict[str, float] | None:
        """The mean [m/s2] where it counts, with PGA [m/s2] and Arias intensity [m/s] without it."""
        mean = float(self.before.acceleration.mean())
        level = self.about_mean
        peak = level.numbers()["pga"]
        if abs(mean) <= OFFSET * peak:
            return None
        return {"mean": mean, "pga": peak, "arias": float(arias(level)[-1])}

    def numbers(self) -> dict[str, Any]:
        """Return the numbers for the summary."""
        offset = self.offset()
        return {
            **({} if self.quantity == "acceleration" else {"quantity": self.quantity}),
            **({} if offset is None else {"offset": offset}),
            **({} if self.unit is None else {"unit": self.unit}),
            "format": self.format,
            "column": self.column,
            "window": [self.begin, self.begin + self.after.duration],
            "time_step": self.after.step,
            "before": self.before.numbers() | intensity(self.before),
            "after": self.after.numbers() | intensity(self.after),
        }


class Scaled(BaseModel):
    """A motion of a given size."""

    model_config = strict

    scale: float | None = None
    """Factor on the motion."""
    target_pga: Annotated[Positive, Unit("m/s2"), PEAK] | None = None
    """Peak acceleration to scale to, instead of a factor."""

    @model_validator(mode="after")
    def _one_size(self) -> Self:
        if self.scale is not None and self.target_pga is not None:
            raise ValueError("give scale or target_pga, not both")
        if self.scale == 0.0:
            raise ValueError("scale: must not be zero")
        return self

    def factor(self, peak: float) -> float:
        """Return the factor for a motion of a given peak acceleration."""
        return self.target_pga / peak if self.target_pga is not None else 1.0 if self.scale is None else self.scale


def process(table: Accelerogram, folder: Path, dt: float, where: str) -> Processed:
    """Read an accelerogram and do to it what its keys say.

    Args:
        table: the keys.
        folder: to which its path is relative.
        dt: time step of the run, for ``resample = "run"`` [s].
        where: the table's name in messages, e.g. ``loads[0]``.

    Raises:
        InputError: a file that cannot be read, named with its line; unknown units; a window outside the record; keys that do not fit it.
    """
    label = f"{where}.path: {table.path}"
    source = Source.open(folder / table.path, label, table.skip)
    name, raw = read(source, table.format, Request(table.column, table.time_step, table.calibration, table.layout))
    whole, quantity = accelerations(raw, Keys(table.quantity, table.units, table.calibration), where, table.path)
    values, begin = _cut(whole, raw, table, where)
    if not values.any():
        raise InputError(label, "the record is zero throughout")
    if np.ptp(values) <= LEVEL * np.abs(values).max():
        raise InputError(label, f"the record is constant throughout, at {values[0]:.4g} m/s2: there is no shaking in it")
    before = integrate(values, raw.step)
    cleaned, step = _clean(values, raw.step, table, dt, where)
    after = correct(integrate(cleaned, step), ORDERS[table.correction])
    by_key = table.units if table.units is not None and acceleration_unit(table.units) != 1.0 else None
    return Processed(before, after, begin, name, raw.name, quantity, raw.notes, raw.unit if raw.unit and measured_by(raw.unit) else by_key)


def _clean(values: np.ndarray, step: float, table: Accelerogram, dt: float, where: str) -> tuple[np.ndarray, float]:
    """Mean, taper, resampling, band-pass: the samples and their step."""
    if table.band is not None or (table.taper > 0.0 and table.correction != "none"):
        values = values - values.mean()
    key = "taper"
    try:
        values = values * taper_factors(len(values), step, table.taper)
        if table.resample is not None:
            key, wanted = "resample", dt if isinstance(table.resample, str) else table.resample
            values, step = resample(values, step, wanted), wanted
            if len(values) < FEWEST:
                raise ValueError(f"{len(values)} samples are left, at least {FEWEST} are needed")
        if table.band is not None:
            key = "band"
            values = band_pass(values, step, *table.band, table.band_order)
    except ValueError as failure:
        raise InputError(f"{where}.{key}", str(failure)) from None
    return values, step


def describe_both(where: str, processed: Processed, correction: str) -> list[str]:
    """Peaks before and after on two lines, intensity and duration on a third; what the mean adds where it counts."""
    numbers = processed.numbers()
    before, after = numbers["before"], numbers["after"]
    lines = [f"{where}   {note}" for note in processed.notes]
    if processed.quantity != "acceleration":
        lines.append(
            f"{where}   a record of {processed.quantity}, differentiated {'once' if processed.quantity == 'velocity' else 'twice'}"
        )
    lines.append(f"{where}   before correction:    {describe(before)}")
    if "offset" in numbers:
        lines.append(f"{where}   {_without(numbers['offset'], before)}")
    if correction != "none":
        lines.append(f"{where}   {correction + ' correction:':21} {describe(after)}")
    lines.append(f"{where}   {in_words(after)}")
    return lines


def _without(offset: dict[str, float], before: dict[str, float]) -> str:
    """PGA and Arias intensity with and without the mean."""
    return (
        f"mean {offset['mean']:.4g} m/s2: PGA {before['pga']:.4g} m/s2 with it, {offset['pga']:.4g} without it; "
        f"Arias intensity {before['arias']:.4g} m/s with it, {offset['arias']:.4g} without it"
    )


def _cut(acceleration: np.ndarray, raw: RawRecord, table: Accelerogram, where: str) -> tuple[np.ndarray, float]:
    """The samples inside the window, and the record's time of the first of them [s]."""
    first, last = 0, len(acceleration) - 1
    end = raw.origin + last * raw.step
    if table.window is not None:
        slack = 1e-6 * raw.step  # n samples of step h are often called n h long: one step more is let pass
        if table.window[0] < raw.origin - slack or table.window[1] > end + raw.step + slack:
            raise InputError(f"{where}.window", f"{list(table.window)} reaches outside the record, {raw.origin:g} to {end:g} s")
        first = int(np.ceil((table.window[0] - raw.origin) / raw.step - 1e-6))
        last = min(last, int(np.floor((table.window[1] - raw.origin) / raw.step + 1e-6)))
    if last - first + 1 < FEWEST:
        raise InputError(where, f"{max(0, last - first + 1)} samples of {table.path} are too few, at least {FEWEST} are needed")
    return acceleration[first : last + 1], raw.origin + first * raw.step
