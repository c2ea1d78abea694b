r"""Hinges that pass to other joints: what blocks do where no factor of the load is borne.

Along a mechanism the line of thrust moves through the joints that are still closed. Where it leaves one, no forces bear the dead loads
under any factor, and by Farkas' lemma there is a motion of the blocks with

    w_0 . v > 0,      w_1 . v = 0:

the dead loads do work, the load does none. The blocks go that way by themselves while the load is held where it is, by a jack that keeps
its displacement: the joint opens that the thrust has left, and a hinge beside it closes. They come to rest where the hinge has closed, and
forces balance again: the hinge has passed. The motion is that of :func:`masonry_cd.limit.linear.least_unborne`, found anew after each step,
and a step ends where blocks meet. What they gain in speed on the way is taken for lost.

Where they find no rest, a part of the structure falls, however the load is held.
"""

from __future__ import annotations

from masonry_cd.limit.solution import Unbounded
from masonry_cd.limit.stage import Moved, Stage, Stages

FIRST = 0.01  # displacement of the fastest corner in the first step, as a share of the smallest width of a block
LONGEST = 0.25  # and in any step
FALLEN = 4.0  # displacement, as a share of the smallest width, after which blocks that have found no rest fall
MOST = 60  # steps
HALVINGS = 10  # of the step in which they come to rest
FALL = "beyond, no factor of the load is borne: blocks fall by themselves"
STUCK = "beyond, no factor of the load is borne, and the blocks that begin to fall lock: the mechanism cannot be followed"
UNSETTLED = f"beyond, no factor of the load is borne, and blocks that begin to fall find no rest in {MOST} steps"
SHORTEST = 1e-9  # step below which blocks cannot go on, as a share of the smallest width


def passed(make: Stages, moved: Moved) -> tuple[Stage | None, str]:
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
            return (rest if used < amount else _earliest(make, falling, used) or rest), ""
        gone += used
        if gone > FALLEN * width:
            return None, FALL
        amount = min(2.0 * amount, LONGEST * width)
    return None, UNSETTLED


def borne(make: Stages, moved: Moved) -> Stage | None:
    """The limit analysis of blocks where they are, None where no factor is borne."""
    try:
        return make.at(moved.assembly, moved.loads, moved.joints, moved.deepest)
    except Unbounded:
        return None


def _earliest(make: Stages, falling: Stage, used: float) -> Stage | None:
    """The first place of a step at which forces balance again, by halving."""
    moving, low, high, best = falling.motion(), 0.0, used, None
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        rest = borne(make, make.step(falling, moving, middle)[0])
        if rest is None:
            low = middle
        else:
            best, high = rest, middle
    return best
