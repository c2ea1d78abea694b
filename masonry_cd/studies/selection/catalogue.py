# SPDX-License-Identifier: GPL-3.0-or-later
"""The catalogue of records: a CSV file with a row for each motion, and any of these columns; others are not read.

motion,event,magnitude,distance_km,vs30_m_s
aqv,laquila,6.3,4.9,474
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import finite_number
from masonry_cd.foundation.files import read_text
from masonry_cd.studies.selection.tables import CandidatesTable

COLUMNS = {"per_event": "event", "magnitude": "magnitude", "distance": "distance_km", "vs30": "vs30_m_s"}  # by the keys that need them
EVENT = COLUMNS["per_event"]

Row = Mapping[str, str | float]


def read_catalogue(table: CandidatesTable, folder: Path) -> dict[str, Row]:
    """Read the facts on each motion; cells that are empty are left out.

    Raises:
        InputError: no such file, a requested column that is missing, a motion twice, a number that is none; names file and line.
    """
    if table.catalogue is None:
        return {}
    path = folder / table.catalogue
    try:
        head, *lines = csv.reader(read_text(path, encoding="utf-8-sig").splitlines() or [""])
    except (OSError, UnicodeDecodeError, csv.Error) as failure:
        raise InputError("candidates.catalogue", f"{path}: cannot be read, {getattr(failure, 'strerror', None) or failure}") from None
    for column in ("motion", *(column for key, column in COLUMNS.items() if getattr(table, key) is not None)):
        if column not in head:
            raise InputError("candidates.catalogue", f"{path}: has no column {column}; there are {', '.join(head) or 'none'}")
    found: dict[str, Row] = {}
    for number, line in enumerate(lines, start=2):
        cells = {name: cell.strip() for name, cell in zip(head, line, strict=False) if cell.strip()}
        if motion := cells.get("motion", ""):
            if motion in found:
                raise InputError("candidates.catalogue", f'{path}:{number}: the motion "{motion}" stands there twice')
            found[motion] = {column: _value(column, cells[column], f"{path}:{number}") for column in COLUMNS.values() if column in cells}
    return found


def why_not(table: CandidatesTable, row: Row) -> str:
    """Why a motion may not be chosen; empty where it may."""
    for key, column in COLUMNS.items():
        limits = getattr(table, key)
        if limits is not None and column not in row:
            return f"the catalogue has no {column} of it"
        if isinstance(limits, tuple) and not limits[0] <= float(row[column]) <= limits[1]:
            return f"{column} {row[column]:g} is not from {limits[0]:g} to {limits[1]:g}"
    return ""


def _value(column: str, cell: str, where: str) -> str | float:
    number = finite_number(cell)
    if number is None and column != EVENT:
        raise InputError("candidates.catalogue", f'{where}: {column}: "{cell}" is not a number')
    return cell if column == EVENT or number is None else number
