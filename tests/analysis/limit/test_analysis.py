# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analyses against closed forms: sliding, overturning, bond, ties, supports that give way, what falls and what nothing moves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from limit_loads import joined, push_loads, pushed
from models import GRAVITY, box, ground

from benchmarks.dry_walls import FRICTION, dry_wall
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse, certificate
from masonry_cd.analysis.limit.interfaces import area_shares
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.joint_laws import JointLaw

QUIET = LimitOptions(starts=0)


def pillar(width=0.5, depth=0.3, height=1.5, friction=0.6, direction=(1.0, 0.0, 0.0), laws=None):
    """A box on the ground, next to the middle of its plate, so that it needs space."""
    return pushed([ground(2.0), box("a", (0.0, -0.2, 0.0), (width, depth - 0.2, height))], friction, direction, laws)


@pytest.mark.parametrize(("direction", "lever"), [((1, 0, 0), 0.5), ((0, 1, 0), 0.3), ((-1, 0, 0), 0.5)])
def test_a_slender_block_overturns_at_width_over_height(direction, lever):
    found = pillar(direction=direction)
    assert found.problem.axis is None
    assert found.associated.factor == pytest.approx(lever / 1.5, abs=1e-6)
    assert STATES[found.associated.mechanism.state[0]] == "hinge"


def test_a_block_pushed_across_its_corner_overturns_about_the_edge_that_gives_way_first():
    found = pillar(direction=(1.0, 1.0, 0.0))
    assert found.associated.factor == pytest.approx(math.sqrt(2.0) * 0.3 / 1.5, abs=1e-6)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0, 71.0])
def test_a_flat_block_slides_at_its_friction_in_every_direction(degrees):
    turn = math.radians(degrees)
    found = pillar(width=2.0, depth=2.0, height=0.4, direction=(math.cos(turn), math.sin(turn), 0.0))
    assert found.associated.factor == pytest.approx(0.6, abs=1e-6)
    assert STATES[found.associated.mechanism.state[0]] == "slide"


def test_cohesion_adds_its_share_to_sliding():
    area, weight = 4.0, 2000.0 * GRAVITY * 4.0 * 0.4
    law = {"default": JointLaw(cohesion=1000.0)}
    found = pillar(width=2.0, depth=2.0, height=0.4, laws=law)
    assert found.associated.factor == pytest.approx(0.6 + 1000.0 * area / weight, rel=1e-6)


@pytest.mark.parametrize("tension", [500.0, 1000.0 / 0.6])
def test_tensile_strength_adds_the_moment_of_a_plastic_joint(tension):
    law = {"default": JointLaw(cohesion=1000.0, tension=tension, normal_stiffness=1e10)}
    found = pillar(width=0.3, depth=0.5, height=2.0, laws=law)
    weight, area = 2000.0 * GRAVITY * 0.3 * 0.5 * 2.0, 0.15
    assert found.associated.factor == pytest.approx((weight + tension * area) * 0.15 / (weight * 1.0), rel=1e-6)
    assert found.associated.certificate.gap < 1e-6


def test_a_planar_joint_with_bond_bears_what_one_in_space_does():
    law = {"default": JointLaw(cohesion=1000.0, tension=500.0, normal_stiffness=1e10)}
    planar = pushed([ground(2.0), box("a", (0.0, -0.25, 0.0), (0.3, 0.25, 2.0))], 0.6, laws=law)
    assert planar.problem.axis == 1
    assert planar.associated.factor == pytest.approx(pillar(width=0.3, depth=0.5, height=2.0, laws=law).associated.factor, rel=1e-6)


def test_the_shares_of_corners_have_the_area_and_the_first_moment_of_the_polygon():
    corners = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 1.0, 0.0], [1.0, 2.0, 0.0]])
    shares = area_shares(corners)
    x, y = corners[:, 0], corners[:, 1]
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    assert shares.sum() == pytest.approx(0.5 * cross.sum())
    assert shares @ x == pytest.approx(((x + np.roll(x, -1)) * cross).sum() / 6.0)
    assert area_shares(np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])) == pytest.approx([0.5] * 4)


def tied_column(strength):
    """A column of half a metre, tied at its top to a fixed post behind it, and its weight [N]."""
    blocks = [box("floor", (-3, -0.2, -0.5), (3, 0.2, 0.0), fixed=True), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 2.0))]
    blocks.append(box("post", (-2.0, -0.2, 0.0), (-1.5, 0.2, 2.0), fixed=True))
    assembly, joints = joined(blocks, 0.6)
    bar = Bars(np.array([[2, 1]]), np.array([[[-1.5, 0.0, 2.0], [0.0, 0.0, 2.0]]]), np.array([strength]))
    return analyse(assembly, joints, push_loads(assembly, bars=bar), QUIET), 2000.0 * GRAVITY * 0.5 * 0.4 * 2.0


def test_a_tie_that_yields_holds_a_column_up_to_its_strength():
    found, weight = tied_column(500.0)
    assert found.associated.factor == pytest.approx((weight * 0.25 + 500.0 * 2.0) / weight, rel=1e-9)
    assert found.associated.optimum.bars[0] * found.problem.weight == pytest.approx(500.0)
    assert found.associated.certificate.gap < 1e-9


def test_a_column_whose_tie_does_not_yield_slides_away_at_its_base():
    found, weight = tied_column(math.inf)  # base at its friction, its resultant at the heel: lambda + 0.25 = 2 (lambda - 0.6)
    assert found.associated.factor == pytest.approx(1.45, rel=1e-9)
    assert found.associated.optimum.bars[0] * found.problem.weight == pytest.approx((1.45 - 0.6) * weight, rel=1e-9)


def test_a_support_that_gives_way_bears_what_balance_leaves_it():
    length, ledge = 2.0, 0.2
    blocks = [box("left", (0, -0.2, -0.5), (ledge, 0.2, 0), True), box("right", (length - ledge, -0.2, -0.5), (length, 0.2, 0), True)]
    blocks.append(box("beam", (0, -0.2, 0), (length, 0.2, 0.3)))
    assembly, joints = joined(blocks, 0.6)
    loads = push_loads(assembly)
    moves = np.zeros((3, 3))
    moves[1, 2] = -1.0
    found = analyse(assembly, joints, BlockLoads(loads.dead, 0.0 * loads.live, Bars.none(), moves), QUIET)
    weight = GRAVITY * assembly.mass[2]
    assert -found.associated.factor * found.problem.weight == pytest.approx(weight * (0.5 * length - ledge) / (length - ledge), rel=1e-9)
    assert found.least is None


def test_what_overhangs_falls_and_is_named():
    found = pushed([ground(2.0), box("a", (0, -0.2, 0), (1, 0.2, 0.5)), box("b", (0.7, -0.2, 0.5), (1.9, 0.2, 1.0))], 0.6)
    assert not found.stands
    assert list(found.associated.mechanism.moving) == [False, False, True]


def test_the_dual_of_a_wall_is_a_mechanism_that_opens_closes_nothing_and_works_with_the_load():
    blocks = dry_wall(3)
    assembly, joints = joined(blocks, FRICTION)
    loads = push_loads(assembly)
    found = analyse(assembly, joints, loads, LimitOptions(starts=1))
    for moves in (found.associated.mechanism, found.least_mechanism):
        assert moves is not None
        assert np.sum(loads.live[:, :3] * moves.velocity[:, :3]) > 0
        assert (moves.velocity[assembly.fixed] == 0).all()
        assert moves.speed.max() == pytest.approx(1.0)
    assert found.least is not None
    search, best = found.problem, found.least.optimum
    moved = (search.jacobian @ best.velocity).reshape(-1, 2)
    size = np.abs(moved).max()
    assert moved[:, 0].min() > -1e-9 * size  # nothing closes
    normal, tangent = best.force.T
    assert (np.abs(tangent) <= search.mu * normal + 1e-9).all()
    slack = np.minimum(search.mu * normal - np.abs(tangent), 1.0)
    assert np.abs(moved[:, 0] * normal).max() < 1e-6 * size  # what opens bears nothing
    assert (np.abs(moved[:, 1]) * slack).max() < 1e-6 * size  # what slides is at its friction
    assert (moved[:, 1] * tangent).max() < 1e-9 * size  # against its motion
    left = search.jacobian.T @ best.force.ravel() + search.dead + best.factor * search.live
    assert np.abs(left).max() < 1e-9


def test_a_certificate_tells_a_wrong_answer_from_a_right_one():
    found = pushed(dry_wall(1), FRICTION)
    best = found.associated.optimum
    wrong = certificate(found.problem, replace(best, force=1.01 * best.force, velocity=-best.velocity), 1e4)
    assert wrong.equilibrium > 1e-3
    assert wrong.flow > 1e-3
    assert wrong.gap > 1e-3


def test_equal_seeds_give_equal_answers():
    first, second = (pushed(dry_wall(4), FRICTION, options=LimitOptions(starts=2, seed=3)) for _ in range(2))
    assert first.least is not None and second.least is not None
    assert first.least.found == second.least.found


def test_a_structure_without_supports_has_no_answer():
    with pytest.raises(InputError, match="no block is fixed"):
        pushed([box("a", (0, 0, 0), (1, 1, 1)), box("b", (0, 0, 1), (1, 1, 2))], 0.6)


def test_a_load_that_moves_nothing_has_no_finite_factor():
    found = pushed([ground(2.0), box("a", (0, -0.2, 0), (1, 0.2, 0.5))], 0.6, (0.0, 0.0, -1.0))
    assert found.unlimited and found.stands and found.associated.factor == np.inf and found.least is None
    assert not found.collapse(1).mechanism.moving.any()
    assert found.collapse(1).normal_force.sum() == pytest.approx(2000.0 * 9.81 * 0.2, rel=1e-6)
