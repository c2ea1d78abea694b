# SPDX-License-Identifier: GPL-3.0-or-later
"""summary.json: what a run has come to, read with all that its readers take for granted checked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text

NAME = "summary.json"
FORMAT = 1  # of its keys; raised when an older program would misread them
TABLES = ("solver", "energy", "islands", "closing", "loads", "left_out", "beds")
NUMBERS = ("steps", "steps_asked", "dt", "wall_seconds", "stepping_seconds", "contacts_mean", "contacts_max", "penetration_max")
TEXTS = ("title", "version", "stopped", "penetration_where", "crushed_where", "provisional")
OF_TABLES: dict[str, dict[str, type]] = {
    "solver": {
        "name": str,
        "tolerance": float,
        "error_max": float,
        "error_mean": float,
        "steps_missed": float,
        "violation_max": float,
        "false_slip_max": float,
        "false_opening_max": float,
        "false_slip_where": str,
    },
    "energy": {"balance_error": float, "kinetic_end": float},
    "loads": {"tables": list},
    "beds": {"share_least": float, "unresolved": float, "share": float, "points": float, "resolved": float, "where": str},
}  # each may be missing, or null as what is not finite is


class Newer(InputError):
    """A summary of a format that a later version of the program wrote."""


def read_summary(folder: Path) -> dict[str, Any]:
    """The summary of a run; empty where it has written none.

    Raises:
        Newer: its format is unknown here.
        InputError: it is no summary.
    """
    path = folder / NAME
    if not path.exists():
        return {}
    try:
        found = json.loads(read_text(path))
    except (OSError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError(path, "not a summary, or one that was cut off")
    form = found.get("format", 0)
    if _is_number(form) and form > FORMAT:
        raise Newer(path, f"of format {form}, which a newer masonry_cd wrote; this one reads formats up to {FORMAT}")
    expected: dict[str, type] = {**dict.fromkeys(TABLES, dict), **dict.fromkeys(NUMBERS, float), **dict.fromkeys(TEXTS, str)}
    _check(path, found, expected, "")
    for table, keys in OF_TABLES.items():
        _check(path, found.get(table) or {}, keys, f"{table}.")
    return found


def _check(path: Path, table: dict[str, Any], keys: dict[str, type], above: str) -> None:
    """Check the types of what a table holds."""
    for key, kind in keys.items():
        value = table.get(key)
        if value is not None and not (_is_number(value) if kind is float else isinstance(value, kind)):
            raise InputError(path, f"{above}{key} is not what a run writes: not a summary, or a damaged one")


def _is_number(value: object) -> bool:
    """Whether a value is a number that a float can hold."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
