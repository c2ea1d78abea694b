# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of ``[material]`` that take one value for all blocks, or values by group, ``young.arch = 2e9``, with ``default`` for the rest; and
those that take values by pair of groups, ``friction.arch-base = 0.9``.

A group may be a pattern, ``young."*-pier"``, ``friction."*arch-*base"``. A name holds before a pattern, and a pattern before ``default``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, TypeVar

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import is_number

Value = TypeVar("Value")
ANY = "*"  # in a pattern: anything


def by_group(check: Callable[[Any], str], schema: dict[str, Any]) -> tuple[Any, Any]:
    """Validator and JSON schema of such a key; ``check`` says what is wrong with a value, or nothing."""

    def validate(value: Any) -> Any:
        values = value if isinstance(value, Mapping) else {"": value}
        if not values:
            raise ValueError("gives no value")
        for group, each in values.items():
            if each is not None and (wrong := check(each)):
                raise ValueError(f'"{group}": {wrong}, got {each!r}' if group else wrong)
        return value

    many = {"type": "object", "minProperties": 1, "additionalProperties": schema}
    return BeforeValidator(validate), WithJsonSchema({"anyOf": [schema, many]})


def numbers(low: float, high: float, unit: str = "") -> tuple[Any, Any]:
    """Those of numbers between two bounds, in a unit."""

    def check(value: Any) -> str:
        if not is_number(value):
            return f"should be a number{f', in {unit.split()[0]}' if unit else ''}"
        return "" if low <= value <= high else f"should be between {low:g} and {high:g}{f' {unit}' if unit else ''}"

    return by_group(check, {"type": "number", "minimum": low, "maximum": high})


def members(word: str, groups: Sequence[str]) -> list[int]:
    """The groups that a name, or a pattern with ``*``, stands for."""
    return [i for i, group in enumerate(groups) if (fnmatchcase(group, word) if ANY in word else group == word)]


def of_group(values: Any, group: str, groups: Sequence[str], key: str, otherwise: Any = None) -> Any:
    """The value for a group, ``otherwise`` where none is given.

    Args:
        values: one, or a mapping.
        group: one of the groups.
        groups: all of them.
        key: of the material, for messages.
        otherwise: where neither the group nor a default is given.

    Raises:
        InputError: the mapping names a group that does not exist.
    """
    if not isinstance(values, Mapping):
        return otherwise if values is None else values
    for name in values:
        if name != "default" and not members(name, groups):
            raise InputError(
                f"material.{key}.{name}", f'"{name}" is not a group of blocks{suggest(name, groups)}; groups: {", ".join(groups)}'
            )
    names = [group, *(name for name in values if members(name, [group])), "default"]
    return next((values[name] for name in names if name in values), otherwise)


def by_pair(pairs: Mapping[str, Value], groups: Sequence[str], key: str) -> list[tuple[int, int, Value]]:
    """Entries (i, j, value) of a symmetric table: the default, patterns, pairs by name, so that each replaces those before it.

    Raises:
        InputError: an unknown group; names the pair as ``key.pair``.
    """
    count = range(len(groups))
    out = [(i, j, pairs["default"]) for i in count for j in count] if "default" in pairs else []
    for pair in sorted((pair for pair in pairs if pair != "default"), key=lambda pair: ANY not in pair):
        first, second = _split_pair(pair, groups, key)
        for i in first:
            for j in second:
                out += [(i, j, pairs[pair]), (j, i, pairs[pair])]
    return out


def pair_table(values: float | Mapping[str, float], groups: Sequence[str], key: str, otherwise: float) -> np.ndarray:
    """The (G, G) symmetric table of one number for all pairs or numbers by pair, ``otherwise`` where none is given.

    Raises:
        InputError: an unknown group.
    """
    table = np.full((len(groups), len(groups)), otherwise)
    for i, j, value in by_pair(values if isinstance(values, Mapping) else {"default": values}, groups, key):
        table[i, j] = value
    return table


def pair_in_words(pair: str) -> str:
    """A pair of groups, or all that the default is for."""
    return "all other joints" if pair == "default" else pair


def _split_pair(pair: str, groups: Sequence[str], key: str) -> tuple[list[int], list[int]]:
    """The groups of ``"a-b"``, where the names themselves may hold a dash, and may be patterns with ``*``."""
    for i, letter in enumerate(pair):
        if letter == "-" and (first := members(pair[:i], groups)) and (second := members(pair[i + 1 :], groups)):
            return first, second
    unknown = next((word for word in pair.split("-") if not members(word, groups)), pair)
    raise InputError(f"{key}.{pair}", f'"{unknown}" is not a group of blocks{suggest(unknown, groups)}; groups: {", ".join(groups)}')
