# SPDX-License-Identifier: GPL-3.0-or-later
"""Foundations in pieces: nothing of them is gained or lost, pieces lie where their names say, and any structure can settle in part."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures import build

KINDS: dict[str, dict[str, Any]] = {
    "wall": {"length": 3.0, "height": 2.0},
    "tower": {"side": 3.0, "height": 6.0, "thickness": 0.6, "belfry_width": 0.0, "door_width": 0.0},
    "leaning tower": {
        "kind": "tower",
        "side": 3.0,
        "height": 6.0,
        "thickness": 0.6,
        "belfry_width": 0.0,
        "door_width": 0.0,
        "inclination": 3.0,
    },
    "column": {},
    "dome": {"span": 5.0, "thickness": 0.6},
    "aqueduct": {},
    "arch": {"span": 4.0, "thickness": 0.5, "buttress_width": 2.2, "buttress_height": 2.0},
    "church": {"block_length": 2.0},
}


def made(kind: str, **more: Any) -> list[Block]:
    return build({"kind": kind} | KINDS[kind] | more, 2000.0, Path())


def supports(blocks: list[Block]) -> dict[str, Block]:
    return {block.name: block for block in blocks if block.fixed}


def volume(blocks: dict[str, Block]) -> float:
    return sum(mass_properties(block.vertices, block.faces).volume for block in blocks.values())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("asked", ["corners", {"x": 3}, {"y": 2, "x": [0.3]}], ids=["corners", "strips", "both ways"])
def test_cuts_fill_the_foundations(kind: str, asked: object) -> None:
    if kind == "church" and asked != "corners":
        return  # the corners show it
    whole, cut = supports(made(kind)), supports(made(kind, foundations=asked))
    assert len(cut) > len(whole)
    assert volume(cut) == pytest.approx(volume(whole), rel=1e-9)
    assert all(len(block.faces) >= 5 for block in cut.values())


def test_corners_are_named_by_where_they_lie() -> None:
    cut = supports(made("wall", foundations="corners"))
    assert {name: tuple(np.sign(block.vertices.mean(axis=0)[:2])) for name, block in cut.items()} == {
        "ground.sw": (-1, -1), "ground.se": (1, -1), "ground.nw": (-1, 1), "ground.ne": (1, 1),
    }  # fmt: skip


def test_strips_are_equal_under_what_stands_on_them() -> None:
    cut = supports(made("wall", foundations={"x": 3}))
    assert list(cut) == ["ground.x1", "ground.x2", "ground.x3"]
    assert np.ptp(cut["ground.x2"].vertices[:, 0]) == pytest.approx(1.0)


def test_a_piece_lies_under_each_part() -> None:
    """Every foot of a tower's wall bears on pieces of its own name and on no other part's."""
    blocks = made("tower", foundations="parts")
    pieces = supports(blocks)
    assert {name.split(".")[1] for name in pieces} == {"south", "north", "east", "west", "rest"}
    assert volume(pieces) == pytest.approx(volume(supports(made("tower"))), rel=1e-9)
    for block in blocks:
        if not block.fixed and block.vertices[:, 2].min() < 1e-9:
            centre = block.vertices.mean(axis=0)[:2]
            ends = {name: (piece.vertices.min(axis=0)[:2], piece.vertices.max(axis=0)[:2]) for name, piece in pieces.items()}
            under = [name for name, (low, high) in ends.items() if (low < centre).all() and (centre < high).all()]
            assert [name.split(".")[1] for name in under] == [block.group]


def test_the_ground_under_buttresses_has_no_gap() -> None:
    ends = sorted(tuple(np.array([b.vertices[:, 0].min(), b.vertices[:, 0].max()])) for b in supports(made("arch")).values())
    assert ends[0][1] == ends[1][0] == 0.0


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("corner", "should be one of whole, corners, parts"),
        (4, "should be one of whole, corners, parts"),
        ({}, "give x or y"),
        ({"x": 1}, "should be 2 to 1000 strips"),
        ({"x": [1.0, 0.5]}, "should be places .m. that rise"),
        ({"x": [100.0]}, "no cut meets a support"),
        ({"z": 2}, "unknown key"),
        ("parts", "a single group stands on each support"),
    ],
)
def test_divisions_that_are_none_are_refused(asked: object, message: str) -> None:
    with pytest.raises(InputError, match=f"structure.foundations.*{message}"):
        made("wall", foundations=asked)


SCENE = """
[structure]
kind = "wall"
length = 2.0
height = 1.0
[material]
density = 1800.0
friction = 0.6
[[loads]]
kind = "settlement"
supports = ["ground*"]
displacement = 0.02
duration = 0.5
[run]
dt = 4e-3
duration = 0.6
tolerance = 1e-5
until_still = false
"""


def settled(folder: Path, *changes: str) -> tuple[dict[str, Any], int, list[str]]:
    """Summary of a wall whose support settles, the support that others are compared to, and the names of all blocks."""
    path = folder / "scene.toml"
    path.write_text(SCENE)
    summary = run_case(prepare(read_scene(path, changes)), folder / "out")
    with Results.open(folder / "out" / "result.h5") as results:
        return summary, results.support, [block.name for block in results.blocks]


def test_a_settlement_of_all_supports_is_warned_of(tmp_path: Path) -> None:
    summary, _, _ = settled(tmp_path, "run.duration=0.02")
    assert any("settlement moves the only support" in line and "structure.foundations" in line for line in summary.warnings)


def test_half_a_footing_settles_and_cracks_the_wall_relative_to_the_half_that_stays(tmp_path: Path) -> None:
    """The first support goes down: displacements are relative to the second, or the blocks that stay would seem to rise."""
    changes = ("structure.foundations={x=2}", 'loads[0].supports=["ground.x1"]')
    summary, support, names = settled(tmp_path, *changes)
    assert names[support] == "ground.x2"
    assert not any("settlement moves" in line for line in summary.warnings)
    assert summary.opening_max > 5e-3
    with Results.open(tmp_path / "out" / "result.h5") as results:
        last, first = results.position[results.frames - 1], results.position[0]
    foot = names.index("wall.1.1")
    assert last[foot, 2] - first[foot, 2] == pytest.approx(-0.02, abs=1e-3)
