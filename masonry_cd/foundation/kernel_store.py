# SPDX-License-Identifier: GPL-3.0-or-later
"""Where compiled kernels are kept: one file an entry, named by all that it depends on, so that a file is right or is not looked at.

    masonry_cd.mechanics.solvers.admm_kernels.admm_bodies-<sources>-<kind>.nbc

``sources`` hashes the code that the entry reaches (``stamps.py``), ``kind`` the types of its arguments, the processor, numba's version and
Python's. No place on the disc is part of a name, so files that a wheel brings are as good as those made here; they are read and never
written.

What is compiled here goes to ``__pycache__`` of the package or, where that cannot be written, to the user's folder for caches; the variable
NUMBA_CACHE_DIR names another. A file ends in a hash of its content: what is cut off or damaged counts as absent.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

FOLDER = "NUMBA_CACHE_DIR"  # environment variable: where to keep what is compiled
SHIPPED = "compiled"  # folder of the package in which a wheel brings kernels
ENDING = ".nbc"
DIGEST = sha256().digest_size
OTHERS = 86400.0  # age at which files of other sources go: another checkout may share the folder [s]

unkept: list[OSError] = []  # why entries could not be written, a full disc for example
_loading = [0.0]  # how long this process has loaded kernels [s]
used: set[str] = set()  # names of what this process has read or written


def places() -> list[Path]:
    """The folders to read from: what a wheel brought, and what was compiled here."""
    own = folder()
    return [_package() / SHIPPED] + ([own] if own is not None else [])


def folder() -> Path | None:
    """The folder to write to, created if missing; None where there is none."""
    return _writable(os.environ.get(FOLDER, ""))


def name_of(entry: str, sources: str, kind: str) -> str:
    """The file of an entry: its module and name, a hash of its sources, and what else decides how it is compiled."""
    entry = entry.replace("<", "").replace(">", "")  # of a function within another one, or without a name
    return f"{entry}-{sources[:24]}-{sha256(kind.encode()).hexdigest()[:24]}{ENDING}"


def read(name: str) -> bytes | None:
    """Return the contents kept under a name; None where there are none, or only part of them."""
    for place in places():
        with suppress(OSError):
            whole = (place / name).read_bytes()
            if sha256(whole[:-DIGEST]).digest() == whole[-DIGEST:]:
                return whole[:-DIGEST]
    return None


@contextmanager
def loading() -> Iterator[None]:
    """Stop :func:`clock` while the body loads a kernel."""
    begin = time.perf_counter()
    try:
        yield
    finally:
        _loading[0] += time.perf_counter() - begin


def clock() -> float:
    """A reading of the clock without the time in which kernels were loaded, which happens at their first calls [s]."""
    return time.perf_counter() - _loading[0]


def is_there(name: str) -> bool:
    """Return True if something is kept under a name."""
    return any((place / name).exists() for place in places())


def write(name: str, data: bytes) -> None:
    """Keep data under a name, where the disc takes it; why it did not is noted in ``unkept``. Processes may write at once."""
    place = folder()
    if place is None:
        return
    part = place / f"{name}.{os.getpid()}.part"
    try:
        part.write_bytes(data + sha256(data).digest())
        part.replace(place / name)
    except OSError as failure:
        unkept.append(failure)
        part.unlink(missing_ok=True)
        return
    used.add(name)
    _drop_others(place, name)


def _drop_others(place: Path, name: str) -> None:
    """Drop old files of an entry that were made of other sources."""
    entry, sources, _ = name.rsplit("-", 2)
    for file in place.glob(f"{entry}-*{ENDING}"):
        with suppress(OSError):
            if not file.name.startswith(f"{entry}-{sources}-") and time.time() - file.stat().st_mtime > OTHERS:
                file.unlink()


@cache
def _writable(named: str) -> Path | None:
    """The first of the folders that may be written to."""
    if named:
        return _made(Path(named))
    with suppress(RuntimeError):  # no home
        found = _made(_package() / "__pycache__")
        return found if found is not None else _made(Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "masonry_cd")
    return None


def _made(place: Path) -> Path | None:
    """A folder, if there is one to write to."""
    with suppress(OSError):
        place.mkdir(parents=True, exist_ok=True)
        return place if os.access(place, os.W_OK | os.X_OK) else None
    return None


def _package() -> Path:
    """The folder of masonry_cd."""
    return Path(sys.modules["masonry_cd"].__path__[0])
