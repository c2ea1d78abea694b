# SPDX-License-Identifier: GPL-3.0-or-later
"""The overhead of a study's engine: many runs that do nothing but wait, with their rows written, and the memory they take.

    python -m benchmarks.study_engine [--runs 10000] [--workers 2] [--milliseconds 10]

Prints, for each tenth of the runs, how long it took, the time of a run beyond what its worker waited, and the memory of the program and of
its largest worker.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.studies.study.clusters import RunPlace, connected
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.engine import Engine
from masonry_cd.studies.study.folder import JOINTS, StudyFolder
from masonry_cd.studies.study.plan import Planned
from masonry_cd.studies.study.task import ROWS, Outcome, Task

JOINTS_OF_RUN = 30
SCENE = {"title": "stands in for a scene", "run": {"dt": 1e-3, "duration": 10.0}, "loads": [{"kind": "record", "path": "x" * 200}] * 3}


def wait(task: Task, seconds: float) -> Outcome:
    """Stands in for a run: its row and its joints are as large as those of an arch."""
    time.sleep(seconds)
    joints = {"opening": np.zeros(JOINTS_OF_RUN, dtype=np.float32), "lost": np.zeros(JOINTS_OF_RUN, dtype=bool), "shape": 1}
    row = RunRow(DONE, seconds=seconds, worker=str(os.getpid()), numbers=dict.fromkeys("abcdefghijkl", 0.123456789))
    return Outcome(task.name, row, joints)


def megabytes() -> tuple[float, float]:
    """Resident memory of this process, and of the largest of its children [MB]."""
    import psutil

    own = psutil.Process()
    children = [child.memory_info().rss for child in own.children(recursive=True)]
    return own.memory_info().rss / 1e6, max(children, default=0) / 1e6


def measure(runs: int, workers: int, seconds: float) -> list[dict[str, float]]:
    """Make the runs; a row for each tenth of them."""
    rows: list[dict[str, float]] = []
    done, last = 0, 0.0
    with TemporaryDirectory() as scratch, connected(RunPlace(workers=workers, memory=1.0)) as (client, _):
        folder = StudyFolder(Path(scratch))
        for name in (ROWS, JOINTS):
            (folder.path / name).mkdir()

        def ended(run: Planned, outcome: Outcome) -> Iterable[Planned]:
            nonlocal done, last
            folder.add(run, outcome)
            done += 1
            if done % (runs // 10) == 0:
                now = time.perf_counter()
                own, child = megabytes()
                overhead = (now - last) * workers / (runs // 10) - seconds
                rows.append({"runs": done, "seconds": now - last, "overhead": overhead, "program": own, "worker": child})
                last = now
            return ()

        planned = [Planned(f"{k:08x}", DesignedRun(), 1.0) for k in range(runs)]
        client.wait_for_workers(workers)
        last = time.perf_counter()
        Engine(client, lambda run: Task(run.name, SCENE, 60.0), ended, lambda *_: None, partial(wait, seconds=seconds)).execute(planned)
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--milliseconds", type=float, default=10.0)
    asked = parser.parse_args()
    print(f"{'runs':>8} {'seconds':>9} {'overhead':>12} {'program':>10} {'worker':>10}")
    for row in measure(asked.runs, asked.workers, asked.milliseconds / 1e3):
        over, own, child = 1e3 * row["overhead"], row["program"], row["worker"]
        print(f"{row['runs']:>8.0f} {row['seconds']:>9.1f} {over:>9.2f} ms {own:>7.0f} MB {child:>7.0f} MB")


if __name__ == "__main__":
    main()
