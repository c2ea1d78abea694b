# SPDX-License-Identifier: GPL-3.0-or-later
"""Tilts and pushes: gravity turns and keeps its size, blocks give way where theory says, and driven ones follow their path."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import advance, box, ground

import loads
from loads.kinds.tilt import load_factors
from masonry_cd.app.step_contacts import contacts_of, reactions_of
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block

G = (0.0, 0.0, -9.81)


def build(*tables: dict, dt: float = 1e-2, steps: int = 1000, gravity: tuple = G) -> loads.Loading:
    return loads.build(tables, dt, steps, gravity, Path("."))


def test_a_tilt_turns_gravity_and_keeps_its_size() -> None:
    a = build({"kind": "tilt", "direction": "x", "rate": 3.0, "start": 2.0, "angle": 20.0}).acceleration
    assert np.linalg.norm(a, axis=1) == pytest.approx(9.81)
    phi = np.clip(3.0 * (0.01 * np.arange(1001) - 2.0), 0.0, 20.0)
    assert np.degrees(np.arctan2(a[:, 0], -a[:, 2])) == pytest.approx(phi, abs=1e-9)
    assert not a[:, 1].any()  # exactly: a scene that moves in its plane stays in it
    assert build({"kind": "tilt", "direction": "-y", "rate": 3.0, "initial": 10.0}).acceleration[0, 1] == pytest.approx(
        -9.81 * np.sin(np.pi / 18)
    )


def test_an_axis_turns_gravity_by_the_right_hand_rule() -> None:
    about = build({"kind": "tilt", "axis": "y", "rate": 3.0}).acceleration
    towards = build({"kind": "tilt", "direction": "-x", "rate": 3.0}).acceleration
    assert about == pytest.approx(towards, abs=1e-12)


def test_a_push_grows_linearly_and_load_factors_read_both_back() -> None:
    t = 0.01 * np.arange(1001)
    pushed = build({"kind": "push", "direction": "y", "rate": 0.05, "start": 1.0, "initial": 0.1, "peak": 0.3})
    wanted = np.clip(0.1 + 0.05 * np.maximum(t - 1.0, 0.0), 0.0, 0.3)
    assert pushed.acceleration[:, 1] == pytest.approx(9.81 * wanted)
    assert (pushed.acceleration[:, 2] == -9.81).all()
    assert pushed.load_factor(G) == pytest.approx(wanted)
    tilted = build({"kind": "tilt", "direction": [1, 1, 0], "rate": 2.0})
    assert tilted.load_factor(G) == pytest.approx(np.tan(np.radians(2.0 * t)))
    assert load_factors(np.array([[1.0, 0.0, 0.0]]), np.array(G))[0] == np.inf


def gives_way_at(blocks: list[Block], mu: float, table: dict, dt: float, limit: float = 0.01, seconds: float = 10.0) -> float:
    """lambda at which a block has moved by a limit [m] from where it was built."""
    steps, assembly = round(seconds / dt), Assembly.from_blocks(blocks, mu)
    loading = loads.build([table], dt, steps, G, Path("."), assembly)
    settings = Run(dt=dt, duration=seconds, solver="nlgs", tolerance=1e-6)
    run = Stepper(assembly, loading.support_velocity, loading.acceleration, settings)
    for k in range(steps):
        run.step()
        if np.linalg.norm(run.state.position - assembly.centre, axis=1).max() > limit:
            return float(loading.load_factor(G)[k])
    return float("nan")


@pytest.mark.parametrize("kind", ["tilt", "push"])
def test_a_block_slides_at_its_coefficient_of_friction_and_a_slender_one_tips_at_its_slenderness(kind: str) -> None:
    table = {"kind": kind, "direction": "x"} | ({"rate": 4.0, "initial": 15.0} if kind == "tilt" else {"rate": 0.05, "initial": 0.25})
    squat, slender = box("b", (0, 0, 0), (0.6, 0.4, 0.3)), box("b", (0, 0, 0), (0.4, 0.4, 1.0))
    growth = 0.05 if kind == "push" else np.radians(4.0) * (1.0 + 0.35**2)  # of lambda, per second
    lag = (6.0 * 1e-3 / (growth * 9.81)) ** (1 / 3)  # a slip of 1 mm under an acceleration that grows by growth g: d = growth g t^3 / 6
    assert gives_way_at([ground(), squat], 0.35, table, 5e-3, limit=1e-3) == pytest.approx(0.35 + growth * lag, abs=1e-3)
    assert 0.40 < gives_way_at([ground(), slender], 0.9, table, 5e-3, limit=1e-3) < 0.42


GRAVITY = (0.0, 0.0, -9.81)
PUSH: dict[str, Any] = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "b", "targets": [0.02]}


def standing(friction: float = 0.9) -> Assembly:
    """A block of 0.5 x 1 x 2 m on its ground."""
    ground = box("ground", (-2.0, -2.0, -0.5), (3.0, 3.0, 0.0), fixed=True)
    return Assembly.from_blocks([ground, box("b", (0.0, 0.0, 0.0), (0.5, 1.0, 2.0))], friction)


def pushed(assembly: Assembly, *tables: dict[str, Any], dt: float = 2e-3, steps: int = 1000) -> Stepper:
    loading = loads.build(list(tables), dt, steps, GRAVITY, Path(), assembly)
    run = Run.model_validate({"dt": dt, "duration": dt * steps})
    return Stepper(assembly, loading.support_velocity, loading.acceleration, run, forces=loading.forces)


def weight(assembly: Assembly) -> float:
    return 9.81 * float(assembly.mass[~assembly.fixed].sum())


@pytest.mark.parametrize("point", [[0.25, 0.5, 2.0], [0.25, 0.4, 2.0]])  # in its plane, and in space
def test_a_block_that_is_tipped_meets_the_force_of_statics(point: list[float]) -> None:
    assembly, steps = standing(), 1600
    stepper = pushed(assembly, PUSH | {"point": point, "targets": [0.05]}, steps=steps, dt=2.5e-3)
    assert (stepper.plane is None) == (point[1] != 0.5)
    for _ in range(steps):
        stepper.step()
        if stepper.steps == 2:
            first = stepper.driven().force[0]
    driven = stepper.driven()
    angle = _turned(0.05)
    arm, height = 0.25 * np.cos(angle) - 1.0 * np.sin(angle), 2.0 * np.cos(angle) + 0.25 * np.sin(angle)
    if point[1] == 0.5:
        assert first == pytest.approx(weight(assembly) * 0.25 / 2.0, rel=5e-3)
        assert driven.force[0] == pytest.approx(weight(assembly) * arm / height, rel=5e-3)
    assert driven.displacement[0] == pytest.approx(0.05, abs=1e-6)
    assert abs(stepper.energy["balance"]) < 1e-6 * stepper.energy["base_work"]


def _turned(way: float) -> float:
    """The angle at which the point 2 m above the middle of the foot has gone a way, about the edge at x = 0.5."""
    angles = np.linspace(0.0, 0.1, 100_001)
    return float(np.interp(way, 0.25 - (0.25 * np.cos(angles) - 2.0 * np.sin(angles)), angles))


def test_a_block_held_from_turning_slides_at_the_force_of_friction_and_what_holds_it_is_a_moment() -> None:
    assembly = standing(friction=0.3)
    stepper = pushed(assembly, PUSH | {"face": "-x", "rotation": "held"})
    advance(stepper, 600)
    driven = stepper.driven()
    assert driven.force[0] == pytest.approx(0.3 * weight(assembly), rel=5e-3)
    assert np.abs(stepper.state.velocity[1, 3:]).max() < 1e-9
    assert stepper.state.position[1, 2] == pytest.approx(1.0, abs=1e-9)


def test_cycles_with_holds_come_to_every_target_and_the_energy_closes() -> None:
    assembly, path = standing(friction=0.3), [0.01, -0.01, 0.0]
    table = PUSH | {"targets": path, "speed": 0.013, "hold": 0.1, "rotation": "held"}
    stepper = pushed(assembly, table, steps=3200, dt=2e-3)
    reached, friction = [], 0.3 * weight(assembly)
    for _ in range(3200):
        stepper.step()
        reached.append(stepper.driven().displacement[0])
    for target in path:
        assert np.abs(np.array(reached) - target).min() < 1e-7
    assert stepper.energy["friction"] == pytest.approx(friction * 0.04, rel=1e-3)
    assert stepper.energy["base_work"] == pytest.approx(friction * 0.04, rel=1e-3)


def test_a_prop_holds_along_its_direction_and_leaves_the_way_across_free() -> None:
    assembly = standing(friction=0.3)
    push = {"kind": "push", "direction": "x", "rate": 0.5}
    stepper = pushed(assembly, push, {"kind": "prop", "direction": "x", "blocks": "b", "face": "x"}, steps=500)
    advance(stepper, 500)
    assert abs(stepper.driven().displacement[0]) < 1e-7
    contacts = contacts_of(stepper, np.full(len(stepper.detector.pairs), -1))
    ground, held = reactions_of(stepper, contacts)[0, 0], stepper.driven().force[0]  # which share each takes is not unique
    assert ground + held == pytest.approx(-0.5 * weight(assembly), rel=1e-3)
    assert held <= -0.199 * weight(assembly)


def test_loads_may_guide_a_block_along_different_axes() -> None:
    loading = loads.build([PUSH, PUSH | {"direction": "y"}], 2e-3, 10, GRAVITY, Path(), standing())
    assert loading.forces is not None
