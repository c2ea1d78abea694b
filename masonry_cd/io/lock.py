"""A lock on the folder of a run, so that no two runs write there at once."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError

NAME = "run.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder, which is made if need be; the lock of a process that is dead is taken over.

    Raises:
        InputError: a run that is alive, or may be since it is on another machine, holds the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file, own = folder / NAME, _owner(os.getpid())
    with _alone(folder):
        holder = _read(file)
        if holder and _lives(holder):
            where = f"process {holder['pid']} on {holder['host']}"
            raise InputError(f"{folder}: another run writes there ({where}); where that is wrong, remove {file}")
        with replacing(file) as part:
            part.write_text(json.dumps(own) + "\n", encoding="utf-8")
    try:
        yield
    finally:
        if _read(file) == own:
            file.unlink(missing_ok=True)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let one process at a time look at the lock and take it."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # some network file systems know no such locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _owner(pid: int) -> dict[str, Any]:
    """A process as the lock names it; its number alone may be used again."""
    return {"pid": pid, "host": socket.gethostname(), "started": _started(pid)}


def _started(pid: int) -> str:
    """When a process was started, in ticks of the clock since which boot; "" where there is none."""
    try:
        after_name = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return f"{after_name[19]} {Path('/proc/sys/kernel/random/boot_id').read_text().strip()}"
    except (OSError, IndexError):
        return ""


def _read(file: Path) -> dict[str, Any]:
    """What a lock says; empty where there is none, or one of no sense."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and found.keys() == {"pid", "host", "started"} else {}


def _lives(holder: dict[str, Any]) -> bool:
    """Whether the holder of a lock may still be at work."""
    return holder["host"] != socket.gethostname() or (holder["started"] != "" and _started(holder["pid"]) == holder["started"])
