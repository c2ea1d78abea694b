# SPDX-License-Identifier: GPL-3.0-or-later
"""Supports of a file by name, group and place, in every kind of file; a rule that is none, or that nothing fulfils, is one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import tower

import structures
from masonry_cd.foundation.errors import InputError
from structures.files import blockfile, meshfile
from structures.standing import in_words

CASES: list[tuple[Any, list[str]]] = [
    ("ground", ["ground"]),
    (["b0"], ["b0"]),
    ({"below": 0.0}, ["ground"]),
    ({"below": "20 cm"}, ["ground", "b0"]),
    ({"box": [[-1, -1, 0.05], [1, 1, 0.2]]}, ["b0"]),
    ({"name": "b?", "below": 0.3}, ["b0"]),
    ([{"name": "b1"}, {"below": 0.0}], ["ground", "b1"]),
]


@pytest.mark.parametrize("suffix", ["json", "obj", "stl", "vtu", "vtm"])
def test_supports_are_found_by_place_in_every_kind_of_file(tmp_path: Path, suffix: str) -> None:
    blocks = tower(2)  # 0.25 m high each, on a plate
    (blockfile if suffix == "json" else meshfile).write(tmp_path / f"t.{suffix}", blocks)
    states = {} if suffix == "json" else {"units": "m", "up": "z"}
    made = structures.build({"kind": "file", "path": f"t.{suffix}", "fixed": {"below": 0.2}, **states}, 2000.0, tmp_path)
    heights = np.array([block.vertices[:, 2].mean() for block in made])
    assert [block.fixed for block in made] == [bool(z < 0.2) for z in heights]


@pytest.mark.parametrize(("fixed", "names"), CASES)
def test_rules(tmp_path: Path, fixed: Any, names: list[str]) -> None:
    meshfile.write(tmp_path / "t.obj", [replace(block, fixed=False) for block in tower(2)])
    if fixed == "ground":  # a name goes first: here it is the plate's
        assert tower(2)[0].name == "ground"
    made = structures.build({"kind": "file", "path": "t.obj", "units": "m", "up": "z", "fixed": fixed}, 2000.0, tmp_path)
    assert [block.name for block in made if block.fixed] == names
    assert all(block.group == "base" for block in made if block.fixed)


def test_what_touches_the_ground_needs_no_name(tmp_path: Path) -> None:
    made = [block for block in tower(3) if not block.fixed]
    blockfile.write(tmp_path / "t.json", made)
    again = structures.build({"kind": "file", "path": "t.json", "fixed": "ground"}, 2000.0, tmp_path)
    assert [block.fixed for block in again] == [True, False, False]
    assert again[0].group == made[0].group


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        (["x*"], 'structure.fixed: no block is named "x\\*"; the first are ground, b0, b1$'),
        (
            {"below": -9},
            r"structure.fixed: no block fulfils below = -9.0; the lowest corner is at z = -?[\d.]+ m, names are ground, b0, b1",
        ),
        ({}, "structure.fixed: must have one of below, box, group and name"),
        ({"under": 1.0}, "structure.fixed.under: unknown key; known keys: below, box, group, name"),
        (["b0", {"below": "1 kg"}], r"structure.fixed\[1\].below: "),
        ({"box": [[1, 0, 0], [0, 1, 1]]}, r"structure.fixed: box: must be \[lowest corner, highest corner\]"),
        (3, "structure.fixed: must be a name, a table of below, box, group or name, or a list of them, got 3"),
    ],
)
def test_rules_that_are_none(tmp_path: Path, fixed: Any, message: str) -> None:
    meshfile.write(tmp_path / "t.obj", tower(2))
    with pytest.raises(InputError, match=f"^{message}"):
        structures.build({"kind": "file", "path": "t.obj", "units": "m", "up": "z", "fixed": fixed}, 2000.0, tmp_path)


def test_where_nothing_is_fixed_the_line_says_how() -> None:
    assert 'structure.fixed = "ground" fixes those that touch the ground' in in_words((), (), ("a", "b"))[0]
