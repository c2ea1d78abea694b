# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations: the bits of a run, states and contacts as arrays, own forces and motions, events, checkpoints; what can be set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")

MASS = 0.4 * 0.4 * 0.8 * 2000.0  # of b2 [kg]


def still(tables: dict[str, Any], *changes: str, duration: float = 0.1, **more: Any) -> mc.Scene:
    """The two blocks without shaking."""
    return mc.scene({key: value for key, value in tables.items() if key != "loads"}, f"run.duration={duration}", *changes, **more)


def falling(**run: Any) -> dict[str, Any]:
    """A cube of 1 kg 10 m above a plate, so that nothing touches it."""
    blocks = [mc.box((-1, -1, -0.5), (1, 1, 0)), mc.box((-0.05, -0.05, 10), (0.05, 0.05, 10.1))]
    return {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 1000.0, "friction": 0.5},
        "run": {"dt": 1e-3, "duration": 0.2, "planar": False, **run},
    }


@pytest.mark.parametrize("step", [2e-3, "auto"])
def test_stepped_it_has_the_bits_of_a_run(tables: dict[str, Any], step: Any) -> None:
    scene = mc.scene(tables, run={"dt": step})
    run, sim = mc.run(scene, progress=False), mc.Simulation(scene)
    sim.run(until=0.05)
    assert 0.05 - 1e-9 <= sim.time < 0.1
    while not sim.done:
        sim.step()
    with run.results() as results:
        assert np.array_equal(results.position[-1], sim.state.position)
        assert np.array_equal(results.velocity[-1], sim.state.velocity)
        assert {name: values[-1] for name, values in results.energies.items()} == sim.energy
        assert len(results.per_step("step_time")) == sim.steps
    for after_the_end in (sim.step, sim.problem, lambda: setattr(sim, "state", sim.state)):
        with pytest.raises(mc.InputError, match="the scene has ended"):
            after_the_end()


def test_contacts_and_reactions_carry_the_weight(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(still(tables, "run.planar=false"))
    assert len(sim.contacts) == 0
    sim.step(20)
    found = sim.contacts
    assert found.point.shape == found.force.shape == (len(found), 3)
    assert np.allclose(np.einsum("cij,ckj->cik", found.frame, found.frame), np.eye(3), atol=1e-12)
    assert np.allclose(np.einsum("ci,cij->cj", found.impulse, found.frame), 2e-3 * found.force)
    weight = 1.5 * MASS * 9.81
    assert np.isclose(sim.reactions()["b0"][2], weight, rtol=1e-6)
    assert np.allclose(sim.reactions()["b0"][3:], 0.0, atol=1e-4 * weight)
    force, upper = sim.joint_forces(), sim.joints.block_b == 2
    assert np.isclose(abs(force[upper][0, 2]), MASS * 9.81, rtol=1e-6)
    assert np.abs(found.slip).max() < 1e-8 and np.abs(found.gap).max() < 1e-6
    assert sim.problem().contacts == len(found)


def test_a_planar_scene_has_the_forces_of_the_whole(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(still(tables))
    sim.step(20)
    assert np.isclose(sim.reactions()["b0"][2], 1.5 * MASS * 9.81, rtol=1e-6)
    assert sim.contacts.impulse.shape[1] == 3 and not sim.contacts.impulse[:, 2].any()


def test_a_force_of_its_own_moves_a_block_as_newton_says() -> None:
    def push(time: float) -> tuple[float, float, float]:
        return (3.0, 4.0 * time, 9.81)  # and its weight is held

    for forces in ({"b1": push}, lambda now: np.outer([0.0, 1.0], push(now.time)), {"b1": ([0.0, 0.2], [push(0.0), push(0.2)])}):
        sim = mc.Simulation(falling(), forces=forces)
        sim.run()
        speed = sim.state.velocity[1, :3]
        assert np.allclose(speed, [0.6, 0.08, 0.0], atol=1e-9)
        assert abs(sim.energy["balance"]) < 1e-9


def test_first_velocities_and_states_that_are_set(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(falling(), velocities={"b1": (1.0, 0.0, 9.81 * 0.1)})
    sim.run()
    place = sim.state.position[1]
    assert np.allclose(place, [0.2, 0.0, 10.05], atol=1e-6)
    sim = mc.Simulation(falling())
    sim.run(until=0.1)
    sim.state = sim.state.changed("b1", velocity=(0.0, 2.0, 0.0), position=(0.0, 0.0, 5.0))
    sim.run()
    assert np.allclose(sim.state.position[1], [0.0, 0.2, 5.0 - 0.5 * 9.81 * 0.01], atol=1e-5)
    assert abs(sim.energy["balance"]) < 1e-9


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s.changed("b0", velocity=(1, 0, 0)), 'block "b0" is a support'),
        (lambda s: s.changed("b1", velocity=(1, 0, 0)), 'block "b1" leaves the plane'),
        (lambda s: s.changed("b1", orientation=(2, 0, 0, 0)), 'block "b1" has no unit quaternion'),
        (lambda s: s.changed("b2", position=(0, 0, 0.7)), "would overlap by 0.1 m"),
        (lambda s: s.changed("b9", position=(0, 0, 0.7)), 'no block is named "b9"'),
        (lambda s: s.changed(position=np.zeros((2, 3))), r"an array of shape \(3, 3\) is needed"),
        (lambda s: s.changed("b1", velocity=(0, 0, np.nan)), "not finite"),
        (lambda s: s.position, "got a ndarray"),
    ],
)
def test_a_state_that_cannot_be_is_refused_and_changes_nothing(tables: dict[str, Any], change: Any, words: str) -> None:
    sim = mc.Simulation(still(tables))
    sim.step(2)
    before = sim.state
    with pytest.raises(mc.InputError, match=words):
        sim.state = change(sim.state)
    assert np.array_equal(before.position, sim.state.position) and np.array_equal(before.velocity, sim.state.velocity)
    with pytest.raises(ValueError, match="read-only"):
        sim.state.velocity[1, 0] = 1.0


def test_an_imposed_motion_drives_a_block(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(still(tables), motions={"b1": lambda time: (0.2, 0.0, 0.0)})
    sim.run()
    place = sim.state.position
    assert place[1, 0] == pytest.approx(0.02, abs=3e-4) and np.isclose(place[1, 2], 0.2)
    slid = 0.5 * 9.81 * 0.5 * (0.2 / (0.5 * 9.81)) ** 2  # until friction has brought b2 to the speed of b1
    assert place[2, 0] == pytest.approx(0.02 - slid, abs=1e-3)
    with refused_at("motions"):
        mc.Simulation(still(tables), motions={"b7": lambda time: (0.2, 0.0, 0.0)})


def test_events_come_once_and_a_function_may_stop_the_run(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(still(tables, duration=2.0), velocities={"b2": (1.6, 0, 0.8, 0, 4, 0)})
    happened: list[tuple[str, object]] = []
    sim.on("step", lambda sim: happened.append(("step", sim.time)))
    sim.on("opening", lambda sim, joint: happened.append(("opening", joint)))

    @lambda function: sim.on("fall", function)
    def falls(sim: mc.Simulation, block: str) -> None:
        happened.append(("fall", block))
        sim.stop()

    sim.run()
    assert [what for what in happened if what[0] == "fall"] == [("fall", "b2")]
    opened = [joint for what, joint in happened if what == "opening"]
    assert opened and len(opened) == len(set(opened))
    assert sum(what == "step" for what, _ in happened) == sim.steps and not sim.done
    with pytest.raises(mc.InputError, match='"opened" is not an event'):
        sim.on("opened", print)
    sim.on("step", lambda sim: sim.step())
    with pytest.raises(mc.InputError, match="in the middle of a step"):
        sim.step()


@pytest.mark.parametrize("step", [2e-3, "auto"])
def test_copies_and_checkpoints_go_on_with_the_same_bits(tables: dict[str, Any], tmp_path: Path, step: Any) -> None:
    scene = mc.scene(tables, run={"dt": step})
    sim, later = mc.Simulation(scene), mc.Simulation(scene)
    sim.run(until=0.04)
    other = sim.copy()
    sim.save(tmp_path / "middle.npz")
    other.run()
    assert sim.time < 0.06  # and stands where it stood
    later.restore(tmp_path / "middle.npz")
    for again in (sim, later):
        again.run()
        assert np.array_equal(again.state.position, other.state.position)
        assert again.energy == other.energy
    with pytest.raises(mc.InputError, match="no checkpoint of a simulation of this scene"):
        mc.Simulation(still(tables)).restore(tmp_path / "middle.npz")


def test_it_records_what_a_run_does_and_says_that_python_took_part(tables: dict[str, Any], tmp_path: Path) -> None:
    plain = mc.Simulation(mc.scene(tables)).record(tmp_path / "plain", progress=False)
    run = mc.run(tables, progress=False)
    with run.results() as a, plain.results() as b:
        assert np.array_equal(a.position[...], b.position[...])
    assert "python" not in plain.summary
    pushed = mc.Simulation(mc.scene(tables), forces={"b2": lambda time: (200.0, 0.0, 0.0)})
    pushed.on("step", lambda sim: sim.stop("seen enough") if sim.time > 0.05 else None)
    found = pushed.record(tmp_path / "pushed", progress=False)
    assert found.stopped == "seen enough" and "take part" in found.summary["python"]
    with pytest.raises(mc.InputError, match="no checkpoint to resume"):
        mc.resume(found, progress=False)
    with pytest.raises(mc.InputError, match="has made steps"):
        pushed.record(progress=False)


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        ({"b0": lambda time: (1, 0, 0)}, 'forces: "b0" is a support'),
        ({"b1": lambda time: (1, 0)}, r'forces\["b1"\]: at 0 s an array of shape \(2,\)'),
        ({"b1": ([0, 0], [[1, 0, 0], [1, 0, 0]])}, "its times do not increase"),
        ({"b1": 3.0}, "a function of time is needed"),
        (lambda now: np.zeros((2, 3)), r"\(3, 3 or 6\) is needed"),
        (lambda now: np.outer(now.velocity[:, 2], [1, 0, 0]), "across the plane in which this scene moves"),
        (7.0, "a function or a dict by block is needed"),
    ],
)
def test_forces_that_are_none_are_refused(tables: dict[str, Any], forces: Any, words: str) -> None:
    with pytest.raises(mc.InputError, match=words):
        mc.Simulation(still(tables), forces=forces, velocities={"b2": (0, 0, 1)}).step()


def test_what_can_be_set_is_set_and_what_is_read_is_not(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(mc.scene(tables))
    sim.step()
    for name in ("friction", "report", "scene", "structure", "time"):
        with pytest.raises(AttributeError, match=name):
            setattr(sim, name, 0.2)
    sim.state = sim.state.changed("b1", velocity=(0.0, 0.0, 0.0))
    other = sim.copy()
    assert other.step() is other.report and sim.report is not other.report
    for made in (sim.state, sim.contacts, sim.joints, sim.report, sim.structure[0], sim.structure, sim.scene):
        with pytest.raises(AttributeError):
            made.friction = 0.2  # type: ignore[union-attr]
