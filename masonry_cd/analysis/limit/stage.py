# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage of a mechanism that is followed: the blocks where they are, and the limit analysis of them there."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.analysis import CAP, Collapse, LimitOptions, NoFiniteFactor, collapse_of, largest_factor
from masonry_cd.analysis.limit.descent import normal_forces
from masonry_cd.analysis.limit.following import LOCKED, FollowedMotion, motion
from masonry_cd.analysis.limit.interfaces import interfaces
from masonry_cd.analysis.limit.mechanism import STATES, STILL, Mechanism, mechanism
from masonry_cd.analysis.limit.moved import moved_joints, touching_gap
from masonry_cd.analysis.limit.problem import Bars, BlockLoads, LimitProblem, plane_of, problem_at
from masonry_cd.analysis.limit.programme import largest, least_unborne
from masonry_cd.analysis.limit.search import close_to, ends_of, least_factor
from masonry_cd.analysis.limit.solution import Optimum, Unbounded
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

HELD = 5.0  # load factor at which a mechanism that is followed counts as held where it may dilate
FIRST = 0.01  # displacement of the fastest corner in a first step, as a share of the smallest width of a block
LONGEST = 0.25  # and in any step
SHORTEST = 1e-9  # and the one below which blocks cannot go on
SLACK = 1e-9  # share of its length by which a tie may be shorter and still pull
UNSEEN = 1e-4  # width of a contact, as a share of the smallest width of a block, below which the detection of contacts finds none
CLOSE = 1e-3  # share of the gap of points that touch below which an overlap is rounding
HALVINGS = 40  # of a step in which blocks meet, at most
FAR_ENOUGH = 0.5  # share of the way to where they overlap that a step goes at least


@dataclass(frozen=True, eq=False)
class CurveStage:
    """A point of the curve: the blocks where they are, their joints there, and the mechanism that goes on."""

    assembly: Assembly
    loads: BlockLoads
    pulling: np.ndarray  # (T,) ties that are not slack
    joints: Joints
    problem: LimitProblem
    best: Optimum
    mechanism: Mechanism
    associated: float  # factor; that of ``best`` where no joint slides
    deepest: float  # overlap of any two blocks [m]

    @property
    def factor(self) -> float:
        """The factor followed."""
        return self.best.factor

    def collapse(self) -> Collapse:
        """The mechanism with its forces."""
        return collapse_of(self.problem, self.best, self.mechanism, self.joints.count)

    def at_work(self) -> frozenset[tuple[int, int, str]]:
        """Joints that bear and hinge or slide, by their two blocks."""
        made, joints = self.collapse(), self.joints
        working = np.flatnonzero((self.mechanism.state > 0) & (self.mechanism.state < 4) & np.isfinite(made.force_point[:, 0]))
        return frozenset((int(joints.block_a[j]), int(joints.block_b[j]), STATES[self.mechanism.state[j]]) for j in working)

    def motion(self) -> FollowedMotion:
        """How the mechanism moves the blocks."""
        return motion(self.problem, self.assembly, self.best, self.mechanism.velocity, _only(self.loads.bars, self.pulling))


@dataclass(frozen=True, eq=False)
class MovedBlocks:
    """Blocks a step after a stage, before their limit analysis."""

    assembly: Assembly
    loads: BlockLoads
    joints: Joints
    deepest: float  # overlap of any two blocks [m]
    locked: bool  # what is kept leaves them where they were


class Stages:
    """Makes the stages of one structure, and remembers what their joints and ties have lost on the way."""

    def __init__(
        self, assembly: Assembly, joints: Joints, loads: BlockLoads, options: LimitOptions, mechanism: np.ndarray | None = None
    ) -> None:
        self.options, self.axis, self.gap = options, plane_of(assembly, loads), touching_gap(assembly)
        self._bonded = {(int(a), int(b)) for a, b in zip(joints.block_a, joints.block_b, strict=True)}
        self._rest = _lengths(loads.bars)
        self._follows = None if mechanism is None else (assembly.centre, mechanism)  # where blocks had these velocities (B, 6)
        self._slid: dict[frozenset[int], float] = {}  # normal forces between two blocks at the stage before, if it slid
        self.unsettled = 0  # searches for the factor without dilation that came to no end
        self.stopped = 0  # programmes whose solver ended before its tolerance
        self.uncorrected = 0  # steps tried in which no contacts could be made to give way

    def at(self, placed: Assembly, loads: BlockLoads, joints: Joints, deepest: float = 0.0) -> CurveStage:
        """The limit analysis of blocks where they are.

        Raises:
            InputError: loads that do no work on any mechanism.
            Unbounded: no factor is borne.
        """
        pulling, problem = self._problem(placed, loads, joints)
        if self._follows is not None:
            known = self._followed(problem, placed)
            if known is not None:
                moves = mechanism(problem, placed, joints, known.velocity)
                return CurveStage(placed, loads, pulling, joints, problem, known, moves, known.factor, deepest)
        best, _ = largest_factor(problem)
        self.stopped += bool(best.stopped)
        associated, moves = best.factor, mechanism(problem, placed, joints, best.velocity)
        if self.options.starts:
            least = self._without_dilation(problem, best, bool((moves.sliding > STILL).any()))
            if least is not None:
                best, moves = least, mechanism(problem, placed, joints, least.velocity)
        return CurveStage(placed, loads, pulling, joints, problem, best, moves, associated, deepest)

    def _followed(self, problem: LimitProblem, placed: Assembly) -> Optimum | None:
        """The answer without dilation to which the mechanism of the stage before leads, None where it closes joints by now."""
        assert self._follows is not None
        centre, velocity = self._follows
        turned = velocity.copy()
        turned[:, :3] += np.cross(velocity[:, 3:], placed.centre - centre)
        ends = ends_of(problem, [problem.unknowns_of(turned)], CAP)
        return ends[0][0] if ends else self._from_held(problem)

    def _from_held(self, problem: LimitProblem) -> Optimum | None:
        """The answer without dilation of a problem whose associated factor is not finite, None where there is none or it is."""
        best = largest(problem, problem.dead, problem.live, HELD)
        if best.factor < 0.99 * HELD:
            return None
        least = least_factor(problem, best, 1, self.options.seed)
        if least is None:
            raise Unbounded("no mechanism without dilation is found")
        return least.optimum

    def _without_dilation(self, problem: LimitProblem, associated: Optimum, slides: bool) -> Optimum | None:
        """The answer without dilation, None where there is none but the associated one, whose mechanism ``slides`` or does not.

        The search begins at the associated mechanism. Where only hinges work that is an answer, but if the stage before slid, blocks may
        continue to slide under less: then it begins from the normal forces of that stage.
        """
        if not self._slid:
            found = least_factor(problem, associated, 1, self.options.seed) if slides else None
            self.unsettled += slides and found is None
            return None if found is None else found.optimum
        normal = normal_forces(problem, associated)
        if not slides:
            pairs = [frozenset(map(int, pair)) for pair in problem.points.bodies]
            count = Counter(pairs)
            normal = np.array([self._slid.get(pair, 0.0) / count[pair] for pair in pairs])
        least = close_to(problem, normal, CAP)
        self.unsettled += slides and least is None
        return least if least is not None and (slides or least.factor < associated.factor) else None

    def bears(self, moved: MovedBlocks) -> bool:
        """Return True if any factor of the load is borne by blocks where they are."""
        try:
            largest_factor(self._problem(moved.assembly, moved.loads, moved.joints)[1])
        except NoFiniteFactor:  # any multiple is
            return True
        except Unbounded:
            return False
        return True

    def falling(self, moved: MovedBlocks) -> CurveStage:
        """Blocks that no factor holds, with the forces that leave least unborne and how the blocks begin to fall.

        Raises:
            Unbounded: no answer of the solver.
        """
        pulling, problem = self._problem(moved.assembly, moved.loads, moved.joints)
        best = least_unborne(problem)
        moves = mechanism(problem, moved.assembly, moved.joints, best.velocity)
        return CurveStage(moved.assembly, moved.loads, pulling, moved.joints, problem, best, moves, best.factor, moved.deepest)

    def _problem(self, placed: Assembly, loads: BlockLoads, joints: Joints) -> tuple[np.ndarray, LimitProblem]:
        """Which ties pull (T,), and the limit analysis of blocks where they are."""
        pulling = _lengths(loads.bars) >= self._rest * (1.0 - SLACK)
        points = interfaces(placed, joints, self.axis)
        whole = np.array([(int(a), int(b)) in self._bonded for a, b in points.bodies], dtype=bool)
        points = replace(points, apex=np.where(whole, points.apex, 0.0), tension=np.where(whole, points.tension, 0.0))
        return pulling, problem_at(placed, points, replace(loads, bars=_only(loads.bars, pulling)), self.axis)

    def wear(self, stage: CurveStage) -> None:
        """Take away what the mechanism of a stage costs as soon as it moves: the bond of the joints at work."""
        worked = np.flatnonzero(stage.mechanism.state > 0)
        self._bonded -= {(int(stage.joints.block_a[j]), int(stage.joints.block_b[j])) for j in worked}

    def accept(self, stage: CurveStage) -> None:
        """Take a stage into the curve: ties that have yielded stay as long as they are, and where it slides, so may the next."""
        self._rest = np.maximum(self._rest, _lengths(stage.loads.bars))
        if self._follows is not None:
            self._follows = stage.assembly.centre, stage.mechanism.velocity
        self._slid = {}
        if (stage.mechanism.sliding > STILL).any():
            for pair, force in zip(stage.problem.points.bodies, stage.best.force[:, 0] + stage.problem.apex, strict=True):
                key = frozenset(map(int, pair))
                self._slid[key] = self._slid.get(key, 0.0) + float(max(force, 0.0))

    def step(self, stage: CurveStage, motion: FollowedMotion, amount: float) -> tuple[MovedBlocks, float]:
        """The blocks when the fastest corner has gone ``amount`` [m], or less where blocks meet before; and how far it has gone."""
        moved, least = self._moved(stage, motion, amount), stage.deepest
        if moved.deepest <= least + self.gap:
            return moved, amount
        low, high, best, over = 0.0, amount, None, moved
        deep = [(amount, moved.deepest - least)]  # lengths of steps that overlap, and by how much more than at the stage
        for k in range(HALVINGS):
            middle = low + _share(low, deep, self.gap, UNSEEN * stage.assembly.width, k) * (high - low)
            moved = self._moved(stage, motion, middle)
            if moved.deepest > least + self.gap:
                high, over = middle, moved
                deep.append((high, over.deepest - least))
            else:
                low, best = middle, moved
                if moved.deepest > least + CLOSE * self.gap and middle > FAR_ENOUGH * high:
                    break
            if high - low < over.deepest - least <= UNSEEN * stage.assembly.width:
                return over, high  # no motion of that length makes such an overlap: a contact that was too narrow to be found
        return (best, low) if best is not None else (moved, 0.0)

    def _moved(self, stage: CurveStage, motion: FollowedMotion, amount: float) -> MovedBlocks:
        end, missed = motion.follow(amount)
        self.uncorrected += math.isinf(missed)
        placed = stage.assembly.placed(end.position, end.rotation)
        found = moved_joints(placed, self.gap)
        loads = stage.loads.moved(stage.assembly.centre, end.position, end.rotation)
        return MovedBlocks(placed, loads, found.joints, found.deepest, motion.progress(end) < LOCKED * amount)


def _share(low: float, deep: list[tuple[float, float]], gap: float, unseen: float, k: int) -> float:
    """Where between ``low`` and the last of the steps that overlap to try next, as a share.

    Every second time in the middle. Otherwise where the line through the last two overlaps, or through the last and none, comes to half the
    gap. Where that is behind ``low``, the overlap was there and not found: then where the line comes to half of what may go unseen.
    """
    if k % 2:
        return 0.5
    high, over = deep[-1]
    longer, more = deep[-2] if len(deep) > 1 else (high + (high - low), 2.0 * over)
    slope = (more - over) / (longer - high)
    if slope <= 0.0:
        return 0.5
    shares = ((high - (over - depth) / slope - low) / (high - low) for depth in (0.5 * gap, 0.5 * unseen))
    return next((float(max(share, 1e-4)) for share in shares if 0.0 < share < 0.99), 0.5)


def _lengths(bars: Bars) -> np.ndarray:
    return np.asarray(np.linalg.norm(bars.points[:, 1] - bars.points[:, 0], axis=1))


def _only(bars: Bars, which: np.ndarray) -> Bars:
    return Bars(bars.blocks[which], bars.points[which], bars.strength[which])
