# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a scene as numbers in SI units, and the unit of a key by its path.

A scene is kept as written, with its texts: "30 mm". What reads a table by its model sees numbers in any case; this is for what reads values
without one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.output_table import OutputTable
from masonry_cd.foundation.errors import table_in_si
from masonry_cd.foundation.units import unit_at
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report

Models = tuple[type[BaseModel], ...]


def scene_in_si(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scene with the texts of all keys that have a unit as numbers.

    Raises:
        InputError: names the key whose text is no number in its unit.
    """
    made = dict(tables)
    for name, value in tables.items():
        if isinstance(value, Mapping):
            made[name] = table_in_si(_models(name, value), value, name)
        elif isinstance(value, list):
            made[name] = [_item_in_si(name, i, item) for i, item in enumerate(value)]
    return made


def _item_in_si(name: str, place: int, item: Any) -> Any:
    """A table of a list of the scene, as numbers."""
    return table_in_si(_models(name, item), item, f"{name}[{place}]") if isinstance(item, Mapping) else item


def unit_of_key(tables: Mapping[str, Any], key: str) -> str:
    """The unit of a key such as ``loads[0].amplitude`` of the scene with some tables; empty where it has none."""
    name, *parts = [int(index) if index else word for index, word in re.findall(r'\[(\d+)\]|"?([\w*-]+)"?', key)] or [""]
    table: Any = tables.get(str(name))
    if isinstance(table, list) and parts and isinstance(parts[0], int):
        index = parts.pop(0)
        table = table[index] if isinstance(index, int) and index < len(table) else None
    return unit_at(_models(str(name), table), parts) if isinstance(table, Mapping) else ""


def _models(name: str, table: Mapping[str, Any]) -> Models:
    """The models of a table of the scene; none of one that is not known."""
    kind = str(table.get("kind"))
    if name in ("structure", "structures"):
        return _models_of_structure(kind)
    if name == "loads":
        from loads import KINDS

        return (KINDS[kind].table,) if kind in KINDS else ()
    if name == "limit":
        from masonry_cd.app.limit_table import LimitTable

        return (LimitTable,)
    one: dict[str, type[BaseModel]] = {"material": Material, "run": Run, "report": Report, "assess": AssessTable, "output": OutputTable}
    return (one[name],) if name in one else ()


def _models_of_structure(kind: str) -> Models:
    """Those of [structure] and of [[structures]]."""
    from structures import KINDS
    from structures.site import PlaceTable
    from structures.tables import CommonTable, table_of

    own = table_of(kind) if kind in KINDS else None
    return (*([] if own is None else [own]), CommonTable, PlaceTable)
