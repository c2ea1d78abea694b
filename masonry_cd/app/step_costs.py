# SPDX-License-Identifier: GPL-3.0-or-later
r"""How long the rest of a run will take: what a step costs follows the motion of the base, so what is still to come of it counts.

The steps of the loads fall into classes by what the base does about them. With a(t) the acceleration that all supports share and d(t) the
largest difference of their velocities, by which they move apart, each at its largest over the MEMORY before t, since blocks go on rocking
for a while, as shares of their peaks:

    strong   a > 25 %,     weak   a > 2 %,     settling   d > 2 %, where nothing shakes,     rest and after   the others,

before any of these and later. A footing that sinks shakes nothing, and yet its structure is on the move; and a structure that has cracked
costs more than one that has not, at rest too.

What a step of each class costs is measured as the run goes, late steps counting more than early ones. It is trusted as far as there are
steps of the class: DOUBT more count as the USUAL ratios would have them, of what all steps so far cost. So neither a class that is still to
come nor the first few steps of one, in which a structure takes up its load anew, throws the estimate.
"""

from __future__ import annotations

import numpy as np

MEMORY = 0.5  # [s]
BOUNDS = (0.02, 0.25)  # of weak and of strong shaking, as shares of the peak
REST, WEAK, STRONG, SETTLING, AFTER = range(5)
USUAL = np.array([1.0, 3.0, 6.0, 2.3, 3.0])  # cost of a step of each class, of one at rest
DOUBT = 20.0  # steps
LATE = 0.2  # share of the run over which what a step cost is forgotten


def motion_classes(support_velocity: np.ndarray, dt: float) -> np.ndarray:
    """The class of each step of the loads (N,); all at rest where no support moves.

    Args:
        support_velocity: (N + 1, S, 3) at the steps [m/s].
        dt: [s].
    """
    steps = len(support_velocity) - 1
    acceleration = np.diff(support_velocity, axis=0)
    low, high = (extreme(acceleration, axis=1, initial=edge) for extreme, edge in ((np.min, np.inf), (np.max, -np.inf)))
    shared = np.where(low > 0.0, low, np.where(high < 0.0, high, 0.0)) if support_velocity.shape[1] else np.zeros((steps, 3))
    apart = np.ptp(support_velocity[1:], axis=1) if support_velocity.shape[1] else np.zeros((steps, 3))
    found = np.searchsorted(BOUNDS, _envelope(shared, dt), side="right").astype(np.int8)
    found[(found == REST) & (_envelope(apart, dt) > BOUNDS[0])] = SETTLING
    found[(found == REST) & (np.maximum.accumulate(found) > REST)] = AFTER
    return found


def _envelope(motion: np.ndarray, dt: float) -> np.ndarray:
    """Of motions (N, 3), the largest component over the MEMORY before each step, as a share of the peak (N,); 0 of none."""
    largest = np.abs(motion).max(axis=1, initial=0.0)
    if not largest.any():
        return largest
    width = max(1, min(len(motion), round(MEMORY / dt)))
    return largest_before(largest, width) / largest.max()


def largest_before(values: np.ndarray, width: int) -> np.ndarray:
    """Of values (N,), none below zero, the largest of each and the width - 1 before it (N,).

    Each window is the end of one block of that width and the beginning of the next (van Herk, Pattern Recogn. Lett. 13, 1992).
    """
    padded = np.concatenate([np.zeros(width - 1), values, np.zeros(-(len(values) + width - 1) % width)])
    blocks = padded.reshape(-1, width)
    from_begin = np.maximum.accumulate(blocks, axis=1).reshape(-1)
    to_end = np.maximum.accumulate(blocks[:, ::-1], axis=1)[:, ::-1].reshape(-1)
    count = len(values)
    return np.maximum(to_end[:count], from_begin[width - 1 : width - 1 + count])


class StepCosts:
    """Measures what steps cost, and tells what is left.

    Args:
        classes: (N,) of each step of the loads.
        adaptive: whether a step of the run may be several of the loads, whose cost they share.
    """

    def __init__(self, classes: np.ndarray, adaptive: bool = False) -> None:
        self._classes, self._adaptive = classes, adaptive
        self._left = np.bincount(classes, minlength=len(USUAL)).astype(float)
        self._seconds, self._steps = np.zeros(len(USUAL)), np.zeros(len(USUAL))
        self._keep = 1.0 - 1.0 / max(1.0, LATE * len(classes))
        self._done = 0

    def add(self, done: int, seconds: float) -> None:
        """Take in that the steps up to a number took some more seconds; steps that the loads jump over cost nothing."""
        done = min(done, len(self._classes))
        if done <= self._done:
            return
        kind, made = int(self._classes[self._done]), float(done - self._done) if self._adaptive else 1.0
        self._left -= np.bincount(self._classes[self._done : done], minlength=len(USUAL))
        self._seconds[kind] = self._keep * self._seconds[kind] + seconds
        self._steps[kind] = self._keep * self._steps[kind] + made
        self._done = done

    def seconds_left(self) -> float:
        """For the steps that are still to come [s]; 0 before the first."""
        if not self._steps.any():
            return 0.0
        at_rest = self._seconds.sum() / (self._steps @ USUAL)
        cost = (self._seconds + DOUBT * at_rest * USUAL) / (self._steps + DOUBT)
        return float(self._left @ cost)
