# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of a building: units, arcs, and one line for each slip."""

from __future__ import annotations

import pytest

from masonry_cd.foundation.errors import InputError, parse_table
from structures.building.table import ArcTable, BuildingTable

WALL = {"name": "a", "axis": [[0.0, 0.0], [4.0, 0.0]], "thickness": 0.5, "height": 3.0}


def test_an_axis_has_points_and_arcs_with_units() -> None:
    axis = [[0, 0], ["300 cm", 0], {"to": [5, 2], "through": [4.4, 0.6]}]
    (wall,) = parse_table(BuildingTable, {"walls": [WALL | {"axis": axis, "thickness": "50 cm"}]}, "structure").walls
    assert wall.axis == ((0.0, 0.0), (3.0, 0.0), ArcTable(to=(5.0, 2.0), through=(4.4, 0.6)))
    assert wall.thickness == 0.5


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"thicknes": 1.0}, r'structure.walls\[0\].thicknes: unknown key \(did you mean "thickness"\?\)'),
        ({"name": "a.b"}, r"structure.walls\[0\].name"),
        ({"axis": [[0.0, 0.0]]}, r"structure.walls\[0\].axis"),
        ({"openings": [{"at": 1.0, "width": -1.0}]}, r"structure.walls\[0\].openings\[0\].width"),
    ],
)
def test_a_slip_is_one_line_that_names_the_key(keys: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_table(BuildingTable, {"walls": [WALL | keys]}, "structure")
