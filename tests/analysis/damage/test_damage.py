# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint damage, and the largest drifts and hinges of all steps, against motions that are known by construction."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_run import at_rest, box, shifted, turned, write_run
from pictures import scene_of
from places import ROOT

from masonry_cd.analysis.damage import joint_damage, part_damage
from masonry_cd.analysis.damage.definitions import STATES, Thresholds, classify
from masonry_cd.analysis.damage.joint_damage import displacement_max, displacements
from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from reports import damage as damage_files
from reports.damage import write_joints_csv
from reports.drawing.figure import in_metres, save_polygons

BASE = box("base", (-3, -1, -0.5), (3, 1, 0), "base", fixed=True)
PIER = [BASE, box("lower", (-0.5, -0.5, 0), (0.5, 0.5, 1)), box("upper", (-0.5, -0.5, 1), (0.5, 0.5, 2))]


def table_of(path: Path, thresholds: Thresholds | None = None) -> dict[tuple[str, str], dict[str, object]]:
    """The rows of the damage table by the (sorted) names of the two blocks."""
    with Results.open(path) as results:
        table = joint_damage.joint_damage(results, thresholds)
    rows = {}
    for j in range(len(table.joint)):
        rows[tuple(sorted((table.block_a[j], table.block_b[j])))] = {
            name: getattr(table, name)[j] for name in table.__dataclass_fields__ if name != "of_laws"
        }
    return rows


def test_structure_at_rest_is_intact(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    rows = table_of(write_run(tmp_path / "result.h5", PIER, [rest, rest]))
    assert len(rows) == 2
    assert all(row["state"] == "intact" and np.isnan(row["first_opening_time"]) for row in rows.values())


def test_known_slip_comes_back(tmp_path: Path) -> None:
    """The upper block slips by 30 mm and back to 12 mm while the base rides on the ground: the base motion must not count."""
    rest = at_rest(PIER)
    far = shifted(shifted(rest, 2, (0.030, 0, 0)), slice(None), (0.5, 0.2, 0.0))
    end = shifted(shifted(rest, 2, (0.012, 0, 0)), slice(None), (0.9, 0.1, 0.0))
    path = write_run(tmp_path / "result.h5", PIER, [rest, far, end])
    row = table_of(path)["lower", "upper"]
    assert row["max_sliding"] == pytest.approx(0.030, abs=1e-9)
    assert row["residual_sliding"] == pytest.approx(0.012, abs=1e-9)
    assert row["max_opening"] == pytest.approx(0.0, abs=1e-9)
    assert row["contact_area_loss"] == pytest.approx(0.030, abs=1e-9)  # of 1 m x 1 m
    assert row["state"] == "slid"
    with Results.open(path) as results:
        assert joint_damage.displacement_max(results) == pytest.approx(0.030, abs=1e-9)
        assert joint_damage.collapsed_blocks(results) == ()


def test_known_hinge_comes_back(tmp_path: Path) -> None:
    """The upper block turns about its right lower edge by 2 degrees at 0.2 s and closes again to 0.5 degrees."""
    rest, edge = at_rest(PIER), (0.5, 0.0, 1.0)
    states = [rest, turned(rest, 2, edge, 0.001), turned(rest, 2, edge, 2.0), turned(rest, 2, edge, 0.5)]
    row = table_of(write_run(tmp_path / "result.h5", PIER, states))["lower", "upper"]
    assert row["max_rotation"] == pytest.approx(np.radians(2.0), abs=1e-9)
    assert row["max_opening"] == pytest.approx(np.sin(np.radians(2.0)), abs=1e-9)
    assert row["residual_opening"] == pytest.approx(np.sin(np.radians(0.5)), abs=1e-9)
    assert row["first_opening_time"] == pytest.approx(0.2)
    assert row["state"] == "opened"


def test_wide_hinge_still_touches_and_is_not_separated(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    path = write_run(tmp_path / "result.h5", PIER, [rest, turned(rest, 2, (0.5, 0.0, 1.0), 25.0)])
    assert table_of(path)["lower", "upper"]["state"] == "opened"
    with Results.open(path) as results:
        assert joint_damage.collapsed_blocks(results) == ()


@pytest.mark.parametrize("by", [(0.0, 0.0, 0.2), (1.1, 0.0, 0.0)], ids=["lifted off", "slid off"])
def test_separated(tmp_path: Path, by: tuple[float, float, float]) -> None:
    rest = at_rest(PIER)
    path = write_run(tmp_path / "result.h5", PIER, [rest, shifted(rest, 2, by)])
    assert table_of(path)["lower", "upper"]["state"] == "separated"
    with Results.open(path) as results:
        assert joint_damage.collapsed_blocks(results) == ("upper",)
        counts = joint_damage.joint_counts(joint_damage.joint_damage(results)).as_dict()
        assert (counts["joints_separated"], sum(counts.values())) == (1, 1)


def test_a_hop_that_lands_again_has_opened_but_is_not_separated(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    row = table_of(write_run(tmp_path / "result.h5", PIER, [rest, shifted(rest, 2, (0, 0, 0.3)), rest]))["lower", "upper"]
    assert (row["state"], row["contact_area_loss"]) == ("opened", pytest.approx(1.0))
    assert row["residual_opening"] == pytest.approx(0.0, abs=1e-12)


def test_the_measure_further_beyond_its_threshold_names_the_joint() -> None:
    opening = np.array([0.0, 2e-4, 2e-4, 9e-5, 1.0])
    sliding = np.array([0.0, 1e-4, 5e-4, 9e-5, 0.0])
    separated = np.array([False, False, False, False, True])
    codes = classify(opening, sliding, separated, Thresholds())
    assert [STATES[c] for c in codes] == ["intact", "opened", "slid", "intact", "separated"]


def test_thresholds_are_the_users(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    path = write_run(tmp_path / "result.h5", PIER, [rest, shifted(rest, 2, (0.001, 0, 0))])
    assert table_of(path)["lower", "upper"]["state"] == "slid"
    assert table_of(path, Thresholds(slid=0.002))["lower", "upper"]["state"] == "intact"
    with pytest.raises(InputError, match=r"thresholds\.slid: must be positive"):
        Thresholds(slid=0.0)


def test_fallen_blocks_are_judged_relative_to_the_base(tmp_path: Path) -> None:
    """The ground settles by 3 m under all of it: nothing fell. One block overturns, another drops by two thirds of its height."""
    blocks = [*PIER, box("drum", (2, -0.2, 0), (2.4, 0.2, 1))]
    rest = at_rest(blocks)
    settled = shifted(rest, slice(None), (0, 0, -3.0))
    with Results.open(write_run(tmp_path / "settled.h5", blocks, [rest, settled])) as results:
        assert joint_damage.collapsed_blocks(results) == ()
        assert joint_damage.displacement_max(results) == pytest.approx(0.0, abs=1e-12)
    thrown = turned(shifted(settled, 2, (1.0, 0, -0.67)), 3, (2.4, 0, -3.0), 90.0)
    with Results.open(write_run(tmp_path / "thrown.h5", blocks, [rest, thrown])) as results:
        assert joint_damage.collapsed_blocks(results) == ("upper", "drum")
        assert joint_damage.collapsed_blocks(results, frame=0) == ()


def test_spheres_that_roll_and_settle_have_not_fallen_and_one_that_runs_out_has(tmp_path: Path) -> None:
    balls = [Block.sphere(name, np.array([0.0, y, 3.0]), 0.1, 2000.0) for name, y in (("stays", 0.0), ("runs", 0.3))]
    blocks = [*PIER, *balls]
    rest = at_rest(blocks)
    end = turned(shifted(shifted(rest, 3, (0.0, 0.0, -0.4)), 4, (0.3, 0.3, -0.9)), 3, (0.0, 0.0, 2.6), 170.0)
    with Results.open(write_run(tmp_path / "result.h5", blocks, [rest, end])) as results:
        assert joint_damage.collapsed_blocks(results) == ("runs",)


def test_csv_holds_the_table(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    path = write_run(tmp_path / "result.h5", PIER, [rest, turned(rest, 2, (0.5, 0.0, 1.0), 2.0)])
    with Results.open(path) as results:
        table = joint_damage.joint_damage(results)
    write_joints_csv(table, tmp_path / "joints.csv")
    with (tmp_path / "joints.csv").open() as file:
        rows = list(csv.DictReader(file))
    head = "joint block_a block_b area max_opening residual_opening max_sliding residual_sliding max_rotation contact_area_loss"
    assert list(rows[0]) == f"{head} first_opening_time state".split()
    assert [row["state"] for row in rows] == list(table.state)
    np.testing.assert_allclose([float(row["max_opening"]) for row in rows], table.max_opening, atol=1e-9, rtol=1e-8)
    assert [row["first_opening_time"] for row in rows] == ["" if np.isnan(t) else f"{t:.9g}" for t in table.first_opening_time]


def test_killed_run_is_judged_by_its_frames(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    states = [rest, turned(rest, 2, (0.5, 0.0, 1.0), 2.0), shifted(rest, 2, (0.03, 0, 0))]
    whole = table_of(write_run(tmp_path / "whole.h5", PIER, states))
    killed = table_of(write_run(tmp_path / "killed.h5", PIER, states, peaks=False))
    for pair, row in whole.items():
        for name in ("max_opening", "max_sliding", "max_rotation", "contact_area_loss", "first_opening_time", "state"):
            assert killed[pair][name] == row[name] or np.isnan(row[name]), name


def test_seams_of_flat_faces_are_no_edges() -> None:
    """A cube whose faces are triangles has the twelve edges of a cube."""
    cube = box("cube", (0, 0, 0), (1, 1, 1))
    split = tuple(t for a, b, c, d in cube.faces for t in ((a, b, c), (a, c, d)))
    solids = Solids.from_blocks([type(cube)("cube", cube.vertices, split, 2000.0), cube])
    assert len(solids.edges()) == 24
    np.testing.assert_allclose(solids.sizes, 1.0)


def test_amplified_shape_keeps_the_base(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    moved = shifted(shifted(rest, 2, (0.001, 0, 0)), slice(None), (5.0, 0, 0))
    with Results.open(write_run(tmp_path / "result.h5", PIER, [rest, moved])) as results:
        solids = Solids.from_blocks(results.blocks)
        pose = Pose.of(results, solids)
        drawn = pose.moved(solids, solids.vertices, solids.vertex_block, factor=100.0)
        with pytest.raises(InputError, match="frames 0 to 1"):
            Pose.of(results, solids, 2)
    shift = drawn - solids.vertices
    np.testing.assert_allclose(shift[solids.vertex_block == 2], [[0.1, 0, 0]] * 8, atol=1e-9)
    np.testing.assert_allclose(shift[solids.vertex_block < 2], 0.0, atol=1e-9)


def test_displacements_are_relative_to_the_first_support_where_supports_move_apart(tmp_path: Path) -> None:
    """The second of two feet sinks by 60 mm with its block, on a ground that moves: only that block has moved."""
    blocks = [box("f1", (0, 0, -1), (1, 1, 0), fixed=True), box("f2", (3, 0, -1), (4, 1, 0), fixed=True)]
    blocks += [box("b1", (0, 0, 0), (1, 1, 1)), box("b2", (3, 0, 0), (4, 1, 1))]
    rest = at_rest(blocks)
    sunk = shifted(shifted(rest, slice(None), (0.2, 0.0, 0.0)), slice(1, None, 2), (0.0, 0.0, -0.06))
    with Results.open(write_run(tmp_path / "run.h5", blocks, [rest, sunk])) as results:
        assert joint_damage.displacements(results) == pytest.approx([0.0, 0.06])
        assert joint_damage.collapsed_blocks(results) == ()


PIER_PEAKS = [BASE, *(box(f"p{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1), "pier") for k in range(3))]
BY_FRAMES = Thresholds(drop=np.nextafter(Thresholds().drop, 1.0))  # other thresholds of fall than a run's: its frames are looked at


def leaning(degrees: float):
    """The two upper blocks turned about an edge of the joint at z = 1."""
    state = at_rest(PIER_PEAKS)
    for index in (2, 3):
        state = turned(state, index, (0.5, 0, 1.0), degrees)
    return state


@pytest.mark.parametrize("every", [2, 0])
def test_a_hinge_between_two_frames_is_found_where_every_step_is_noted(tmp_path: Path, every: int) -> None:
    """It opens by 10 mm at 0.1 s, and the frames are those of 0 and 0.2 s. Older files have a frame at 0.1 s here, and no steps."""
    states = [at_rest(PIER_PEAKS), leaning(0.6), at_rest(PIER_PEAKS)]
    with Results.open(write_run(tmp_path / "result.h5", PIER_PEAKS, states, every=every)) as results:
        assert results.frames == (2 if every else 3)
        damage = part_damage.part_damage(results)
        largest = displacement_max(results)
    assert damage.of_steps == bool(every)
    (hinge,) = damage.hinges
    assert (hinge["joint"], hinge["touches_towards"], hinge["at_end"]) == (1, "+x", False)
    assert [hinge[axis] for axis in "xyz"] == pytest.approx([0.5, 0.0, 1.0], abs=1e-12)
    assert (hinge["opening"], hinge["time"]) == (pytest.approx(np.sin(np.radians(0.6)), abs=1e-9), pytest.approx(0.1))
    row = damage.parts[0]
    angle = np.radians(0.6)
    moved = 0.5 * (1 - np.cos(angle)) + 1.5 * np.sin(angle)  # of the centre at z = 2.5, about the edge at x = 0.5, z = 1
    assert (row["hinges_ever"], row["residual_drift"]) == (1, pytest.approx(0.0, abs=1e-12))
    assert row["max_drift"] == pytest.approx(moved / 3.0, rel=1e-9)
    top = damage.levels[-1]
    assert (top["largest_displacement"], top["residual_x"]) == (pytest.approx(moved, rel=1e-9), pytest.approx(0.0, abs=1e-12))
    assert largest == pytest.approx(np.hypot(moved, 1.5 * (np.cos(angle) - 1) + 0.5 * np.sin(angle)), rel=1e-9)


def test_the_heading_of_a_crack_map_tells_what_is_left_from_the_largest_of_all_steps(tmp_path: Path) -> None:
    """The summary, the page and the map have one largest displacement; what the frame shows besides goes by another name."""
    states = [at_rest(PIER_PEAKS), leaning(0.6), leaning(0.1)]
    with Results.open(write_run(tmp_path / "result.h5", PIER_PEAKS, states, every=2)) as results:
        largest, left = displacement_max(results), displacements(results)[-1]
        (drawn, _) = save_polygons(scene_of(results), tmp_path, "crack_map")
    assert (in_metres(largest), in_metres(left)) == ("16.6 mm", "2.76 mm")  # sqrt(1.5^2 + 0.5^2) m times the angle
    text = drawn.read_text()
    assert "relative to the base, at this time at most 2.76 mm" in text
    assert "over all time steps: largest displacement 16.6 mm, " in text


def test_hinges_count_from_the_opening_that_the_report_asks_for(tmp_path: Path) -> None:
    states = [at_rest(PIER_PEAKS), leaning(0.06), at_rest(PIER_PEAKS)]  # 1 mm
    with Results.open(write_run(tmp_path / "result.h5", PIER_PEAKS, states, every=2)) as results:
        found = [
            len(part_damage.part_damage(results, part_damage.DamageSettings(thresholds=Thresholds(opened=opened))).hinges)
            for opened in (1e-4, 1e-3, 1.1e-3)
        ]
    assert found == [1, 1, 0]


def test_files_say_which_peaks_they_have(tmp_path: Path) -> None:
    for every, said in ((1, damage_files.OF_STEPS), (0, damage_files.OF_FRAMES)):
        with Results.open(write_run(tmp_path / "result.h5", PIER_PEAKS, [at_rest(PIER_PEAKS)] * 2, every=every)) as results:
            damage_files.write_part_damage(part_damage.part_damage(results), tmp_path)
        assert json.loads((tmp_path / "damage.json").read_text())["note"].endswith(said)


def test_damaged_peaks_are_left_out_with_a_word(tmp_path: Path) -> None:
    states = [at_rest(PIER_PEAKS), leaning(0.6), leaning(0.2)]
    path = write_run(tmp_path / "result.h5", PIER_PEAKS, states, every=2)
    with h5py.File(path, "r+") as file:
        file["peaks/drift"][0] = 0.5
    with Results.open(path) as results:
        assert not results.has_peaks_of_steps
        assert results.words == (f"{path}: the largest drifts and hinges are damaged; the largest values of the frames are used",)
        damage = part_damage.part_damage(results)
    assert damage.parts[0]["max_drift"] < 0.01
    assert damage.hinges[0]["opening"] == pytest.approx(np.sin(np.radians(0.2)), abs=1e-9)


def test_fallen_blocks_leave_the_drift_of_their_part(tmp_path: Path) -> None:
    """The upper block slides off between two frames and drops by its height: what stands has not drifted."""
    rest = at_rest(PIER_PEAKS)
    with Results.open(write_run(tmp_path / "result.h5", PIER_PEAKS, [rest, shifted(rest, 3, (2.0, 0, -1.0)), rest], every=2)) as results:
        assert results.step_peaks["drift"] == pytest.approx(0.0, abs=1e-12)
        assert results.step_peaks["displacement"] == pytest.approx([0, 0, 0, np.sqrt(5.0)])


@pytest.mark.parametrize(
    ("scene", "changes", "lost"),
    [
        ("arch", ["run.dt=2e-3", "run.duration=0.8", "run.frames_per_second=500", "run.until_still=false", "loads[0].amplitude=4.0"], True),
        ("two_piers", ["run.duration=0.3", "run.frames_per_second=500", "run.until_still=false"], False),
    ],
)
def test_steps_give_what_frames_of_every_step_give(tmp_path: Path, scene: str, changes: list[str], lost: bool) -> None:
    """The peaks that the run noted are those of its frames, one per step, reckoned by the report; apart from rounding."""
    case = prepare(read_scene(ROOT / "examples" / f"{scene}.toml", changes))
    run_case(case, tmp_path)
    with Results.open(tmp_path / "result.h5") as results:
        every = np.arange(results.frames)
        steps, frames = (
            part_damage.part_damage(results, part_damage.DamageSettings(thresholds=t), every) for t in (Thresholds(), BY_FRAMES)
        )
    assert (steps.of_steps, frames.of_steps) == (True, False)
    assert len({row["time"] for row in steps.history}) == case.steps + 1
    assert steps.parts[-1]["max_drift"] > 1e-4 and (steps.parts[-1]["lost_blocks"] > 0) == lost
    for name in ("parts", "hinges", "levels"):
        for mine, theirs in zip(getattr(steps, name), getattr(frames, name), strict=True):
            for key, value in mine.items():
                if isinstance(value, float):
                    assert value == pytest.approx(theirs[key], rel=1e-9, abs=1e-12, nan_ok=True), (name, key)
                else:
                    assert value == theirs[key], (name, key)
