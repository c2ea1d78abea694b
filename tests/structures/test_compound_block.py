# SPDX-License-Identifier: GPL-3.0-or-later
"""Compound blocks: convex parts that act as one stone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from models import ground

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.geometry.checks import check
from structures.geometry.compound_block import compound_block
from structures.geometry.prism import box


def corner() -> list:
    """An L of three cubes' room in two boxes that share a face."""
    return [box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), box((1.0, 0.0, 0.0), (2.0, 1.0, 1.0)), box((0.0, 1.0, 0.0), (1.0, 2.0, 1.0))]


def test_the_shell_has_no_inner_faces_and_the_mass_of_its_parts() -> None:
    block = compound_block("L", corner(), 2000.0, "wall")
    check([block])
    assert len(block.faces) == 3 * 6 - 2 * 2
    whole = mass_properties(block.vertices, block.faces)
    assert whole.volume == pytest.approx(3.0)
    assert whole.centre == pytest.approx([2.5 / 3.0, 2.5 / 3.0, 0.5])


def test_it_stands_on_all_its_parts() -> None:
    assembly = Assembly.from_blocks([compound_block("L", corner(), 2000.0, "wall"), ground()], 0.6)
    joints = find_joints(assembly)
    assert joints.area.sum() == pytest.approx(3.0)
    assert np.allclose(np.abs(joints.normal[:, 2]), 1.0)


def test_parts_that_share_no_face_are_refused() -> None:
    with pytest.raises(InputError, match=r'^block "two": its parts do not share whole faces$'):
        compound_block("two", [box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), box((1.0, 0.0, 0.0), (2.0, 0.5, 1.0))], 2000.0, "wall")


def test_parts_in_the_same_place_are_refused() -> None:
    part = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match=r'^block "two": its parts have no face of their own; corners within 0\.0001 mm'):
        compound_block("two", [part, part], 2000.0, "wall")


def test_parts_that_do_not_fill_the_block_are_refused() -> None:
    block = compound_block("L", corner(), 2000.0, "wall")
    with pytest.raises(InputError, match=r'block "L": its parts have 2 m3, the block has 3 m3'):
        check([replace(block, parts=block.parts[:2])])
