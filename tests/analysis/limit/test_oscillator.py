# SPDX-License-Identifier: GPL-3.0-or-later
"""The oscillator of a mechanism by hand: a free-standing wall, an arch on piers as a linkage of four hinges, a block that slides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from limit_loads import everything, joined, push_loads
from models import GRAVITY, box, ground

from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.candidates import candidates
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.oscillator import Oscillator, oscillator
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joints import Joints
from structures.geometry.prism import prism_xz


def of_blocks(blocks, friction=0.65) -> Oscillator:
    """The oscillator of blocks that are pushed along x, with its curve."""
    assembly, joints = joined(blocks, friction)
    return associated(assembly, joints, capacity_curve(assembly, joints, push_loads(assembly), CurveOptions(LimitOptions(starts=0))))


def associated(assembly: Assembly, joints: Joints, curve: CapacityCurve | None = None) -> Oscillator:
    """The oscillator of the associated mechanism of a push along x."""
    loads = push_loads(assembly)
    analysis = analyse(assembly, joints, loads, LimitOptions(starts=0))
    part = everything(assembly, joints, analysis, loads)
    one = candidates(analysis, [], part)[0]
    assert one.mechanism is not None
    return oscillator(part, one.mechanism, one.oscillator.alpha, one.dilation, curve)


def test_a_free_standing_wall():
    """alpha0 = b/h, all of it moves as its centre does; alpha = tan(beta - theta), tan(beta) = b/h, vanishes when it has moved by b/2."""
    thickness, height, length = 0.5, 4.0, 2.0
    found = of_blocks([ground(4.0), box("wall", (0.0, -1.0, 0.0), (thickness, 1.0, height))])
    ratio, weight = thickness / height, 2000.0 * GRAVITY * thickness * height * length
    assert found.alpha == pytest.approx(ratio, rel=1e-9)
    assert found.weight == pytest.approx(weight, rel=1e-9)
    assert found.mass == pytest.approx(weight / GRAVITY, rel=1e-9)
    assert found.fraction == pytest.approx(1.0, rel=1e-9)
    assert found.acceleration() == pytest.approx(ratio * GRAVITY, rel=1e-9)
    assert found.last == pytest.approx(0.5 * thickness, rel=1e-5)
    beta, radius = math.atan(ratio), 0.5 * math.hypot(thickness, height)
    for share in (0.25, 0.4, 0.6):
        theta = beta - math.asin((1.0 - share) * 0.5 * thickness / radius)
        assert found.acceleration(share * found.last) == pytest.approx(math.tan(beta - theta) * GRAVITY, rel=1e-3)
    assert found.acceleration(2.0 * found.last) == pytest.approx(0.0, abs=1e-5)


def test_courses_that_turn_as_one_are_one_body():
    """A wall of one course and one of eight have equal oscillators: which blocks it is laid of makes no difference."""
    whole = of_blocks([ground(4.0), box("wall", (0.0, -1.0, 0.0), (0.5, 1.0, 4.0))])
    laid = of_blocks([ground(4.0), *(box(f"c{k}", (0.0, -1.0, 0.5 * k), (0.5, 1.0, 0.5 * k + 0.5)) for k in range(8))])
    for name in ("alpha", "weight", "mass", "fraction"):
        assert getattr(laid, name) == pytest.approx(getattr(whole, name), rel=1e-9), name
    assert laid.last == pytest.approx(whole.last, rel=5e-3)  # leaning, it also slides a little
    assert laid.fraction == pytest.approx(1.0, rel=1e-9)


def test_without_a_curve_no_displacement_is_known():
    assembly, joints = joined([ground(4.0), box("slab", (0.0, -1.0, 0.0), (2.0, 1.0, 0.4))], 0.3)
    found = associated(assembly, joints)
    assert found.alpha == pytest.approx(0.3, rel=1e-9)
    assert not found.falls
    assert found.last == math.inf
    assert found.acceleration(1.0) == pytest.approx(0.3 * GRAVITY, rel=1e-9)


def arch_on_piers() -> list[Block]:
    """Ground, left pier, nine voussoirs of a semicircle, right pier; a chain."""
    inner, outer, width, tall, count = 2.0, 2.5, 0.9, 3.0, 9
    blocks = [
        box("ground", (-5.0, -0.5, -0.5), (5.0, 0.5, 0.0), fixed=True),
        box("left", (-outer - width + 0.5, -0.5, 0), (-inner, 0.5, tall)),
    ]
    angles = np.linspace(math.pi, 0.0, count + 1)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    up = np.array([0.0, tall])
    for k in range(count):
        corners = up + np.array([inner * rays[k + 1], outer * rays[k + 1], outer * rays[k], inner * rays[k]])
        blocks.append(Block(f"v{k}", *prism_xz(corners, -0.5, 0.5), 2000.0))
    return [*blocks, box("right", (inner, -0.5, 0.0), (outer + width - 0.5, 0.5, tall))]


def linkage(theta: float, hinges: np.ndarray, bodies: list[np.ndarray]) -> np.ndarray:
    """Places of the centres of three bars A-B, B-C, C-D that have turned by theta about A; A and D are fixed, (n, 2)."""
    a, b, c, d = hinges
    turned = a + turn(theta) @ (b - a)
    reach, first, second = np.linalg.norm(d - turned), np.linalg.norm(c - b), np.linalg.norm(d - c)
    along = (reach**2 + first**2 - second**2) / (2.0 * reach)
    axis = (d - turned) / reach
    aside = math.sqrt(first**2 - along**2) * np.array([-axis[1], axis[0]])
    third = min((turned + along * axis + side * aside for side in (1.0, -1.0)), key=lambda place: float(np.linalg.norm(place - c)))
    moved = [a + (bodies[0] - a) @ turn(theta).T]
    for base, tip, at, to, centres in ((b, c, turned, third, bodies[1]), (d, c, d, third, bodies[2])):
        old, new = tip - base, to - at
        angle = math.atan2(new[1], new[0]) - math.atan2(old[1], old[0])
        moved.append(at + (centres - base) @ turn(angle).T)
    return np.concatenate(moved)


def turn(angle: float) -> np.ndarray:
    """Turn vectors in the plane."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def test_an_arch_on_piers_is_a_linkage_of_four_hinges():
    """Every value from the linkage turned by finite angles: alpha = d(sum P z) / d(sum P x)."""
    blocks = arch_on_piers()
    assembly, joints = joined(blocks, 5.0)
    found = analyse(assembly, joints, push_loads(assembly), LimitOptions(starts=0))
    moves = found.associated.mechanism
    hinged = np.flatnonzero(moves.state == STATES.index("hinge"))
    assert len(hinged) == 4 and moves.count("slide") == 0
    chain = [0, *range(1, 12), 0]  # ground, left pier, voussoirs, right pier, ground
    pairs = [{int(joints.block_a[j]), int(joints.block_b[j])} for j in hinged]
    at = [next(k for k in range(12) if {chain[k], chain[k + 1]} == pair) for pair in pairs]
    order = np.argsort(at)
    cuts, hinges = np.array(at)[order], moves.hinge[hinged[order]][:, [0, 2]]
    bodies = [np.arange(cuts[k] + 1, cuts[k + 1] + 1) for k in range(3)]
    mass = np.concatenate([assembly.mass[body] for body in bodies])
    centres = [assembly.centre[body][:, [0, 2]] for body in bodies]

    def places(theta: float) -> np.ndarray:
        return linkage(theta, hinges, centres)

    step = 1e-4
    sign = math.copysign(1.0, float(mass @ (places(step) - places(-step))[:, 0]))

    def alpha(theta: float) -> float:
        rate = places(sign * (theta + step)) - places(sign * (theta - step))
        return float(mass @ rate[:, 1] / (mass @ rate[:, 0]))

    each = (places(sign * step) - places(-sign * step))[:, 0] / (2.0 * step)
    parts = np.split(np.arange(len(mass)), np.cumsum([len(body) for body in bodies])[:-1])  # each bar is one body, at its centre
    weight = GRAVITY * np.array([mass[part].sum() for part in parts])
    move = np.array([mass[part] @ each[part] / mass[part].sum() for part in parts])
    curve = capacity_curve(assembly, joints, push_loads(assembly), CurveOptions(LimitOptions(starts=0)))
    made = associated(assembly, joints, curve)
    assert made.alpha == pytest.approx(alpha(0.0), rel=1e-6)
    assert made.weight == pytest.approx(weight.sum(), rel=1e-9)
    assert made.mass == pytest.approx((weight @ move) ** 2 / (GRAVITY * weight @ move**2), rel=1e-6)
    assert made.fraction == pytest.approx((weight @ move) ** 2 / (weight.sum() * (weight @ move**2)), rel=1e-6)
    assert 0.5 < made.fraction < 1.0
    assert made.acceleration() == pytest.approx(alpha(0.0) * GRAVITY / made.fraction, rel=1e-6)
    low, high = 0.0, 0.5
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if alpha(middle) > 0.0 else (low, middle)
    row = int(np.flatnonzero(np.concatenate(bodies) == curve.control.block)[0])
    control = float((places(sign * low) - places(0.0))[row, 0])
    assert curve.displacement[-1] == pytest.approx(control, rel=1e-3)
    assert made.last == pytest.approx(control / each[row] * (weight @ move**2) / (weight @ move), rel=1e-3)
    half = 0.5 * low
    there = float((places(sign * half) - places(0.0))[row, 0]) / control * made.last
    assert made.acceleration(there) == pytest.approx(alpha(half) * GRAVITY / made.fraction, rel=1e-3)
