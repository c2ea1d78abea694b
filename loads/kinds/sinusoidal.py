# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinusoidal base motion, v(t) = C e(t) sin(2 pi f (t - start)).

The load of parametric studies on masonry churches (Clementi et al. 2018). The velocity, not the acceleration, is a sine, so it starts from
zero without a jump and every whole cycle brings the base back to where it was. The acceleration starts at 2 pi f C at once; the
envelope e, when a ramp is requested, rises from 0 to 1 and falls again by the smooth step 3 x^2 - 2 x^3 over the ramp at either end,
inside the duration.

A duration that ends inside a half cycle would leave the base moving. Without a ramp the motion then goes on to the next zero of the
sine, and says so.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import model_validator

from loads.acted import over_time
from loads.motion import STANDARD_GRAVITY, DirectionKey, LoadAction, LoadKind, Positive, RunGrid, describe, smooth_step
from loads.supports import ShakingTable
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant, Span
from masonry_cd.foundation.units import Unit, Usual

FINE = 400  # samples per cycle from which the peaks in the printed line are taken
SINE = Usual(
    0.05, 2.0 * STANDARD_GRAVITY, "2 pi frequency times it, its PGA, is usually 0.005 to 2 g", ("cm/s", "mm/s", "km/h"), over="its PGA"
)


class SinusoidalTable(ShakingTable):
    """Keys of ``kind = "sinusoidal"``."""

    kind: Literal["sinusoidal"] = "sinusoidal"
    direction: DirectionKey
    """Axis ("x", "-y" ...), vector or level angle from x to y along which the base moves."""
    amplitude: Annotated[float, Unit("m/s"), SINE]
    """C, of the velocity."""
    frequency: Annotated[Positive, Unit("Hz")]
    """f."""
    cycles: Positive | None = None
    """Number of cycles; give cycles or duration."""
    duration: Span | None = None
    """Duration, instead of cycles."""
    ramp: Instant = 0.0
    """Smooth rise and fall of the amplitude at either end."""

    @model_validator(mode="after")
    def _one_length(self) -> Self:
        if (self.cycles is None) == (self.duration is None):
            raise ValueError("give exactly one of cycles and duration")
        if 2.0 * self.ramp > self.asked * (1.0 + 1e-12):
            raise ValueError(f"ramp: {self.ramp:g} s in and out do not fit into the {self.asked:g} s of motion")
        return self

    @property
    def asked(self) -> float:
        """How long the user wants the motion [s]."""
        return self.duration if self.duration is not None else (self.cycles or 0.0) / self.frequency

    @property
    def length(self) -> float:
        """How long the motion lasts: up to the next zero of the sine, unless a ramp ends it [s]."""
        if self.ramp > 0.0:
            return self.asked
        half_cycles = math.ceil(2.0 * self.frequency * self.asked - 1e-9)
        return half_cycles / (2.0 * self.frequency)

    def velocity(self, since: np.ndarray) -> np.ndarray:
        """v at times since the start of the motion (n,) [m/s]."""
        wave = self.amplitude * libm.sin(2.0 * np.pi * self.frequency * since)
        if self.ramp > 0.0:
            wave = wave * smooth_step(since / self.ramp) * smooth_step((self.length - since) / self.ramp)
        return np.where((since > 0.0) & (since < self.length), wave, 0.0)


def sinusoidal(table: SinusoidalTable, grid: RunGrid, where: str) -> LoadAction:
    """The base motion.

    Raises:
        InputError: a frequency that steps of dt cannot follow.
    """
    if table.frequency * grid.dt >= 0.5:
        limit = 0.5 / grid.dt
        raise InputError(
            f"{where}.frequency", f"{table.frequency:g} Hz is beyond run.dt {grid.dt:g} s, which follows less than {limit:g} Hz"
        )
    numbers = _numbers(table)
    return LoadAction(
        motion=lambda times: table.direction.along(table.velocity(times - table.start)),
        delay=table.delay_of_blocks(grid, where),
        lines=_lines(table, grid, where, numbers),
        summary=table.facts("direction") | {"after": numbers},
        acted=over_time(where, "cycles", table.start + table.latest(grid, where), table.length),
    )


def _numbers(table: SinusoidalTable) -> dict[str, float]:
    """Peaks and end values of the motion itself, on a grid of its own."""
    cycles = table.length * table.frequency
    points = int(min(max(FINE * math.ceil(cycles), 10 * FINE), 4_000_000)) + 1
    since = np.linspace(0.0, table.length, points)
    h = since[1] - since[0]
    velocity = table.velocity(since)
    displacement = np.concatenate([[0.0], np.cumsum(0.5 * h * (velocity[1:] + velocity[:-1]))])
    peak = np.abs(np.diff(velocity)).max() / h if table.ramp > 0.0 else 2.0 * np.pi * table.frequency * abs(table.amplitude)
    end = float(displacement[-1])
    return {
        "pga": float(peak),
        "pgv": float(np.abs(velocity).max()),
        "pgd": float(np.abs(displacement).max()),
        "end_velocity": float(velocity[-1]),
        "end_displacement": end,
    }


def _lines(table: SinusoidalTable, grid: RunGrid, where: str, n: dict[str, Any]) -> tuple[str, ...]:
    """Lines on the motion for the user."""
    end = table.start + table.length
    lines = [f"{where} sinusoidal along {table.direction.label}, {table.start:g} to {end:g} s: {describe(n)}"]
    if table.ramp > 0.0:
        lines.append(f"{where} the amplitude is tapered smoothly over {table.ramp:g} s at either end")
    elif table.length > table.asked * (1.0 + 1e-9):
        on = f"the motion goes on to the next zero of the sine, {table.length:g} s"
        lines.append(f"{where} {table.asked:g} s ends inside a half cycle: {on}")
    return tuple(lines)


KINDS = {
    "sinusoidal": LoadKind(
        SinusoidalTable,
        sinusoidal,
        grown=lambda keys, factor: {**keys, "amplitude": float(keys["amplitude"]) * factor},
        starter={"direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 5},
    )
}
