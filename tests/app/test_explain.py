# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run left out, and why: the lines agree with what the run did."""

from __future__ import annotations

import json
import re

import pytest
from command_line import masonry_cd
from made_run import box

from masonry_cd.app.explain import HEAVY, packages_not_loaded
from structures.files import blockfile

SCENE = """\
structure = { kind = "file", path = "blocks.json" }
material = { density = 2000.0, friction = 0.5 }
run = { dt = 1e-3, duration = 0.06 }
"""


@pytest.fixture
def explained(tmp_path):
    """Runs two cubes, the upper of which falls by 5 mm, and a third far away; returns what was said and kept."""
    cubes = [box("low", (0, 0, 0), (1, 0.5, 1)), box("high", (0.2, 0, 1.005), (1, 0.5, 2)), box("far", (10, 0, 0), (11, 0.5, 1))]
    blockfile.write(tmp_path / "blocks.json", [box("plate", (-2, -0.25, -1), (12, 0.75, 0), fixed=True), *cubes])
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE)

    def run(*changes: str) -> tuple[str, dict]:
        words = [word for change in changes for word in ("--set", change)]
        result = masonry_cd("run", scene, "-o", tmp_path / "out", "--force", "--explain", *words)
        assert result.exit_code == 0, result.output
        return result.stdout, json.loads((tmp_path / "out" / "summary.json").read_text())

    return run


def number(lines: list[str], pattern: str) -> tuple[int, ...]:
    """The numbers of the one line that fits."""
    (found,) = [match for line in lines if (match := re.search(pattern, line))]
    return tuple(int(group) for group in found.groups())


def test_every_line_is_said_and_kept(explained):
    said, summary = explained()
    assert "left out, and why:" in said
    assert all(f"- {line}\n" in said for line in summary["explanation"])


def test_the_numbers_are_those_of_the_run(explained):
    lines = explained()[1]["explanation"]
    assert "mirror image about y = 0.25 m" in lines[0]
    spared, possible = number(lines, r"pairs of blocks: (\d+) of (\d+) not listed")
    assert possible == 6  # four blocks
    assert spared == 3  # the far cube meets neither of the others, and the upper one does not meet the plate
    apart, steps = number(lines, r"impacts apart from forces: not solved in (\d+) of (\d+) steps")
    assert steps == 60
    assert 57 <= apart <= 59  # the cube lands once, in a step or two
    assert number(lines, r"broad phase: left out in (\d+) of (\d+) steps") == (59, 60)
    kept, far = number(lines, r"contact points kept (\d+) times, .* not looked at (\d+) times")
    assert 100 < kept < kept + far <= 60 * 3  # three listed pairs in every step, of which two stand still
    assert any("joints are rigid" in line for line in lines)
    assert any("crack_map" in line and "[report] does not ask" in line for line in lines)


def test_what_is_asked_for_is_not_left_out(explained):
    lines = explained("run.planar=false", "run.solver=nlgs", "material.joints.normal_stiffness=1e9", "report.damage=true")[1]["explanation"]
    assert lines[0] == "third dimension: kept, since run.planar is false"
    assert any(line.startswith("solvers: all but nlgs") for line in lines)
    assert not any("joints are rigid" in line for line in lines)
    assert not any("damage by part" in line for line in lines)


def test_packages_are_looked_up_not_guessed():
    assert packages_not_loaded(dict.fromkeys(HEAVY.values())) == "packages not loaded: none"
    assert packages_not_loaded({"gmsh": None}).startswith("packages not loaded: vtk, pyvista")


def test_islands_and_what_slept_are_reported(explained):
    summary = explained()[1]
    islands = summary["islands"]
    assert islands["max"] == 2  # the cubes that come to lie on each other, and the far one
    assert 0.3 < islands["sleeping_mean"] < 1.0
    mean, most, asleep = number(summary["explanation"], r"islands, .*: ([\d.]+) on average, (\d+) at most; .* (\d+)% of the blocks slept")
    assert (mean, most, asleep) == (round(islands["mean"]), 2, round(100 * islands["sleeping_mean"]))
    whole = explained("run.islands=false")[1]
    assert "islands: all blocks solved as one, since run.islands is false" in whole["explanation"]
    assert whole["islands"]["max"] == 1
