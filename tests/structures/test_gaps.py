# SPDX-License-Identifier: GPL-3.0-or-later
"""Gaps between blocks closed: faces meet exactly, nothing moves farther than needed, and what is far apart stays apart."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from models import box
from solids import build, moved_at_rest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import triangles
from structures.files import blockfile
from structures.geometry.checks import check
from structures.geometry.gaps import close_gaps
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.prism import prism_xz

WALL = {"length": 2.0, "height": 1.5, "thickness": 0.4, "course_height": 0.25}


def shaken(blocks: list[Block], by: float) -> list[Block]:
    """The blocks, each moved and turned a little, by up to a distance at its corners [m]."""
    rng = np.random.default_rng(1)
    out = []
    for block in blocks:
        turn, move = rng.uniform(-0.4 * by, 0.4 * by, (2, 3))
        arm = block.vertices - block.vertices.mean(axis=0)
        out.append(Block(block.name, block.vertices + move + np.cross(turn, arm), block.faces, 2000.0, block.group, block.fixed))
    return out


def test_a_wall_with_gaps_gets_its_joints_back() -> None:
    """Stones in running bond, each out of place by up to a millimetre: no corner has a partner, only planes do."""
    sound = build("wall", **WALL)
    joints = find_joints(Assembly.from_blocks(sound, 0.6))
    loose = shaken(sound, 1e-3)
    assert find_joints(Assembly.from_blocks(loose, 0.6)).count < joints.count
    closed, moved, pairs = close_gaps(loose, 4e-3)
    check(closed)
    again = find_joints(Assembly.from_blocks(closed, 0.6))
    assert again.count == joints.count == pairs
    assert again.area.sum() == pytest.approx(joints.area.sum(), rel=5e-3)
    assert 5e-4 < moved < 4e-3
    assert moved_at_rest(closed) < 1e-4


def test_exact_joints_stay_as_they_are() -> None:
    arch = build("arch", span=4.0, thickness=0.5, voussoirs=9)
    closed, moved, _ = close_gaps(arch, 1e-3)
    assert moved < 1e-12
    assert all(np.abs(a.vertices - b.vertices).max() < 1e-12 for a, b in zip(arch, closed, strict=True))


def test_gaps_wider_than_the_tolerance_stay() -> None:
    blocks = [box("a", (0, 0, 0), (1, 1, 1)), box("b", (0, 0, 1.01), (1, 1, 2))]
    assert close_gaps(blocks, 5e-3)[1:] == (0.0, 0)
    closed, moved, pairs = close_gaps(blocks, 2e-2)
    assert (moved, pairs) == (pytest.approx(5e-3), 1)
    assert closed[0].vertices[:, 2].max() == pytest.approx(1.005, abs=1e-12)  # half way


def test_triangles_and_corners_of_a_plan_follow_too() -> None:
    """An L of triangles, whose inner faces move: its sides stay planar."""
    vertices, faces = prism_xz(np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float), 0.0, 1.0)
    turns = [next((k for k, vertex in enumerate(face) if len(face) == 6 and vertex % 6 == 3), 0) for face in faces]
    loops = tuple(face[k:] + face[:k] for face, k in zip(faces, turns, strict=True))  # those of its ends begin at the inner corner
    soup = Block("l", vertices, tuple(tuple(map(int, corners)) for corners in triangles(loops)), 2000.0)
    closed, moved, pairs = close_gaps([soup, box("in it", (1.002, 0, 1.004), (2, 1, 2))], 5e-3)
    assert pairs == 4  # two triangles each
    assert moved == pytest.approx(np.hypot(1e-3, 2e-3), rel=5e-3)  # half of either gap, but for the areas
    check(merge_coplanar([closed[1]]))


def test_a_chain_of_small_gaps_that_adds_up_is_refused() -> None:
    """Steps of 1 mm under one long stone, each within the tolerance of the next; the plane of all is far from the last."""
    steps = [box(f"s{k}", (k, 0, 0), (k + 1, 1, 1 + 1e-3 * k)) for k in range(12)]
    bridges = [box(f"t{k}", (k + 0.5, 0, 1 + 1e-3 * k + 5e-4), (k + 1.5, 1, 2)) for k in range(11)]
    with pytest.raises(
        InputError, match=r'^block "s0": to close its gaps a corner would have to move by 5\.\d+ mm, more than twice the 1 mm'
    ):
        close_gaps([*steps, *bridges], 1e-3)


def test_a_scene_says_what_was_moved(tmp_path: Path) -> None:
    blockfile.write(tmp_path / "loose.json", shaken(build("wall", **WALL), 1e-3))
    with pytest.raises(InputError, match="overlap"):
        structures.build({"kind": "file", "path": "loose.json"}, 2000.0, tmp_path)
    _, (note,), *_ = structures.make({"kind": "file", "path": "loose.json", "gaps": 4e-3}, 2000.0, tmp_path)
    assert note.startswith("loose.json: ")
    assert float(note.split()[-2]) < 4e-3
    text = json.loads((tmp_path / "loose.json").read_text())
    text["blocks"][3]["faces"].pop()
    (tmp_path / "open.json").write_text(json.dumps(text))
    with pytest.raises(InputError, match=r'^open\.json: block ".*": open shell'):
        structures.build({"kind": "file", "path": "open.json", "gaps": 4e-3}, 2000.0, tmp_path)
