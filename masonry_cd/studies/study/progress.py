# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a study is: runs done, running and failed, and the time left, on one line of a terminal; elsewhere a line now and then.

A run's cost is guessed by its number of steps. What a step costs is measured by the runs that have ended, which are made in a random order
and so stand for the others.
"""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress
from typing import TextIO

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.app.progress import PLAIN
from masonry_cd.foundation.quantities import in_words

DRAWN, SAID = 0.5, 10.0  # between two lines on a terminal and elsewhere [s]


class StudyProgress:
    """Counts runs and tells how long the rest takes.

    Args:
        total: runs of the plan so far.
        finished: of them, before this call.
        weight: of those that are left.
        quiet: say nothing.
        stream: standard error when not given.
    """

    def __init__(self, total: int, finished: int, weight: float, quiet: bool = False, stream: TextIO | None = None) -> None:
        self.total, self.finished, self.failed = total, finished, 0
        self._stream = stream or sys.stderr
        self._line = self._stream.isatty() and os.environ.get("TERM", "dumb") not in PLAIN
        self._every = float("inf") if quiet else DRAWN if self._line else SAID
        self._left, self._cost, self._made = weight, 0.0, 0.0
        self._last = self._begin = time.monotonic()
        self._width = 0
        self._workers: set[str] = set()

    def planned(self, weight: float) -> None:
        """A run was added to the plan."""
        self.total += 1
        self._left += weight

    def ended(self, weight: float, row: RunRow) -> None:
        """A run has ended: its row. What the first one of a worker took to set up, as loading the kernels, does not come again."""
        self.finished += 1
        self.failed += not row.done
        self._left -= weight
        first = row.worker not in self._workers
        self._workers.add(row.worker)
        self._made += weight
        self._cost += row.seconds - (row.timing.get("set_up", 0.0) if first else 0.0)

    def seconds_left(self, threads: int) -> float | None:
        """For the runs that are left [s]; None before the first has ended."""
        if not self._made > 0.0 or not threads:
            return None
        return max(0.0, self._left) * self._cost / self._made / threads

    def look(self, running: int, threads: int) -> None:
        """Draw the line if it is time to."""
        now = time.monotonic()
        if now - self._last >= self._every:
            self._last = now
            self._show(self.line(min(running, threads), threads))

    def line(self, running: int, threads: int) -> str:
        """The state as text."""
        left = self.seconds_left(threads)
        rest = "waiting for workers" if not threads else "" if left is None else f"{in_words(left)} left"
        failed = f", {self.failed} failed" if self.failed else ""
        so_far = in_words(time.monotonic() - self._begin)
        return f"{self.finished} of {self.total} runs done{failed}, {running} running, {so_far} so far{rest and ', ' + rest}"

    def close(self) -> None:
        """End the line of a terminal."""
        if self._line and self._width:
            with suppress(OSError):
                print(file=self._stream, flush=True)

    def _show(self, line: str) -> None:
        with suppress(OSError):  # a terminal may go away; the study goes on
            if self._line:
                print("\r" + line.ljust(self._width), end="", file=self._stream, flush=True)
                self._width = len(line)
            else:
                print(line, file=self._stream, flush=True)
