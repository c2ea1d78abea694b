# SPDX-License-Identifier: GPL-3.0-or-later
"""All that is wrong with a structure, collected before any of it is refused.

What is faulty is left out, and the rest is checked without it. A check that fails only because something is left out says nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any, TypeVar

from pydantic import BaseModel

from masonry_cd.foundation import errors
from masonry_cd.foundation.errors import Fault, InputError, Path, WrongKeys, parse_table

Model = TypeVar("Model", bound=BaseModel)

LISTS = {"walls": "", "junctions": "", "vaults": "vault", "roofs": "roof", "columns": "column", "arcades": "arcade"} | {
    "buttresses": "buttress",
    "openings": "o",
}  # of tables, and what those without a name are called, followed by a number
BEARING = ("walls", "columns", "arcades", "buttresses")
NOBODY = ""
NO_JUNCTION = {"walls": (NOBODY, NOBODY)}  # in the place of one, that others keep their numbers
ANYTHING = "*"  # among what is left out: there may be things of any name in it


class Absent(InputError):
    """Something that is needed and not there; ``names`` say what it is, none that it may be anything that bears."""

    def __init__(self, text: str, *names: str) -> None:
        super().__init__("", text)
        self.names = names


@dataclass
class Faults(errors.Faults):
    """All that is wrong with a structure, and what is left out of it for that."""

    left_out: dict[str, bool] = field(default_factory=dict)  # by name, because of its own faults: whether it would bear others

    @contextmanager
    def of(self, place: object = "", *names: str, bears: bool = False) -> Iterator[None]:
        """Collect what is wrong in the body, reported at ``place`` unless that is empty, and leave out what goes by some names then."""
        try:
            yield
        except ValueError as error:
            if not isinstance(error, Absent) or not self.lacks(*error.names):
                faults = error.faults if isinstance(error, InputError) else (Fault("", str(error)),)
                self.found += [fault.under(place) for fault in faults]
            self.left_out |= dict.fromkeys(names, bears)

    def lacks(self, *names: str) -> bool:
        """Whether anything is left out that goes by one of some names or patterns, or has such a part; without names, that bears."""
        if not names:
            return any(self.left_out.values())
        return any(one == ANYTHING or fnmatchcase(one, name) or name.startswith(f"{one}.") for one in self.left_out for name in names)

    def parsed(self, model: type[Model], table: Mapping[str, Any], where: str) -> tuple[dict[str, Any], Model]:
        """A table without its wrong keys, and read; where these lie in lists of tables, without the innermost tables that have them."""
        while True:
            try:
                return {**table}, parse_table(model, table, where)
            except WrongKeys as wrong:
                if not all(wrong.paths):
                    raise
                self.found += wrong.faults
                table = self._without(table, {_entry(path) for path in wrong.paths})

    def _without(self, table: Mapping[str, Any], places: set[Path], at: Path = ()) -> dict[str, Any]:
        """A table without some keys, and without the tables in its lists of which some are named; others keep the names that they had."""
        made = {key: value for key, value in table.items() if (*at, key) not in places}
        if not at and any(key == "plan" or isinstance(table[key], (list, tuple)) for key in table.keys() - made.keys()):
            self.left_out[ANYTHING] = True
        for key in made.keys() & {str(place[len(at)]) for place in places if place[: len(at)] == at and len(place) > len(at) + 1}:
            own = [dict(row) if isinstance(row, Mapping) else {} for row in table[key]]
            rows = [{"name": f"{LISTS[key]}{k + 1}"} | row if LISTS[key] else row for k, row in enumerate(own)]
            wrong = [k for k in range(len(rows)) if (*at, key, k) in places]
            made[key] = [self._without(row, places, (*at, key, k)) for k, row in enumerate(rows) if k not in wrong]
            if key == "junctions":
                made[key], self.left_out[NOBODY] = [NO_JUNCTION if k in wrong else row for k, row in enumerate(rows)], False
            elif not at:
                self.left_out |= {str(rows[k].get(word, f"{key}[{k}]")): key in BEARING for k in wrong for word in ("name", "group")}
        return made


class Incomplete(InputError):
    """A structure with faults, and what can be built of it without what is left out."""

    def __init__(self, collected: Faults, rest: Callable[[], Any]) -> None:
        ValueError.__init__(self, collected, rest)
        self.faults, self.collected, self.rest = tuple(collected.found), collected, rest


def _entry(place: Path) -> Path:
    """The place of the innermost table of a list that a key lies in; else that of the key."""
    if place[0] not in LISTS or len(place) < 2:
        return place[:1]
    return place[:4] if len(place) > 3 and place[2] == "openings" else place[:2]
