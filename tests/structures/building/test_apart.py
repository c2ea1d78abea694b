# SPDX-License-Identifier: GPL-3.0-or-later
"""A wall that is near others and joins none of them is named; lengths in another unit are doubted where nothing can be built."""

from __future__ import annotations

from pathlib import Path

import pytest

import structures
from masonry_cd.app.case import make_structures
from masonry_cd.app.scene import parse_scene
from masonry_cd.foundation.errors import InputError

ROOM = {"south": [[0, 0], [6, 0]], "east": [[6, 0], [6, 4]], "north": [[6, 4], [0, 4]], "west": [[0, 4], [0, 0]]}


def notes(folder: Path, **axes: list[list[float]]) -> list[str]:
    walls = [{"name": n, "axis": [[float(x) for x in p] for p in a], "thickness": 0.6, "height": 1.0} for n, a in (ROOM | axes).items()]
    return structures.make({"kind": "building", "block_length": 1.5, "course_height": 0.5, "walls": walls}, 2000.0, folder)[1]


@pytest.mark.parametrize(
    ("axes", "named"),
    [
        ({}, ""),
        ({"east": [[6.9, 0.9], [6.9, 3.0]]}, "east"),
        ({"inner": [[2.0, 1.0], [2.0, 3.0]]}, "inner"),
        ({"far": [[20.0, 0.0], [20.0, 4.0]]}, ""),
    ],
)
def test_a_wall_that_joins_no_other_is_named(tmp_path: Path, axes: dict[str, list[list[float]]], named: str) -> None:
    found = [line for line in notes(tmp_path, **axes) if "joins no other" in line]
    assert [line.split()[1] for line in found] == ([named] if named else [])


def test_walls_in_centimetres_are_doubted_next_to_what_is_refused() -> None:
    walls = ", ".join(
        f'{{name = "{n}", axis = {[[100 * x for x in p] for p in a]}, thickness = 60, height = 300}}' for n, a in ROOM.items()
    )
    rest = "[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 1.0\n"
    text = f'[structure]\nkind = "building"\nwalls = [{walls}]\n{rest}'
    with pytest.raises(InputError) as failure:
        make_structures(parse_scene(text, Path("scene.toml")))
    lines = str(failure.value).splitlines()
    assert "structure.block_length" in lines[0]
    for line, key, meant in zip(lines[1:], ("thickness", "height"), ("60 cm", "300 cm"), strict=True):
        assert f"structure.walls[0].{key} = " in line and f'"{meant}"' in line and "3 more" in line
