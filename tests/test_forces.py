"""loads.forces: a bar swings at its frequency and never pushes, a force turns a block about its centre, too stiff a bar is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from models import box

import loads
from loads.forces import Forces, felt_mass
from masonry_cd.blocks import Assembly
from masonry_cd.errors import InputError

G = (0.0, 0.0, -9.81)


@pytest.fixture(scope="module")
def pair() -> Assembly:
    """A fixed cube and a free one 3 m away, of 2000 kg."""
    return Assembly.from_blocks([box("wall", (0, 0, 0), (1, 1, 1), fixed=True), box("stone", (4, 0, 0), (5, 1, 1))], 0.6)


def build(assembly: Assembly | None, *tables: dict, dt: float = 1e-3, steps: int = 2000) -> loads.Loading:
    return loads.build(tables, dt, steps, G, Path("."), assembly, applies_forces=True)


def test_a_caller_that_does_not_apply_forces_is_told(pair: Assembly) -> None:
    with pytest.raises(InputError, match=r'loads\[0\].kind: "tie": forces on single blocks are not applied in this run'):
        loads.build([BAR], 1e-3, 100, G, Path("."), pair)


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
        velocity[1, :3] += dt * forces.wrench(position, rotation, velocity, k)[1, :3] / assembly.mass[1]
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


def test_damping_takes_energy_and_never_pushes(pair: Assembly) -> None:
    damped = forces(pair, {**BAR, "damping": 0.1})
    x = swing(damped, pair, 0.5, 1e-3, 200)
    back = -np.diff(x)[150:].mean() / 1e-3
    assert 0.6 < back / 0.5 < 0.85  # exp(-0.1 pi) = 0.73 over half a swing
    position, rotation, velocity = pair.centre.copy(), np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 6))
    velocity[1, 0] = -5.0  # shortening fast, still a little taut
    position[1, 0] += 1e-4
    assert damped.tensions(position, rotation, velocity)[0] == 0.0
    position[1, 0] -= 1e-2
    velocity[1, 0] = 5.0  # slack, lengthening fast
    assert damped.tensions(position, rotation, velocity)[0] == 0.0


def test_action_equals_reaction_and_moments_are_about_the_centres(pair: Assembly) -> None:
    points = [[1.0, 0.5, 0.9], [4.0, 0.2, 0.1]]
    bar = forces(pair, {**BAR, "points": points, "tension": 1000.0})
    wrench = bar.wrench(pair.centre, np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 6)), 0)
    assert np.linalg.norm(wrench[0, :3]) == pytest.approx(1000.0)
    assert wrench[0, :3] == pytest.approx(-wrench[1, :3])
    about_origin = wrench[:, 3:] + np.cross(pair.centre, wrench[:, :3])
    assert about_origin.sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert wrench[0, 0] > 0.0 > wrench[1, 0]  # it pulls


def test_a_point_load_grows_stays_and_moves_with_its_block(pair: Assembly) -> None:
    load = forces(pair, {"kind": "point", "block": "stone", "force": [0, 0, -600], "point": [5.0, 0.5, 1.0], "start": 0.5, "ramp": 1.0})
    still, turned = np.tile(np.eye(3), (2, 1, 1)), np.tile(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), (2, 1, 1))  # x goes to -z
    at = [load.wrench(pair.centre, still, np.zeros((2, 6)), k)[1] for k in (0, 500, 1000, 1500, 2000)]
    assert [w[2] for w in at] == pytest.approx([0.0, 0.0, -300.0, -600.0, -600.0])
    assert at[-1][3:] == pytest.approx([0.0, 300.0, 0.0])  # arm 0.5 m along x, force down
    assert load.wrench(pair.centre, turned, np.zeros((2, 6)), 2000)[1][3:] == pytest.approx([0.0, 300.0, 0.0])  # arm (0.5, 0, -0.5)
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


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({**BAR, "blocks": ["wall", "stoen"]}, 'loads[0].blocks: "stoen" is no block or group (did you mean "stone"?)'),
        ({**BAR, "blocks": ["wall", "wall"]}, "loads[0].blocks: must be the names of two blocks"),
        ({**BAR, "diameter": 0.02}, "loads[0]: give exactly one of diameter and area"),
        ({**BAR, "points": [[0, 0, 0]]}, "loads[0].points: must be two points"),
        ({**BAR, "points": [[0, 0, 0], [0, 0, 0]]}, "loads[0].points: both ends are at one point"),
        ({**BAR, "area": 1.0}, "loads[0]: run.dt 0.001 s is too long for its 796 Hz between these blocks; at most 0.0002 s will do"),
        ({"kind": "point", "block": "wall", "force": [0, 0, 1]}, 'loads[0].block: "wall" is fixed, a force cannot move it'),
        ({"kind": "point", "block": "*", "force": [0, 0, 1]}, 'loads[0].block: "*" names 2 blocks (wall, stone ...), one is needed'),
        ({"kind": "point", "block": "stone", "force": [0, 1]}, "loads[0].force: must be three numbers"),
    ],
)
def test_bad_tables_are_named(pair: Assembly, table: dict, message: str) -> None:
    with pytest.raises(InputError) as failure:
        build(pair, table)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)
