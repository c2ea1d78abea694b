# SPDX-License-Identifier: GPL-3.0-or-later
"""The loads of a scene as a limit analysis takes them: each table with all of it there, by the ``static`` of its kind.

A push or a tilt is ``lambda |g| d`` on every kilogram along a direction d, tilted by phi with lambda = tan(phi); what is live is multiplied
by lambda; of supports that move the force is sought that they still bear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from loads import LoadEntry, asked
from loads.bars import Tie
from loads.kinds.tie import TieTable, bar
from loads.motion import Pattern, RunGrid, Static
from masonry_cd.foundation.errors import of_each, parse_table

NO_STEP = 1e-12  # of a grid that has none [s]: no tie is too stiff for it


class StaticTable(NamedTuple):
    """One table of [[loads]] in limit analysis."""

    label: str  # ``loads[0] (push)``
    pattern: Pattern
    does: Static
    left_out: bool


def static_tables(tables: Sequence[Mapping[str, Any]], grid: RunGrid) -> list[StaticTable]:
    """All [[loads]] tables.

    Raises:
        InputError: the faults of all tables together.
    """

    def one(load: LoadEntry) -> StaticTable:
        kind, table, where = load
        found = None if kind.static is None else kind.static(table, grid, where)
        return StaticTable(f"{where} ({table.kind})", "" if found is None else kind.pattern(table), found or Static(), found is None)

    return of_each(one, asked(tables, grid.folder))


def patterns(tables: Sequence[Mapping[str, Any]], folder: Path) -> list[Pattern]:
    """The pattern that each [[loads]] table gives a limit analysis; empty where it gives none.

    Raises:
        InputError: a bad table.
    """
    return [one.kind.pattern(one.table) for one in asked(tables, folder)]


def ties_of(made: Sequence[tuple[str, Mapping[str, Any]]], grid: RunGrid) -> list[Tie]:
    """The ties of a structure, from tables of kind "tie" with what the structure calls them."""
    return [bar(parse_table(TieTable, table, where), grid, where) for where, table in made]
