# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a run is: a bar with the time left on a terminal, plain lines every ten seconds elsewhere (TERM=dumb too); signals between steps.

A step may take microseconds, so a call costs no more than a look at the clock until there is something to draw.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from contextlib import suppress
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any, TextIO

from masonry_cd.foundation.quantities import in_words
from masonry_cd.foundation.system import STOPPING, stays_ignored

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

BAR_SECONDS, LINE_SECONDS = 0.2, 10.0
PLAIN = ("", "dumb", "unknown")  # terminals that cannot go back in a line, by TERM


class Progress:
    """Call it with the number of steps done; use it as a context manager.

    Args:
        total: steps of the run, ticks where their length adapts; one that goes on until its blocks are still may make more.
        quiet: say nothing.
        stream: where to; standard error when not given.
        tick: of a run whose steps adapt [s]; None for one of fixed steps.
        what: is counted, where it is not a step.
    """

    def __init__(
        self,
        total: int,
        quiet: bool = False,
        stream: TextIO | None = None,
        tick: float | None = None,
        what: str = "step",
    ) -> None:
        self.total, self.done = total, 0
        self._grows = False  # whether more may come than are known: then nothing is said of the time left
        self._tick, self._what = tick, what
        self._stream = stream or sys.stderr
        self._bar = _bar(self._stream) if is_drawn(self._stream) and not quiet else None
        self._every = float("inf") if quiet else BAR_SECONDS if self._bar else LINE_SECONDS

    def __enter__(self) -> Progress:
        self._begin = self._last = time.perf_counter()
        if self._bar:
            self._bar.start()
            self._task = self._bar.add_task(
                self._what if self._what != "step" else "steps" if self._tick is None else "shortest steps", total=self.total, left=""
            )
            self._bar.refresh()
        return self

    def __call__(self, done: int) -> None:
        self.done = done
        now = time.perf_counter()
        if now - self._last >= self._every:
            self._last = now
            self._show(now - self._begin)

    def more(self, begun: int, ended: int) -> None:
        """Add the number of steps that have begun to the total, and the number that have ended to those done."""
        self.total, self._grows = self.total + begun, True
        self(self.done + ended)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar:
            self._show(time.perf_counter() - self._begin)
            with suppress(OSError):
                self._bar.stop()

    def _show(self, elapsed: float) -> None:
        with suppress(OSError):  # a terminal may go away; the run goes on
            self._draw(elapsed)

    def _draw(self, elapsed: float) -> None:
        seconds = elapsed / max(1, self.done) * (self.total - self.done)  # as if all cost alike
        left = "" if self._grows else "until all blocks are still" if self.done > self.total else f"{in_words(seconds)} left"
        if self._bar:
            self._bar.update(self._task, total=max(self.total, self.done), completed=self.done, left=left, refresh=True)
            return
        if self._grows:
            print(f"{self._what}: {self.done} of {self.total} begun have ended, {in_words(elapsed)} so far", file=self._stream, flush=True)
            return
        share = f" ({100 * self.done / self.total:.0f} %)" if self.done <= self.total else ""
        steps = f"{self._what} {self.done} of {self.total}"
        if self._tick is not None:
            steps = f"{self.done * self._tick:.4g} of {self.total * self._tick:.4g} s"
        print(f"{steps}{share}, {in_words(elapsed)} so far, {left}", file=self._stream, flush=True)


def is_drawn(stream: TextIO) -> bool:
    """Return True if a bar can be drawn there."""
    return stream.isatty() and os.environ.get("TERM", "dumb") not in PLAIN


def _bar(stream: TextIO) -> Bar:
    """A bar that is drawn only on demand, so that no thread of its own takes time from the run."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
    )

    columns: tuple[Any, ...] = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
    )
    return Progress(*columns, console=Console(file=stream), auto_refresh=False)


class Interrupted(KeyboardInterrupt):
    """A signal that asked the run to end, taken where nothing is torn."""

    def __init__(self, number: int) -> None:
        self.number = number
        super().__init__(f"{'interrupted' if number == signal.SIGINT else f'stopped by {signal.Signals(number).name}'}")


class TimedOut(Interrupted):
    """The time that a run may take is over; no signal came."""

    def __init__(self, seconds: float) -> None:
        KeyboardInterrupt.__init__(self, f"out of time, {seconds:g} s,")
        self.number = 0


class Interrupt:
    """Holds Ctrl-C and its like back until :meth:`check` is called, so that nothing is torn; more of them change nothing.

    Args:
        stream: where the first one is acknowledged; standard error when not given.
        said: what is printed then.

    Attributes:
        number: of the first signal that came, 0 before.
        at_once: take the next signal where it comes, by raising Interrupted: for work that nothing tears.
    """

    def __init__(self, stream: TextIO | None = None, said: str = "finishing the step; results are being written") -> None:
        self.number, self.at_once = 0, False
        self._stream, self._said, self._acknowledged = stream, said, False
        self._former: dict[int, Any] = {}
        self._former_hook = sys.unraisablehook

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():  # elsewhere signals cannot be handled
            for number in STOPPING:
                if not stays_ignored(number):
                    self._former[number] = signal.signal(number, self._handle)
            self._former_hook, sys.unraisablehook = sys.unraisablehook, self._unraisable
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)
        if self._former:
            sys.unraisablehook = self._former_hook

    def check(self) -> None:
        """Raise Interrupted if a signal has come."""
        if self.number:
            raise Interrupted(self.number)

    def _unraisable(self, what: Any) -> None:
        """Say nothing of a signal that came where Python raises nothing, as while an object is taken away: :meth:`check` knows of it."""
        if not isinstance(what.exc_value, Interrupted):
            self._former_hook(what)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.number = self.number or number
        if self.at_once:
            raise Interrupted(number)
        if not self._acknowledged:
            self._acknowledged = True
            with suppress(OSError, RuntimeError, ValueError):  # a terminal that is gone, or one that is being written to
                print(self._said, file=self._stream or sys.stderr, flush=True)
