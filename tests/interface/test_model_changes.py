# SPDX-License-Identifier: GPL-3.0-or-later
"""A model that Python changes between two steps: what blocks then do by closed forms, the balance of energy, and restarts to the bit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import masonry_cd as mc

G, STEP = 9.81, 1e-3
SPRINGS = {"normal_stiffness": 1e9, "tangential_stiffness": 5e8}
BOND = SPRINGS | {"cohesion": 2e5, "tension": 2e5}


def simulation(*blocks: mc.Block, joints: dict[str, Any] | None = None, waiting: str = "", **tables: Any) -> mc.Simulation:
    """Blocks on a ground 4 m wide whose top is z = 0."""
    ground = mc.Block("ground", *mc.box((-2, -1, -0.5), (2, 1, 0)), group="base", fixed=True)
    material = {"density": 2000.0, "friction": 0.5} | ({} if joints is None else {"joints": joints})
    run = {"dt": STEP, "duration": 1.0, "tolerance": 1e-10} | tables.pop("run", {})
    scene = mc.scene(structure={"blocks": [ground, *blocks]}, material=material, run=run, **tables)
    return mc.Simulation(scene, waiting=waiting)


def cube(name: str, x: float = 0.0, z: float = 0.0, group: str = "block") -> mc.Block:
    """A cube of one metre whose foot is at a height [m]."""
    return mc.Block(name, *mc.box((x - 0.5, -0.5, z), (x + 0.5, 0.5, z + 1.0)), group=group)


WEIGHT = 2000.0 * G


@pytest.mark.parametrize("joints", [None, SPRINGS], ids=["rigid", "elastic"])
def test_what_stood_on_a_block_that_is_removed_falls_freely(joints: dict[str, Any] | None) -> None:
    sim = simulation(cube("low"), cube("high", z=1.0), joints=joints)
    sim.run(until=0.1)
    assert sim.reactions()["ground"][2] == pytest.approx(2.0 * WEIGHT, rel=1e-6)
    begin, stored = sim.state.position[2, 2], sim.energy["elastic"]
    sim.remove("low")
    sim.run(until=0.4)
    assert begin - sim.state.position[2, 2] == pytest.approx(0.5 * G * 0.3**2, rel=0.005)
    assert sim.energy["change_work"] == pytest.approx(-stored, rel=1e-6, abs=1e-9)  # the springs go with the block
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-8)
    assert sim.absent.tolist() == [False, True, False]
    assert sim.state.position[1].tolist() == pytest.approx([0.0, 0.0, 0.5], abs=1e-4)


def test_a_block_lands_where_another_was_that_is_gone() -> None:
    sim = simulation(cube("low"), cube("high", z=1.0))
    sim.remove("low")
    sim.run(until=0.9)
    assert sim.state.position[2, 2] == pytest.approx(0.5, abs=1e-6)
    assert sim.reactions()["ground"][2] == pytest.approx(WEIGHT, rel=1e-6)


def test_the_motion_of_a_removed_block_is_taken_out_of_the_energy() -> None:
    sim = simulation(cube("falls", z=1.0))
    sim.run(until=0.2)
    moving = sim.energy["kinetic"]
    sim.remove("falls")
    sim.step()
    assert (sim.energy["kinetic"], sim.energy["change_work"]) == (0.0, pytest.approx(-moving))
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-9)


def test_a_block_that_is_put_in_later_carries_from_then_on() -> None:
    sim = simulation(cube("low"), cube("late", z=1.0), waiting="late")
    sim.run(until=0.1)
    assert sim.reactions()["ground"][2] == pytest.approx(WEIGHT, rel=1e-6)
    sim.add("late")
    sim.run(until=0.2)
    assert sim.reactions()["ground"][2] == pytest.approx(2.0 * WEIGHT, rel=1e-6)
    assert not sim.absent.any()


def test_a_block_is_not_put_in_where_another_lies() -> None:
    sim = simulation(cube("low"), cube("high", z=1.0))
    sim.remove("low")
    sim.run(until=0.3)
    before = sim.state.position
    with pytest.raises(mc.InputError, match=r"change\.add"):
        sim.add("low")
    assert sim.absent.tolist() == [False, True, False]
    assert np.array_equal(sim.state.position, before)
    sim.step()


def test_a_support_that_is_released_goes_on_with_its_velocity() -> None:
    side = mc.Block("side", *mc.box((1.5, -0.5, 1.0), (2.5, 0.5, 2.0)), group="side", fixed=True)
    load = {"kind": "settlement", "supports": "side", "direction": "x", "displacement": 0.2, "duration": 0.2}
    sim = simulation(cube("low"), side, loads=[load])
    sim.run(until=0.1)
    velocity, before = sim.state.velocity[2, 0], sim.state.position[2]
    assert velocity == pytest.approx(1.875 * 0.2 / 0.2, rel=1e-3)
    sim.release("side")
    assert sim.energy["change_work"] == pytest.approx(0.5 * 2000.0 * velocity**2)
    sim.run(until=0.2)
    assert sim.state.position[2, 0] - before[0] == pytest.approx(0.1 * velocity, rel=1e-6)
    assert before[2] - sim.state.position[2, 2] == pytest.approx(0.5 * G * 0.1**2, rel=0.015)
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-7)


def test_a_block_slides_once_friction_is_less_than_its_slope() -> None:
    angle = math.radians(20.0)
    sim = simulation(cube("block"), run={"gravity": (G * math.sin(angle), 0.0, -G * math.cos(angle))})
    sim.run(until=0.1)
    assert abs(sim.state.velocity[1, 0]) < 1e-9
    sim.material(friction=0.2)
    sim.run(until=0.4)
    slides = G * (math.sin(angle) - 0.2 * math.cos(angle))
    assert sim.state.velocity[1, 0] == pytest.approx(0.3 * slides, rel=1e-6)


def test_gravity_that_turns_makes_a_block_slide() -> None:
    sim = simulation(cube("block"), run={"planar": False})
    sim.run(until=0.1)
    sim.change(gravity=(0.7 * G, 0.0, -G))
    sim.run(until=0.3)
    assert sim.state.velocity[1, 0] == pytest.approx(0.2 * 0.2 * G, rel=1e-6)  # (0.7 - mu) g
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-8)


def test_a_block_that_hangs_by_its_bond_falls_once_it_is_cut() -> None:
    beam = mc.Block("beam", *mc.box((-2, -0.5, 3.0), (2, 0.5, 3.5)), group="beam", fixed=True)
    sim = simulation(cube("hangs", z=2.0), beam, joints=BOND)
    sim.run(until=0.1)
    assert sim.reactions()["beam"][2] == pytest.approx(WEIGHT, rel=1e-6)
    begin = sim.state.position[1, 2]
    sim.change(cut="block-beam")
    sim.run(until=0.4)
    assert begin - sim.state.position[1, 2] == pytest.approx(0.5 * G * 0.3**2, rel=0.005)
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-7)


def test_a_tie_pulls_with_its_first_tension_from_when_it_is_put_in() -> None:
    loads = [{"kind": "tie", "name": "tie", "blocks": ["left", "right"], "area": 1e-5, "tension": 2000.0}]
    sim = simulation(cube("left", -1.0), cube("right", 1.0), loads=loads)
    for what, force in (("take_out", 0.0), ("put_in", 2000.0)):
        sim.change(**{what: "tie"})
        sim.run(until=sim.time + 0.1)
        along = sim.contacts.force[:, 0] @ (sim.contacts.blocks[:, 0] == 2) - sim.contacts.force[:, 0] @ (sim.contacts.blocks[:, 1] == 2)
        assert along == pytest.approx(force, abs=2.0)


def test_a_prop_holds_until_it_is_taken_out() -> None:
    prop = {"kind": "prop", "name": "prop", "blocks": "block", "direction": "x"}
    sim = simulation(cube("block"), loads=[prop], run={"gravity": (0.8 * G, 0.0, -G)})
    sim.run(until=0.1)
    assert abs(sim.state.velocity[1, 0]) < 1e-6
    sim.change(take_out="prop")
    sim.run(until=0.3)
    assert sim.state.velocity[1, 0] == pytest.approx(0.2 * 0.3 * G, rel=1e-5)


def test_what_hangs_on_a_block_that_is_removed_falls() -> None:
    beam = mc.Block("beam", *mc.box((-2, -0.5, 4.5), (2, 0.5, 5.0)), group="beam", fixed=True)
    ends = (("hangs", "rod", 3.0), ("rod", "beam", 4.5))
    pins = [{"kind": "hinge", "blocks": [a, b], "point": [0, 0, z]} for a, b, z in ends]
    rod = mc.Block("rod", *mc.box((-0.1, -0.1, 3.2), (0.1, 0.1, 4.3)))
    sim = simulation(cube("hangs", z=2.0), rod, beam, links=pins, run={"tolerance": 1e-8})
    sim.run(until=0.1)
    assert abs(sim.state.velocity[1, 2]) < 1e-6
    begin = sim.state.position[1, 2]
    sim.remove("rod")
    assert sim.links() == []
    sim.run(until=0.4)
    assert begin - sim.state.position[1, 2] == pytest.approx(0.5 * G * 0.3**2, rel=0.005)


def test_restarts_and_copies_have_the_changes_and_the_bits(tmp_path: Path) -> None:
    def begun() -> mc.Simulation:
        return simulation(cube("low"), cube("high", z=1.0), cube("late", x=1.2), joints=SPRINGS, waiting="late")

    sim = begun()
    sim.run(until=0.05)
    sim.add("late")
    sim.release("ground")
    sim.remove("low")
    sim.material(friction=0.3, joints=SPRINGS | {"normal_stiffness": 2e9})
    sim.save(tmp_path / "at_once")
    sim.run(until=0.1)
    sim.save(tmp_path / "later")
    copied = sim.copy()
    sim.run(until=0.2)
    copied.run(until=0.2)
    others = [copied]
    for file in ("at_once", "later"):
        other = begun()
        other.restore(tmp_path / file)
        other.run(until=0.2)
        others.append(other)
    for other in others:
        assert np.array_equal(other.state.position, sim.state.position)
        assert other.energy == sim.energy
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-7)


def test_events_of_the_scene_reach_own_laws_and_forces() -> None:
    event = [{"at": 0.1, "remove": "low"}, {"at": 0.1, "put_in": "tie"}]
    tie = {"kind": "tie", "name": "tie", "blocks": ["high", "late"], "area": 1e-5, "tension": 2000.0}
    sim = simulation(cube("low"), cube("high", z=1.0), cube("late", x=1.4), events=event, loads=[tie])
    bound = mc.JointLaw(lambda opening, slip, history, step, stress: stress.__setitem__((..., 0), 1e6 * opening), stiffness=1e7)
    own = mc.Simulation(sim.scene, law=bound)
    for one in (sim, own):
        one.run(until=0.2)
        copied = one.copy()
        one.run(until=0.4)
        copied.run(until=0.4)
        assert np.array_equal(one.state.position, copied.state.position)
    assert own.state.position[2] == pytest.approx(sim.state.position[2], abs=1e-6)  # nothing binds it to what is gone


def test_what_is_there_is_not_put_in_and_a_function_keeps_the_friction() -> None:
    sim = mc.Simulation(simulation(cube("low")).scene, friction=lambda contacts: contacts.friction)
    for keys, place in (({"add": "low"}, "change.add"), ({"material": {"friction": 0.1}}, "change.material.friction")):
        with pytest.raises(mc.InputError) as refused:
            sim.change(**keys)
        assert refused.value.place == place
    sim.remove("low")
    with pytest.raises(mc.InputError, match=r"change\.remove"):
        sim.remove("low")


def test_deformable_blocks_come_and_go() -> None:
    ground = mc.Block("ground", *mc.box((-2, -1, -0.5), (2, 1, 0)), group="base", fixed=True)
    material = {"density": 2000.0, "friction": 0.5, "deformable": "uniform", "young": 1e9, "poisson": 0.2}
    scene = mc.scene(structure={"blocks": [ground, cube("low"), cube("high", z=1.0)]}, material=material, run={"dt": STEP, "duration": 1.0})
    sim = mc.Simulation(scene)
    sim.run(until=0.05)
    sim.remove("high")
    sim.run(until=0.1)
    assert sim.reactions()["ground"][2] == pytest.approx(WEIGHT, rel=0.1)  # it swings a little
    assert sim.energy["balance"] == pytest.approx(0.0, abs=1e-6)


def test_what_is_recorded_shows_when_blocks_were_there(tmp_path: Path) -> None:
    sim = simulation(cube("low"), cube("high", z=1.0), run={"duration": 0.2, "frames_per_second": 20, "until_still": False})
    sim.on("step", lambda sim: sim.remove("high") if sim.steps == 100 else None)
    run = sim.record(tmp_path / "out", progress=False)
    with run.results() as results:
        assert [int(results.present(frame).sum()) for frame in range(results.frames)] == [3, 3, 3, 2, 2]
    assert run.joints["max_opening"].max() < 1e-9
