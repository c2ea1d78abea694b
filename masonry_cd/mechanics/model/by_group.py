# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of ``[material]`` that take one value for all blocks, or values by group, ``young.arch = 2e9``, with ``default`` for the rest.

A group may be a pattern, ``young."*-pier"``. A name holds before a pattern, and a pattern before ``default``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from pydantic import BeforeValidator, WithJsonSchema

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import is_number

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
                f"material.{key}.{name}", f'"{name}" is no group of blocks{suggest(name, groups)}; groups: {", ".join(groups)}'
            )
    names = [group, *(name for name in values if members(name, [group])), "default"]
    return next((values[name] for name in names if name in values), otherwise)
