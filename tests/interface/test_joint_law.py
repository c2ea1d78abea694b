# SPDX-License-Identifier: GPL-3.0-or-later
"""Own joint laws: patch tests by closed forms, a law that softens for good, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit

import masonry_cd as mc
from masonry_cd.interface.joint_law import integration_points

K, A, SIDE = 2e7, 0.16, 0.4  # [Pa/m], [m2], [m]
WEIGHT = 0.064 * 2000.0 * 9.81  # of the cube [N]


@njit
def spring(opening: Any, slip: Any, history: Any, step: float, stress: Any) -> None:
    """A spring against opening and slipping, with a dashpot that brings it to rest; history holds where a point was."""
    for k in range(len(opening)):
        stress[k, 0] = K * opening[k] + 1.2e5 * (opening[k] - history[k, 0]) / step
        history[k, 0] = opening[k]
        for i in range(2):
            stress[k, 1 + i] = K * slip[k, i] + 1.2e5 * (slip[k, i] - history[k, 1 + i]) / step
            history[k, 1 + i] = slip[k, i]


SPRING = mc.JointLaw(spring, stiffness=K, history=3)


def cube(where: str, **run: Any) -> dict[str, Any]:
    """A cube of 0.4 m under, next to or on a fixed one."""
    places = {
        "under": [(-1, -1, 0.4), (1, 1, 0.8), (-0.2, -0.2, 0.0), (0.2, 0.2, 0.4)],
        "beside": [(-0.4, -1, 0), (0, 1, 0.4), (0, -0.2, 0), (0.4, 0.2, 0.4)],
        "on": [(-1, -1, -0.4), (1, 1, 0), (-0.2, -0.2, 0), (0.2, 0.2, 0.4)],
    }[where]
    return {
        "structure": {"blocks": [mc.box(*places[:2]), mc.box(*places[2:])], "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.0001},
        "run": {"dt": 1e-4, "duration": 0.15, **run},
    }


@pytest.mark.parametrize("planar", [True, False])
def test_a_block_that_hangs_stretches_its_joint_by_its_weight(planar: bool) -> None:
    sim = mc.Simulation(cube("under", planar=planar), law=SPRING)
    sim.run()
    assert 0.2 - sim.state.position[1, 2] == pytest.approx(WEIGHT / (K * A), rel=2e-3)
    assert np.abs(sim.state.velocity[1]).max() < 1e-5 and abs(sim.energy["balance"]) < 1e-6


def test_a_block_that_is_pushed_slides_by_the_shear_of_its_joint() -> None:
    push = 500.0
    sim = mc.Simulation(cube("on"), law=SPRING, forces={"b1": lambda time: (push, 0.0, 0.0)})
    sim.run()
    assert sim.state.position[1, 0] * K * A == pytest.approx(push, rel=0.02)  # less a little that leans on the edge


def test_a_block_on_a_wall_opens_about_its_lower_edge_as_the_moment_says() -> None:
    sim = mc.Simulation(cube("beside"), law=SPRING)
    sim.run()
    turn = 2.0 * abs(sim.state.orientation[1, 2])
    assert turn == pytest.approx(WEIGHT * SIDE / 2 / (K * SIDE * SIDE**3 / 3), rel=0.02)


def test_what_softens_stays_soft_and_lets_go(tmp_path: Path) -> None:
    def brittle(opening: Any, slip: Any, history: Any, step: float, stress: Any) -> None:
        history[:, 0] = np.maximum(history[:, 0], opening > 1.5e-4)
        stress[:, 0] = np.where(history[:, 0] > 0.0, 0.0, K * np.maximum(opening, 0.0))

    law = mc.JointLaw(brittle, stiffness=K, history=1)
    scene = mc.scene(cube("under", duration=0.02))  # it swings to a stretch of 0.78 mm, twice that of its weight
    sim = mc.Simulation(scene, law=law)
    sim.run(until=0.004)
    other, later = sim.copy(), mc.Simulation(scene, law=law)
    sim.save(tmp_path / "middle.npz")
    later.restore(tmp_path / "middle.npz")
    for each in (sim, other, later):
        each.run()
        assert np.array_equal(each.state.position, sim.state.position)
    assert sim.state.velocity[1, 2] < -0.1  # it falls


def test_points_have_the_moments_of_their_polygon() -> None:
    corners = np.array([[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0]], dtype=float)
    points = integration_points(corners, np.array([0.0, 0.0, 1.0])) - [1.5, 0.5, 0.0]
    assert np.allclose((points**2).mean(axis=0)[:2], [9 / 12, 1 / 12]) and np.allclose(points.mean(axis=0), 0.0)
    triangle = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]], dtype=float)
    points = integration_points(triangle, np.array([0.0, 0.0, 1.0])) - [2 / 3, 1 / 3, 0.0]
    assert np.allclose((points**2).mean(axis=0)[:2], [4 / 18, 1 / 18])


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (mc.JointLaw(spring, stiffness=1e12, history=3), r"law: run.dt 0.0001 s is too long for a stiffness of 1e\+12 Pa/m"),
        (mc.JointLaw(spring, stiffness=0.0), "a stiffness above zero"),
        (mc.JointLaw(spring, stiffness=K, history=3, joints=[4]), "there are joints 0 to 0"),
        (mc.JointLaw(lambda *a: a[-1].fill(np.nan), stiffness=K), "its stresses are not finite"),
    ],
)
def test_a_law_that_cannot_be_is_refused(law: mc.JointLaw, words: str) -> None:
    with pytest.raises(mc.InputError, match=words):
        mc.Simulation(cube("under"), law=law).step()
