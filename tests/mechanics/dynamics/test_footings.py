# SPDX-License-Identifier: GPL-3.0-or-later
"""Footings on springs and dashpots of the ground: settlement, periods, decrements, transmissibility in closed form; energy, restart."""

from __future__ import annotations

from copy import deepcopy
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import masonry_cd as mc
from masonry_cd.analysis.pushover import require_pushes
from masonry_cd.app.case import prepare
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.ground_table import GroundTable
from masonry_cd.mechanics.model.impedance import Soil, impedance
from masonry_cd.studies.assess.assumptions import assumptions_of
from masonry_cd.studies.laboratory.case import run_in
from structures.geometry.prism import box

G = 9.81
STIFF = {"x": 1e14, "y": 1e14, "z": 1e14, "rx": 1e15, "ry": 1e15, "rz": 1e15}
FOOTING, BLOCK = mc.box((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0)), mc.box((-0.9, -0.9, 0.0), (0.9, 0.9, 2.0))
MASSES = np.array([8000.0, 12960.0])
MASS = float(MASSES.sum())
HEIGHT = float(MASSES @ [0.5, 2.0]) / MASS  # of both above the base
INERTIA = float(MASSES @ [(2.0**2 + 1.0**2) / 12.0 + 0.5**2, (1.8**2 + 2.0**2) / 12.0 + 2.0**2])  # about the middle of the base
ONE = [{"kind": "rigid", "blocks": ["b1", "b0"]}]


def scene_of(ground: dict[str, Any] | None, loads: Any = (), links: Any = (), blocks: Any = (FOOTING, BLOCK), **more: Any) -> mc.Scene:
    material, events = more.pop("material", {}), more.pop("events", [])
    return mc.scene(
        structure={"blocks": list(blocks), "fixed": "b0"},
        material={"density": 2000.0, "friction": 0.8} | material,
        loads=list(loads),
        links=list(links),
        ground=[] if ground is None else [ground],
        events=events,
        run={"dt": 1e-3, "duration": 2.0, "tolerance": 1e-10} | more,
    )


def simulation(*asked: Any, **more: Any) -> mc.Simulation:
    return mc.Simulation(scene_of(*asked, **more))


def assembly_of(ground: dict[str, Any], footing: Any) -> Assembly:
    scene = scene_of(ground, blocks=(footing, BLOCK))  # its blocks are in a file that goes with it
    return prepare(scene.checked).assembly


def swung(sim: mc.Simulation, velocity: np.ndarray, seconds: float, column: int) -> tuple[np.ndarray, np.ndarray]:
    """Times, and shifts of the footing's centre along an axis, after a push of both blocks by velocities (2, 6)."""
    pushed = sim.state.velocity.copy()
    pushed[:2] = velocity
    sim.state = sim.state.changed(velocity=pushed)
    rest, times, ways = sim.state.position[0, column], [], []
    while sim.time < seconds - 1e-9:
        sim.step()
        times.append(sim.time)
        ways.append(sim.state.position[0, column] - rest)
    return np.array(times), np.array(ways)


def period_and_decrement(times: np.ndarray, ways: np.ndarray) -> tuple[float, float]:
    """Mean distance of upward crossings of zero, and the mean logarithmic decrement of the peaks between them."""
    up = np.flatnonzero((ways[:-1] < 0.0) & (ways[1:] >= 0.0))
    crossings = times[up] - ways[up] * (times[up + 1] - times[up]) / (ways[up + 1] - ways[up])
    peaks = []
    for first, last in pairwise(up.tolist()):
        k = first + int(np.argmax(ways[first:last]))
        a, b, c = ways[k - 1 : k + 2]
        peaks.append(b + (c - a) ** 2 / (8.0 * (2.0 * b - a - c)))
    return float(np.diff(crossings).mean()), float(-np.diff(np.log(peaks)).mean())


# --- closed forms -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planar", [True, False])
def test_a_footing_settles_by_its_weight_over_its_stiffness_and_the_ground_bears_it(planar):
    sim = simulation({"stiffness": STIFF | {"z": 2e7}}, planar=planar)
    assert sim.structure.blocks[0].vertices[:, 2].min() - sim.state.position[0, 2] == pytest.approx(-0.5 + MASS * G / 2e7, rel=1e-6)
    sim.step(3)
    assert sim.reactions()["b0.soil"][:3] == pytest.approx([0.0, 0.0, MASS * G], rel=1e-6, abs=1e-3)
    assert sim.energy["ground"] == pytest.approx(0.5 * (MASS * G) ** 2 / 2e7, rel=1e-6)


SHARE = 0.05  # of critical
VERTICAL = (2, "z", 2e7, MASS, 0.0)
SWAY = (1, "y", 2e7, MASS, 0.0)
ROCKING = (1, "rx", 1e8, INERTIA, MASS * G * HEIGHT)


@pytest.mark.parametrize(
    ("mode", "planar", "links"),
    [(VERTICAL, True, []), (VERTICAL, False, ONE), (SWAY, True, ONE), (SWAY, False, []), (ROCKING, True, []), (ROCKING, False, ONE)],
)
def test_free_vibration_has_the_period_and_the_decrement_of_its_spring_and_dashpot(mode, planar, links):
    column, way, spring, inertia, overturning = mode
    omega = np.sqrt((spring - overturning) / inertia)
    dashpot = 2.0 * SHARE * omega * inertia
    sim = simulation({"stiffness": STIFF | {way: spring}, "damping": {way: dashpot}}, planar=planar, links=links)
    push = np.zeros((2, 6))
    if way == "rx":
        push[:, 3], push[:, 1] = 1e-3, -1e-3 * np.array([0.5, 2.0])
    else:
        push[:, column] = 5e-3
    period, decrement = period_and_decrement(*swung(sim, push, 0.7, column))
    damped = np.sqrt(1.0 - SHARE**2)
    assert period == pytest.approx(2.0 * np.pi / (omega * damped), rel=1e-3)
    assert decrement == pytest.approx(2.0 * np.pi * SHARE / damped, rel=1e-3)
    assert abs(sim.energy["balance"]) < 1e-6 * sim.energy["radiation"]


@pytest.mark.parametrize("ratio", [0.5, 1.5])
def test_the_steady_response_to_a_shaken_ground_is_the_transmissibility(ratio):
    share, frequency = 0.3, 3.0
    omega = 2.0 * np.pi * frequency / ratio
    load = {"kind": "sinusoidal", "direction": "y", "amplitude": 0.02, "frequency": frequency, "cycles": 12, "ramp": 0.5}
    ground = {"stiffness": STIFF | {"y": MASS * omega**2}, "damping": {"y": 2.0 * share * omega * MASS}}
    sim = simulation(ground, [load], duration=4.0, dt=2e-3)
    ways = []
    while sim.time < 3.0:
        sim.step()
        if sim.time > 2.3:
            ways.append(sim.state.position[[0, 2], 1])
    own, given = np.ptp(ways, axis=0)
    damping = (2.0 * share * ratio) ** 2
    assert own / given == pytest.approx(np.sqrt((1.0 + damping) / ((1.0 - ratio**2) ** 2 + damping)), rel=1e-3)
    assert abs(sim.energy["balance"]) < 1e-9 * sim.energy["radiation"]


# --- limits, laws and restarts ----------------------------------------------------------------------------------------------------------

SHAKEN = [{"kind": "sinusoidal", "direction": "y", "amplitude": 0.3, "frequency": 2.0, "cycles": 2}]
SLENDER = (FOOTING, mc.box((-0.25, -0.25, 0.0), (0.25, 0.25, 1.5)))
SOFT = {
    "stiffness": {"x": 2e7, "y": 2e7, "z": 4e7, "rx": 1e8, "ry": 1e8, "rz": 1e8},
    "damping": {"x": 2e5, "y": 2e5, "z": 4e5, "rx": 1e5, "ry": 1e5, "rz": 1e5},
}
ELASTIC = {"joints": {"normal_stiffness": 1e10, "tangential_stiffness": 4e9}}


def paths(ground: dict[str, Any] | None, seconds: float) -> np.ndarray:
    """Shifts of the top block along y at all steps."""
    sim = simulation(ground, SHAKEN, blocks=SLENDER)
    ways = []
    while sim.time < seconds:
        sim.step()
        ways.append(sim.state.position[1, 1])
    return np.array(ways)


def test_a_block_on_hard_ground_rocks_as_on_a_support():
    held, hard = paths(None, 1.2), paths({"stiffness": STIFF}, 1.2)
    assert np.abs(hard - held).max() < 2e-3 * np.abs(held).max()


@pytest.mark.parametrize("material", [{}, ELASTIC])
@pytest.mark.parametrize("planar", [True, False])
def test_every_solver_takes_the_ground_and_energy_closes(material, planar):
    places = []
    for solver in ("auto", "nlgs", "interior"):
        sim = simulation(SOFT, SHAKEN, duration=0.5, tolerance=1e-8, material=material, planar=planar, solver=solver)
        sim.step(150)
        places.append(sim.state.position)
        assert abs(sim.energy["balance"]) < 1e-9 * sim.energy["radiation"]
    assert np.abs(np.ptp(places, axis=0)).max() < 1e-7


def test_a_run_on_ground_resumes_to_the_bit(tmp_path):
    whole, other = (simulation(SOFT, SHAKEN, duration=0.5, material=ELASTIC) for _ in range(2))
    whole.step(40)
    whole.save(tmp_path / "kept.npz")
    other.restore(tmp_path / "kept.npz")
    for sim in (whole, other):
        sim.step(40)
    assert np.array_equal(whole.state.position, other.state.position)
    assert whole.energy == other.energy


def test_a_settlement_named_by_the_support_moves_the_ground_below_and_events_leave_footings_alone():
    sink = {"kind": "settlement", "supports": "b0", "displacement": 0.01, "duration": 0.2}
    sim = simulation(SOFT, [sink], duration=1.0)
    first = sim.state.position.copy()
    sim.step(1000)
    assert sim.state.position[2, 2] - first[2, 2] == pytest.approx(-0.01, rel=1e-9)
    assert sim.state.position[:2, 2] - first[:2, 2] == pytest.approx([-0.01, -0.01], rel=1e-3)
    for change in ({"release": "b0"}, {"remove": "b0"}):
        with pytest.raises(mc.InputError, match="ground"):
            simulation(SOFT, [sink], events=[{"at": 0.1} | change])


def test_modes_on_ground_have_its_springs():
    found = mc.modal(scene_of(SOFT), method="joints", young=1e12, modes=6, pictures=0)
    frequency = min(found["models"]["joints"]["frequency_hz"])
    mass = np.array([[MASS, MASS * HEIGHT], [MASS * HEIGHT, INERTIA]])  # of a shift of the base along y and a turn about x
    lowest = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, np.diag([2e7, 1e8]))).min()) / (2.0 * np.pi)
    assert frequency == pytest.approx(lowest, rel=1e-2)


# --- from soil --------------------------------------------------------------------------------------------------------------------------


def test_springs_of_a_square_are_those_of_pais_and_kausel():
    """Factors alpha and damping ratios beta of a square at Poisson's ratio 1/3, evaluated from NIST GCR 12-917-21, table 2-3a."""
    soil, still = Soil(1.0, 1.0, 1.0 / 3.0), impedance(Soil(1.0, 1.0, 1.0 / 3.0), 2.0, 2.0)[0]
    shift, turn = 9.2 / (2.0 - 1.0 / 3.0), 4.0 / (1.0 - 1.0 / 3.0)
    assert still == pytest.approx([shift, shift, 4.7 / (1.0 - 1.0 / 3.0), turn, turn, 8.31], rel=1e-12)
    for a, alpha, beta in (
        (0.25, [1.0, 0.9963, 0.9833, 0.9761], [0.0906, 0.1424, 0.0019, 0.0018]),
        (1.0, [1.0, 0.9455, 0.8167, 0.8167], [0.3623, 0.6001, 0.0972, 0.0819]),
        (2.0, [1.0, 0.8286, 0.6333, 0.7250], [0.7246, 1.3695, 0.4840, 0.3279]),
    ):
        springs, dashpots = impedance(soil, 2.0, 2.0, a)
        some = [0, 2, 3, 5]
        assert (springs / still)[some] == pytest.approx(alpha, abs=6e-5)
        assert (dashpots * a / (2.0 * springs))[some] == pytest.approx(beta, abs=6e-5)


def test_a_footing_gets_the_springs_of_its_plan_as_it_lies():
    """A base of 4 m by 2 m, its longer side along y: what the formulas call x lies along y; and of twice the width by keys."""
    wide = mc.box((-1.0, -2.0, -1.0), (1.0, 2.0, 0.0))
    soil = {"shear_wave_velocity": 200.0, "density": 1800.0, "poisson": 0.3, "embedment": 0.5}
    springs, dashpots = impedance(Soil(1800.0 * 200.0**2, 1800.0, 0.3, 0.5), 4.0, 2.0)
    turned = [1, 0, 2, 4, 3, 5]
    footings = assembly_of(soil, wide).footings
    assert np.diagonal(footings.stiffness[0]) == pytest.approx(springs[turned], rel=1e-9)
    assert np.diagonal(footings.damping[0]) == pytest.approx(dashpots[turned], rel=1e-9)
    larger = np.diagonal(assembly_of(soil | {"length": 4.0, "width": 4.0}, wide).footings.stiffness[0])
    assert larger == pytest.approx(impedance(Soil(1800.0 * 200.0**2, 1800.0, 0.3, 0.5), 4.0, 4.0)[0], rel=1e-9)


def test_the_footing_of_a_tower_is_cut_out_of_its_slab_below_its_walls_and_has_its_added_mass():
    scene = mc.scene(
        structure={"kind": "tower", "side": 4.0, "height": 4.0, "thickness": 0.8, "course_height": 1.0, "base_depth": 0.5}
        | {"belfry_width": 0.0, "door_width": 0.0},
        material={"density": 2000.0, "friction": 0.6},
        ground=[{"shear_wave_velocity": 200.0, "density": 1800.0, "poisson": 0.3, "added_mass": 1000.0}],
        run={"dt": 1e-3, "duration": 0.1},
    )
    assembly = prepare(scene.checked).assembly
    own, below = assembly.footings.blocks[0]
    assert assembly.mass[own] == pytest.approx(4.0 * 4.0 * 0.5 * 2000.0 + 1000.0, rel=1e-9)
    assert np.ptp(assembly.blocks[own].vertices, axis=0) == pytest.approx([4.0, 4.0, 0.5], rel=1e-9)
    assert assembly.blocks[below].vertices[:, 2].max() == pytest.approx(assembly.blocks[own].vertices[:, 2].min(), abs=1e-12)


def test_an_assessment_halves_and_doubles_the_stiffness_of_the_soil():
    soil = {"shear_wave_velocity": 200.0, "density": 1800.0, "poisson": 0.3, "stiffness": {"x": 1e8}}
    scene = scene_of(soil).checked
    known, _ = assumptions_of(scene, deepcopy(dict(scene.tables)), shakes=True)
    (found,) = (one for one in known if one.name == "soil stiffness")
    for level, factor in zip(found.levels, (0.5, 2.0), strict=True):
        tables = deepcopy(dict(scene.tables))
        level.change(tables)
        made = [GroundTable(**keys).of_footing((4.0, 2.0), np.array([1.0, 0.0]))[0] for keys in (soil, *tables["ground"])]
        before, after = map(np.diagonal, made)
        assert after == pytest.approx(factor * before, rel=1e-12)


# --- a bed that does not pull ----------------------------------------------------------------------------------------------------

WIDTH, BED, TOP, WEIGHT = 2.0, 5e7, 2.0, G * MASS  # of the footing [m], stiffness of the bed [N/m3], where it is pushed [m], [N]


def rocked(folder: Path, **ground: Any) -> tuple[np.ndarray, np.ndarray]:
    """Turns [rad] of a footing and the block that is one with it, pushed at the top, and moments about the middle of the base [N m]."""
    area = WIDTH * WIDTH
    blocks = [
        Block("footing", *box((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0)), 2000.0, "base", fixed=True),
        Block("block", *box((-0.9, -0.9, 0.0), (0.9, 0.9, TOP)), 2000.0, "wall"),
    ]
    push = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "block", "point": [0.0, 0.0, TOP]}
    tables = {
        "title": "A footing that rocks",
        "material": {"density": 2000.0, "friction": 2.0},
        "links": [{"kind": "rigid", "blocks": ["block", "footing"]}],
        "ground": [{"uplift": True, "stiffness": {"x": 100.0 * BED * area, "z": BED * area}} | ground],
        "loads": [push | {"targets": [0.045], "speed": 0.02}],
        "run": {"dt": 5e-3, "tolerance": 1e-8, "frames_per_second": 20.0},
    }
    with run_in(folder, blocks, tables) as results:
        names = [block.name for block in results.blocks]
        turn = 2.0 * np.asarray(results.orientation[:, names.index("footing"), 2])
        curve = require_pushes(results)[0]
        force = np.interp(results.time, curve.time, curve.force)
    return turn, force * (TOP + 1.0) + WEIGHT * HEIGHT * turn  # the weight goes with the turn


def test_a_footing_on_a_bed_lifts_off_by_the_closed_form(tmp_path: Path) -> None:
    # Pressed over s: N = k B s^2 theta / 2, M = N (L / 2 - s / 3); before, M = k B L^3 theta / 12.
    turn, moment = rocked(tmp_path)
    lifted = turn > 1.2 * 2.0 * WEIGHT / (BED * WIDTH**3)
    length = np.sqrt(2.0 * WEIGHT / (BED * WIDTH * turn[lifted]))
    assert lifted.sum() > 10
    assert moment[lifted] == pytest.approx(WEIGHT * (WIDTH / 2.0 - length / 3.0), rel=0.03)
    whole = (turn > 0.2 * WEIGHT / (BED * WIDTH**3)) & (turn < 1.8 * WEIGHT / (BED * WIDTH**3))
    assert moment[whole] == pytest.approx(BED * WIDTH**4 * turn[whole] / 12.0, rel=0.03)


def test_a_bed_yields_at_its_bearing_strength(tmp_path: Path) -> None:
    strength = 4.0 * WEIGHT / WIDTH**2
    turn, moment = rocked(tmp_path, bearing_strength=strength)
    expected = WEIGHT * WIDTH / 2.0 * (1.0 - WEIGHT / (strength * WIDTH**2))  # M = N L / 2 (1 - N / (q B L))
    assert turn[-1] > 5e-3
    assert moment.max() == pytest.approx(expected, rel=0.04)


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"bearing_strength": 1e5}, "bearing_strength needs uplift"),
        ({"uplift": True, "stiffness": {"x": 1e9, "z": 1e9}, "damping": {"x": 1e5}}, "damping.x counts without uplift"),
        ({"uplift": True, "stiffness": {"z": 1e9}}, "stiffness.x"),
    ],
)
def test_keys_of_beds_go_together(ground: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        scene_of({"stiffness": STIFF} | ground)
