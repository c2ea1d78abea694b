# SPDX-License-Identifier: GPL-3.0-or-later
"""Compilation by numba, and the processor's seconds that each kernel takes: of the first run of a scene, or of the kernels of the tests.

    python -m benchmarks.compiling examples/aqueduct_sinusoidal.toml
    python -m benchmarks.compiling examples/church_sine.toml --set run.duration=0.1 --by type --rows 60
    python -m benchmarks.compiling --tests

Everything is compiled into an empty folder, by one process on one core, so that nothing is compiled twice. A row is a kernel, or with
``--by type`` one specialisation of it; its seconds are without those of kernels that are compiled for it meanwhile. Entries are compiled
twice: as Python calls them, field by field, and as other kernels do.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import defaultdict
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from numba.core import event

import masonry_cd as mc
from benchmarks.sitting import HERE, head
from masonry_cd.foundation.kernel_store import FOLDER


class Clock(event.Listener):
    """Seconds of the processor by kernel and types of its arguments, as numba compiles them."""

    def __init__(self) -> None:
        self.seconds = defaultdict[tuple[str, str], list[float]](list)
        self._open = list[list[float]]()  # of the compilations that wait for others: their begin, and what the others took

    def on_start(self, found: event.Event) -> None:
        self._open.append([time.process_time(), 0.0])

    def on_end(self, found: event.Event) -> None:
        begin, others = self._open.pop()
        took = time.process_time() - begin
        if self._open:
            self._open[-1][1] += took
        function = found.data["dispatcher"].py_func
        kinds = ", ".join(map(str, found.data["args"]))
        self.seconds[f"{function.__module__}.{function.__qualname__}", kinds].append(took - others)


def table(clock: Clock, by_type: bool, rows: int) -> str:
    """The compilations that took most, and what all took together."""
    grouped = defaultdict[tuple[str, ...], list[float]](list)
    for (name, kinds), took in clock.seconds.items():
        grouped[(name, kinds) if by_type else (name,)] += took
    found = sorted(grouped.items(), key=lambda item: -sum(item[1]))
    lines = [head("kernel", *(["types"] if by_type else []), "times compiled", "s")]
    lines += [f"| {' | '.join(names)} | {len(took)} | {sum(took):.2f} |" for names, took in found[:rows]]
    left = [second for _, took in found[rows:] for second in took]
    total = [second for _, took in found for second in took]
    lines += [f"| {len(found[rows:])} more |{' |' if by_type else ''} {len(left)} | {sum(left):.2f} |"]
    lines += [f"| together |{' |' if by_type else ''} {len(total)} | {sum(total):.2f} |"]
    return "\n".join(lines)


def main(words: Sequence[str] | None = None) -> int:
    """Compile into an empty folder, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="*", type=Path)
    parser.add_argument("--set", action="append", default=[], dest="changes", metavar="KEY=VALUE")
    parser.add_argument("--tests", action="store_true", help="the kernels that the tests reach")
    parser.add_argument("--by", choices=("kernel", "type"), default="kernel")
    parser.add_argument("--rows", type=int, default=40)
    asked = parser.parse_args(words)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # so that no second process helps
    clock = Clock()
    with ExitStack() as during:
        folder = Path(during.enter_context(TemporaryDirectory()))
        during.enter_context(patch.dict(os.environ, {FOLDER: str(folder / "kernels")}))
        during.enter_context(event.install_listener("numba:compile", clock))
        begin = time.process_time()
        if asked.tests:
            sys.path.insert(0, str(HERE.parent / "tests"))
            import kernels

            for job in kernels.JOBS.values():
                job()
        for file in asked.scene:
            mc.run(mc.scene(file, *asked.changes), folder / file.stem)
        took = time.process_time() - begin
    print(table(clock, asked.by == "type", asked.rows))
    print(f"\n{took:.1f} s of the processor in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
