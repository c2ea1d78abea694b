# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's values as those of a scene file, the changes that they mean, and arrays of numbers: one check for geometry, motions, forces."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.app.scene_text import toml_key, toml_text
from masonry_cd.foundation.errors import InputError


def plain(value: Any, key: str) -> Any:
    """A value as TOML holds it: numbers and arrays of numpy as Python's, paths as text; keys of a table that are None are left out.

    Args:
        value: of a key.
        key: for messages; empty for the whole scene.

    Raises:
        InputError: a value that no scene holds.
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(name): plain(item, f"{key}.{name}" if key else str(name)) for name, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [plain(item, f"{key}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, str | bool | int | float):
        return value
    raise InputError(key or "scene", f"a {type(value).__name__} is not a value of a scene")


def changes(tables: Mapping[str, Any], now: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """Yield the changes of tables against others, as ``key=value``, the form of ``--set``.

    Keys of a table that is there already are changed one by one; a table that says its ``kind`` takes the place of the other, since its
    keys are those of its kind.

    Args:
        tables: plain values.
        now: the tables that they change.
        above: what stands before their keys.
    """
    for name, value in tables.items():
        key, there = above + toml_key(name), now.get(name)
        if isinstance(value, Mapping) and isinstance(there, Mapping) and "kind" not in value:
            yield from changes(value, there, f"{key}.")
        else:
            yield f"{key}={toml_text(value)}"


def with_absolute_paths(value: Any, folder: Path, own: frozenset[str] = frozenset()) -> Any:
    """Tables in which the values of keys ``path`` no longer depend on a folder, but for the names of files that go with the scene."""
    if isinstance(value, Mapping):
        return {
            key: str((folder / item).absolute())
            if key == "path" and isinstance(item, str) and item not in own
            else with_absolute_paths(item, folder, own)
            for key, item in value.items()
        }
    return [with_absolute_paths(item, folder, own) for item in value] if isinstance(value, list | tuple) else value


def numbers(given: Any, where: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Finite numbers in an array of its own.

    Args:
        given: whatever numpy makes an array of numbers of.
        where: for messages.
        shape: that it must have, -1 standing for any length; any when not given.

    Raises:
        InputError: anything else.
    """
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise InputError(where, "an array of numbers is needed") from None
    if shape is not None and (array.ndim != len(shape) or any(n >= 0 and n != m for n, m in zip(shape, array.shape, strict=True))):
        wanted = f"({', '.join('N' if n < 0 else str(n) for n in shape)}{',' if len(shape) == 1 else ''})"
        raise InputError(where, f"an array of shape {wanted} is needed, got {array.shape}")
    if not np.isfinite(array).all():
        at = f" at {np.argwhere(~np.isfinite(array))[0].tolist()}" if array.ndim else ""
        raise InputError(where, f"not finite{at}")
    return array
