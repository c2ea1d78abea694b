# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures of other blocks: as many more as their size says, in the same outline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from structures.variants import rebonded, refilled, resized

TABLES: list[dict[str, Any]] = [
    {"kind": "arch", "span": 4.0, "thickness": 0.4, "voussoirs": 15},
    {"kind": "aqueduct", "spans": 1},
    {
        "kind": "bridge",
        "spans": [
            {"span": 5.0, "rise": 1.5, "thickness": 0.4},
            {"span": 4.0, "rise": 3.0, "thickness": 0.4, "shape": "pointed", "rings": 2},
        ],
        "walls": {"thickness": 0.4},
        "abutments": [{"rigid": False}],
    },
    {"kind": "church", "block_length": 1.4, "windows": 0, "apse": False, "tower": False},
    {"kind": "column"},
    {"kind": "dome", "sides": 8},
    {"kind": "tower", "height": 10.0, "course_height": 0.8, "side": 4.0, "belfry_width": 0.0, "door_width": 0.0},
    {"kind": "vault", "voussoirs": 9},
    {"kind": "wall"},
]


def built(table: dict[str, Any]) -> tuple[int, float, float]:
    """How many blocks stand on the base, how much they weigh together, and how high they reach."""
    blocks = [block for block in structures.make(table, 2000.0, Path()).blocks if not block.fixed]
    corners = np.concatenate([block.vertices for block in blocks])
    return len(blocks), sum(volume(block.vertices) for block in blocks), float(corners[:, 2].max())


def volume(corners: np.ndarray) -> float:
    """Of the convex hull of corners."""
    from scipy.spatial import ConvexHull

    return float(ConvexHull(corners).volume)


@pytest.mark.parametrize("table", TABLES, ids=lambda table: str(table["kind"]))
def test_smaller_blocks_are_more_and_fill_the_same(table: dict[str, Any]) -> None:
    count, filled, high = built(table)
    small, large = (resized(table, factor) for factor in (0.7, 1.4))
    assert small is not None
    assert large is not None
    assert table == dict(table)  # the table that was given is left as it was
    more, same, as_high = built(small)
    assert more > 1.2 * count
    assert built(large)[0] < count
    assert same == pytest.approx(filled, rel=0.02)
    assert as_high == pytest.approx(high, rel=0.02)


def test_blocks_of_a_file_have_no_size() -> None:
    assert resized({"kind": "file", "path": "blocks.json"}, 0.7) is None
    assert rebonded({"kind": "file", "path": "blocks.json"}) == []


@pytest.mark.parametrize(
    ("table", "names"),
    [
        ({"kind": "tower", "height": 10.0, "course_height": 1.0, "belfry_width": 0.0}, ["straight joints where walls meet"]),
        ({"kind": "tower", "height": 10.0, "course_height": 1.0, "belfry_width": 0.0, "bonded": False}, ["bonded where walls meet"]),
        ({"kind": "vault", "voussoirs": 9}, ["straight joints between rings"]),
        ({"kind": "aqueduct", "spans": 1}, ["whole courses in piers"]),
        ({"kind": "wall", "leaves": 2}, ["half the through-stones"]),
        ({"kind": "wall", "noise": {"size": 1e-6, "seed": 4}}, ["other seed of the noise"]),
        ({"kind": "arch", "span": 4.0, "thickness": 0.4}, []),
        ({"kind": "bridge", "spans": [{"span": 5.0, "rise": 1.5, "thickness": 0.6, "rings": 3}]}, ["rings as one"]),
    ],
)
def test_other_bonds_are_other_blocks(table: dict[str, Any], names: list[str]) -> None:
    found = rebonded(table)
    assert [name for name, _ in found] == names
    first = structures.make(table, 2000.0, Path()).blocks
    for _, other in found:
        made = structures.make(other, 2000.0, Path()).blocks
        same = len(made) == len(first) and all(np.array_equal(a.vertices, b.vertices) for a, b in zip(made, first, strict=True))
        assert not same


def test_other_fills_are_the_same_blocks_under_other_assumptions() -> None:
    table = {
        "kind": "bridge",
        "spans": [{"span": 5.0, "rise": 1.5, "thickness": 0.4}],
        "fill": {"passive": 0.6},
        "walls": {"thickness": 0.4},
    }
    (first,) = structures.make(table, 2000.0, Path()).fills
    found = refilled(table)
    assert {about: [name for name, _ in some] for about, some in found.items()} == {
        "resistance": ["none", "twice"],
        "spread": ["2:1"],
        "pressure": ["active", "none"],
        "angle": ["25 degrees", "35 degrees"],
    }
    made = {about: [structures.make(other, 2000.0, Path()).fills[0] for _, other in some] for about, some in found.items()}
    assert [(fill.passive, fill.passive_shaken) for fill in made["resistance"]] == [(0.0, 0.0), (1.0, 0.6)]
    assert [fill.spread for fill in made["spread"]] == ["2:1"]
    assert [fill.coefficients[fill.pressure] for fill in made["pressure"]] == pytest.approx([1.0 / 3.0, 0.0])
    assert made["angle"][0].coefficients["passive"] < first.coefficients["passive"] < made["angle"][1].coefficients["passive"]
    assert refilled({"kind": "wall"}) == {}
    assert refilled({**table, "walls": None})["pressure"] == []
