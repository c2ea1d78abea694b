# SPDX-License-Identifier: GPL-3.0-or-later
"""Links against closed forms: pendulums, sliders, blocks that are one, a three-hinged arch; their energy, their forces, their restarts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import masonry_cd as mc
from masonry_cd.app.case import prepare
from structures.geometry.prism import prism_xz

G = 9.81
SUPPORT = mc.box((-0.05, -0.05, 2.5), (0.05, 0.05, 2.6))  # out of the way of what swings
PIN = {"kind": "hinge", "blocks": ["b1", "b0"], "point": [0.0, 0.0, 0.0]}


def turned(low: tuple[float, ...], high: tuple[float, ...], angle: float) -> tuple[np.ndarray, Any]:
    """A box turned about the axis y through the origin."""
    vertices, faces = mc.box(low, high)
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(vertices) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T, faces


def simulation(blocks: list[Any], links: list[dict[str, Any]], fixed: Any = "b0", loads: Any = (), **run: Any) -> mc.Simulation:
    scene = mc.scene(
        structure={"blocks": blocks, "fixed": fixed},
        material={"density": 2000.0, "friction": 0.5},
        loads=list(loads),
        links=links,
        run={"dt": 1e-3, "duration": 3.0} | run,
    )
    return mc.Simulation(scene)


def rod(angle: float, length: float = 1.0, width: float = 0.1) -> tuple[np.ndarray, Any]:
    """A rod that hangs from the origin."""
    return turned((-width / 2, -0.05, -length), (width / 2, 0.05, 0.0), angle)


# --- pendulums --------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("degrees", "axis", "planar"), [(2.0, False, True), (60.0, False, True), (60.0, True, False)])
def test_a_rod_on_a_pin_swings_with_the_period_of_the_elliptic_integral_and_keeps_its_energy(degrees, axis, planar):
    amplitude = np.radians(degrees)
    pin = PIN | ({"axis": [0.0, 1.0, 0.0]} if axis else {})
    sim = simulation([SUPPORT, rod(amplitude)], [pin], dt=2e-3, duration=2.8, planar=planar)
    assert (sim.problem().dimension == 2) == planar
    p = np.sqrt(G * 0.5 / ((1.0 + 0.1**2) / 12 + 0.25))
    times, ways = [0.0], [sim.state.position[1, 0]]
    drift = 0.0
    while not sim.done:
        sim.step()
        times.append(sim.time)
        ways.append(sim.state.position[1, 0])
        drift = max(drift, abs(sim.energy["kinetic"] - sim.energy["gravity_work"]))
    x, t = np.array(ways), np.array(times)
    at = np.flatnonzero(x[:-1] * x[1:] < 0.0)
    crossings = t[at] + (t[at + 1] - t[at]) * x[at] / (x[at] - x[at + 1])
    assert 2.0 * np.diff(crossings).mean() == pytest.approx(4.0 * ellipk(np.sin(amplitude / 2) ** 2) / p, rel=1e-5)
    assert drift < 3e-4 * 20.0 * G * 0.5 * (1.0 - np.cos(amplitude)) + 1e-9
    assert abs(sim.energy["balance"]) < 1e-9
    assert np.abs(sim.links()[0].point - PIN["point"]).max() < 2e-6


def test_the_pin_of_a_pendulum_pulls_by_weight_and_centrifugal_force():
    sim = simulation([SUPPORT, rod(np.radians(60.0))], [PIN], duration=0.6)
    while sim.state.position[1, 0] < 0.0:
        sim.step()
    at = sim.state
    weight = 2000.0 * 0.1 * 0.1 * G
    inertia = (1.0 + 0.1**2) / 12 + 0.25
    spin = np.sqrt(2.0 * G * 0.5 * (np.cos(np.arctan(at.position[1, 0] / at.position[1, 2])) - 0.5) / inertia)
    pin = sim.links()[0]
    assert pin.force[2] == pytest.approx(weight * (1.0 + 0.5 * spin**2 / G), rel=3e-3)
    assert sim.reactions()["b0"][:3] == pytest.approx(pin.force, rel=1e-9)
    assert (pin.kind, pin.blocks) == ("hinge", ("b1", "b0")) and np.abs(pin.moment).max() < 1e-9


def test_a_double_pendulum_keeps_its_energy_however_wildly_it_swings():
    tip = -np.array([np.sin(np.radians(110.0)), 0.0, np.cos(np.radians(110.0))])
    second = turned((-0.05, -0.05, -2.0), (0.05, 0.05, -1.01), np.radians(110.0))
    lower = {"kind": "hinge", "blocks": ["b2", "b1"], "point": tip.tolist()}
    change = {}
    for dt in (4e-3, 2e-3):
        sim = simulation([SUPPORT, rod(np.radians(110.0)), second], [PIN, lower], dt=dt, duration=1.6)
        change[dt] = 0.0
        while not sim.done:
            sim.step()
            change[dt] = max(change[dt], abs(sim.energy["kinetic"] - sim.energy["gravity_work"]))
        assert abs(sim.energy["balance"]) < 1e-8
    print(change)
    assert change[2e-3] < 0.3 * change[4e-3] and change[2e-3] < 0.5  # of some 500 J: of second order, and no drift


def test_a_top_on_a_ball_joint_precesses_at_m_g_l_over_its_spin():
    base, lean = mc.box((-0.3, -0.3, -0.4), (0.3, 0.3, -0.2)), np.radians(30.0)
    sim = simulation([base, turned((-0.2, -0.2, 0.0), (0.2, 0.2, 0.2), lean)], [PIN], dt=5e-4, duration=0.4, planar=False)
    axis, spin = np.array([np.sin(lean), 0.0, np.cos(lean)]), 200.0
    precession = G * 0.1 / (0.4**2 / 6 * spin)
    turning = spin * axis + [0.0, 0.0, precession]
    sim.state = sim.state.changed("b1", velocity=(*np.cross(turning, 0.1 * axis), *turning))
    sim.run()
    x, y, z = sim.state.position[1]
    assert np.arctan2(y, x) == pytest.approx(0.4 * precession, rel=0.02)
    assert z == pytest.approx(0.1 * np.cos(lean), rel=2e-3)


# --- sliders and rigid links --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planar", [True, False])
def test_a_slider_on_an_incline_takes_sqrt_2s_over_a(planar):
    slope = np.radians(30.0)
    rail = turned((-2.0, -0.1, -0.4), (2.0, 0.1, 0.0), slope)
    cart = turned((-1.0, -0.1, 0.0), (-0.8, 0.1, 0.5), slope)  # higher than long: without the rail it would topple
    along = [float(np.cos(slope)), 0.0, float(-np.sin(slope))]
    sim = simulation([rail, cart], [{"kind": "slider", "blocks": ["b1", "b0"], "axis": along}], duration=0.5, planar=planar)
    sim.run()
    way = 0.5 * G * np.sin(slope) * 0.5**2
    assert sim.state.position[1] - sim.structure["b1"].mass_properties.centre == pytest.approx(way * np.array(along), abs=2e-3 * way)
    assert sim.state.orientation[1] == pytest.approx([1, 0, 0, 0], abs=1e-9)
    rail_force = sim.links()[0]
    assert rail_force.force @ along == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(rail_force.force) == pytest.approx(2000.0 * 0.2 * 0.2 * 0.5 * G * np.cos(slope), rel=1e-6)


@pytest.mark.parametrize("planar", [True, False])
def test_two_blocks_tied_rigidly_rock_and_slide_as_one(planar):
    ground = mc.box((-3, -0.2, -0.5), (3, 0.2, 0.0))
    halves = [mc.box((-0.2, -0.2, 0.0), (0.2, 0.2, 0.5)), mc.box((-0.2, -0.2, 0.5), (0.2, 0.2, 1.2))]
    shaken = [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.5, "frequency": 1.5, "cycles": 1}]
    rigid = [{"kind": "rigid", "blocks": ["b1", "b2"]}]
    tied = simulation([ground, *halves], rigid, loads=shaken, duration=0.8, planar=planar)
    one = simulation([ground, mc.box((-0.2, -0.2, 0.0), (0.2, 0.2, 1.2))], [], loads=shaken, duration=0.8, planar=planar)
    largest = 0.0
    while not one.done:
        tied.step()
        one.step()
        largest = max(largest, abs(one.state.orientation[1, 2]))
    assert largest > 0.005  # it rocks
    assert tied.state.orientation[1] == pytest.approx(one.state.orientation[1], abs=2e-5)
    assert tied.state.orientation[2] == pytest.approx(tied.state.orientation[1], abs=1e-9)
    for name in ("kinetic", "impact", "base_work", "gravity_work"):
        assert tied.energy[name] == pytest.approx(one.energy[name], rel=5e-3, abs=0.02)
    assert abs(tied.energy["balance"]) < 1e-6


def test_a_three_hinged_arch_has_its_static_reactions_and_stands_still():
    """H = w L^2 / (8 f) of two straight bars of weight W / 2 each, rise f: H = W L / (8 f), V = W / 2."""
    half, rise, depth = 2.0, 1.5, 0.2
    length = float(np.hypot(half, rise))
    across = 0.5 * depth / length * np.array([-rise, half])
    left = np.array([[-half, 0.0], [-half / 2, rise / 2] - across, [0.0, rise], [-half / 2, rise / 2] + across])
    bars = [prism_xz(left, -0.1, 0.1), prism_xz(left * [-1.0, 1.0], -0.1, 0.1)]
    feet = [mc.box((x - 0.1, -0.1, -0.4), (x + 0.1, 0.1, -0.2)) for x in (-half, half)]
    hinges = [
        {"kind": "hinge", "blocks": ["b0", "b2"], "point": [-half, 0.0, 0.0]},
        {"kind": "hinge", "blocks": ["b1", "b3"], "point": [half, 0.0, 0.0]},
        {"kind": "hinge", "blocks": ["b2", "b3"], "point": [0.0, 0.0, rise]},
    ]
    sim = simulation([*feet, *bars], hinges, fixed=["b0", "b1"], duration=0.1)
    sim.run()
    weight = 2000.0 * length * depth * 0.2 * G
    thrust = weight * 2.0 * half / (8.0 * rise)
    springing, other, crown = (link.force for link in sim.links())
    assert springing == pytest.approx([-thrust, 0.0, -weight / 2], rel=1e-6, abs=1e-6)
    assert other == pytest.approx([thrust, 0.0, -weight / 2], rel=1e-6, abs=1e-6)
    assert crown == pytest.approx([-thrust, 0.0, 0.0], rel=1e-6, abs=1e-4)
    assert np.abs(sim.state.velocity).max() < 1e-8


def test_a_shaken_support_works_through_a_hinge_and_the_balance_closes():
    shaken = [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 1.0, "cycles": 2}]
    sim = simulation([SUPPORT, rod(0.0)], [PIN], loads=shaken, duration=1.5)
    base = 0.0
    while not sim.done:
        before = sim.state.velocity[0, 0]
        sim.step()
        base += 1e-3 * sim.links()[0].force[0] * 0.5 * (before + sim.state.velocity[0, 0])
    assert sim.energy["base_work"] == pytest.approx(base, rel=1e-9) and base > 0.1
    assert abs(sim.energy["balance"]) < 1e-9 and abs(sim.energy["impact"]) < 1e-3 * base


def test_two_balls_on_a_line_are_a_hinge_about_it_though_they_hold_more_than_it_needs():
    balls = [PIN | {"point": [0.0, y, 0.0]} for y in (-0.05, 0.05)]
    several, one = (
        simulation([SUPPORT, rod(1.0)], links, dt=2e-3, duration=0.3, planar=False) for links in (balls, [PIN | {"axis": [0.0, 1.0, 0.0]}])
    )
    several.run()
    one.run()
    assert several.state.position[1] == pytest.approx(one.state.position[1], abs=1e-12)
    assert sum(link.force for link in several.links()) == pytest.approx(one.links()[0].force, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("stiffness", [{}, {"joints": {"normal_stiffness": 1e9}}])
def test_blocks_that_links_make_one_need_no_contact_between_them_and_weigh_on_their_support(stiffness):
    boxes = [mc.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), mc.box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0)), mc.box((1.0, 0.0, 0.0), (2.0, 1.0, 2.0))]
    rigid = [{"kind": "rigid", "blocks": ["b1", "b2"]}, {"kind": "rigid", "blocks": ["b2", "b3"]}]  # b1 and b3 touch, too
    ground = mc.box((-1, -1, -0.5), (3, 2, 0.0))
    sim = mc.Simulation(
        mc.scene(
            structure={"blocks": [ground, *boxes], "fixed": "b0"},
            material={"density": 2000.0, "friction": 0.5} | stiffness,
            links=rigid,
            run={"dt": 1e-3, "duration": 0.02},
        )
    )
    sim.run()
    assert sim.reactions()["b0"][2] == pytest.approx(4.0 * 2000.0 * G, rel=1e-6)
    assert np.abs(sim.state.velocity).max() < 1e-8
    assert {tuple(pair) for pair in sim.contacts.blocks.tolist()} <= {(1, 0), (3, 0), (0, 1), (0, 3)}
    assert sum(abs(link.force[2]) for link in sim.links()) > 100.0 and not prepare(sim.scene.checked).doubts


# --- solvers, restarts, state -------------------------------------------------------------------------------------------------------


def beam_on_a_hinge(**run: Any) -> mc.Simulation:
    """A beam, hinged to a post, that falls onto a stack at its other end, which is shaken."""
    blocks = [
        mc.box((-2, -0.3, -0.5), (4, 0.3, 0.0)), mc.box((-0.2, -0.2, 0.0), (0.2, 0.2, 1.0)), mc.box((0.3, -0.2, 0.8), (3.0, 0.2, 1.0)),
        mc.box((2.3, -0.3, 0.0), (2.8, 0.3, 0.4)), mc.box((2.3, -0.3, 0.4), (2.8, 0.3, 0.79)),
    ]  # fmt: skip
    hinge = {"kind": "hinge", "blocks": ["b2", "b1"], "point": [0.2, 0.0, 0.9]}
    rigid = {"kind": "rigid", "blocks": ["b1", "b0"]}
    shaken = [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 3.0, "cycles": 1}]
    return simulation(blocks, [hinge, rigid], loads=shaken, duration=0.3, tolerance=1e-9, **run)


def test_all_solvers_find_the_same_motion_of_a_beam_that_lands():
    found = []
    for solver in ("auto", "nlgs", "admm", "newton", "pivoting"):
        sim = beam_on_a_hinge(solver=solver, dt=2e-3)
        sim.run()
        assert abs(sim.energy["balance"]) < 1e-6
        found.append(sim.state.position[2:])
    spread = max(float(np.abs(other - found[0]).max()) for other in found[1:])
    assert spread < 1e-5
    assert found[0][0, 2] < 0.9  # it has come down


@pytest.mark.parametrize("planar", [True, False])
def test_linked_blocks_restart_to_the_bit(tmp_path, planar):
    sim = beam_on_a_hinge(dt=2e-3, planar=planar)
    sim.run(until=0.1)
    sim.save(tmp_path / "there.h5")
    other = beam_on_a_hinge(dt=2e-3, planar=planar)
    other.restore(tmp_path / "there.h5")
    sim.run()
    other.run()
    for name in ("position", "orientation", "velocity"):
        assert np.array_equal(getattr(sim.state, name), getattr(other.state, name))
    assert sim.energy == other.energy


def test_a_state_that_tears_a_link_is_refused():
    sim = simulation([SUPPORT, rod(0.3)], [PIN])
    with pytest.raises(mc.InputError, match=r"have to close 0\.1 m"):
        sim.state = sim.state.changed("b1", position=sim.state.position[1] + [0.1, 0.0, 0.0])


def test_links_go_with_blocks_and_released_supports_and_a_block_does_not_come_back_to_one_that_has_moved():
    blocks = [mc.box((-3.0, -1.0, -9.0), (3.0, 1.0, -8.0)), SUPPORT, rod(0.3)]
    sim = simulation(blocks, [PIN | {"blocks": ["b2", "b1"]}], ["b0", "b1"], duration=0.4)
    sim.run(until=0.1)
    mass = np.array([block.mass_properties.volume * 2000.0 for block in sim.structure])[1:]
    before = mass @ sim.state.velocity[1:, :3] / mass.sum()
    sim.release("b1")
    sim.run(until=0.2)
    assert mass @ sim.state.velocity[1:, :3] / mass.sum() - before == pytest.approx([0.0, 0.0, -0.1 * G], abs=1e-9)
    assert len(sim.links()) == 1 and abs(sim.energy["balance"]) < 1e-9
    sim.remove("b2")
    sim.run(until=0.3)
    assert sim.links() == []
    with pytest.raises(mc.InputError, match="have to close"):
        sim.add("b2")
