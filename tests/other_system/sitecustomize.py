# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for a system that has none of what POSIX and Linux alone have, in every Python that is started with this folder on its path.

    PYTHONPATH=tests/other_system python -m pytest        (make test-elsewhere)

The program's own modules cannot import what Windows lacks; libraries may, as they have their own ways there. Signals, os.fork and the like
are gone for all, and /proc for the program. What this cannot show: paths, encodings and the C library of another system.
"""

import builtins
import os
import signal
import sys
from pathlib import Path

OURS = ("masonry_cd", "structures", "loads", "reports")
MODULES = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix")
GONE = (
    (signal, ("SIGHUP", "SIGQUIT", "SIGXCPU", "SIGUSR1", "SIGUSR2")),
    (os, ("fork", "forkpty", "killpg", "sched_getaffinity")),
)

_import = builtins.__import__


def without(name, globals=None, locals=None, fromlist=(), level=0):
    """An import that finds no module of POSIX where this program asks for it, and has it look for processes nowhere."""
    if name in MODULES and str((globals or {}).get("__name__", "")).partition(".")[0] in OURS:
        raise ImportError(f"no module named {name} on this system")
    found = _import(name, globals, locals, fromlist, level)
    system = sys.modules.get("masonry_cd.foundation.system")
    if hasattr(system, "STOPPING"):  # it is read that far
        system.PROC, system.RENAMES_OPEN_FILES = Path("/nowhere"), False
    return found


builtins.__import__ = without
for module, names in GONE:
    for name in names:
        delattr(module, name)
