# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures whose joints were built with gaps and overlaps of micrometres: they stand as the exact ones do, at once and for no more."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import GRAVITY, advance, box, ground, stepper, tower

import structures
from benchmarks.noise import noisy
from masonry_cd.mechanics.contact.find_joints import INEXACT, MOST_INEXACT, built_gap, find_joints, joint_parts
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw

TABLE = {"kind": "aqueduct", "spans": 1, "pier_courses": 4}
STEPS = 30
TOLERANCE = 1e-8


def aqueduct(size: float, axes: str = "xyz") -> list[Block]:
    return noisy(structures.build(TABLE, 2000.0, Path()), size, axes)


def stood(blocks: list[Block], **settings: Any) -> tuple[Stepper, list[int], list[float]]:
    """A stepper after some steps at rest, the iterations of each and their errors."""
    machine = stepper(blocks, STEPS, **{"solver": "auto", "tolerance": TOLERANCE, **settings})
    reports = [machine.step() for _ in range(STEPS)]
    return machine, [report.iterations for report in reports], [report.error for report in reports]


def pair_forces(machine: Stepper) -> dict[tuple[int, int], np.ndarray]:
    """The force between each two blocks over the last step (3,) [N]."""
    assert machine.last is not None
    rows, out = machine.last.rows, {}
    force = np.einsum("cij,ci->cj", rows.frame[:, : machine.solution.impulse.shape[1]], machine.solution.impulse) / machine.settings.dt
    for blocks, f in zip(rows.blocks.tolist(), force, strict=True):
        out[tuple(blocks)] = out.get(tuple(blocks), 0.0) + f
    return out


@pytest.mark.parametrize("dt", [1e-4, 4e-3])
@pytest.mark.parametrize("axes", ["xz", "xyz"])
@pytest.mark.parametrize("size", [1e-6, 8e-6])
def test_an_aqueduct_with_gaps_rests_as_the_exact_one_does(size: float, axes: str, dt: float) -> None:
    exact, usual, _ = stood(aqueduct(0.0), dt=dt, planar=axes == "xz")
    noisy, iterations, errors = stood(aqueduct(size, axes), dt=dt)
    assert max(errors) <= TOLERANCE
    assert sum(iterations) <= 2 * sum(usual)
    assert np.abs(noisy.state.position - noisy.assembly.centre).max() < 1e-9
    here, there = pair_forces(noisy), pair_forces(exact)
    assert here.keys() == there.keys()
    largest = max(np.linalg.norm(f) for f in there.values())
    assert max(np.linalg.norm(here[pair] - there[pair]) for pair in there) < 1e-3 * largest


def test_no_impacts_are_seen_in_gaps_that_count_as_none() -> None:
    """At a short step the gap over the step is a speed of several g h."""
    machine = stepper(aqueduct(8e-6), 3, solver="auto", tolerance=1e-6, dt=1e-4)
    assert not any(machine.step().apart for _ in range(3))


def test_exact_coordinates_have_no_gap() -> None:
    assembly = Assembly.from_blocks(tower(3), 0.6)
    assert built_gap(assembly) < 1e-15
    assert stepper(tower(3), 1).system.inexact < 1e-15


@pytest.mark.parametrize(("share", "counts"), [(0.5, True), (2.0, False)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_gaps_and_overlaps_count_as_none_up_to_a_limit(sign: float, share: float, counts: bool) -> None:
    side = 0.1
    gap = sign * share * INEXACT * side
    blocks = [ground(1.0), box("b", (0.0, 0.0, gap), (side, side, gap + side))]
    assert built_gap(Assembly.from_blocks(blocks, 0.6)) == pytest.approx(abs(gap) if counts else 0.0, rel=1e-6)


def test_the_limit_of_large_blocks_is_far_below_a_crack() -> None:
    gap = 1.2 * MOST_INEXACT
    blocks = [ground(10.0), box("b", (0.0, 0.0, gap), (4.0, 4.0, gap + 4.0))]
    assert gap < INEXACT * 4.0
    assert built_gap(Assembly.from_blocks(blocks, 0.6)) == 0.0


def test_a_real_gap_closes() -> None:
    """A block above its support by more than the limit falls onto it."""
    gap = 4.0 * INEXACT * 0.1
    machine = stepper([ground(1.0), box("b", (0.0, 0.0, gap), (0.1, 0.1, gap + 0.1))], 30, dt=1e-3)
    advance(machine, 30)
    assert machine.state.position[1, 2] - machine.assembly.centre[1, 2] == pytest.approx(-gap, rel=1e-3)


def test_a_block_thrown_up_lands_where_it_stood_or_within_the_gap() -> None:
    """A gap that counts as closed does not lift or sink a block that leaves its place: it lands within that gap."""
    blocks = [ground(1.0), box("b", (0.0, 0.0, 4e-6), (0.2, 0.2, 0.2))]
    machine = stepper(blocks, 400, dt=1e-3)
    machine.kick(np.array([[0.0] * 6, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]]))
    advance(machine, 400)
    height = machine.state.position[1, 2] - machine.assembly.centre[1, 2] + 4e-6
    assert 0.5 / GRAVITY < 400 * 1e-3
    assert -1e-9 <= height <= machine.system.inexact + 1e-9


def test_mortar_bonds_over_gaps_as_built() -> None:
    law = {"default": JointLaw(normal_stiffness=1e10, cohesion=2e5)}
    shares = {}
    for size in (0.0, 4e-6):
        machine = stepper(aqueduct(size), 2, joints=law, solver="auto", tolerance=1e-6, planar=False)
        machine.step()
        joints = find_joints(machine.assembly)
        parts = {tuple(sorted(pair)): k for k, pair in enumerate(joint_parts(machine.assembly).tolist())}
        pair_joint = np.array([parts.get(tuple(sorted(pair)), -1) for pair in machine.detector.pairs.tolist()])
        shares[size] = machine.joint_bonds(pair_joint, joints)
    np.testing.assert_allclose(shares[4e-6], shares[0.0], atol=1e-3)
    assert shares[0.0].min() > 0.99


def test_a_noisy_block_rocks_as_the_exact_one_does() -> None:
    """It changes edges several times: what counts as closed changes neither when nor how hard."""
    angles = []
    for size in (0.0, 1e-6):
        blocks = noisy([ground(2.0), box("b", (-0.2, -0.2, 0.0), (0.2, 0.2, 1.6))], size)
        machine = stepper(blocks, 1500, dt=1e-3, friction=1.0, solver="auto", tolerance=1e-8, planar=False)
        machine.kick(np.array([[0.0] * 6, [0.48, 0.0, 0.0, 0.0, 0.6, 0.0]]))
        angles.append([(machine.step(), 2.0 * machine.state.orientation[1, 2])[1] for _ in range(1500)])
    exact, rough = np.array(angles)
    assert np.ptp(exact) > 0.15
    assert (np.diff(np.sign(exact)) != 0.0).sum() >= 2
    assert np.abs(rough - exact).max() < 1e-3
