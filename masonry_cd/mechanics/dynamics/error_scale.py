# SPDX-License-Identifier: GPL-3.0-or-later
r"""The scale of the stopping test where single blocks take forces that they are far too light for.

The natural map error is a share of |q|, q = (H v_free + b) / sqrt(d) over all contacts. What it leaves at a contact is, in m/s,
error |q| sqrt(d_c) at most. A block of mass m under a force F would reach h F / m in a step, were it not held: with 100 kN on a loading
beam of 0.04 kg that is 5 km/s at h = 2 ms, |q| is what this block alone makes it, and an error of 1e-6 lets it slip at 5 mm/s.

So a block does not set the scale by a force that it is far too light for. Let a be the mean acceleration of the free blocks by gravity and
forces, weighted by their masses, and call a block overloaded if its own is more than OVERLOADED times that. On the C contacts of a problem
with d the largest of those on overloaded blocks, errors are divided by

    min( |q|,  AMPLE h a sqrt(C / d) ),

the norm that C contacts of blocks as light as that one would have, moving AMPLE times as fast as forces let the structure as a whole. What
is left at a contact is then error AMPLE h a sqrt(C) at most, whatever the mass of the block: as much as elsewhere. Scenes without forces on
single blocks, and those where no block stands out so, keep |q| and with it all their bits. The scale is never so small that a tolerance
would ask for less than ROUNDING of |q|, which no solver reaches.

Only the steps of a run are tested so. Problem files and ``solve`` have the published measure, see
``masonry_cd/mechanics/friction/problem.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.impacts import Solve, error_of
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.law_terms import error_norms
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution
from masonry_cd.mechanics.solvers.options import Options

OVERLOADED = 10.0  # times the mean acceleration; ties and floor loads on single blocks stay below some hundred, and are harmless
AMPLE = 10.0  # so that the scale changes only where a block stands out by orders of magnitude
ROUNDING = 1e-13  # natural map error below which rounding decides, as of ``auto``


@dataclass(frozen=True, eq=False)
class Overload:
    """The overloaded blocks of a step."""

    system: System
    v: np.ndarray  # (F, n) before the step
    blocks: np.ndarray  # (F,) bool
    speed: float  # h a [m/s]

    def share(self, problem: FrictionProblem, tolerance: float) -> float:
        """Return the divisor of errors, over |q|; 1 at most. A problem of impacts has blocks that other contacts hold already."""
        _, gained = self.system.speeds(problem.v_free - self.v)
        blocks = self.blocks & (gained > OVERLOADED * self.speed)
        on = (blocks[problem.bodies] & (problem.bodies >= 0)).any(axis=1)
        if not on.any():
            return 1.0
        given = problem.arrays()
        _, size = error_norms(given, np.zeros((problem.contacts, problem.dimension)))
        scale = AMPLE * self.speed * np.sqrt(problem.contacts / given.d[on].max())
        return max(scale / size, min(1.0, ROUNDING / tolerance)) if scale < size else 1.0


def find_overload(system: System, v: np.ndarray, predicted: Prediction) -> Overload | None:
    """The blocks that gravity and forces would give far more speed than the others, were they not held; None for none.

    ``v`` (F, n) are the velocities before the step.
    """
    if predicted.force_impulse is None:
        return None
    (centre, gained), mass = system.speeds(predicted.v_free - v), system.assembly.mass[system.free]
    mean = float(mass @ centre) / float(mass.sum())
    blocks = gained > OVERLOADED * mean
    return Overload(system, v, blocks, mean) if blocks.any() else None


def on_scale(overload: Overload | None, options: Options, solve: Callable[[FrictionProblem, Options, Solution, str], Solution]) -> Solve:
    """A solver with its options bound, whose solutions have errors on the scale of a step."""

    def solve_on_scale(problem: FrictionProblem, start: Solution, kind: str) -> Solution:
        share = 1.0 if overload is None else overload.share(problem, options.tolerance)
        if share == 1.0:
            return solve(problem, options, start, kind)
        own = replace(options, tolerance=share * options.tolerance, accept=share * options.accept)
        found = solve(problem, own, start, kind)
        error = error_of(problem, found)
        met = error <= own.tolerance  # on the one scale and so, whatever the rounding, on the other
        return replace(found, error=min(error / share, options.tolerance) if met else error / share)

    return solve_on_scale
