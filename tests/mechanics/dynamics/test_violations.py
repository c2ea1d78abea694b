# SPDX-License-Identifier: GPL-3.0-or-later
"""Violations of the contact laws after a step in m/s and mm, which no light block under a large force hides in the norm of the error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, material_of, still, tower

from loads.bars import Forces, PointLoad
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.violations import find_violations
from masonry_cd.mechanics.friction.problem import natural_map_error
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw

DT, FRICTION = 1e-3, 0.6


def pushed(
    blocks: list[Block],
    force: tuple[float, float, float],
    steps: int,
    *,
    tolerance: float = 1e-9,
    stiffness: float = 0.0,
    planar: bool = True,
) -> Stepper:
    """Blocks whose last one a force acts on, at its centre [N]."""
    laws = {"default": JointLaw(normal_stiffness=stiffness)} if stiffness else None
    assembly = Assembly.from_blocks(blocks, material_of(FRICTION, laws))
    settings = {"dt": DT, "duration": 1e3, "solver": "auto", "tolerance": tolerance, "threads": 1, "planar": planar}
    held = PointLoad(len(blocks) - 1, np.zeros(3), np.array(force), np.ones(steps + 1))
    return Stepper(assembly, still(steps), gravity(steps), Run.model_validate(settings), forces=Forces((held,), ()))


def cube(density: float = 2000.0) -> Block:
    """A box of 1 m on the ground."""
    return box("cube", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0), density=density)


WEIGHT = 2000.0 * GRAVITY


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("stiffness", [0.0, 1e10])
@pytest.mark.parametrize("share", [0.3, 0.9])  # of the weight: held by friction, and more than it holds
def test_an_exact_step_violates_nothing_whether_its_contacts_stick_or_slide(share: float, stiffness: float, planar: bool) -> None:
    made = pushed([ground(), cube()], (share * WEIGHT, 0.0, 0.0), 40, stiffness=stiffness, planar=planar)
    reports = [made.step() for _ in range(40)]
    assert (made.state.velocity[1, 0] > 0.05) == (share > FRICTION)
    assert max(report.violation.speed for report in reports) <= 1e-8
    assert max(report.violation.slip for report in reports) <= 1e-9


def test_a_stuck_block_that_creeps_is_seen_and_its_slip_adds_up() -> None:
    """A velocity that the impulses do not answer for stands for a solver that stopped early."""
    made, creep = pushed([ground(), cube()], (0.0, 0.0, -WEIGHT), 20), 2e-5
    advance(made, 5)
    assert made.last is not None
    exact, before = made.motion.v, np.zeros_like(made.motion.false_slip)
    for k in range(1, 4):
        violation, after = find_violations(made.system, made.last, made.solution.impulse, exact + [creep, 0.0, 0.0], before)
        assert violation.speed == pytest.approx(creep, rel=1e-3)
        assert violation.slip == pytest.approx(DT * creep, rel=1e-3), "new contacts begin without slip"
        assert violation.opening <= 1e-12 and violation.blocks in ((0, 1), (1, 0))
        kept = replace_previous(made)
        violation, _ = find_violations(made.system, kept, made.solution.impulse, exact + [creep, 0.0, 0.0], k * after)
        assert violation.slip == pytest.approx((k + 1) * DT * creep, rel=1e-3), "contacts found again go on from theirs"
    back, _ = find_violations(made.system, replace_previous(made), made.solution.impulse, exact - [creep, 0.0, 0.0], after)
    assert back.slip <= 1e-3 * DT * creep, "slips there and back cancel"
    up, _ = find_violations(made.system, made.last, made.solution.impulse, exact + [0.0, creep, 0.0], before)
    down, _ = find_violations(made.system, made.last, made.solution.impulse, exact - [0.0, creep, 0.0], before)
    assert up.opening == pytest.approx(DT * creep, rel=1e-3) and down.opening == 0.0
    assert up.speed == pytest.approx(creep, rel=1e-3) == down.speed


def replace_previous(made: Stepper):
    """The problem of the last step, its contacts found where they were before."""
    assert made.last is not None
    count = len(made.last.found.gap)
    return made.last._replace(found=made.last.found._replace(previous=np.arange(count)))


def test_an_impact_is_no_violation() -> None:
    falling = box("cube", (-0.5, -0.5, 0.01), (0.5, 0.5, 1.01))
    made = pushed([ground(), falling], (0.1 * WEIGHT, 0.0, 0.0), 120)
    reports = [made.step() for _ in range(120)]
    assert any(report.apart for report in reports) and max(report.violation.slip for report in reports) <= 1e-9


def light_top(ratio: float, tolerance: float, steps: int) -> Stepper:
    """A tower of three whose light top takes ten times the tower's weight, aslant by a tenth: friction holds six times as much."""
    *rest, top = tower(3)
    force = 10.0 * 3 * 2000.0 * 0.5 * 0.5 * 0.25 * GRAVITY
    mass = force / (ratio * GRAVITY)
    return pushed([*rest, replace(top, density=mass / 0.0625)], (0.1 * force, 0.0, -force), steps, tolerance=tolerance)


@pytest.mark.parametrize("ratio", [1e2, 1e3, 1e4, 1e5, 1e6])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-4])
def test_a_light_block_under_a_large_force_stays_where_friction_holds_it(ratio: float, tolerance: float) -> None:
    """Its slip is bounded by tolerance, step and the mean acceleration of the tower, whatever its mass."""
    steps = 100
    made = light_top(ratio, tolerance, steps)
    begin = made.state.position[-1, 0]
    reports = [made.step() for _ in range(steps)]
    mean = 20.0 * GRAVITY  # of the tower by its weight and the force, at most 1 + 10 / (2/3)
    left = 10.0 * tolerance * DT * mean * np.sqrt(reports[-1].contacts)  # [m/s]
    assert all(report.error <= tolerance for report in reports)
    assert max(report.violation.speed for report in reports[1:]) <= 2.0 * left
    assert abs(made.state.position[-1, 0] - begin) <= 4.0 * left * DT * steps


def test_the_published_error_stays_that_of_the_norm() -> None:
    made = light_top(1e6, 1e-6, 10)
    for _ in range(10):
        report = made.step()
    assert made.last is not None
    published = natural_map_error(made.last.problem, made.solution.impulse)
    assert published <= 1e-2 * 1e-6 and report.error <= 1e-6
    assert published == 0.0 or report.error > 10.0 * published


def test_where_no_block_stands_out_the_error_is_the_published_one() -> None:
    for made in (light_top(1e2, 1e-6, 10), pushed([ground(), cube()], (5e4 * WEIGHT, 0.0, -1e5 * WEIGHT), 10)):
        for _ in range(10):
            report = made.step()
        assert made.last is not None
        if not report.apart:
            assert report.error == natural_map_error(made.last.problem, made.solution.impulse)
