# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors a user can cause, and how they are reported: one line that names the key, file, line or block."""

from __future__ import annotations

import copy
import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self, TypeVar

from pydantic import BaseModel, ValidationError

from masonry_cd.foundation.units import UnitError, declared_at, in_si, models_in, read_values

Model = TypeVar("Model", bound=BaseModel)
Given = TypeVar("Given")
Made = TypeVar("Made")
Path = tuple[str | int, ...]  # keys and places that lead to a key of a table

QUOTED = 300  # most characters of a value that a message quotes
WORD = 400  # most characters of any other word
MOST_LINES = 30  # of what is wrong with one thing
UNKNOWN = "unknown key"
LINE = 900  # most characters of a message; its beginning says where, its end what would do


class Fault(NamedTuple):
    """One thing that is wrong with what the user gave."""

    place: str  # path of the key as the user writes it, file with its line, block or option; empty where the text says it all
    text: str  # what is wrong, what is allowed, what to write instead
    source: str = ""  # file and line in which the place is given

    def __str__(self) -> str:
        return one_line(": ".join(part for part in (self.source, self.place, self.text) if part))

    def under(self, place: object) -> Fault:
        """The fault of a part, reported of the whole at ``place``; as it is where that is empty."""
        return Fault(str(place), f"{self.place}: {self.text}" if self.place else self.text, self.source) if place else self


class InputError(ValueError):
    """Something the user gave is wrong. The command line prints a line for each of its ``faults`` and exits with 2."""

    faults: tuple[Fault, ...]

    def __init__(self, place: object, text: str) -> None:
        super().__init__(place, text)
        self.faults = (Fault(str(place), text),)

    @classmethod
    def of(cls, faults: Iterable[Fault]) -> InputError:
        """All of some faults, of which there is one at the least."""
        every = tuple(faults)
        error = InputError(every[0].place, every[0].text)
        error.faults = every
        return error

    @property
    def place(self) -> str:
        """The place of the first fault."""
        return self.faults[0].place

    @property
    def lines(self) -> tuple[str, ...]:
        """A line for each fault, up to ``MOST_LINES`` of them, each once."""
        lines = [*dict.fromkeys(str(fault) for fault in self.faults)]
        more = len(lines) - MOST_LINES
        return (*lines[:MOST_LINES], f"and {more} more faults") if more > 0 else tuple(lines)

    def each(self, change: Callable[[Fault], Fault]) -> Self:
        """An error of the same class whose faults are changed."""
        error = copy.copy(self)
        error.faults = tuple(change(fault) for fault in self.faults)
        return error

    def under(self, place: object) -> Self:
        """The error of a part, reported of the whole at ``place``."""
        return self.each(lambda fault: fault.under(place))

    def unsourced(self) -> Self:
        """The error without file and line, as part of another one."""
        return self.each(lambda fault: fault._replace(source=""))

    def __str__(self) -> str:
        return "\n".join(self.lines)


class WrongKeys(InputError):
    """Keys of a table that are wrong: ``paths`` say where in the table each of the faults lies."""

    def __init__(self, paths: Sequence[Path], faults: Sequence[Fault]) -> None:
        ValueError.__init__(self, paths, faults)
        self.paths, self.faults = tuple(paths), tuple(faults)


@dataclass
class Faults:
    """A collector of all that is wrong with one kind of input, which is refused at once."""

    found: list[Fault] = field(default_factory=list)

    def add(self, place: object, text: str) -> None:
        """Note a fault."""
        self.found.append(Fault(str(place), text))

    @contextmanager
    def of(self, place: object = "", name: object = "") -> Iterator[None]:
        """Collect what is wrong in the body, with ``place`` and then ``name`` before the place of each fault, where they are not empty."""
        try:
            yield
        except InputError as error:
            self.found += error.under(name).under(place).faults

    def refuse(self) -> None:
        """Raise all faults as one error, where there are any.

        Raises:
            InputError: all of them.
        """
        if self.found:
            raise InputError.of(self.found)


def of_each(make: Callable[[Given], Made], items: Iterable[Given]) -> list[Made]:
    """The values that ``make`` returns for some items.

    Raises:
        InputError: the faults of all items together.
    """
    faults, made = Faults(), list[Made]()
    for item in items:
        with faults.of():
            made.append(make(item))
    faults.refuse()
    return made


def one_line(message: str) -> str:
    """A message that a terminal can show: control characters and lone surrogates by their codes, quoted values and endless words cut."""
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in message)
    shown = re.sub(r'"([^"]*)"', lambda quoted: f'"{_cut(quoted.group(1), QUOTED)}"', shown)
    shown = re.sub(r"\S+", lambda word: _cut(word.group(), WORD), shown)
    return shown if len(shown) <= LINE else f"{shown[: LINE // 2]} ... {shown[-LINE // 3 :]}"


def _cut(text: str, most: int) -> str:
    """A text cut to a number of characters."""
    return text if len(text) <= most else text[:most] + " ..."


def in_plain_words(failure: OSError) -> str:
    """Describe a refusal of the system, as ``out/blocks.json: permission denied``: without its number, and with the file in front."""
    if isinstance(failure, BrokenPipeError):
        return "the program that reads the output has gone (broken pipe)"
    if not failure.strerror:
        return str(failure)
    why = failure.strerror[0].lower() + failure.strerror[1:]
    return f"{failure.filename}: {why}" if failure.filename else why


def in_a_line(reason: Exception) -> str:
    """The message of an exception as one line; the name of its class where it has none."""
    return " ".join(str(reason).split()) or type(reason).__name__


def suggest(word: str, known: Iterable[str]) -> str:
    """Return ' (did you mean "x"?)' when a known word is close to the given one, else an empty string."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f' (did you mean "{close[0]}"?)' if close else ""


def parse_table(model: type[Model], table: Mapping[str, Any], where: str) -> Model:
    """Validate one table of a scene file.

    Args:
        model: the pydantic model of the table, with ``extra="forbid"``.
        table: the table as read from TOML; a key with a unit takes a text with another, "30 mm" (:mod:`.units`).
        where: the table's name in the file, as the user writes it, e.g. ``structure`` or ``loads[0]``.

    Raises:
        WrongKeys: one line that names the first offending key as ``where.key``.
    """
    table = table_in_si((model,), table, where)
    try:
        return model.model_validate(table)
    except ValidationError as failure:
        found = _faults(failure, model, table, where)
        raise WrongKeys(list(found), list(found.values())) from None


def table_in_si(models: Sequence[type[BaseModel]], table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """A table of a scene file with the texts of all keys that have a unit as numbers in it, see :func:`masonry_cd.foundation.units.in_si`.

    Raises:
        WrongKeys: names the key whose text has an unknown unit, one of another dimension, or none.
    """
    try:
        return in_si(models, table)
    except UnitError as fault:
        raise WrongKeys([tuple(fault.parts)], [Fault(_path(where, fault.parts), str(fault))]) from None


def values_in_si(value: Any, unit: Callable[[], str], where: str) -> Any:
    """A value, or values in lists, with its texts as numbers in a unit that is determined only where there is one.

    Raises:
        InputError: names the value as ``where``.
    """
    try:
        return read_values(value, unit)
    except UnitError as fault:
        raise InputError(_path(where, fault.parts), str(fault)) from None


def _faults(failure: ValidationError, model: type[BaseModel], table: Mapping[str, Any], where: str) -> dict[Path, Fault]:
    """Pydantic's report as a fault for each key, by its path in the table; misspelt keys come first, since they explain missing ones.

    Of a value that may have several forms the first counts, and of a value with wrong ones in it these.
    """
    found, forms = dict[Path, Fault](), dict[Path, str | int]()
    misspelt = {error["loc"][:-1] for error in failure.errors() if error["type"] == "extra_forbidden"}
    for error in sorted(failure.errors(), key=lambda e: e["type"] != "extra_forbidden"):
        if error["type"] == "missing" and error["loc"][:-1] in misspelt:
            continue
        place, own = _in_table(table, error["loc"], error["type"] == "missing")
        if all(forms.setdefault(at, form) == form for at, form in own.items()):
            shown = [part for part in error["loc"] if part not in own.values() or not _is_form(str(part))]
            text = _text(error, model)
            if any(text == fault.text for fault in found.values()) and text.startswith(f"{UNKNOWN}; "):
                text = UNKNOWN  # the keys that are known are listed once
            found.setdefault(place, Fault(_path(where, shown), text))
    innermost = [place for place in found if not any(place == other[: len(place)] for other in found if other != place)]
    first = {_of_array(place): place for place in reversed(innermost)}  # one fault for an array of numbers
    return {place: found[place] for place in innermost if first[_of_array(place)] == place}


def _is_form(part: str) -> bool:
    """True for a part of a path that is not a key but pydantic's name of a form of values, ``dict[str,float]`` or ``constrained-float``."""
    return "[" in part or part.startswith("constrained-")


def _of_array(place: Path) -> Path:
    """The path without the places in the array of values in which it ends."""
    while place and isinstance(place[-1], int):
        place = place[:-1]
    return place


def _in_table(table: Any, parts: Path, missing: bool) -> tuple[Path, dict[Path, str | int]]:
    """The place in a table to which pydantic's keys and places lead, and its names of the forms of values on the way there, by place."""
    place: Path = ()
    forms = dict[Path, str | int]()
    for k, part in enumerate(parts):
        try:
            table = table[part]
        except (KeyError, IndexError, TypeError):
            if not missing or k < len(parts) - 1:
                forms[place] = part
                continue
        place = (*place, part)
    return place, forms


def _text(error: Mapping[str, Any], model: type[BaseModel]) -> str:
    """Pydantic's words on a key, with the keys that are known or the value that is given."""
    if error["type"] == "extra_forbidden":
        known = _keys(model, error["loc"][:-1])
        hint = suggest(str(error["loc"][-1]), known)
        return f"{UNKNOWN}{hint or '; known keys: ' + ', '.join(known)}"
    if error["type"] == "missing":
        return "missing"
    message = error["msg"].removeprefix("Value error, ")
    given = error.get("input")
    unit = declared_at((model,), error["loc"]).unit if error["type"].startswith(("greater", "less")) else ""  # of the bound, too
    shown = f", got {_cut(repr(given), QUOTED)} {unit}".rstrip() if isinstance(given, (str, int, float, bool)) else ""
    return f"{message[0].lower()}{message[1:]}{shown}"


def _path(where: str, parts: Sequence[str | int]) -> str:
    """A key as the user would address it: ``structure.openings[1].width``."""
    for part in parts:
        where += f"[{part}]" if isinstance(part, int) else f".{part}" if where else part
    return where


def _keys(model: type[BaseModel], parts: Sequence[str | int]) -> list[str]:
    """The keys of the table that is found by following keys and places from a model."""
    for part in parts:
        if isinstance(part, str) and part in model.model_fields:
            model = next(models_in(model.model_fields[part].annotation), model)
    further: tuple[str, ...] = getattr(model, "further_keys", tuple)()
    return [*(field.alias or name for name, field in model.model_fields.items()), *further]
