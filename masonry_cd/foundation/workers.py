# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that work for this one and end with it: after Ctrl-C at once, and when it is killed.

Ctrl-C in a terminal reaches all processes, and is for the first alone to answer; it ends its workers. One that is killed cannot: a worker
is then ended by the kernel (Linux) or by a thread that waits for the end of its parent.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any

from masonry_cd.foundation import system
from masonry_cd.foundation.errors import InputError

ENDED = 1  # exit code of a worker whose parent is gone


def leave_interrupts() -> None:
    """Leave Ctrl-C to the process that the user started."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def workers(
    count: int, begins: str = system.INHERITS, prepare: Callable[..., object] | None = None, *given: Any
) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of processes; whatever ends the body early ends them. Its tasks are submitted: those of ``map`` may be cancelled twice.

    Args:
        count: of them.
        begins: how a process begins, as multiprocessing names it.
        prepare: called in each process before its first task.
        given: to ``prepare``.

    Raises:
        InputError: a process died.
    """
    before = set(multiprocessing.active_children())
    context = multiprocessing.get_context(begins)
    with ProcessPoolExecutor(count, mp_context=context, initializer=_begin, initargs=(prepare, given)) as pool:
        try:
            yield pool
        except BrokenProcessPool:
            raise InputError("", "a process died that worked for this one, perhaps for want of memory; fewer at a time need less") from None
        except BaseException:
            with _uninterrupted():
                for child in set(multiprocessing.active_children()) - before:
                    child.kill()
                pool.shutdown()
            raise


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Have a second Ctrl-C wait for what takes no time."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    known = signal.getsignal(signal.SIGINT)
    leave_interrupts()
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, known)


def _begin(prepare: Callable[..., object] | None, given: tuple[Any, ...]) -> None:
    """Begin a worker."""
    leave_interrupts()
    system.end_with_parent()
    threading.Thread(target=_end_after_parent, daemon=True).start()
    if prepare is not None:
        prepare(*given)


def _end_after_parent() -> None:
    """Wait for the end of the parent, and end this process."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(ENDED)
