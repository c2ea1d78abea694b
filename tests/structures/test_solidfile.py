# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks written as solids for CAD programs and gmsh."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from solids import build

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.model.blocks import Block
from structures.files import solidfile
from structures.geometry.prism import box


@pytest.mark.parametrize("ending", ["step", "brep"])
def test_solids_keep_the_volume_of_each_block_in_their_order(ending: str, tmp_path: Path) -> None:
    blocks = build("vault", form="cross", voussoirs=5)  # stones on the groins are not convex
    path = tmp_path / f"blocks.{ending}"
    solidfile.write(path, blocks)
    with gmsh_session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        volumes = [gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.occ.importShapes(str(path))]
    assert volumes == pytest.approx([block.mass_properties.volume for block in blocks], rel=1e-7)


@pytest.mark.parametrize("names", [["it's", "a\\b", "pietra è", "塔 1"], ["alone"]])
def test_names_and_groups_come_back_from_step_and_nothing_is_printed(
    names: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    groups = ["größe", "größe", "left pier", "left pier"]
    blocks = [Block(name, *box((k, 0, 0), (k + 1, 1, 1)), 2000.0, groups[k]) for k, name in enumerate(names)]
    solidfile.write(tmp_path / "blocks.step", blocks)
    assert capfd.readouterr().out == ""
    read = build("file", path=str(tmp_path / "blocks.step"), fixed=names[0])
    assert [block.name for block in read] == names
    assert [block.group for block in read][1:] == groups[1 : len(names)]


def test_a_step_file_that_does_not_name_all_its_solids_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "blocks.step"
    solidfile.write(path, [Block(f"b{k}", *box((k, 0, 0), (k + 1, 1, 1)), 2000.0) for k in range(3)])
    path.write_text(re.sub(r"#\d+ = NEXT_ASSEMBLY_USAGE_OCCURRENCE\([^;]*;", "", path.read_text(), count=1))
    with pytest.raises(InputError, match=r"blocks\.step: has 3 solids, 3 names and 2 groups of blocks"):
        build("file", path=str(path), fixed="b0")


def test_a_mesh_has_the_groups_of_the_blocks_and_their_volume(tmp_path: Path) -> None:
    blocks = [Block("a", *box((0, 0, 0), (1, 1, 1)), 2000.0, "one"), Block("b", *box((1, 0, 0), (2, 1, 1)), 2000.0, "two")]
    path = tmp_path / "blocks.msh"
    solidfile.write(path, blocks)
    with gmsh_session() as gmsh:
        gmsh.open(str(path))
        groups = {
            gmsh.model.getPhysicalName(*group): gmsh.model.getEntitiesForPhysicalGroup(*group) for group in gmsh.model.getPhysicalGroups()
        }
        assert set(groups) == {"one", "two"}
        assert gmsh.model.mesh.getElementsByType(4)[0].size > 10


def test_faces_that_make_no_solid_are_refused_by_block(tmp_path: Path) -> None:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    vertices[0] += [0.0, 0.0, 0.2]  # three of its faces are warped now
    with pytest.raises(InputError, match='block "warped"'):
        solidfile.write(tmp_path / "x.step", [Block("warped", vertices, faces, 2000.0)])
