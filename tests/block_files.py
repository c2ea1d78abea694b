# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks as block files have them, and a scene of two of them."""

from __future__ import annotations

import json
from pathlib import Path

PLATE_SCENE = """\
{title}
[structure]
kind = "file"
{path}
[material]
{density}
{friction}
[[loads]]
kind = "sinusoidal"
direction = "x"
{amplitude}
frequency = 2.0
cycles = 1
[run]
{dt}
{duration}
{solver}
{report}
"""
LINES = {
    "title": 'title = "Block on a plate"',
    "path": 'path = "blocks.json"',
    "density": "density = 2000.0",
    "friction": "friction = 0.0",
    "amplitude": "amplitude = 0.2",
    "dt": "dt = 1e-3",
    "duration": "duration = 0.5",
    "solver": 'solver = "nlgs"',
    "report": "",
}


def cuboid(low: tuple[float, float, float], high: tuple[float, float, float]) -> dict[str, list]:
    """Vertices and faces of a cuboid, as a block file has them."""
    vertices = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return {"vertices": vertices, "faces": faces}


def write_plate_and_block(folder: Path) -> None:
    """blocks.json: a fixed plate with a block on it."""
    plate = cuboid((-2.0, -1.0, -0.5), (2.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}
    block = cuboid((-0.5, -0.25, 0.0), (0.5, 0.25, 0.4)) | {"name": "block", "group": "block"}
    (folder / "blocks.json").write_text(json.dumps({"units": "m", "blocks": [plate, block]}))


def write_plate_scene(folder: Path, **lines: str) -> Path:
    """A scene of one block on a plate shaken along x, C = 0.2 m/s at 2 Hz for one cycle; lines are replaced by the name of their key."""
    write_plate_and_block(folder)
    scene = folder / "scene.toml"
    scene.write_text(PLATE_SCENE.format(**(LINES | lines)))
    return scene
