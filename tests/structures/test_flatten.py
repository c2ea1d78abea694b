# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks that are nearly flat and nearly convex: made flat, within the tolerance, wherever they lie and however they are turned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import structures
from benchmarks.noisy_stones import cut_box, noisy, stepped
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties, triangles
from masonry_cd.mechanics.model.polygon import loop_planes
from structures.files.blockfile import sound
from structures.geometry.convex import size_of, split
from structures.geometry.flatten import LIMIT, SHARE, flattened
from structures.geometry.prism import box


def stone(seed: int, convex: bool, in_triangles: bool, noise: float, away: bool = False) -> tuple[Block, Block]:
    """A stone of the benchmark, and the same with noise."""
    rng = np.random.default_rng(seed)
    block = (cut_box if convex else stepped)(rng)
    faces = tuple(map(tuple, triangles(split(block).faces).tolist())) if in_triangles else block.faces
    return block, noisy(block, faces, noise, away, rng)


def off_plane(block: Block) -> float:
    """How far a corner is off the plane of its face at most [m]."""
    loops = [block.vertices[list(face)] for face in block.faces]
    return max(float(np.abs(loop @ n - c).max()) for loop, n, c in zip(loops, *loop_planes(loops), strict=True))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.sampled_from([1e-7, 1e-6, 1e-5, 1e-4]))
def test_noise_up_to_a_ten_thousandth_is_taken(seed: int, convex: bool, in_triangles: bool, noise: float) -> None:
    exact, uneven = stone(seed, convex, in_triangles, noise)
    (flat,), far, _ = flattened([uneven], None)
    (taken,) = sound([flat], "stone")
    size, volume = size_of(exact), mass_properties(exact.vertices, exact.faces).volume
    assert off_plane(taken) < 1e-5 * size
    assert far <= LIMIT * SHARE * size
    assert mass_properties(taken.vertices, taken.faces).volume == pytest.approx(volume, rel=20 * noise + 2e-3 * (far > 4 * noise * size))


@pytest.mark.parametrize("convex", [True, False])
def test_where_it_lies_does_not_matter(convex: bool) -> None:
    for seed in range(5):
        (here,), near, _ = flattened([stone(seed, convex, True, 1e-5)[1]], None)
        (there,), far, _ = flattened([stone(seed, convex, True, 1e-5, away=True)[1]], None)
        assert here.faces == there.faces
        assert near == pytest.approx(far, abs=1e-9)
        np.testing.assert_allclose(here.vertices - here.vertices[0], there.vertices - there.vertices[0], atol=1e-9)


def test_where_corners_have_three_planes_they_become_exactly_flat() -> None:
    _, uneven = stone(3, True, False, 1e-4)
    (flat,), _, count = flattened([uneven], None)
    assert count == 1
    assert off_plane(uneven) > 1e-5
    assert off_plane(flat) < 1e-12
    assert flat.faces == uneven.faces


def test_more_than_three_planes_in_a_corner_give_way_together() -> None:
    """A pyramid on eight sides whose sides are quadrilaterals: its top is on eight planes, each corner of its foot on three."""
    angle = np.arange(8) * np.pi / 4
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(8)])
    corners = np.concatenate([ring, 0.5 * ring + [0, 0, 0.5], [[0, 0, 0.8]]])
    sides = [(k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k) for k in range(8)]
    block = Block("pyramid", corners, (tuple(range(8))[::-1], *sides, *((8 + k, 8 + (k + 1) % 8, 16) for k in range(8))), 2000.0)
    shaken = replace(block, vertices=corners + 1e-4 * np.random.default_rng(2).uniform(-1, 1, corners.shape))
    (flat,), far, _ = flattened([shaken], None)
    assert off_plane(flat) < 1e-10
    assert far < 5e-4
    assert sound([flat], "pyramid")


def test_sound_blocks_stay_as_they_are() -> None:
    vertices, faces = box((0, 0, 0), (1, 0.5, 0.4))
    corners = np.array(vertices, dtype=float)
    roof = replace(Block("roof", corners, faces, 2000.0))
    ridge = Block("ridge", np.concatenate([corners, [[0.5, 0, 0.4005], [0.5, 0.5, 0.4005]]]), _with_ridge(corners), 2000.0)
    blocks = [roof, ridge, stone(1, False, False, 0.0)[0], stone(1, False, True, 0.0)[1]]
    new, far, changed = flattened(blocks, None)
    assert (far, changed) == (0.0, 0)
    assert all(a is b for a, b in zip(new, blocks, strict=True))


def _with_ridge(corners: np.ndarray) -> tuple[tuple[int, ...], ...]:
    """Faces of the box 1 x 0.5 x 0.4 m whose top has a ridge of 1 mrad across its middle, between corners 8 and 9."""
    at = {tuple(corner): k for k, corner in enumerate(corners.tolist())}
    a, b, c, d = (at[x, y, 0.0] for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)))
    e, f, g, h = (at[x, y, 0.4] for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)))
    return ((d, c, b, a), (a, b, f, 8, e), (b, c, g, f), (c, d, h, 9, g), (d, a, e, h), (e, 8, 9, h), (8, f, g, 9))


def test_what_is_farther_off_is_another_shape() -> None:
    vertices, faces = box((0, 0, 0), (1, 0.5, 0.4))
    corners = np.array(vertices, dtype=float)
    corners[0] += [0, 0, 0.05]
    block = Block("warped", corners, faces, 2000.0)
    new, far, changed = flattened([block], None)
    assert (new[0] is block, far, changed) == (True, 0.0, 0)
    assert flattened([replace(block, vertices=corners)], 0.03)[2] == 1


def test_the_key_says_within_what_and_a_note_how_far(tmp_path: Path) -> None:
    _, uneven = stone(3, True, False, 1e-4)
    lines = ["o stone"] + [f"v {x!r} {y!r} {z!r}" for x, y, z in uneven.vertices.tolist()]
    lines += ["f " + " ".join(str(1 + i) for i in face) for face in uneven.faces]
    (tmp_path / "stone.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    table = {"kind": "file", "path": "stone.obj", "units": "m", "up": "z"}
    _, notes, *_ = structures.make(table, 2000.0, tmp_path)
    assert any("faces of 1 blocks made flat, corners moved by at most" in note for note in notes)
    with pytest.raises(InputError, match="is not planar"):
        structures.build(table | {"flatness": 0.0}, 2000.0, tmp_path)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_flatness_above_the_noise_of_a_scan_gives_the_faces_back(seed: int) -> None:
    """Triangles off by a thousandth of the block: more than is taken for noise by itself, so the key decides."""
    clean, scanned = stone(seed, True, True, 1e-3)
    alone, _, _ = flattened([scanned], None)
    asked, moved, changed = flattened([scanned], 6e-3 * size_of(clean))
    assert len(alone[0].faces) > len(clean.faces)
    assert (changed, len(asked[0].faces) <= len(clean.faces)) == (1, True)
    assert moved <= LIMIT * 6e-3 * size_of(clean)
    assert mass_properties(asked[0].vertices, asked[0].faces).volume == pytest.approx(
        mass_properties(clean.vertices, clean.faces).volume, rel=2e-2
    )
