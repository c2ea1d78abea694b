# SPDX-License-Identifier: GPL-3.0-or-later
"""A study from end to end: an arch of 27 voussoirs under 40 motions at ten levels, on one worker and on more.

    python -m benchmarks.study_arch --records ../suite --workers 1 2
    python -m benchmarks.study_arch --motions 4 --workers 1 2

Records are files NAME_NS.acc (or H1, Lo) with a sample every 5 ms; without a folder of them the motions are artificial, of Eurocode 8. A
line of the table has the time of the clock of the whole command, the seconds in which its workers were busy, all of them together, and what
these went to: setting a run up, its steps, its end (tables, joints), and recording (joints measured after each step, results written). The
table of the runs must be the same on any number of workers, seconds aside.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.sitting import head

LEVELS = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]  # PGA [m/s2]
STUDY = """
title = "Arch of 27 voussoirs"
design = "stripes"
seed = 1

[scene]
structure = {{ kind = "arch", span = 4.0, thickness = 0.4, width = 1.0, voussoirs = 27 }}
material = {{ density = 2200.0, friction = 0.6 }}
run = {{ dt = 5e-3, duration = 15.0, tolerance = 1e-5, frames_per_second = 25.0 }}
report = {{ crack_map = false }}
{motions}

[intensity]
measure = "{measure}"
{key}
levels = {levels}

[limit_states]
cracked = {{ quantity = "max_opening", above = 1e-3 }}
damaged = {{ quantity = "max_opening", above = 1e-2 }}
collapse = {{ quantity = "collapsed_blocks", above = 0 }}
"""
RECORDED = """
[records]
folder = "{folder}"
x = ["NS", "H1", "Lo"]
units = "m/s2"
dt = 0.005
trim = {{ arias = [0.005, 0.975], before = 0.2, after = 0.5 }}
rest = 1.0
"""
ARTIFICIAL = """
[[scene.loads]]
kind = "artificial"
direction = "x"
spectrum = "EC8"
ground = "B"
ag = 1.0

[records]
key = "loads[0].seed"
values = {seeds}
"""


@dataclass(frozen=True)
class Took:
    """Time and counts of a study."""

    workers: int
    runs: int
    clock: float  # the whole command [s]
    parts: dict[str, float]  # seconds of all workers, by what they did

    @property
    def busy(self) -> float:
        """Seconds of all workers."""
        return sum(self.parts.values())


def study_text(records: Path | None, motions: int, levels: list[float]) -> str:
    """The study file."""
    if records is not None:
        return STUDY.format(motions=RECORDED.format(folder=records.resolve()), measure="PGA", key='of = "x"', levels=levels)
    artificial = ARTIFICIAL.format(seeds=list(range(motions)))
    return STUDY.format(motions=artificial, measure="ag", key='key = "loads[0].ag"', levels=levels)


def measure(text: str, workers: int, folder: Path) -> tuple[Took, list[dict[str, str]]]:
    """Run a study; what it took, and its table without the seconds.

    Raises:
        RuntimeError: the command failed, or a run in it.
    """
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    begin, out = time.perf_counter(), folder / f"on{workers}"
    command = [sys.executable, "-m", "masonry_cd", "study", str(file), "-o", str(out), "--workers", str(workers), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    clock = time.perf_counter() - begin
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    rows = [json.loads(path.read_text(encoding="utf-8")) for path in sorted((out / "rows").glob("*.json"))]
    parts = {name: sum(row["timing"][name] for row in rows) for name in rows[0]["timing"]}
    parts["recording"] = sum(row["seconds"] for row in rows) - sum(parts.values())
    with (out / "runs.csv").open(newline="", encoding="utf-8") as lines:
        table = [{name: value for name, value in row.items() if name != "seconds"} for row in csv.DictReader(lines)]
    return Took(workers, len(rows), clock, parts), table


def main() -> int:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="A study of an arch from end to end.")
    parser.add_argument("--records", type=Path, help="a folder of records; without it motions are artificial")
    parser.add_argument("--motions", type=int, default=40, help="how many artificial ones")
    parser.add_argument("--levels", type=float, nargs="+", default=LEVELS, help="[m/s2]")
    parser.add_argument("--workers", type=int, nargs="+", default=[2])
    given = parser.parse_args()
    first: tuple[Took, list[dict[str, str]]] | None = None
    for workers in given.workers:
        with TemporaryDirectory() as folder:
            try:
                took, table = measure(study_text(given.records, given.motions, given.levels), workers, Path(folder))
            except RuntimeError as error:
                print(error, file=sys.stderr)
                return 2
        if first is None:
            first = took, table
            print(head("workers", "runs", "clock [s]", "busy [s]", *(f"{name.replace('_', ' ')} [%]" for name in took.parts), "speed-up"))
        if table != first[1]:
            print(f"the table on {workers} workers differs from that on {first[0].workers}", file=sys.stderr)
            return 2
        shares = [f"{100.0 * spent / took.busy:.1f}" for spent in took.parts.values()]
        cells = [str(workers), str(took.runs), f"{took.clock:.0f}", f"{took.busy:.0f}", *shares, f"{first[0].clock / took.clock:.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
