# SPDX-License-Identifier: GPL-3.0-or-later
"""The six dry walls of Ferris & Tin-Loi (Int. J. Mech. Sci. 43, 2001): units of 0.4 x 0.175 m, friction 0.65.

A row lists lengths in units from the left, an opening as a negative one; rows from the bottom. ``ASSOCIATED`` are factors of a horizontal
body force by a linear programme, ``LEAST`` those published for sliding without dilation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import box

FRICTION, DENSITY = 0.65, 2000.0
LENGTH, HEIGHT = 0.4, 0.175
ASSOCIATED = {1: 0.64286, 2: 0.58000, 3: 0.40369, 4: 0.33195, 5: 0.23964, 6: 0.34782}
LEAST = {2: 0.563, 3: 0.356, 4: 0.264, 5: 0.215, 6: 0.297}

_LONG, _SHORT = [0.5, 1, 1, 1, 1, 0.5], [1] * 5
_FOUR, _HALVES = [1] * 4, [0.5, 1, 1, 1, 0.5]
_DOOR_A, _DOOR_B = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
_PIERS_A, _PIERS_B = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
_THREE, _ENDS = [1] * 3, [0.5, 1, 1, 0.5]
_SLIT: list[list[float]] = [[1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5], [1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5], [1, -1, 1]]
_SEVEN, _SEVEN_ENDS = [1] * 7, [0.5, 1, 1, 1, 1, 1, 1, 0.5]
_PAIR_A, _PAIR_B = [0.5, 1, -1, 1, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1, 0.5, -1, 0.5, 1]
_PAIR: list[list[float]] = [_PAIR_A, _PAIR_B, _PAIR_A, _PAIR_B, _PAIR_A]
ROWS: dict[int, Sequence[Sequence[float]]] = {
    1: [_LONG, _SHORT] * 3,
    2: [_LONG, _SHORT] * 5,
    3: [_FOUR, _HALVES, _FOUR, _DOOR_A, _DOOR_B, _DOOR_A, _DOOR_B, _DOOR_A, _FOUR, _HALVES, _FOUR],
    4: [_LONG, _SHORT, _LONG, _PIERS_A, _PIERS_B, _PIERS_A, _PIERS_B, _PIERS_A, _LONG, _SHORT, _LONG],
    5: [_ENDS, _THREE, _ENDS, *_SLIT, _ENDS, _THREE, _ENDS, *_SLIT, _ENDS, _THREE, _ENDS],
    6: [_SEVEN_ENDS, _SEVEN, _SEVEN_ENDS, _SEVEN, *_PAIR, _SEVEN, _SEVEN_ENDS, _SEVEN, *_PAIR, _SEVEN, _SEVEN_ENDS, _SEVEN, _SEVEN_ENDS],
}


def dry_wall(number: int) -> list[Block]:
    """The blocks of a wall on a fixed plate."""
    blocks = [Block("ground", *box((-5.0, -5.0, -1.0), (5.0, 5.0, 0.0)), DENSITY, "base", fixed=True)]
    for course, row in enumerate(ROWS[number]):
        edges = LENGTH * np.concatenate([[0.0], np.cumsum(np.abs(row))])
        for k, unit in enumerate(row):
            if unit > 0:
                low, high = (edges[k], -0.1, HEIGHT * course), (edges[k + 1], 0.1, HEIGHT * (course + 1))
                blocks.append(Block(f"c{course}.{k}", *box(low, high), DENSITY))
    return blocks
