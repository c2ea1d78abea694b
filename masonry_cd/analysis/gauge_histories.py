# SPDX-License-Identifier: GPL-3.0-or-later
"""Histories at the gauges of a scene, as columns over the steps of a run: points, joints, cracks and supports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.io.gauges import JOINT_COLUMNS, Gauges
from masonry_cd.io.results import Results

History = dict[str, np.ndarray]
UNITS = {
    "time": "s", "u": "m", "v": "m/s", "a": "m/s2", "opening": "m", "sliding": "m", "slip": "m", "normal_force": "N", "shear_force": "N",
    "moment": "N m", "depth": "m", "f": "N",
}  # fmt: skip


def unit_of_column(name: str) -> str:
    """Return the unit of a column of these tables."""
    return UNITS.get(name, UNITS.get(name[:-2] if name[-2:] in ("_x", "_y", "_z") else name[:-1], ""))


def point_histories(results: Results) -> dict[str, History]:
    """Displacement, velocity and acceleration of each point by its name: time, ux .. az, relative to the base where the scene says so.

    The acceleration of a step is the change of velocity in it over its length.
    """
    gauges, time = results.gauges.points, results.per_step("step_time")
    rows, base = results.per_step("gauges/points"), results.per_step("gauges/base")
    found: dict[str, History] = {}
    if not gauges or not len(rows):
        return found
    time = time[: len(rows)]
    step = np.diff(time, prepend=0.0)[:, None]
    for k, gauge in enumerate(gauges):
        moved = np.asarray(rows[:, k], dtype=float) - (base if gauge.relative else 0.0)
        acceleration = np.diff(moved[:, 3:], axis=0, prepend=np.zeros((1, 3))) / step
        values = np.concatenate([moved, acceleration], axis=1)
        found[_free(gauge.name, found)] = {"time": time, **dict(zip(_columns("uva"), values.T, strict=True))}
    return found


def joint_gauge_histories(results: Results) -> dict[str, History]:
    """Opening, sliding, forces, moment and compressed depth of each joint by its name."""
    return _plain(results, results.gauges.joints, "gauges/joints", JOINT_COLUMNS)


def support_histories(results: Results) -> dict[str, History]:
    """Reactions of each support by its name: fx, fy, fz on what stands on it."""
    return _plain(results, results.gauges.supports, "gauges/supports", _columns("f"))


def crack_histories(results: Results) -> dict[str, History]:
    """Return the history of each crack gauge by its name: opening along the line between its points as built, and the size of the slip."""
    found = _plain(results, results.gauges.cracks, "gauges/cracks", _columns("u"))
    made: dict[str, History] = {}
    for gauge, (name, columns) in zip(results.gauges.cracks, found.items(), strict=False):
        line = np.array(gauge.points[1]) - np.array(gauge.points[0])
        line /= np.sqrt(np.sum(line * line))
        gone = np.stack([columns["ux"], columns["uy"], columns["uz"]], axis=1)
        along = np.sum(gone * line, axis=1)
        across = gone - along[:, None] * line
        made[name] = {"time": columns["time"], "opening": along, "slip": np.sqrt(np.sum(across * across, axis=1))}
    return made


def gauge_histories(results: Results) -> dict[str, History]:
    """All of these by the names of the gauges; of those of one name the first, in the order of points, joints, cracks and supports."""
    kinds = (support_histories, crack_histories, joint_gauge_histories, point_histories)
    return {name: columns for kind in kinds for name, columns in kind(results).items()}


def columns_of(gauges: Gauges) -> dict[str, tuple[str, ...]]:
    """The columns of each gauge by its name, time aside, likewise."""
    kinds = (
        (gauges.supports, _columns("f")),
        (gauges.cracks, ("opening", "slip")),
        (gauges.joints, JOINT_COLUMNS),
        (gauges.points, _columns("uva")),
    )
    return {gauge.name: columns for every, columns in kinds for gauge in every}


def _plain(results: Results, gauges: Sequence[Any], dataset: str, columns: tuple[str, ...]) -> dict[str, History]:
    """Histories as they were written."""
    rows, time = results.per_step(dataset), results.per_step("step_time")
    found: dict[str, History] = {}
    for k, gauge in enumerate(gauges if len(rows) else ()):
        found[_free(gauge.name, found)] = {
            "time": time[: len(rows)],
            **dict(zip(columns, np.asarray(rows[:, k], dtype=float).T, strict=True)),
        }
    return found


def _columns(quantities: str) -> tuple[str, ...]:
    return tuple(f"{quantity}{axis}" for quantity in quantities for axis in "xyz")


def _free(name: str, taken: dict[str, History]) -> str:
    """The name, or one with a number behind it where it is taken."""
    count = 2
    made = name
    while made in taken:
        made, count = f"{name} {count}", count + 1
    return made
