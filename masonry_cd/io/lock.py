# SPDX-License-Identifier: GPL-3.0-or-later
"""A lock on the folder of a run, so that no two runs write there at once."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.system import one_process_in, started

NAME = "run.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder, which is made if need be; the lock of a process that is dead is taken over.

    Raises:
        InputError: a run that is alive, or may be since it is on another machine, holds the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file, own = folder / NAME, _owner(os.getpid())
    with one_process_in(folder):  # which looks at the lock and takes it
        holder = _read(file)
        if holder and _lives(holder):
            where = f"process {holder['pid']} on {holder['host']}"
            raise InputError(folder, f"another run writes there ({where}); where that is wrong, remove {file}")
        with replacing(file) as part:
            part.write_text(json.dumps(own) + "\n", encoding="utf-8")
    try:
        yield
    finally:
        if _read(file) == own:
            file.unlink(missing_ok=True)


def _owner(pid: int) -> dict[str, Any]:
    """A process as the lock names it; its number alone may be used again."""
    return {"pid": pid, "host": socket.gethostname(), "started": started(pid)}


def _read(file: Path) -> dict[str, Any]:
    """What a lock says; empty where there is none, or one of no sense."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and found.keys() == {"pid", "host", "started"} else {}


def _lives(holder: dict[str, Any]) -> bool:
    """Whether the holder of a lock may still be at work."""
    return holder["host"] != socket.gethostname() or (holder["started"] != "" and started(holder["pid"]) == holder["started"])
