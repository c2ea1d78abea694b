# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors a user can cause, and how they are reported: one line that names the key, file, line or block."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from masonry_cd.foundation.units import UnitError, in_si, models_in, read_values, unit_at

Model = TypeVar("Model", bound=BaseModel)
Path = tuple[str | int, ...]  # keys and places that lead to a key of a table

QUOTED = 300  # most characters of a value that a message quotes
WORD = 400  # most characters of any other word
MOST_LINES = 30  # of what is wrong with one thing
LINE = 900  # most characters of a message; its beginning says where, its end what would do


class InputError(ValueError):
    """Something the user gave is wrong. The message is one line; the command line prints it and exits with 2."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class InputErrors(InputError):
    """All that is wrong with something, a line each; ``lines`` are those that are shown."""

    def __init__(self, messages: Sequence[str]) -> None:
        lines = [one_line(message) for message in dict.fromkeys(messages)]
        more = len(lines) - MOST_LINES
        self.lines = (*lines[:MOST_LINES], f"and {more} more faults") if more > 0 else tuple(lines)
        ValueError.__init__(self, "\n".join(self.lines))


class WrongKeys(InputError):
    """Keys of a table that are wrong: the message is the first of ``lines``, ``places`` say where in the table each of them lies."""

    def __init__(self, faults: Sequence[tuple[Path, str]]) -> None:
        super().__init__(faults[0][1])
        self.places, self.lines = tuple(place for place, _ in faults), tuple(one_line(line) for _, line in faults)


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
    """What the system refused, as ``out/blocks.json: permission denied``: without its number, and with the file in front."""
    if isinstance(failure, BrokenPipeError):
        return "the program that reads the output has gone (broken pipe)"
    if not failure.strerror:
        return str(failure)
    why = failure.strerror[0].lower() + failure.strerror[1:]
    return f"{failure.filename}: {why}" if failure.filename else why


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
        raise WrongKeys(_lines(failure, model, table, where)) from None


def table_in_si(models: Sequence[type[BaseModel]], table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """A table of a scene file with the texts of all keys that have a unit as numbers in it, see :func:`masonry_cd.foundation.units.in_si`.

    Raises:
        WrongKeys: names the key whose text has an unknown unit, one of another dimension, or none.
    """
    try:
        return in_si(models, table)
    except UnitError as fault:
        raise WrongKeys([(tuple(fault.parts), f"{_path(where, fault.parts)}: {fault}")]) from None


def values_in_si(value: Any, unit: Callable[[], str], where: str) -> Any:
    """A value, or values in lists, with its texts as numbers in a unit that is asked for only where there is one.

    Raises:
        InputError: names the value as ``where``.
    """
    try:
        return read_values(value, unit)
    except UnitError as fault:
        raise InputError(f"{_path(where, fault.parts)}: {fault}") from None


def _lines(failure: ValidationError, model: type[BaseModel], table: Mapping[str, Any], where: str) -> list[tuple[Path, str]]:
    """Pydantic's report as a line for each key, with its place; misspelt keys come first, since they explain missing ones.

    Of a value that may have several forms the first counts, and of a value with wrong ones in it these.
    """
    found, forms = dict[Path, str](), dict[Path, str | int]()
    misspelt = {error["loc"][:-1] for error in failure.errors() if error["type"] == "extra_forbidden"}
    for error in sorted(failure.errors(), key=lambda e: e["type"] != "extra_forbidden"):
        if error["type"] == "missing" and error["loc"][:-1] in misspelt:
            continue
        place, own = _in_table(table, error["loc"], error["type"] == "missing")
        if all(forms.setdefault(at, form) == form for at, form in own.items()):
            shown = [part for part in error["loc"] if part not in own.values() or "[" not in str(part)]
            found.setdefault(place, _line(error, model, _path(where, shown)))
    return [(place, line) for place, line in found.items() if not any(place == other[: len(place)] for other in found if other != place)]


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


def _line(error: Mapping[str, Any], model: type[BaseModel], key: str) -> str:
    """What pydantic says of a key, in a line."""
    if error["type"] == "extra_forbidden":
        known = _keys(model, error["loc"][:-1])
        hint = suggest(str(error["loc"][-1]), known)
        return f"{key}: unknown key{hint or '; known keys: ' + ', '.join(known)}"
    if error["type"] == "missing":
        return f"{key}: missing"
    message = error["msg"].removeprefix("Value error, ")
    given = error.get("input")
    unit = unit_at((model,), error["loc"]) if error["type"].startswith(("greater", "less")) else ""  # of the bound, too
    shown = f", got {_cut(repr(given), QUOTED)} {unit}".rstrip() if isinstance(given, (str, int, float, bool)) else ""
    return f"{key}: {message[0].lower()}{message[1:]}{shown}"


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
    return [field.alias or name for name, field in model.model_fields.items()]
