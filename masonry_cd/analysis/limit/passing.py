# SPDX-License-Identifier: GPL-3.0-or-later
r"""Hinges that pass to other joints: what blocks do where no factor of the load is borne.

Along a mechanism the line of thrust moves through the joints that are still closed. Where it leaves one, no forces bear the dead loads
under any factor, and by Farkas' lemma there is a motion of the blocks with

    w_0 . v > 0,      w_1 . v = 0:

the dead loads do work, the load does none. The blocks go that way by themselves while the load is held where it is, by a jack that keeps
its displacement: the joint opens that the thrust has left, and a hinge next to it closes. They come to rest where the hinge has closed, and
forces balance again: the hinge has passed. The motion is that of :func:`masonry_cd.analysis.limit.programme.least_unborne`, found again
after each step, and a step ends where blocks meet. What they gain in speed on the way is taken for lost.

Where they find no rest, a part of the structure falls, however the load is held.
"""

from __future__ import annotations

from masonry_cd.analysis.limit.following import FollowedMotion
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.analysis.limit.stage import FIRST, LONGEST, SHORTEST, CurveStage, MovedBlocks, Stages

FALLEN = 4.0  # displacement, as a share of the smallest width, after which blocks that have found no rest fall
MOST = 60  # steps
HALVINGS = 12  # of a step in which a factor ceases to be borne, or begins to be
FALL = "beyond, no factor of the load is borne: blocks fall by themselves"
STUCK = "beyond, no factor of the load is borne, and the blocks that begin to fall lock: the mechanism cannot be followed"
UNSETTLED = f"beyond, no factor of the load is borne, and blocks that begin to fall find no rest in {MOST} steps"


def passed(make: Stages, moved: MovedBlocks) -> tuple[CurveStage | None, str]:
    """Where blocks come to rest that no factor of the load holds where they are; None where they do not, and why."""
    width = moved.assembly.width
    amount, gone = FIRST * width, 0.0
    for _ in range(MOST):
        falling = make.falling(moved)
        if not falling.mechanism.moving.any():
            return None, STUCK
        make.wear(falling)
        moving = falling.motion()
        moved, used = make.step(falling, moving, amount)
        if used < SHORTEST * width or moved.locked:
            return None, STUCK
        rest = borne(make, moved)
        if rest is not None:
            return (rest if used < amount else edge(make, falling, moving, used, borne_before=False)[0] or rest), ""
        gone += used
        if gone > FALLEN * width:
            return None, FALL
        amount = min(2.0 * amount, LONGEST * width)
    return None, UNSETTLED


def borne(make: Stages, moved: MovedBlocks) -> CurveStage | None:
    """The limit analysis of blocks where they are, None where no factor is borne."""
    try:
        return make.at(moved.assembly, moved.loads, moved.joints, moved.deepest)
    except Unbounded:
        return None


def edge(make: Stages, start: CurveStage, moving: FollowedMotion, reach: float, borne_before: bool) -> tuple[CurveStage | None, float]:
    """Where in a step a factor ceases to be borne, or begins to be, by halving.

    Args:
        make: the limit analyses.
        start: where the step begins.
        moving: its motion.
        reach: its length [m].
        borne_before: whether a factor is borne at its beginning and none at its end, or the other way round.

    Returns:
        The last analysis with a factor, None where there was none, and a length of the step at which there is none if one is borne before.
    """
    low, high, best = 0.0, reach, None
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        moved = make.step(start, moving, middle)[0]
        bears = make.bears(moved)
        best = moved if bears else best
        low, high = (middle, high) if bears == borne_before else (low, middle)
    return None if best is None else borne(make, best), high
