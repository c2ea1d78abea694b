# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of pushes and gauges of a run, from its result file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_cd.analysis.gauge_histories import unit_of_column
from masonry_cd.analysis.pushover import push_curves, require_pushes
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.interface.tables import frame_of
from masonry_cd.io.results import Results
from reports.laboratory import histories_of

if TYPE_CHECKING:
    from pandas import DataFrame


def push_table(results: Results, push: str | None) -> DataFrame:
    """A push or prop by its name, the first push for None.

    Raises:
        InputError: there is none.
    """
    curves = push_curves(results) if push else require_pushes(results)
    names = [curve.name for curve in curves]
    if push and push not in names:
        there = ", ".join(names) or "none"
        raise InputError("force_displacement", f'"{push}" is no push or prop{suggest(push, names)}; there are {there}')
    curve = curves[names.index(push) if push else 0]
    columns = {name: getattr(curve, name) for name in ("displacement", "force", "moment", "inertia")}
    return frame_of(columns, curve.time, "time", numbers=curve.numbers())


def gauge_table(results: Results, name: str) -> DataFrame:
    """A gauge by its name.

    Raises:
        InputError: none has this name.
    """
    by_name = {own: columns for kind in histories_of(results).values() for own, columns in kind.items()}
    if name not in by_name:
        raise InputError("gauge", f'"{name}" is none{suggest(name, by_name)}; there are {", ".join(by_name)}')
    columns = dict(by_name[name])
    time = columns.pop("time")
    frame = frame_of(columns, time, "time")
    frame.attrs["units"] |= {column: unit_of_column(column) for column in ("time", *columns)}
    return frame
