# SPDX-License-Identifier: GPL-3.0-or-later
"""A limit analysis from the question whether the structure stands to its mechanism at the largest factor, with a certificate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.limit.crushing import block_shares, crushable, cut_where_it_crushes, refuse_crushed_at_rest, solved_finely
from masonry_cd.analysis.limit.mechanism import Mechanism, mechanism
from masonry_cd.analysis.limit.problem import BlockLoads, LimitProblem, limit_problem
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.analysis.limit.search import least_factor, polished, sought
from masonry_cd.analysis.limit.solution import ALIKE, LeastFound, Optimum, Unbounded, merged
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

HELD = 5.0  # load factor, in the weight of what is free, that a structure without a finite associated one is searched up to, tenfold
CAP = 1e4  # largest factor looked for, with the live loads scaled to the dead ones
STANDS = 1e-5  # a structure stands that bears its dead loads but for this share
NOTHING = 1e-6  # share of the dead loads below which live ones count as none; the cone programmes end at 1e-8
SEARCHES = 3  # of the least factor at most, each with the cells of joints that crush cut by the mechanisms of the one before
NO_FORCE = 1e-6  # share of the mean weight of a block below which a joint bears nothing
RESTS = "whether it stands"
NO_WORK = "the load does no work on any mechanism: no factor of it sets the structure in motion"

Domain = Callable[[LimitProblem, Assembly, Joints], LimitProblem]  # puts into a problem what its joints bear


class NoFiniteFactor(InputError):
    """Loads of which any multiple is borne: no mechanism on which they do work."""


@dataclass(frozen=True)
class LimitOptions:
    """How to solve."""

    starts: int = 3  # of the search for the least factor without dilation; 0: no search
    seed: int = 0


@dataclass(frozen=True)
class Certificate:
    """How good an answer is; forces over the mean weight of a block, velocities with w_1 . v = 1."""

    static: float  # the factor that the forces bear
    kinematic: float  # the factor from the work of the loads on the mechanism
    gap: float  # between the two
    equilibrium: float  # largest residual of a block's equilibrium
    friction: float  # largest force beyond a friction cone, or tension beyond a joint's
    flow: float  # largest closing of a point, beyond what its flow rule allows, over the largest velocity


@dataclass(frozen=True, eq=False)
class LimitAnswer:
    """The state at the largest factor."""

    factor: float
    optimum: Optimum
    mechanism: Mechanism
    certificate: Certificate
    seconds: float


@dataclass(frozen=True, eq=False)
class Collapse:
    """A mechanism and the forces of the J joints that go with it."""

    mechanism: Mechanism
    normal_force: np.ndarray  # (J,) [N]
    shear_force: np.ndarray  # (J,) [N]
    force_point: np.ndarray  # (J, 3) where the resultant crosses the joint [m]; nan without a normal force
    bars: np.ndarray  # (T,) tensions of the ties [N]
    block_share: np.ndarray | None = None  # (J,) share of the joint under stress at its strength; nan of joints that do not crush


@dataclass(frozen=True, eq=False)
class Governing:
    """A factor with its forces and its mechanism."""

    factor: float
    optimum: Optimum
    mechanism: Mechanism


@dataclass(frozen=True, eq=False)
class Analysis:
    """A limit analysis: whether the structure stands, what it bears, how it gives way."""

    problem: LimitProblem
    standing: float  # share of its dead loads that it bears; 1: it stands
    associated: LimitAnswer  # of the dead loads where it does not stand
    least: LeastFound | None  # without dilation
    least_mechanism: Mechanism | None
    starts: int  # of the search for it that were made
    stopped: tuple[str, ...]  # which programmes other than the search ended before their tolerance
    unlimited: bool = False  # forces bear any multiple of the live loads; ``associated`` is then what bears the dead ones

    @property
    def remarks(self) -> tuple[str, ...]:
        """A line for each programme that ended before its tolerance, that of the least pair among them."""
        return self.stopped if self.least is None else (*self.stopped, *_remarks({"the least factor": self.least.optimum}))

    @property
    def stands(self) -> bool:
        """Return True if it bears its dead loads."""
        return self.standing >= 1.0 - STANDS

    @property
    def is_endless(self) -> bool:
        """Return True if no finite factor is known: none with dilation, and a search without it found none."""
        return self.unlimited and self.least is None

    @property
    def bears_nothing(self) -> bool:
        """Return True if the least of the live loads sets it in motion: what is borne of them is nothing compared with the dead ones."""
        if self.unlimited:
            return False
        borne = abs(self.associated.factor) * float(np.linalg.norm(self.problem.live))
        return not self.problem.moves_support and borne <= NOTHING * float(np.linalg.norm(self.problem.dead))

    @property
    def governing(self) -> Governing:
        """The answer that belongs to the least factor found, or else to the associated one."""
        if self.least is not None and self.least_mechanism is not None:
            return Governing(self.least.optimum.factor, self.least.optimum, self.least_mechanism)
        return Governing(self.associated.factor, self.associated.optimum, self.associated.mechanism)

    def collapse(self, joints: int) -> Collapse:
        """The mechanism of the least factor found, or else the associated one, with its forces; of a structure of some joints."""
        return collapse_of(self.problem, self.governing.optimum, self.governing.mechanism, joints)


def collapse_of(problem: LimitProblem, best: Optimum, moves: Mechanism, joints: int) -> Collapse:
    """A mechanism with the forces found for it; of a structure of a given number of joints."""
    joint, points, weight = problem.points.joint, problem.points, problem.weight
    normal = weight * best.force[:, 0]
    total = np.bincount(joint, normal, minlength=joints)
    world = np.einsum("pd,pdi->pi", weight * best.force[:, 1:], points.frame[:, 1:])
    shear = np.stack([np.bincount(joint, part, minlength=joints) for part in world.T], axis=1)
    sums = np.stack([np.bincount(joint, normal * part, minlength=joints) for part in points.point.T], axis=1)
    bears = np.abs(total) > NO_FORCE * weight
    place = np.where(bears[:, None], sums / np.where(bears, total, 1.0)[:, None], np.nan)
    return Collapse(
        moves, total, np.linalg.norm(shear, axis=1), place, weight * best.bars[: problem.ties], block_shares(problem, best, joints)
    )


def analyse(assembly: Assembly, joints: Joints, loads: BlockLoads, options: LimitOptions | None = None) -> Analysis:
    """Find the largest factor of the live loads.

    Raises:
        InputError: a structure without supports, live loads that do no work, or no answer of the solver.
    """
    options = options or LimitOptions()
    begin = time.perf_counter()
    problem, alone = at_rest(assembly, joints, loads)
    _refuse_crushed(problem, alone, assembly)
    if alone.factor < 1.0 - STANDS:
        nothing = replace(problem, live=problem.dead, dead=np.zeros_like(problem.dead))
        fall = _answer(nothing, assembly, joints, alone, 1.0, time.perf_counter() - begin)
        return Analysis(problem, alone.factor, fall, None, None, 0, _remarks({RESTS: alone}))
    if loads.support_velocity is not None:
        problem = crushable(limit_problem(assembly, joints, loads), assembly, joints)
    begin, endless = time.perf_counter(), False
    try:
        problem, best = solved_finely(problem, lambda finer: largest_factor(finer)[0])
    except Unbounded as failure:
        raise InputError("limit", f"no answer: {failure}") from None
    except NoFiniteFactor:
        best, endless = replace(alone, factor=HELD * _scale(problem), velocity=np.zeros(problem.unknowns)), True
    answer = _answer(problem, assembly, joints, best, 0.0 if endless else CAP * _scale(problem), time.perf_counter() - begin)
    if endless:
        answer = replace(answer, factor=math.inf)
    starts = 0 if problem.moves_support or not problem.live.any() else options.starts
    problem, least = searched_finely(problem, lambda finer: least_factor(finer, best, starts, options.seed))
    moves = None if least is None else mechanism(problem, assembly, joints, least.optimum.velocity)
    programmes = {RESTS: alone} | ({} if endless else {"the load factor, whose certificate says how far it holds": best})
    return Analysis(problem, min(alone.factor, 1.0), answer, least, moves, starts, _remarks(programmes), endless)


def largest_factor(problem: LimitProblem) -> tuple[Optimum, float]:
    """The best forces and velocities of a problem, and the largest factor that was looked for.

    Raises:
        InputError: live loads that do no work on any mechanism.
        Unbounded: no forces bear the dead loads with any factor.
    """
    if not problem.live.any():
        raise NoFiniteFactor("limit", NO_WORK)
    scale = _scale(problem)
    scaled = largest(problem, problem.dead, scale * problem.live, CAP)
    if scaled.factor > 0.99 * CAP:
        raise NoFiniteFactor("limit", NO_WORK)
    return replace(scaled, factor=scale * scaled.factor, velocity=scale * scaled.velocity), scale * CAP


def _scale(problem: LimitProblem) -> float:
    """The size of the dead loads over that of the live ones."""
    return max(float(np.linalg.norm(problem.dead)), 1e-300) / float(np.linalg.norm(problem.live))


def with_more_starts(analysis: Analysis, assembly: Assembly, joints: Joints, made: int, most: int, seed: int) -> Analysis:
    """An analysis in space whose search goes on until starts agree, two at a time, and whose least pair is then polished.

    Args:
        analysis: whose own search has ``made`` this number of starts.
        assembly: its blocks.
        joints: of them.
        made: starts of its own.
        most: to which it goes on.
        seed: of it.
    """
    problem, best, least, starts = analysis.problem, analysis.associated.optimum, analysis.least, analysis.starts
    while made < most and not (least is not None and least.has_agreement):
        upto = min(made + 2, most)
        starts += upto - made
        least, made = merged(least, least_factor(problem, best, upto, seed, made, least), starts), upto
    if least is None:
        return replace(analysis, starts=starts)
    if problem.axis is None:
        least = polished(problem, least, sought(best))
    return replace(analysis, least=least, least_mechanism=mechanism(problem, assembly, joints, least.optimum.velocity), starts=starts)


def searched_finely(problem: LimitProblem, search: Callable[[LimitProblem], LeastFound | None]) -> tuple[LimitProblem, LeastFound | None]:
    """Return the findings of a search, and the problem of it: joints that crush cut where the mechanisms found crush, until that changes it
    by no more than ALIKE."""
    least = search(problem)
    for _ in range(SEARCHES):
        finer = problem
        for end in () if least is None else least.ends:
            finer = cut_where_it_crushes(finer, end) or finer
        again = None if finer is problem else search(finer)
        if least is None or again is None:
            break
        change = abs(again.optimum.factor - least.optimum.factor)
        problem, least = finer, again
        if change <= ALIKE * abs(least.optimum.factor):
            break
    return problem, least


def _remarks(programmes: dict[str, Optimum]) -> tuple[str, ...]:
    """A line for each of the named programmes whose solver ended before its tolerance."""
    return tuple(
        f"{name}: the solver stopped before it met its tolerance ({best.stopped} after {best.iterations} iterations)"
        for name, best in programmes.items()
        if best.stopped
    )


def at_rest(assembly: Assembly, joints: Joints, loads: BlockLoads, domain: Domain = crushable) -> tuple[LimitProblem, Optimum]:
    """The largest share of the dead loads that a structure bears, at most 1, and the problem that this is of.

    ``domain`` puts into a problem what its joints bear.

    Raises:
        InputError: a structure without supports, or no answer of the solver.
    """
    if not assembly.fixed.any():
        raise InputError("structure", "no block is fixed; a limit analysis needs at least one support")
    problem = domain(limit_problem(assembly, joints, replace(loads, support_velocity=None)), assembly, joints)
    return solved_finely(problem, _rests)


def refuse_crushed(problem: LimitProblem, assembly: Assembly) -> None:
    """Refuse a strength below the stress that the dead loads of a problem make.

    Raises:
        InputError: names the joint; or no answer of the solver.
    """
    if problem.sections is not None:
        _refuse_crushed(*solved_finely(problem, _rests), assembly)


def _refuse_crushed(problem: LimitProblem, alone: Optimum, assembly: Assembly) -> None:
    if alone.factor < 1.0 - STANDS and problem.sections is not None:
        refuse_crushed_at_rest(problem, alone, assembly, lambda bare: _rests(bare).factor >= 1.0 - STANDS)


def _rests(problem: LimitProblem) -> Optimum:
    """The largest share of the dead loads that is borne, at most 1; what has no answer is an error of the input."""
    try:
        return largest(problem, np.zeros_like(problem.dead), problem.dead, 1.0)
    except Unbounded as failure:
        raise InputError("limit", f"no answer: {failure}") from None


def _answer(problem: LimitProblem, assembly: Assembly, joints: Joints, best: Optimum, cap: float, seconds: float) -> LimitAnswer:
    """An optimum with its mechanism and certificate."""
    moves = mechanism(problem, assembly, joints, best.velocity)
    return LimitAnswer(best.factor, best, moves, certificate(problem, best, cap), seconds)


def certificate(problem: LimitProblem, best: Optimum, cap: float) -> Certificate:
    """Measure an optimum, apart from what the solver says of it."""
    left = problem.jacobian.T @ best.force.ravel() - problem.bars.T @ best.bars + problem.dead + best.factor * problem.live
    normal, tangent = best.force[:, 0] + problem.apex, np.linalg.norm(best.force[:, 1:], axis=1)
    beyond = np.maximum(tangent - problem.mu * normal, -(best.force[:, 0] + problem.tension))
    moved = (problem.jacobian @ best.velocity).reshape(best.force.shape)
    cut = problem.tension < problem.apex
    lifted = problem.mu * np.linalg.norm(moved[:, 1:], axis=1)
    closing = lifted - moved[:, 0]
    longer = problem.bars @ best.velocity
    yields = np.isfinite(problem.strength)
    work = -float(problem.dead @ best.velocity) + float(np.sum(np.maximum(longer[yields], 0.0) * problem.strength[yields]))
    work += float(np.sum(problem.apex * np.where(cut, np.minimum(lifted, moved[:, 0]), moved[:, 0])))
    work += float(np.sum((problem.tension * np.maximum(moved[:, 0] - lifted, 0.0))[cut]))
    kinematic = work + cap * max(1.0 - float(problem.live @ best.velocity), 0.0)
    largest = max(float(np.abs(best.velocity).max(initial=0.0)), 1e-300)
    return Certificate(
        static=best.factor,
        kinematic=kinematic,
        gap=abs(kinematic - best.factor),
        equilibrium=float(np.abs(left).max(initial=0.0)),
        friction=float(np.maximum(beyond, 0.0).max(initial=0.0)),
        flow=float(max(closing.max(initial=0.0), longer[~yields].max(initial=0.0)) / largest),
    )
