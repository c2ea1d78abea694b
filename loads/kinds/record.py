# SPDX-License-Identifier: GPL-3.0-or-later
"""A recorded accelerogram as base motion.

The accelerogram is read and processed (``loads.signal.accelerogram``) and scaled. Its velocity, which is piecewise quadratic, is then
evaluated exactly at the times of the run. The motion starts at rest. With a correction it also ends at rest, where it began; without one
the velocity left at the end fades out by a smooth step over ``FADE`` seconds, and the line printed says so.

``target_pga`` is the peak of the corrected record. With ``site`` that is the motion of rock, and what acts is that of the ground above it
(``loads.signal.site_response``). The horizontal pair of a station is turned by ``rotate`` in the tables of both: each
component then acts along its direction turned about the vertical, which is the same as turning the pair,

    a_x = a_1 cos(phi) - a_2 sin(phi),      a_y = a_1 sin(phi) + a_2 cos(phi).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np

from loads.motion import DirectionKey, FromFile, LoadAction, LoadKind, RunGrid, smooth_step
from loads.signal.accelerogram import Accelerogram, Processed, Scaled, describe_both, process
from loads.signal.baseline import ORDERS, GroundHistory
from loads.signal.intensity import reached
from loads.signal.plausible import doubts
from loads.signal.site_response import SiteTable, surface_motion
from loads.supports import ShakingTable
from masonry_cd.foundation.units import Unit

FADE = 1.0  # [s] in which the velocity of an uncorrected record goes to zero after its end


class Recorded(Accelerogram):
    """An accelerogram and where it acts."""

    direction: DirectionKey
    """Axis ("x", "-y" ...), vector or level angle from x to y along which the base moves."""

    @property
    def fade(self) -> float:
        """How long the base moves on after its end [s]."""
        return FADE if self.correction == "none" else 0.0

    def ready(self, grid: RunGrid, where: str) -> Processed:
        """The motion, read and processed."""
        return process(self, grid.folder, grid.dt, where)

    def doubts(self, processed: Processed, where: str) -> list[str]:
        """List doubts that it is what the user means, a line each."""
        return doubts(processed, self.correction, where)

    def lines(self, processed: Processed, how: str, where: str) -> list[str]:
        """On the motion, which acts in a way said by ``how``."""
        column = f" [{processed.column}]" if processed.column else ""
        return [f"{where} record {self.path}{column} {how}", *describe_both(where, processed, self.correction)]


class RecordTable(Scaled, Recorded, ShakingTable):
    """Keys of ``kind = "record"``."""

    kind: Literal["record"] = "record"
    rotate: Annotated[float, Unit("degrees")] = 0.0
    """Turns the direction about z, counter-clockwise seen from above."""
    site: SiteTable | None = None
    """Layers of soil through which the motion goes, which then is that of a rock outcrop, to the surface."""


def record(table: RecordTable, grid: RunGrid, where: str) -> LoadAction:
    """The base motion.

    Raises:
        InputError: a file that cannot be read, named with its line; unknown units; a window outside the record.
    """
    processed = table.ready(grid, where)
    factor = table.factor(processed.after.numbers()["pga"])
    processed = processed.scaled(factor)
    rock, direction = processed, table.direction.turned(table.rotate)
    site = None if table.site is None else surface_motion(table.site, rock.after, ORDERS[table.correction], where)
    processed = rock if site is None else replace(rock, after=site.history)
    after = processed.after
    summary = table.facts("path", "correction") | {"direction": list(direction.vector), "factor": factor} | processed.numbers()
    summary |= {} if site is None else {"site": site.facts}
    begin, end = summary["window"]
    how = f"along {direction.label}: {begin:g} to {end:g} s of it, from {table.start:g} s of the run, times {factor:.6g}"
    return LoadAction(
        motion=lambda times: direction.along(sample(after, times - table.start)),
        delay=table.delay_of_blocks(grid, where),
        lines=(*table.lines(rock, how, where), *(site.lines if site else ()), *_warnings(table, grid, where, after)),
        warnings=(*table.doubts(rock, where), *(site.warnings if site else ())),
        summary=summary,
        acted=reached(where, [(table.start + table.latest(grid, where), after)]),
    )


def sample(history: GroundHistory, since: np.ndarray) -> np.ndarray:
    """Velocity (m,) at times since the start of a record: zero before, fading to zero over FADE after its end [m/s]."""
    return history.velocity_at(since) * (1.0 - smooth_step((since - history.duration) / FADE))


def _warnings(table: RecordTable, grid: RunGrid, where: str, after: GroundHistory) -> list[str]:
    """List what the user may not expect of the motion."""
    lines: list[str] = []
    if table.correction == "none" and abs(after.velocity[-1]) > 1e-6 * np.abs(after.velocity).max():
        more = after.displacement[-1] + 0.5 * FADE * after.velocity[-1]
        lines.append(f"{where}   not corrected: velocity brought to zero over {FADE:g} s at its end, end displacement {more:.4g} m")
    if grid.dt > after.step * (1.0 + 1e-9):
        coarse = f"run.dt {grid.dt:g} s is coarser than the record's {after.step:g} s"
        lines.append(f'{where}   {coarse}: what it holds above {0.5 / grid.dt:g} Hz is lost; resample = "run" filters it out first')
    return lines


def record_end(table: RecordTable, grid: RunGrid, where: str) -> float:
    """When the base stands still again [s].

    Raises:
        InputError: see :func:`record`.
    """
    return table.start + table.ready(grid, where).after.duration + table.fade + table.latest(grid, where)


def grown(keys: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """The keys of a record, or of a shock, that is larger by a factor."""
    key = next((key for key in Scaled.model_fields if key in keys), None)
    return {**keys, "scale": factor} if key is None else {**keys, key: float(keys[key]) * factor}


def _recorded(keys: Mapping[str, Any], made: Mapping[str, Any], where: str) -> list[FromFile]:
    begin, (first, last) = keys.get("start", 0.0), made["window"]
    return [FromFile(where, keys, made["factor"], begin, begin + last - first, ((where, keys, made),))]


KINDS = {
    "record": LoadKind(
        RecordTable, record, record_end, grown=grown, recorded=_recorded, starter={"path": "quake.csv", "direction": "x", "units": "g"}
    )
}
