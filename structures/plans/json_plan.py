# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans in JSON: the keys of a building's table, ``{"units": "m", "walls": [...], "vaults": [...]}``, to be corrected by hand."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from structures.files.json_object import load

OF_A_FILE = ("$schema", "comment")  # keys that say nothing of the building


def read_json(path: Path) -> dict[str, Any]:
    """The tables of a plan in JSON.

    Raises:
        InputError: no JSON, no object, other units, or no walls; with the line of what is wrong.
    """
    plan = load(path, "walls")
    if plan.get("units", "m") != "m":
        raise InputError(path.name, 'units: lengths of a plan in JSON are in metres, "m"; single ones may be texts with a unit, "30 cm"')
    if not isinstance(plan.get("walls"), list) or not plan["walls"]:
        raise InputError(path.name, "walls: missing; a plan has at least one wall")
    return {key: value for key, value in plan.items() if key not in ("units", *OF_A_FILE)}


def write_json(path: Path, tables: Mapping[str, Any]) -> None:
    """Write the tables of a plan: a line for each wall's, opening's and vault's own keys."""
    text = _text({"units": "m", **tables}, "")
    with replacing(path) as part:
        part.write_text(text + "\n", encoding="utf-8")


def _text(value: Any, indent: str) -> str:
    """JSON that is wide where it is flat: objects without lists of objects within on one line."""
    inner = indent + "  "
    if isinstance(value, Mapping) and any(_is_deep(part) for part in value.values()):
        flat = {key: part for key, part in value.items() if not _is_deep(part)}
        lines = [json.dumps(flat, ensure_ascii=False, allow_nan=False)[1:-1]] if flat else []
        lines += [f"{json.dumps(key)}: {_text(part, inner)}" for key, part in value.items() if _is_deep(part)]
        return "{\n" + ",\n".join(inner + line for line in lines) + f"\n{indent}}}"
    if _is_deep(value):
        return "[\n" + ",\n".join(inner + _text(part, inner) for part in value) + f"\n{indent}]"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _is_deep(value: Any) -> bool:
    """Return True if a value is a list of objects with keys of their own, other than the pieces of an axis."""
    return isinstance(value, (list, tuple)) and any(isinstance(part, Mapping) and "to" not in part for part in value)
