# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/level.py with analysis/limit/held.py: the height of the lines at which a mechanism is held, above the foundation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import box, ground

from masonry_cd.analysis.code_check.level import foundation_of, level_of
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.held import held_at
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.foundation.errors import InputError, parse_table

HINGE, SLIDE = STATES.index("hinge"), STATES.index("slide")
BUILDING = {"building_height": 8.0, "building_period": 0.3, "storeys": 2}


def pushed(blocks, mu=0.6):
    """The mechanism of a push along x, with blocks and joints."""
    assembly, joints = joined(blocks, mu)
    return (
        analyse(assembly, joints, push_loads(assembly, (1.0, 0.0, 0.0)), LimitOptions(starts=0)).collapse(joints.count).mechanism,
        assembly,
        joints,
    )


def test_a_slab_is_held_at_its_foot_or_on_what_stands_still() -> None:
    slab = box("slab", (0.0, 0.0, 0.0), (0.5, 2.0, 3.0))
    assert held_at(*pushed([ground(8.0), slab])) == pytest.approx(0.0, abs=1e-9)
    base = box("base", (0.0, 0.0, 0.0), (2.0, 2.0, 1.0))
    assert held_at(*pushed([ground(8.0), base, box("slab", (0.8, 0.0, 1.0), (1.2, 2.0, 3.0))])) == pytest.approx(1.0)


def test_what_slides_is_held_at_its_lowest_point() -> None:
    moves, *structure = pushed([ground(8.0), box("slab", (0.0, 0.0, 0.0), (2.0, 2.0, 0.5))], mu=0.2)
    assert moves.state[0] == SLIDE and held_at(moves, *structure) == pytest.approx(0.0)


def test_lines_count_by_their_length() -> None:
    """A slab with one line of 2 m at its foot, and another of 1 m at a ledge 1.5 m up: Z = 0.5 m."""
    ledge = box("ledge", (0.5, 0.0, 1.0), (1.0, 1.0, 1.5), fixed=True)
    moves, assembly, joints = pushed([ground(8.0), box("slab", (0.0, 0.0, 0.0), (0.5, 2.0, 3.0)), ledge])
    slab, turned = assembly.names.index("slab"), np.zeros((assembly.count, 6))
    turned[slab, 4] = 1.0
    hinge = np.array([[0.5, 1.0, 0.0] if abs(n[2]) > 0.5 else [0.5, 0.5, 1.5] for n in joints.normal])
    between = (joints.block_a == slab) | (joints.block_b == slab)
    both = replace(
        moves, velocity=turned, speed=np.arange(assembly.count) == slab, hinge=hinge, state=np.where(between, HINGE, 0)
    )  # fmt: skip
    assert held_at(both, assembly, joints) == pytest.approx((2.0 * 0.0 + 1.0 * 1.5) / 3.0)


@pytest.mark.parametrize(
    ("line", "keys", "height", "counted", "doubted"),
    [
        (0.3, {}, 0.3, 0.0, False), (3.0, {}, 3.0, 0.0, True), (3.0, BUILDING, 3.0, 3.0, False),
        (0.0, BUILDING | {"foundation": -6.0}, 6.0, 6.0, False), (0.0, BUILDING | {"height": 6.0}, 6.0, 6.0, False),
        (1.0, BUILDING | {"height": 6.0}, 6.0, 6.0, True),
    ],
)  # fmt: skip
def test_the_height_counts_from_the_foundation(line: float, keys: dict, height: float, counted: float, doubted: bool) -> None:
    table = parse_table(CheckTable, {"spectrum": "EC8", "ag": 1.0} | keys, "limit.check")
    assembly, _ = joined([ground(8.0), box("slab", (0.0, 0.0, 0.0), (0.5, 2.0, 3.0))], 0.6)
    level = level_of(table, line, foundation_of(table, assembly))
    assert (level.height, level.counted, bool(level.doubt)) == (height, counted, doubted)


def test_a_foundation_above_the_lowest_block_is_refused() -> None:
    table = parse_table(CheckTable, {"spectrum": "EC8", "ag": 1.0, "foundation": 2.0} | BUILDING, "limit.check")
    with pytest.raises(InputError, match=r"limit\.check\.foundation"):
        foundation_of(table, joined([ground(8.0), box("slab", (0.0, 0.0, 0.0), (0.5, 2.0, 3.0))], 0.6)[0])
