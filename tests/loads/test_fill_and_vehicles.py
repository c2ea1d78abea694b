# SPDX-License-Identifier: GPL-3.0-or-later
"""Fill and vehicles of bridges: thrusts and spreading in closed form, resistance that grows, is capped, and is none on the way out."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bridge_scenes import GRAVITY, SPAN, bridge, grid
from scipy.optimize import brentq

from loads import build, fill
from loads.bars import Forces, Tie
from loads.kinds.vehicle import KINDS, VEHICLES, VehicleTable, strip_loads, vehicle
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Assembly

SOLID = [{"rigid": False, "height": 2.0}]


def of_fill(shaken: bool = False, **keys: object) -> tuple:
    made, assembly = bridge(width=3.0, cover=0.4, abutments=SOLID, **keys)
    part = fill.at_collapse(made.fills[0], grid(made, assembly), shaken).static
    forces = list(part.points)
    assert bool(part.words) == bool(forces)
    return made.fills[0], assembly, forces, list(part.ties)


@pytest.mark.parametrize(("pressure", "k"), [("at_rest", 1.0 / 3.0), ("active", 1.0 / 3.0), ("none", 0.0)])
def test_at_collapse_the_back_of_an_abutment_is_pressed_by_half_k_gamma_of_the_depths_squared(pressure: str, k: float) -> None:
    found, assembly, pressed, _ = of_fill(fill={"pressure": pressure, "friction_angle": 30.0, "density": 1800.0})
    backs = [face for face in found.faces if face.kind == "back" and face.block.startswith("abutment1")]
    low, high = -2.0, max(float(face.corners[:, 2].max()) for face in backs)
    deep, shallow = found.level - low, found.level - high
    exact = 0.5 * k * 1800.0 * 10.0 * (deep**2 - shallow**2) * 3.0
    left = [load for load in pressed if assembly.names[load.block].startswith("abutment1")]
    assert sum(float(load.force[0]) for load in left) == pytest.approx(exact)  # towards the span
    if k:
        lever = sum(float(load.force[0]) * (assembly.centre[load.block] + load.arm)[2] for load in left) / exact
        middle = found.level - (deep**3 - shallow**3) / (1.5 * (deep**2 - shallow**2))
        assert lever == pytest.approx(middle)


def test_walls_are_pressed_outwards_and_both_sides_alike() -> None:
    _, assembly, pressed, _ = of_fill(walls={"course_height": 0.5, "unit_length": 1.0}, fill={"friction_angle": 0.0})
    total = {side: np.zeros(3) for side in ("front", "back")}
    for load in pressed:
        for side, sum_of in total.items():
            if assembly.names[load.block].startswith(f"spandrel_{side}"):
                sum_of += load.force
    assert total["front"][1] < 0.0
    assert total["front"] == pytest.approx(-total["back"])


@pytest.mark.parametrize(("shaken", "share"), [(False, 0.5), (True, 0.2)])
def test_passive_resistance_is_capped_at_its_share_of_k_p(shaken: bool, share: float) -> None:
    found, _, _, bars = of_fill(shaken, fill={"passive": 0.5, "passive_shaken": 0.2, "density": 1800.0})
    arches = [bar for bar in bars if "arch1" in bar.name]
    left = sum(bar.limit for bar in arches if bar.name.endswith("left"))
    crown, foot = found.level - 2.0, found.level - min(float(f.corners[:, 2].min()) for f in found.faces if f.kind == "extrados")
    # chords: the integral of depth over the level part is the mean depth times the rise of each, exact for any polyline
    assert left == pytest.approx(share * 3.0 * 1800.0 * 10.0 * 0.5 * (foot**2 - crown**2) * 3.0, rel=2e-3)  # but for the level chord
    assert left == pytest.approx(sum(bar.limit for bar in arches if bar.name.endswith("right")))


def test_an_arch_meets_it_only_where_it_moves_into_the_fill_and_in_proportion_up_to_the_cap() -> None:
    found, assembly, _, bars = of_fill(fill={"mobilised_at": 0.01})
    left = next(bar for bar in bars if bar.name == "fill of arch1, left")
    forces, turns = Forces((), (left,)), np.broadcast_to(np.eye(3), (assembly.count, 3, 3))

    def met(moved: float) -> float:
        position = assembly.centre.copy()
        position[left.blocks[0], 0] += moved
        yielded = forces.yields(position, turns, np.zeros(1))
        acting = forces.acting(position, turns, np.zeros((assembly.count, 6)), 0, 1, yielded)
        return float(acting.force[0, 0])

    assert met(0.005) == 0.0  # towards the span, out of the fill
    assert met(-0.005) == pytest.approx(0.5 * left.limit)
    assert met(-0.01) == pytest.approx(left.limit)
    assert met(-0.05) == pytest.approx(left.limit)
    assert found.mobilised_at == 0.01


def test_a_slanted_arch_meets_the_fill_at_right_angles_to_its_springings() -> None:
    made, assembly = bridge(width=3.0, skew=30.0)
    bars = [f for f in fill.part(made.fills[0], grid(made, assembly), False).forces if isinstance(f, Tie)]
    points = assembly.centre[list(bars[0].blocks)] + bars[0].arms
    way = (points[1] - points[0]) / fill.FAR
    assert abs(way[1] / way[0]) == pytest.approx(math.tan(math.radians(30.0)))
    assert way[2] == pytest.approx(0.0, abs=1e-12)


def pressed(assembly: Assembly, bars: list[Tie], moved: float) -> float:
    """Return the outward pull of the bars of a wall, of which the first is at its face, once it has moved by some length along y."""
    forces, turns = Forces((), tuple(bars)), np.broadcast_to(np.eye(3), (assembly.count, 3, 3))
    position = assembly.centre.copy()
    position[bars[0].blocks[0], 1] += moved
    yielded = forces.yields(position, turns, np.zeros(len(bars)))
    acting = forces.acting(position, turns, np.zeros((assembly.count, 6)), 0, 1, yielded)
    return float(acting.force[: len(bars), 1].sum())


def test_a_wall_is_pressed_by_k_0_at_rest_by_k_a_once_it_has_moved_and_by_nothing_once_the_fill_has_run_out() -> None:
    keys = {"active_at": 0.002, "gone_at": 0.25, "friction_angle": 30.0}
    made, assembly = bridge(width=3.0, walls={"course_height": 0.5, "unit_length": 1.0}, fill=keys)
    found = made.fills[0]
    face = max((f for f in found.faces if f.block.startswith("spandrel_back")), key=lambda f: f.pressed(found.level)[0])
    depth, place = face.pressed(found.level)
    deepest, thrust = found.level - float(face.corners[:, 2].min()), depth * found.density * 10.0 * float(np.abs(face.area[1]))
    bars = [f for f in fill.part(found, grid(made, assembly), False).forces if f.name == f"fill of {face.block}, pressure"]
    assert assembly.centre[bars[0].blocks[0]] + bars[0].arms[0] == pytest.approx(place)
    assert pressed(assembly, bars, 0.0) == pytest.approx(0.5 * thrust)
    assert pressed(assembly, bars, -0.01) == pytest.approx(0.5 * thrust)  # into the fill: no more than at rest
    assert pressed(assembly, bars, 0.001 * deepest) == pytest.approx((0.5 + 1.0 / 3.0) / 2.0 * thrust, rel=4e-3)
    assert pressed(assembly, bars, 0.002 * deepest) == pytest.approx(thrust / 3.0 * (1.0 - 0.002 / 0.25), rel=1e-6)
    assert pressed(assembly, bars, 0.125 * deepest) == pytest.approx(thrust / 6.0, rel=1e-6)
    assert pressed(assembly, bars, 0.25 * deepest + 1e-6) == 0.0
    assert pressed(assembly, bars, 3.0) == 0.0


def test_the_fill_runs_out_where_its_slumped_wedge_has_done_as_much_work() -> None:
    """A slope of phi next to a wall that moves away keeps the volume of the fill: H - sqrt(2 d H tan phi) of the wall are touched."""
    made, _ = bridge(fill={"friction_angle": 35.0})
    slope = math.tan(math.radians(35.0))
    moved = np.linspace(0.0, 0.5 / slope, 20001)
    touched = 1.0 - np.sqrt(2.0 * moved * slope)
    work = float(np.sum(0.5 * (touched[1:] ** 2 + touched[:-1] ** 2) * np.diff(moved)))
    assert 0.5 * made.fills[0].reach == pytest.approx(work, rel=1e-5)
    removed, filled = (1.0 - touched - moved * slope) ** 2 / (2.0 * slope), moved * (touched + 0.5 * moved * slope)
    assert removed == pytest.approx(filled, abs=1e-12)
    assert bridge(fill={"friction_angle": 0.0})[0].fills[0].reach == 1.0


def test_an_arch_or_a_pier_bears_the_reaction_of_spandrel_walls_and_the_ground_that_of_wing_walls_and_backs() -> None:
    made, assembly = bridge(width=3.0, skew=20.0, abutments=SOLID, walls={"wing_length": 2.0})
    bars = [f for f in fill.part(made.fills[0], grid(made, assembly), False).forces if f.name.endswith("pressure")]
    borne = {(assembly.names[a].split("_")[0].split(".")[0].rstrip("12"), assembly.names[b].split(".")[0].rstrip("12")) for a, b in
             (bar.blocks for bar in bars)}  # fmt: skip
    assert borne == {("spandrel", "arch"), ("spandrel", "abutment"), ("wing", "foot_abutment"), ("abutment", "foot_abutment")}


def test_the_back_of_an_abutment_meets_its_share_of_k_p_in_all_and_no_more() -> None:
    keys = {"density": 1800.0, "friction_angle": 30.0, "passive": 1.0}
    found, _, forces, bars = of_fill(fill=keys)
    made, assembly = bridge(width=3.0, cover=0.4, abutments=SOLID, fill=keys)
    gamma_h = sum(abs(face.area[0]) * face.pressed(found.level)[0] for face in found.faces if face.kind == "back") * 1800.0 * 10.0
    resisting = sum(bar.limit for bar in bars if "abutment" in bar.name)
    assert resisting + sum(float(np.abs(load.force[0])) for load in forces) == pytest.approx(3.0 * gamma_h)
    in_a_run = [bar for bar in fill.part(found, grid(made, assembly), False).forces if bar.name.startswith("fill of abutment")]
    assert sum(bar.limit for bar in in_a_run) == pytest.approx(3.0 * gamma_h)


def test_gravity_may_be_ramped_next_to_fill_that_presses_on_nothing() -> None:
    made, assembly = bridge(width=3.0)
    build([{"kind": "gravity", "ramp": 1.0}], 1e-3, 10, GRAVITY, Path(), assembly, fills=made.fills)


def table(**keys: object) -> VehicleTable:
    return parse_table(VehicleTable, {"kind": "vehicle", **keys}, "loads[0]")


@pytest.mark.parametrize("spread", ["2:1", "boussinesq"])
@pytest.mark.parametrize("keys", [{}, {"skew": 25.0}, {"strips": 3}])
@pytest.mark.parametrize("name", sorted(VEHICLES))
def test_what_the_bridge_bears_sums_to_the_axles(spread: str, keys: dict, name: str) -> None:
    made, _ = bridge(SPAN, SPAN, width=3.5, fill={"spread": spread}, **keys)
    asked = table(name=name, offset=0.2)
    _, load = strip_loads(asked, made.fills[0], np.array([3.7, 7.1]))
    assert load.sum(axis=1) == pytest.approx(sum(asked.known.loads), rel=2e-3)  # the rest is spread beyond the ends


def test_the_load_lies_under_the_axle_and_within_its_cone() -> None:
    made, _ = bridge(width=3.0, cover=1.0, fill={"spread": "boussinesq"})
    strips, load = strip_loads(table(axles=[1.0], contact=[0.2, 0.2]), made.fills[0], np.array([3.0]))
    middle = strips.ends.mean(axis=1)
    assert float(np.sum(load[0] * middle)) == pytest.approx(3.0, abs=1e-12)
    reach = 0.1 + strips.depth * math.tan(math.radians(30.0)) + np.ptp(strips.ends, axis=1)
    assert not load[0][np.abs(middle - 3.0) > reach].any()


def test_two_to_one_is_even_over_the_contact_and_the_depth() -> None:
    made, _ = bridge({"span": 20.0, "rise": 0.4, "thickness": 0.3, "voussoirs": 201}, width=3.0, cover=1.0, fill={"spread": "2:1"})
    strips, load = strip_loads(table(axles=[1.0], contact=[0.2, 0.2]), made.fills[0], np.array([10.0]))
    density = load[0] / np.ptp(strips.ends, axis=1)
    under = np.abs(strips.ends.mean(axis=1) - 10.0) < 0.5
    assert density[under] == pytest.approx(1.0 / 1.2, rel=3e-3)


@pytest.mark.parametrize(("offset", "track"), [(0.0, 1.8), (1.5, 1.8), (-1.9, 1.0), (0.0, 4.0)])
def test_a_strip_is_as_wide_as_wheels_spread_and_ends_at_the_edges(offset: float, track: float) -> None:
    """The union of what lies under either wheel, on a grid; or twice the narrower one of two strips apart."""
    made, _ = bridge(width=6.0, cover=0.6)
    keys = {"axles": [1.0], "offset": offset, "track": track, "contact": [0.3, 0.4]}
    (strips, load), (_, line) = (strip_loads(table(across=a, **keys), made.fills[0], np.array([3.0])) for a in ("strip", "line"))
    y = (np.arange(600_000) + 0.5) / 1e5 - 3.0
    for k in np.flatnonzero(line[0] > 1e-3)[::7].tolist():
        under = [np.abs(y - offset - side * 0.5 * track) < 0.5 * (0.4 + strips.depth[k]) for side in (-1.0, 1.0)]
        apart = not (under[0] & under[1]).any()
        wide = 2.0 * min(u.mean() for u in under) if apart else (under[0] | under[1]).mean()
        assert load[0, k] * wide == pytest.approx(line[0, k], rel=1e-4)


def test_a_narrow_road_is_a_strip_itself_and_slanted_voussoirs_have_none() -> None:
    made, assembly = bridge(width=2.3, cover=2.0)
    (_, load), (_, line) = (strip_loads(table(across=a, name="single"), made.fills[0], np.array([3.0])) for a in ("strip", "line"))
    assert load == pytest.approx(line, rel=1e-12)
    made, assembly = bridge(width=6.0, skew=20.0)
    with pytest.raises(InputError, match=r"loads\[0\]\.across.*without skew"):
        vehicle(table(name="single", across="strip", position=3.0), grid(made, assembly), "loads[0]")


def test_an_axle_in_the_middle_loads_a_strip_in_its_plane() -> None:
    made, assembly = bridge(width=3.0)
    part = vehicle(table(name="triple", position=3.0), grid(made, assembly), "loads[0]")
    assert max(abs(float(load.arm[1] + assembly.centre[load.block, 1])) for load in part.forces) < 1e-12


def test_a_crossing_comes_and_goes() -> None:
    made, assembly = bridge(width=3.0)
    own = grid(made, assembly, steps=1200, dt=0.01)
    part = vehicle(table(name="double", speed=1.0), own, "loads[0]")
    total = sum(-float(load.force[2]) * load.factor for load in part.forces)
    on = (own.times > 4.5) & (own.times < 5.0)  # both axles over the arch
    assert total[on] == pytest.approx(2 * 10.0 * 9810.0, rel=1e-3)
    assert total[-1] == 0.0
    assert float(np.abs(np.diff(total)).max()) < 0.1 * 2 * 98100.0  # no axle jumps onto the arch


def test_a_crossing_that_the_run_cuts_short_is_said() -> None:
    made, assembly = bridge(width=3.0)
    acted = vehicle(table(name="single", speed=1.0), grid(made, assembly, 100, 0.01), "loads[0]").acted
    assert acted is not None and acted.end == pytest.approx(9.0)
    assert len(acted.lines(1.0)) == 1 and not acted.lines(9.0)


def thrust_of_wedges(phi: float, k: float, way: float) -> float:
    """K of the wedge that presses most on an upright smooth wall (way 1) or resists least (way -1), shaken by k along its motion.

    Its weight W and k W balance the wall's force, level, and that on its slip plane at an angle a, at phi to the normal: by sliding down,
    P = W (tan(a - phi) + k), by sliding up, P = W (tan(a + phi) - k), with W = 1 / (2 tan(a)) of gamma H^2.
    """
    a = np.radians(np.linspace(1.0, 89.0, 400_001))
    phi = float(np.radians(phi))
    a = a[(a - phi > -1.5) & (a + phi < 1.57)] if way < 0 else a
    each = (np.tan(a - way * phi) + way * k) / np.tan(a)
    return float(each.max() if way > 0 else each[np.cos(a + phi) > 0.0].min())


@pytest.mark.parametrize(("phi", "k"), [(30.0, 0.0), (30.0, 0.2), (35.0, 0.3), (40.0, 0.1), (30.0, -0.2), (30.0, 0.57)])
def test_shaken_fill_presses_and_resists_as_the_worst_of_all_wedges(phi: float, k: float) -> None:
    made, _ = bridge(width=3.0, fill={"friction_angle": phi})
    active, passive = made.fills[0].shaken(k)
    assert active == pytest.approx(thrust_of_wedges(phi, k, 1.0), rel=1e-6)
    assert passive == pytest.approx(thrust_of_wedges(phi, k, -1.0), rel=1e-6)


def test_above_the_tangent_of_phi_shaken_fill_slides_by_itself() -> None:
    made, _ = bridge(width=3.0, fill={"friction_angle": 30.0})
    found = made.fills[0]
    assert found.slides_at == pytest.approx(np.tan(np.radians(30.0)))
    assert found.shaken(2.0) == found.shaken(found.slides_at) == pytest.approx((4.0 / 3.0, 4.0 / 3.0), rel=1e-6)


def test_under_a_push_pressure_grows_along_it_and_resistance_falls() -> None:
    made, assembly = bridge(width=3.0, cover=0.4, abutments=SOLID, fill={"friction_angle": 30.0})
    found, by = made.fills[0], 0.25
    still = fill.at_collapse(found, grid(made, assembly), True)
    shaken = fill.at_collapse(found, grid(made, assembly), True, np.array([by, 0.0, 0.0]))
    assert not still.live and "Mononobe" in shaken.static.words and "Mononobe" not in still.static.words
    active, passive = found.shaken(by)
    for dead, live in zip(still.static.points, shaken.live, strict=True):
        towards = float(np.sign(dead.force[0]))  # the left abutment is pressed along x
        k = active if towards > 0.0 else found.shaken(-by)[0]
        assert (dead.force + by * live.force)[0] == pytest.approx(dead.force[0] * 3.0 * k)
    limits = [{bar.name: bar.limit for bar in part.static.ties if "arch1" in bar.name} for part in (still, shaken)]
    for name, limit in limits[0].items():
        share = passive / 3.0 if name.endswith("right") else 1.0
        assert limits[1][name] == pytest.approx(share * limit)


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_wheels_press_walls_by_k_a_of_what_two_to_one_reaches(offset: float) -> None:
    """In sum what a grid over the inner face of a wall gives, by the load of a wheel over the area that it reaches at each depth."""
    made, assembly = bridge(width=4.0, cover=0.5, walls={"course_height": 0.5, "unit_length": 1.0}, fill={"friction_angle": 30.0})
    found = made.fills[0]
    keys = {"axles": [2.0], "position": 2.0, "track": 1.8, "contact": [0.3, 0.3], "offset": offset}
    still = [0] * 2
    for side, sign in enumerate((-1.0, 1.0)):
        loads = KINDS["vehicle"].static(table(**keys), grid(made, assembly), "loads[0]").points
        name = ("spandrel_front", "spandrel_back")[side]
        some = [load for load in loads if assembly.names[load.block].startswith(name)]
        still[side] = float(sum(load.force[1] for load in some if abs(load.force[1]) > 0.0))
        far = found.clear[1] - sign * offset  # from the wall to the middle of the vehicle
        dx = 2e-3
        x = np.arange(0.0, 6.0, dx) + 0.5 * dx
        total = 0.0
        for face in found.faces:
            if face.kind != "wall" or not face.block.startswith(name):
                continue
            z = face.corners[:, 2]
            for depth in np.arange(found.level - z.max(), found.level - z.min(), dx) + 0.5 * dx:
                inside = crossed(face.corners[:, [0, 2]], found.level - depth)
                wide = 0.3 + depth
                wheels = sum(abs(far + s * 0.9) <= 0.5 * wide for s in (-1.0, 1.0))
                total += wheels * 1.0 / wide**2 * dx * dx * float(((x > inside[0]) & (x < inside[1]) & (abs(x - 2.0) < 0.5 * wide)).sum())
        assert sign * still[side] == pytest.approx(total / 3.0, rel=0.03, abs=1e-6)
    assert still[0] == pytest.approx(-still[1], rel=1e-9) if offset == 0.0 else abs(still[1]) > abs(still[0])


def crossed(polygon: np.ndarray, height: float) -> tuple[float, float]:
    """Where a level line enters and leaves a convex polygon (n, 2)."""
    found = []
    for (x0, z0), (x1, z1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (z0 - height) * (z1 - height) < 0.0:
            found.append(x0 + (height - z0) / (z1 - z0) * (x1 - x0))
    return (min(found), max(found)) if found else (0.0, 0.0)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_run_warns_where_shaken_fill_presses_more_than_it_has_it_press(share: float, tmp_path: Path) -> None:
    """About the acceleration at which K_AE is K_0, 1 / 2 at 30 degrees."""
    made, assembly = bridge(width=3.0, abutments=SOLID, fill={"friction_angle": 30.0})
    found = made.fills[0]
    equal = brentq(lambda k: found.shaken(k)[0] - 0.5, 0.0, found.slides_at)
    peak, frequency = share * equal * float(np.sqrt(np.sum(np.square(GRAVITY)))), 1.0
    load = {"kind": "sinusoidal", "direction": "x", "amplitude": peak / (2.0 * math.pi * frequency), "frequency": frequency, "cycles": 1}
    loading = build([load], 1e-3, 1000, list(GRAVITY), tmp_path, assembly, fills=[found])
    assert any("K_AE" in line for line in loading.warnings) == (share > 1.0)
