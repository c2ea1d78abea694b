# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a scene as numbers in SI units, and the unit of a key by its path.

A scene is kept as written, with its texts: "30 mm". What reads a table by its model sees numbers in any case; this is for what reads values
without one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from masonry_cd.analysis.hazard.table import HazardTable
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.output_table import OutputTable
from masonry_cd.foundation.errors import InputError, table_in_si
from masonry_cd.foundation.plugins import find
from masonry_cd.foundation.units import Key, declared_at, usual_keys
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.ground_table import GroundTable
from masonry_cd.mechanics.model.link_table import LinkTable
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report

Models = tuple[type[BaseModel], ...]


def scene_in_si(tables: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """The tables of a scene with the texts of all keys that have a unit as numbers; ``folder``: where kinds in files of Python are.

    Raises:
        InputError: names the key whose text is not a number in its unit.
    """
    made = dict(tables)
    for name, value in tables.items():
        if isinstance(value, Mapping):
            made[name] = table_in_si(_models(name, value, folder), value, name)
        elif isinstance(value, list):
            made[name] = [
                table_in_si(_models(name, item, folder), item, f"{name}[{i}]") if isinstance(item, Mapping) else item
                for i, item in enumerate(value)
            ]
    return made


def usual_keys_of(tables: Mapping[str, Any], folder: Path | None = None) -> Iterator[Key]:
    """The keys of some tables of a scene, as numbers, whose fields say which values are usual."""
    for name, value in tables.items():
        every = {f"{name}[{i}]": item for i, item in enumerate(value)} if isinstance(value, list) else {name: value}
        for place, table in every.items():
            if isinstance(table, Mapping):
                yield from usual_keys(_models(name, table, folder), table, place)


def unit_of_key(tables: Mapping[str, Any], key: str) -> str:
    """The unit of a key such as ``loads[0].amplitude`` of the scene with some tables; empty where it has none."""
    name, *parts = [int(index) if index else word for index, word in re.findall(r'\[(\d+)\]|"?([\w*-]+)"?', key)] or [""]
    table: Any = tables.get(str(name))
    if isinstance(table, list) and parts and isinstance(parts[0], int):
        index = parts.pop(0)
        table = table[index] if isinstance(index, int) and index < len(table) else None
    return declared_at(_models(str(name), table), parts).unit if isinstance(table, Mapping) else ""


def _models(name: str, table: Mapping[str, Any], folder: Path | None = None) -> Models:
    """The models of a table of the scene; none of one that is not known."""
    if name in ("structure", "structures", "loads"):
        try:
            return _models_of_kind(name, str(table.get("kind")), folder)
        except InputError:  # an unknown kind, which whoever builds it says
            return ()
    if name == "limit":
        from masonry_cd.app.limit_table import LimitTable

        return (LimitTable,)
    if name == "strengthen":
        from masonry_cd.app.strengthen_table import StrengthenTable

        return (StrengthenTable,)
    one: dict[str, type[BaseModel]] = {
        "material": Material, "run": Run, "report": Report, "assess": AssessTable, "output": OutputTable, "links": LinkTable,
        "hazard": HazardTable, "ground": GroundTable,
    }  # fmt: skip
    return (one[name],) if name in one else ()


def _models_of_kind(name: str, kind: str, folder: Path | None) -> Models:
    """Those of a structure or a load of a kind, ours or a plug-in's.

    Raises:
        InputError: no such kind.
    """
    if name == "loads":
        from loads import KINDS

        return (find("loads", kind, "kind", KINDS, folder).table,)
    from structures import kind_of
    from structures.site import PlaceTable
    from structures.tables import CommonTable

    own = kind_of(kind, folder).table
    return (*([] if own is None else [own]), CommonTable, PlaceTable)
