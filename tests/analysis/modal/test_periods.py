# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic periods: of walls and towers, damping at the first one, the decay of a free vibration, and what a rigid run leaves out."""

from __future__ import annotations

import json
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from models import box, gravity, still, tower, wall

from masonry_cd.analysis.modal.elastic_joints import joint_modes, period_along
from masonry_cd.analysis.modal.elastic_period import DAMPING, YOUNG, elastic_period
from masonry_cd.analysis.modal.first_period import damped_at_first_period, first_frequency
from masonry_cd.app.case import prepare
from masonry_cd.app.commands.modal import modal
from masonry_cd.app.scene import parse_scene, read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
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


def test_a_block_that_nothing_holds_has_no_period() -> None:
    blocks = tower(2)
    loose = [*blocks, Block("loose", blocks[1].vertices + [0.0, 0.0, 5.0], blocks[1].faces, 2000.0, blocks[1].group)]
    with pytest.raises(InputError, match=r'material.joints.damping: needs damping_frequency .* block "loose" is tied to no support'):
        damped_at_first_period(elastic(loose, 0.05), None)


E, G, DT = 2.4e9, 0.8e9, 1e-3


def parts(blocks):
    assembly = Assembly.from_blocks(blocks, 0.6)
    return assembly, find_joints(assembly)


def sine(period, cycles, direction):
    """Velocities (N + 1, 3) of a base whose acceleration is a sine of 1 m/s2 [m/s]."""
    time = np.arange(0.0, cycles * period, DT)
    return np.outer((1.0 - np.cos(2.0 * np.pi * time / period)) * period / (2.0 * np.pi), direction)


@pytest.mark.parametrize("blocks", [tower(8), wall(4, 6)], ids=["tower", "wall"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_period_is_that_of_the_first_mode_along_the_axis(blocks, axis):
    assembly, joints = parts(blocks)
    stiffness = joint_stiffness(assembly, joints, np.full(assembly.count, E), np.full(assembly.count, G))
    modes = joint_modes(blocks, np.full(assembly.count, E), 0.5, 6 * len(blocks))
    first = np.flatnonzero(np.asarray(modes["participation"])[:, axis] > 0.3)[0]
    assert period_along(assembly, joints, stiffness, np.eye(3)[axis]) == pytest.approx(1.0 / modes["frequencies"][first], rel=0.02)


def test_a_block_without_a_joint_does_not_count():
    assembly, joints = parts([*tower(4), box("aloof", (5.0, 5.0, 5.0), (5.5, 5.5, 5.5))])
    stiffness = joint_stiffness(assembly, joints, np.full(assembly.count, E), np.full(assembly.count, G))
    alone, own = parts(tower(4))
    of_tower = joint_stiffness(alone, own, np.full(alone.count, E), np.full(alone.count, G))
    along = np.array([1.0, 0.0, 0.0])
    assert period_along(assembly, joints, stiffness, along) == pytest.approx(period_along(alone, own, of_tower, along))


def test_a_long_sine_at_the_period_is_amplified_by_half_the_inverse_of_the_damping():
    assembly, joints = parts(tower(20))
    at_rest = elastic_period(assembly, joints, sine(0.1, 3, [1.0, 0.0, 0.0]), DT, (E, G))
    cycles = 40
    found = elastic_period(assembly, joints, sine(at_rest.elastic_period, cycles, [1.0, 0.0, 0.0]), DT, (E, G))
    assert found.elastic_period == at_rest.elastic_period
    assert found.amplification == pytest.approx((1.0 - np.exp(-2.0 * np.pi * DAMPING * cycles)) / (2.0 * DAMPING), rel=0.02)


def test_of_two_directions_that_which_is_amplified_more_is_reported():
    assembly, joints = parts(wall(4, 6))
    across = elastic_period(assembly, joints, sine(1.0, 2, [0.0, 1.0, 0.0]), DT, None)
    assert across.elastic_basis.young == YOUNG and not across.elastic_basis.named
    period = across.elastic_period
    both = sine(period, 20, [0.0, 1.0, 0.0]) + 1.3 * sine(2.0 * period, 10, [1.0, 0.0, 0.0])
    found = elastic_period(assembly, joints, both, DT, None)
    assert abs(found.elastic_basis.direction[1]) > 0.99
    assert found.elastic_period == pytest.approx(period, rel=1e-3)
    along = elastic_period(assembly, joints, sine(1.0, 2, [1.0, 0.0, 0.0]), DT, None)
    assert along.elastic_period < 0.5 * period, "a wall is stiffer in its plane"


LENGTH, HEIGHT, THICKNESS, DENSITY = 4.0, 3.0, 0.5, 22e3 / 9.80665
E_PERIODS, G_PERIODS = 2.85e9, 0.95e9  # squared stone
MISSED = {("straight", 2.0, 1.0, "in"): 7.0, ("running", 2.0, 1.5, "out"): 10.5, ("straight", 2.0, 1.5, "out"): 10.5}  # [%]


@cache
def continuum_period(width: float) -> float:
    """Return the period of a cantilever of a width and HEIGHT [s], as FE of 12 squares or so over the smaller side."""
    from scipy.sparse.linalg import eigsh
    from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad
    from skfem.helpers import dot, sym_grad

    side = min(width, HEIGHT) / 12.0
    mesh = MeshQuad.init_tensor(np.linspace(0.0, width, round(width / side) + 1), np.linspace(0.0, HEIGHT, round(HEIGHT / side) + 1))
    basis = Basis(mesh, ElementVector(ElementQuad2()))

    @BilinearForm  # type: ignore[untyped-decorator]
    def energy(u, v, _):  # type: ignore[no-untyped-def]
        a, b = sym_grad(u), sym_grad(v)
        return E_PERIODS * (a[0, 0] * b[0, 0] + a[1, 1] * b[1, 1]) + 4.0 * G_PERIODS * a[0, 1] * b[0, 1]

    @BilinearForm  # type: ignore[untyped-decorator]
    def inertia(u, v, _):  # type: ignore[no-untyped-def]
        return DENSITY * dot(u, v)

    free = basis.complement_dofs(basis.get_dofs(lambda x: x[1] < 1e-9))
    stiffness, mass = (form.assemble(basis)[free][:, free].tocsc() for form in (energy, inertia))
    return float(2.0 * np.pi / np.sqrt(eigsh(stiffness, 1, mass, sigma=0.0)[0][0]))


def cantilever(length: float, height: float, bond: str) -> list[Block]:
    """The wall of blocks of about a length and a height, on a base."""
    columns, courses = round(LENGTH / length), round(HEIGHT / height)
    blocks = [box("base", (-3.0, -1.0, -0.5), (3.0, 1.0, 0.0), fixed=True)]
    for k in range(courses):
        ends = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, columns + 1)
        if bond == "running" and k % 2:
            ends = np.array([ends[0], *(0.5 * (ends[1:] + ends[:-1])), ends[-1]])
        bottom, top = HEIGHT * k / courses, HEIGHT * (k + 1) / courses
        for i, (left, right) in enumerate(pairwise(ends)):
            blocks.append(box(f"b{k}.{i}", (left, -0.25, bottom), (right, 0.25, top), density=DENSITY))
    return blocks


def block_file(folder: Path, blocks: list[Block]) -> Path:
    """A scene of blocks, of masonry by name."""
    listed = [
        {"name": b.name, "vertices": b.vertices.tolist(), "faces": [list(f) for f in b.faces], "fixed": b.fixed, "group": b.group}
        for b in blocks
    ]
    (folder / "blocks.json").write_text(json.dumps({"units": "m", "blocks": listed}))
    scene = folder / "scene.toml"
    scene.write_text(
        '[structure]\nkind = "file"\npath = "blocks.json"\n[material]\nmasonry = "squared stone"\nfriction = 0.6\n'
        "[run]\ndt = 1e-3\nduration = 1.0\n"
    )
    return scene


def periods(folder: Path, blocks: list[Block]) -> tuple[float, float]:
    """The periods of the first modes in and out of the plane by ``masonry-cd modal`` [s]."""
    found = modal(read_scene(block_file(folder, blocks)), {"method": "joints", "modes": 8, "pictures": 0}).value["models"]["joints"]
    assert found["young_pa"] == pytest.approx(E_PERIODS)
    first = [next(k for k, share in enumerate(found["participation"][axis]) if share > 0.3) for axis in "xy"]
    return 1.0 / found["frequency_hz"][first[0]], 1.0 / found["frequency_hz"][first[1]]


SIZES = [(2.0, 1.5), (2.0, 1.0), (1.0, 1.0), (1.0, 0.5), (0.5, 0.5), (0.5, 0.25)]
FINE = [(0.25, 0.25), (0.25, 0.125)]


def check(folder: Path, length: float, height: float, bond: str) -> str:
    """Within 5 % but where it is known to miss; a row of the table in docs/validation.md."""
    found = periods(folder, cantilever(length, height, bond))
    off = [100.0 * (period / continuum_period(width) - 1.0) for period, width in zip(found, (LENGTH, THICKNESS), strict=True)]
    for error, plane in zip(off, ("in", "out"), strict=True):
        assert abs(error) < MISSED.get((bond, length, height, plane), 5.0), f"{bond} {length} x {height} m, {plane}: {error:.1f} %"
    return f"| {length:g} x {height:g} m | {bond} | {off[0]:+.1f} % | {off[1]:+.1f} % |"


@pytest.mark.parametrize("bond", ["straight", "running"])
@pytest.mark.parametrize(("length", "height"), SIZES)
def test_a_wall_swings_as_the_continuum_whatever_the_size_of_its_blocks(length, height, bond, tmp_path):
    print(check(tmp_path, length, height, bond))


@pytest.mark.slow(reason="walls of 200 and 400 blocks, each with a mesh of its own joints; coarser ones make the same point")
@pytest.mark.parametrize("bond", ["straight", "running"])
@pytest.mark.parametrize(("length", "height"), FINE)
def test_fine_blocks_too(length, height, bond, tmp_path):
    print(check(tmp_path, length, height, bond))


def test_bed_slips_alone_would_make_a_wall_too_soft(tmp_path):
    """With G over the length on both joints, as in a column, straight bond is a fifth slower: what the factor of the bond is for."""
    blocks = cantilever(0.5, 0.5, "straight")
    plain = {
        "young": E_PERIODS,
        "method": "joints",
        "modes": 8,
        "pictures": 0,
        "normal_stiffness": E_PERIODS / 0.5,
        "tangential_stiffness": G_PERIODS / 0.5,
    }
    found = modal(blocks, plain).value["models"]["joints"]
    first = next(k for k, share in enumerate(found["participation"]["x"]) if share > 0.3)
    assert 1.0 / found["frequency_hz"][first] > 1.15 * continuum_period(LENGTH)
