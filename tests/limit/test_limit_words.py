# SPDX-License-Identifier: GPL-3.0-or-later
"""No finite load factor is a result, with what would make it finite; a scene of limit analysis needs no [run]."""

from __future__ import annotations

import json
from pathlib import Path

import limit_scenes
import pytest
from command_line import masonry_cd
from limit_scenes import said
from models import box, ground

from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.files import write
from masonry_cd.mechanics.model.blocks import Block


def scene(folder: Path, tables: str, joints: str = "", blocks: list[Block] | None = None) -> Path:
    """A pillar, or other blocks, without a table [run]."""
    return limit_scenes.scene(folder, blocks or limit_scenes.pillar(), tables, 0.6, joints, run="")


def test_a_load_that_no_mechanism_yields_to_is_a_result(tmp_path):
    path = scene(tmp_path, "[limit]\npush = '-z'\n")
    done = masonry_cd("limit", path, "-o", tmp_path / "out", "--no-picture")
    assert done.exit_code == 0, done.output
    assert "push along -z: no finite load factor" in done.output and "(material.joints.compressive_strength)" in done.output
    made = json.loads((tmp_path / "out" / "limit.json").read_text())
    assert made["no_finite_factor"] and made["associated"] is None and made["certificate"] is None and made["stands"]
    assert "not finite" in (tmp_path / "out" / "limit.html").read_text()


def test_joints_that_crush_make_it_finite(tmp_path):
    weight = 2000.0 * 9.81 * 1.5
    found = limit_case(scene(tmp_path, "[limit]\npush = '-z'\n", f", joints = {{compressive_strength = {3.0 * weight}}}"))
    assert not found.whole.analysis.unlimited and found.whole.analysis.associated.factor == pytest.approx(2.0, rel=1e-6)


def test_a_curve_of_it_is_none(tmp_path):
    case = limit_case(scene(tmp_path, "[limit]\npush = '-z'\n[limit.curve]\n"))
    assert case.whole.curve is None and any("no finite load factor" in line for line in said(case))


def test_a_scene_with_limit_needs_no_run(tmp_path):
    path = scene(tmp_path, "[limit]\npush = 'x'\n")
    assert read_scene(path).static
    assert limit_case(path).whole.analysis.associated.factor == pytest.approx(0.5 / 1.5, rel=1e-9)


@pytest.mark.parametrize(("tables", "message"), [("[limit]\npush = 'x'\n", "a run needs dt and duration"), ("", "run: missing")])
def test_what_is_run_needs_one(tables, message, tmp_path):
    done = masonry_cd("run", scene(tmp_path, tables), "-o", tmp_path / "out")
    assert done.exit_code == 2 and "run: missing" in done.output and message in done.output and done.output.count("\n") == 1
    if not tables:
        with pytest.raises(InputError, match="run: missing"):
            read_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("courses", [1, 3])
def test_a_wall_wedged_between_rigid_cheeks_leans_out_alone(courses, tmp_path):
    """With dilation it would have to part its cheeks, which are fixed, and bears any multiple; without, it overturns about its edge."""
    cheeks = [box("left", (0.0, -1.6, 0.0), (1.0, -1.0, 3.0), fixed=True), box("right", (0.0, 1.0, 0.0), (1.0, 1.6, 3.0), fixed=True)]
    high = 3.0 / courses
    slab = [box(f"slab{k}", (0.0, -1.0, k * high), (0.5, 1.0, (k + 1) * high)) for k in range(courses)]
    check = '[limit.check]\nspectrum = "EC8"\nag = 4.0\ndisplacements = false\n'
    path = scene(tmp_path, f"[limit]\npush = '-x'\n{check}", blocks=[ground(5.0), *slab, *cheeks])
    case = limit_case(path)
    assert case.whole.analysis.unlimited and not case.whole.analysis.is_endless
    assert case.whole.analysis.least is not None and case.whole.analysis.least.optimum.factor == pytest.approx(0.5 / 3.0, rel=1e-3)
    assert case.verdict is not None and case.verdict.state == "NOT satisfied" and case.verdict.search is not None
    assert case.verdict.search.associated is None
    words = said(case)
    assert any("no finite associated load factor" in line for line in words) and any("is the least found" in line for line in words)
    write(case, tmp_path / "out", pictures=False)
    made = json.loads((tmp_path / "out" / "limit.json").read_text())
    assert made["no_finite_factor"] and made["associated"] is None and made["least"]["factor"] == pytest.approx(0.5 / 3.0, rel=1e-3)
    assert made["mechanism"]["of"] == "least" and len(made["mechanism"]["moving_blocks"]) == courses
