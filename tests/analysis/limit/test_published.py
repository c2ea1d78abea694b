# SPDX-License-Identifier: GPL-3.0-or-later
"""Published and exact numbers of limit analysis: dry walls, arches by thickness, friction and push."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from limit_loads import joined, push_loads, pushed
from models import box
from scipy.linalg import null_space
from scipy.optimize import brentq

from benchmarks.dry_walls import ASSOCIATED, FRICTION, LEAST, dry_wall
from masonry_cd.analysis.limit.analysis import STANDS, Analysis, LimitOptions, at_rest
from masonry_cd.analysis.limit.problem import LimitProblem, limit_problem
from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import prism_xz


def arch(count: int, ratio: float, embrace: float = 180.0, radius: float = 10.0) -> list[Block]:
    """Straight-edged voussoirs of thickness ratio * radius between fixed ones that continue them."""
    half, step = 0.5 * ratio * radius, embrace / count
    angles = np.radians(90.0 + embrace / 2 + step - step * np.arange(count + 3))
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    inner, outer = (radius - half) * rays, (radius + half) * rays
    blocks = []
    for k in range(count + 2):
        corners = np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]])
        fixed = k in (0, count + 1)
        blocks.append(Block(f"v{k}", *prism_xz(corners, -0.5, 0.5), 2000.0, "base" if fixed else "arch", fixed=fixed))
    return blocks


@pytest.mark.parametrize("wall", ASSOCIATED)
def test_associated_factor_of_the_dry_walls(wall):
    analysis = pushed(dry_wall(wall), FRICTION)
    assert analysis.stands
    assert analysis.problem.axis == 1
    assert analysis.associated.factor == pytest.approx(ASSOCIATED[wall], abs=1e-5)
    made = analysis.associated.certificate
    assert made.kinematic == pytest.approx(made.static, abs=1e-9)
    assert max(made.equilibrium, made.friction, made.flow) < 1e-9


@pytest.mark.parametrize("wall", [2, 3, 4, 5])
def test_least_factor_without_dilation_of_the_dry_walls(wall):
    """A pair whose gap is nothing proves that its factor is one of Coulomb's law; of walls 2, 5 and 6 it is less than the published one."""
    analysis = pushed(dry_wall(wall), FRICTION, options=LimitOptions(starts=2))
    assert analysis.least is not None and analysis.least.gap < 1e-12
    assert 0.97 * LEAST[wall] < analysis.least.optimum.factor < (1.0 + 1e-2) * LEAST[wall]
    assert analysis.least.optimum.factor < analysis.associated.factor


def test_least_factor_without_dilation_of_the_largest_wall():
    analysis = pushed(dry_wall(6), FRICTION, options=LimitOptions(starts=1))
    assert analysis.least is not None and analysis.least.gap < 1e-12
    assert 0.97 * LEAST[6] < analysis.least.optimum.factor < LEAST[6]


def test_least_factor_in_space_of_a_wall_next_to_a_lone_block_out_of_its_plane():
    apart = box("apart", (0.0, 2.0, 0.0), (1.0, 3.0, 0.5))
    in_space = pushed([*dry_wall(3), apart], FRICTION, options=LimitOptions(starts=1))
    assert in_space.problem.axis is None and in_space.least is not None
    assert in_space.least.optimum.factor == pytest.approx(LEAST[3], rel=0.02)
    assert in_space.least.gap < 1e-4


def test_minimum_thickness_of_an_arch_by_bisection():
    thin, thick = 0.100, 0.115
    while thick - thin > 2e-5:
        middle = 0.5 * (thin + thick)
        thin, thick = (thin, middle) if pushed(arch(27, middle), 10.0).stands else (middle, thick)
    assert 0.5 * (thin + thick) == pytest.approx(0.10672, abs=1e-4)


def edges(problem: LimitProblem) -> np.ndarray:
    """Rows n + mu t and n - mu t of all points, times which no velocities of a mechanism are below zero."""
    lean = problem.mu[:, None] * problem.jacobian[1::2].toarray()
    return np.concatenate([problem.jacobian[0::2].toarray() + lean, problem.jacobian[0::2].toarray() - lean])


def power(ratio: float, count: int, mu: float, fall: Analysis) -> float:
    """Power of the weights of an arch of a thickness in the mechanism with the hinges and slips of another's that is nearest to it."""
    blocks, joints = joined(arch(count, ratio), mu)
    problem = limit_problem(blocks, joints, push_loads(blocks))
    velocity = fall.associated.optimum.velocity
    kept = edges(fall.problem) @ velocity < 1e-7 * np.abs(velocity).max()
    free = null_space(edges(problem)[kept], rcond=1e-9)
    assert 1 <= free.shape[1] <= 3  # more than one where the mechanism is symmetric, or several are as good
    return float(problem.dead @ (free @ (free.T @ velocity)))


def minimum_thickness(count: int, mu: float, ratio: float) -> tuple[float, int]:
    """The least thickness over radius that stands, from below, with the thickness as the unknown of the virtual work, and the rounds.

    What falls at a thickness falls by a mechanism, whose joints do no work any more at a greater one. That is the next: Newton's method.
    """
    for rounds in range(20):
        fall = pushed(arch(count, ratio), mu)
        if fall.stands:
            return ratio, rounds
        ratio = float(brentq(power, ratio, 1.5 * ratio, (count, mu, fall), xtol=1e-10)) + 1e-9
    raise AssertionError("no end")


@pytest.mark.parametrize(
    ("count", "mu", "start", "ratio"),
    [(11, 10.0, 0.08, 0.10459), (15, 10.0, 0.08, 0.10607), (27, 10.0, 0.08, 0.10672), (27, 0.32, 0.15, 0.1838), (27, 0.39, 0.08, 0.1116)],
)
def test_minimum_thickness_of_an_arch_as_an_unknown(count, mu, start, ratio):
    found, rounds = minimum_thickness(count, mu, start)
    assert found == pytest.approx(ratio, abs=1e-4)
    assert 1 <= rounds <= 4


@pytest.mark.parametrize(("count", "ratio"), [(11, 0.10459), (13, 0.10253), (15, 0.10607), (21, 0.10669), (51, 0.10736)])
def test_arches_stand_above_their_minimum_thickness_and_fall_below(count, ratio):
    assert pushed(arch(count, ratio + 1e-4), 10.0).stands
    fall = pushed(arch(count, ratio - 1e-4), 10.0)
    assert not fall.stands
    assert fall.associated.mechanism.moving.any()


@pytest.mark.parametrize(("mu", "ratio"), [(0.32, 0.1838), (0.36, 0.1409), (0.39, 0.1116)])
def test_minimum_thickness_by_friction(mu, ratio):
    assert pushed(arch(27, ratio + 1e-4), mu).stands
    assert not pushed(arch(27, ratio - 1e-4), mu).stands


@pytest.mark.parametrize(
    ("ratio", "push"), [(0.11, 0.0123), (0.12, 0.0484), (0.125, 0.0655), (0.15, 0.1453), (0.2, 0.2843), (0.25, 0.4082), (0.3, 0.5194)]
)
def test_horizontal_capacity_of_arches(ratio, push):
    assert pushed(arch(27, ratio), 10.0).associated.factor == pytest.approx(push, abs=1e-4)


def test_oppenheims_arch():
    """Seven voussoirs, 10 m to their middle, 1.5 m thick, embrace 157.5 degrees (Earthquake Eng. Struct. Dyn. 21, 1992)."""
    assert pushed(arch(7, 0.15, 157.5), 10.0).associated.factor == pytest.approx(0.3736, abs=1e-4)


@pytest.mark.parametrize(("ratio", "push"), [(0.125, 0.0655), (0.3, 0.5194)])
def test_horizontal_capacity_of_arches_by_what_stands_under_a_push_that_is_held(ratio, push):
    assembly, joints = joined(arch(27, ratio), 10.0)
    loads = push_loads(assembly)
    for factor, stands in ((push - 1e-4, True), (push + 1e-4, False)):
        held = replace(loads, dead=loads.dead + factor * loads.live)
        assert (at_rest(assembly, joints, held)[1].factor > 1.0 - STANDS) == stands


def test_a_wall_next_to_a_lone_block_out_of_its_plane_bears_as_much():
    apart = box("apart", (0.0, 2.0, 0.0), (1.0, 3.0, 0.5))
    in_space = pushed([*dry_wall(1), apart], FRICTION)
    assert in_space.problem.axis is None
    assert in_space.associated.factor == pytest.approx(ASSOCIATED[1], abs=1e-5)
