# SPDX-License-Identifier: GPL-3.0-or-later
"""Spheres against closed forms: rolling, slipping, turning on the spot, impact, piles; and what any run must do."""

import math

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, material_of, stepper

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.materials import Material

RADIUS = 0.1


def ball(name: str, centre: tuple[float, float, float], radius: float = RADIUS) -> Block:
    return Block.sphere(name, np.array(centre, dtype=float), radius, 2000.0)


def on_slope(degrees: float, seconds: float, **settings: object) -> Stepper:
    """A sphere on a slope that falls along x, after some seconds."""
    angle, steps = math.radians(degrees), round(1e3 * seconds)
    pull = gravity(steps, (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)))
    machine = stepper([ground(50.0), ball("ball", (0.0, 0.0, RADIUS))], steps, acceleration=pull, **settings)
    return advanced(machine, steps)


def rolling(speed: float, direction: float, steps: int, dt: float, **settings: object) -> Stepper:
    """A sphere that rolls on a level floor from the start, in some direction [degrees]."""
    machine = stepper([ground(50.0), ball("ball", (0.0, 0.0, RADIUS))], steps, dt=dt, **settings)
    c, s = math.cos(math.radians(direction)), math.sin(math.radians(direction))
    machine.kick(np.array([[0.0] * 6, [speed * c, speed * s, 0.0, -speed * s / RADIUS, speed * c / RADIUS, 0.0]]))
    return advanced(machine, steps)


def advanced(machine: Stepper, steps: int) -> Stepper:
    advance(machine, steps)
    return machine


@pytest.mark.parametrize("degrees", [5.0, 20.0, 40.0])
def test_a_sphere_rolls_down_a_slope_with_five_sevenths_of_what_slips(degrees):
    machine, angle = on_slope(degrees, 1.0), math.radians(degrees)
    velocity = machine.state.velocity[1]
    assert velocity[0] == pytest.approx(5.0 / 7.0 * GRAVITY * math.sin(angle), rel=1e-6)
    assert velocity[4] * RADIUS == pytest.approx(velocity[0], rel=1e-6)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["kinetic"]


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_sphere_slips_where_friction_is_below_two_sevenths_of_the_slope(share):
    angle = math.radians(30.0)
    mu = share * 2.0 / 7.0 * math.tan(angle)
    velocity = on_slope(30.0, 1.0, friction=mu).state.velocity[1]
    slip = max(0.0, GRAVITY * (math.sin(angle) - 3.5 * mu * math.cos(angle)))
    assert velocity[0] - RADIUS * velocity[4] == pytest.approx(slip, abs=1e-6)


def test_a_sphere_pushed_without_spin_slips_until_it_rolls_at_five_sevenths_of_its_speed():
    mu, speed = 0.3, 2.0
    machine = stepper([ground(50.0), ball("ball", (0.0, 0.0, RADIUS))], 1000, friction=mu)
    machine.kick(np.array([[0.0] * 6, [speed, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    until = 2.0 * speed / (7.0 * mu * GRAVITY)
    advanced(machine, round(0.9 * until * 1e3))
    velocity = machine.state.velocity[1]
    assert velocity[0] - RADIUS * velocity[4] == pytest.approx(0.1 * speed, abs=0.01)
    velocity = advanced(machine, 300).state.velocity[1]
    assert [velocity[0], RADIUS * velocity[4]] == pytest.approx([5.0 / 7.0 * speed] * 2, rel=1e-6)


@pytest.mark.parametrize("direction", [0.0, 30.0, 45.0])
def test_rolling_friction_stops_a_sphere_after_the_distance_of_its_closed_form(direction):
    share, speed, errors = 0.1, 1.0, []
    expected = 0.7 * speed**2 / (share * GRAVITY)
    for dt in (2e-3, 1e-3):
        steps = round(1.2 * 1.4 * speed / (share * GRAVITY) / dt)
        machine = rolling(speed, direction, steps, dt, rolling=share)
        errors.append(np.linalg.norm(machine.state.position[1, :2]) / expected - 1.0)
        assert np.linalg.norm(machine.state.velocity[1]) < 1e-6
        assert abs(machine.energy["balance"]) < 1e-9
    assert abs(errors[1]) < 1e-3
    assert abs(errors[1]) < 0.7 * abs(errors[0])  # of first order


@pytest.mark.parametrize(("share", "rolls"), [(0.99, True), (1.01, False)])
def test_a_sphere_with_rolling_friction_stays_on_a_slope_below_its_angle(share, rolls):
    angle = math.radians(5.0)
    machine = on_slope(5.0, 0.5, rolling=share * math.tan(angle))
    assert (machine.state.velocity[1, 0] > 1e-4) == rolls


def test_turning_on_the_spot_is_slowed_by_the_friction_at_the_arm():
    share, mu, spin = 0.1, 0.5, 20.0
    machine = stepper([ground(), ball("ball", (0.0, 0.0, RADIUS))], 200, friction=mu, rolling=share)
    machine.kick(np.array([[0.0] * 6, [0.0] * 5 + [spin]]))
    advanced(machine, 200)
    slowed = mu * share * RADIUS * GRAVITY / (0.4 * RADIUS**2) * 0.2
    assert machine.state.velocity[1, 5] == pytest.approx(spin - slowed, rel=1e-3)


def test_a_sphere_that_falls_stays_where_it_lands():
    machine = stepper([ground(), ball("ball", (0.0, 0.0, RADIUS + 0.2))], 400)
    advanced(machine, 400)
    mass = machine.assembly.mass[1]
    assert machine.state.position[1, 2] == pytest.approx(RADIUS, abs=1e-6)
    assert machine.energy["impact"] == pytest.approx(mass * GRAVITY * 0.2, rel=1e-3)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["impact"]


def rolled_over(step: float, dt: float, direction: float, tolerance: float = 1e-10) -> Stepper:
    """A sphere that rolls at 1 m/s from one block of the ground to the next, whose top is higher by a step [m]."""
    floor = [box("a", (-5.0, -5.0, -1.0), (0.1, 5.0, 0.0), fixed=True), box("b", (0.1, -5.0, -1.0), (5.0, 5.0, step), fixed=True)]
    machine = stepper([*floor, ball("ball", (0.0, 0.0, RADIUS))], round(0.4 / dt), dt=dt, planar=False, tolerance=tolerance)
    c, s = math.cos(math.radians(direction)), math.sin(math.radians(direction))
    machine.kick(np.array([[0.0] * 6, [0.0] * 6, [c, s, 0.0, -s / RADIUS, c / RADIUS, 0.0]]))
    return advanced(machine, round(0.4 / dt))


@pytest.mark.parametrize("direction", [0.0, 40.0])
@pytest.mark.parametrize(("dt", "tolerance"), [(1e-3, 1e-10), (3.1e-3, 1e-10), (3.1e-3, 1e-5)])
def test_the_seam_of_two_level_blocks_does_not_brake_a_sphere(dt, tolerance, direction):
    machine = rolled_over(0.0, dt, direction, tolerance)
    mass = machine.assembly.mass[2]
    assert machine.state.position[2, 0] > 0.2
    assert machine.state.position[2, 2] == pytest.approx(RADIUS, abs=1e-3 * RADIUS * tolerance**0.5)
    assert machine.energy["kinetic"] == pytest.approx(0.7 * mass, rel=10.0 * tolerance)


def test_a_step_at_a_seam_lifts_a_sphere_and_takes_of_its_speed():
    step = 2e-3 * RADIUS
    machine = rolled_over(step, 3.1e-3, 0.0)
    assert machine.state.position[2, 2] == pytest.approx(RADIUS + step, abs=1e-6)
    assert machine.energy["impact"] > 1e-4 * machine.energy["kinetic"]
    assert machine.energy["kinetic"] < 0.7 * machine.assembly.mass[2] * (1.0 - 1e-3)


@pytest.mark.parametrize("corner", [False, True], ids=["edge", "corner"])
def test_a_sphere_hits_an_edge_or_a_corner_along_the_line_to_its_centre(corner):
    """Without friction it loses the speed along that line, and no more."""
    table = box("table", (-1.0, -1.0, -1.0), (0.0, 0.0, 0.0), fixed=True)
    aside, speed, steps = 0.05, 2.0, 40
    centre = (aside, aside if corner else -0.5, 0.15)
    machine = stepper([table, ball("ball", centre)], steps, friction=0.0, acceleration=np.zeros((steps + 1, 3)), dt=1e-3)
    machine.kick(np.array([[0.0] * 6, [0.0, 0.0, -speed, 0.0, 0.0, 0.0]]))
    advanced(machine, steps)
    normal = np.array([aside, aside if corner else 0.0, 0.0])
    normal[2] = math.sqrt(RADIUS**2 - normal @ normal)
    normal /= RADIUS
    before = np.array([0.0, 0.0, -speed])
    tangent = before - (before @ normal) * normal
    velocity = machine.state.velocity[1, :3]
    assert np.linalg.norm(velocity) == pytest.approx(np.linalg.norm(tangent), rel=0.03)
    assert abs(np.cross(velocity, tangent)).max() < 0.1 * speed**2
    assert machine.energy["impact"] > 0.0


@pytest.mark.parametrize(("mu", "stands"), [(1.01 * math.tan(math.pi / 8), True), (0.99 * math.tan(math.pi / 8), False)])
def test_a_ball_on_four_stands_from_the_tangent_of_22_5_degrees_on(mu, stands):
    """The force on a ball of the base passes through its foot, at 22.5 degrees to the line of centres."""
    machine = stepper([ground(), *pyramid(2)], 300, friction=mu, tolerance=1e-9)
    advanced(machine, 300)
    sunk = machine.assembly.centre[-1, 2] - machine.state.position[-1, 2]
    assert (sunk < 1e-6) == stands


@pytest.mark.parametrize(
    ("side", "mu", "rolling", "framed"),
    [(3, 0.8, 0.0, False), (4, 0.6, 0.1, False), (4, 0.6, 0.0, True)],
    ids=["rough", "with rolling friction", "in a frame"],
)
def test_a_face_centred_pile_of_cannonballs_stands_and_its_forces_close(side, mu, rolling, framed):
    blocks = [ground(), *(frame(side * RADIUS) if framed else []), *pyramid(side)]
    machine = stepper(blocks, 100, friction=mu, rolling=rolling, tolerance=1e-9)
    advanced(machine, 100)
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-6
    made, impulse = machine.last, machine.solution.impulse
    force = np.einsum("cid,ci->cd", made.rows.frame, impulse) / 1e-3
    below = machine.assembly.fixed[made.rows.blocks].any(axis=1)
    weight = machine.assembly.mass[~machine.assembly.fixed].sum() * GRAVITY
    assert force[below].sum(axis=0) == pytest.approx([0.0, 0.0, weight], rel=1e-6, abs=1e-6 * weight)


def test_a_pile_of_three_layers_spreads_where_its_balls_are_smoother():
    machine = advanced(stepper([ground(), *pyramid(3)], 100, friction=0.6, tolerance=1e-8), 100)
    assert np.abs(machine.state.position - machine.assembly.centre).max() > 1e-3


def frame(half: float) -> list[Block]:
    """Four fixed beams on the ground round a square."""
    out, top = half + 0.2, 0.15
    lows = ((-out, -out, 0), (half, -out, 0), (-half, -out, 0), (-half, half, 0))
    highs = ((-half, out, top), (out, out, top), (half, -half, top), (half, out, top))
    return [box(f"f{k}", low, high, fixed=True) for k, (low, high) in enumerate(zip(lows, highs, strict=True))]


def pyramid(side: int) -> list[Block]:
    """Square layers of spheres, one less on a side from layer to layer, each in the hollows of those below."""
    made = []
    for layer in range(side):
        count = side - layer
        for i in range(count):
            for j in range(count):
                x, y = ((2 * k - count + 1) * RADIUS for k in (i, j))
                made.append(ball(f"l{layer}.{i}.{j}", (x, y, RADIUS * (1.0 + math.sqrt(2.0) * layer))))
    return made


def poured(steps: int) -> Stepper:
    """Twenty spheres of two sizes that fall onto a box between walls, with rolling friction."""
    walls = [box(f"w{k}", low, high, fixed=True) for k, (low, high) in enumerate((((-1, -1, 0), (-0.4, 1, 1)), ((0.4, -1, 0), (1, 1, 1))))]
    stone = box("stone", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.1))
    places = np.random.default_rng(1).permutation(27)[:20]
    made = [
        ball(f"b{k}", (0.24 * (p % 3 - 1) + 0.01 * (k % 4), 0.24 * (p // 3 % 3 - 1), 0.3 + 0.25 * (p // 9)), 0.06 + 0.05 * (k % 2))
        for k, p in enumerate(places.tolist())
    ]
    return advanced(stepper([ground(), *walls, stone, *made], 1000, rolling=0.05, solver="auto", tolerance=1e-8, dt=2e-3), steps)


def test_poured_spheres_keep_the_balance_of_energy_and_their_bits():
    first, second = poured(400), poured(400)
    assert first.state.position.tobytes() == second.state.position.tobytes()
    energy = first.energy
    assert abs(energy["balance"]) < 1e-6 * energy["gravity_work"]
    assert first.state.position[5:, 2].min() > 0.05


def test_a_run_with_spheres_goes_on_to_the_same_bits():
    first, second = poured(150), poured(0)
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (first, second):
        advanced(machine, 50)
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.state.velocity.tobytes() == second.state.velocity.tobytes()


def test_spheres_do_not_deform():
    blocks = [ground(), ball("ball", (0.0, 0.0, RADIUS))]
    with pytest.raises(InputError, match=r"material.deformable: the group block has spheres"):
        Assembly.from_blocks(blocks, Material(friction=0.6, deformable="uniform", young=1e9))


def test_rolling_friction_needs_spheres():
    with pytest.raises(InputError, match=r"material.rolling_friction: no block is a sphere"):
        Assembly.from_blocks([ground(), box("b", (0, 0, 0), (1, 1, 1))], material_of(0.6, rolling=0.1))


def test_a_sphere_lies_on_a_block_that_deforms():
    """Its gap follows the strain of the block below: it presses as much, and sinks by what that is shortened."""
    stone = Block("stone", *_box((-0.2, -0.2, 0.0), (0.2, 0.2, 0.4)), 2000.0, "soft")
    blocks = [ground(), stone, ball("ball", (0.0, 0.0, 0.4 + RADIUS))]
    material = ElasticBlocks(deformable={"soft": "uniform"}, young=1e6, poisson=0.0, damping=0.5, damping_frequency=10.0)
    machine = advanced(stepper(blocks, 1500, material=material, tolerance=1e-9), 1500)
    weight = GRAVITY * machine.assembly.mass[1:]
    shortened = (weight[1] + 0.5 * weight[0]) / (0.16 * 1e6) * 0.4
    assert machine.assembly.centre[2, 2] - machine.state.position[2, 2] == pytest.approx(shortened, rel=0.02)


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> tuple[np.ndarray, tuple]:
    made = box("b", low, high)
    return made.vertices, made.faces
