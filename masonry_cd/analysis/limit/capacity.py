# SPDX-License-Identifier: GPL-3.0-or-later
r"""Capacity curves: a mechanism followed at finite displacements, and the load factor that the moved structure still bears.

At each step the blocks are where the last mechanism has brought them, their joints are found again
(:mod:`masonry_cd.analysis.limit.moved`), and a limit analysis of this geometry gives the factor and the mechanism that goes on
(:mod:`masonry_cd.analysis.limit.following`), which may be another. Where no factor is borne, hinges pass to other joints
(:mod:`masonry_cd.analysis.limit.passing`). The factor is drawn over the displacement of a control block along the load, until it vanishes.

**Flow.** Where joints slide, the factor and the mechanism are those of sliding without dilation (a descent of
:mod:`masonry_cd.analysis.limit.search` from the associated mechanism), when ``starts`` asks for it; otherwise the factor is the
associated one, an upper bound, and the mechanism is followed without the dilation that its flow rule adds: blocks slide and do not climb.

**Bond** is lost in joints that have hinged, slid or opened. **Ties** pull as they are then directed, those that yielded are longer for
good, and those that have become shorter pull nothing until they are as long again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from masonry_cd.analysis.limit.analysis import STANDS, LimitOptions, at_rest
from masonry_cd.analysis.limit.following import FollowedMotion
from masonry_cd.analysis.limit.mechanism import STILL
from masonry_cd.analysis.limit.passing import borne, edge, passed
from masonry_cd.analysis.limit.problem import BlockLoads
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.analysis.limit.stage import FIRST, LONGEST, SHORTEST, CurveStage, Stages
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import at_start_only
from masonry_cd.mechanics.model.joints import Joints

STEPS = 40  # from start to end, about
MOST = 6  # times the number of steps at most
STALLED, WAY = 10, 0.05  # steps on which no block goes as far as this share of the farthest way before: the curve makes no way
PASSING = 1e-4  # step, as a share of the smallest width, on which a factor that rises makes the stage before it one of no rest ...
RISES = 1e-3  # ... where it rises by more than this share
MORE = 4.0  # times as far as the last step went, at most
LEAST = 1e-3  # displacement of the fastest corner that a step tries, as a share of the smallest width
VANISHES = "the factor vanishes"
BELOW = "the factor falls below zero at once, where the mechanism changes"
FALLS = (VANISHES, BELOW)
GONE = 1e-6  # share of the first factor at which it has vanished
ROUNDING = 1e-5  # share below which it is shown as zero
ALIKE = 0.02  # share of the last displacement below which two points look alike
BEYOND = 1.05  # of what is left, so that the last step goes past the end
TRIES = 30  # to find where it does


@dataclass(frozen=True)
class CurveOptions:
    """Options of a capacity curve: the point to follow, and how finely."""

    analysis: LimitOptions = field(default_factory=LimitOptions)
    steps: int = STEPS
    control: int | None = None  # block; None: whose centre moves fastest along the load when the mechanism begins
    limit: float = np.inf  # control displacement at which to stop [m]
    mechanism: np.ndarray | None = None  # (B, 6) velocities of a mechanism without dilation that is followed; None: what is found


@dataclass(frozen=True, eq=False)
class Control:
    """The centre of mass of a block, and the direction in which its displacement counts."""

    block: int
    point: np.ndarray  # (3,) as built [m]
    direction: np.ndarray  # (3,) unit


@dataclass(frozen=True, eq=False)
class CapacityCurve:
    """Factor against displacement at K points."""

    control: Control
    displacement: np.ndarray  # (K,) of the control point along its direction [m]
    factor: np.ndarray  # (K,)
    stages: tuple[CurveStage, ...]  # K
    changes: tuple[int, ...]  # points at which other joints are at work than before
    jumps: tuple[int, ...]  # points to which blocks went by themselves, the load's displacement held
    falls: bool  # at the last point the factor vanishes
    end: str  # why the curve ends, as text
    remarks: tuple[str, ...]
    seconds: float

    @property
    def ultimate(self) -> float | None:
        """Displacement at which the factor vanishes [m], None where the curve ends before."""
        return float(self.displacement[-1]) if self.falls else None

    @property
    def peak(self) -> int:
        """The point of the largest factor."""
        return int(np.argmax(self.factor))

    @property
    def marks(self) -> tuple[int, ...]:
        """Points whose mechanism is worth a look: the first, the peak, half the way, the last."""
        half, last = int(np.argmin(np.abs(self.displacement - 0.5 * self.displacement[-1]))), len(self.factor) - 1
        near = ALIKE * abs(float(self.displacement[-1]))
        seen = [k for k in (self.peak, half) if near < self.displacement[k] < self.displacement[-1] - near]
        return tuple(sorted({0, *seen, last}))

    def shown_factor(self, k: int) -> float:
        """The factor of a point as it is shown: zero where it has vanished but for rounding."""
        return 0.0 if abs(self.factor[k]) < ROUNDING * abs(self.factor[0]) else float(self.factor[k])


def capacity_curve(assembly: Assembly, joints: Joints, loads: BlockLoads, options: CurveOptions | None = None) -> CapacityCurve:
    """Follow the mechanism of a structure until its load factor vanishes.

    Args:
        assembly: the blocks as built.
        joints: of them.
        loads: forces that keep their directions; point loads go with their blocks where ``arms`` says where they act.
        options: how.

    Raises:
        InputError: as of :func:`masonry_cd.analysis.limit.analysis.analyse`; a structure that does not stand; supports that move.
    """
    options = options or CurveOptions()
    if loads.support_velocity is not None:
        raise InputError("limit.curve", "supports that move have no load factor to follow; push, tilt or live loads have")
    if reason := at_start_only(assembly.laws):
        raise InputError("limit.curve", f"{reason}; their load factor is known at the start only")
    if at_rest(assembly, joints, loads)[1].factor < 1.0 - STANDS:
        raise InputError("limit.curve", "the structure does not stand under its dead loads: there is no factor to follow")
    return _Path(assembly, joints, loads, options).followed()


class _Path:
    """A curve while it is followed."""

    def __init__(self, assembly: Assembly, joints: Joints, loads: BlockLoads, options: CurveOptions) -> None:
        self.begin, self.options, self.width = time.perf_counter(), options, assembly.width
        self.make = Stages(assembly, joints, loads, options.analysis, options.mechanism)
        try:
            first = self.make.at(assembly, loads, joints)
        except Unbounded as failure:
            raise InputError("limit", f"no answer: {failure}") from None
        self.stages, self.jumps, self.tried = [first], list[int](), 0
        self.make.accept(first)
        self.control = self._control(first)

    def followed(self) -> CapacityCurve:
        """The curve."""
        amount, end = FIRST * self.width, ""
        while not end:
            self.tried += 1
            last = self.stages[-1]
            found, used, end = self._next(last, amount)
            if found is None:
                break
            if self._passes(last, found, used):
                self.stages.pop()
            self.stages.append(found)
            self.make.accept(found)
            end = end or self._enough(found)
            amount = self._amount(last, found, used, amount)
        displacement = np.array([self.displacement(stage) for stage in self.stages])
        work = [stage.at_work() for stage in self.stages]
        return CapacityCurve(
            control=self.control,
            displacement=displacement,
            factor=np.array([stage.factor for stage in self.stages]),
            stages=tuple(self.stages),
            changes=tuple(k for k in range(1, len(work)) if work[k] != work[k - 1] and work[k]),
            jumps=tuple(self.jumps),
            falls=end in FALLS,
            end=end,
            remarks=self._remarks(),
            seconds=time.perf_counter() - self.begin,
        )

    def _passes(self, last: CurveStage, found: CurveStage, used: float) -> bool:
        """Return True if a stage is left at once for one that bears more: contacts that had parted close again."""
        first = len(self.stages) == 1 or len(self.stages) - 1 in self.jumps
        return not first and used <= PASSING * self.width and found.factor > (1.0 + RISES) * last.factor

    def displacement(self, stage: CurveStage) -> float:
        """Return the displacement of the control point [m]."""
        return float((stage.assembly.centre[self.control.block] - self.control.point) @ self.control.direction)

    def _next(self, last: CurveStage, amount: float) -> tuple[CurveStage | None, float, str]:
        """The stage a step later, how far the fastest corner goes to it [m], and why the curve ends there, if it does."""
        self.make.wear(last)
        moving = last.motion()
        moved, used = self.make.step(last, moving, amount)
        if used < SHORTEST * self.width or moved.locked:
            return None, 0.0, "the mechanism locks: its blocks cannot slide on without climbing" if moved.locked else "blocks meet"
        found = borne(self.make, moved)
        if found is None:
            return self._passed(last, moving, used)
        gone = GONE * abs(self.stages[0].factor)
        if found.factor > gone:
            return found, used, ""
        low, high, best = 0.0, used, found
        below, above = last.factor, found.factor
        for k in range(TRIES):
            share = below / (below - above) if k % 3 else 0.5
            middle = low + min(max(share, 0.02), 0.98) * (high - low)
            moved, _ = self.make.step(last, moving, middle)
            tried = borne(self.make, moved)
            if tried is None:
                high = middle
                continue
            best = tried
            if abs(best.factor) <= gone:
                return best, middle, VANISHES
            if best.factor > 0.0:
                low, below = middle, best.factor
            else:
                high, above = middle, best.factor
        return best, high, BELOW

    def _passed(self, last: CurveStage, moving: FollowedMotion, used: float) -> tuple[CurveStage | None, float, str]:
        """Where no factor is borne a step later: the last stage before, by halving, and the one after hinges have passed on."""
        best, high = edge(self.make, last, moving, used, borne_before=True)
        if best is not None:
            self.stages.append(best)
            self.make.accept(best)
        found, end = passed(self.make, self.make.step(last, moving, high)[0])
        if found is not None:
            self.jumps.append(len(self.stages))
            end = BELOW if found.factor <= 0.0 else ""
        return found, high, end

    def _enough(self, found: CurveStage) -> str:
        """Why the curve ends though the factor has not vanished, if it does."""
        if self.displacement(found) >= self.options.limit:
            return f"the control displacement of {length(self.options.limit)} is reached"
        if len(self.stages) > STALLED and self._farthest(-1 - STALLED, -1) < WAY * self._farthest(0, -1 - STALLED):
            return f"in {STALLED} steps no block went more than {WAY:.0%} farther: blocks meet at every step"
        if max(len(self.stages), self.tried) > MOST * self.options.steps:  # stages that are left at once count as well
            return f"{MOST * self.options.steps} steps are made, and the factor has not vanished"
        return ""

    def _farthest(self, first: int, last: int) -> float:
        """How far any block has gone from one stage to another [m]."""
        gone = self.stages[last].assembly.centre - self.stages[first].assembly.centre
        return float(np.linalg.norm(gone, axis=1).max())

    def _amount(self, last: CurveStage, found: CurveStage, used: float, amount: float) -> float:
        """The next step [m], so that about as many are made as asked."""
        amount = max(min(amount, MORE * used), LEAST * self.width)  # where blocks met, they soon meet again
        slope = (found.factor - last.factor) / used
        left = max(self.options.steps - len(self.stages), 1)
        wanted = 2.0 * amount if slope >= 0.0 else BEYOND * found.factor / (-slope * left)
        wanted = float(np.clip(wanted, 0.5 * amount, min(2.0 * amount, LONGEST * self.width)))
        gone = (self.displacement(found) - self.displacement(last)) / used  # of the control point, by way of the fastest corner
        return min(wanted, BEYOND * (self.options.limit - self.displacement(found)) / gone) if gone > 0.0 else wanted

    def _remarks(self) -> tuple[str, ...]:
        """List the ends that were not reached on the way."""
        out = []
        if self.make.unsettled:
            where = f"in {self.make.unsettled} limit analyses on the way"
            out.append(f"sliding without dilation did not converge {where}: the associated factor is given there")
        slid = any(stage.mechanism.sliding.max(initial=0.0) > STILL for stage in self.stages)
        if slid and not self.options.analysis.starts:
            out.append("joints slide: the curve has the associated factor (upper bound); limit.starts = 1 follows the one without dilation")
        if self.make.uncorrected:
            out.append(f"no correction was found for {self.make.uncorrected} of the steps tried: there blocks go as the mechanism begins")
        if self.make.stopped:
            out.append(f"the solver stopped before it met its tolerance in {self.make.stopped} limit analyses on the way")
        return tuple(out)

    def _control(self, first: CurveStage) -> Control:
        """The requested block, or the one that moves fastest along the load."""
        live = first.loads.live[:, :3].sum(axis=0)
        velocity = first.mechanism.velocity[:, :3]
        size = float(np.linalg.norm(live))
        if size <= 1e-9 * float(np.abs(first.loads.live[:, :3]).sum()):
            live, size = velocity[int(np.argmax(np.linalg.norm(velocity, axis=1)))], 1.0
        direction = live / np.linalg.norm(live)
        block = self.options.control
        if block is None:
            along = velocity @ direction
            near = np.flatnonzero(along >= (1.0 - 1e-6) * along.max())
            block = int(near[np.argmax(first.assembly.centre[near, 2])])
        if first.assembly.fixed[block]:
            raise InputError("limit.curve.control", f'block "{first.assembly.names[block]}" is a support: it does not move')
        return Control(block, first.assembly.centre[block].copy(), direction)
