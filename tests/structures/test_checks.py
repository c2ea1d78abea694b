# SPDX-License-Identifier: GPL-3.0-or-later
"""Unsound blocks: each is refused by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron
from structures.geometry.checks import check
from structures.geometry.prism import prism_xz, rectangle


def box(name: str, x: float, z: float, size: tuple[float, float, float] = (1.0, 1.0, 1.0), fixed: bool = False) -> Block:
    vertices, faces = prism_xz(rectangle(x, x + size[0], z, z + size[2]), 0.0, size[1])
    return Block(name, vertices, faces, 2000.0, fixed=fixed)


def turned(block: Block, angle: float, axis: int) -> Block:
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    rotation = np.eye(3)
    rotation[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    centre = block.vertices.mean(axis=0)
    return replace(block, vertices=(block.vertices - centre) @ rotation.T + centre)


def refused(*blocks: Block) -> str:
    with pytest.raises(InputError) as failure:
        check(blocks)
    assert "\n" not in str(failure.value)
    return str(failure.value)


def with_faces(block: Block, faces: Faces) -> Block:
    return replace(block, faces=faces)


def test_touching_blocks_are_sound() -> None:
    check([box("base", -1, -1, (4, 4, 1), fixed=True), box("a", 0, 0), box("b", 1, 0), box("c", 0.5, 1)])


def test_open_shell() -> None:
    block = box("a", 0, 0)
    assert refused(box("z", 5, 0), with_faces(block, block.faces[:-1])).startswith('block "a": open shell, edge ')


def test_reversed_shell() -> None:
    block = box("a", 0, 0)
    assert "faces are reversed" in refused(with_faces(block, tuple(face[::-1] for face in block.faces)))


def test_one_reversed_face() -> None:
    block = box("a", 0, 0)
    message = refused(with_faces(block, (block.faces[0][::-1], *block.faces[1:])))
    assert message.startswith('block "a": two faces run the same way along edge')


def test_bent_face() -> None:
    block = box("a", 0, 0)
    vertices = block.vertices.copy()
    vertices[0, 2] += 0.01
    assert "is not planar" in refused(replace(block, vertices=vertices))


def test_non_convex_shell() -> None:
    corner = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    vertices, faces = prism_xz(corner, 0.0, 1.0)
    block = Block("ell", vertices, faces, 2000.0)
    assert refused(block).startswith('block "ell": not convex, vertex')
    halves = [prism_xz(rectangle(0, 2, 0, 1), 0, 1), prism_xz(rectangle(0, 1, 1, 2), 0, 1)]
    check([replace(block, parts=tuple(Polyhedron(*half) for half in halves)), box("in the corner", 1, 1)])
    with pytest.raises(InputError, match='"ell" and "in the arm": they overlap'):
        check([replace(block, parts=tuple(Polyhedron(*half) for half in halves)), box("in the arm", 0.5, 1.5)])


def test_degenerate_faces_and_indices() -> None:
    block = box("a", 0, 0)
    assert "face 0 is degenerate" in refused(with_faces(block, ((0, 1, 1), *block.faces[1:])))
    assert "face 0 names a vertex outside 0 to 7" in refused(with_faces(block, ((0, 1, 9), *block.faces[1:])))
    flat = replace(block, vertices=block.vertices * [1, 1, 0])
    assert "degenerate" in refused(flat)


def test_values_that_are_no_numbers() -> None:
    block = box("a", 0, 0)
    vertices = block.vertices.copy()
    vertices[3, 1] = np.nan
    assert refused(replace(block, vertices=vertices)) == 'block "a": vertex 3 is not finite'
    assert "density must be above 0" in refused(replace(block, density=0.0))


def test_names_given_twice() -> None:
    assert refused(box("a", 0, 0), box("a", 2, 0)) == 'block "a": two blocks have this name'


def test_names_that_no_line_can_show() -> None:
    long = "v" * 100_000
    assert refused(box(long, 0, 0)) == f'block "{long[:300]} ...": its name has 100000 characters; at most 200'
    assert refused(replace(box("a", 0, 0), group=long)) == 'block "a": its group has 100000 characters; at most 200'
    check([replace(box(long[:200], 0, 0), group=long[:200])])


def test_overlap_names_both_blocks_and_the_depth() -> None:
    assert refused(box("a", 0, 0), box("b", 0.998, 0.2)) == 'blocks "a" and "b": they overlap by 2 mm'
    assert refused(box("outer", 0, 0), box("inner", 0.4, 0.4, (0.2, 0.2, 0.2))).startswith('blocks "outer" and "inner": they overlap')


def test_overlap_below_the_tolerance_passes_and_supports_may_meet() -> None:
    check([box("a", 0, 0), box("b", 1.0 - 1e-7, 0)])
    check([box("ground", 0, 0, fixed=True), box("footing", 0.5, 0.5, fixed=True)])


@pytest.mark.parametrize(
    ("width", "depth", "sound"), [(1.0, 1.9e-5, True), (1.0, 2.1e-5, False), (0.01, 0.9e-6, True), (0.01, 1.5e-6, False)]
)
def test_overlaps_of_inexact_coordinates_pass_as_their_gaps_do(width: float, depth: float, sound: bool) -> None:
    """Up to a ten-thousandth of the smallest width, and 0.02 mm; of supports too, whose own width does not count."""
    base, stone = box("base", 0, -0.001, (1.0, 1.0, 0.001), fixed=True), box("a", 0, -depth, (1.0, 1.0, width))
    if sound:
        check([base, stone])
    else:
        assert '"base" and "a": they overlap' in refused(base, stone)


def test_boxes_whose_bounding_boxes_meet_but_which_are_apart() -> None:
    # two tilted cubes, one edge to another: only the cross product of two edges separates them
    lower = turned(box("lower", 0, 0), np.pi / 4, 1)  # an edge along y on top, at z = 0.5 + sqrt(2)/2
    upper = turned(box("upper", 0, np.sqrt(2.0)), np.pi / 4, 0)  # an edge along x below
    check([lower, replace(upper, vertices=upper.vertices + [0, 0, 1e-9])])
    assert "overlap by 1 mm" in refused(lower, replace(upper, vertices=upper.vertices - [0, 0, 1e-3]))


def test_of_five_thousand_blocks_the_two_that_overlap_are_found() -> None:
    blocks = [box(f"{i}-{j}", i + 0.5 * (j % 2), j) for i in range(50) for j in range(100)]
    check(blocks)
    blocks[2550] = replace(blocks[2550], vertices=blocks[2550].vertices + [2e-3, 0.0, 0.0])  # 25-50, into the next one of its course
    assert refused(*blocks) == 'blocks "25-50" and "26-50": they overlap by 2 mm'
