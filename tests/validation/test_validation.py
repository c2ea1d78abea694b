# SPDX-License-Identifier: GPL-3.0-or-later
"""Long comparisons with published and exact numbers: run them with ``pytest -m validation -s``, which prints the tables.

Sources: limit analysis (linear programmes on the same blocks), Milankovitch's and Makris & Alexakis' arch, Ferris & Tin-Loi's dry wall,
Housner's rocking block. All of them are recomputed figures; voussoir count and cut are part of the case.
"""

from __future__ import annotations

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, stepper, still, tower, wall

from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import prism_xz

pytestmark = pytest.mark.validation
AUTO = {"solver": "auto", "tolerance": 1e-8}


def arch(count: int, ratio: float, radius: float = 10.0, embrace: float = 180.0) -> list[Block]:
    """Straight-edged voussoirs of thickness ratio * radius on fixed abutments with radial seats."""
    half = 0.5 * ratio * radius
    angles = np.radians(90.0 + embrace / 2 - embrace * np.arange(count + 1) / count)  # from the left springing
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    inner, outer = (radius - half) * rays, (radius + half) * rays
    blocks = []
    for k in range(count):
        corners = np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]])
        blocks.append(Block(f"v{k + 1}", *prism_xz(corners, -0.5, 0.5), 2000.0, "arch"))
    for name, end, sense in (("left", 0, -1.0), ("right", count, 1.0)):
        tangent = sense * np.array([rays[end][1], -rays[end][0]])
        seat = np.array([inner[end] - 0.2 * half * rays[end], outer[end] + 0.2 * half * rays[end]])
        corners = np.concatenate([seat, seat[::-1] + half * tangent])
        blocks.append(Block(name, *prism_xz(corners, -0.6, 0.6), 2000.0, "base", fixed=True))
    return blocks


def stands(blocks: list[Block], mu: float, seconds: float = 1.5, dt: float = 2e-3) -> bool:
    """Return True if a structure is still where it was built after some seconds under its own weight."""
    steps = round(seconds / dt)
    machine = stepper(blocks, steps, friction=mu, dt=dt, **AUTO)
    for _ in range(steps):
        machine.step()
        moved = np.abs(machine.state.position - machine.assembly.centre).max()
        if moved > 1e-3:
            return False
    return bool(moved < 1e-4)


@pytest.mark.parametrize(("count", "ratio"), [(11, 0.10459), (13, 0.10253), (15, 0.10607), (21, 0.10669), (27, 0.10672), (51, 0.10736)])
def test_minimum_thickness_by_voussoirs(count, ratio):
    assert stands(arch(count, 1.005 * ratio), mu=1.0)
    assert not stands(arch(count, 0.995 * ratio), mu=1.0)


def test_minimum_thickness_of_27_voussoirs_at_mu_half():
    assert stands(arch(27, 0.1069), mu=0.5)
    assert not stands(arch(27, 0.1065), mu=0.5)


@pytest.mark.parametrize(("mu", "ratio"), [(0.32, 0.1838), (0.34, 0.1618), (0.36, 0.1409), (0.38, 0.1211), (0.39, 0.1116)])
def test_minimum_thickness_by_friction(mu, ratio):
    assert stands(arch(27, 1.005 * ratio), mu)
    assert not stands(arch(27, 0.995 * ratio), mu)


@pytest.mark.parametrize(("degrees", "ratio"), [(120.0, 0.0229), (140.0, 0.0413), (157.5, 0.0647), (170.0, 0.0865)])
def test_minimum_thickness_by_embrace(degrees, ratio):
    rounding = 0.00005 / ratio  # the reference has four decimals
    assert stands(arch(180, (1.005 + rounding) * ratio, embrace=degrees), mu=1.0)
    assert not stands(arch(180, (0.995 - rounding) * ratio, embrace=degrees), mu=1.0)


def critical_push(blocks: list[Block], mu: float, guess: float, dt: float = 2e-3, seconds: float = 8.0) -> float:
    """The horizontal acceleration over g at which a structure starts to move when it grows slowly from zero."""
    steps = round(1.3 * seconds / dt)
    pull = gravity(steps)
    pull[:, 0] = -GRAVITY * guess * np.arange(steps + 1) * dt / seconds
    machine = stepper(blocks, steps, friction=mu, dt=dt, acceleration=pull, **AUTO)
    for _ in range(steps):
        machine.step()
        if np.abs(machine.state.position - machine.assembly.centre).max() > 1e-6:
            break
    return guess * machine.state.time / seconds


@pytest.mark.parametrize(
    ("ratio", "push"), [(0.11, 0.0123), (0.12, 0.0484), (0.125, 0.0655), (0.15, 0.1453), (0.2, 0.2843), (0.25, 0.4082), (0.3, 0.5194)]
)
def test_horizontal_capacity_of_arches(ratio, push, capsys):
    got = critical_push(arch(27, ratio), 1.0, push)
    with capsys.disabled():
        print(f"\narch, N 27, t/R {ratio}: lambda {got:.4f}, limit analysis {push}", end=" ")
    assert got == pytest.approx(push, rel=1e-2)


def test_horizontal_capacity_of_the_dry_wall(capsys):
    rows = [[0.5, 1, 1, 1, 1, 0.5], [1, 1, 1, 1, 1]] * 3
    blocks = [ground(5.0)]
    for course, row in enumerate(rows):
        edges = 0.4 * np.concatenate([[0.0], np.cumsum(row)])
        for k in range(len(row)):
            low, high = (edges[k], -0.1, 0.175 * course), (edges[k + 1], 0.1, 0.175 * (course + 1))
            blocks.append(box(f"c{course}.{k}", low, high))
    got = critical_push(blocks, 0.65, 0.643)
    with capsys.disabled():
        print(f"\ndry wall 1: lambda {got:.4f}, associated limit analysis 0.6429", end=" ")
    assert 0.97 * 0.64286 < got < 1.005 * 0.64286


@pytest.mark.parametrize(("frequency", "amplitude"), [(0.5, 0.34), (1.0, 0.465), (1.5, 0.595), (2.0, 0.73), (3.0, 0.99)])
def test_smallest_overturning_pulse(frequency, amplitude):
    def overturns(factor: float, dt: float = 1e-3) -> bool:
        end = 0.5 / frequency
        steps = round((end + 3.0) / dt)
        omega, time = 2 * np.pi * frequency, np.arange(steps + 1) * dt
        velocity = still(steps)
        velocity[:, 0, 0] = factor * amplitude * GRAVITY / omega * (1 - np.cos(omega * np.minimum(time, end)))
        block = box("b", (-0.2, -0.2, 0.0), (0.2, 0.2, 1.6))
        machine = stepper([ground(), block], steps, friction=1.0, dt=dt, support_velocity=velocity)
        for _ in range(steps):
            machine.step()
            if abs(machine.state.orientation[1, 2]) > 0.4:
                return True
        return False

    assert overturns(1.01)  # the reference is rounded up to 0.005 g
    assert not overturns(0.98)


@pytest.mark.parametrize("count", [10, 50])
def test_towers_at_rest_do_not_sink(count, capsys):
    machine = stepper(tower(count), 4000, dt=5e-3, **AUTO)
    deepest = 0.0
    for _ in range(4000):
        deepest = max(deepest, machine.step().penetration)
    moved = np.abs(machine.state.position - machine.assembly.centre).max()
    with capsys.disabled():
        print(f"\ntower of {count} at rest for 20 s: moved {1e6 * moved:.4f} um, penetration {1e6 * deepest:.4f} um", end=" ")
    assert deepest < 1e-6
    assert moved < 2e-7  # what a tolerance of 1e-8 leaves of g h in every one of 4,000 steps adds up to 2 um at worst


@pytest.mark.parametrize("ratio", [10.0, 1e3, 1e5])
def test_heavy_on_light_does_not_sink(ratio):
    blocks = tower(5)
    top = blocks[-1]
    blocks[-1] = Block(top.name, top.vertices, top.faces, ratio * top.density, top.group)
    machine = stepper(blocks, 400, dt=5e-3, **AUTO)
    advance(machine, 400)
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-6


def test_a_coarse_step_does_not_topple_a_tower():
    machine = stepper(tower(10), 400, dt=0.05, **AUTO)
    advance(machine, 400)
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-6


def test_a_wall_of_400_blocks_is_thrown_down_and_comes_to_rest():
    dt, shaken, steps = 2e-3, 2.0, 2500
    time = np.arange(steps + 1) * dt
    velocity = still(steps)
    velocity[:, 0, 1] = np.where(time < shaken, 1.5 * np.sin(2 * np.pi * time), 0.0)
    velocity[:, 0, 0] = np.where(time < shaken, 0.5 * np.sin(3 * np.pi * time), 0.0)
    blocks = [ground(30.0), *wall(20, 20)[1:]]  # wide enough that nothing leaves it
    machine = stepper(blocks, steps, dt=dt, support_velocity=velocity, solver="auto", tolerance=1e-6, max_iterations=150)
    for _ in range(steps):
        report = machine.step()
    dropped = (machine.assembly.centre - machine.state.position)[1:, 2] > 0.1
    assert dropped.mean() > 0.5
    assert machine.state.position[1:, 2].min() > 0.09  # nothing sank into the ground
    assert machine.energy["kinetic"] < 1e-3 * machine.assembly.mass[1:].sum() * GRAVITY * dt
    assert report.penetration < 1e-4 * 0.2  # an overlap of less than 1e-4 of a block's volume
