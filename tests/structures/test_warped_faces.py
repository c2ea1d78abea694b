# SPDX-License-Identifier: GPL-3.0-or-later
"""Warped faces under repair: in triangles, with the larger solid, and as they are without it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.files import meshfile
from structures.geometry.prism import box
from structures.geometry.warped_faces import in_triangles


@pytest.mark.parametrize("push", [0.02, -0.02])
def test_a_corner_off_its_faces_by_two_centimetres(tmp_path: Path, push: float) -> None:
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 0.6, 0.5))
    vertices = np.array(vertices, dtype=float)
    vertices[7] += push
    meshfile.write(tmp_path / "w.obj", [Block("s", vertices, faces, 2000.0)])
    table = {"kind": "file", "path": "w.obj", "units": "m", "up": "z"}
    with pytest.raises(InputError, match="is not planar, a corner is"):
        structures.build(table, 2000.0, tmp_path)
    (block,), notes, *_ = structures.make(table | {"repair": True}, 2000.0, tmp_path)
    assert notes == ["w.obj: 3 warped faces cut into triangles"]
    assert (len(block.faces), len(block.parts)) == (9, 0)  # convex: no diagonal is a valley
    assert np.abs(vertices[:, None] - block.vertices).max(axis=2).min(axis=1).max() == 0.0  # corners stay


def test_flat_faces_stay(tmp_path: Path) -> None:
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 0.6, 0.5))
    block = Block("s", np.array(vertices, dtype=float), faces, 2000.0)
    (same,), count = in_triangles([block])
    assert (same is block, count) == (True, 0)
    assert mass_properties(same.vertices, same.faces).volume == pytest.approx(0.3)
