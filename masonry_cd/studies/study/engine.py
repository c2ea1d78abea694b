# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs as futures: few in flight at a time, results as they arrive, so that memory stays flat over any number of them.

A worker that dies costs its run, which the scheduler gives to another. A run that takes several workers with it is a failed row; one that
hangs takes one, see watchdog.py.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.run_row import FAILED, RunRow
from masonry_cd.foundation.errors import one_line
from masonry_cd.foundation.quantities import in_words
from masonry_cd.studies.study.clusters import DEATHS
from masonry_cd.studies.study.plan import Planned
from masonry_cd.studies.study.task import Outcome, Task, run_task
from masonry_cd.studies.study.watchdog import given_up, has_hung, watched

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 3  # runs that wait for each thread, so that none is idle
LEAST = 8  # in flight, however few threads there are
POLL = 0.2  # between two looks at signals [s]
RECOUNT = 5.0  # between two counts of the threads [s]
GATHER = 60.0  # for a result to arrive [s]; its worker may have died, and the run is repeated
GONE = "the scheduler does not answer any more"


class ClusterLost(Exception):
    """The scheduler does not answer, or there are no workers; runs that had not returned are to be repeated. Its text says which."""


@dataclass
class Engine:
    """Gives runs to the workers of a cluster."""

    client: Client
    task_of: Callable[[Planned], Task]
    ended: Callable[[Planned, Outcome], Iterable[Planned]]  # takes a result; the runs that follow from it
    look: Callable[[int, int], None]  # called now and then with the number in flight and of threads; it may raise to end the engine
    function: Callable[[Task], Outcome] = run_task
    patience: float = math.inf  # without any worker [s]; those of a queue may take days to come
    _running: dict[str, tuple[Future, Planned]] = field(default_factory=dict)
    _done: SimpleQueue[Future] = field(default_factory=SimpleQueue)
    _threads: int = 0
    _counted: float = -RECOUNT
    _manned: float = field(default_factory=time.monotonic)

    def execute(self, runs: Iterable[Planned]) -> None:
        """Make all runs, and those that follow from them.

        Raises:
            ClusterLost: the scheduler is gone, or the workers are.
        """
        waiting = deque(runs)
        try:
            while waiting or self._running:
                self._count()
                while waiting and len(self._running) < max(LEAST, (1 + AHEAD) * self._threads):
                    self._submit(waiting.popleft())
                self.look(len(self._running), self._threads)
                waiting.extend(self._take())
        finally:
            if self._running and self._alive():
                self.client.cancel([future for future, _ in self._running.values()], force=True)
            self._running.clear()

    def _submit(self, run: Planned) -> None:
        """Give a run to the cluster."""
        future = self.client.submit(watched, self.function, self.task_of(run), key=f"run-{run.name}", pure=False)
        self._running[str(future.key)] = (future, run)
        future.add_done_callback(self._done.put)

    def _take(self) -> Iterable[Planned]:
        """Wait a little for a result; the runs that follow from it."""
        try:
            future = self._done.get(timeout=POLL)
        except Empty:
            return []
        if str(future.key) not in self._running:
            return []
        run = self._running[str(future.key)][1]
        outcome = self._outcome(future, run)
        if outcome is None:
            return []
        del self._running[str(future.key)]
        future.release()
        return self.ended(run, outcome)

    def _outcome(self, future: Future, run: Planned) -> Outcome | None:
        """Return the outcome of a run; None where its result was lost on the way, and it is repeated."""
        from distributed import KilledWorker

        if future.status in ("cancelled", "lost"):
            raise ClusterLost(GONE)
        try:
            found: Outcome = future.result(timeout=GATHER)
            return found
        except TimeoutError:
            future.add_done_callback(self._done.put)
            return None
        except KilledWorker:
            task = self.task_of(run)
            if has_hung(task):
                return given_up(task)
            reason = f"{DEATHS + 1} workers died with it: more memory than they may take, or a crash"
        except Exception as error:
            if future.status in ("cancelled", "lost") or not self._alive():
                raise ClusterLost(GONE) from None
            reason = one_line(f"{type(error).__name__}: {error}")
        return Outcome(run.name, RunRow(FAILED, reason))

    def _count(self) -> None:
        """Count the threads of the cluster now and then: workers may come and go."""
        now = time.monotonic()
        if now - self._counted < RECOUNT and self._threads:
            return
        self._counted = now
        try:
            found: dict[str, Any] = self.client.nthreads()
        except (OSError, TimeoutError, ValueError):
            raise ClusterLost(GONE) from None
        self._threads = sum(found.values())
        if self._threads:
            self._manned = now
        elif now - self._manned > self.patience:
            raise ClusterLost(f"no worker has been there for {in_words(now - self._manned)}")

    def _alive(self) -> bool:
        """Return True if the scheduler still answers."""
        return bool(self.client.status == "running")
