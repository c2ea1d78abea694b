# SPDX-License-Identifier: GPL-3.0-or-later
"""Values over time for the page's plots: thinned where a run has more steps than a plot has points.

A stretch of many steps is sent as two of them, the lowest and the highest, each at its own time: peaks are never lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.support_motion import SupportMotion
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES

POINTS = 2400  # of one curve at most
COSTS = {"seconds": "solver/seconds", "iterations": "solver/iterations", "contacts": "solver/contacts"}


@dataclass(frozen=True, eq=False)
class SeriesCurve:
    """A value over time: (P,) float32 each."""

    time: np.ndarray
    value: np.ndarray


def thinned(time: np.ndarray, value: np.ndarray, points: int = POINTS) -> SeriesCurve:
    """The lowest and the highest value of each stretch, in the order in which they occur; all of them where they are few."""
    if len(value) <= points:
        return SeriesCurve(time.astype(np.float32), value.astype(np.float32))
    bounds = np.linspace(0, len(value), points // 2 + 1).astype(np.int64)[:-1]
    stretch = np.repeat(np.arange(len(bounds)), np.diff(np.append(bounds, len(value))))
    sound = np.isfinite(value)
    order = np.lexsort((np.where(sound, value, np.inf), stretch))
    lowest = order[bounds]
    order = np.lexsort((np.where(sound, value, -np.inf), stretch))
    highest = order[np.append(bounds[1:], len(value)) - 1]
    keep = np.unique(np.concatenate([[0, len(value) - 1], lowest, highest]))
    return SeriesCurve(time[keep].astype(np.float32), value[keep].astype(np.float32))


def base_motion(results: Results, motions: Sequence[SupportMotion]) -> dict[str, SeriesCurve]:
    """Displacement [m] and velocity [m/s] of each motion of the supports, ``base/0/displacement/x`` and so on."""
    time = np.asarray(results.time, dtype=float)
    out: dict[str, SeriesCurve] = {}
    for k, motion in enumerate(motions):
        for name, values in (("displacement", motion.displacement), ("velocity", motion.velocity)):
            out |= {f"base/{k}/{name}/{axis}": thinned(time, column) for axis, column in zip("xyz", values.T, strict=True)}
    return out


def step_curves(results: Results) -> dict[str, SeriesCurve]:
    """Written per step: energies [J], solver error, cost; what a file does not hold, or an energy that is always zero, is left out."""
    time = _steps(results, "step_time")
    if time is None:
        return {}
    names = {f"energy/{name}": f"energy/{name}" for name in ENERGIES}
    names |= {f"cost/{name}": path for name, path in COSTS.items()} | {"error": "solver/error", "penetration": "penetration"}
    out = {}
    for name, path in names.items():
        values = _steps(results, path)
        if values is not None and (values.any() or not name.startswith("energy/")):
            rows = min(len(values), len(time))
            out[name] = thinned(time[:rows], values[:rows])
    return out


def steps_missed(results: Results, tolerance: float) -> tuple[int, int, np.ndarray]:
    """Steps whose error is above the tolerance, of how many, and their times (at most ``POINTS`` of them) [s]."""
    time, error = _steps(results, "step_time"), _steps(results, "solver/error")
    if time is None or error is None:
        return 0, 0, np.zeros(0, np.float32)
    rows = min(len(time), len(error))
    missed = np.flatnonzero(~(error[:rows] <= tolerance))
    some = missed[np.unique(np.linspace(0, len(missed) - 1, POINTS).astype(np.int64))] if len(missed) > POINTS else missed
    return len(missed), rows, time[some].astype(np.float32)


def _steps(results: Results, name: str) -> np.ndarray | None:
    """A value per step, or None where the file holds none."""
    values = np.asarray(results.per_step(name), dtype=float)
    return values if len(values) else None
