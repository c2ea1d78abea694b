# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a scene file: TOML in and out, changes by ``--set``, and the line on which a key stands."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from masonry_cd.foundation import files
from masonry_cd.foundation.errors import InputError

DEEPEST = 20  # tables and lists in one another; scenes and studies have at most six
TOO_DEEP = "lists or tables nested too deep"
SLIPS = (  # common ones in the value of a key, and their remedies
    (r"[+-]?\d+,\d", "a number has a decimal point: 0.25"),
    (r"[+-]?\.\d|[+-]?\d+\.(?:\D|$)", "a number has digits on both sides of its point: 0.5"),
    (r"[+-]?[\d.]+(?:e[+-]?\d+)?\s*[A-Za-z%]", 'a number with its unit stands in quotes: "30 mm"'),
    (r"(?:True|TRUE|yes|on|False|FALSE|no|off)\b", "yes and no are written true and false"),
    (r'"[^"]*\\', "a path is written with /, or in single quotes"),
    (r"(?!true|false)[A-Za-z_]", 'a text stands in quotes: "x"'),
)
WRITE = "write key=value, e.g. run.dt=1e-3 or loads[0].amplitude=0.3"


def read_text(path: Path) -> str:
    """The text of a file, or one line on why there is none."""
    if _has_bytes(str(path.absolute())):  # results keep the name as text
        raise InputError(path, "its name, or a folder of it, holds bytes that are no text in UTF-8; rename it")
    try:
        return files.read_text(path, encoding="utf-8-sig")  # some editors begin a file with a mark of its encoding
    except FileNotFoundError:
        raise InputError(path, "no such scene file") from None
    except IsADirectoryError:
        raise InputError(path, "is a folder, not a scene file") from None
    except UnicodeDecodeError:
        raise InputError(path, "not a text file in UTF-8") from None
    except OSError as failure:
        raise InputError(path, str(failure.strerror)) from None


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Parse TOML; a syntax error names file and line."""
    try:
        return _shallow(_load_toml(text, str(path)), str(path))
    except tomllib.TOMLDecodeError as failure:
        message = re.match(r"(.*?) \(at (?:line (\d+), column \d+|end of document)\)", str(failure))
        what, line = (message.group(1), message.group(2)) if message else (str(failure), None)
        hint = _hint(text.splitlines()[int(line) - 1]) if line and not what.startswith("Cannot") else ""
        raise InputError(f"{path}:{line or text.count(chr(10)) + 1}", f"not valid TOML: {what[0].lower()}{what[1:]}{hint}") from None


def _hint(line: str) -> str:
    """Guess what a line that is not TOML probably was to be; empty where that is not clear."""
    _, _, value = line.partition("=")
    return next((f" ({remedy})" for pattern, remedy in SLIPS if re.match(pattern, value.strip())), "")


def _shallow(tables: dict[str, Any], where: str) -> dict[str, Any]:
    """The tables, refused where they are nested deeper than what walks through them by recursion should meet."""
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        level = [
            item for value in level for item in (value.values() if isinstance(value, dict) else value) if isinstance(item, dict | list)
        ]
    if level:
        raise InputError(where, TOO_DEEP)
    return tables


def _load_toml(text: str, where: str) -> dict[str, Any]:
    """Parse TOML; what Python's parser cannot hold is an InputError that names ``where``, other syntax errors are left to the caller."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # of a number that Python does not convert
        raise InputError(where, f"a number of more than {sys.get_int_max_str_digits()} digits") from None
    except RecursionError:
        raise InputError(where, TOO_DEEP) from None


def override(tables: dict[str, Any], change: str) -> None:
    """Apply one ``key=value`` to the tables, in place."""
    key, value = parse_change(change)
    try:
        assign(tables, key, value)
    except InputError as error:
        raise error.under(f"--set {change}") from None


def assign(tables: dict[str, Any], key: str, value: Any) -> None:
    """Give a key such as ``loads[0].amplitude`` a value, in place; tables on the way to it are made where there are none.

    Raises:
        InputError: no key, or one in a list that has no such place.
    """
    parts: list[str | int] = [
        int(index) if index else (quoted or bare) for index, quoted, bare in re.findall(r'\[(\d+)\]|"([^"]+)"|([^.\[\]"]+)', key)
    ]
    if not parts or isinstance(parts[-1], int):
        raise InputError("", WRITE)
    if len(parts) > DEEPEST:
        raise InputError("", f"a key of {len(parts)} parts: {TOO_DEEP}")
    here: Any = tables
    for part, following in pairwise(parts):
        if isinstance(part, str) and isinstance(here, dict):
            here = here.setdefault(part, [] if isinstance(following, int) else {})
        elif isinstance(part, int) and isinstance(here, list) and part < len(here):
            here = here[part]
        else:
            raise InputError("", f"there is no {key[: key.rfind('.')]} in the scene")
    if not isinstance(here, dict):
        raise InputError(key[: key.rfind(".")], "is not a table; a list is addressed as loads[0].amplitude")
    here[str(parts[-1])] = value


def parse_change(change: str) -> tuple[str, Any]:
    """Split ``key=value`` as --set takes it; the value is TOML, or else text.

    Raises:
        InputError: no key, or no equals sign.
    """
    key, equals, value = (part.strip() for part in change.partition("="))
    if _has_bytes(change):  # which no file could keep
        raise InputError(f"--set {change}", "holds bytes that are no text in UTF-8")
    if not key or not equals:
        raise InputError(f"--set {change}", WRITE)
    return key, _toml_value(key, value)


def _has_bytes(text: str) -> bool:
    """Return True if a text has lone surrogates, which stand for bytes of the command line or of a name that are no UTF-8."""
    return any("\ud800" <= letter <= "\udfff" for letter in text)


def _toml_value(key: str, value: str) -> Any:
    """The TOML value given for a key, or the bare text where it is none."""
    try:
        parsed = _shallow(_load_toml(f"value = {value}", f"--set {key}"), f"--set {key}")
    except tomllib.TOMLDecodeError:
        return value
    return parsed["value"] if len(parsed) == 1 else value


def dump_toml(tables: Mapping[str, Any]) -> str:
    """Write tables as TOML: plain values first, then ``[table]`` and ``[[table]]`` sections; deeper tables inline."""
    lines = [f"{toml_key(key)} = {toml_text(value)}" for key, value in tables.items() if not _is_section(value)]
    for key, value in tables.items():
        if _is_section(value):
            for section in [value] if isinstance(value, Mapping) else value:
                head = toml_key(key)
                lines += ["", f"[{head}]" if isinstance(value, Mapping) else f"[[{head}]]"]
                lines += [f"{toml_key(name)} = {toml_text(item)}" for name, item in section.items()]
    return "\n".join(lines) + "\n"


def _is_section(value: object) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and all(isinstance(item, Mapping) for item in value))


def toml_key(key: str) -> str:
    """A key in TOML's notation."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def toml_text(value: object) -> str:
    """One value in TOML's notation."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml_key(key)} = {toml_text(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    if isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False)
    return str(value)  # numbers, inf and nan; dates print as TOML writes them


def place_of(text: str, key: str, path: Path) -> str:
    """``file:line`` of a key such as ``loads[0].amplitude``; of the innermost table that is there where it is missing; else the file."""
    wanted, best, at = _key_path(key), 0, None
    here: list[tuple[str, int]] = []
    seen: dict[str, int] = {}  # tables so far of each [[list]]
    for number, line in enumerate(text.splitlines(), start=1):
        head = re.match(r"\s*(\[{1,2})\s*([^\]]+?)\s*\]", line)
        word = re.match(r'\s*((?:"[^"]+"|[\w-]+)(?:\s*\.\s*(?:"[^"]+"|[\w-]+))*)\s*=', line)
        if head:
            here = _key_path(head.group(2))
            name = ".".join(part for part, _ in here)
            seen[name] = seen.get(name, -1) + (head.group(1) == "[[")
            here = [(part, max(0, seen.get(".".join(p for p, _ in here[: i + 1]), 0))) for i, (part, _) in enumerate(here)]
        elif not word:
            continue
        found = here + (_key_path(word.group(1)) if word and not head else [])
        last = len(found) - 1
        if len(here) <= last < len(wanted):
            found[last] = (found[last][0], wanted[last][1])  # of a list, whichever item is wanted stands here
        shared = next((i for i, (a, b) in enumerate(zip(found, wanted, strict=False)) if a != b), min(len(found), len(wanted)))
        if shared > best:
            best, at = shared, number
    return f"{path}:{at}" if at else str(path)


def keys_of(value: object, key: str = "") -> Iterator[tuple[str, Any]]:
    """All values of a table that are no tables or lists themselves, with their keys, ``loads[0].ag``."""
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from keys_of(item, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from keys_of(item, f"{key}[{i}]")
    else:
        yield key, value


def is_within(key: str, table: str) -> bool:
    """Return True if a key such as ``run.dt`` is, or lies in, another such as ``run``; all places of a list lie in the list."""
    wanted, above = _key_path(key), _key_path(table)
    last = len(above) - 1
    if above and last < len(wanted) and not table.rstrip().endswith("]"):
        above[last] = (above[last][0], wanted[last][1])
    return bool(above) and wanted[: len(above)] == above


def _key_path(key: str) -> list[tuple[str, int]]:
    """``loads[1].amplitude`` as [("loads", 1), ("amplitude", 0)]."""
    parts = re.findall(r'"?([\w-]+)"?(?:\[(\d+)\])?', key)
    return [(name, int(index or 0)) for name, index in parts]
