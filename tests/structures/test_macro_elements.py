# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.macro_elements: the parts that practice looks at, by kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from masonry_cd.mechanics.model.blocks import Block
from structures import KINDS
from structures.kinds import church, tower, vault, wall
from structures.macro_elements import MacroElement, macro_elements
from structures.macro_elements.layout import BlockLayout

CHURCH = {
    "block_length": 1.6, "course_height": 0.65, "length": 18.0, "width": 8.0, "height": 8.0, "thickness": 0.9, "gable": 2.6,
    "apse_radius": 2.8, "apse_height": 5.2, "tower_height": 16.0,
}  # fmt: skip


def parts(kind: str, blocks: list[Block]) -> dict[str, MacroElement]:
    """Return the parts by name."""
    found = macro_elements(blocks, KINDS[kind].parts)
    assert len({one.name for one in found}) == len(found)
    fixed = np.array([block.fixed for block in blocks])
    for one in found:
        assert len(one.blocks) and not fixed[one.blocks].any()
        assert all(abs(np.hypot(x, y) - 1.0) < 1e-9 and z == 0.0 for x, y, z in one.directions)
    return {one.name: one for one in found}


def test_a_church_has_the_parts_that_practice_names() -> None:
    blocks = church.build(CHURCH, 1900.0, Path())
    found = parts("church", blocks)
    for name in (
        "facade",
        "facade, upper part",
        "facade, gable",
        "nave wall south",
        "triumphal arch, in its plane",
        "apse",
        "bell tower",
        "belfry",
    ):
        assert name in found, name
    assert {one.kind for one in found.values()} >= {"corner", "piers", "spandrels", "half dome"}
    low = np.array([block.vertices[:, 2].min() for block in blocks])
    assert low[found["facade, gable"].blocks].min() >= 7.8 - 1e-6  # the eaves lie on a whole course
    assert low[found["belfry"].blocks].min() > 10.0
    assert found["facade"].directions == ((-1.0, 0.0, 0.0),)
    assert set(found["nave wall south"].directions) == {(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)}  # inwards too
    assert set(found["triumphal arch"].directions) == {(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)}
    assert set(found["facade, gable"].blocks) < set(found["facade, upper part"].blocks) < set(found["facade"].blocks)


def test_openings_are_read_from_the_stones_and_part_the_piers() -> None:
    table = {
        "length": 8.0, "height": 4.0, "course_height": 0.25,
        "openings": [{"centre": c, "width": 1.0, "height": 1.5, "sill": 1.0, "head": "lintel"} for c in (-2.0, 2.0)],
    }  # fmt: skip
    blocks = wall.build(table, 1900.0, Path())
    first, second = BlockLayout.of(blocks).holes("wall")
    assert (first.start, first.end, first.sill, first.head) == pytest.approx((-2.5, -1.5, 1.0, 2.5), abs=1e-6)
    assert second.start == pytest.approx(1.5, abs=1e-6)
    found = parts("wall", blocks)
    piers = found["wall, piers 1"].piers
    assert len(piers) == 3
    middle = [np.mean([blocks[b].vertices[:, 0].mean() for b in pier]) for pier in piers]
    assert middle == sorted(middle) and middle[1] == pytest.approx(0.0, abs=0.2)
    assert "wall, spandrels" in found and "wall, in its plane" in found


def test_a_tower_has_walls_corners_and_a_belfry() -> None:
    table = {"side": 5.0, "height": 12.0, "thickness": 0.8, "course_height": 0.5}
    found = parts("tower", tower.build(table, 1900.0, Path()))
    assert {"tower", "south wall", "belfry", "corner south-west"} <= set(found)
    assert len(found["tower"].directions) == 4


def test_a_kind_that_names_no_parts_has_its_groups() -> None:
    blocks = tower.build({"side": 4.0, "height": 6.0, "thickness": 0.8, "course_height": 0.5, "belfry_width": 0.0}, 1900.0, Path())
    assert {"south", "east", "north", "west"} == set(parts("file", blocks))


def test_vaults_and_parapets_are_parts() -> None:
    assert set(parts("vault", vault.build({"form": "barrel", "span": 3.0, "length": 2.0, "thickness": 0.4}, 1900.0, Path()))) == {"vault"}
    cross = parts("vault", vault.build({"form": "cross", "span": 4.0, "thickness": 0.5}, 1900.0, Path()))
    assert "vault" in cross and {one.kind for one in cross.values()} == {"vault", "web"}
    assert "nave vault" in parts("church", church.build(CHURCH | {"roof": "vault"}, 1900.0, Path()))
    walls = [  # the upper courses of a wall
        replace(b, group="parapet" if b.vertices[:, 2].min() > 3.0 else b.group)
        for b in wall.build({"length": 4.0, "height": 4.0}, 1900.0, Path())
    ]
    found = parts("file", walls)["parapet"]
    assert found.kind == "parapet" and {way[0] for way in found.directions} == {0.0}
