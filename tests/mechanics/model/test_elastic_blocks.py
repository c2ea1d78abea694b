# SPDX-License-Identifier: GPL-3.0-or-later
"""Which blocks deform: keys by group, what is refused, and the axes and masses of the strains."""

from __future__ import annotations

import numpy as np
import pytest
from models import tower

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model import block_mesh as meshing
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.deformation import hooke, principal_axes
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks, Elasticity
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.materials import Material
from structures.geometry.prism import box

GROUPS = ("base", "arch", "pier-east", "pier-west")


def test_values_by_group_by_pattern_and_by_default() -> None:
    """A name holds before a pattern, and that before the default."""
    keys = {
        "deformable": {"arch": "uniform", "pier-*": "uniform", "pier-west": "rigid"},
        "young": {"default": 1e9, "arch": 5e9},
        "damping": {"default": 0.0, "arch": 0.1},
        "damping_frequency": 10.0,
    }
    material = ElasticBlocks.model_validate(keys)
    arch, east = (material.of_group(group, GROUPS) for group in ("arch", "pier-east"))
    assert arch is not None
    assert arch.young == 5e9
    assert arch.retardation == pytest.approx(0.1 / (np.pi * 10.0))
    assert east == Elasticity(1e9, 0.2, 0.0)
    assert material.of_group("pier-west", GROUPS) is None
    assert material.of_group("base", GROUPS) is None


def test_a_group_whose_name_has_brackets_goes_by_its_name() -> None:
    """Only a star makes a pattern."""
    material = ElasticBlocks.model_validate({"deformable": {"pier[1]": "uniform"}, "young": {"pier[1]": 2e9}})
    assert material.of_group("pier[1]", ["base", "pier[1]"]) == Elasticity(2e9, 0.2, 0.0)
    assert material.of_group("base", ["base", "pier[1]"]) is None


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"deformable": {"arhc": "uniform"}, "young": 1e9}, r'material\.deformable\.arhc: "arhc" is not a group.*did you mean "arch"'),
        ({"deformable": "uniform", "young": {"arch": 1e9}}, r"material\.young: no value for the group pier-east"),
    ],
)
def test_groups_that_do_not_fit_the_blocks_are_refused(keys: dict[str, object], message: str) -> None:
    """With the key at fault."""
    with pytest.raises(InputError, match=message):
        ElasticBlocks.model_validate(keys).of_group("pier-east", GROUPS)


@pytest.mark.parametrize("rigid", ["rigid", {"default": "rigid"}])
def test_a_scene_with_elasticity_may_be_run_with_rigid_blocks(rigid: object) -> None:
    """Its other keys wait: one scene gives both runs of a comparison."""
    keys = {"deformable": rigid, "young": 1e9, "mesh_size": 0.1, "damping": 0.05, "damping_frequency": 10.0}
    assert ElasticBlocks.model_validate(keys).of_group("arch", GROUPS) is None


def test_a_vibration_without_damping_may_be_asked_for_by_zero() -> None:
    """A study over damping may begin at none."""
    keys = {"deformable": "uniform", "young": 1e9, "damping": 0.0, "damping_frequency": 10.0}
    assert ElasticBlocks.model_validate(keys).of_group("arch", GROUPS) == Elasticity(1e9, 0.2, 0.0)


def test_hookes_law_is_that_of_a_bar_whose_sides_are_free() -> None:
    """Its inverse has 1 / E, - nu / E and 1 / G."""
    compliance = np.linalg.inv(hooke(Elasticity(2e9, 0.25, 0.0)))
    np.testing.assert_allclose(compliance[0, :3], np.array([1.0, -0.25, -0.25]) / 2e9, rtol=1e-12)
    np.testing.assert_allclose(compliance[3:, 3:], 2.5 / 2e9 * np.eye(3), rtol=1e-12)


def test_principal_axes_stay_near_those_of_the_frame() -> None:
    """They diagonalise any symmetric tensor; those of one that is diagonal but for rounding are the frame's."""
    square = np.random.default_rng(0).normal(size=(50, 3, 3))
    tensor = np.einsum("dij,dkj->dik", square, square)
    tensor[0] = np.eye(3) + 1e-14
    tensor[1] = np.diag([2.0, 1.0, 1.0])
    axes, values = principal_axes(tensor)
    np.testing.assert_allclose(np.einsum("dij,dj,dkj->dik", axes, values, axes), tensor, atol=1e-10)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, rtol=1e-12)
    assert np.array_equal(axes[:2], np.tile(np.eye(3), (2, 1, 1)))


def test_an_assembly_that_is_moved_takes_the_axes_along() -> None:
    """As the limit analysis moves it."""
    made = Assembly.from_blocks(tower(2), Material(friction=0.5, deformable="uniform", young=1e9))
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = made.placed(made.centre, np.tile(quarter, (3, 1, 1)))
    assert made.deformation is not None
    assert moved.deformation is not None
    np.testing.assert_allclose(moved.deformation.axes, quarter @ made.deformation.axes, atol=1e-15)


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
