# SPDX-License-Identifier: GPL-3.0-or-later
"""Points between the facets of meshed blocks: what happens where two meshes cross in more of them than there is room for."""

from __future__ import annotations

import numpy as np
import pytest
from models import material_of

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import TooManyPoints
from masonry_cd.mechanics.dynamics.warps import Warps
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.state import State, rotation_matrices
from structures.geometry.prism import prism_xz


def long_plate(name: str, y: float, sides: int, upright: bool) -> Block:
    """A plate of 4 m x 1 m, whose ends are arcs of so many sides: its mesh is of slivers along it, from one end to the other."""
    s = np.linspace(-0.5, 0.5, sides + 1)
    end = np.stack([2.0 + 0.01 * (1.0 - 4.0 * s * s), s], axis=1)
    outline = np.concatenate([end, -end])
    return Block(name, *prism_xz(outline[:, ::-1] if upright else outline, y, y + 0.3), 2000.0, name)


def crossed(sides: int) -> tuple[Detector, Assembly]:
    """Two such plates against each other, at right angles."""
    material = ElasticBlocks.model_validate({"deformable": "tetrahedra", "young": 1e9, "mesh_size": 10.0})
    blocks = [long_plate("level", 0.0, sides, False), long_plate("upright", 0.3, sides, True)]
    assembly = Assembly.from_blocks(blocks, material_of(0.6, None, material))
    warps = Warps.of(assembly, None, 12)
    assert warps is not None
    return Detector(assembly, facets=warps.facets), assembly


def detect(detector: Detector, assembly: Assembly, apart: float = 0.0) -> ContactSet:
    """The contacts of the plates as built, or apart [m]."""
    state = State.at_rest(assembly)
    state.position[1, 1] += apart
    return detector.detect(state.position, rotation_matrices(state.orientation), np.zeros((2, 6)), 1e-3, 1e-4, np.zeros(3))


def test_slivers_that_cross_touch_wherever_their_sides_do() -> None:
    found = detect(*crossed(2))
    assert len(found.gap) > 8  # the corners of the overlap, and what is within
    assert np.abs(found.gap).max() < 1e-9


def test_meshes_that_cross_in_too_many_points_name_their_blocks() -> None:
    detector, assembly = crossed(14)
    with pytest.raises(TooManyPoints) as crowd:
        detect(detector, assembly)
    assert crowd.value.blocks == (0, 1)
    assert len(detect(detector, assembly, 0.1).gap) == 0  # nothing of it is left once they are apart
