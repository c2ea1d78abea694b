# SPDX-License-Identifier: GPL-3.0-or-later
r"""Save the results of short scenes, change the code, and check that not a bit of them has changed.

    python -m benchmarks.bits save
    python -m benchmarks.bits check
    python -m benchmarks.bits check --only church tower --file out/before.json
    python -m benchmarks.bits check --as Prescott

Each scene is run by the command line, ``python -m masonry_cd run``, in a process of its own, so nothing but the commands and the files that
they write has to stay as it is. ``save`` keeps a hash of every dataset of result.h5, every column of every table, every key of
summary.json, of dumped friction problems and of their solutions; times of the clock and versions are left out. ``check`` says
what differs, from which row on, and by how much. Exit codes: 0 the same, 1 a difference or a scene that fails, 2 bad input.

A baseline belongs to one machine and one set of package versions; ``check`` says so when they differ.

``--as`` checks whether bits depend on the processor, beyond AVX2 and FMA: it has libraries choose as they would on another one, numpy its
plainest loops, and OpenBLAS the kernels for the processor named. This one must know their instructions, as any does those for Prescott, and
one with AVX2 those for Sandybridge, Haswell and Zen.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.bits import baseline
from benchmarks.bits.cases import CASES, Case
from benchmarks.bits.other_processor import other_processor
from benchmarks.bits.runs import Arrays, run_case

FILE = Path("out/bits.json")


def main(words: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="benchmarks.bits", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("save", "check"))
    parser.add_argument("--file", type=Path, default=FILE, help=f"the baseline, {FILE} by default")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=CASES, help=f"some scenes: {', '.join(CASES)}")
    parser.add_argument("--as", dest="core", metavar="CORE", help="check as another processor would do, e.g. Prescott")
    parser.add_argument("--jobs", type=int, default=1, help="scenes at a time")
    asked = parser.parse_args(words)
    if asked.what == "save" and asked.core:
        parser.error("--as: a baseline is of this processor")
    if asked.jobs < 1:
        parser.error("--jobs: at least 1")
    cases = {name: CASES[name] for name in asked.only or CASES}
    if asked.what == "save":
        return save(cases, asked.file, asked.jobs)
    if not asked.file.exists():
        parser.error(f"{asked.file}: no baseline; make one by: python -m benchmarks.bits save")
    return check(cases, asked.file, asked.jobs, other_processor(asked.core) if asked.core else {})


def save(cases: Mapping[str, Case], file: Path, jobs: int = 1) -> int:
    """Run the cases and keep their results; 1 where one fails."""
    failed = 0
    for name, found, seconds in _run(cases, jobs):
        if isinstance(found, str):
            failed += 1
            print(f"{name}: FAILED, {found}", flush=True)
            continue
        baseline.save(file, name, found)
        print(f"{name}: {len(found)} arrays, {seconds:.1f} s", flush=True)
    print(f"written: {file}")
    return 1 if failed else 0


def check(cases: Mapping[str, Case], file: Path, jobs: int = 1, environment: Mapping[str, str] | None = None) -> int:
    """Run the cases, with variables set in the environment, and report what differs from the baseline; 1 where anything does."""
    for line in baseline.machine_lines(baseline.load(file)):
        print(line)
    for name, value in (environment or {}).items():
        print(f"{name}={value}")
    different = 0
    for name, found, seconds in _run(cases, jobs, environment):
        lines = [f"FAILED, {found}"] if isinstance(found, str) else baseline.differences(file, name, found)
        different += bool(lines)
        print(f"{name}: {f'{len(lines)} DIFFER' if lines else 'the same'}, {seconds:.1f} s", flush=True)
        for line in lines:
            print(f"    {line}", flush=True)
    print(f"{different} of {len(cases)} scenes differ" if different else f"all {len(cases)} scenes are the same to the bit")
    return 1 if different else 0


def _run(cases: Mapping[str, Case], jobs: int, environment: Mapping[str, str] | None = None) -> Iterator[tuple[str, Arrays | str, float]]:
    """Name, results or the reason why there are none, and seconds of each case, in order."""

    def one(name: str) -> tuple[str, Arrays | str, float]:
        begin = time.perf_counter()
        try:
            found: Arrays | str = run_case(cases[name], environment)
        except RuntimeError as failure:
            found = str(failure)
        return name, found, time.perf_counter() - begin

    with ThreadPoolExecutor(jobs) as pool:
        yield from pool.map(one, cases)


if __name__ == "__main__":
    sys.exit(main())
