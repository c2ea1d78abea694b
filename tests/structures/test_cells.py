# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.geometry.cells and outer_shell: stones cut from each other keep their volume, their parts are thick, their shells closed."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.geometry.cells import ConvexCell, joined, outside, planes, stone_of, together
from structures.geometry.checks import check
from structures.geometry.outer_shell import is_closed, outer_shell
from structures.geometry.prism import box, prism_xz
from structures.layout.pockets import with_pockets


def part(low: tuple[float, float, float], high: tuple[float, float, float]) -> ConvexCell:
    return ConvexCell.of(Block("stone", *box(low, high), 1.0))


def volume(parts: list[ConvexCell]) -> float:
    return sum(one.block.mass_properties.volume for one in parts)


def test_a_shallow_pocket_is_cut_off_upright_to_its_face() -> None:
    """A solid reaches 1 mm into the top of a stone, in a part of its length and depth."""
    solid = Polyhedron(*box((0.2, -1.0, 0.499), (0.7, 0.3, 2.0)))
    left = outside(part((0.0, 0.0, 0.0), (1.0, 0.6, 0.5)), planes(solid), np.zeros(6, dtype=bool))
    assert left is not None
    assert volume(left) == pytest.approx(0.3 - 0.5 * 0.3 * 0.001, rel=1e-12)
    assert min(one.width for one in joined(left)) > 0.15


def test_a_solid_next_to_a_stone_takes_nothing_and_one_about_it_all() -> None:
    stone, none = part((0.0, 0.0, 0.0), (1.0, 0.6, 0.5)), np.zeros(6, dtype=bool)
    assert outside(stone, planes(Polyhedron(*box((1.0, 0.0, 0.0), (2.0, 1.0, 1.0)))), none) is None
    assert outside(stone, planes(Polyhedron(*box((-1.0, -1.0, -1.0), (2.0, 1.0, 1.0)))), none) == []


def test_parts_that_are_convex_together_are_one_and_meeting_in_an_edge_is_not_hanging_together() -> None:
    row = [part((float(k), 0.0, 0.0), (k + 1.0, 0.5, 0.5)) for k in range(3)]
    (whole,) = joined(row)
    assert len(whole.block.faces) == 6
    assert whole.width == pytest.approx(0.5)
    across = [part((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), part((1.0, 1.0, 0.0), (2.0, 2.0, 1.0))]
    assert [len(group) for group in together(across)] == [1, 1]


def test_a_stone_whose_parts_meet_in_an_edge_has_a_closed_shell() -> None:
    """Two cubes that meet in an edge, on a plate that does not share whole faces with them."""
    parts = [part((0.0, 0.0, 0.0), (2.0, 2.0, 0.5)), part((0.0, 0.0, 0.5), (1.0, 1.0, 1.5)), part((1.0, 1.0, 0.5), (2.0, 2.0, 1.5))]
    shell = outer_shell([Polyhedron(one.block.vertices, one.block.faces) for one in parts])
    assert is_closed(shell.faces)
    stone = stone_of(Block("stone", *box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), 1.0), parts)
    check([stone])
    assert stone.mass_properties.volume == pytest.approx(4.0)


def test_a_sliver_over_a_pocket_goes_to_the_stone_above_it() -> None:
    """The back of a wedge passes 2 mm under the bed between two stones: of the lower one only what lies behind it stays."""
    blocks = [Block(name, *box((0.0, 0.0, z), (1.0, 0.6, z + 0.4)), 1.0) for name, z in (("low", 0.0), ("high", 0.4))]
    profile = np.array([(-0.5, -0.1), (1.5, -0.1), (1.5, 0.3935), (-0.5, 0.3995)])
    solid = Polyhedron(*prism_xz(profile, -1.0, 0.3))
    made = with_pockets(blocks, [solid], 0.02)
    assert [block.name for block in made] == ["low", "high"]
    check(made)
    parts = [ConvexCell.of(Block("", one.vertices, one.faces)) for block in made for one in block.convex_parts]
    assert min(one.width for one in parts) > 0.25
    cut = 0.3 * (0.3965 * 1.0)  # its back is at 0.3965 m in the middle of the stone
    assert sum(block.mass_properties.volume for block in made) == pytest.approx(0.48 - cut, rel=1e-9)


def test_a_sliver_thinner_than_rounding_leaves_no_face_that_runs_to_and_fro() -> None:
    """A prism of 5 nm on the side of a cube: both of its ends are lines along an edge of the cube."""
    cube = Polyhedron(*box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    plan = np.array([(0.0, 1.0), (1.0, 1.0), (0.5, 1.0 + 5e-9)])
    corners = np.vstack([np.column_stack([plan, np.full(3, z)]) for z in (0.0, 1.0)])
    sliver = Polyhedron(corners, ((0, 1, 2), (5, 4, 3), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)))
    shell = outer_shell([cube, sliver])
    assert all(len(set(face)) == len(face) for face in shell.faces)
    assert is_closed(shell.faces)
    check([Block("stone", shell.vertices, shell.faces, 1.0)])
