# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user sees while kernels are compiled: how many there are, how long it will take, and how far it is.

Processes that compile put what they have done into the folder of ``kernel_store.py``: how far they are is how many files have come there.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import TextIO

from numba.core import event

from masonry_cd.app.progress import LINE_SECONDS, is_drawn
from masonry_cd.foundation import kernel_store
from masonry_cd.foundation.quantities import in_words

EVERY = 0.5  # between two looks into the folder [s]
DOUBT = 3.0  # after which kernels are being compiled, though some were there [s]
WEIGHTS = {
    "admm_bodies": 12.0,
    "pivoting_by_team": 10.0,
    "newton_by_team": 5.0,
    "path_by_team": 3.0,
    "update_pairs": 2.0,
}  # times as long as others these take to compile
LATE = {  # what a run may have compiled when a step first comes to it
    "newton_by_team": "Newton's method",
    "path_by_team": "the interior point method",
}


class LateMethods(event.Listener):
    """Says which of LATE is compiled in the middle of a run, which does not count as time of the step."""

    def __init__(self) -> None:
        self.heard = False
        self._depth, self._uncounted = 0, ExitStack()  # numba compiles an entry, and in it the kernel of that name

    def on_start(self, found: event.Event) -> None:
        """Say it, where numba compiles one of these."""
        method = _late_method(found)
        if method and self._depth == 0 and self.heard:
            _say(f"compiling {method}, which no step needed before", sys.stderr)
            self._uncounted.enter_context(kernel_store.loading())
        self._depth += bool(method)

    def on_end(self, found: event.Event) -> None:
        """Count time again."""
        self._depth -= bool(_late_method(found))
        if self._depth == 0:
            self._uncounted.close()


late_methods = LateMethods()
event.register("numba:compile", late_methods)


def _late_method(found: event.Event) -> str | None:
    """Which of LATE numba compiles."""
    return LATE.get(found.data["dispatcher"].py_func.__name__)


@contextmanager
def shown(count: int, seconds: float, why_again: str, stream: TextIO | None = None) -> Iterator[None]:
    """Say how many kernels are compiled in the body and about how long that takes [s], then show how far it is.

    Args:
        count: kernels of this kind of scene.
        seconds: that all of them take.
        why_again: why the next run compiles them again; empty where it does not.
        stream: where to; standard error when not given.
    """
    to, known = stream or sys.stderr, _files() - kernel_store.used  # those of the structure may have been compiled just now
    how_often = f"in each run, as {why_again}" if why_again else "once"
    line = f"compiling {'up to ' if known and not why_again else ''}{count} kernels, {how_often}: about {in_words(seconds)}"
    if not known or why_again:
        _say(line, to)
    if why_again:
        yield
        return
    over = threading.Event()
    watch = threading.Thread(target=_watch, args=(known, count, line, to, over), daemon=True)
    watch.start()
    try:
        yield
    finally:
        over.set()
        watch.join()


def _say(line: str, stream: TextIO) -> None:
    with suppress(OSError):  # a terminal may go away
        print(line, file=stream, flush=True)


def _watch(known: set[str], count: int, line: str, stream: TextIO, over: threading.Event) -> None:
    """Show how far compiling is until it is over: a bar on a terminal, lines now and then elsewhere."""
    if known:  # all may be there, and nothing to be compiled
        if over.wait(DOUBT):
            return
        _say(line, stream)
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    begin = last = time.monotonic()
    total, drawn = count - len(WEIGHTS) + sum(WEIGHTS.values()), is_drawn(stream)
    console = Console(file=stream, quiet=not drawn)
    with (
        suppress(OSError),
        Progress(TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=console, auto_refresh=False) as bar,
    ):
        task = bar.add_task("", total=total)
        while not over.wait(EVERY):
            new = _files() - known
            words = f"{min(len(new), count)} of {count} kernels"
            bar.update(task, completed=min(sum(map(_weight, new)), total), description=words, refresh=True)
            if not drawn and time.monotonic() - last >= LINE_SECONDS:
                last = time.monotonic()
                _say(f"compiling: {words}, {in_words(last - begin)} so far", stream)
        bar.update(task, completed=total, description=f"{count} of {count} kernels", refresh=True)


def _files() -> set[str]:
    """The entries that are kept."""
    place = kernel_store.folder()
    return set() if place is None else {file.name for file in place.glob(f"*{kernel_store.ENDING}") if not file.name.startswith("warm-up-")}


def _weight(name: str) -> float:
    """How long an entry takes to compile, in times of most."""
    return WEIGHTS.get(name.partition("-")[0].rpartition(".")[2], 1.0)
