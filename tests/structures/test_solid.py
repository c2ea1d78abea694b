# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids cut into courses: nothing is lost, every joint is found, the bond runs, and gravity moves nothing."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from solids import bonded_share, exposed, free_volume, moved_at_rest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block

pytestmark = pytest.mark.usefixtures("trusting")

HEAD = 'SetFactory("OpenCASCADE");\n'
# a hollow square tower of 2.4 m, walls 0.4 m, with a door
TOWER = """
Box(1) = {0, 0, 0, 2.4, 2.4, 1.5}; Box(2) = {0.4, 0.4, 0, 1.6, 1.6, 1.5}; Box(3) = {1.0, -1, 0, 0.4, 2, 1.0};
BooleanDifference(5) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Physical Volume("tower") = {5};
"""
KEYS = {"units": "m", "course_height": 0.25, "unit_length": 0.8}


def cut(folder: Path, text: str, **keys: object) -> list[Block]:
    (folder / "solid.geo").write_text(HEAD + text)
    return structures.build({"kind": "solid", "path": "solid.geo", "trusted": True, **KEYS, **keys}, 2000.0, folder)


def test_a_tower_keeps_its_volume_joints_and_bond_and_stands(tmp_path: Path) -> None:
    blocks = cut(tmp_path, TOWER)
    assert free_volume(blocks) == pytest.approx((2.4**2 - 1.6**2) * 1.5 - 0.4 * 0.4 * 1.0, rel=1e-6)
    assert {block.group for block in blocks} == {"tower", "base"}
    assembly = Assembly.from_blocks(blocks, 0.6)
    skin = 4 * (2.4 + 1.6) * 1.5 - 2 * 0.4 * 1.0 + 0.4 * (2 * 1.0 + 0.4) + (2.4**2 - 1.6**2)  # walls, less the door, its reveals, top
    assert exposed(blocks, assembly, find_joints(assembly)) == pytest.approx(skin, rel=1e-6)
    assert bonded_share(blocks, 0, 1.2, 2.0, 2.4) == pytest.approx(0.5)  # in every second course of the back wall
    assert moved_at_rest(blocks) < 1e-4


def test_stones_share_their_corners_to_the_bit(tmp_path: Path) -> None:
    blocks = cut(tmp_path, TOWER)
    corners = np.concatenate([block.vertices for block in blocks])
    for axis in range(3):
        values = np.unique(corners[:, axis])
        assert np.diff(values).min() > 1e-3  # no two that agree but for rounding


def test_no_slivers_where_the_grid_does_not_suit_the_walls(tmp_path: Path) -> None:
    """Walls of 0.4 m and stones of 0.7 m: planes fall into the walls that run along them, and are left out there."""
    blocks = cut(tmp_path, TOWER, unit_length=0.7)
    parts = [part for block in blocks if not block.fixed for part in block.convex_parts]
    assert min(np.ptp(part.vertices, axis=0).min() for part in parts) > 0.25 * 0.7 - 1e-9
    assert any(block.parts for block in blocks)  # stones around the corner
    assert free_volume(blocks) == pytest.approx((2.4**2 - 1.6**2) * 1.5 - 0.4 * 0.4 * 1.0, rel=1e-6)


def test_a_step_file_states_its_units_and_may_have_y_up(tmp_path: Path) -> None:
    with gmsh_session() as gmsh:  # a wall of 2000 x 500 x 400 mm, y up
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")  # OpenCASCADE keeps the unit of whoever used it last in this process
        gmsh.model.occ.addBox(0, 0, 0, 2000, 500, 400)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "wall.step"))
    keys = {"kind": "solid", "path": "wall.step", "up": "y", "course_height": 0.25, "unit_length": 0.5}
    blocks = structures.build(keys, 2000.0, tmp_path)
    stones = np.concatenate([block.vertices for block in blocks if not block.fixed])
    assert np.ptp(stones, axis=0) == pytest.approx([2.0, 0.4, 0.5])
    assert sorted(block.name for block in blocks) == [*(f"c0s{k}" for k in range(4)), *(f"c1s{k}" for k in range(5)), "ground"]
    with pytest.raises(InputError, match=r"structure\.units: belongs to \.geo and \.brep files"):
        structures.build({**keys, "units": "mm"}, 2000.0, tmp_path)


def test_a_column_of_drums_is_faceted_within_the_chord(tmp_path: Path) -> None:
    text = "Cylinder(1) = {0, 0, 0, 0, 0, 1.0, 0.4};"
    with pytest.raises(InputError, match=r"structure\.chord: missing; solid\.geo has 1 curved face, the first at"):
        cut(tmp_path, text, unit_length=1.0)
    keys = {"kind": "solid", "path": "solid.geo", "trusted": True, **KEYS, "unit_length": 1.0, "chord": 0.02}
    blocks, notes, *_ = structures.make(keys, 2000.0, tmp_path)
    drum = blocks[0]
    sides = len(drum.faces) - 2
    off = 0.4 * (1.0 - np.cos(np.pi / sides))
    assert 0.004 < off <= 0.02
    assert notes[0].startswith(f"solid.geo: curved faces are flat facets, at most {1e3 * off:.3g} mm off; the volume changes by -")
    assert free_volume(blocks) == pytest.approx(0.5 * sides * 0.4**2 * np.sin(2 * np.pi / sides) * 1.0, rel=1e-6)


def test_a_round_tower_is_made_of_stones_with_parts(tmp_path: Path) -> None:
    text = """Cylinder(1) = {0, 0, 0, 0, 0, 1.0, 1.5}; Cylinder(2) = {0, 0, 0, 0, 0, 1.0, 1.0};
    BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2}; Delete; };"""
    blocks = cut(tmp_path, text, course_height=0.5, unit_length=1.0, chord=0.03)
    assert any(block.parts for block in blocks)
    assert free_volume(blocks) == pytest.approx(np.pi * (1.5**2 - 1.0**2), rel=0.02)
    assert moved_at_rest(blocks, 0.04) < 1e-4


def test_a_block_with_a_hole_through_it(tmp_path: Path) -> None:
    text = """Box(1) = {0, 0, 0, 1, 1, 0.5}; Box(2) = {0.4, -1, 0.1, 0.2, 3, 0.3};
    BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2}; Delete; };"""
    blocks = cut(tmp_path, text, course_height=0.5, unit_length=5.0)
    assert len(blocks) == 2
    assert free_volume(blocks) == pytest.approx(0.5 - 0.2 * 0.3, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "keys", "message"),
    [
        (TOWER, {"units": None}, "structure.units: missing; solid.geo does not say it"),
        (TOWER, {"bond": "wild"}, "structure.bond: input should be 'running' or 'stack', got 'wild'"),
        (TOWER, {"path": "none.step", "units": None}, 'structure.path: no file "none.step"'),
        (TOWER, {"path": "solid.dxf"}, 'structure.path: "solid.dxf" is not a solid; known: .geo, .step, .stp, .brep'),
        ("Point(1) = {0, 0, 0};", {}, "solid.geo: no volume of the OpenCASCADE kernel in it; a .geo file begins with SetFactory"),
        ("Box(1) = {0, 0", {}, "solid.geo: cannot be read: "),
        ("Cylinder(1) = {0, 0, 0, 0, 0, 1, 0.4};", {"chord": 1e-6}, "structure.chord: solid.geo: some facets stay "),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, keys: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as failure:
        cut(tmp_path, text, **keys)
    assert str(failure.value).startswith(message)


def test_a_missing_geometry_kernel_names_the_packages_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError, match="apt-get install libglu1-mesa libgl1"), gmsh_session():
        pass
