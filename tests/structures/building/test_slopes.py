# SPDX-License-Identifier: GPL-3.0-or-later
"""Two tops that slope or step in one junction: each wall fills what lies under the higher of the two; heads that have little space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from plans import free_volume, prepare, volume_of_plan, wall
from solids import build
from statics3d import assembled, in_one_piece

from masonry_cd.foundation.gmsh_session import gmsh_session
from structures.building.engine import Walls
from structures.geometry.polygons import loop

GABLE = [[0, 1.6], [2, 2.3], [4, 1.6]]
PAIRS: dict[str, list[dict[str, Any]]] = {
    "corner, both rise": [wall("a", [[0, 0], [4, 0]], top=[[0, 1], [4, 2]]), wall("b", [[0, 0], [0, 4]], top=[[0, 1], [4, 2.2]])],
    "corner, one rises": [wall("a", [[0, 0], [4, 0]], top=[[0, 1], [4, 2]]), wall("b", [[0, 4], [0, 0]], top=[[0, 1], [4, 2.2]])],
    "ridges that cross": [wall("a", [[0, 0], [4, 0]], top=GABLE), wall("b", [[2, -2], [2.3, 2]], top=[[0, 1.5], [2, 2.4], [4, 1.5]])],
    "a gable on a slope": [wall("a", [[0, 0], [4, 0]], top=GABLE), wall("b", [[1, 0], [1.2, 3]], top=[[0, 2.1], [1.5, 1.7], [3, 2.1]])],
    "steps": [wall("a", [[0, 0], [4, 0]], top=[[0, 1.4], [2, 1.4], [2, 2], [4, 2]]), wall("b", [[2, 0], [2, 3]], top=[[0, 1.6], [3, 1.9]])],
}  # fmt: skip

OTHER_COURSES: dict[str, list[dict[str, Any]]] = {
    "lower": [wall("a", [[0, 0], [4, 0]], height=2.4), wall("b", [[2, 0], [2, 3]], height=3.0, course_height=0.25)],
    "a gable": [wall("a", [[0, 4], [-4, 8]], top=[[0, 4.2], [2.6, 5.2], [5.6, 3.2]]), wall("b", [[-4, 8], [2, 10]], course_height=0.25)],
    "on another": [
        wall("a", [[0, 0], [4, 0]]),
        wall("c", [[2, 0], [2, 3]], height=1.1),
        wall("b", [[2, 0], [2, 3]], base=1.1, course_height=0.25),
    ],
}


def volume_by_kernel(walls: Walls) -> float:
    """Return the volume of the union of straight walls, each under its top and drawn out at junctions, by the geometry kernel [m3]."""
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ

        def prism(ring: np.ndarray, along: Sequence[float]) -> tuple[int, int]:
            points = [occ.addPoint(*p) for p in ring.tolist()]
            lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
            made = occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], *along)
            return next(body for body in made if body[0] == 3)

        bodies = []
        for k, leg in enumerate(walls.plan.legs):
            (facet,), shape = leg.facets, walls.plan.shape(k, 0)
            left, _, right, _ = shape.bounds
            profile = [(left, 0.0), (right, 0.0), *reversed(leg.tops_between(facet, left, right))]
            side = np.array([[*facet.place(np.array([s, -leg.thickness])), z] for s, z in profile])
            plan = np.column_stack([facet.place(loop(shape)), np.zeros(len(loop(shape)))])
            both = occ.intersect([prism(side, [*(2.0 * leg.thickness * facet.left), 0.0])], [prism(plan, [0.0, 0.0, 9.0])])
            bodies += both[0]
        return float(sum(occ.getMass(*body) for body in occ.fuse(bodies[:1], bodies[1:])[0]))


@pytest.mark.parametrize("case", PAIRS)
def test_two_slopes_in_one_junction_are_filled_exactly(case: str) -> None:
    keys = {"walls": PAIRS[case], "block_length": 0.7, "course_height": 0.35}
    blocks = build("building", **keys)
    assert free_volume(blocks) == pytest.approx(volume_by_kernel(prepare(keys)), rel=1e-9)
    assert in_one_piece(*assembled(blocks))


@pytest.mark.parametrize("case", OTHER_COURSES)
def test_walls_of_other_courses_in_a_straight_joint_are_filled_exactly(case: str) -> None:
    keys = {"walls": OTHER_COURSES[case], "junction": "butt"}
    assert free_volume(build("building", **keys)) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)


def test_a_gable_falls_to_both_far_faces_where_its_last_place_is_a_hair_short_of_the_end() -> None:
    walls = [
        wall("a", [[0, 0], [4, 0]], top=[[0, 1.6], [2, 2.6], [3.9996, 1.6]]),
        wall("b", [[0, 0], [0, 3]], height=1.2),
        wall("c", [[4, 0], [4, 3]], height=1.2),
    ]
    (leg,) = [leg for leg in prepare({"walls": walls}).plan.legs if leg.keys.name == "a"]
    assert [leg.top(leg.facets[0], s) for s in (-0.3, 4.3)] == pytest.approx([1.45, 1.45], abs=5e-4)


def test_a_head_without_a_measure_of_its_own_fits_the_masonry_that_there_is() -> None:
    """The lintel of a door near a corner and under the top of its wall is as high and long as it can be."""
    door = {"name": "door", "at": 0.98, "width": 1.0, "height": 2.2}
    walls = [wall("a", [[0, 0], [4, 0]], 0.5, openings=[door]), wall("b", [[0, 0], [0, 3]], 0.5)]
    (lintel,) = [block for block in build("building", walls=walls, block_length=0.9) if ".o1.l" in block.name]
    assert np.ptp(lintel.vertices, axis=0) == pytest.approx([1.0 + 2.0 * (0.98 - 0.5 - 0.25 - 0.05), 0.5, 0.2])
