# SPDX-License-Identifier: GPL-3.0-or-later
r"""Supports that follow a history that was measured or chosen: displacements, velocities and rotations, support by support.

Of one history the scene has the times, and the values along a direction or about an axis. A table (CSV) has a column of times and one for
each support and component, each with its unit in brackets:

    time [d], pier1.z [mm], pier2.z [mm], pier2.ry [mrad]

x, y, z are along the world axes, displacements or velocities by their unit; rx, ry, rz are the components of the rotation vector, axis by
angle. A name is that of a support or group, and may have * in it; with ``supports`` the columns have components alone. Displacements and
rotations are counted from the first row, smooth in between, and at rest before and after (:mod:`loads.value_history`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from loads.kinds.settlement import MOVED, SETTLED
from loads.motion import Direction, DirectionKey, LoadAction, LoadKind, LoadTable, RunGrid, Static, Turning
from loads.readers.fields import decimal, delimiter_of, split
from loads.readers.source import Source
from loads.readers.units import split_heading
from loads.supports import Names, select_supports
from loads.turning import by_rotation
from loads.value_history import ValueHistory, at_middles
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Instant, Numbers, Span, Vector
from masonry_cd.foundation.quantities import counted, length
from masonry_cd.foundation.units import Unit, UnitError, number_in

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
TIMES = ("time", "t")
FEWEST_STEPS = 10  # of the run in a history
AT_ONCE = 1e-3  # share of its largest speed by which a history may begin or end moving
OF_HISTORY = ("displacement", "velocity", "rotation")


class MotionTable(LoadTable):
    """Keys of ``kind = "motion"``."""

    kind: Literal["motion"] = "motion"
    supports: Names = None
    """Names of fixed blocks or groups, * stands for any letters; left out where the columns of a file name them."""
    path: str | None = None
    """A table (CSV): a column of times, and one for each support and component with its unit, e.g. "pier1.z [mm]"."""
    time: Annotated[Numbers | None, Unit("s")] = None
    """Increasing times, instead of a time step."""
    displacement: Annotated[Numbers | None, Unit("m"), SETTLED, MOVED[0]] = None
    """At these times, along the direction."""
    velocity: Annotated[Numbers | None, Unit("m/s")] = None
    """Velocity along the direction, instead of a displacement, straight between the times."""
    rotation: Annotated[Numbers | None, Unit("degrees")] = None
    """Angle at these times, about the axis."""
    direction: Annotated[DirectionKey, Field(json_schema_extra={"default": "-z"})] = Direction((0.0, 0.0, -1.0), "-z")
    """Axis, vector or level angle from x to y along which the supports move."""
    axis: DirectionKey | None = None
    """Axis, vector or level angle from x to y about which they turn, by the right hand."""
    about: Annotated[Vector | None, Unit("m")] = None
    """Point about which they turn, as built, which moves with them; each about its own centre of mass when not given."""
    start: Instant = 0.0
    """When the history begins."""
    duration: Span | None = None
    """Duration in the run; that of the history itself when not given."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = [key for key in OF_HISTORY if getattr(self, key) is not None]
        if self.path is not None:
            astray = next((key for key in ("time", *given, "axis") if getattr(self, key) is not None), "")
            if astray or "direction" in self.model_fields_set:
                raise ValueError(f"{astray or 'direction'}: does not apply with path: the columns of the file give it")
            return self
        if self.time is None:
            raise ValueError("time: missing; give path, or time with displacement, velocity or rotation")
        if self.supports is None:
            raise ValueError("supports: missing; the columns of a file may name them")
        if not given or {"displacement", "velocity"} <= set(given):
            raise ValueError("displacement: give displacement or velocity, or rotation, or one of the former with rotation")
        for key in given:
            if len(getattr(self, key)) != len(self.time):
                raise ValueError(f"{key}: {len(getattr(self, key))} values at {len(self.time)} times")
        if ("rotation" in given) != (self.axis is not None):
            raise ValueError("axis: needed with rotation, and only with it")
        return self


class Column(NamedTuple):
    """A component of the motion of supports over time."""

    names: tuple[str, ...] | None  # of the supports; None: all
    component: int  # of COMPONENTS
    values: np.ndarray  # (N,) [m], [m/s] or [rad]
    is_velocity: bool
    where: str  # for messages


class Moving(NamedTuple):
    """Supports that follow one course."""

    supports: np.ndarray  # (B,) bool
    course: ValueHistory  # of six components


def motion(table: MotionTable, grid: RunGrid, where: str) -> LoadAction:
    """The motions of the supports.

    Raises:
        InputError: a bad file, names that fit no support, two columns for one component, or a history that the steps cannot follow.
    """
    every = _moving(table, grid, where)
    parts = [_part(one, table, grid, where) for one in every]
    times = every[0].course.times
    together = ValueHistory(times, np.concatenate([one.course.values for one in every], axis=1))
    farthest = max(float(np.abs(one.course.at(times)[:, :3]).max()) for one in every)
    angle = math.degrees(max(float(np.abs(one.course.at(times)[:, 3:]).max()) for one in every))
    moved = np.any([one.supports for one in every], axis=0)
    names = [grid.blocks(where).names[b] for b in np.flatnonzero(moved)]
    turns = f" and {angle:.3g} degrees" if angle else ""
    how = f"by up to {length(farthest)}{turns}, {times[0]:g} to {times[-1]:.4g} s"
    summary = table.facts("path", "start", "duration") | {"supports": names, "displacement": farthest, "rotation": angle}
    return replace(
        parts[0],
        more=tuple(parts[1:]),
        lines=(f"{where} motion of {counted(len(names), 'support')} {how}",),
        warnings=tuple(_at_once(every, where)),
        summary=summary,
        acted=together.acted(where),
    )


def _part(one: Moving, table: MotionTable, grid: RunGrid, where: str) -> LoadAction:
    """Return the part of the loads that drives supports along one course."""
    turns = bool(one.course.values[:, 3:].any())
    about = None if table.about is None else np.array(table.about)
    turning = Turning(lambda grid: by_rotation(at_middles(one.course.at, grid.times, grid.dt)[:, 3:], grid.dt, where), about)
    return LoadAction(
        motion=lambda times: np.diff(at_middles(one.course.at, times, grid.dt)[:, :3], axis=0) / grid.dt,
        share=one.supports.astype(float),
        turning=turning if turns else None,
    )


def _moving(table: MotionTable, grid: RunGrid, where: str) -> list[Moving]:
    """The supports by the courses that they follow.

    Raises:
        InputError: see :func:`motion`.
    """
    times, columns = _of_scene(table, where) if table.path is None else _of_file(table, table.path, grid, where)
    if len(times) < 2 or (np.diff(times) <= 0.0).any():
        raise InputError(f"{where}.{'time' if table.path is None else 'path'}", "two times at least are needed, and they have to increase")
    scale = 1.0 if table.duration is None else table.duration / float(times[-1] - times[0])
    if table.duration is not None and any(column.is_velocity for column in columns):
        raise InputError(f"{where}.duration", "velocities go with their own times; of displacements and rotations the run may take another")
    at = table.start + scale * (times - times[0])
    steps = (at[-1] - at[0]) / grid.dt
    if steps < FEWEST_STEPS:
        raise InputError(where, f"the history takes {steps:.3g} steps of run.dt {grid.dt:g} s, and at least {FEWEST_STEPS} are needed")
    found = [Moving(mask, _course(at, [columns[k] for k in own])) for own, mask in _by_support(columns, grid, where).items()]
    found[0].course.check_steps(grid.dt, f"{where}.{'time' if table.path is None else 'path'}")
    if table.about is not None and not any(one.course.values[:, 3:].any() for one in found):
        raise InputError(f"{where}.about", "does not apply: nothing turns")
    return found


def _by_support(columns: Sequence[Column], grid: RunGrid, where: str) -> dict[tuple[int, ...], np.ndarray]:
    """The supports (B,) that follow the same columns, by the numbers of these.

    Raises:
        InputError: names that fit no support, or two columns for one component of a support.
    """
    assembly = grid.blocks(where)
    own: dict[int, tuple[int, ...]] = {}
    for k, column in enumerate(columns):
        for b in np.flatnonzero(select_supports(column.names, grid, column.where)).tolist():
            mine = own.get(b, ())
            if any(columns[j].component == column.component for j in mine):
                raise InputError(column.where, f'gives {COMPONENTS[column.component]} of "{assembly.names[b]}" a second time')
            own[b] = (*mine, k)
    out: dict[tuple[int, ...], np.ndarray] = {}
    for b, mine in own.items():
        out.setdefault(mine, np.zeros(assembly.count, dtype=bool))[b] = True
    return out


def _course(times: np.ndarray, columns: Sequence[Column]) -> ValueHistory:
    """The course of six components (N, 6), by those that are given."""
    values, slopes = np.zeros((len(times), 6)), np.full((len(times), 6), np.nan)
    for column in columns:
        c = column.component
        if column.is_velocity:
            v, slopes[:, c] = column.values, column.values
            values[1:, c] = np.cumsum(0.5 * np.diff(times) * (v[1:] + v[:-1]))
        else:
            values[:, c] = column.values - column.values[0]
    return ValueHistory(times, values, slopes)


def _at_once(every: list[Moving], where: str) -> Iterator[str]:
    """A warning where velocities begin or end with a jump, which strikes what stands on the supports."""
    for one in every:
        slopes = np.nan_to_num(one.course.slopes) if one.course.slopes is not None else np.zeros((2, 6))
        most = float(np.abs(slopes).max())
        for end, at in (("begin", 0), ("end", -1)):
            speed = float(np.abs(slopes[at]).max())
            if speed > AT_ONCE * most:
                yield f"{where} velocities {end} at {speed:.3g} m/s at once, which strikes what stands on these supports"
                return


def _of_scene(table: MotionTable, where: str) -> tuple[np.ndarray, list[Column]]:
    """Times and columns of a history in the scene."""
    columns = []
    for key in OF_HISTORY:
        values = getattr(table, key)
        if values is None:
            continue
        way = table.axis if key == "rotation" else table.direction
        assert way is not None  # there with a rotation
        size = np.array(values) * (math.pi / 180.0 if key == "rotation" else 1.0)
        columns += [
            Column(table.supports, i + 3 * (key == "rotation"), size * way.vector[i], key == "velocity", f"{where}.supports")
            for i in range(3)
            if way.vector[i]
        ]
    return np.array(table.time), columns


def _of_file(table: MotionTable, path: str, grid: RunGrid, where: str) -> tuple[np.ndarray, list[Column]]:
    """Times and columns of a table.

    Raises:
        InputError: names the file, and the line or the heading.
    """
    source = Source.open(grid.folder / path, f"{where}.path: {path}")
    delimiter = delimiter_of(source)
    if delimiter is None:
        raise source.error("no comma, semicolon or tab between numbers, as a CSV file has")
    rows = [(i, split(line, delimiter)) for i, line in source.content()]
    headings, numbers = [split_heading(text) for text in rows[0][1]], list[list[float]]()
    for i, fields in rows[1:]:
        if len(fields) != len(headings):
            raise source.error(f"{len(fields)} columns, where the headings are {len(headings)}", i)
        numbers.append([source.number(decimal(field, delimiter), i) for field in fields])
    values = np.array(numbers).reshape(-1, len(headings))
    at = next((k for k, (name, _) in enumerate(headings) if name.lower() in TIMES), None)
    if at is None:
        raise source.error(f'no column "time"; headings: {", ".join(rows[0][1])}', rows[0][0])
    times = values[:, at] * _size(headings[at], ("s",), source, rows[0][0])[1]
    columns = [_column(heading, values[:, k], table, source, rows[0][0]) for k, heading in enumerate(headings) if k != at]
    if not columns:
        raise source.error("times alone; a column for each support and component is needed", rows[0][0])
    return times, columns


def _column(heading: tuple[str, str | None], values: np.ndarray, table: MotionTable, source: Source, line: int) -> Column:
    """The column of a heading, ``pier1.z [mm]``, or ``z [mm]`` with the key supports."""
    support, _, component = heading[0].rpartition(".")
    if component not in COMPONENTS:
        raise source.error(f'"{heading[0]}" ends with no component{suggest(component, COMPONENTS)}: {", ".join(COMPONENTS)}', line)
    if (table.supports is None) == (not support):
        which = "names no support, and the key supports is not given" if not support else "names a support, and so does the key supports"
        raise source.error(f'"{heading[0]}" {which}', line)
    turns = component.startswith("r")
    unit, size = _size(heading, ("degrees",) if turns else ("m", "m/s"), source, line)
    where = f'{source.label}, line {source.skipped + line + 1}, "{heading[0]}"'
    factor = size * (math.pi / 180.0 if turns else 1.0)
    return Column((support,) if support else table.supports, COMPONENTS.index(component), factor * values, unit == "m/s", where)


def _size(heading: tuple[str, str | None], units: tuple[str, ...], source: Source, line: int) -> tuple[str, float]:
    """The first of some units that the unit of a heading is one of, and its size in it.

    Raises:
        InputError: no unit, or one of something else.
    """
    name, given = heading
    if given is None:
        raise source.error(f'"{name}" states no unit; write it behind the name, "{name} [{"d" if units == ("s",) else "mm"}]"', line)
    fault = ""
    for unit in units:
        try:
            return unit, number_in(f"1 {given}", unit)
        except UnitError as reason:
            fault = fault or str(reason).partition(";")[0]
    raise source.error(f'"{name} [{given}]": {fault}', line)


def _static(table: MotionTable, grid: RunGrid, where: str) -> Static | None:
    """The way from the first to the last values; by one metre of the corner that goes farthest. None of supports that come back."""
    assembly = grid.blocks(where)
    every = _moving(table, grid, where)
    velocity = np.zeros((assembly.count, 6))
    for one in every:
        velocity[one.supports] = one.course.values[-1]
        if table.about is not None:
            velocity[one.supports, :3] += np.cross(velocity[one.supports, 3:], assembly.centre[one.supports] - np.array(table.about))
    corners = [
        np.sqrt(np.sum((row[:3] + np.cross(row[3:], block.vertices - centre)) ** 2, axis=1)).max()
        for row, block, centre in zip(velocity, assembly.blocks, assembly.centre, strict=True)
    ]
    farthest = max(corners)
    return Static(f"{where} motion of supports", velocity=velocity / farthest) if farthest > 0.0 else None


KINDS = {
    "motion": LoadKind(
        MotionTable,
        motion,
        static=_static,
        pattern=lambda table: "settlement",
        gentle=True,
        starter={"supports": "abutment2", "time": [0.0, 2.0, 4.0, 6.0], "displacement": [0.0, 0.01, 0.015, 0.02]},
    )
}
