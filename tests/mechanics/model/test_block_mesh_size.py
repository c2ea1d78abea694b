# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh far too fine is refused before gmsh makes it, by the number of nodes that it would have."""

from __future__ import annotations

import pytest

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model import block_mesh as meshing
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.geometry.prism import box

CUBE = Polyhedron(*box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))


@pytest.mark.parametrize("axis", [-1, 1])
@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-200])
def test_a_mesh_far_too_fine_is_not_made(size: float, axis: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshing, "gmsh_session", lambda: pytest.fail("gmsh was called"))
    with pytest.raises(InputError, match=r'material\.mesh_size: block "b" would get about \S+ nodes with \S+ m, and \d+ are the most'):
        meshing.block_mesh("b", CUBE, size, axis)


@pytest.mark.parametrize("axis", [-1, 1])
def test_the_number_is_about_that_of_the_mesh(axis: int) -> None:
    """Those on the surface, which weigh where elements are large, come on top."""
    mesh = meshing.block_mesh("b", CUBE, 0.25 if axis < 0 else 0.08, axis)
    assert 0.3 * len(mesh.nodes) < meshing.likely_nodes(CUBE, 0.25 if axis < 0 else 0.08, axis) < 1.5 * len(mesh.nodes)
