# SPDX-License-Identifier: GPL-3.0-or-later
"""Ends a run that hangs, in a step or anywhere else, so that it becomes a row as well.

A run looks at the clock after each step, which does not end a step that never returns; nor does an alarm of Python reach code that does
not come back to Python. A thread without Python does (faulthandler): when the time is up it writes where the program hangs, and ends the
process of the worker. Its nanny starts the worker again, and the scheduler gives the run away again; who gets it finds what was written,
and gives up.
"""

from __future__ import annotations

import faulthandler
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from masonry_cd.analysis.run_row import TIMEOUT, RunRow
from masonry_cd.studies.study.task import ROWS, Outcome, Task

SUFFIX = ".hang"  # of the file in the folder of rows that says where a run hung


def watched(make: Callable[[Task], Outcome], task: Task) -> Outcome:
    """Make a run in a worker, which ends with it should it take longer than all of it may.

    Args:
        make: makes the run.
        task: the run.
    """
    if has_hung(task):
        return given_up(task)
    if not _is_restarted():
        return make(task)
    with _alarm(task.timeout + task.grace, _trace(task)):
        return make(task)


def has_hung(task: Task) -> bool:
    """Return True if a run has ended its worker because it hung."""
    try:
        return bool(_trace(task).read_bytes())
    except OSError:
        return False


def given_up(task: Task) -> Outcome:
    """Return the outcome of a run that hung."""
    reason = f"timed out after {task.timeout:g} s, in a step or a set-up that did not end"
    return Outcome(task.name, RunRow(TIMEOUT, reason, task.timeout + task.grace))


def _trace(task: Task) -> Path:
    """The file that says where a run hung; empty while it runs."""
    return Path(task.folder) / ROWS / f"{task.name}{SUFFIX}"


def _is_restarted() -> bool:
    """Return True if this is a worker whose nanny starts it again when it ends."""
    from distributed import get_worker

    try:
        return bool(get_worker().nanny)
    except ValueError:
        return False


@contextmanager
def _alarm(seconds: float, trace: Path) -> Iterator[None]:
    """End this process after some time, unless what is inside has ended."""
    there = trace.parent.is_dir()  # without it the run is given away until as many workers were lost as it may cost
    with (trace if there else Path(os.devnull)).open("wb") as file:
        faulthandler.dump_traceback_later(seconds, exit=True, file=file)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
    if there:
        trace.unlink(missing_ok=True)
