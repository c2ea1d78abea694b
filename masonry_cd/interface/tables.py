# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables as DataFrames of pandas whose units are known: ``frame.attrs["units"]`` gives the unit of each column that has one.

Columns are called as in the CSV files of a run; values are in SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.app.per_step import QUANTITIES
from masonry_cd.foundation.extras import require
from masonry_cd.mechanics.model.joint_laws import histories

if TYPE_CHECKING:
    from pandas import DataFrame

UNITS = {
    "m": "x y z ux uy uz base_x base_y base_z from_z to_z mean_z residual_x residual_y largest_displacement max_opening residual_opening "
    "max_sliding residual_sliding opening sliding displacement",
    "m2": "area joint_area opened_area slid_area separated_area open_area slipped_area apart_area contact_area",
    "m3": "volume",
    "kg": "mass",
    "s": "time first_opening_time max_compression_time max_tension_time max_edge_stress_time max_normal_force_time",
    "rad": "rx ry rz max_rotation rotation turn",
    "m/s": "vx vy vz",
    "rad/s": "wx wy wz",
    "N": "force inertia normal_force shear_force max_normal_force fx fy fz",
    "N m": "mx my mz",
    "Pa": "max_compression max_tension strength max_edge_stress max_finite_edge_stress end_edge_stress xx yy zz xy yz xz s1 s2 s3",
    "Hz": "frequency_hz",
}
UNIT_OF = {name: unit for unit, names in UNITS.items() for name in names.split()}
UNIT_OF |= {name.rpartition("/")[2]: quantity.unit for name, quantity in QUANTITIES.items() if quantity.unit}
UNIT_OF |= {history.name: history.unit for history in histories() if history.unit}


def frame_of(columns: Mapping[Any, Any], index: Any = None, name: str | None = None, unit: str = "", **about: Any) -> DataFrame:
    """A DataFrame with its units.

    Args:
        columns: (N,) each, by name.
        index: (N,) the index; numbers from zero when not given.
        name: of the index.
        unit: of all columns, where these are named by what they are of (blocks, joints); else by their names.
        about: further attributes of the frame.
    """
    require("a table", "pandas")
    import pandas

    frame = pandas.DataFrame(dict(columns), index=None if index is None else pandas.Index(index, name=name))
    units = {str(column): unit or UNIT_OF[str(column)] for column in frame.columns if unit or str(column) in UNIT_OF}
    if name in UNIT_OF:
        units[name] = UNIT_OF[name]
    frame.attrs |= {"units": units} | about
    return frame


def frame_of_rows(rows: Sequence[Mapping[str, Any]], index: str = "", **about: Any) -> DataFrame:
    """A DataFrame with its units from rows of equal keys; ``index`` is the column that becomes the index."""
    columns = {key: [row[key] for row in rows] for key in (rows[0] if rows else ())}
    return frame_of(columns, columns.pop(index, None) if index else None, index or None, **about)


def columns_of(names: Iterable[str], values: Any) -> dict[str, np.ndarray]:
    """The columns of an array (N, C) by their names."""
    return dict(zip(names, np.asarray(values, dtype=float).T, strict=True))
