# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces at points, moments, and supports that turn, against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import masonry_cd as mc

G, RATE, MASS = 9.81, 0.1, 2000.0 * 0.4 * 0.6 * 0.8
INERTIA = MASS / 12.0 * np.array([0.6**2 + 0.8**2, 0.4**2 + 0.8**2, 0.4**2 + 0.6**2])


def floating(**run: Any) -> dict[str, Any]:
    """A block without gravity, and a support far away."""
    blocks = [mc.box((-5, -1, -9), (-4, 1, -8)), mc.box((-0.2, -0.3, -0.4), (0.2, 0.3, 0.4))]
    return {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.6},
        "run": {"dt": 1e-3, "duration": 0.3, "until_still": False, "gravity": [0, 0, 0], **run},
    }


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("door", ["python", "scene"])
def test_a_free_block_spins_up_by_a_constant_moment(axis: int, door: str) -> None:
    moment = np.zeros(6)
    moment[3 + axis] = 10.0
    scene = floating() if door == "python" else floating() | {"loads": [{"kind": "point", "block": "b1", "moment": moment[3:]}]}
    sim = mc.Simulation(scene, forces={"b1": lambda time: moment} if door == "python" else None)
    assert (sim.problem().dimension == 2) == (axis == 1)  # about the normal it stays in the plane; about the others it turns out of it
    sim.run()
    rate = 10.0 * 0.3 / INERTIA[axis]
    assert sim.state.velocity[1, 3 + axis] == pytest.approx(rate, rel=1e-9) and np.abs(sim.state.velocity[1]).sum() == pytest.approx(rate)
    assert sim.state.orientation[1, 1 + axis] == pytest.approx(np.sin(0.25 * rate * 0.3), rel=1e-5)  # half of half of w t
    assert sim.energy["force_work"] == pytest.approx(0.5 * INERTIA[axis] * rate**2, rel=1e-9)


def test_a_force_at_a_point_is_a_force_and_its_moment_about_the_centre() -> None:
    force, at = np.array([3.0, -2.0, 5.0]), (0.2, 0.1, 0.4)

    def wrench(now: Any) -> np.ndarray:
        return np.array([np.zeros(6), [*force, *np.cross(now.rotation[1] @ at, force)]])

    one, other = mc.Simulation(floating(), forces={"b1": mc.Force(lambda time: force, at=at)}), mc.Simulation(floating(), forces=wrench)
    scene = mc.Simulation(floating() | {"loads": [{"kind": "point", "block": "b1", "force": force, "point": at}]})
    for sim in (one, other, scene):
        sim.run()
        assert sim.state.velocity[1] == pytest.approx(one.state.velocity[1], abs=1e-15) and sim.energy["balance"] < 1e-10
    assert np.abs(one.state.velocity[1, 3:]).max() > 1e-3


def on_platform(height: float, width: float, **run: Any) -> dict[str, Any]:
    """A block on a platform, of friction 0.3 under a low one and 0.9 under a slender one."""
    blocks = [mc.box((-2, -1, -0.5), (2, 1, 0)), mc.box((-width / 2, -0.2, 0), (width / 2, 0.2, height))]
    return {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.3 if width > height else 0.9},
        "run": {"dt": 2e-3, "duration": 4.0, "until_still": False, **run},
    }


def platform(time: float) -> tuple[float, ...]:
    """Turns at RATE after a second of run-up, so by RATE (t - 1/2)."""
    return 0.0, 0.0, 0.0, 0.0, RATE * min(1.0, time), 0.0


def seen_from_platform(sim: mc.Simulation) -> np.ndarray:
    """Place of the block (3,) and what of its x axis leads along z, all on the platform."""
    base, block = sim.state.rotation
    return np.array([*(base.T @ (sim.state.position[1] - sim.state.position[0])), (base.T @ block)[0, 2]])


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(("height", "width", "tangent"), [(0.3, 0.4, 0.3), (0.6, 0.2, 1.0 / 3.0)])
def test_a_block_on_a_platform_that_turns_slides_at_the_friction_and_tips_at_its_slenderness(
    planar: bool, height: float, width: float, tangent: float
) -> None:
    sim = mc.Simulation(on_platform(height, width, planar=planar), motions={"b0": mc.Motion(platform, about=(-1.0, 0.7, 0.0))})
    sim.run(until=np.arctan(tangent - 0.005) / RATE + 0.5)
    at = seen_from_platform(sim)
    assert at == pytest.approx([0.0, 0.0, 0.25 + height / 2, 0.0], abs=2e-6)
    sim.run(until=np.arctan(tangent + 0.015) / RATE + 0.5)
    moved = np.abs(seen_from_platform(sim) - at)
    assert moved[0 if width > height else 3] > 1e-4
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-9) and sim.contacts.point[:, 0].min() > -width
    assert (sim.problem().dimension == 2) == planar


def test_the_work_of_a_base_that_turns_is_that_of_lifting_what_it_carries() -> None:
    for more in ({}, {"joints": {"normal_stiffness": 1e9, "tangential_stiffness": 1e9}}):
        scene = on_platform(0.3, 0.4)
        scene["material"] |= more
        turn = ([0.0, 1.0, 2.0], [[0] * 6, [0, 0, 0.1, 0, -0.1, 0], [0, 0, 0.1, 0.05, -0.1, 0.2]])
        sim = mc.Simulation(scene, motions={"b0": mc.Motion(turn, about=(-1.5, 0.0, 0.0), of="displacement")})
        sim.run(until=2.5)
        lifted = 2000.0 * 0.3 * 0.4 * 0.4 * G * (sim.state.position[1, 2] - 0.15)
        assert lifted > 100.0 and sim.energy["base_work"] == pytest.approx(lifted, abs=0.02) and abs(sim.energy["balance"]) < 1e-8
        assert seen_from_platform(sim)[:3] == pytest.approx([0.0, 0.0, 0.4], abs=1e-5)
        assert sim.reactions()["b0"][3:] == pytest.approx(
            np.cross(sim.state.position[1] - sim.state.position[0], [0, 0, -2000.0 * 0.048 * G]) * -1.0, abs=2.0
        )


@pytest.mark.parametrize("step", [2e-3, "auto"])
def test_a_run_on_a_support_that_turns_goes_on_from_its_middle_with_the_same_bits(tmp_path: Path, step: Any) -> None:
    scene = on_platform(0.6, 0.2, dt=step, duration=0.4)

    def made() -> mc.Simulation:
        turn = mc.Motion(([0.0, 0.1, 0.25], [[0] * 6, [0, 0, 0, 0.02, 0.1, 0], [0, 0, 0, 0, 0.3, 0.1]]), of="displacement")
        return mc.Simulation(scene, motions={"b0": turn}, forces={"b1": ([0.0, 1.0], [[0, 0, 0, 0, 5, 0], [0, 0, 0, 0, 50, 9]])})

    sim, later = made(), made()
    sim.run(until=0.2)
    sim.save(tmp_path / "middle.npz")
    sim.run()
    later.restore(tmp_path / "middle.npz")
    later.run()
    assert np.array_equal(later.state.position, sim.state.position) and np.array_equal(later.state.orientation, sim.state.orientation)
    assert later.energy == sim.energy and abs(sim.energy["balance"]) < 2e-6 * sim.energy["base_work"]
    assert sim.state.orientation[0] == pytest.approx(_half_angle(0.3, 0.1), abs=1e-12 if step == 2e-3 else 5e-5)


def _half_angle(y: float, z: float) -> list[float]:
    angle = float(np.hypot(y, z))
    return [np.cos(angle / 2), 0.0, np.sin(angle / 2) * y / angle, np.sin(angle / 2) * z / angle]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"forces": {"b1": mc.Force(lambda time: (1, 0, 0), at=(9, 0, 0))}}, r'forces\["b1"\].at: \(9, 0, 0\) m lies'),
        ({"forces": {"b1": mc.Force(lambda time: (1, 0, 0), at=(0, 0))}}, r'forces\["b1"\].at: an array of shape \(3,\)'),
        ({"forces": {"b1": lambda time: (1, 0, 0, 0)}}, r"an array of shape \(4,\), \(3 or 6,\) is needed"),
        ({"forces": lambda now: np.zeros((2, 5))}, r"\(2, 3 or 6\) is needed, got \(2, 5\)"),
        ({"motions": {"b0": mc.Motion(lambda time: (1, 0, 0), of="place")}}, 'of = "place"'),  # type: ignore[arg-type]
        ({"motions": {"b0": mc.Motion(lambda time: (1, 0, 0, 0, 0, 0), about=(1, 2))}}, r'motions\["b0"\].about'),
        ({"motions": {"b0": lambda time: (0, 0, 0, 0, 700.0, 0)}}, r'motions\["b0"\]: turns by up to 0.7 rad within a step'),
        ({"motions": {"b0": mc.Motion(([0, 1e-4], [[0] * 6, [1] * 6]), of="displacement")}}, "closer than run.dt 0.001 s"),
    ],
)
def test_what_is_no_force_and_no_motion_is_refused(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(mc.InputError, match=words):
        mc.Simulation(floating(), **keys).step()


def test_a_block_that_is_linked_to_a_support_that_turns_goes_round_with_it() -> None:
    tables = floating() | {"links": [{"kind": "rigid", "blocks": ["b1", "b0"], "point": [0.0, 0.0, -0.4]}]}
    turns = ([0.0, 0.2, 0.3], [(0, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0.5, 0), (0, 0, 0, 0, 0.5, 0)])
    sim = mc.Simulation(tables, motions={"b0": turns})
    sim.run()
    arm = sim.state.position[1] - sim.state.position[0]
    assert sim.state.velocity[1] == pytest.approx([*np.cross([0.0, 0.5, 0.0], arm), 0.0, 0.5, 0.0], abs=2e-3)
    kinetic = 0.5 * MASS * float(np.sum(sim.state.velocity[1, :3] ** 2)) + 0.5 * INERTIA[1] * 0.5**2
    assert sim.energy["kinetic"] == pytest.approx(kinetic, rel=1e-3)
    assert sim.energy["base_work"] == pytest.approx(kinetic, rel=1e-3)
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-8)


def test_a_support_that_is_released_goes_on_turning_and_a_moment_on_what_is_removed_does_nothing() -> None:
    scene = floating(duration=0.2)
    scene["structure"]["blocks"] = [*scene["structure"]["blocks"], mc.box((3, -0.3, -0.4), (3.4, 0.3, 0.4))]
    turn = (0.1, 0.0, 0.0, 0.0, 0.5, 0.0)
    sim = mc.Simulation(scene, motions={"b1": lambda time: turn}, forces={"b2": lambda time: (0, 0, 0, 0, 9.0, 0)})
    sim.run(until=0.1)
    before = sim.energy["force_work"]
    sim.release("b1")
    sim.remove("b2")
    sim.run()
    assert sim.state.velocity[1] == pytest.approx(turn, abs=1e-12) and sim.energy["force_work"] == before > 0.0
    assert abs(sim.energy["balance"]) < 1e-9 and not sim.state.velocity[2].any()


def test_a_gauge_is_not_relative_to_a_support_that_turns() -> None:
    turns = {"kind": "motion", "supports": "b0", "time": [0.0, 0.3], "axis": "y", "rotation": [0.0, 1.0], "about": [0, 0, 0]}
    tables = floating() | {"loads": [turns], "output": {"point": [{"block": "b1", "name": "p"}]}}
    with pytest.raises(mc.InputError) as refused:
        mc.Simulation(tables)
    assert refused.value.place == "output.point[0].relative"
    tables["output"]["point"][0]["relative"] = False
    mc.Simulation(tables).step()
