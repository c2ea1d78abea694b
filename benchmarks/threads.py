# SPDX-License-Identifier: GPL-3.0-or-later
"""Gain by threads: wall time per step of scene files on one thread, on two, and so on up to the cores there are.

    python -m benchmarks.threads examples/church_sine.toml examples/aqueduct_sinusoidal.toml --steps 50

Each is run by turns as often as asked, and medians are shown. Factors of one subtree, and pivoting, keep to one thread. The last column is
what a run takes where ``run.threads`` is not given: one for each THREAD_WORTH contacts of ``masonry_cd/mechanics/solvers/options.py``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.ours import stepper_of_file
from benchmarks.sitting import head
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.solvers import cores, threads_that_pay

WARM = 2  # steps before the clock starts: the first is cold


class Sample(NamedTuple):
    """Some steps of a scene."""

    seconds: float  # of wall time, per step
    contacts: float  # mean over the steps
    dimension: int  # 2 in a plane
    position: np.ndarray  # (B, 3) at the end [m]


def sample(scene: Path, changes: Sequence[str], threads: int, steps: int) -> Sample:
    """Step a scene, changed by some ``key=value``, on some threads.

    Raises:
        InputError: anything wrong with the scene.
    """
    machine = stepper_of_file(scene, [*changes, f"run.threads={threads}"])
    for _ in range(WARM):
        machine.step()
    begin = time.perf_counter()
    contacts = [machine.step().contacts for _ in range(steps)]
    return Sample((time.perf_counter() - begin) / steps, float(np.mean(contacts)), machine.system.rows, machine.state.position)


def row(scene: Path, changes: Sequence[str], steps: int, repeats: int) -> str:
    """A line of the table.

    Raises:
        InputError: anything wrong with the scene.
        RuntimeError: threads changed the answer.
    """
    counts = range(1, cores() + 1)
    found = [[sample(scene, changes, threads, steps) for threads in counts] for _ in range(repeats)]
    first = found[0][0]
    if any((one.position != first.position).any() for each in found for one in each):
        raise RuntimeError(f"{scene}: threads changed the answer")
    times = np.median([[one.seconds for one in each] for each in found], axis=0)
    cells = [scene.name, f"{first.contacts:.0f}", *(f"{1e3 * each:.3g}" for each in times), f"{times[0] / times.min():.2f}"]
    return f"| {' | '.join([*cells, str(threads_that_pay(None, int(first.contacts), first.dimension))])} |"


def main() -> int:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="What threads save.")
    parser.add_argument("scenes", type=Path, nargs="+", help="scene files")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another value of a key of the scenes")
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    print(head("scene", "contacts", *(f"ms on {n}" for n in range(1, cores() + 1)), "one thread over the best", "by itself"))
    try:
        for scene in given.scenes:
            print(row(scene, given.set, given.steps, given.repeats), flush=True)
    except (InputError, RuntimeError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
