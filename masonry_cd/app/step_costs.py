r"""How long the rest of a run will take: what a step costs follows the shaking, so the intensity of the loads still to come counts.

The steps of the loads fall into classes by how strongly the base works about them: with a(t) the largest acceleration of a support, d(t)
the largest difference of their velocities, by which they move apart, and e(t) the maximum of either over the MEMORY before t, since blocks
go on rocking for a while,

    rest   e < 2 % of its peak,     weak   e < 25 %,     strong   the others,

of the two the stronger. A footing that sinks at an even speed shakes nothing, and yet its structure is on the move.

What a step of each class costs is measured as the run goes, late steps counting more than early ones. A class that has not come yet is
taken from the one next to it by the USUAL ratios.
"""

from __future__ import annotations

import numpy as np

MEMORY = 0.5  # [s]
BOUNDS = (0.02, 0.25)  # of weak and of strong shaking, as shares of the peak
USUAL = (1.0, 3.0, 6.0)  # cost of a step of each class, of one at rest
LATE = 0.1  # share of the run over which what a step cost is forgotten


def shaking_classes(support_velocity: np.ndarray, dt: float) -> np.ndarray:
    """The class of each step of the loads (N,): 0 rest, 1 weak, 2 strong; all at rest where no support moves.

    Args:
        support_velocity: (N + 1, S, 3) at the steps [m/s].
        dt: [s].
    """
    from scipy.ndimage import maximum_filter1d

    steps = len(support_velocity) - 1
    width = max(1, min(steps, round(MEMORY / dt)))
    found = np.zeros(steps, dtype=np.int8)
    for strength in (np.abs(np.diff(support_velocity, axis=0)), np.ptp(support_velocity[1:], axis=1, keepdims=True)):
        largest = strength.max(axis=(1, 2), initial=0.0)
        if largest.any():
            envelope = maximum_filter1d(largest, width, origin=(width - 1) // 2, mode="constant")
            found = np.maximum(found, np.searchsorted(BOUNDS, envelope / largest.max(), side="right").astype(np.int8))
    return found


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
        seen = np.flatnonzero(self._steps > 0.0)
        if not len(seen):
            return 0.0
        cost = np.divide(self._seconds, self._steps, out=np.zeros(len(USUAL)), where=self._steps > 0.0)
        for kind in range(len(USUAL)):
            near = int(seen[np.argmin(np.abs(seen - kind))])
            cost[kind] = cost[near] * USUAL[kind] / USUAL[near]
        return float(self._left @ cost)
