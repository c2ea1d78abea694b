# SPDX-License-Identifier: GPL-3.0-or-later
r"""Shocks in a row on the same, ever more damaged structure (Ferrante et al. 2019 shake a cracked church by three records in a row).

Each shock has the components of one record, scaled by one factor. Between two shocks, and after the last, the base stands still for a rest:
a fixed time, or until the structure is still,

    max |v| of the blocks that still stand < still   over ``hold`` seconds,   at most ``longest_rest``.

A component is a recorded accelerogram, or an artificial one where it names a ``spectrum`` instead of a ``path``.

**Load time and run time.** How long a rest until still takes is only known in the run. So the arrays of loads are laid out in a load
time in which every such rest has its full length, and say where it lies: a :class:`Pause` from step ``first`` to step ``last``. The run
loop keeps the step of the load k beside its own, and in a pause, once the structure has been still for ``hold`` steps, goes on at
k = ``last``. Base velocity and acceleration are constant over a pause, so the jump changes nothing but the time that passes. ``last`` of
the pause after the last shock is the end of the loads, so the run ends there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from loads.kinds.artificial import SpectrumMatch, drawn
from loads.kinds.record import FADE, sample
from loads.motion import Direction, DirectionKey, LoadKind, Part, RunGrid, describe
from loads.signal.accelerogram import Accelerogram, Processed, Scaled, describe_both, process, size_factor
from loads.signal.intensity import in_words, reached
from loads.signal.plausible import doubts
from loads.supports import ShakingTable
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.fields import Span, is_number
from masonry_cd.foundation.table_schema import rows
from masonry_cd.foundation.units import Unit

Positive = Annotated[float, Field(gt=0.0)]


def _rest(value: object) -> float | str:
    """A time or the word "still"."""
    if value == "still":
        return "still"
    if isinstance(value, (int, float)) and is_number(value) and value >= 0.0:
        return float(value)
    raise ValueError('must be a time in seconds, or "still": until the structure is')


class Recorded(Accelerogram):
    """A recorded component of a shock."""

    direction: DirectionKey
    """Axis ("x", "-y" ...) or vector along which the base moves."""


class Artificial(SpectrumMatch):
    """An artificial component of a shock."""

    direction: DirectionKey
    """Axis ("x", "-y" ...) or vector along which the base moves."""


class ShockTable(Scaled):
    """One shock: ``[[loads.shocks]]``; ``target_pga`` is that of its strongest component."""

    name: Annotated[str, Field(min_length=1, max_length=40)] | None = None
    """Of the shock, in tables and closing lines."""
    components: Annotated[list[dict[str, Any]], Field(min_length=1, json_schema_extra=rows(Recorded, Artificial))]
    """Each with a direction, and the keys of a record or of an artificial accelerogram."""
    rotate: Annotated[float, Unit("degrees")] = 0.0
    """Turns all directions about z, counter-clockwise seen from above."""


class SequenceTable(ShakingTable):
    """Keys of ``kind = "sequence"``."""

    kind: Literal["sequence"] = "sequence"
    shocks: Annotated[list[ShockTable], Field(min_length=1)]
    """In their order in time."""
    rest: Annotated[float | str, Unit("s"), BeforeValidator(_rest)] = "still"
    """After each shock, or "still": until the structure is."""
    longest_rest: Span = 20.0
    """At most, where it waits for the structure to be still."""
    still: Annotated[Positive, Unit("m/s")] = 1e-3
    """Speed below which a block counts as still."""
    hold: Span = 0.5
    """How long all blocks have to be still."""


@dataclass(frozen=True)
class Shock:
    """When a shock acts: from step first to step last of the loads."""

    name: str
    first: int
    last: int


@dataclass(frozen=True)
class Pause:
    """Steps of the loads during which nothing changes; see the head of this file for what the run loop does with it."""

    first: int
    last: int
    speed: float  # below which the structure counts as still [m/s]
    hold: int  # steps that it has to be
    after: str  # the shock before


@dataclass(frozen=True, eq=False)
class _Ready:
    """A shock whose records are read and scaled."""

    name: str
    parts: tuple[tuple[Direction, Processed], ...]
    factor: float
    length: float  # until the base stands still again [s]
    doubts: tuple[str, ...]  # whether its records are what the user means

    def velocity(self, since: np.ndarray) -> np.ndarray:
        """Of the base at times since its start, (n, 3) [m/s]."""
        out = np.zeros((len(since), 3))
        for direction, processed in self.parts:
            out += direction.along(sample(processed.after, since))
        out[since >= self.length * (1.0 - 1e-12)] = 0.0  # exactly still, where rounding leaves 1e-17 m/s
        return out


def sequence(table: SequenceTable, grid: RunGrid, where: str) -> Part:
    """The base motion, the shocks and the pauses.

    Raises:
        InputError: a record that cannot be read; named with its line and the shock it belongs to.
    """
    ready, lines = [], []
    for i, shock in enumerate(table.shocks):
        done, said = _prepare(shock, grid, f"{where}.shocks[{i}]", i)
        ready.append(done)
        lines.append(said)
    delay = table.delay_of_blocks(grid, where)
    latest = 0.0 if delay is None else float(delay.max())
    shocks, pauses = _lay_out(table, ready, grid, latest)
    starts = [shock.first * grid.dt for shock in shocks]

    def motion(times: np.ndarray) -> np.ndarray:
        out = np.zeros((len(times), 3))
        for start, one in zip(starts, ready, strict=True):
            out += one.velocity(times - start)
        return out

    acting = [(start + latest, processed.after) for start, one in zip(starts, ready, strict=True) for _, processed in one.parts]
    end = pauses[-1].last if pauses else shocks[-1].last
    timed = [line for shock, said in zip(shocks, lines, strict=True) for line in _timed(shock, said, grid)]
    if end > grid.steps:
        timed.append(f"{where} the run ends at {grid.end:g} s: run.duration = {end * grid.dt:g} would hold all shocks and rests")
    return Part(
        motion=motion,
        delay=delay,
        lines=tuple(timed),
        warnings=tuple(line for one in ready for line in one.doubts),
        summary={"kind": "sequence", "rest": table.rest, "shocks": [_summary(s, r, grid) for s, r in zip(shocks, ready, strict=True)]},
        shocks=tuple(shock for shock in shocks if shock.first < grid.steps),
        pauses=tuple(replace(p, last=min(p.last, grid.steps)) for p in pauses if p.first < grid.steps and table.rest == "still"),
        acted=reached(where, acting),
    )


def _prepare(shock: ShockTable, grid: RunGrid, where: str, place: int) -> tuple[_Ready, list[str]]:
    """Read and scale the components of a shock; with the lines on them."""
    keys = [f"{where}.components[{j}]" for j in range(len(shock.components))]
    components = [_component(table, key) for table, key in zip(shock.components, keys, strict=True)]
    raw = [_read(component, grid, key) for component, key in zip(components, keys, strict=True)]
    factor = size_factor(shock.scale, shock.target_pga, max(one.after.numbers()["pga"] for one in raw))
    scaled = [one.scaled(factor) for one in raw]
    directions = [component.direction.turned(shock.rotate) for component in components]
    lines, unsure, length = [], [], 0.0
    for component, direction, one, key in zip(components, directions, scaled, keys, strict=True):
        lines += _described(component, direction, one, factor, key)
        if isinstance(component, Recorded):
            unsure += doubts(one, component.correction, key)
        fades = isinstance(component, Recorded) and component.correction == "none"
        length = max(length, one.after.duration + (FADE if fades else 0.0))
    return _Ready(shock.name or f"shock {place + 1}", tuple(zip(directions, scaled, strict=True)), factor, length, tuple(unsure)), lines


def _described(component: Recorded | Artificial, direction: Direction, processed: Processed, factor: float, where: str) -> list[str]:
    """The lines on a component at its final size."""
    how = f"along {direction.label}, times {factor:.6g}"
    if isinstance(component, Recorded):
        column = f" [{processed.column}]" if processed.column else ""
        return [f"{where} {component.path}{column} {how}", *describe_both(where, processed, component.correction)]
    numbers = processed.numbers()["after"]
    origin = f"artificial, {component.spectrum} spectrum, ground {component.ground}, seed {component.seed}"
    return [f"{where} {origin} {how}: {describe(numbers)}", f"{where}   {in_words(numbers)}"]


def _component(table: dict[str, Any], where: str) -> Recorded | Artificial:
    """A component by its keys: one with a ``spectrum`` is artificial."""
    return parse_table(Artificial, table, where) if "spectrum" in table else parse_table(Recorded, table, where)


def _read(component: Recorded | Artificial, grid: RunGrid, where: str) -> Processed:
    """The motion of a component, not scaled yet."""
    if isinstance(component, Recorded):
        return process(component, grid.folder, grid.dt, where)
    motion = drawn(component, where)
    return Processed(motion, motion, 0.0, "artificial", "")


def _lay_out(table: SequenceTable, ready: list[_Ready], grid: RunGrid, latest: float) -> tuple[list[Shock], list[Pause]]:
    """Shocks and pauses in steps of the load time; shocks begin on a step."""
    rest = table.longest_rest if isinstance(table.rest, str) else table.rest
    shocks, pauses = [], []
    first = math.ceil(table.start / grid.dt - 1e-6)
    for one in ready:
        last = first + math.ceil((one.length + latest) / grid.dt - 1e-6)
        after = last + math.ceil(rest / grid.dt - 1e-6)
        shocks.append(Shock(one.name, first, last))
        pauses.append(Pause(last, after, table.still, max(1, math.ceil(table.hold / grid.dt)), one.name))
        first = after
    return shocks, pauses


def _timed(shock: Shock, lines: list[str], grid: RunGrid) -> list[str]:
    """The lines of a shock below one that says when it acts."""
    return [f'shock "{shock.name}": {shock.first * grid.dt:g} to {shock.last * grid.dt:g} s of the loads', *lines]


def _summary(shock: Shock, ready: _Ready, grid: RunGrid) -> dict[str, Any]:
    return {
        "name": shock.name,
        "start": shock.first * grid.dt,
        "end": shock.last * grid.dt,
        "factor": ready.factor,
        "components": [{"direction": list(direction.vector), **one.numbers()} for direction, one in ready.parts],
    }


def _end(table: SequenceTable, grid: RunGrid, where: str) -> float:
    """When the last rest is over [s]."""
    ready = [_prepare(shock, grid, f"{where}.shocks[{i}]", i)[0] for i, shock in enumerate(table.shocks)]
    shocks, pauses = _lay_out(table, ready, grid, table.latest(grid, where))
    return grid.dt * (pauses[-1].last if pauses else shocks[-1].last)


KINDS = {"sequence": LoadKind(SequenceTable, sequence, _end)}
