# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns: frusta on each other."""

from __future__ import annotations

import math

import pytest
from solids import build, free_volume, moved_at_rest
from statics3d import assembled, can_stand, in_one_piece

from masonry_cd.foundation.errors import InputError


def frustum(sides: int, low: float, high: float, height: float) -> float:
    """Volume of a frustum of a regular pyramid with its corners on two circles [m3]."""
    area = 0.5 * sides * math.sin(2.0 * math.pi / sides)
    return area * height * (low**2 + low * high + high**2) / 3.0


def test_blocks_fill_plinth_shaft_and_capital() -> None:
    blocks = build("column", height=5.0, diameter=0.8, top_diameter=0.6, plinth=0.25, capital=0.5, width=1.0, sides=16)
    exact = 0.25 * 1.0 + frustum(16, 0.4, 0.3, 4.25) + frustum(16, 0.3, 0.49, 0.3) + 0.2 * 1.0
    assert free_volume(blocks) == pytest.approx(exact, rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    assert joints.count == len(blocks) - 1
    assert sorted(joints.area)[0] == pytest.approx(0.5 * 16 * math.sin(math.pi / 8) * 0.3**2)  # under the capital


def test_a_single_drum_without_plinth_and_capital() -> None:
    blocks = build("column", drums=1, plinth=0.0, capital=0.0, height=2.0)
    assert [b.name for b in blocks] == ["drum1", "ground"]


def test_it_stands_until_the_push_reaches_the_edge_of_its_foot() -> None:
    blocks = build("column", plinth=0.0, capital=0.0, top_diameter=0.9, diameter=0.9, height=6.0, sides=12)
    assert can_stand(blocks, mu=0.6)
    assert moved_at_rest(blocks) < 1e-6
    reach = 0.45 * math.cos(math.pi / 12) / 3.0  # half the width over the height of the centre of mass
    assert can_stand(blocks, mu=0.6, push=(0.99 * reach, 0.0, 0.0))
    assert not can_stand(blocks, mu=0.6, push=(1.01 * reach, 0.0, 0.0))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"top_diameter": 1.0}, "structure.top_diameter: must be at most the diameter, 0.9 m, got 1"),
        ({"width": 0.5}, "structure.width: must be at least the diameter, 0.9 m, got 0.5"),
        ({"height": 0.7}, "structure.height: must exceed plinth and capital, 0.8 m, got 0.7"),
        ({"sides": 3}, "structure.sides: input should be greater than or equal to 4"),
    ],
)
def test_wrong_keys_are_named_in_one_line(keys: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as failure:
        build("column", **keys)
    assert str(failure.value).startswith(message)
