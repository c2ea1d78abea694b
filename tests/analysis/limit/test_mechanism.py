# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis.limit.mechanism: which mechanisms are stones of one course that slide by themselves."""

from __future__ import annotations

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import box, ground

from masonry_cd.analysis.limit.found import named
from masonry_cd.analysis.limit.mechanism import mechanism
from masonry_cd.analysis.limit.part import Whole
from masonry_cd.analysis.limit.problem import Bars, limit_problem

LOW, LEFT, RIGHT, TOP = 1, 2, 3, 4
ALONG, OVER = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.0, -0.5, 0.0, 1.0, 0.0]
CASES = {
    "one stone": ({RIGHT: ALONG}, "1 stone of one course that slides"),
    "a course": ({LEFT: ALONG, RIGHT: ALONG, TOP: ALONG}, ""),
    "two stones next to each other": ({LEFT: ALONG, RIGHT: ALONG}, "2 stones of one course that slide"),
    "one that turns": ({TOP: OVER}, ""),
    "nothing": ({}, ""),
}


@pytest.mark.parametrize(("moved", "words"), CASES.values(), ids=list(CASES))
def test_stones_of_one_course_that_slide_are_named_so(moved: dict[int, list[float]], words: str) -> None:
    stones = [box("low", (0.0, 0.0, 0.0), (2.0, 1.0, 1.0)), box("left", (0.0, 0.0, 1.0), (1.0, 1.0, 2.0))]
    stones += [box("right", (1.0, 0.0, 1.0), (2.0, 1.0, 2.0)), box("top", (0.0, 0.0, 2.0), (0.9, 1.0, 3.0))]
    assembly, joints = joined([ground(6.0), *stones], 0.5)
    problem = limit_problem(assembly, joints, push_loads(assembly, (1.0, 0.2, 0.0)))
    velocity = np.zeros((assembly.count, 6))
    for block, rate in moved.items():
        velocity[block] = rate
    moves = mechanism(problem, assembly, joints, problem.unknowns_of(velocity))
    whole = Whole(assembly, joints, np.zeros((assembly.count, 6)), Bars.none(), 9.81, lambda _: False)
    name, alone = named(moves, whole, ~assembly.fixed)
    assert alone == bool(words) and (name == words or not words)
