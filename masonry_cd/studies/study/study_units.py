# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts with a unit where the unit is not the key's own: values that a key of the scene takes, levels of a measure, bounds of a quantity.

[vary]           "loads[0].displacement" = {from = "10 mm", to = "40 mm", count = 4}
[intensity]      levels = ["0.1 g", "0.2 g"]
[limit_states]   cracked = {quantity = "max_opening", above = "5 mm"}
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from masonry_cd.analysis.calibration.observations import unit_of
from masonry_cd.analysis.fragility import measures
from masonry_cd.analysis.outputs import STUDY, units_in
from masonry_cd.foundation.errors import values_in_si

UNITS = units_in(STUDY)
"""Units of the columns of runs.csv that have one."""
PURE = ("distribution", "beta", "count")  # keys of what varies that are no values of its key
ROTATE = "records.rotate"  # varies as keys of the scene do


def study_in_si(tables: Mapping[str, Any], unit_of_key: Callable[[str], str]) -> dict[str, Any]:
    """The tables of a study with such texts as numbers in SI units.

    Args:
        tables: as read.
        unit_of_key: the unit of a key of its scene, which is asked only where a text is met.

    Raises:
        InputError: names the key whose text is not a number in its unit.
    """
    made = dict(tables)
    unit = _unit_of_levels(tables, unit_of_key)
    for name, keys in (("intensity", ("levels",)), ("ida", ("start", "step"))):
        if isinstance(tables.get(name), Mapping):
            made[name] = {k: values_in_si(v, unit, f"{name}.{k}") if k in keys else v for k, v in tables[name].items()}
    if isinstance(tables.get("observations"), list):
        made["observations"] = [_observation(table, f"observations[{i}]") for i, table in enumerate(tables["observations"])]
    if isinstance(tables.get("limit_states"), Mapping):
        made["limit_states"] = {name: _limit_state(table, f"limit_states.{name}") for name, table in tables["limit_states"].items()}
    return made


def varied_in_si(varied: Iterable[tuple[str, Any]], unit_of_key: Callable[[str], str]) -> Iterator[tuple[str, Any]]:
    """The keys of ``[vary]`` with what they are given, texts as numbers in SI units.

    Raises:
        InputError: names the key.
    """
    for key, given in varied:
        where = f'vary."{key}"'

        def unit(key: str = key) -> str:
            return "degrees" if key == ROTATE else unit_of_key(key)

        if isinstance(given, Mapping):
            yield key, {k: v if k in PURE else values_in_si(v, unit, f"{where}.{k}") for k, v in given.items()}
        else:
            yield key, values_in_si(given, unit, where)


def _observation(table: Any, where: str) -> Any:
    """An observation with its value and its bounds as numbers."""
    if not isinstance(table, Mapping):
        return table

    def of(key: str) -> Callable[[], str]:
        return lambda: "m" if key == "above" else unit_of(table)

    return {k: values_in_si(v, of(k), f"{where}.{k}") if k in ("value", "error", "above") else v for k, v in table.items()}


def _limit_state(table: Any, where: str) -> Any:
    """A limit state with its bounds as numbers."""
    if not isinstance(table, Mapping):
        return table

    def unit() -> str:
        return UNITS.get(str(table.get("quantity")), "")

    return {k: values_in_si(v, unit, f"{where}.{k}") if k in ("above", "least_demand") else v for k, v in table.items()}


def _unit_of_levels(tables: Mapping[str, Any], unit_of_key: Callable[[str], str]) -> Callable[[], str]:
    """The unit of a level: that of the key that it is put in, or of the measure."""
    intensity = tables.get("intensity")
    given = intensity if isinstance(intensity, Mapping) else {}
    key, measure = given.get("key"), given.get("measure", "PGA")
    return lambda: unit_of_key(key) if isinstance(key, str) else measures.unit(str(measure)).replace("²", "2")
