# SPDX-License-Identifier: GPL-3.0-or-later
"""A recorded accelerogram as base motion.

The accelerogram is read and processed (``loads.signal.accelerogram``) and scaled. Its velocity, which is piecewise quadratic, is then
evaluated exactly at the times of the run. The motion starts at rest. With a correction it also ends at rest, where it began; without one
the velocity left at the end fades out by a smooth step over ``FADE`` seconds, and the line printed says so.

``target_pga`` is the peak of the corrected record. The horizontal pair of a station is turned by ``rotate`` in the tables of both: each
component then acts along its direction turned about the vertical, which is the same as turning the pair,

    a_x = a_1 cos(phi) - a_2 sin(phi),      a_y = a_1 sin(phi) + a_2 cos(phi).
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from loads.motion import DirectionKey, LoadKind, Part, RunGrid, smooth_step
from loads.signal.accelerogram import Accelerogram, Scaled, describe_both, process, size_factor
from loads.signal.baseline import History
from loads.signal.intensity import reached
from loads.signal.plausible import doubts
from loads.supports import ShakingTable
from masonry_cd.foundation.units import Unit

FADE = 1.0  # [s] in which the velocity of an uncorrected record goes to zero after its end


class RecordTable(Scaled, Accelerogram, ShakingTable):
    """Keys of ``kind = "record"``."""

    kind: Literal["record"] = "record"
    direction: DirectionKey
    """Axis ("x", "-y" ...) or vector along which the base moves."""
    rotate: Annotated[float, Unit("degrees")] = 0.0
    """Turns the direction about z, counter-clockwise seen from above."""


def record(table: RecordTable, grid: RunGrid, where: str) -> Part:
    """The base motion.

    Raises:
        InputError: a file that cannot be read, named with its line; unknown units; a window outside the record.
    """
    processed = process(table, grid.folder, grid.dt, where)
    factor = size_factor(table.scale, table.target_pga, processed.after.numbers()["pga"])
    processed = processed.scaled(factor)
    direction, after = table.direction.turned(table.rotate), processed.after
    summary = {
        "kind": "record",
        "path": table.path,
        "direction": list(direction.vector),
        "factor": factor,
        "correction": table.correction,
        **processed.numbers(),
    }
    begin, end = summary["window"]
    column = f" [{processed.column}]" if processed.column else ""
    first = (
        f"{where} record {table.path}{column} along {direction.label}: {begin:g} to {end:g} s of it, "
        f"from {table.start:g} s of the run, times {factor:.6g}"
    )
    return Part(
        motion=lambda times: direction.along(sample(after, times - table.start)),
        delay=table.delay_of_blocks(grid, where),
        lines=(first, *describe_both(where, processed, table.correction), *_warnings(table, grid, where, after)),
        warnings=tuple(doubts(processed, table.correction, where)),
        summary=summary,
        acted=reached(where, [(table.start + table.latest(grid, where), after)]),
    )


def sample(history: History, since: np.ndarray) -> np.ndarray:
    """Velocity (m,) at times since the start of a record: zero before, fading to zero over FADE after its end [m/s]."""
    return history.velocity_at(since) * (1.0 - smooth_step((since - history.duration) / FADE))


def _warnings(table: RecordTable, grid: RunGrid, where: str, after: History) -> list[str]:
    """What the user may not expect of the motion."""
    lines: list[str] = []
    if table.correction == "none" and abs(after.velocity[-1]) > 1e-6 * np.abs(after.velocity).max():
        more = after.displacement[-1] + 0.5 * FADE * after.velocity[-1]
        lines.append(f"{where}   not corrected: then the velocity fades to zero over {FADE:g} s, the displacement ends at {more:.4g} m")
    if grid.dt > after.step * (1.0 + 1e-9):
        coarse = f"run.dt {grid.dt:g} s is coarser than the record's {after.step:g} s"
        lines.append(f'{where}   {coarse}: what it holds above {0.5 / grid.dt:g} Hz is lost; resample = "run" filters it out first')
    return lines


def record_end(table: RecordTable, grid: RunGrid, where: str) -> float:
    """When the base stands still again [s].

    Raises:
        InputError: see :func:`record`.
    """
    fades = FADE if table.correction == "none" else 0.0
    return table.start + process(table, grid.folder, grid.dt, where).after.duration + fades + table.latest(grid, where)


KINDS = {"record": LoadKind(RecordTable, record, record_end)}
