# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmarks at their smallest sizes, without any peer: what they measure is right."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks import element_kinds, memory, memory_per_contact, parts, peers, problem_files, rocking, scaling
from benchmarks.counters import Counters
from benchmarks.lmgc90_error import judge
from benchmarks.ours import measure, stepper
from benchmarks.scenes import GRAVITY, arcade, arch, scene, tower, wall
from benchmarks.sitting import numbers_of
from masonry_cd.mechanics.dynamics import islands
from masonry_cd.mechanics.friction.problem import natural_map_error
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.state import rotation_matrices
from masonry_cd.mechanics.solvers import SOLVERS, Options

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


def test_instructions_are_those_of_this_thread():
    counters = Counters.open()
    if counters is None:
        pytest.skip("this machine gives no counters of the processor")

    def counted(turns: int) -> int:
        before = counters.read()[0]
        for _ in range(turns):
            pass
        return counters.read()[0] - before

    one, ten = counted(100_000), counted(1_000_000)
    assert 8.0 * one < ten < 12.0 * one
    assert one > 100_000


def test_ours_says_when_a_tolerance_is_missed():
    assert measure(tower(3), 5, "nlgs", 1e-12, max_iterations=1).missed == 5


def test_in_space_there_are_twice_the_contacts_of_a_plane():
    flat, full = (measure(arcade(1), 3, "nlgs", 1e-3, planar=planar) for planar in (True, False))
    assert full.contacts == 2 * flat.contacts > 0


def test_an_unknown_solver_is_named():
    with pytest.raises(ValueError, match='no solver "magic"'):
        measure(tower(1), 1, "magic")


SIZES = ("wall10x10", "wall20x24")


def test_memory_per_contact_is_that_of_the_scene():
    small, large = (memory_per_contact.Measured(**numbers_of("benchmarks.memory_per_contact", [name, "--steps", "8"])) for name in SIZES)
    assert small.contacts < 0.3 * large.contacts
    assert 0.0 < large.resident <= large.peak
    assert 500.0 < large.per_contact < 20_000.0
    assert large.resident > 1.5 * small.resident
    with pytest.raises(ValueError, match="steps: at least 4"):
        memory_per_contact.measure(tower(2), 3)


def test_memory_is_sampled_on_the_way():
    found = memory.measure(tower(2), 3 * 256)
    assert found.steps == [256, 512, 768]
    assert min(found.resident) > max(found.held) > 0.0
    assert found.held[-1] - found.held[0] < 1.0
    assert found.growth()[0] == pytest.approx(found.resident[2] / found.resident[1] - 1.0)


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
    """Impulses in other axes: those of the solver are read off the Jacobian, whose rows are its axes on the candidate body."""
    problem = machine.last.problem
    side = (problem.bodies[:, 0] < 0).astype(int)
    own = problem.jacobian[np.arange(len(side)), side, :, :3] * np.where(side == 0, 1.0, -1.0)[:, None, None]
    return np.einsum("cij,ckj,ck->ci", frame, own, impulse)


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


def test_the_table_without_a_peer(capsys, monkeypatch, tmp_path):
    kept = tmp_path / "numbers.json"
    command = "peers scenes tower3 --runs 1 --steps 5 --solver nlgs --tolerances 1e-3 --json"
    monkeypatch.setattr(sys, "argv", [*command.split(), str(kept)])
    peers.main()
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("| tower3"))
    assert len(row.split("|")) == len(peers.HEAD.splitlines()[0].split("|"))
    assert json.loads(kept.read_text())["tower3"]["ours, 1e-03"]["error_max"] <= 1e-3


def test_the_table_compares_times():
    peer, own = peers.Rows(), peers.Rows()
    for ms in (9.0, 10.0, 50.0):
        peer.add(
            3 * ms, ms, 2 * ms, {"blocks": 4, "steps": 9, "contacts": 8.0, "iterations": 50.0, "error_median": 1e-3, "error_max": 1e-2}
        )
    own.add(15.0, 2.0, 5.0, peer.last | {"missed": 0})
    assert "| 2.0 | 5.0 | 4.0 |" in peers.table_lines("tower3", {"LMGC90": peer, "ours": own})[1]


def test_a_peer_that_is_not_there_is_reported_in_one_line(capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["peers", "scenes", "tower3", "--runs", "1", "--lmgc90-python", sys.executable])
    with pytest.raises(SystemExit) as end:
        peers.main()
    assert end.value.code == 2
    assert capsys.readouterr().err == "LMGC90: ModuleNotFoundError: No module named 'compas_lmgc90'\n"


def test_sizes_of_the_scaling_table():
    for family, tolerance in (("wall", 0.05), ("arcade", 0.02)):
        for wanted, name in zip((500, 2000), scaling.names(family, [500, 2000], []), strict=True):
            assert len(scene(name).blocks) == pytest.approx(wanted, rel=tolerance)
    assert len(scene(scaling.names("church", [2000], [])[0]).blocks) == pytest.approx(2000, rel=0.2)
    small = {"blocks": 10, "contacts": 20, "mean_ms": 1.0, "iterations": 5.0, "first_iterations": 8}
    large = {"blocks": 100, "contacts": 400, "mean_ms": 20.0, "iterations": 10.0, "first_iterations": 8}
    assert "cost per block x 2.00, per contact x 1.00; iterations x 2.00, of the first step x 1.00" in scaling.growth([small, large])


def test_each_part_of_a_run_has_its_own_seconds():
    before = parts.problem.error_bodies
    costs = parts.measure(tower(3), 6, frame_every=3)
    assert parts.problem.error_bodies is before  # the clocks are off again
    assert set(costs.seconds) >= {"narrow phase", "contact rows", "iterations", "joints", "output"}
    assert (costs.calls["contact rows"], costs.calls["step, rest"], costs.steps) == (6, 6, 6)
    assert (costs.blocks, costs.joints) == (4, 3)
    assert sum(costs.seconds.values()) > 0.0
    lines = parts.table([costs, costs])
    assert all("x 1.00" in line for line in lines if line.startswith("| all"))


def test_the_clock_of_a_part_stops_while_another_one_runs(monkeypatch):
    now = iter([0.0, 1.0, 5.0, 7.0])
    monkeypatch.setattr(parts.time, "process_time", lambda: next(now))
    clocks = parts.Clocks()
    inner = clocks.timed("inner", lambda: None)
    clocks.timed("outer", inner)()
    assert clocks.seconds == {"inner": 4.0, "outer": 3.0}


def test_the_second_solve_of_a_step_with_impacts_has_a_name_of_its_own():
    clocks = parts.Clocks()
    solver = clocks.timed("iterations", lambda problem, start, kind: problem)
    clocks.told_apart(lambda solve: [solve(0, None, kind) for kind in (islands.FORCES, islands.IMPACTS)])(solver)
    solver(0, None, islands.FORCES)
    assert clocks.calls == {"iterations": 2, "iterations of impacts": 1}


def test_a_problem_of_a_scene_goes_to_a_file_and_back(tmp_path):
    problem = problem_files.of_step("tower2", 1)
    problem_files.save(problem, tmp_path / "problem.npz")
    again = problem_files.load(str(tmp_path / "problem.npz"))
    assert abs(again.w - problem.w).max() == 0.0
    answer = SOLVERS["nlgs"](again, Options(tolerance=1e-9), None).impulse
    assert natural_map_error(problem, answer) <= 1e-9
    weight = 2 * 0.5 * 0.5 * 0.25 * 2000.0 * GRAVITY * 1e-3
    assert answer[:, 0].sum() == pytest.approx(1.5 * weight)  # the joint carries one block, the base two


def test_the_peers_files_stand_alone():
    folder = Path(peers.__file__).parent
    for name in ("lmgc90.py", "siconos_solve.py"):
        text = (folder / name).read_text()
        assert "import masonry_cd" not in text
        assert "from benchmarks" not in text


def test_kinds_of_blocks_are_timed_on_the_same_scene(monkeypatch):
    """A rigid tower has six unknowns a block in space and three in its plane; one cut into triangles has those of its mesh."""
    monkeypatch.setitem(element_kinds.SCENES, "wall", "tower2")
    monkeypatch.setattr(element_kinds, "FIRST", 1)
    rigid = element_kinds.cost("wall", "rigid", 3, 1e9, 0.0, 1e-6)
    cut = element_kinds.cost("wall", "tetrahedra", 3, 1e9, 10.0, 1e-6)
    assert rigid[:2] == (0, 3)
    assert cut[:2] == (5, 10)
    assert cut[4] > 0.0
