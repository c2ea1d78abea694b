# SPDX-License-Identifier: GPL-3.0-or-later
r"""A pulse: a body force on every block that begins, ends, and leaves nothing behind.

    half-sine    a sin(pi x),     rectangle    a,     sine    a sin(2 pi x),     cosine    a cos(2 pi x),     x = (t - start) / duration

for x in [0, 1], along a direction, and zero elsewhere. Seen from a base that is accelerated by -a this is the force of inertia. Each step
gets the mean of the pulse over it, so that its impulse is exact whatever the step. A sine leaves a base moved, a cosine where it was: the
pulses of types A and B of Makris & Chang, EERC Report 98/02, 1998.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from loads.acted import over_time
from loads.motion import STANDARD_GRAVITY, DirectionKey, LoadAction, LoadKind, LoadTable, RunGrid
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant, Span
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

BLOW = Usual(0.3, 50.0 * STANDARD_GRAVITY, "0.3 m/s2 (0.03 g) harms no masonry, blows beyond 50 g are rare", ACCELERATIONS)
SIGNS = {  # x between which a shape keeps its sign
    "half-sine": (0.0, 1.0), "rectangle": (0.0, 1.0), "sine": (0.0, 0.5, 1.0), "cosine": (0.0, 0.25, 0.75, 1.0),
}  # fmt: skip


class PulseTable(LoadTable):
    """Keys of ``kind = "pulse"``."""

    kind: Literal["pulse"] = "pulse"
    direction: DirectionKey
    """Axis, vector or angle from x towards y along which it acts on every block."""
    acceleration: Annotated[float, Unit("m/s2"), BLOW]
    """Peak of the acceleration."""
    duration: Span
    """Duration of the pulse."""
    shape: Literal["half-sine", "rectangle", "sine", "cosine"] = "half-sine"
    """History of its acceleration."""
    start: Instant = 0.0
    """When it begins."""


def pulse(table: PulseTable, grid: RunGrid, where: str) -> LoadAction:
    """The body force at the run's times, (N + 1, 3) [m/s2].

    Raises:
        InputError: a pulse that is shorter than a step.
    """
    if table.duration < grid.dt:
        raise InputError(f"{where}.duration", f"{table.duration:g} s are less than a step, run.dt = {grid.dt:g} s")
    ends = np.concatenate([[-grid.dt], grid.times])
    means = table.acceleration * np.diff(_integral(table, ends)) / grid.dt
    end, size = table.start + table.duration, abs(table.acceleration)
    line = f"{where} pulse, a {table.shape} of {size:.4g} m/s2 ({size / STANDARD_GRAVITY:.3g} g) along {table.direction.label}"
    return LoadAction(
        acceleration=table.direction.along(means),
        lines=(f"{line}, {table.start:g} to {end:g} s",),
        summary=table.facts("direction", "acceleration", "shape", "start", "duration"),
        acted=over_time(where, "impulse", table.start, table.duration, lambda x: _passed(table, x)),
    )


def _passed(table: PulseTable, x: float) -> float:
    """The share of the integral of its size that has passed at x."""
    ends = (table.start + table.duration * np.clip(SIGNS[table.shape], 0.0, end) for end in (x, 1.0))
    passed = [np.abs(np.diff(_integral(table, times))).sum() for times in ends]
    return float(passed[0] / passed[1])


def _integral(table: PulseTable, times: np.ndarray) -> np.ndarray:
    """Return the integral of a pulse of peak 1 up to times (n,) [s]."""
    x = np.clip((times - table.start) / table.duration, 0.0, 1.0)
    if table.shape == "rectangle":
        return np.asarray(table.duration * x)
    if table.shape == "cosine":
        return np.asarray(table.duration * libm.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    turns = 1.0 if table.shape == "half-sine" else 2.0
    return np.asarray(table.duration * (1.0 - libm.cos(turns * np.pi * x)) / (turns * np.pi))


KINDS = {"pulse": LoadKind(PulseTable, pulse, starter={"direction": "x", "acceleration": 1.5, "duration": 0.25})}
