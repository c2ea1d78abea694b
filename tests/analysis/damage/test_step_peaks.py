# SPDX-License-Identifier: GPL-3.0-or-later
"""Largest drifts, displacements and hinges of all steps: what happens between two frames is in the tables, to the bit."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_run import at_rest, box, shifted, turned, write_run
from pictures import scene_of
from places import ROOT

from masonry_cd.analysis.damage import part_damage
from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import displacement_max, displacements
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.results import Results
from reports import damage as damage_files
from reports.drawing.figure import in_metres, save_polygons

BASE = box("base", (-3, -1, -0.5), (3, 1, 0), "base", fixed=True)
PIER = [BASE, *(box(f"p{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1), "pier") for k in range(3))]
BY_FRAMES = Thresholds(drop=np.nextafter(Thresholds().drop, 1.0))  # other thresholds of fall than a run's: its frames are looked at


def leaning(degrees: float):
    """The two upper blocks turned about an edge of the joint at z = 1."""
    state = at_rest(PIER)
    for index in (2, 3):
        state = turned(state, index, (0.5, 0, 1.0), degrees)
    return state


@pytest.mark.parametrize("every", [2, 0])
def test_a_hinge_between_two_frames_is_found_where_every_step_is_noted(tmp_path: Path, every: int) -> None:
    """It opens by 10 mm at 0.1 s, and the frames are those of 0 and 0.2 s. Older files have a frame at 0.1 s here, and no steps."""
    states = [at_rest(PIER), leaning(0.6), at_rest(PIER)]
    with Results.open(write_run(tmp_path / "result.h5", PIER, states, every=every)) as results:
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
    states = [at_rest(PIER), leaning(0.6), leaning(0.1)]
    with Results.open(write_run(tmp_path / "result.h5", PIER, states, every=2)) as results:
        largest, left = displacement_max(results), displacements(results)[-1]
        (drawn, _) = save_polygons(scene_of(results), tmp_path, "crack_map")
    assert (in_metres(largest), in_metres(left)) == ("16.6 mm", "2.76 mm")  # sqrt(1.5^2 + 0.5^2) m times the angle
    text = drawn.read_text()
    assert "relative to the base, at this time at most 2.76 mm" in text
    assert "over all time steps: largest displacement 16.6 mm, " in text


def test_hinges_count_from_the_opening_that_the_report_asks_for(tmp_path: Path) -> None:
    states = [at_rest(PIER), leaning(0.06), at_rest(PIER)]  # 1 mm
    with Results.open(write_run(tmp_path / "result.h5", PIER, states, every=2)) as results:
        found = [
            len(part_damage.part_damage(results, part_damage.Settings(thresholds=Thresholds(opened=opened))).hinges)
            for opened in (1e-4, 1e-3, 1.1e-3)
        ]
    assert found == [1, 1, 0]


def test_files_say_which_peaks_they_have(tmp_path: Path) -> None:
    for every, said in ((1, damage_files.OF_STEPS), (0, damage_files.OF_FRAMES)):
        with Results.open(write_run(tmp_path / "result.h5", PIER, [at_rest(PIER)] * 2, every=every)) as results:
            damage_files.write_part_damage(part_damage.part_damage(results), tmp_path)
        assert json.loads((tmp_path / "damage.json").read_text())["note"].endswith(said)


def test_damaged_peaks_are_left_out_with_a_word(tmp_path: Path) -> None:
    states = [at_rest(PIER), leaning(0.6), leaning(0.2)]
    path = write_run(tmp_path / "result.h5", PIER, states, every=2)
    with h5py.File(path, "r+") as file:
        file["peaks/drift"][0] = 0.5
    with Results.open(path) as results:
        assert not results.peaks_of_steps
        assert results.words == (f"{path}: the largest drifts and hinges are damaged; those of the frames are taken",)
        damage = part_damage.part_damage(results)
    assert damage.parts[0]["max_drift"] < 0.01
    assert damage.hinges[0]["opening"] == pytest.approx(np.sin(np.radians(0.2)), abs=1e-9)


def test_fallen_blocks_leave_the_drift_of_their_part(tmp_path: Path) -> None:
    """The upper block slides off between two frames and drops by its height: what stands has not drifted."""
    rest = at_rest(PIER)
    with Results.open(write_run(tmp_path / "result.h5", PIER, [rest, shifted(rest, 3, (2.0, 0, -1.0)), rest], every=2)) as results:
        assert results.step_peaks["drift"] == pytest.approx(0.0, abs=1e-12)
        assert results.step_peaks["displacement"] == pytest.approx([0, 0, 0, np.sqrt(5.0)])


@pytest.mark.parametrize(
    ("scene", "changes", "lost"),
    [
        ("arch", ["run.duration=1.0", "run.frames_per_second=1000", "run.until_still=false", "loads[0].amplitude=3.0"], True),
        ("two_piers", ["run.duration=0.5", "run.frames_per_second=500", "run.until_still=false"], False),
    ],
)
def test_steps_give_what_frames_of_every_step_give(tmp_path: Path, scene: str, changes: list[str], lost: bool) -> None:
    """The peaks that the run noted are those of its frames, one per step, reckoned by the report; apart from rounding."""
    case = prepare(read_scene(ROOT / "examples" / f"{scene}.toml", changes))
    run_case(case, tmp_path)
    with Results.open(tmp_path / "result.h5") as results:
        every = np.arange(results.frames)
        steps, frames = (part_damage.part_damage(results, part_damage.Settings(thresholds=t), every) for t in (Thresholds(), BY_FRAMES))
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
