# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of a plan: all of them at once, a line each that names wall, junction and place."""

from __future__ import annotations

from typing import Any

import pytest
from plans import wall
from solids import build

from masonry_cd.foundation.errors import InputError

A = wall("a", [[0, 0], [6, 0]])
CASES: dict[str, tuple[list[dict[str, Any]], dict[str, Any], str]] = {
    "sharp angle": ([A, wall("b", [[1, 0], [6, 1]])], {}, "walls a and b: their strips overlap at x = .*at an angle of 11 degrees; none"),
    "sheet": ([A, wall("b", [[0, 0], [0, 3]]) | {"thickness": 5e-10}], {}, "wall b: its thickness, 5e-10 m, is less than 1 mm"),
    "stub": ([A, wall("b", [[3, -0.35], [3, 3]])], {}, "walls a and b at x = 3 m, y = 0 m: wall b sticks out 50 mm beyond the other"),
    "at a bend": (
        [wall("bent", [[0, 0], [3, 0], [6, 0.8]]), wall("b", [[3, 0], [3, 3]])],
        {},
        "walls bent and b at x = 3 m, y = 0 m: wall bent bends there",
    ),
    "opening over a corner": (
        [A | {"openings": [{"at": 0.7, "width": 0.8, "height": 1.5}]}, wall("b", [[0, 0], [0, 3]])],
        {},
        "opening o1 of wall a at 0.7 m: with its head it lies over the junction with wall b at x = 0 m, y = 0 m",
    ),
    "opening through the top": (
        [A | {"openings": [{"at": 3, "width": 1.0, "height": 2.3}]}],
        {},
        r"opening o1 of wall a at 3 m: with its head it reaches up to z = 2.6 m, the wall there to 2.4 m",
    ),
    "rose below the base": (
        [A | {"openings": [{"shape": "rose", "at": 3, "width": 1.0}]}],
        {},
        r"opening o1 of wall a at 3 m: with its ring it reaches down to z = -0\.\d+ m, the wall begins at 0 m",
    ),
    "column in a wall": (
        [A],
        {"columns": [{"at": [2.0, 0.2], "height": 2.0, "size": 0.4}]},
        "columns column1: the one at x = 2 m, y = 0.2 m stands in wall a",
    ),
    "opening beyond the wall": ([A | {"openings": [{"name": "door", "at": 7, "width": 1.0}]}], {}, "opening door of wall a at 7 m"),
    "openings over each other": (
        [A | {"openings": [{"at": 3, "width": 1.0, "height": 1.5}, {"at": 3.6, "width": 1.0, "height": 1.5}]}],
        {},
        "opening o2 of wall a at 3.6 m: with its head it overlaps opening o1 of wall a at 3 m, at x = 3.3",
    ),
    "rise of another shape": ([A | {"openings": [{"at": 3, "width": 1.0, "rise": 0.2}]}], {}, "a at 3 m: rise belongs to another shape"),
    "junction of walls that do not meet": (
        [A, wall("b", [[0, 3], [6, 3]])],
        {"junctions": [{"walls": ["a", "b"], "bond": "butt"}]},
        r"structure.junctions\[0\].walls: walls a and b do not meet",
    ),
    "no such wall": ([A], {"junctions": [{"walls": ["a", "x"]}]}, r'structure.junctions\[0\].walls: there is no wall "x"'),
    "courses that do not interlock": (
        [A, wall("b", [[0, 0], [0, 3]], course_height=0.25)],
        {},
        "walls a and b at x = 0 m, y = 0 m: courses of 0.3 and 0.25 m do not interlock",
    ),
    "control character": ([wall("a\x07b", [[0, 0], [3, 0]])], {}, r"structure.walls\[0\].name: should have no control characters"),
    "two names": ([A, A], {}, "wall a: another wall has this name, too"),
    "nothing under it": ([A, wall("b", [[0, 3], [6, 3]], base=1.2)], {}, "wall b: nothing is under it at x = 0 m, y = 3 m"),
    "no height": ([{"name": "a", "axis": [[0, 0], [3, 0]], "thickness": 0.5}], {}, "wall a: give height, or top"),
    "turns back": ([wall("a", [[0, 0], [3, 0], [0, 0.1]])], {}, "wall a: its axis turns back by 178 degrees at x = 3 m, y = 0 m"),
    "arc in line": ([wall("a", [[0, 0], {"to": [3, 0], "through": [1, 0]}])], {}, "wall a: its arc from x = 0 m, y = 0 m passes through"),
    "masonry unknown": ([A | {"masonry": "cheese"}], {}, 'wall a: masonry "cheese" is none of'),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_fault_is_a_line_that_names_wall_junction_and_place(case: str) -> None:
    walls, keys, said = CASES[case]
    with pytest.raises(InputError, match=said) as failure:
        build("building", walls=walls, **keys)
    assert "\n" not in str(failure.value)
