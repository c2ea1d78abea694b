"""Walls of a plan: every corner filled, joints exact, interlocked, standing."""

from __future__ import annotations

from typing import Any

import pytest
from plans import free_volume, prepare, volume_of_plan, wall
from solids import build
from statics3d import assembled, in_one_piece

CLOSED = [[0, 0], [4, 0], [4.6, 3.2], [0, 3.5], [0, 0]]
CASES: dict[str, dict[str, Any]] = {
    "square of four walls": {
        "walls": [
            wall("s", [[0, 0], [4, 0]]),
            wall("e", [[4, 0], [4, 3]], 0.5),
            wall("n", [[4, 3], [0, 3]], height=2.1),
            wall("w", [[0, 3], [0, 0]]),
        ]
    },
    "one wall out of square": {"walls": [wall("ring", CLOSED)]},
    "T at an angle": {"walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[2.5, 0], [4, 2.5]], 0.4, 1.8)]},
    "X at an angle": {"walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[1.5, -2], [3.5, 2]], 0.4, 3.0)]},
    "three walls in one place": {
        "walls": [wall("a", [[0, 0], [2.5, 0]]), wall("c", [[2.5, 0], [5, 0]], 0.5), wall("b", [[2.5, 0], [3, 2.5]], 0.5, 1.8)]
    },
    "butt and a share": {
        "walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[0, 0], [0.8, 2.5]]), wall("c", [[5, 0], [5, 2.5]])],
        "junctions": [{"walls": ["b", "a"], "bond": "butt"}, {"walls": ["a", "c"], "bond": 0.5}],
    },
    "gable between side walls": {
        "walls": [
            wall("facade", [[0, 0], [5, 0]], top=[[0, 2], [2.5, 3.2], [5, 2]], openings=[{"at": 2.5, "width": 0.9, "height": 1.6}]),
            wall("south", [[0, 0], [0, 2]], height=2.0),
            wall("north", [[5, 0], [5, 2]], height=2.0),
        ]
    },
    "stepped and sloping top": {
        "walls": [
            wall("a", [[0, 0], [2, 0], [4, 0.4]], top=[[0, 1.5], [1.4, 1.5], [1.4, 2.1], [3.2, 2.6], [4, 2.6]]),
            wall("b", [[0, 0], [0, 2]]),
        ]
    },
    "arc on a wall": {
        "walls": [
            wall("east", [[-3.2, 0], [3.2, 0]], 0.6),
            wall("apse", [[-2, 0], {"to": [2, 0], "through": [0, 2]}], 0.5, 2.1,
                 openings=[{"at": 3.14159, "width": 0.5, "sill": 0.6, "height": 0.9, "shape": "round"}]),
        ]
    },
    "round tower": {"walls": [wall("tower", [[2, 0], {"to": [2, 0], "through": [-2, 0]}], 0.6, 2.4)]},
    "tower on a corner": {
        "walls": [wall("s", [[0, 0], [4, 0]], height=4.2), wall("w", [[0, 0], [0, 2.5]], height=4.2), wall("e", [[4, 0], [4, 2.5]]),
                  wall("in", [[0, 2.5], [2.2, 2.5]], height=4.2), wall("mid", [[2.2, 2.5], [2.2, 0]], height=4.2)]
    },
    "heights between beds, irregular": {
        "bond": "irregular",
        "walls": [wall("a", [[0, 0], [4, 0]], height=2.45), wall("b", [[4, 0], [4, 2]], height=2.37)],
    },
    "rubble": {"bond": "rubble", "seed": 3, "walls": [wall("a", [[0, 0], [4, 0]]), wall("b", [[4, 0], [5, 2]])]},
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_blocks_fill_the_walls_of_the_plan_and_hang_together(case: str) -> None:
    keys = CASES[case]
    blocks = build("building", **keys)  # checked: closed, convex or of convex parts, apart
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
