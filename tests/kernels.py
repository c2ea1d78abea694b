# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that the tests reach, compiled before them into their store by two processes: ``python -m kernels``.

Without it each process of the tests would compile the same ones at the same time. What is in the cache already is loaded, in seconds.
What is missing here is compiled by the first test that needs it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence

import numpy as np
import scenes
from scipy import sparse

from masonry_cd.app.warmup import SELDOM, SceneKind, compiling
from masonry_cd.mechanics.friction.problem import LocalProblem
from masonry_cd.mechanics.solvers import SOLVERS, Options

UNIFORM = {True: 3, False: 6}  # strains of a uniform block in a plane or in space
MESHED = 10  # unknowns of a meshed block beyond those of a rigid one; any number has the same kernels
SWEEPS = ("nlgs", "accelerated")  # solvers that blocks of all kinds meet in the tests
UNREACHED = Options(tolerance=1e-300, max_iterations=2)  # so that each solver turns to all that it has


def compiled(kind: SceneKind) -> None:
    """Have the kernels of a kind of scene compiled."""
    with compiling(kind):
        pass


def of_runs(planar: bool) -> None:
    """Compile the kernels of blocks rigid, of uniform strain and meshed, on joints without and with a law that goes by area."""
    for strained in (0, UNIFORM[planar], MESHED):
        for by_area in (False, True):
            compiled(SceneKind("auto", planar, by_area, stress=True, strained=strained))
    for solver in SOLVERS:
        compiled(SceneKind(solver, planar))
    for solver in (*SWEEPS, *(SELDOM if planar else ())):
        for strained in (UNIFORM[planar], MESHED):
            compiled(SceneKind(solver, planar, strained=strained))


def of_grains() -> None:
    """Spheres among blocks."""
    for by_area in (False, True):
        compiled(SceneKind("auto", False, by_area, spheres=True))


def of_problems_alone() -> None:
    """Problems that are given by W alone, and one without a joint."""
    flat = LocalProblem(sparse.identity(4, format="csr"), -np.ones((2, 2)), np.full(2, 0.5))
    for name in SOLVERS:
        for problem in (scenes.tower(2).to_local(), flat, scenes.apart()):
            SOLVERS[name](problem, UNREACHED, None)


JOBS = {"plane": lambda: of_runs(True), "space": lambda: (of_runs(False), of_grains(), of_problems_alone())}


def main(words: Sequence[str]) -> int:
    """Do one of the jobs, or have a process do each."""
    if words:
        JOBS[words[0]]()
        return 0
    processes = [subprocess.Popen([sys.executable, "-m", "kernels", job]) for job in JOBS]
    return max(process.wait() for process in processes)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
