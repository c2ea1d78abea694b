# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of a solve, the same for every solver."""

from __future__ import annotations

import os
from dataclasses import dataclass

MOST_ITERATIONS = 10**9  # kernels count in 64 bits, and tens of them per iteration
LARGEST_SEED = 2**63 - 1
# Contacts in space and in a plane that keep a thread busy (benchmarks.threads). With fewer, the methods that linearise the law gain little
# on free cores and lose on shared ones: their threads meet twenty times an iteration.
THREAD_WORTH = {3: 3_500, 2: 10_500}


@dataclass(frozen=True)
class Options:
    """Options of one solve.

    Attributes:
        tolerance: natural map error (scaled, see ``masonry_cd.mechanics.friction.problem``) at which to stop.
        accept: natural map error with which ``auto`` leaves packed grains after their sweeps; 0: none above the tolerance.
        max_iterations: None takes the solver's own limit.
        seed: of the random sweep order.
        threads: at most, of the solvers that can use more than one.
    """

    tolerance: float = 1e-8
    max_iterations: int | None = None
    seed: int = 0
    threads: int = 1
    accept: float = 0.0

    def limit(self, own: int) -> int:
        """Iterations at most, of a solver whose own limit is given."""
        return own if self.max_iterations is None else self.max_iterations

    def reason(self, name: str, error: float, end: str = "stopped") -> str:
        """Say how a solver ended, by the error that it leaves."""
        return f"{name}: converged" if error <= self.tolerance else f"{name}: {end} at an error of {error:.1e}"


def cores() -> int:
    """Cores that this process may use: more threads than these would only wait for one another."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def threads_that_pay(asked: int | None, contacts: int, dimension: int) -> int:
    """Threads for a given number of contacts of dimension 2 or 3: as many as requested, and no more than there are cores.

    By default it is one for each THREAD_WORTH of the contacts, within OMP_NUM_THREADS, by which clusters share out their cores.
    """
    if asked is not None:
        return min(asked, cores()) if asked > 1 else asked  # the number of cores is read only where it matters, twice a step
    wanted = contacts // THREAD_WORTH[dimension]
    if wanted <= 1:
        return 1
    allowed = os.environ.get("OMP_NUM_THREADS", "")
    most = min(cores(), int(allowed)) if allowed.isdecimal() else cores()
    return max(1, min(wanted, most))
