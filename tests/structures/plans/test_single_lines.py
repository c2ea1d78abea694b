# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans in single lines, one for each wall, are no plans in faces; those in faces draw no word."""

from __future__ import annotations

from pathlib import Path

import pytest
from drawings import Drawing

from masonry_cd.foundation.errors import InputError
from structures.plans.keys import LayersTable, PlanKeys

ROOMS = {"KITCHEN": (7.0, 1.5), "CORRIDOIO": (4.0, 3.7), "BAGNO 5.2 m2": (4.6, 5.7)}


def rooms(drawing: Drawing, names: bool) -> None:
    """A house of six rooms about a corridor."""
    drawing.lines((0, 0), (10, 0), (10, 7), (0, 7), (0, 0))
    for a, b in (((0, 3), (10, 3)), ((0, 4.4), (10, 4.4)), ((5, 0), (5, 3)), ((4, 4.4), (4, 7)), ((6, 4.4), (6, 7))):
        drawing.lines(a, b)
    for words, place in ROOMS.items() if names else ():
        drawing.text(words, place, "TEXT")


def cells(drawing: Drawing, names: bool) -> None:
    """A row of cells so narrow that all lines pair."""
    for k in range(6):
        drawing.lines((2.0 * k, 0), (2.0 * k, 4.0))
    if names:
        drawing.text("CAMERA", (2.6, 2.0), "TEXT")


@pytest.mark.parametrize(("draw", "names"), [(rooms, True), (rooms, False), (cells, True)])
def test_single_lines_are_refused_with_the_remedy(tmp_path: Path, draw, names: bool) -> None:
    drawing = Drawing()
    draw(drawing, names)
    found = drawing.plan(tmp_path)
    assert set(found.faults) == {wall["name"] for wall in found.tables["walls"]}
    assert all("structure.layers.axes" in fault.text and "structure.wall_thickness" in fault.text for fault in found.faults.values())


def test_walls_that_are_all_as_wide_as_rooms_are_doubted_first(tmp_path: Path) -> None:
    drawing = Drawing()
    cells(drawing, False)
    assert "structure.layers.axes" in drawing.plan(tmp_path).notes[0]


def test_where_no_lines_pair_the_remedy_is_named(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.lines((0, 0), (10, 0), (10, 7), (0, 7), (0, 0))
    with pytest.raises(InputError, match=r"no wall comes out.*structure\.layers\.axes"):
        drawing.plan(tmp_path)


def test_the_remedy_makes_walls_of_them(tmp_path: Path) -> None:
    drawing = Drawing()
    rooms(drawing, True)
    keys = PlanKeys(wall_height=3.0, wall_thickness=0.4, layers=LayersTable(axes=("WALLS",), walls=("NONE",)))
    plan = drawing.plan(tmp_path, keys)
    assert {wall["thickness"] for wall in plan.tables["walls"]} == {0.4}
    assert not any("single lines" in note for note in plan.notes)


def test_faces_with_names_of_rooms_between_them_are_walls(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.box((0, 0), (8, 6))
    drawing.box((0.5, 0.5), (7.5, 5.5))
    drawing.text("SALA", (3, 3), "TEXT")
    drawing.lines((1, 8), (3, 8))  # a stray one
    plan = drawing.plan(tmp_path)
    assert len(plan.tables["walls"]) == 4
    assert not any("single lines" in note for note in plan.notes)
