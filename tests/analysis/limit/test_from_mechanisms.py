# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms of parts as starts of the search of the whole: what lies on them goes with them, and the least factor found is never more."""

from __future__ import annotations

import numpy as np
from limit_loads import joined, push_loads
from models import box, ground
from test_macro import EFFORT, element, stack, toothed, whole_of

from masonry_cd.analysis.limit.admitted import admitted
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.candidates import with_mechanisms
from masonry_cd.analysis.limit.macro import analyse_element
from masonry_cd.analysis.limit.mechanism import mechanism
from masonry_cd.analysis.limit.part import part_of, resting
from masonry_cd.analysis.limit.problem import limit_problem

X = (1.0, 0.0, 0.0)


def test_stones_that_rest_on_a_part_are_taken_along() -> None:
    """A facade that overturns lifts the stones of the cross wall that lie on it, which are held while it is analysed by itself."""
    whole = whole_of(toothed())
    facade = element(whole, "facade")
    one = next(one for one in analyse_element(whole, facade, X, EFFORT).mechanisms if one.moving > 3)
    assembly, joints = joined(toothed(), 0.6)
    problem = limit_problem(assembly, joints, push_loads(assembly))
    part = part_of(whole, resting(whole, facade.blocks), np.array(X)).problem
    velocity = problem.block_velocity(problem.unknowns_of(part.block_velocity(one.velocity, assembly.count)), assembly.count)
    assert ((problem.jacobian @ problem.unknowns_of(velocity))[:: problem.directions]).min() < -1e-3
    taken = admitted(problem, assembly, velocity)
    assert taken is not None
    assert ((problem.jacobian @ taken)[:: problem.directions]).min() > -2e-4 * np.abs(taken).max()
    moved = np.linalg.norm(problem.block_velocity(taken, assembly.count), axis=1) > 1e-9
    assert any(assembly.names[b].startswith("cross") for b in np.flatnonzero(moved))


def test_what_would_push_a_support_is_passed_over() -> None:
    blocks = [ground(8.0), *stack("wall", 3), box("stop", (0.5, -1.0, 0.0), (1.0, 1.0, 1.5), fixed=True)]
    assembly, joints = joined(blocks, 0.6)
    problem = limit_problem(assembly, joints, push_loads(assembly))
    velocity = np.zeros((assembly.count, 6))
    velocity[1:4, 0] = 1.0
    assert admitted(problem, assembly, velocity) is None


def test_a_known_mechanism_lowers_the_least_factor_found_or_leaves_it() -> None:
    """A slab between cheeks: one start comes to the wedged mechanism; that of the slab alone is less."""
    cheeks = [box("left", (0.0, -1.6, 0.0), (1.0, -1.0, 3.0)), box("right", (0.0, 1.0, 0.0), (1.0, 1.6, 3.0))]
    assembly, joints = joined([ground(8.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0)), *cheeks], 0.6)
    analysis = analyse(assembly, joints, push_loads(assembly, (-1.0, 0.0, 0.0)), LimitOptions(starts=1))
    assert analysis.least is not None
    leans = np.zeros((assembly.count, 6))
    leans[1] = [-1.5, 0.0, 0.25, 0.0, -1.0, 0.0]
    known = mechanism(analysis.problem, assembly, joints, analysis.problem.unknowns_of(leans))
    more = with_mechanisms(analysis, assembly, joints, [known])
    assert more.least is not None and more.starts == 2
    assert abs(more.least.optimum.factor - 0.5 / 3.0) < 1e-4 < analysis.least.optimum.factor - more.least.optimum.factor
    again = with_mechanisms(analysis, assembly, joints, [known, known, known])
    assert again.least is not None and again.starts == 2 and again.least.agreeing == 1  # one mechanism three times is not agreement
