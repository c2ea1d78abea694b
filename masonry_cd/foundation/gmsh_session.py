# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of gmsh, whose geometry kernel is OpenCASCADE. This module imports little: a child process that reads a file starts from it."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PACKAGES = "libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1"


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """The gmsh module, started and silent, with an empty model that is dropped at the end.

    Raises:
        InputError: gmsh or a system library that it needs is missing.
    """
    try:
        import gmsh

        running = bool(gmsh.isInitialized())
        if not running:  # not interruptible: the handler of Ctrl-C stays ours
            with _signals_as_they_are():
                gmsh.initialize(readConfigFiles=False, interruptible=False)
    except (ImportError, OSError, AttributeError) as failure:
        from masonry_cd.foundation.errors import InputError, in_a_line

        raise InputError(f"gmsh does not start ({in_a_line(failure)}); on Debian and Ubuntu", f"apt-get install {PACKAGES}") from None
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("structure")
        yield gmsh
        gmsh.model.remove()
    finally:
        if not running:
            gmsh.finalize()


@contextmanager
def _signals_as_they_are() -> Iterator[None]:
    """Keep how the process takes signals: gmsh would have a hangup end it under nohup, and a closed pipe without a word."""
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    yield
    if threading.current_thread() is threading.main_thread():  # elsewhere signals cannot be handled
        for number, handler in handlers.items():
            if handler not in (None, signal.SIG_DFL):
                signal.signal(number, handler)


@contextmanager
def silent() -> Iterator[None]:
    """Nothing on standard output: what OpenCASCADE says of a file that it writes goes there, past gmsh's own switch."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)
