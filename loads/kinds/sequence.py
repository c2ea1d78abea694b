# SPDX-License-Identifier: GPL-3.0-or-later
r"""Shocks in a row on the same, ever more damaged structure (Ferrante et al. 2019 shake a cracked church by three records in a row).

Each shock has the components of one record, scaled by one factor. Between two shocks, and after the last, the base stands still for a rest:
a fixed time, or until the structure is still,

    max |v| of the blocks that still stand < still   over ``hold`` seconds,   at most ``longest_rest``.

A component is a recorded accelerogram, or an artificial one where it names a ``spectrum`` instead of a ``path``.

**Load time and run time.** How long a rest until still takes is only known in the run. So the arrays of loads are laid out in a load
time in which every such rest has its full length, and say where it lies: a :class:`Pause` from step ``first`` to step ``last``. The run
loop keeps the step of the load k in addition to its own, and in a pause, once the structure has been still for ``hold`` steps, goes on at
k = ``last``. Base velocity and acceleration are constant over a pause, so the jump changes nothing but the time that passes. ``last`` of
the pause after the last shock is the end of the loads, so the run ends there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from loads.kinds.artificial import SpectrumMatch
from loads.kinds.record import Recorded, grown, sample
from loads.motion import Direction, FromFile, LoadAction, LoadKind, Positive, RunGrid
from loads.signal.accelerogram import Processed, Scaled
from loads.signal.intensity import reached
from loads.supports import ShakingTable
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.fields import Span, is_number
from masonry_cd.foundation.table_schema import rows
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.shocks import Pause, Shock


def _rest(value: object) -> float | str:
    """A time or the word "still"."""
    if value == "still":
        return "still"
    if isinstance(value, (int, float)) and is_number(value) and value >= 0.0:
        return float(value)
    raise ValueError('must be a time in seconds, or "still": until the structure is')


class ShockTable(Scaled):
    """One shock: ``[[loads.shocks]]``; ``target_pga`` is that of its strongest component."""

    name: Annotated[str, Field(min_length=1, max_length=40)] | None = None
    """Name of the shock, in tables and closing lines."""
    components: Annotated[list[dict[str, Any]], Field(min_length=1, json_schema_extra=rows(Recorded, SpectrumMatch))]
    """Each with a direction, and the keys of a record or of an artificial accelerogram."""
    rotate: Annotated[float, Unit("degrees")] = 0.0
    """Turns all directions about z, counter-clockwise seen from above."""


class SequenceTable(ShakingTable):
    """Keys of ``kind = "sequence"``."""

    kind: Literal["sequence"] = "sequence"
    shocks: Annotated[list[ShockTable], Field(min_length=1)]
    """Shocks in their order in time."""
    rest: Annotated[float | str, Unit("s"), BeforeValidator(_rest)] = "still"
    """After each shock, or "still": until the structure is."""
    longest_rest: Span = 20.0
    """At most, where it waits for the structure to be still."""
    still: Annotated[Positive, Unit("m/s")] = 1e-3
    """Speed below which a block counts as still."""
    hold: Span = 0.5
    """Time for which all blocks must be at rest."""


@dataclass(frozen=True, eq=False)
class _Ready:
    """A shock whose records are read and scaled."""

    name: str
    parts: tuple[tuple[Direction, Processed], ...]
    factor: float
    length: float  # until the base stands still again [s]
    doubts: tuple[str, ...]  # whether its records are what the user means

    def velocity(self, since: np.ndarray) -> np.ndarray:
        """Return the velocity of the base at times since its start, (n, 3) [m/s]."""
        out = np.zeros((len(since), 3))
        for direction, processed in self.parts:
            out += direction.along(sample(processed.after, since))
        out[since >= self.length * (1.0 - 1e-12)] = 0.0  # exactly still, where rounding leaves 1e-17 m/s
        return out


def sequence(table: SequenceTable, grid: RunGrid, where: str) -> LoadAction:
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
    timed = list[str]()
    for acts, said in zip(shocks, lines, strict=True):
        timed += [f'shock "{acts.name}": {acts.first * grid.dt:g} to {acts.last * grid.dt:g} s of the loads', *said]
    if end > grid.steps:
        timed.append(f"{where} the run ends at {grid.end:g} s: run.duration = {end * grid.dt:g} would hold all shocks and rests")
    return LoadAction(
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
    """Read and scale the components of a shock, of which one with a ``spectrum`` is artificial; with the lines on them."""
    keyed = [(f"{where}.components[{j}]", table) for j, table in enumerate(shock.components)]
    components: list[Recorded | SpectrumMatch] = [
        parse_table(SpectrumMatch, table, key) if "spectrum" in table else parse_table(Recorded, table, key) for key, table in keyed
    ]
    raw = [component.ready(grid, key) for component, (key, _) in zip(components, keyed, strict=True)]
    factor = shock.factor(max(one.after.numbers()["pga"] for one in raw))
    scaled = [one.scaled(factor) for one in raw]
    directions = [component.direction.turned(shock.rotate) for component in components]
    lines, unsure = list[str](), list[str]()
    for component, direction, one, (key, _) in zip(components, directions, scaled, keyed, strict=True):
        lines += component.lines(one, f"along {direction.label}, times {factor:.6g}", key)
        unsure += component.doubts(one, key)
    length = max(one.after.duration + component.fade for component, one in zip(components, scaled, strict=True))
    return _Ready(shock.name or f"shock {place + 1}", tuple(zip(directions, scaled, strict=True)), factor, length, tuple(unsure)), lines


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


def _grown(keys: Mapping[str, Any], factor: float) -> dict[str, Any]:
    return {**keys, "shocks": [grown(shock, factor) for shock in keys.get("shocks", [])]}


def _recorded(keys: Mapping[str, Any], made: Mapping[str, Any], where: str) -> list[FromFile]:
    """A motion for each shock, of whose components some may be artificial."""
    found = []
    for i, (shock, one) in enumerate(zip(keys["shocks"], made["shocks"], strict=True)):
        place = f"{where}.shocks[{i}]"
        both = enumerate(zip(shock["components"], one["components"], strict=True))
        parts = tuple((f"{place}.components[{j}]", own, its) for j, (own, its) in both)
        found.append(FromFile(place, shock, one["factor"], one["start"], one["end"], parts))
    return found


KINDS = {
    "sequence": LoadKind(
        SequenceTable,
        sequence,
        _end,
        grown=_grown,
        recorded=_recorded,
        starter={"rest": 0.5, "shocks": [{"components": [{"path": "quake.csv", "direction": "x", "units": "g"}]}]},
    )
}
