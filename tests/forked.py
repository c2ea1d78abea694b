# SPDX-License-Identifier: GPL-3.0-or-later
"""A body of a test in a process of its own, which may crash or hang without harm to the others."""

from __future__ import annotations

import os
import signal
import traceback
from collections.abc import Callable

import pytest


def need_fork() -> None:
    """Skip the test on a system that cannot fork a process."""
    if not hasattr(os, "fork"):
        pytest.skip("needs os.fork")


def ended(body: Callable[[], str | None], limit: int) -> str:
    """Run a body in a forked process, ended after ``limit`` [s]: what it returns, "" for nothing, or how else it ended."""
    need_fork()
    read, write = os.pipe()
    if (pid := os.fork()) == 0:
        try:
            signal.alarm(limit)
            os.write(write, (body() or "").encode())
        except BaseException:
            os.write(write, traceback.format_exc()[-3000:].encode())
        finally:
            os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as said:
        words = said.read().decode()
    _, status = os.waitpid(pid, 0)
    return words or (f"ended by signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "")
