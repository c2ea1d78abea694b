# SPDX-License-Identifier: GPL-3.0-or-later
"""reports.limit.picture: the mechanism is seen from where it moves to, and the key has what is there."""

from __future__ import annotations

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import box, ground

from masonry_cd.analysis.limit.analysis import Options, analyse
from masonry_cd.mechanics.model.joint_laws import JointLaw
from reports.drawing.palette import CRUSHED
from reports.drawing.parts import Lines, view_named
from reports.limit.picture import Subject, mechanism_scene


def slabs_pushed(direction: tuple[float, float, float]) -> Subject:
    """Two slabs, which keep a picture from being a front view, in the mechanism of a push."""
    blocks = [ground(8.0), box("one", (0.0, 0.0, 0.0), (0.5, 0.5, 3.0)), box("two", (1.0, 2.0, 0.0), (1.5, 2.5, 3.0))]
    assembly, joints = joined(blocks, 0.6)
    found = analyse(assembly, joints, push_loads(assembly, direction), Options(starts=0))
    return Subject(found.governing.mechanism, blocks, joints)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
def test_blocks_move_towards_the_viewer(direction: tuple[float, float, float]) -> None:
    view = mechanism_scene(slabs_pushed(direction), "", "").view
    assert view.towards @ direction > 0.1
    assert np.allclose(np.cross(view.right, view.up), view.towards)


def test_a_view_by_name_stays_and_the_key_has_no_empty_lines() -> None:
    scene = mechanism_scene(slabs_pushed((0.0, 1.0, 0.0)), "", "", "isometric")
    assert np.array_equal(scene.view.towards, view_named("isometric").towards)
    words = [sign.text for sign in scene.key[0].signs]
    assert any(word.startswith("hinge: ") for word in words) and not any(": 0 " in word for word in words)


def test_joints_that_crush_are_outlined_and_counted() -> None:
    blocks = [ground(8.0), box("one", (0.0, 0.0, 0.0), (0.5, 0.5, 3.0))]
    assembly, joints = joined(blocks, 0.6, {"default": JointLaw(compressive_strength=3e5)})
    found = analyse(assembly, joints, push_loads(assembly, (1.0, 0.0, 0.0)), Options(starts=0))
    scene = mechanism_scene(Subject(found.governing.mechanism, blocks, joints), "", "")
    assert "crushes: 1 joint" in [sign.text for sign in scene.key[0].signs]
    (outline,) = [layer for layer in scene.layers if isinstance(layer, Lines) and layer.colour == CRUSHED]
    assert len(outline.pairs) == 4
