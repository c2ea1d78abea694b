# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmarks at their smallest sizes, without any peer: what they measure is right."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from places import EXAMPLES

from benchmarks import constants, element_kinds, memory_per_contact, parts, peers, problem_files, rocking
from benchmarks.constants import SCENES, switched
from benchmarks.false_contacts import Count, Watch
from benchmarks.joint_points import costs
from benchmarks.lmgc90_error import judge
from benchmarks.ours import measure, stepper
from benchmarks.profile import PHASES, line_of_steps, profile, tables
from benchmarks.scenes import GRAVITY, arcade, arch, scene, tower, wall
from benchmarks.sitting import numbers_of
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.dynamics import moreau_jean
from masonry_cd.mechanics.friction.problem import natural_map_error
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.state import rotation_matrices
from masonry_cd.mechanics.solvers import SOLVERS, Options, admm, auto, interior, newton, nlgs

# --- scenes -----------------------------------------------------------------------------------------------------------------------


def test_scenes_have_the_sizes_that_they_are_known_by():
    assert [len(scene(name).blocks) for name in ("tower50", "wall10x10", "arcade3", "arch27")] == [51, 106, 69, 28]
    assert len(arcade(50).blocks) == 1009
    assert len(scene("wall4x3").blocks) == 1 + 4 + 5 + 4
    with pytest.raises(ValueError, match='no scene "wall4"; known: block, arch27'):
        scene("wall4")


@pytest.mark.parametrize("made", [tower(3), wall(3, 2), arcade(1), arch(9)], ids=lambda made: made.name)
def test_blocks_are_closed_and_look_outwards(made):
    for block in made.blocks:
        assert mass_properties(block.vertices, block.faces).volume > 0, block.name


def test_voussoirs_fill_the_ring():
    free = [block for block in arch(9, ratio=0.2).blocks if not block.fixed]
    volume = sum(mass_properties(block.vertices, block.faces).volume for block in free)
    assert volume == pytest.approx(0.5 * 9 * (5.5**2 - 4.5**2) * np.sin(np.pi / 9))  # nine straight-edged sectors


def test_the_block_rocks_to_both_sides_and_stands():
    machine, lean = stepper(scene("block"), 1000), []
    for _ in range(1000):
        machine.step()
        lean.append(machine.state.orientation[1, 2])  # half the angle
    assert -0.1 < min(lean) < -0.01 < 0.01 < max(lean) < 0.1  # half of the corner's lies at 0.12


def test_a_peer_gets_the_same_blocks_and_a_base_that_starts_from_rest(tmp_path):
    made = wall(3, 2)
    made.write(tmp_path / "scene.json", 7)
    given = json.loads((tmp_path / "scene.json").read_text())
    assert np.array_equal(given["blocks"][4]["vertices"], made.blocks[4].vertices)
    assert given["blocks"][0]["fixed"]
    velocity = np.array(given["base_velocity"])
    assert velocity[0] == 0.0
    assert np.diff(velocity)[0] == pytest.approx(0.2 * 2 * np.pi * 2.0 * 1e-3, rel=1e-4)  # C w dt


# --- ours -------------------------------------------------------------------------------------------------------------------------


def test_ours_measures_a_run():
    out = measure(tower(3), 20, "nlgs", 1e-6)
    assert (out.blocks, out.contacts, out.steps, out.planar) == (4, 6.0, 20, True)
    assert out.missed == 0
    assert 0 < out.error_median <= out.error_max <= 1e-6
    assert 0 < out.detection_share < 1
    assert min(out.first_ms, out.median_ms, out.mean_ms) > 0
    assert sum(out.reasons.values()) == 20


def test_ours_says_when_a_tolerance_is_missed():
    assert measure(tower(3), 5, "nlgs", 1e-12, max_iterations=1).missed == 5


def test_in_space_there_are_twice_the_contacts_of_a_plane():
    flat, full = (measure(arcade(1), 3, "nlgs", 1e-3, planar=planar) for planar in (True, False))
    assert full.contacts == 2 * flat.contacts > 0


SIZES = ("wall10x10", "wall20x24")


def test_memory_per_contact_is_that_of_the_scene():
    small, large = (memory_per_contact.Measured(**numbers_of("benchmarks.memory_per_contact", [name, "--steps", "8"])) for name in SIZES)
    assert small.contacts < 0.3 * large.contacts
    assert 0.0 < large.resident <= large.peak
    assert 500.0 < large.per_contact < 20_000.0
    assert large.resident > 1.5 * small.resident
    with pytest.raises(ValueError, match="steps: at least 4"):
        memory_per_contact.measure(tower(2), 3)


# --- LMGC90's results by our measure ----------------------------------------------------------------------------------------------


def as_lmgc90(made, steps: int, tolerance: float) -> tuple[dict[str, np.ndarray], list[float]]:
    """A run of ours written down as LMGC90 would, and the errors of its steps."""
    machine = stepper(made, steps, "nlgs", tolerance, planar=False)
    position, axes, out, errors = [machine.state.position.copy()], [rotation_matrices(machine.state.orientation)], {}, []
    for k in range(1, steps + 1):
        errors.append(machine.step().error)
        position.append(machine.state.position.copy())
        axes.append(rotation_matrices(machine.state.orientation).transpose(0, 2, 1))  # one axis per row
        found, impulse = machine.last.found, machine.solution.impulse
        frame = np.stack([found.normal, *tangents(found.normal)], axis=1)
        force = impulse_in(frame, found, impulse, machine) / made.dt
        out[f"icdbdy_{k}"], out[f"ianbdy_{k}"] = (found.bodies + 1).T
        gap = np.where(found.gap > machine.system.constants.closed, found.gap, np.minimum(found.gap, 0.0))  # as the contact law saw it
        out[f"coor_{k}"], out[f"gap_{k}"] = found.point.copy(), gap[:, None]
        out[f"uc_{k}"] = frame[:, [1, 0, 2]].reshape(-1, 9)
        out[f"rloc_{k}"], out[f"vloc_{k}"] = force[:, [1, 0, 2]], np.zeros((len(found.gap), 3))
    return out | {"sampled": np.arange(1, steps + 1), "position": np.array(position), "axes": np.array(axes)}, errors


def tangents(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Any two tangents."""
    first = np.cross(normal, [0.3, 0.5, 0.7])
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)


def impulse_in(frame: np.ndarray, found, impulse: np.ndarray, machine) -> np.ndarray:
    """Impulses in other axes than those of the solver."""
    return np.einsum("cij,ckj,ck->ci", frame, machine.last.rows.frame, impulse)


def test_positions_and_forces_alone_give_back_the_error_of_each_step():
    made = tower(4)
    result, errors = as_lmgc90(made, 6, 1e-4)
    judged = judge(made, result)
    assert judged.errors == pytest.approx(np.array(errors), rel=1e-3)
    assert judged.residual < 1e-6
    result["rloc_3"] *= 1.01
    worse = judge(made, result)
    assert worse.residual > 1e-3  # wrong forces do not go unseen
    assert worse.errors[2] > 3 * judged.errors[2]


# --- rocking ----------------------------------------------------------------------------------------------------------------------


def test_the_rocking_reference_loses_at_each_impact_what_housner_says():
    motion, angle = rocking.housner(np.linspace(0.0, 3.0, 3001))
    height = np.cos(rocking.ALPHA - motion.peaks) - np.cos(rocking.ALPHA)  # of the energy at the peaks; the pulse is over
    assert height[1:] / height[:-1] == pytest.approx((1.0 - 1.5 * np.sin(rocking.ALPHA) ** 2) ** 2, rel=1e-6)
    assert np.nanmax(np.abs(angle)) >= motion.peaks[0] * (1 - 1e-4)
    assert np.isnan(angle[-1])
    assert np.diff(motion.impacts).min() > 0


def test_impacts_and_peaks_are_read_off_a_history():
    dt = 1e-2
    t = dt * np.arange(400)
    motion = rocking.observed(np.where(t < 0.5, 0.0, -np.exp(-0.3 * t) * np.sin(2 * np.pi * (t - 0.5))), dt)
    assert motion.impacts == pytest.approx(1.0 + 0.5 * np.arange(4), abs=1e-3)
    assert motion.peaks == pytest.approx(np.exp(-0.3 * np.array([1.25, 1.75, 2.25])), rel=2e-2)


def test_ours_rocks_as_housner_does():
    angle = rocking.ours_angle(2e-3, 750, "nlgs")
    late, low, rms = rocking.errors(angle, 2e-3)
    assert late < 2e-3
    assert low < 5e-3
    assert rms < 0.01 * rocking.ALPHA


# --- tables -----------------------------------------------------------------------------------------------------------------------


def test_a_peer_that_is_not_there_is_reported_in_one_line(capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["peers", "scenes", "tower3", "--runs", "1", "--lmgc90-python", sys.executable])
    with pytest.raises(SystemExit) as end:
        peers.main()
    assert end.value.code == 2
    assert capsys.readouterr().err == "LMGC90: ModuleNotFoundError: No module named 'compas_lmgc90'\n"


def test_each_part_of_a_run_has_its_own_seconds():
    before = parts.problem.error_norms
    costs = parts.measure(tower(3), 6, frame_every=3)
    assert parts.problem.error_norms is before  # the clocks are off again
    assert set(costs.seconds) >= {"narrow phase", "contact rows", "iterations", "joints", "output"}
    assert (costs.calls["contact rows"], costs.calls["step, rest"], costs.steps) == (6, 6, 6)
    assert (costs.blocks, costs.joints) == (4, 3)
    assert sum(costs.seconds.values()) > 0.0
    lines = parts.table([costs, costs])
    assert all("x 1.00" in line for line in lines if line.startswith("| all"))


def test_a_problem_of_a_scene_goes_to_a_file_and_back(tmp_path):
    problem = problem_files.of_step("tower2", 1)
    problem_files.save(problem, tmp_path / "problem.npz")
    again = problem_files.load(str(tmp_path / "problem.npz"))
    assert abs(again.w - problem.w).max() == 0.0
    answer = SOLVERS["nlgs"](again, Options(tolerance=1e-9), None).impulse
    assert natural_map_error(problem, answer) <= 1e-9
    weight = 2 * 0.5 * 0.5 * 0.25 * 2000.0 * GRAVITY * 1e-3
    assert answer[:, 0].sum() == pytest.approx(1.5 * weight)  # the joint carries one block, the base two


def test_kinds_of_blocks_are_timed_on_the_same_scene(monkeypatch):
    """A rigid tower has six unknowns a block in space and three in its plane; one cut into triangles has those of its mesh."""
    monkeypatch.setitem(element_kinds.SCENES, "wall", "tower2")
    monkeypatch.setattr(element_kinds, "FIRST", 1)
    rigid = element_kinds.cost("wall", "rigid", 3, 1e9, 0.0, 1e-6)
    cut = element_kinds.cost("wall", "tetrahedra", 3, 1e9, 10.0, 1e-6)
    assert rigid[:2] == (0, 3)
    assert cut[:2] == (5, 10)
    assert cut[4] > 0.0


def test_steps_phases_and_methods_are_counted() -> None:
    """Each step once; the phases are no longer than the steps, and the methods no longer than the phase that solves."""
    places = [(moreau_jean, name) for name in PHASES]
    places += [(admm, "run_by_team"), (newton, "over_bodies"), (interior, "over_bodies"), (nlgs, "run_by_team")]
    before = [getattr(owner, name) for owner, name in places]
    found = profile(EXAMPLES / "arch.toml", ["run.duration=0.05"])
    assert [getattr(owner, name) for owner, name in places] == before
    assert len(found.seconds) == len(found.errors) == len(found.contacts) > 0
    assert set(found.phases) == set(PHASES)
    assert sum(each.iterations for each in found.methods.values()) > 0
    assert sum(each.seconds for each in found.methods.values()) <= found.phases["solve"] <= sum(found.seconds)
    assert all(each.moved > 0.0 for each in found.methods.values() if each.iterations)
    assert sum(line.startswith(("| predict", "| solve")) for line in tables(found)) == 2
    assert line_of_steps(found) in tables(found)


def test_all_that_is_spent_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The thrown walls take ADMM, and two of them Newton."""
    spent: dict[str, int] = dict.fromkeys(auto.METHODS, 0)

    def noted(name: str, method: Any) -> SimpleNamespace:
        def solve(*problem: Any) -> Any:
            found = method.solve(*problem)
            spent[name] += found.iterations
            return found

        return SimpleNamespace(solve=solve)

    methods = {name: noted(name, method) for name, method in auto.METHODS.items()}
    monkeypatch.setattr(auto, "METHODS", methods)
    found = constants.measure(SCENES["thrown walls"])
    assert found.iterations == spent
    assert spent["admm"] > 0
    assert found.cost > 0.0
    assert (found.steps, found.missed) == (3, 0)
    assert auto.METHODS is methods


def test_a_switched_constant_shows_in_the_counts_and_is_put_back() -> None:
    """With few iterations of ADMM others have to do more."""
    usual, limit = constants.measure(SCENES["thrown walls"]), auto.MOST
    with switched("MOST", 1):
        other = constants.measure(SCENES["thrown walls"])
    assert other.iterations["newton"] > usual.iterations["newton"]
    assert limit == auto.MOST
    assert constants.measure(SCENES["thrown walls"]).iterations == usual.iterations


@pytest.mark.parametrize(("lowered", "overlaps", "early"), [(0.0, 0, 0), (0.1, 1, 0), (-0.1, 0, 1)])
def test_a_gap_that_jumps_is_counted_once(monkeypatch: pytest.MonkeyPatch, lowered: float, overlaps: int, early: int) -> None:
    """The last pair of a tower at rest comes, in one detection, 100 mm deeper than before, or back from 100 mm above."""
    machine, detect, made, seen = stepper(tower(3, amplitude=0.0), 8), Detector.detect, Count(), []

    def shifted(self: Detector, *where: Any) -> Any:
        found = detect(self, *where)
        seen.append(len(found.gap))
        if len(seen) == 5:
            found.gap[found.pair == found.pair.max()] -= lowered
        return found

    monkeypatch.setattr(Detector, "detect", shifted)
    Watch(machine, made)
    state = machine.state
    for _ in range(8):
        machine.detector.detect(state.position, rotation_matrices(state.orientation), state.velocity, 1e-3, 1e-3, np.zeros(3))
    assert (made.overlaps, made.steps_with_overlaps, made.early, made.pairs) == (overlaps, overlaps, early, 8 * 3)
    assert made.deepest == pytest.approx(0.1 if overlaps else 0.0, abs=0.01)


WALL = """
structure = { kind = "wall", length = 0.8, height = 0.6, thickness = 0.2, unit_length = 0.4, course_height = 0.2 }
material = { density = 2000.0, friction = 0.6, joints = { normal_stiffness = 1e9 } }
run = { dt = 2e-3, duration = 0.2, tolerance = 1e-5 }
loads = [{ kind = "sinusoidal", direction = "y", amplitude = 0.3, frequency = 3.0, cycles = 2 }]
"""


def test_what_rings_cost_is_tabled_next_to_three_points_and_rings_in_all_joints(tmp_path: Path) -> None:
    scene = tmp_path / "wall.toml"
    scene.write_text(WALL)
    _, _, *rows = costs(scene, [], 60).splitlines()
    names, contacts = zip(*((cells[1].strip(), int(cells[2])) for cells in (row.split("|") for row in rows)), strict=True)
    assert names == ("3", "7", "9", "11", "9 in all joints")
    assert contacts[0] < contacts[1] < contacts[2] < contacts[3] and contacts[2] <= contacts[4]
