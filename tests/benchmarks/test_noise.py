# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise on the corners of blocks: of the size asked for, the same for a seed, and of blocks that stay sound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from benchmarks.noise import noisy
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.geometry.checks import Shells, check_convex, check_shells

SIZE = 1e-6
STORED = ["-0x1.800003b0696b4p+0", "-0x1.999999999999ap-3", "0x1.ef3635db3966bp-22"]  # first corner of the second block of a wall, seed 7


@pytest.mark.parametrize("table", [{"kind": "tower"}, {"kind": "vault", "form": "cross", "voussoirs": 7}], ids=["tower", "vault"])
def test_each_block_moves_by_the_size_and_stays_sound(table: dict[str, Any]) -> None:
    exact = structures.build(table, 2000.0, Path())
    made = noisy(exact, SIZE)
    most = [np.linalg.norm(a.vertices - b.vertices, axis=1).max() for a, b in zip(made, exact, strict=True)]
    assert most == pytest.approx([SIZE] * len(most), rel=1e-6)
    check_shells(made)
    parts = [(i, part) for i, block in enumerate(made) for part in block.convex_parts]
    check_convex(made, Shells.of(parts), np.ones(len(parts), dtype=bool))
    for block in made:  # parts of one block go with it
        filled = sum(mass_properties(part.vertices, part.faces).volume for part in block.parts)
        assert not block.parts or filled == pytest.approx(mass_properties(block.vertices, block.faces).volume, rel=1e-12)


def test_a_seed_gives_the_same_bits_everywhere_and_axes_left_out_do_not_move() -> None:
    exact = structures.build({"kind": "wall"}, 2000.0, Path())
    first, other = (noisy(exact, SIZE, "xz", seed) for seed in (7, 8))
    assert [x.hex() for x in first[1].vertices[0].tolist()] == STORED
    assert first[1].vertices.tobytes() != other[1].vertices.tobytes()
    assert all(np.array_equal(a.vertices[:, 1], b.vertices[:, 1]) for a, b in zip(first, exact, strict=True))
