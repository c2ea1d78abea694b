# SPDX-License-Identifier: GPL-3.0-or-later
r"""The load factor that a structure carries while a load grows, from the motion of its run: the capacity curve of the dynamics.

Of the work of the load, what does not become kinetic energy K is carried: lifted weight, friction, elastic joints. With X the work of the
load for a factor of one,

    lambda_c dX = lambda dX - dK.

While the structure stands, however soft its joints, lambda_c is the factor applied. Once it gives way the load drives blocks instead, and
lambda_c is the factor that they still bear on their way. The structure has given way where no later lambda_c reaches the factor applied;
the largest one is the factor it bore, however fast the load grew meanwhile. Slopes are taken between frames some way apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

BALANCED = 0.03  # share of the factor by which what is carried may stay behind it, while a structure stands
WAY = 0.5  # between two frames of a slope, as a share of the displacement from which blocks count as moved
FARTHER = 0.3  # and as a share of the displacement: over less, what swings hides what grows
FAR = 50.0  # times that displacement: beyond it blocks fall, and what they hit says nothing of what the structure bore


@dataclass(frozen=True)
class CarriedFactor:
    """The largest factor that was carried."""

    factor: float
    frame: int  # at the end of its slope


def largest_carried(
    displacement: np.ndarray, work: np.ndarray, factor: np.ndarray, kinetic: np.ndarray, moved: float
) -> CarriedFactor | None:
    """The largest factor that a structure carried before it gave way, None where it still carries what is applied.

    Args:
        displacement: (F,) largest of a block in each frame [m].
        work: (F,) X, of the load for a factor of one [J].
        factor: (F,) applied.
        kinetic: (F,) K [J].
        moved: displacement from which blocks count as moved [m].
    """
    marks = _marks(displacement, WAY * moved, FAR * moved)
    if len(marks) < 2 or displacement[marks[-1]] <= moved:
        return None
    done = np.concatenate([[0.0], np.cumsum(0.5 * (factor[1:] + factor[:-1]) * np.diff(work))])[marks]
    along = np.diff(work[marks])
    driven = along > 0.0
    carried = np.full(len(along), -np.inf)
    carried[driven] = (np.diff(done) - np.diff(kinetic[marks]))[driven] / along[driven]
    applied = np.diff(done) / np.where(driven, along, np.inf)
    balanced = np.flatnonzero(driven & (carried >= (1.0 - BALANCED) * applied))
    last = int(balanced[-1]) if len(balanced) else -1
    if last == len(along) - 1 or not driven.any():
        return None
    borne = np.minimum(carried, applied)  # a structure that swings back bears no more than is applied
    best = int(np.argmax(borne))
    return CarriedFactor(float(borne[best]), int(marks[best + 1]))


def _marks(displacement: np.ndarray, way: float, far: float) -> np.ndarray:
    """Frames each of which is farther than the last by a way and a share, up to the first beyond ``far``."""
    out = [0]
    for frame, at in enumerate(displacement):
        last = displacement[out[-1]]
        if at >= last + max(way, FARTHER * last):
            out.append(frame)
        if at > far:
            break
    return np.array(out)
