# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns and piers of a building, one by one or in rows: round ones with plinth and capital, square ones of coursed stones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.building.stones import upright
from structures.building.table import BuildingColumnTable, BuildingTable
from structures.courser.columns import MOST_DRUMS, ColumnTable, column
from structures.courser.courses import divided

SIDES = 12  # of a round column
LEAST_HEIGHT = 1.5  # of a round column, in diameters: what is lower has no plinth and capital


@dataclass(frozen=True, eq=False)
class ColumnRow:
    """A row of columns, or a single one."""

    name: str
    keys: BuildingColumnTable
    places: tuple[np.ndarray, ...]  # (2,) each [m]
    where: str  # its key


def rows_of(table: BuildingTable, faults: Faults) -> list[ColumnRow]:
    """The columns of a table by rows; what is wrong is added to the faults."""
    found: list[ColumnRow] = []
    for k, keys in enumerate(table.columns):
        name = keys.name or f"column{k + 1}"
        with faults.of():
            _refuse_many(keys, table, f"columns[{k}].{'height' if keys.drum is None else 'drum'}")
        with faults.of(f"structure.columns[{k}]", f"columns {name}"):
            if name in {row.name for row in found}:
                raise InputError("", f'other ones have the name "{name}", too')
            found.append(ColumnRow(name, keys, tuple(_places(keys)), f"structure.columns[{k}]"))
    return found


def _refuse_many(keys: BuildingColumnTable, table: BuildingTable, key: str) -> None:
    """Refuse columns of too many drums or stones.

    Raises:
        InputError: names the key, the number and the limit.
    """
    if keys.section == "square":
        stones = _courses(keys, table) * max(1.0, keys.size / table.block_length)
    else:
        stones = _drums(keys, table)
        if stones > MOST_DRUMS:
            raise InputError(f"structure.{key}", f"makes {stones:.4g} drums of a column; at most {MOST_DRUMS} are allowed")
    size.check_size((keys.number or 1) * stones, key)


def _drums(keys: BuildingColumnTable, table: BuildingTable) -> float:
    """How many drums a round column is to have, not rounded."""
    _, plinth, capital = _ends(keys)
    return (keys.height - plinth - capital) / (keys.drum or 2.0 * table.course_height)


def _courses(keys: BuildingColumnTable, table: BuildingTable) -> float:
    """How many courses a square pier is to have, not rounded."""
    return keys.height / (keys.drum or table.course_height)


def _ends(keys: BuildingColumnTable) -> tuple[bool, float, float]:
    """Return if a round column is plain, and the heights of its plinth and capital [m]."""
    plain = keys.height < LEAST_HEIGHT * keys.size
    return (plain, 0.0, 0.0) if plain else (plain, 0.25 * keys.size, 0.4 * keys.size)


def _places(keys: BuildingColumnTable) -> np.ndarray:
    """Where the columns of a row stand (n, 2) [m].

    Raises:
        InputError: half a row, or columns in each other.
    """
    points = [keys.at] if isinstance(keys.at[0], float) else list(keys.at)
    places = np.array(points, dtype=float)
    if (keys.to is None) != (keys.number is None):
        raise InputError("", "a row from at to to has a number of columns; give both of to and number")
    if keys.to is not None and keys.number is not None:
        if len(points) > 1:
            raise InputError("", f"a row from at to to begins with one point, at has {len(points)}")
        share = np.linspace(0.0, 1.0, keys.number)[:, None]
        places = (1.0 - share) * places[0] + share * np.array(keys.to)
    gaps = [math.dist(a, b) for i, a in enumerate(places) for b in places[:i]]
    if gaps and min(gaps) < keys.size:
        raise InputError("", f"two of them are {min(gaps):.3g} m apart, closer than their size, {keys.size:g} m")
    return places


def blocks_of(row: ColumnRow, table: BuildingTable, density: float) -> list[Block]:
    """The blocks ``NAME.cNUMBER.PART`` of a row of columns."""
    found = []
    for i, place in enumerate(row.places, start=1):
        prefix = f"{row.name}.c{i}."
        found += _square(row, place, prefix, table, density) if row.keys.section == "square" else _round(row, place, prefix, table, density)
    return found


def _round(row: ColumnRow, place: np.ndarray, prefix: str, table: BuildingTable, density: float) -> list[Block]:
    """A column with plinth and capital, as wide as an arcade needs."""
    keys = row.keys
    plain, plinth, capital = _ends(keys)
    own = ColumnTable.model_validate(
        {
            "height": keys.height,
            "diameter": keys.size,
            "top_diameter": keys.size * (1.0 if plain else 0.9),
            "plinth": plinth,
            "capital": capital,
            "sides": SIDES,
            "drums": max(1, round(_drums(keys, table))),
        }
    )
    return column((float(place[0]), float(place[1])), keys.base, own, density, prefix, row.name)


def _square(row: ColumnRow, place: np.ndarray, prefix: str, table: BuildingTable, density: float) -> list[Block]:
    """A pier in courses of stones that lie crosswise in turns."""
    keys = row.keys
    half, turn = 0.5 * keys.size, math.radians(keys.turned)
    x, y = libm.cos(np.array([turn]))[0], libm.sin(np.array([turn]))[0]
    axes = np.array([[x, y], [-y, x]])
    beds = [keys.base + z for z in divided(0.0, keys.height, keys.drum or table.course_height)]
    count = max(1, round(keys.size / table.block_length))
    found = []
    for course, bed in enumerate(pairwise(beds)):
        ends = np.linspace(-half, half, count + 1)
        for k in range(count):
            plan = np.array([(ends[k], -half), (ends[k + 1], -half), (ends[k + 1], half), (ends[k], half)])
            plan = plan if course % 2 == 0 else plan[:, ::-1]
            vertices, faces = upright(place + plan @ axes, *bed)
            found.append(Block(f"{prefix}{course + 1}.{k + 1}", vertices, faces, density, row.name))
    return found
