# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's values as those of a scene file, and the changes that they mean."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.app.scene_text import toml_text
from masonry_cd.foundation.errors import InputError

BARE = re.compile(r"[A-Za-z0-9_-]+")


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
    raise InputError(key or "scene", f"a {type(value).__name__} is no value of a scene")


def changes(tables: Mapping[str, Any], now: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """What tables change in others, as ``key=value``, the form of ``--set``.

    Keys of a table that is there already are changed one by one; a table that says its ``kind`` takes the place of the other, since its
    keys are those of its kind.

    Args:
        tables: plain values.
        now: the tables that they change.
        above: what stands before their keys.
    """
    for name, value in tables.items():
        key, there = above + (name if BARE.fullmatch(name) else f'"{name}"'), now.get(name)
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
