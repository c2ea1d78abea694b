# SPDX-License-Identifier: GPL-3.0-or-later
"""Checkpoints: all that a run needs to go on to the bit as if it had not been stopped.

``checkpoint.npz`` lies next to result.h5 and is replaced as a whole, so a kill at any moment leaves the last one intact; the one before it
is kept as ``checkpoint_before.npz``. It says how many rows of result.h5 belong to it, with a mark that distinguishes these from others;
what the file holds beyond them is computed again. A checksum detects a damaged one.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import part_of, replacing
from masonry_cd.foundation.errors import InputError, in_a_line
from masonry_cd.foundation.files import size_of_regular

NAME = "checkpoint.npz"
FORMAT = 14  # of what a stepper writes and of the results next to it; raised when what they hold changes
Check = Callable[[dict[str, np.ndarray], dict[str, Any]], None]
NOTHING = "there is no checkpoint to resume from: the run finished, or stopped before its first one"


class Damaged(InputError):
    """A checkpoint whose bytes are not those that were written."""


def before(path: Path) -> Path:
    """Where the checkpoint before the last one is kept."""
    return path.with_name(f"{path.stem}_before{path.suffix}")


def save(path: Path, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
    """Write arrays and JSON-able numbers in one stroke, and keep what was there as the one before."""
    text = json.dumps(dict(numbers) | {"format": FORMAT})
    with replacing(path) as part:
        with open(part, "wb") as file:
            np.savez(file, **arrays, numbers=np.array(text), checksum=np.array(_checksum(arrays, text)))  # type: ignore[arg-type]
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            path.replace(before(path))


def remove(path: Path) -> None:
    """Take a checkpoint and the one before it away, and what a kill has left of the next one."""
    for file in (path, before(path), part_of(path)):
        file.unlink(missing_ok=True)


def load(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read what :func:`save` wrote.

    Raises:
        Damaged: it cannot be read, or its checksum is another.
        InputError: there is none, or another version of the program wrote it.
    """
    if not path.exists():
        raise InputError(path, f"{NOTHING}")
    try:
        if not size_of_regular(path):
            raise EOFError("the file is empty")
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files if name not in ("numbers", "checksum")}
            text = str(stored["numbers"])
            numbers, checksum = json.loads(text), str(stored["checksum"]) if "checksum" in stored.files else None
    except Exception as reason:  # damaged bytes make the readers of zip files, arrays and JSON raise whatever they like
        raise Damaged(path, f"not a readable checkpoint: {in_a_line(reason)}") from None
    if not isinstance(numbers, dict):
        raise Damaged(path, "not a readable checkpoint: it has no table of numbers")
    if (form := numbers.get("format")) != FORMAT:
        which = "a newer" if isinstance(form, int) and form > FORMAT else "an older" if isinstance(form, int) else "another"
        raise InputError(
            path,
            f"has format {form!r} of {which} version of masonry_cd; resume with that version, or start again with --force",
        )
    if checksum != _checksum(arrays, text):
        raise Damaged(path, "not a readable checkpoint: its checksum does not match its content")
    return arrays, numbers


def repair(path: Path, check: Check = lambda arrays, numbers: None) -> str:
    """Put the checkpoint before the last one in its place where the last one is damaged or gone; return a line that says so, or "".

    Args:
        path: of the last one.
        check: raises an InputError where what a checkpoint holds cannot be gone on from.

    Raises:
        InputError: none that can be read and that passes the check. Then nothing is changed.
    """
    require(path)
    older, refused = before(path), list[InputError]()
    for file in (path, older):
        if file.exists():
            try:
                check(*load(file))
            except InputError as reason:
                named = reason.place.startswith(f"{file.parent}{os.sep}")
                refused.append(reason if named else reason.under(f"{file}: not a checkpoint from which this run can continue"))
            else:
                if file == older:
                    older.replace(path)
                return f"{refused[0]}; the run continues from the previous checkpoint" if refused else ""
    raise refused[0]


def require(path: Path) -> None:
    """Raise an InputError where there is no checkpoint."""
    if not path.exists() and not before(path).exists():
        raise InputError(path, f"{NOTHING}")


def _checksum(arrays: Mapping[str, np.ndarray], text: str) -> str:
    """SHA-256 of names, types, shapes and bytes of all arrays, and of the numbers as text."""
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
