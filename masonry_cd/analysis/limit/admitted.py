# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms of some blocks as mechanisms of all: what lies on them goes with them."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.limit.crushing import crushed_open
from masonry_cd.analysis.limit.mechanism import STILL
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.mechanics.model.blocks import Assembly

CARRIED = 100  # rounds in which blocks at rest are taken along, a course or two each


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
