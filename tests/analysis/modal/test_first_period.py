# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping stated as a share of critical at the first elastic period: the period, the decay of a free vibration, and its energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from models import gravity, still, tower

from masonry_cd.analysis.modal.first_period import damped_at_first_period, first_frequency
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.studies.vibration import linear_modes

SCENE = """
[structure]
kind = "wall"
length = 2.0
height = 1.0
thickness = 0.2
course_height = 0.5
[material]
density = 2000.0
friction = 0.6
[material.joints]
normal_stiffness = 1e9
damping = 0.05
[run]
dt = 2e-3
duration = 0.1
"""


def elastic(blocks: list[Block], share: float = 0.0) -> Assembly:
    return Assembly.from_blocks(
        blocks, Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=1e9, damping=share, theta=0.5)})
    )


def test_it_is_the_first_mode_of_the_blocks_on_their_joints_in_space_and_in_a_plane() -> None:
    assembly = elastic(tower(4))
    shapes = linear_modes(assembly, 2)
    assert first_frequency(assembly) == pytest.approx(shapes.frequencies[0], rel=1e-9)
    assert [first_frequency(assembly, across) for across in (0, 1)] == pytest.approx(shapes.frequencies[:2], rel=1e-9)  # one by symmetry


def test_a_thin_wall_has_a_longer_period_out_of_its_plane_than_in_it() -> None:
    thick, thin = 1.0, 0.25  # widths of a tower in x and y: it bends at frequencies about in their proportion
    blocks = [block if block.fixed else _scaled(block, thick / 0.5, thin / 0.5) for block in tower(6)]
    out, within = (first_frequency(elastic(blocks), across) for across in (0, 1))
    assert first_frequency(elastic(blocks)) == pytest.approx(out, rel=1e-9)
    assert 2.0 < within / out < 4.5


def _scaled(block: Block, x: float, y: float) -> Block:
    return Block(block.name, block.vertices * [x, y, 1.0], block.faces, block.density, block.group)


def test_a_free_vibration_decays_by_the_logarithmic_decrement_and_the_balance_closes() -> None:
    share, blocks = 0.05, tower(4)
    assembly, period = damped_at_first_period(elastic(blocks, share), None)
    shapes = linear_modes(elastic(blocks), 1)
    dt = period / 80.0
    steps = round(5.0 * period / dt)
    run = Run(dt=dt, duration=1.0, tolerance=1e-10, planar=False)
    machine = Stepper(assembly, still(steps), gravity(steps), run)
    settle(machine)
    begin, speed = machine.state.position.copy(), 1e-3 / np.abs(shapes.shapes[0]).max()
    machine.kick(speed * shapes.shapes[0])
    put_in = 0.5 * speed**2  # phi^T M phi is one
    history = []
    for _ in range(steps):
        machine.step()
        history.append(float(np.einsum("bi,bi->", shapes.weighted[0][:, :3], machine.state.position - begin)))
    path = np.array(history)
    peaks = [path[k] for k in range(1, steps - 1) if path[k] > max(path[k - 1], path[k + 1])]
    assert len(peaks) == 5
    decrement = np.log(np.array(peaks[:-1]) / peaks[1:])
    assert decrement == pytest.approx(2.0 * np.pi * share / np.sqrt(1.0 - share**2), rel=0.04)
    energy = machine.energy
    assert abs(energy["balance"]) < 1e-6 * put_in
    left = np.exp(-2.0 * 5.0 * decrement.mean())  # of the energy after five periods
    assert energy["damping"] == pytest.approx((1.0 - left) * put_in, rel=0.02)


def test_a_run_says_the_period_at_which_its_joints_are_damped() -> None:
    case = prepare(parse_scene(SCENE, Path("scene.toml")))
    frequency = first_frequency(case.assembly, across=1)  # nothing moves it out of its plane, in which it is softer
    assert first_frequency(case.assembly) < 0.9 * frequency
    assert float(case.assembly.laws.retardation.max()) == pytest.approx(0.05 / (np.pi * frequency))
    assert f"material.joints.damping: 0.05 of critical at the first elastic period, {1 / frequency:.4g} s" in " ".join(case.notes)


def test_a_frequency_that_is_given_holds() -> None:
    case = prepare(parse_scene(SCENE, Path("scene.toml"), ['material.joints.damping_frequency="10 Hz"']))
    assert float(case.assembly.laws.retardation.max()) == pytest.approx(0.05 / (10.0 * np.pi))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("material.joints={damping=0.05}", "material.joints.default: damping needs normal_stiffness beside"),
        (
            'material={density=2000.0, friction=0.6, deformable="uniform", young=1e9, joints={normal_stiffness=1e9, damping=0.05}}',
            "material.joints.damping: needs damping_frequency beside it where blocks deform",
        ),
    ],
)  # fmt: skip
def test_without_a_first_elastic_period_it_is_refused_by_key(change: str, said: str) -> None:
    with pytest.raises(InputError) as failure:
        prepare(parse_scene(SCENE, Path("scene.toml"), [change]))
    assert said in str(failure.value)


def test_a_block_that_nothing_holds_has_no_period() -> None:
    blocks = tower(2)
    loose = [*blocks, Block("loose", blocks[1].vertices + [0.0, 0.0, 5.0], blocks[1].faces, 2000.0, blocks[1].group)]
    with pytest.raises(InputError, match=r'material.joints.damping: needs damping_frequency .* block "loose" is tied to no support'):
        damped_at_first_period(elastic(loose, 0.05), None)
