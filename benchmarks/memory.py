# SPDX-License-Identifier: GPL-3.0-or-later
r"""Memory over a long run, which must stay flat.

    python -m benchmarks.memory wall10x10 --steps 20000

A whole run, result file included, in a temporary folder. Ten times on the way the resident memory of the process and the memory
that Python and numpy hold (tracemalloc) are written down, each time with the writer's buffers just emptied; growth is that of the last
against the second, when all of them have been filled once. Exit code 1 when either grew by more than `--allowed`, 5 % when not given.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import tracemalloc
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.ours import stepper
from benchmarks.scenes import BenchScene, scene
from benchmarks.sitting import head
from masonry_cd.app.recorder import ROWS_AT_ONCE
from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.contact.find_joints import find_joints

SAMPLES = 10


@dataclass
class Memory:
    """Samples of memory over a run."""

    steps: list[int] = field(default_factory=list)
    resident: list[float] = field(default_factory=list)  # of the process [MB]
    held: list[float] = field(default_factory=list)  # by Python and numpy [MB]

    def sample(self, step: int) -> None:
        """Take one."""
        self.steps.append(step)
        self.resident.append(resident_bytes() / 1e6)
        self.held.append(tracemalloc.get_traced_memory()[0] / 1e6)

    def growth(self) -> tuple[float, float]:
        """Growth of resident and held memory, last sample against the second."""
        return self.resident[-1] / self.resident[1] - 1.0, self.held[-1] / self.held[1] - 1.0


def resident_bytes() -> int:
    """Resident memory of this process, from the kernel."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def measure(made: BenchScene, steps: int) -> Memory:
    """Run a scene with its results written, and sample the memory."""
    out, every = Memory(), max(1, steps // SAMPLES // ROWS_AT_ONCE) * ROWS_AT_ONCE

    def progress(step: int) -> None:
        if step % every == 0:
            writer.flush()
            out.sample(step)

    machine = stepper(made, steps)
    joints = find_joints(machine.assembly)
    tracemalloc.start()
    with tempfile.TemporaryDirectory() as folder, ResultWriter(Path(folder) / "result.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, RunPlan(steps, 20), progress)
    tracemalloc.stop()
    return out


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Whether memory stays flat in a long run.")
    parser.add_argument("scene", nargs="?", default="wall10x10")
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--allowed", type=float, default=0.05, help="growth")
    given = parser.parse_args()
    try:
        memory = measure(scene(given.scene), given.steps)
    except (ValueError, OSError) as wrong:
        parser.error(str(wrong))
    print(head("steps", "resident [MB]", "Python and numpy [MB]"))
    for step, resident, held in zip(memory.steps, memory.resident, memory.held, strict=True):
        print(f"| {step} | {resident:.1f} | {held:.3f} |")
    growth = memory.growth()
    print(f"\ngrowth {100 * growth[0]:.1f} % and {100 * growth[1]:.1f} %")
    parser.exit(int(max(growth) > given.allowed))


if __name__ == "__main__":
    main()
