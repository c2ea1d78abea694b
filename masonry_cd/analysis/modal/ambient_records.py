# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient records: a CSV file of accelerations, and one of the places of the sensors.

    time_s,A1_x_m_s2,A1_y_m_s2,A2_y_m_s2          sensor,x_m,y_m,z_m
    0.00,0.00012,-0.00034,0.00021                 A1,0.0,1.0,8.5
    0.01,0.00018,-0.00029,0.00017                 A2,6.0,1.0,8.5

A heading names sensor, axis and unit, ``A1 x [mg]`` as well. Times advance evenly. Lines that begin with # are remarks.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from loads.readers.units import TIME, acceleration_unit, split_heading
from masonry_cd.analysis.modal.ambient import AmbientRecord
from masonry_cd.analysis.modal.measured_modes import PLACES, cells, number, numbered_lines, place_of, table_rows
from masonry_cd.foundation.errors import InputError, suggest

UNEVEN = 0.5  # of a step: times written with few digits stay below, a missing line does not


def read_ambient(path: Path, sensors: Path) -> AmbientRecord:
    """Read a record and the places of its sensors.

    Raises:
        InputError: a file, heading or value that is wrong; names file, line and column.
    """
    lines = numbered_lines(path, "holds no record; the first line names time_s and the channels, such as A1_x_m_s2")
    header = cells(lines[0][1], lines[0][0])
    channels = [_channel(name, path) for name in header[1:]]
    name, unit = split_heading(header[0])
    if name.lower() not in ("time", "t") or (unit or "") not in TIME:
        raise InputError(path, f'the first column should be time_s, got "{header[0]}"')
    if not channels:
        raise InputError(path, "has no channel next to the time; a heading names sensor, axis and unit, such as A1_x_m_s2")
    for k, (sensor, axis, _) in enumerate(channels):
        if (sensor, axis) in [channel[:2] for channel in channels[:k]]:
            raise InputError(path, f'column "{header[k + 1]}": sensor {sensor} has its {axis} in a column before')
    table = _numbers(lines[1:], header)
    for name, spread in zip(header, np.ptp(table, axis=0), strict=True):
        if spread == 0.0:
            raise InputError(path, f'column "{name}": does not vary')
    step = TIME[unit or ""] * _step(table[:, 0], [where for where, _ in lines[1:]])
    placed = _places(sensors)
    names = tuple(dict.fromkeys(sensor for sensor, _, _ in channels))
    for sensor in names:
        if sensor not in placed:
            raise InputError(sensors, f'has no sensor "{sensor}", which {path.name} has{suggest(sensor, tuple(placed))}')
    points = np.array([placed[sensor][1] for sensor in names])
    index = np.array([names.index(sensor) for sensor, _, _ in channels])
    axes = np.array(["xyz".index(axis) for _, axis, _ in channels])
    values = table[:, 1:] * np.array([factor for _, _, factor in channels])
    return AmbientRecord(path, values, step, index, axes, names, points, tuple(placed[sensor][0] for sensor in names))


def _channel(heading: str, path: Path) -> tuple[str, str, float]:
    """Sensor, axis and size of the unit [m/s2] of a heading."""
    name, unit = split_heading(heading)
    factor = acceleration_unit(unit) if unit else None
    if factor is None:
        said = "has no unit" if unit is None else f"{unit} is not a unit of acceleration"
        raise InputError(path, f'column "{heading}": {said}; write sensor, axis and unit, such as A1_x_m_s2 or A1_x_mg')
    found = re.fullmatch(r"(.+)[ _]([xyz])", name)
    if found is None:
        raise InputError(path, f'column "{heading}": names no axis; write sensor, axis and unit, such as A1_x_m_s2')
    return found[1], found[2], factor


def _numbers(lines: Sequence[tuple[str, str]], header: Sequence[str]) -> np.ndarray:
    """The numbers of the lines, (N, columns)."""
    try:
        table = np.loadtxt([line for _, line in lines], delimiter=",", comments=None, ndmin=2)
        if table.shape[1] == len(header) and np.isfinite(table).all():
            return table
    except ValueError:
        pass  # cell by cell, then: to say which it is, or to read what is quoted
    rows = []
    for where, line in lines:
        row = cells(line, where)
        if len(row) != len(header):
            raise InputError(where, f"{len(row)} values under {len(header)} columns")
        rows.append([number(text, name, where) for text, name in zip(row, header, strict=True)])
    return np.array(rows)


def _step(times: np.ndarray, places: Sequence[str]) -> float:
    """The step of times that advance evenly, in their unit."""
    if len(times) < 3:
        raise InputError(places[0], f"{len(times)} lines of numbers are no record")
    steps = np.diff(times)
    usual = float(np.median(steps))
    for k in np.flatnonzero(~(np.abs(steps - usual) < UNEVEN * usual)).tolist():
        raise InputError(places[k + 1], f"the time advances by {steps[k]:.4g}, elsewhere by {usual:.4g}")
    return float(times[-1] - times[0]) / (len(times) - 1)


def _places(path: Path) -> dict[str, tuple[str, list[float]]]:
    """File and line, and point [m], of each sensor."""
    header, rows = table_rows(path, ("sensor", *PLACES), "holds no sensors; the first line names the columns: sensor, x_m, y_m, z_m")
    if "sensor" not in header or sorted(PLACES[name][0] for name in header if name in PLACES) != ["x", "y", "z"]:
        raise InputError(path, "should have the columns sensor, x_m, y_m, z_m, each once")
    out: dict[str, tuple[str, list[float]]] = {}
    for where, row in rows:
        if row["sensor"] in out:
            raise InputError(where, f"sensor {row['sensor']} occurs twice")
        out[row["sensor"]] = where, place_of(row, where)
    return out
