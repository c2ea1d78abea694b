"""Checkpoints: all that a run needs to go on to the bit as if it had not been stopped.

``checkpoint.npz`` lies beside result.h5 and is replaced as a whole (written aside, then renamed), so a kill at any moment leaves the
last one intact. It says how many rows of result.h5 belong to it; what the file holds beyond them is computed again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.errors import InputError

NAME = "checkpoint.npz"
PART = ".part"  # ends the name of one that is being written
FORMAT = 3  # of what a stepper writes; raised when what it holds changes


def save(path: Path, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
    """Write arrays and JSON-able numbers in one stroke."""
    aside = path.with_suffix(PART)
    with open(aside, "wb") as file:
        np.savez(file, **arrays, numbers=np.array(json.dumps(dict(numbers) | {"format": FORMAT})))  # type: ignore[arg-type]
        file.flush()
        os.fsync(file.fileno())
    os.replace(aside, path)


def remove(path: Path) -> None:
    """Take a checkpoint away, and what a kill has left of the next one."""
    path.unlink(missing_ok=True)
    path.with_suffix(PART).unlink(missing_ok=True)


def load(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read what :func:`save` wrote.

    Raises:
        InputError: there is none, it cannot be read, or another version of the program wrote it.
    """
    require(path)
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files if name != "numbers"}
            numbers = json.loads(str(stored["numbers"]))
    except (OSError, ValueError, KeyError) as reason:
        raise InputError(f"{path}: not a readable checkpoint: {reason}") from None
    if numbers.get("format") != FORMAT:
        raise InputError(f"{path}: written by another version of masonry_cd, which alone can go on from it; --force starts anew")
    return arrays, numbers


def require(path: Path) -> None:
    """Raise an InputError where there is no checkpoint."""
    if not path.exists():
        raise InputError(f"{path}: nothing to resume from: the run ended, or was stopped before its first checkpoint")


def prefixed(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same arrays under ``prefix/name``."""
    return {f"{prefix}/{name}": array for name, array in arrays.items()}


def part(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays under ``prefix/``, without it."""
    head = prefix + "/"
    return {name.removeprefix(head): array for name, array in arrays.items() if name.startswith(head)}
