# SPDX-License-Identifier: GPL-3.0-or-later
"""Capacity curves against closed forms: a rocking block, a wall of two blocks held at its top, sliding, a tie, bond, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import GRAVITY, box, ground
from released_from_curve import brackets

from benchmarks.dry_walls import FRICTION, dry_wall
from masonry_cd.analysis.limit.analysis import LimitOptions
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.moved import Placement
from masonry_cd.analysis.limit.problem import Arms, Bars, BlockLoads
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly

WIDTH, HEIGHT = 0.5, 1.5


def rocking(displacement: np.ndarray, width: float = WIDTH, height: float = HEIGHT) -> np.ndarray:
    """Factor of a block turned about its toe so far that its centre has moved by a displacement: tan(alpha - theta)."""
    across = 0.5 * width - displacement  # of the centre from the toe
    return across / np.sqrt(0.25 * (width**2 + height**2) - across**2)


def pillar(depth: tuple[float, float]) -> tuple[Assembly, BlockLoads]:
    """A block on the ground under a push."""
    assembly, _ = joined([ground(2.0), box("a", (0.0, depth[0], 0.0), (WIDTH, depth[1], HEIGHT))], 0.6)
    return assembly, push_loads(assembly)


@pytest.mark.parametrize(("depth", "within"), [((-0.2, 0.2), 1e-9), ((-0.2, 0.3), 1e-6)])  # in a plane, and in space
def test_a_rocking_block_bears_the_tangent_of_what_is_left_of_its_angle(depth, within):
    assembly, loads = pillar(depth)
    curve = capacity_curve(assembly, find_joints(assembly), loads)
    assert curve.factor == pytest.approx(rocking(curve.displacement), abs=within * 3)
    assert curve.ultimate == pytest.approx(0.5 * WIDTH, rel=1e-5)
    assert curve.end == "the factor vanishes"
    assert not curve.changes
    assert 30 <= len(curve.factor) <= 60
    assert curve.stages[-1].at_work() == {(0, 1, "hinge")}
    assert curve.stages[-1].assembly.blocks[1].vertices[1] == pytest.approx([WIDTH, depth[0], 0.0], abs=1e-9)  # the toe stayed where it was


def two_blocks(lower: float, upper: float, stop: float) -> Assembly:
    """A wall of two blocks, 0.25 m thick; a smooth stop from ``stop`` below its top upwards holds it."""
    top = lower + upper
    held = replace(box("stop", (0.25, -0.5, top - stop), (0.55, 0.5, top + 0.5), fixed=True), group="stop")
    blocks = [ground(2.0), box("a", (0.0, -0.5, 0.0), (0.25, 0.5, lower)), box("b", (0.0, -0.5, lower), (0.25, 0.5, top)), held]
    return Assembly.from_blocks(blocks, {"default": 0.7, "block-stop": 0.0})


def bending(theta: np.ndarray, lower: float, upper: float, stop: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of the lower block's centre, and factor, when the lower block has turned by theta about its toe: virtual work.

    The upper block hinges on the lower one's heel and turns back by phi, so that its face stays on the edge of the stop.
    """
    t, c, s = 0.25, np.cos(theta), np.sin(theta)
    heel = np.array([t - t * c + lower * s, t * s + lower * c])
    heel_rate = np.array([t * s + lower * c, t * c - lower * s])
    edge, phi = lower + upper - stop, theta * lower / upper
    for _ in range(60):
        miss = (t - heel[0]) * np.cos(phi) + (edge - heel[1]) * np.sin(phi) - t
        phi = phi - miss / (-(t - heel[0]) * np.sin(phi) + (edge - heel[1]) * np.cos(phi))
    cc, ss = np.cos(phi), np.sin(phi)
    phi_rate = (heel_rate[0] * cc + heel_rate[1] * ss) / (-(t - heel[0]) * ss + (edge - heel[1]) * cc)
    first = 0.5 * np.array([t * s + lower * c, t * c - lower * s])
    second = heel_rate + 0.5 * phi_rate * np.array([-t * ss - upper * cc, t * cc - upper * ss])
    factor = (lower * first[1] + upper * second[1]) / (lower * first[0] + upper * second[0])
    return 0.5 * (t - t * c + lower * s), factor


@pytest.mark.parametrize(("lower", "upper"), [(1.5, 1.5), (2.0, 1.0)])
def test_a_wall_held_at_its_top_bends_upwards_between_three_hinges(lower, upper):
    assembly = two_blocks(lower, upper, 0.2)
    curve = capacity_curve(assembly, find_joints(assembly), push_loads(assembly), CurveOptions(control=1))
    places, factors = bending(np.linspace(0.0, 0.25, 100001), lower, upper, 0.2)
    assert curve.factor == pytest.approx(np.interp(curve.displacement, places, factors), abs=1e-8)
    assert curve.ultimate is None  # the upper block falls back from its stop before the factor has vanished
    assert curve.end == "beyond, no factor of the load is borne: blocks fall by themselves"
    upper_block = curve.stages[-1].assembly.blocks[2]
    assert upper_block.vertices[:, 0].min() < -0.03


def test_a_sliding_block_keeps_its_factor_until_it_tips_over_the_edge():
    plate = box("plate", (-2.0, -0.5, -0.5), (0.6, 0.5, 0.0), fixed=True)
    assembly, joints = joined([plate, box("a", (0.0, -0.5, 0.0), (0.6, 0.5, 0.2))], 0.3)
    curve = capacity_curve(assembly, joints, push_loads(assembly), CurveOptions(LimitOptions(starts=1), limit=0.1))
    assert curve.factor == pytest.approx(np.full(len(curve.factor), 0.3), abs=1e-9)
    assert curve.stages[-1].assembly.centre[1, 2] == pytest.approx(0.1, abs=1e-9)  # it slides and does not climb
    assert curve.displacement[-1] >= 0.1
    assert curve.ultimate is None
    assert "displacement of 100 mm is reached" in curve.end


def slider_and_pebbles(count: int) -> Assembly:
    """A block that slides for 0.1 m and then meets rough pebbles, one after the other, 0.3 mm apart; all faces between them are smooth."""
    places = 0.4 + 0.0403 * np.arange(count)
    pebbles = [replace(box(f"p{k}", (x, -0.1, 0.0), (x + 0.04, 0.1, 0.04)), group="pebble") for k, x in enumerate(places)]
    blocks = [ground(3.0), box("slider", (0.0, -0.1, 0.0), (0.3, 0.1, 0.2)), *pebbles]
    smooth = {"block-pebble": 0.0, "pebble-pebble": 0.0}
    return Assembly.from_blocks(blocks, {"default": 0.3, "base-pebble": 0.9, **smooth})


@pytest.mark.parametrize(("count", "stalls"), [(12, True), (8, False)])
def test_a_curve_whose_blocks_meet_at_every_step_ends(count, stalls):
    assembly = slider_and_pebbles(count)
    options = CurveOptions(LimitOptions(starts=1), limit=0.15, control=1)
    curve = capacity_curve(assembly, find_joints(assembly), push_loads(assembly), options)
    assert ("blocks meet at every step" in curve.end) is stalls
    last = float(curve.displacement[-1])
    assert (0.1 < last < 0.105) if stalls else (last > 0.15)
    mass, rough = assembly.mass[1], assembly.mass[2]
    pushed = int(np.floor((last - 0.1) / 3e-4 + 1e-3)) + 1 if stalls else count
    assert curve.factor[-1] == pytest.approx((0.3 * mass + 0.9 * pushed * rough) / (mass + pushed * rough), rel=1e-6)


def test_a_tie_that_yields_goes_on_pulling_as_it_is_then_directed():
    blocks = [ground(3.0), box("a", (0.0, -0.2, 0.0), (WIDTH, 0.2, HEIGHT)), box("far", (-2.0, -0.2, 0.0), (-1.5, 0.2, 1.5), fixed=True)]
    assembly, joints = joined(blocks, 0.6)
    ends = np.array([[[-1.5, 0.0, HEIGHT], [0.0, 0.0, HEIGHT]]])
    bars = Bars(np.array([[2, 1]]), ends, np.array([500.0]))
    curve = capacity_curve(assembly, joints, push_loads(assembly, bars=bars))
    weight = 2000.0 * GRAVITY * WIDTH * 0.4 * HEIGHT
    for k in (0, len(curve.factor) // 2, len(curve.factor) - 1):
        corner, centre = curve.stages[k].assembly.blocks[1].vertices[4], curve.stages[k].assembly.centre[1]
        line = np.array([-1.5, 0.0, HEIGHT]) - [corner[0], 0.0, corner[2]]
        pull = 500.0 * line / np.linalg.norm(line)
        arm = np.array([corner[0] - WIDTH, corner[2]])
        back = pull[2] * arm[0] - pull[0] * arm[1]  # its moment about the toe against the fall
        expected = (weight * (WIDTH - centre[0]) + back) / (weight * centre[2])
        assert curve.factor[k] == pytest.approx(expected, abs=1e-7)
    assert curve.ultimate > 0.5 * WIDTH


def test_a_point_load_turns_with_its_block():
    assembly, loads = pillar((-0.2, 0.2))
    down, arm = np.array([0.0, 0.0, -3000.0]), np.array([0.1, 0.0, 0.75])
    dead = loads.dead.copy()
    dead[1] += [*down, *np.cross(arm, down)]
    loads = replace(loads, dead=dead, arms=Arms(np.array([1]), arm[None], down[None], np.zeros((1, 3))))
    curve = capacity_curve(assembly, find_joints(assembly), loads)
    last = curve.stages[-1].assembly
    place = (
        last.centre[1]
        + (last.blocks[1].vertices - last.centre[1]).T @ np.linalg.pinv((assembly.blocks[1].vertices - assembly.centre[1]).T) @ arm
    )
    weight = 2000.0 * GRAVITY * WIDTH * 0.4 * HEIGHT
    assert weight * (WIDTH - last.centre[1, 0]) + 3000.0 * (WIDTH - place[0]) == pytest.approx(0.0, abs=0.1)


def test_bond_is_lost_as_soon_as_its_joint_opens():
    from masonry_cd.mechanics.model.joint_laws import JointLaw

    law = {"default": JointLaw(cohesion=1000.0, tension=500.0, normal_stiffness=1e10)}
    assembly, joints = joined([ground(2.0), box("a", (0.0, -0.2, 0.0), (WIDTH, 0.2, HEIGHT))], 0.6, law)
    curve = capacity_curve(assembly, joints, push_loads(assembly))
    assert curve.factor[0] > 1.01 * WIDTH / HEIGHT
    assert curve.factor[1:] == pytest.approx(rocking(curve.displacement[1:]), abs=1e-8)


def test_blocks_are_moved_along_their_screws():
    assembly, _ = pillar((-0.2, 0.2))
    toe, turn = np.array([WIDTH, 0.0, 0.0]), np.array([0.0, 0.7, 0.0])
    velocity = np.zeros((2, 6))
    velocity[1] = [*np.cross(turn, assembly.centre[1] - toe), *turn]
    whole = Placement.as_built(assembly).along(velocity, 1.0)
    steps = Placement.as_built(assembly)
    assert np.linalg.norm(whole.position[1] - toe) == pytest.approx(np.linalg.norm(assembly.centre[1] - toe), rel=1e-12)
    for _ in range(1000):
        velocity[1, :3] = np.cross(turn, steps.position[1] - toe)
        steps = steps.along(velocity, 1e-3)
    assert steps.position == pytest.approx(whole.position, abs=1e-10)
    assert steps.rotation == pytest.approx(whole.rotation, abs=1e-10)


def test_what_has_no_factor_to_follow_is_refused():
    assembly, loads = pillar((-0.2, 0.2))
    with pytest.raises(InputError, match=r"limit\.curve: supports that move"):
        capacity_curve(assembly, find_joints(assembly), replace(loads, support_velocity=np.ones((2, 3))))
    with pytest.raises(InputError, match='block "ground" is a support'):
        capacity_curve(assembly, find_joints(assembly), loads, CurveOptions(control=0))
    leaning, joints = joined([box("plate", (-1.0, -0.5, -0.5), (0.1, 0.5, 0.0), True), box("a", (0.0, -0.5, 0.0), (0.5, 0.5, 1.0))], 0.6)
    with pytest.raises(InputError, match="does not stand"):
        capacity_curve(leaning, joints, push_loads(leaning))


@pytest.mark.parametrize(("wall", "first"), [(1, 0.63898), (4, 0.263736)])  # wall 4 goes on sliding though hinges alone would be an answer
def test_a_dry_wall_whose_contacts_give_way_goes_on_and_the_dynamics_bracket_it(wall, first):
    assembly, joints = joined(dry_wall(wall), FRICTION)
    curve = capacity_curve(assembly, joints, push_loads(assembly), CurveOptions(LimitOptions(starts=1), limit=0.05))
    assert curve.factor[0] == pytest.approx(first, abs=1e-5)
    assert curve.end == "the control displacement of 50 mm is reached"
    assert curve.displacement[-1] < 0.06
    for bracket in brackets(curve, assembly.laws, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -GRAVITY])):
        assert bracket.low <= bracket.factor + 1e-3 and bracket.factor <= bracket.high + 1e-3
        assert bracket.high - bracket.low < 0.011 * curve.factor[0]


def test_a_dry_wall_is_followed_until_its_factor_vanishes():
    assembly, joints = joined(dry_wall(1), FRICTION)
    curve = capacity_curve(assembly, joints, push_loads(assembly), CurveOptions(LimitOptions(starts=1)))
    assert curve.end == "the factor vanishes"
    last = curve.stages[-1]
    ((_, _, state),) = last.at_work()
    assert state == "hinge"  # the blocks above a stair of joints topple over one edge, and stand upright on it
    moving = last.mechanism.moving
    upright = np.average(last.assembly.centre[moving, 0], weights=assembly.mass[moving])
    assert upright == pytest.approx(last.mechanism.hinge[last.mechanism.state == 1][0, 0], abs=1e-6)


def test_no_block_slides_back_against_the_push_where_contacts_give_way():
    assembly = Assembly.from_blocks(dry_wall(6), FRICTION)
    options = CurveOptions(LimitOptions(starts=1), limit=1.535e-3)
    curve = capacity_curve(assembly, find_joints(assembly), push_loads(assembly), options)
    gone = curve.stages[-1].assembly.centre[:, 0] - assembly.centre[:, 0]
    assert (
        gone.min() > -1e-5
    )  # a row went 5 mm back in the second step, and 0.1 m by the tenth, while corrections could slide back for nothing
    assert curve.factor[-1] == pytest.approx(curve.factor[0], rel=0.05)


def test_a_curve_ends_close_to_the_displacement_asked_for():
    assembly, loads = pillar((-0.2, 0.2))
    curve = capacity_curve(assembly, find_joints(assembly), loads, CurveOptions(steps=10, limit=0.07))
    assert curve.end == "the control displacement of 70 mm is reached"
    assert 0.07 <= curve.displacement[-1] < 0.07 * 1.06


def test_the_marks_are_the_start_the_peak_the_middle_and_the_end():
    assembly, loads = pillar((-0.2, 0.2))
    curve: CapacityCurve = capacity_curve(assembly, find_joints(assembly), loads)
    first, half, last = curve.marks
    assert (first, last) == (0, len(curve.factor) - 1)
    assert curve.displacement[half] == pytest.approx(0.5 * curve.displacement[-1], rel=0.06)
