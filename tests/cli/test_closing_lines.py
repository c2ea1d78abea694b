# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says at its end where nothing moved, and where everything falls."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import masonry_cd, refusal

TOWER = """
[structure]
kind = "column"
drums = 3
[material]
density = 2200.0
friction = 0.6
[run]
dt = 1e-3
duration = 0.1
"""


def energy_line(folder: Path, *words: str) -> tuple[str, float]:
    """The closing line on the energy, and the balance in summary.json, relative."""
    (folder / "tower.toml").write_text(TOWER)
    result = masonry_cd("run", folder / "tower.toml", "-o", folder / "out", "--force", *words)
    assert result.exit_code == 0, result.output
    line = next(line for line in result.stdout.splitlines() if line.startswith("energy: "))
    return line, json.loads((folder / "out" / "summary.json").read_text())["energy"]["balance_error"]


def test_the_balance_of_a_tower_at_rest_is_given_in_joules(tmp_path: Path) -> None:
    line, relative = energy_line(tmp_path)
    number, rest = line.removeprefix("energy: balance closed to ").split(" ", 1)
    assert float(number) < 1e-6
    assert rest == "J; no work was done beyond what the tolerance of the steps leaves"
    assert relative < 1e-2


def test_the_balance_of_a_fall_is_a_share_of_its_work(tmp_path: Path) -> None:
    line, relative = energy_line(tmp_path, "--set", "run.gravity=[3.0,0.0,-1.0]")
    assert line.endswith(" of the largest work done")
    assert relative < 1e-3


@pytest.mark.parametrize(("gravity", "warned"), [("-9.81", True), ("0.0", False)])
def test_a_structure_without_supports_falls_with_a_warning(block_on_plate, tmp_path: Path, gravity: str, warned: bool) -> None:
    scene = block_on_plate(duration=f"duration = 0.01\ngravity = [0.0, 0.0, {gravity}]")
    blocks = tmp_path / "blocks.json"
    blocks.write_text(blocks.read_text().replace("true", "false"))
    text = scene.read_text()
    scene.write_text(text[: text.index("[[loads]]")] + text[text.index("[run]") :])
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    line = "no block of the structure is fixed: nothing carries it, and it falls as a whole"
    assert result.exit_code == 0, result.output
    assert (f"masonry-cd: warning: {line}; of a file, structure.fixed = " in result.stderr) == warned
    assert any(said.startswith(line) for said in json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"]) == warned


def test_a_base_that_is_shaken_needs_a_support(block_on_plate, tmp_path: Path) -> None:
    scene, blocks = block_on_plate(), tmp_path / "blocks.json"
    blocks.write_text(blocks.read_text().replace("true", "false"))
    found = refusal(masonry_cd("run", scene, "-o", tmp_path / "out"))
    assert found.place == str(scene)
    assert not (tmp_path / "out").exists()
