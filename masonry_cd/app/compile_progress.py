# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of the compilation of kernels, as the user sees it: how many there are, which one is at work, how long it will take.

Processes that compile put what they have done into the folder of ``kernel_store.py``: how far they are is how many files have come there.
The time that is left begins with what an idle machine takes and moves with what is seen. Where a share s of the work is done after a time
t, of T expected, the whole is taken for t + (1 - s) T, and 1 - s of that is left: it grows while nothing comes.
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
    "interior_by_team": 4.0,
    "path_by_team": 3.0,
    "update_pairs": 2.0,
}  # times as long as others these take to compile
LATE = {  # what a run may have compiled when a step first comes to it
    "newton_by_team": "Newton's method",
    "interior_by_team": "the interior point method",
    "path_by_team": "the path by length of the interior point method",
}


class AtWork(event.Listener):
    """Knows which kernels numba compiles in this process: one that Python calls, and one of those in it."""

    def __init__(self) -> None:
        self._open = list[str]()

    def on_start(self, found: event.Event) -> None:
        """Another one is compiled for the last one."""
        self._open.append(found.data["dispatcher"].py_func.__name__)

    def on_end(self, found: event.Event) -> None:
        """It is done; it may have begun before anybody listened."""
        del self._open[-1:]

    def __str__(self) -> str:
        names = [*dict.fromkeys([*self._open[:1], *self._open[-1:]])]
        return f", now {' with '.join(names)}" if names else ""


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
    watch = threading.Thread(target=_watch, args=(known, (count, seconds), line, to, over), daemon=True)
    watch.start()
    try:
        yield
    finally:
        over.set()
        watch.join()


def time_left(expected: float, share: float, elapsed: float) -> float:
    """Seconds that are left where a share of the work has been done, of the seconds expected; see the head of this file."""
    return (1.0 - share) * (elapsed + (1.0 - share) * expected)


def _say(line: str, stream: TextIO) -> None:
    with suppress(OSError):  # a terminal may go away
        print(line, file=stream, flush=True)


def _watch(known: set[str], work: tuple[int, float], line: str, stream: TextIO, over: threading.Event) -> None:
    """Show how far compiling is until it is over: a bar on a terminal, lines elsewhere; ``work``: kernels, and seconds expected."""
    if known:  # all may be there, and nothing to be compiled
        if over.wait(DOUBT):
            return
        _say(line, stream)
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    begin, lines, (count, expected), drawn = time.monotonic(), 0, work, is_drawn(stream)
    total = count - len(WEIGHTS) + sum(WEIGHTS.values())
    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
    with (
        suppress(OSError),
        event.install_listener("numba:compile", AtWork()) as at_work,
        Progress(*columns, console=Console(file=stream, quiet=not drawn), auto_refresh=False) as bar,
    ):
        task = bar.add_task("", total=total)
        while not over.wait(EVERY):
            new, elapsed = _files() - known, time.monotonic() - begin
            done = min(sum(map(_weight, new)), total)
            left = in_words(round(time_left(expected, done / total, elapsed)))
            words = f"{min(len(new), count)} of {count} kernels{at_work}, about {left} left"
            bar.update(task, completed=done, description=words, refresh=True)
            if not drawn and elapsed >= (lines + 1) * LINE_SECONDS:
                lines += 1
                _say(f"compiling: {words}", stream)
        bar.update(task, completed=total, description=f"{count} of {count} kernels", refresh=True)


def _files() -> set[str]:
    """The entries that are kept."""
    place = kernel_store.folder()
    return set() if place is None else {file.name for file in place.glob(f"*{kernel_store.ENDING}") if not file.name.startswith("warm-up-")}


def _weight(name: str) -> float:
    """How long an entry takes to compile, in times of most."""
    return WEIGHTS.get(name.partition("-")[0].rpartition(".")[2], 1.0)
