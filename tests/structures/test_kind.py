# SPDX-License-Identifier: GPL-3.0-or-later
"""Statements of a kind: blocks of another size fill the same outline, other bonds are other blocks, other fills the same."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from structures import kind_of

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
    """Return the volume of the convex hull of corners."""
    from scipy.spatial import ConvexHull

    return float(ConvexHull(corners).volume)


@pytest.mark.parametrize("table", TABLES, ids=lambda table: str(table["kind"]))
def test_smaller_blocks_are_more_and_fill_the_same(table: dict[str, Any]) -> None:
    count, filled, high = built(table)
    resized = kind_of(table["kind"]).resized
    assert resized is not None
    given = copy.deepcopy(table)
    small, large = (resized(table, factor) for factor in (0.7, 1.4))
    assert table == given
    more, same, as_high = built(small)
    assert more > 1.2 * count
    assert built(large)[0] < count
    assert same == pytest.approx(filled, rel=0.02)
    assert as_high == pytest.approx(high, rel=0.02)


def test_blocks_of_a_file_have_no_size_and_no_bond() -> None:
    assert kind_of("file").resized is None
    assert kind_of("file").bonds({"kind": "file", "path": "blocks.json"}) == {}


@pytest.mark.parametrize(
    ("table", "names"),
    [
        ({"kind": "tower", "height": 10.0, "course_height": 1.0, "belfry_width": 0.0}, ["straight joints where walls meet"]),
        ({"kind": "tower", "height": 10.0, "course_height": 1.0, "belfry_width": 0.0, "bonded": False}, ["bonded where walls meet"]),
        ({"kind": "vault", "voussoirs": 9}, ["straight joints between rings"]),
        ({"kind": "aqueduct", "spans": 1}, ["whole courses in piers"]),
        ({"kind": "wall", "leaves": 2}, ["half the through-stones"]),
        ({"kind": "arch", "span": 4.0, "thickness": 0.4}, []),
        ({"kind": "bridge", "spans": [{"span": 5.0, "rise": 1.5, "thickness": 0.6, "rings": 3}]}, ["rings as one"]),
    ],
)
def test_other_bonds_are_other_blocks(table: dict[str, Any], names: list[str]) -> None:
    found = kind_of(table["kind"]).bonds(table)
    assert list(found) == names
    first = structures.make(table, 2000.0, Path()).blocks
    for keys in found.values():
        made = structures.make(table | keys, 2000.0, Path()).blocks
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
    assumptions = kind_of("bridge").assumptions
    found = {name: dict(assume(table, True)) for name, assume in assumptions.items()}
    assert {name: list(some) for name, some in found.items()} == {
        "fill resistance": ["none", "twice"],
        "fill spread": ["2:1"],
        "fill pressure": ["active", "none"],
        "fill angle": ["25 degrees", "35 degrees"],
    }
    made = {name: [structures.make(table | keys, 2000.0, Path()).fills[0] for keys in some.values()] for name, some in found.items()}
    assert [(fill.passive, fill.passive_shaken) for fill in made["fill resistance"]] == [(0.0, 0.0), (1.0, 0.6)]
    assert [fill.spread for fill in made["fill spread"]] == ["2:1"]
    assert [fill.coefficients[fill.pressure] for fill in made["fill pressure"]] == pytest.approx([1.0 / 3.0, 0.0])
    loose, dense = (fill.coefficients["passive"] for fill in made["fill angle"])
    assert loose < first.coefficients["passive"] < dense
    assert isinstance(assumptions["fill spread"](table, False), str)  # why it is not varied
    assert isinstance(assumptions["fill pressure"]({**table, "walls": None}, False), str)
