# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids of a CAD model as blocks: whole, in the file's unit, touching where they did, and curved faces as asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from structures.files.cad_solids import named


def model(path: Path, *solids: tuple[str, tuple[float, ...]]) -> Path:
    """Write a model of solids, each by the kernel's own function."""
    with gmsh_session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")  # OpenCASCADE keeps the unit of whoever used it last in this process
        for kind, numbers in solids:
            getattr(gmsh.model.occ, f"add{kind}")(*numbers)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def built(folder: Path, name: str, **keys: object) -> list[Block]:
    return structures.build({"kind": "file", "path": name, **keys}, 2000.0, folder)


@pytest.mark.parametrize(("name", "keys"), [("a.step", {"units": "m"}), ("a.brep", {"units": "m"})])
def test_each_solid_is_a_block(tmp_path: Path, name: str, keys: dict[str, object]) -> None:
    model(tmp_path / name, ("Box", (0, 0, 0, 2, 1, 0.5)), ("Box", (0.5, 0, 0.5, 1, 1, 1)))
    if name.endswith(".step"):  # gmsh states millimetres
        keys, size = {}, 1e-3
    else:
        size = 1.0
    blocks = built(tmp_path, name, **keys)
    assert [len(block.vertices) for block in blocks] == [8, 8]
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([size**3, size**3])
    assert find_joints(Assembly.from_blocks(blocks, 0.6)).area == pytest.approx([size**2])


def test_a_unit_of_a_brep_is_that_of_the_scene(tmp_path: Path) -> None:
    model(tmp_path / "a.brep", ("Box", (0, 0, 0, 2000, 1000, 500)))
    (block,) = built(tmp_path, "a.brep", units="mm")
    assert np.ptp(block.vertices, axis=0) == pytest.approx([2.0, 1.0, 0.5])
    with pytest.raises(InputError, match=r"structure\.units: missing; a\.brep"):
        built(tmp_path, "a.brep")


def test_curved_faces_are_facets_within_the_chord(tmp_path: Path) -> None:
    model(tmp_path / "drum.brep", ("Cylinder", (0, 0, 0, 0, 0, 1, 0.5)))
    with pytest.raises(InputError, match=r"structure\.chord: missing; drum\.brep has 1 curved face"):
        built(tmp_path, "drum.brep", units="m")
    (drum,) = built(tmp_path, "drum.brep", units="m", chord=0.01)
    assert np.hypot(*drum.vertices[:, :2].T) == pytest.approx(0.5)
    assert 0.97 < drum.mass_properties.volume / (0.25 * np.pi) < 1.0
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(InputError, match=r"^structure\.chord: "):
        built(tmp_path, "a.obj", units="m", chord=0.01)


def test_labels_are_names_and_groups() -> None:
    names, groups = named(["Shapes/arch/stone", "Shapes/arch/stone", "Shapes/pier", "", "key"])
    assert names == ["stone.0", "stone.1", "pier", "b3", "key"]
    assert groups == ["arch", "arch", "", "", ""]
