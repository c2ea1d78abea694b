# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a capacity curve judged by rigid-block dynamics, which tests the curve.

Past its peak a structure cannot be held by a load, only caught between two: released from rest where the curve has brought its blocks, it
falls back under a factor below that of the curve, and goes on under one above. The two are brought together by halving. The dynamics knows
nothing of the curve's joints: it finds its contacts itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.capacity import CapacityCurve
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws

PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)  # points that are judged, as shares of the curve
WIDE = 0.08  # first factors tried, to either side, as a share of the first factor of the curve
CLOSE = 0.01  # share of it at which the two are close enough
STEP, STEPS = 2e-3, 150  # [s] of a release
MOST = 7  # factors tried to either side, so far apart
TOLERANCE = 1e-6  # natural map error of a step
SEEN = 1e-3  # share of the smallest width that the control block goes before it is said to move


@dataclass(frozen=True)
class Bracket:
    """Bracket of a point of a curve by the dynamics."""

    displacement: float  # of the control point [m]
    factor: float  # of the curve
    low: float  # largest factor found under which the structure falls back or stays; nan: none of those tried
    high: float  # least one found under which it goes on; nan: none of those tried
    missed: int  # steps on the way whose solution missed its tolerance


def brackets(curve: CapacityCurve, laws: JointLaws, direction: np.ndarray, gravity: np.ndarray) -> tuple[Bracket, ...]:
    """Judge some points of a curve under gravity (3,) [m/s2] and a body force along a direction (3,), on joints of some laws."""
    last = float(curve.displacement[-1])
    places = sorted({int(np.argmin(np.abs(curve.displacement - share * last))) for share in PLACES} - {0})
    return tuple(_Release(curve, k, laws, direction, gravity).bracket() for k in places)


class _Release:
    """Blocks released from rest at point k of a curve, again and again."""

    def __init__(self, curve: CapacityCurve, k: int, laws: JointLaws, direction: np.ndarray, gravity: np.ndarray) -> None:
        self.curve, self.k, self.laws, self.direction, self.gravity = curve, k, laws, direction, gravity
        self.missed = 0  # steps so far that missed their tolerance

    def bracket(self) -> Bracket:
        """Between a factor under which they fall back and one under which they go on."""
        factor, first = float(self.curve.factor[self.k]), abs(float(self.curve.factor[0]))
        tried = WIDE * first * np.arange(1.0, MOST + 1.0)
        low = next((below for below in factor - tried if not self.goes_on(below)), np.nan)
        high = next((above for above in factor + tried if self.goes_on(above)), np.nan)
        while high - low > CLOSE * first:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.goes_on(middle) else (middle, high)
        return Bracket(float(self.curve.displacement[self.k]), factor, float(low), float(high), self.missed)

    def goes_on(self, factor: float) -> bool:
        """Return True if they go on along the curve under a factor."""
        placed, control = replace(self.curve.stages[self.k].assembly, laws=self.laws), self.curve.control
        pull = np.tile(self.gravity + factor * math.hypot(*self.gravity) * self.direction, (STEPS + 1, 1))
        run = Run.model_validate({"dt": STEP, "duration": STEP * STEPS, "tolerance": TOLERANCE})
        machine = Stepper(placed, np.zeros((STEPS + 1, 1, 3)), pull, run)
        seen, gone = SEEN * placed.width, 0.0
        for _ in range(STEPS):
            self.missed += machine.step().error > TOLERANCE
            gone = float((machine.state.position[control.block] - placed.centre[control.block]) @ control.direction)
            if abs(gone) > seen:
                break
        return gone > seen
