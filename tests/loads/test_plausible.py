"""Motions and sizes that are likely not meant are warned of, with the cause; sound ones are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import loads
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene

STEP = 0.01
TIME = STEP * np.arange(1001)
SWELL = np.sin(np.pi * TIME / 10.0) ** 2
WAVE = 2.0 * SWELL * np.sin(2 * np.pi * 1.3 * (TIME - 5.0)) * np.cos(np.pi * (TIME - 5.0) / 10.0)


def warnings(folder: Path, values: np.ndarray, unit: str = "m/s2", **keys: object) -> list[str]:
    rows = "".join(f"{t:.2f} {a:.12g}\n" for t, a in zip(TIME, values, strict=True))
    (folder / "quake.txt").write_text(f"# t [s]  a [{unit}]\n{rows}")
    table = {"kind": "record", "path": "quake.txt", "direction": "x", **keys}
    return list(loads.build([table], 1e-3, 12_000, (0.0, 0.0, -9.81), folder).warnings)


def test_a_record_that_swells_and_fades_is_let_pass(tmp_path: Path) -> None:
    assert warnings(tmp_path, WAVE) == []


def test_a_window_that_cuts_the_shaking_is_named_at_both_ends(tmp_path: Path) -> None:
    lines = warnings(tmp_path, WAVE, window=[2.5, 7.1], correction="none")
    assert [line.split(" while")[0] for line in lines] == ["loads[0] the record begins", "loads[0] the record ends"]
    assert "is the window too narrow, or the file cut?" in lines[0]


def test_a_correction_that_makes_the_motion_anew_says_what_it_changed(tmp_path: Path) -> None:
    (line,) = warnings(tmp_path, WAVE + 0.02)
    assert line.startswith("loads[0] the quadratic correction changes ")
    assert "PGD from 1" in line
    assert "the record drifts (it would end at 0.2 m/s)" in line
    assert warnings(tmp_path, WAVE + 0.02, correction="none") == []


SCENE = """
[structure]
kind = "column"
height = {height}
diameter = {diameter}
plinth = 0
capital = 0
base_depth = {diameter}
[material]
density = 2000.0
friction = 0.6
[run]
dt = 1e-4
duration = 1e-3
"""


@pytest.mark.parametrize(("height", "said"), [(0.25, "smaller than 0.3 m"), (0.35, ""), (290.0, ""), (310.0, "larger than 300 m")])
def test_a_structure_of_odd_size_asks_for_its_unit(tmp_path: Path, height: float, said: str) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.format(height=height, diameter=height / 6))
    found = [line for line in prepare(read_scene(path)).warnings if line.startswith("structure: ")]
    assert [said in line for line in found] == ([True] if said else [])
