# SPDX-License-Identifier: GPL-3.0-or-later
r"""Memory against size: bytes per contact of a shaken structure, and whether they stay flat over its steps.

    python -m benchmarks.memory_per_contact
    python -m benchmarks.memory_per_contact church2380 wall24x12 --steps 100

Each scene is stepped in a process of its own, in space. Its memory is what is resident above what the process held when all kernels were
loaded and a small scene had been stepped: blocks, contacts, factors, what the methods keep, and what numba and numpy allocate for a while.
The first steps fill it, of buildings that slide the first few hundred, until each method has had its turn. Growth is that of the mean over
the last quarter of the steps against the second quarter.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.memory import resident_bytes
from benchmarks.ours import stepper, warm_up
from benchmarks.scenes import BenchScene, scene
from benchmarks.sitting import head, numbers_of, sitting

SCENES = ("wall24x12", "wall49x24", "wall97x49", "church2380", "church1290", "church615")  # 300, 1,200, 4,800; 540, 1,200, 4,900 blocks
TOLERANCE = 1e-3


@dataclass(frozen=True)
class Measured:
    """The memory of a scene."""

    scene: str
    blocks: int
    contacts: float  # mean over the steps
    program: float  # resident before the scene was built [B]
    resident: float  # above that, mean over the last quarter of the steps [B]
    peak: float  # above that, the largest so far of the whole process [B]
    growth: float  # of resident, last quarter against the second one; 0 where it is too small to be seen

    @property
    def per_contact(self) -> float:
        """Resident memory per contact [B]."""
        return self.resident / self.contacts


def measure(made: BenchScene, steps: int, threads: int = 1) -> Measured:
    """Step a scene and sample the memory after each step.

    Raises:
        ValueError: fewer than four steps.
    """
    if steps < 4:
        raise ValueError("steps: at least 4")
    warm_up("auto", TOLERANCE, {"planar": False, "threads": threads})
    program = resident_bytes()
    machine = stepper(made, steps, "auto", TOLERANCE, planar=False, threads=threads)
    contacts, resident = [], []
    for _ in range(steps):
        contacts.append(machine.step().contacts)
        resident.append(resident_bytes() - program)
    quarter = steps // 4
    early, late = float(np.mean(resident[quarter : 2 * quarter])), float(np.mean(resident[-quarter:]))
    blocks = int((~machine.assembly.fixed).sum())
    return Measured(
        made.name, blocks, float(np.mean(contacts)), program, late, _peak_bytes() - program, late / early - 1.0 if early else 0.0
    )


def _peak_bytes() -> int:
    """The most memory that was ever resident, from the kernel."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))


def line(found: Measured) -> str:
    """A line of the table."""
    cells = [found.scene, f"{found.blocks}", f"{found.contacts:.0f}", f"{1e-6 * found.program:.0f}", f"{1e-6 * found.resident:.1f}"]
    cells += [f"{1e-6 * found.peak:.1f}", f"{found.per_contact:.0f}", f"{100 * found.growth:+.1f} %"]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Bytes of memory per contact of shaken structures of several sizes.")
    parser.add_argument("scenes", nargs="*", default=SCENES, help=f"names of benchmarks/scenes.py; left out: {' '.join(SCENES)}")
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="measure one scene in this very process, as JSON")
    given = parser.parse_args()
    try:
        made = [scene(name) for name in given.scenes]
        if given.json:
            print(json.dumps(asdict(measure(made[0], given.steps, given.threads))))
            return
    except (ValueError, OSError) as wrong:
        parser.error(str(wrong))
    print(sitting(), "", head(
        "scene", "blocks", "contacts", "program [MB]", "scene [MB]", "peak [MB]", "bytes per contact", "growth over the steps"
    ), sep="\n", flush=True)  # fmt: skip
    options = ["--steps", str(given.steps), "--threads", str(given.threads)]
    for name in given.scenes:
        print(line(Measured(**numbers_of("benchmarks.memory_per_contact", [name, *options]))), flush=True)


if __name__ == "__main__":
    main()
