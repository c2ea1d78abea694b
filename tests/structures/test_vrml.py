# SPDX-License-Identifier: GPL-3.0-or-later
"""VRML of both versions: face sets are placed as often as they are used, turned outwards and named."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import mesh_files as files
import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

CORNERS, FACES = files.box((0.0, 0.0, 0.0), (1.0, 2.0, 0.5))
POINTS = ", ".join(" ".join(f"{x:g}" for x in corner) for corner in CORNERS)
LOOPS = ", ".join(f"{', '.join(map(str, face))}, -1" for face in FACES)
INWARDS = ", ".join(f"{', '.join(map(str, face[::-1]))}, -1" for face in FACES)
COORD = f"coord DEF corners Coordinate {{ point [ {POINTS} ] }}"
LOOK = "appearance Appearance { material Material { diffuseColor 1 0 0 } }"
SHAPE = f"Shape {{ {LOOK} geometry IndexedFaceSet {{ {COORD} solid TRUE coordIndex [ {LOOPS} ] }} }}"


def made(folder: Path, text: str, **keys: Any) -> tuple[list[Block], str]:
    (folder / "a.wrl").write_text(text, encoding="utf-8")
    blocks, notes, *_ = structures.make({"kind": "file", "path": "a.wrl", "up": "z", **keys}, 2000.0, folder)
    return blocks, "\n".join(notes)


def lows(blocks: list[Block]) -> np.ndarray:
    return np.round([block.vertices.min(axis=0) for block in blocks], 9)


def test_transforms_place_and_use_repeats(tmp_path: Path) -> None:
    """A translation of a definition, a quarter turn about the vertical with a scale, and a mirror; clockwise faces are turned."""
    text = f"""#VRML V2.0 utf8
# a comment with {{ braces
DEF one Transform {{ children [ DEF stone {SHAPE} ] }}
Transform {{ translation 3 0 0 children USE stone }}
DEF turned Transform {{ translation 8 0 0 rotation 0 0 1 1.5707963267948966 scale 1 1 2 children [ {SHAPE}, Group {{ }} ] }}
Transform {{ translation 12 0 0 scale -1 1 1 children [ USE stone ] }}
DEF inwards Transform {{ translation 20 0 0 children Shape {{
  geometry IndexedFaceSet {{ ccw FALSE coord USE corners coordIndex [ {INWARDS} ] }} }} }}
ROUTE one.translation TO turned.set_translation
Shape {{ geometry Sphere {{ radius 2 }} }}
Switch {{ whichChoice -1 choice [ {SHAPE} ] }}
"""
    blocks, notes = made(tmp_path, text)
    assert [block.name for block in blocks] == ["stone.0", "stone.1", "turned", "stone.2", "inwards"]
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([1.0, 1.0, 2.0, 1.0, 1.0])
    assert lows(blocks).tolist() == [[0, 0, 0], [3, 0, 0], [6, 0, 0], [11, 0, 0], [20, 0, 0]]
    assert "1 Sphere not read" in notes and "1 choices of a Switch" in notes


def test_version_1_holds_a_state_within_separators(tmp_path: Path) -> None:
    text = f"""#VRML V1.0 ascii
Separator {{
  ShapeHints {{ vertexOrdering COUNTERCLOCKWISE shapeType SOLID }}
  Coordinate3 {{ point [ {POINTS} ] }}
  DEF low Separator {{ Translation {{ translation 0 0 1 }} IndexedFaceSet {{ coordIndex [ {LOOPS} ] }} }}
  MatrixTransform {{ matrix 1 0 0 0  0 1 0 0  0 0 1 0  5 0 2 1 }}
  DEF high IndexedFaceSet {{ coordIndex [ {LOOPS} ] }}
}}"""
    blocks, _ = made(tmp_path, text)
    assert [block.name for block in blocks] == ["low", "high"] and lows(blocks).tolist() == [[0, 0, 1], [5, 0, 2]]


def test_y_is_up_and_metres_unless_the_scene_says_otherwise(tmp_path: Path) -> None:
    (tmp_path / "b.wrz").write_bytes(gzip.compress(f"#VRML V2.0 utf8\n{SHAPE}".encode()))
    (block,) = structures.build({"kind": "file", "path": "b.wrz"}, 2000.0, tmp_path)
    assert np.ptp(block.vertices, axis=0) == pytest.approx([1.0, 0.5, 2.0])
    (block,) = structures.build({"kind": "file", "path": "b.wrz", "up": "z", "units": "cm"}, 2000.0, tmp_path)
    assert np.ptp(block.vertices, axis=0) == pytest.approx([0.01, 0.02, 0.005])


@pytest.mark.parametrize(
    "text",
    [
        "#VRML V2.0 utf8\nPROTO Stone [ ] { Shape { } }",
        "#VRML V2.0 utf8\nShape { geometry Box { size 1 1 1 } }",
        f"#VRML V2.0 utf8\n{SHAPE}"[:-40],
        "#VRML V2.0 utf8\n" + "Group { children [ " * 100,
        "#VRML V2.0 utf8\nUSE nothing",
        "no VRML",
    ],
)
def test_worlds_that_cannot_be_read_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match=r"a\.wrl"):
        made(tmp_path, text)
