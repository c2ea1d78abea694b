"""A recorded accelerogram as base motion.

The acceleration is read, cut to a window, its baseline corrected, scaled and integrated exactly (``loads.baseline``). The velocity, which
is piecewise quadratic, is then evaluated exactly at the times of the run. The motion starts at rest. With a correction it also ends at
rest, where it began; without one the velocity left at the end fades out by a smooth step over ``FADE`` seconds, and the line
printed says so.

``target_pga`` is the peak of the corrected record. Components recorded on rotated axes are set by a direction given as a vector.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from loads.baseline import ORDERS, History, correct, integrate
from loads.motion import DirectionKey, LoadTable, Part, RunGrid, describe, smooth_step
from loads.readers import RawRecord, Request, Source, read
from loads.readers.units import ACCELERATION, acceleration_unit
from masonry_cd.errors import InputError

FADE = 1.0  # [s] in which the velocity of an uncorrected record goes to zero after its end
FEWEST = 8  # samples

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


def _window(value: object) -> tuple[float, float]:
    """Two times, the first before the second."""
    numbers = list(value) if isinstance(value, (list, tuple)) else []
    if len(numbers) != 2 or any(isinstance(n, bool) or not isinstance(n, (int, float)) for n in numbers) or not numbers[0] < numbers[1]:
        raise ValueError("must be [from, to] in seconds of the record, from < to" + (f"; given: {numbers}" if numbers else ""))
    return float(numbers[0]), float(numbers[1])


def _column(value: object) -> str | int | None:
    """A heading or a place."""
    if isinstance(value, bool) or not (value is None or isinstance(value, (str, int))):
        raise ValueError("must be the heading of a column, or its place counted from 0")
    return value


Window = Annotated[tuple[float, float], BeforeValidator(_window)]
Column = Annotated[str | int | None, BeforeValidator(_column)]


class RecordTable(LoadTable):
    """Keys of ``kind = "record"``."""

    kind: Literal["record"] = "record"
    path: str
    format: Literal["auto", "at2", "esm", "csv", "columns"] = "auto"
    direction: DirectionKey
    column: Column = None  # heading, or place counted from 0
    units: str | None = None  # of the accelerations
    time_step: Positive | None = None  # [s], where the file has no time column
    scale: float | None = None
    target_pga: Positive | None = None  # [m/s2]
    start: NotNegative = 0.0  # time of the run at which the record begins [s]
    window: Window | None = None  # part of the record to use, in its own time [s]
    taper: NotNegative = 0.0  # [s] over which the acceleration rises and falls at the ends of the window
    correction: Literal["none", "linear", "quadratic", "cubic"] = "quadratic"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.scale is not None and self.target_pga is not None:
            raise ValueError("give scale or target_pga, not both")
        if self.scale == 0.0:
            raise ValueError("scale: must not be zero")
        return self


def record(table: RecordTable, grid: RunGrid, where: str) -> Part:
    """The base velocity at the run's times.

    Raises:
        InputError: a file that cannot be read, named with its line; unknown units; a window outside the record.
    """
    label = f"{where}.path: {table.path}"
    source = Source.open(grid.folder / table.path, label)
    name, raw = read(source, table.format, Request(table.column, table.time_step))
    acceleration = raw.values * _unit(table, raw, where)
    acceleration, begin = _cut(acceleration, raw, table, where)
    before = integrate(acceleration * _taper(len(acceleration), raw.step, table, where), raw.step)
    after = correct(before, ORDERS[table.correction])
    factor = _factor(table, after, label)
    before, after = before.scaled(factor), after.scaled(factor)
    summary = {
        "kind": "record",
        "path": table.path,
        "format": name,
        "column": raw.name,
        "direction": list(table.direction.vector),
        "window": [begin, begin + after.duration],
        "time_step": raw.step,
        "factor": factor,
        "correction": table.correction,
        "before": before.numbers(),
        "after": after.numbers(),
    }
    return Part(
        velocity=table.direction.along(sample(after, grid.times - table.start)),
        lines=_lines(table, grid, where, summary, after),
        summary=summary,
    )


def sample(history: History, since: np.ndarray) -> np.ndarray:
    """Velocity (m,) at times since the start of a record: zero before, fading to zero over FADE after its end [m/s]."""
    return history.velocity_at(since) * (1.0 - smooth_step((since - history.duration) / FADE))


def _unit(table: RecordTable, raw: RawRecord, where: str) -> float:
    """Size of the record's unit in m/s2."""
    given = None if table.units is None else acceleration_unit(table.units)
    known = ", ".join(ACCELERATION)
    if table.units is not None and given is None:
        raise InputError(f'{where}.units: unknown unit "{table.units}"; known: {known}')
    written = None if raw.unit is None else acceleration_unit(raw.unit)
    if given is not None and written is not None and not np.isclose(given, written):
        raise InputError(f'{where}.units: "{table.units}", but {table.path} says "{raw.unit}"; leave the key out or correct the file')
    found = given if given is not None else written
    if found is None:
        says = f'says "{raw.unit}", which is no known unit' if raw.unit else "does not name its unit"
        raise InputError(f"{where}.units: missing, and {table.path} {says}; give one of {known}")
    return found


def _cut(acceleration: np.ndarray, raw: RawRecord, table: RecordTable, where: str) -> tuple[np.ndarray, float]:
    """The samples inside the window, and the record's time of the first of them [s]."""
    first, last = 0, len(acceleration) - 1
    end = raw.origin + last * raw.step
    if table.window is not None:
        slack = 1e-6 * raw.step  # n samples of step h are often called n h long: one step more is let pass
        if table.window[0] < raw.origin - slack or table.window[1] > end + raw.step + slack:
            raise InputError(f"{where}.window: {list(table.window)} reaches outside the record, {raw.origin:g} to {end:g} s")
        first = int(np.ceil((table.window[0] - raw.origin) / raw.step - 1e-6))
        last = min(last, int(np.floor((table.window[1] - raw.origin) / raw.step + 1e-6)))
    if last - first + 1 < FEWEST:
        raise InputError(f"{where}: {max(0, last - first + 1)} samples of {table.path} are too few, at least {FEWEST} are needed")
    return acceleration[first : last + 1], raw.origin + first * raw.step


def _taper(count: int, step: float, table: RecordTable, where: str) -> np.ndarray:
    """Factors (count,) that rise and fall over the taper at both ends."""
    if table.taper == 0.0:
        return np.ones(count)
    since = step * np.arange(count)
    if 2.0 * table.taper > since[-1]:
        raise InputError(f"{where}.taper: {table.taper:g} s at both ends do not fit into the {since[-1]:g} s of the record")
    return np.asarray(smooth_step(since / table.taper) * smooth_step((since[-1] - since) / table.taper))


def _factor(table: RecordTable, history: History, label: str) -> float:
    """What to multiply the record with."""
    peak = history.numbers()["pga"]
    if peak == 0.0:
        raise InputError(f"{label}: the record is zero throughout")
    if table.target_pga is not None:
        return table.target_pga / peak
    return 1.0 if table.scale is None else table.scale


def _lines(table: RecordTable, grid: RunGrid, where: str, summary: dict[str, Any], after: History) -> tuple[str, ...]:
    """What to tell the user."""
    begin, end = summary["window"]
    column = f" [{summary['column']}]" if summary["column"] else ""
    lines = [
        f"{where} record {table.path}{column} along {table.direction.label}: {begin:g} to {end:g} s of it, "
        f"from {table.start:g} s of the run, times {summary['factor']:.6g}",
        f"{where}   before correction:    {describe(summary['before'])}",
    ]
    if table.correction != "none":
        lines.append(f"{where}   {table.correction + ' correction:':21} {describe(summary['after'])}")
    elif abs(after.velocity[-1]) > 1e-6 * np.abs(after.velocity).max():
        more = after.displacement[-1] + 0.5 * FADE * after.velocity[-1]
        lines.append(f"{where}   not corrected: then the velocity fades to zero over {FADE:g} s, the displacement ends at {more:.4g} m")
    if grid.dt > after.step * (1.0 + 1e-9):
        coarse = f"run.dt {grid.dt:g} s is coarser than the record's {after.step:g} s"
        lines.append(f"{where}   {coarse}: what it holds above {0.5 / grid.dt:g} Hz is lost")
    if table.start + after.duration > grid.end + after.step:
        over = table.start + after.duration
        lines.append(f"{where}   the run ends at {grid.end:g} s, the record at {over:g} s; the key window picks the part to use")
    return tuple(lines)
