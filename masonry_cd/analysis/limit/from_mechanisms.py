# SPDX-License-Identifier: GPL-3.0-or-later
r"""The least factor without dilation from mechanisms that are known: a start of the search that needs no sequence of its own.

The descent of :mod:`masonry_cd.analysis.limit.nonassociated` begins at velocities. Those of another problem will do: of the same structure
without its ties, of one of its macro-elements, of a few rigid bodies. Four cone programmes take the place of some twenty.

**Agreement.** Descents from mechanisms that are alike come to one end, which says nothing: those that come to one factor are one start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from masonry_cd.analysis.limit import nonassociated
from masonry_cd.analysis.limit.crushing import crushed_open
from masonry_cd.analysis.limit.mechanism import STILL
from masonry_cd.analysis.limit.nonassociated import ALIKE, LeastFound, Pair, merged
from masonry_cd.analysis.limit.nonassociated_space import SearchInSpace
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.mechanics.model.blocks import Assembly

CARRIED = 100  # rounds in which blocks at rest are taken along, a course or two each


@dataclass(frozen=True, eq=False)
class Searched:
    """A search: what it found, None where no start came to an end, and of how many starts."""

    least: LeastFound | None
    starts: int


def ends_of(problem: LimitProblem, mechanisms: Sequence[np.ndarray], cap: float) -> list[Pair]:
    """The pairs that descents from velocities (unknowns,) come to, those that come to an end.

    Args:
        problem: whose least factor is sought.
        mechanisms: velocities that the live loads drive, w_1 . v > 0, under which no joint closes and that no tie holds which does not
            yield; others are passed over.
        cap: the largest factor that is looked for.
    """
    ends, descend = [], _descent(problem, cap)
    for velocity in mechanisms:
        power = float(problem.live @ velocity)
        end = descend(velocity / power) if power > 0.0 and not _held(problem, velocity) else None
        if end is not None:
            ends.append(end)
    return ends


def _held(problem: LimitProblem, velocity: np.ndarray) -> bool:
    """Whether a mechanism stretches a tie that does not yield, or closes a joint."""
    longer = (problem.bars @ velocity)[~np.isfinite(problem.strength)]
    opening = (problem.jacobian @ velocity)[:: problem.directions]
    size = STILL * float(np.abs(velocity).max(initial=0.0))
    return bool((longer > size).any() or (opening < -size).any())


def admitted(problem: LimitProblem, assembly: Assembly, velocity: np.ndarray, crushing: np.ndarray | None = None) -> np.ndarray | None:
    """The unknowns of a mechanism of some blocks (B, 6) that closes no joint: blocks at rest that it would lift or push go with it.

    Joints (J,) that it crushes may close. None where that leads to a support, to blocks that push one another, or to no end.
    """
    moved = velocity.copy()
    ends = problem.points.bodies
    may = np.zeros(problem.points.count, dtype=bool) if crushing is None else crushing[problem.points.joint]
    for _ in range(CARRIED):
        unknowns = problem.unknowns_of(moved)
        opening = (problem.jacobian @ unknowns)[:: problem.directions]
        closes = ends[(opening < -STILL * float(np.abs(unknowns).max(initial=0.0))) & ~may]
        if not len(closes):
            return crushed_open(problem, unknowns)
        rests = ~moved[closes].any(axis=2)
        some = rests[:, 0] != rests[:, 1]
        still, goes = np.where(rests[:, 0], closes[:, 0], closes[:, 1])[some], np.where(rests[:, 0], closes[:, 1], closes[:, 0])[some]
        if not len(still) or assembly.fixed[still].any():
            return None
        arm = assembly.centre[still] - assembly.centre[goes]
        moved[still] = moved[goes]
        moved[still, :3] += np.cross(moved[goes, 3:], arm)
    return None


def _descent(problem: LimitProblem, cap: float) -> Callable[[np.ndarray], Pair | None]:
    """The descent from velocities (unknowns,) with w_1 . v = 1."""
    if problem.axis is not None:
        return partial(nonassociated.descend, problem)
    programmes = SearchInSpace(problem, cap)

    def descend(velocity: np.ndarray) -> Pair | None:
        try:
            return programmes.descend(velocity)
        except Unbounded:
            return None

    return descend


def begun_at(problem: LimitProblem, before: Searched, mechanisms: Sequence[np.ndarray], cap: float) -> Searched:
    """A search that has begun at mechanisms as well; arguments as of :func:`ends_of`."""
    every, apart = ends_of(problem, mechanisms, cap), list[Pair]()
    for end in sorted(every, key=lambda pair: pair[0].factor):
        if not apart or end[0].factor - apart[-1][0].factor > ALIKE * abs(apart[-1][0].factor):
            apart.append(end)
    starts = before.starts + len(mechanisms) - len(every) + len(apart)
    found = LeastFound(*apart[0], starts, tuple(optimum for optimum, _ in apart)) if apart else None
    return Searched(merged(before.least, found, starts), starts)
