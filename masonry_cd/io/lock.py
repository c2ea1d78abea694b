# SPDX-License-Identifier: GPL-3.0-or-later
"""A lock on the folder of a run, so that no two runs write there at once.

``run.lock`` names the process that holds the folder, and that process holds the file by the kernel for as long as it lives. So

    the kernel says that it is held           the holder lives, in whichever container or, by a file system that shares locks, machine
    it is free, and was held on this boot     the holder is dead: a kill, also of a container of another name
    else, the same host                       by its number and when it was started
    else, another host                        not to be known: it may live, and is refused, with what to do
"""

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
from masonry_cd.foundation.system import hold, one_process_in, started

NAME = "run.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder, which is created if missing; the lock of a process that is dead is taken over.

    Raises:
        InputError: a run that is alive, or may be since it is on another machine, holds the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file, own = folder / NAME, _owner(os.getpid())
    with one_process_in(folder):  # which looks at the lock and takes it
        holder = _read(file)
        if holder and (end := _lives(file, holder)):
            where = f"process {holder['pid']} on {holder['host']}"
            raise InputError(folder, f"another run is writing to this folder ({where}){end}")
        handle = None
        with replacing(file, listed=False) as part:
            handle = _held(part)
            part.write_text(json.dumps(own | {"held": handle is not None}) + "\n", encoding="utf-8")
    try:
        yield
    finally:
        if _read(file).items() >= own.items():
            file.unlink(missing_ok=True)
        if handle is not None:
            os.close(handle)


def _owner(pid: int) -> dict[str, Any]:
    """A process as the lock names it; its number alone may be used again."""
    return {"pid": pid, "host": socket.gethostname(), "started": started(pid)}


def _read(file: Path) -> dict[str, Any]:
    """Return the contents of a lock; empty where there is none, or one of no sense."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and found.keys() >= {"pid", "host", "started"} else {}


def _held(part: Path) -> int | None:
    """The handle by which a new lock is held: it stays with the file when that gets its name."""
    part.touch()
    return hold(part)


def _lives(file: Path, holder: dict[str, Any]) -> str:
    """How a refusal ends where the holder of a lock may still be at work; empty where it is dead."""
    try:
        handle = hold(file)
    except BlockingIOError:
        return ": wait until it finishes, or choose another folder"
    except OSError:  # a lock that may be read and not written
        handle = None
    if handle is not None:
        os.close(handle)
        if holder.get("held") and _boot(holder["started"]) and _boot(holder["started"]) == _boot(started(os.getpid())):
            return ""
    if holder["host"] != socket.gethostname():
        return f", which may still be active: if its machine or container has stopped, remove {file} and repeat"
    lives = holder["started"] != "" and started(holder["pid"]) == holder["started"]
    return f"; if that process is not a run, remove {file}" if lives else ""


def _boot(when: Any) -> str:
    """The boot of the machine since which a process was started; empty where the system does not say."""
    return str(when).partition(" ")[2]
