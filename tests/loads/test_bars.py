# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.bars, point loads and ties: a bar swings at its frequency and never pushes, a force turns a block about its centre."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from models import box, ground

import loads
from loads.bar_frequency import felt_mass
from loads.bars import Forces, PointLoad
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.place_on_block import require_on_block
from structures.files import blockfile
from structures.geometry.compound_block import compound_block
from structures.geometry.prism import box as box_part
from structures.geometry.prism import prism_xz

G = (0.0, 0.0, -9.81)


@pytest.fixture(scope="module")
def pair() -> Assembly:
    """A fixed cube and a free one 3 m away, of 2000 kg."""
    return Assembly.from_blocks([box("wall", (0, 0, 0), (1, 1, 1), fixed=True), box("stone", (4, 0, 0), (5, 1, 1))], 0.6)


def build(assembly: Assembly | None, *tables: dict, dt: float = 1e-3, steps: int = 2000) -> loads.Loading:
    return loads.build(tables, dt, steps, G, Path("."), assembly)


def forces(assembly: Assembly, *tables: dict, **keys: float) -> Forces:
    found = build(assembly, *tables, **keys).forces
    assert found is not None
    return found


BAR = {"kind": "tie", "blocks": ["wall", "stone"], "area": 1e-4, "modulus": 2e11, "damping": 0.0}  # 4 m: k = 5e6 N/m, w = 50 rad/s


def swing(forces: Forces, assembly: Assembly, speed: float, dt: float, steps: int, offset: float = 0.0) -> np.ndarray:
    """x of the free stone over the steps, under the wrench alone, by the step's own scheme for theta 1/2."""
    position, velocity = assembly.centre.copy(), np.zeros((2, 6))
    position[1, 0] += offset
    velocity[1, 0] = speed
    rotation, out = np.tile(np.eye(3), (2, 1, 1)), []
    for k in range(steps):
        position[1] += 0.5 * dt * velocity[1, :3]
        velocity[1, :3] += dt * forces.acting(position, rotation, velocity, k).wrench(2)[1, :3] / assembly.mass[1]
        position[1] += 0.5 * dt * velocity[1, :3]
        out.append(position[1, 0] - assembly.centre[1, 0])
    return np.array(out)


def test_a_taut_bar_swings_at_its_frequency_and_keeps_its_energy(pair: Assembly) -> None:
    dt, omega = 1e-3, np.sqrt(5e6 / 2000.0)
    held = forces(pair, BAR, {"kind": "point", "block": "stone", "force": [1e5, 0, 0]})  # pulled so that it stays taut: 20 mm
    x = swing(held, pair, 0.0, dt, 2000, offset=0.025) - 0.02
    wanted = 0.005 * np.cos(omega * dt * np.arange(1, 2001))
    assert x == pytest.approx(wanted, abs=0.02 * 0.005)
    assert abs(x).max() < 1.001 * 0.005


def test_a_slack_bar_lets_go_and_catches(pair: Assembly) -> None:
    x = swing(forces(pair, BAR), pair, 0.5, 1e-3, 200)
    omega = 50.0
    assert x.max() == pytest.approx(0.5 / omega, rel=1e-3)  # half a swing outwards ...
    assert np.diff(x)[150:] == pytest.approx(-0.5 * 1e-3, rel=1e-3)  # ... then it flies back at the speed it came with, unpushed


def test_a_force_in_stages_goes_from_share_to_share_and_is_held(pair: Assembly) -> None:
    table = {"kind": "point", "block": "stone", "force": [0, 0, -1000.0], "start": 0.1, "ramp": 0.2, "hold": 0.3}
    (load,) = forces(pair, {**table, "stages": [0.5, 1.5, 0.0]}).points
    times = np.array([0.0, 0.1, 0.2, 0.3, 0.6, 0.7, 0.8, 1.1, 1.2, 1.3, 2.0])
    wanted = [0.0, 0.0, 0.25, 0.5, 0.5, 1.0, 1.5, 1.5, 0.75, 0.0, 0.0]
    assert load.factor[np.round(times / 1e-3).astype(int)] == pytest.approx(wanted, abs=1e-9)
    steps = forces(pair, {**table, "ramp": 0.0, "stages": [0.5, 1.5]}).points[0]
    assert steps.factor[[99, 101, 399, 401]] == pytest.approx([0.0, 0.5, 0.5, 1.5])


def test_damping_takes_energy_and_never_pushes(pair: Assembly) -> None:
    damped = forces(pair, {**BAR, "damping": 0.1})
    x = swing(damped, pair, 0.5, 1e-3, 200)
    back = -np.diff(x)[150:].mean() / 1e-3
    assert 0.6 < back / 0.5 < 0.85  # exp(-0.1 pi) = 0.73 over half a swing
    position, rotation, velocity = pair.centre.copy(), np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 6))
    velocity[1, 0] = -5.0  # shortening fast, still a little taut
    position[1, 0] += 1e-4
    assert damped.acting(position, rotation, velocity, 0).tension[0] == 0.0
    position[1, 0] -= 1e-2
    velocity[1, 0] = 5.0  # slack, lengthening fast
    assert damped.acting(position, rotation, velocity, 0).tension[0] == 0.0


def test_action_equals_reaction_and_moments_are_about_the_centres(pair: Assembly) -> None:
    points = [[1.0, 0.5, 0.9], [4.0, 0.2, 0.1]]
    bar = forces(pair, {**BAR, "points": points, "tension": 1000.0})
    wrench = bar.acting(pair.centre, np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 6)), 0).wrench(2)
    assert np.linalg.norm(wrench[0, :3]) == pytest.approx(1000.0)
    assert wrench[0, :3] == pytest.approx(-wrench[1, :3])
    about_origin = wrench[:, 3:] + np.cross(pair.centre, wrench[:, :3])
    assert about_origin.sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert wrench[0, 0] > 0.0 > wrench[1, 0]  # it pulls


def test_a_point_load_grows_stays_and_moves_with_its_block(pair: Assembly) -> None:
    load = forces(pair, {"kind": "point", "block": "stone", "force": [0, 0, -600], "point": [5.0, 0.5, 1.0], "start": 0.5, "ramp": 1.0})
    still, turned = np.tile(np.eye(3), (2, 1, 1)), np.tile(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), (2, 1, 1))  # x goes to -z
    rest = np.zeros((2, 6))
    at = [load.acting(pair.centre, still, rest, k).wrench(2)[1] for k in (0, 500, 1000, 1500, 2000)]
    assert [w[2] for w in at] == pytest.approx([0.0, 0.0, -300.0, -600.0, -600.0])
    assert at[-1][3:] == pytest.approx([0.0, 300.0, 0.0])  # arm 0.5 m along x, force down
    assert load.acting(pair.centre, turned, rest, 2000).wrench(2)[1][3:] == pytest.approx([0.0, 300.0, 0.0])  # arm (0.5, 0, -0.5)
    assert build(pair, BAR, {"kind": "point", "block": "stone", "force": [0, 0, -9810.0]}).lines[1].endswith("0.5 times its weight")


def test_which_forces_leave_a_plane(pair: Assembly) -> None:
    push = {"kind": "point", "block": "stone", "force": [1.0, 0.0, 0.0]}
    assert not forces(pair, BAR, push).leaves_plane(1, 0.5, pair.centre)
    assert forces(pair, {**push, "force": [1.0, 1.0, 0.0]}).leaves_plane(1, 0.5, pair.centre)
    assert forces(pair, {**push, "point": [4.5, 0.6, 0.5]}).leaves_plane(1, 0.5, pair.centre)
    assert forces(pair, {**BAR, "points": [[1, 0.4, 0.5], [4, 0.5, 0.5]]}).leaves_plane(1, 0.5, pair.centre)


def test_the_mass_a_bar_feels(pair: Assembly) -> None:
    assert felt_mass(pair, (0, 1), pair.centre) == pytest.approx(2000.0)
    off = pair.centre + [[0, 0, 0.5], [0, 0, 0.5]]  # 1/m + r^2 / I with I = m / 6: 1 + 0.25 * 6 = 2.5 times as easy to move
    assert felt_mass(pair, (0, 1), off) == pytest.approx(2000.0 / 2.5)


def test_ties_on_one_block_stiffen_one_another(pair: Assembly) -> None:
    one = {**BAR, "area": 0.03, "points": [[1.0, 0.5, 0.5], [4.0, 0.5, 0.5]]}  # 3 m: k = 2e9 N/m, w = 1000 rad/s: at the limit alone
    assert len(forces(pair, one, dt=0.999e-3).ties) == 1
    with refused_at("run.dt"):
        forces(pair, one, one, dt=0.999e-3)
    with refused_at("run.dt"):
        forces(pair, {**one, "damping": 0.25}, dt=0.999e-3)


def run_step(blocks: list[Block], tables: list[dict], dt: float, seconds: float, mu: float = 0.6, **settings: object) -> Stepper:
    """A run under gravity and the forces, to its end."""
    steps, assembly = round(seconds / dt), Assembly.from_blocks(blocks, mu)
    loading = loads.build(tables, dt, steps, G, Path("."), assembly)
    if loading.support_of is not None:
        assembly = replace(assembly, support_of=loading.support_of)
    run = Run.model_validate({"dt": dt, "duration": seconds, "solver": "nlgs", "tolerance": 1e-9} | settings)
    machine = Stepper(assembly, loading.support_velocity, loading.acceleration, run, forces=loading.forces)
    largest = 0.0
    for _ in range(steps):
        machine.step()
        largest = max(largest, abs(machine.energy["balance"]))
    works = [abs(machine.energy[name]) for name in ("base_work", "gravity_work", "force_work", "friction", "impact")]
    assert largest < 1e-9 * (max(works) + 1.0)
    return machine


PULLED = box("b", (0, -0.5, 0), (1, 0.5, 0.2))  # 400 kg


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(("share", "mu"), [(0.7, 0.5), (0.45, 0.5)])
def test_a_pulled_block_slides_as_coulomb_says_and_the_balance_closes(share: float, mu: float, planar: bool) -> None:
    """a = (share - mu) g: the block moves by a t^2 / 2, and the force has worked share m g times that."""
    weight, seconds = 400.0 * 9.81, 0.3
    pull = {"kind": "point", "block": "b", "force": [share * weight, 0.0, 0.0], "point": [1.0, 0.0, 0.05]}
    machine = run_step([ground(), PULLED], [pull], 1e-3, seconds, mu, planar=planar)
    assert (machine.plane is not None) == planar
    moved = machine.state.position[1] - machine.assembly.centre[1]
    wanted = max(0.0, 0.5 * (share - mu) * 9.81 * seconds**2)
    assert moved == pytest.approx([wanted, 0.0, 0.0], abs=1e-7)
    assert machine.energy["force_work"] == pytest.approx(share * weight * wanted, abs=1e-3)


def test_a_force_off_the_plane_turns_a_block_in_space_and_one_in_it_leaves_it_planar() -> None:
    push = {"kind": "point", "block": "b", "force": [300.0, 0.0, 0.0]}
    inside = run_step([ground(), PULLED], [push], 1e-3, 0.01, mu=0.0)
    assert inside.plane is not None
    assert inside.state.velocity[1, 0] == pytest.approx(300.0 / 400.0 * 0.01)
    off = run_step([ground(), PULLED], [{**push, "point": [0.5, 0.5, 0.1]}], 1e-3, 0.01, mu=0.0)
    assert off.plane is None
    about_z = 400.0 / 6.0
    assert off.state.velocity[1, 5] == pytest.approx(-0.5 * 300.0 / about_z * 0.01, rel=1e-6)


def test_a_hung_block_stretches_its_tie_by_its_weight_and_swings_at_its_frequency() -> None:
    """k = 2e6 N/m and 400 kg: w = 70.7 rad/s; let go at the tie's own length it swings between 0 and 2 m g / k without a contact."""
    blocks = [box("beam", (0, -0.5, 3), (1, 0.5, 4), fixed=True), PULLED]
    bar = {"kind": "tie", "blocks": ["beam", "b"], "points": [[0.5, 0.0, 3.0], [0.5, 0.0, 0.2]], "area": 2.8e-5, "modulus": 2e11}
    period = 2 * np.pi / np.sqrt(2e6 / 400.0)
    machine = run_step(blocks, [{**bar, "damping": 0.0}], period / 400, 5.5 * period)
    down = machine.assembly.centre[1, 2] - machine.state.position[1, 2]
    assert down == pytest.approx(2.0 * 400.0 * 9.81 / 2e6, rel=1e-3)  # after half a swing more than five
    assert machine.tensions == pytest.approx([2.0 * 400.0 * 9.81], rel=1e-3)
    damped = run_step(blocks, [{**bar, "damping": 0.2}], period / 100, 12 * period)
    assert damped.tensions == pytest.approx([400.0 * 9.81], rel=1e-4)
    assert damped.energy["force_work"] < -damped.energy["gravity_work"] * 0.99


def rafters() -> list[Block]:
    """Two stones that lean on each other, on level feet: an arch of three hinges."""
    left = Block("left", *prism_xz(np.array([[-2.0, 0.0], [-1.4, 0.0], [0.0, 1.6], [0.0, 2.2]]), 0.0, 0.5), 2000.0)
    right = Block("right", *prism_xz(np.array([[2.0, 0.0], [0.0, 2.2], [0.0, 1.6], [1.4, 0.0]]), 0.0, 0.5), 2000.0)
    return [box("foot1", (-3.0, 0, -0.5), (-1.0, 0.5, 0), fixed=True), box("foot2", (1.0, 0, -0.5), (3.0, 0.5, 0), fixed=True), left, right]


def test_a_tie_bears_the_thrust_of_an_arch_on_smooth_supports() -> None:
    """Without friction below, the thrust is the tie's alone: H = W x_G / rise of the line of thrust, between its extremes."""
    blocks = rafters()
    tie = {"kind": "tie", "blocks": ["left", "right"], "points": [[-1.7, 0.25, 0.05], [1.7, 0.25, 0.05]], "area": 4e-4, "damping": 0.1}
    loose = run_step(blocks, [], 1e-3, 0.4, mu=0.0)
    assert loose.state.position[3, 0] - loose.assembly.centre[3, 0] > 0.05  # it spreads and falls
    held = run_step(blocks, [tie], 2e-4, 0.4, mu=0.0)
    assert np.abs(held.state.position - held.assembly.centre).max() < 2e-3
    weight, arm = held.assembly.mass[3] * 9.81, held.assembly.centre[3, 0]
    thrust = [weight * (foot - arm) / (crown - 0.05) for foot, crown in ((1.4, 2.2), (2.0, 1.6))]
    assert thrust[0] < held.tensions[0] < thrust[1]


POINT = {"kind": "point", "block": "stone", "force": [0, 0, -600]}


def test_a_place_on_the_surface_counts_as_on_the_block_and_one_in_a_hollow_does_not(pair: Assembly) -> None:
    assert build(pair, {**POINT, "point": [5.001, 0.5, 1.002]}, steps=10).forces is not None
    ball = Block.sphere("ball", np.zeros(3), 1.0)
    require_on_block(ball, [0.0, 0.0, 1.005], "key")  # where the ball of triangles by which it is drawn may be flatter
    with refused_at("key"):
        require_on_block(ball, [0.8, 0.8, 0.0], "key")
    foot = [box_part((x, 0, 0), (x + 1, 1, 1)) for x in (0, 1, 2)]  # parts share whole faces
    u_shape = compound_block("u", [*foot, box_part((0, 0, 1), (1, 1, 3)), box_part((2, 0, 1), (3, 1, 3))], 1.0, "g")
    require_on_block(u_shape, [0.5, 0.5, 2.5], "key")
    with pytest.raises(InputError, match=r'\(1\.5, 0\.5, 2\) m lies 0\.5 m outside block "u"'):
        require_on_block(u_shape, [1.5, 0.5, 2.0], "key")


def test_where_nothing_acts_all_sums_are_zero(pair: Assembly) -> None:
    none = Forces((), ()).acting(pair.centre, np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 6)), 0)
    assert (none.block.shape, none.force.shape, none.tension.shape) == ((0,), (0, 3), (0,))
    assert none.wrench(2).shape == (2, 6)
    assert none.virial(2).shape == (2, 3, 3)
    assert not none.wrench(2).any()
    assert not none.virial(2).any()


def test_a_run_tells_what_its_ties_had_to_bear(tmp_path: Path) -> None:
    blockfile.write(tmp_path / "blocks.json", rafters())
    (tmp_path / "scene.toml").write_text(
        """
structure = {kind = "file", path = "blocks.json"}
material = {density = 2000.0, friction = 0.2}
run = {dt = 5e-4, duration = 0.1, solver = "nlgs", tolerance = 1e-6}
[[loads]]
kind = "tie"
blocks = ["left", "right"]
points = [[-1.7, 0.25, 0.05], [1.7, 0.25, 0.05]]
diameter = 0.02
tension = 500.0
"""
    )
    prepared = prepare(read_scene(tmp_path / "scene.toml"))
    summary = run_case(prepared, tmp_path / "out")
    (tie,) = summary.ties
    assert tie.blocks == ("left", "right")
    with Results.open(tmp_path / "out" / "result.h5") as results:
        tension = results.per_step("ties/tension")
        assert tension.shape == (200, 1)
        assert tie.tension_max == tension.max() > tension[-1] == tie.tension_end > 500.0
    assert tie.stress_max == pytest.approx(tie.tension_max / (np.pi * 1e-4))
    assert closing_lines(summary)[2].startswith('tie "left" to "right": at most ')


def test_a_moment_that_varies_within_a_step_is_measured_at_the_corners(pair: Assembly) -> None:
    """An adapting step takes the mean of it: what it is off by accelerates a corner by M R / I."""
    factor = np.array([0.0, 0.0, 1.0, 1.0])
    turning = Forces((PointLoad(1, np.zeros(3), np.zeros(3), factor, np.array([0.0, 60.0, 0.0])),), ())
    least = float(np.linalg.eigvalsh(pair.inertia[1])[0])
    assert turning.spread(1, 2, pair) == pytest.approx(30.0 * pair.reach[1] / least)
    assert turning.spread(2, 2, pair) == 0.0 and turning.leaves_plane(0, 0.0, pair.centre)
