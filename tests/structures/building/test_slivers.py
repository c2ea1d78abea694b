# SPDX-License-Identifier: GPL-3.0-or-later
"""Corners of three walls at odd angles: no stone, and no part of one, is a sliver, and nothing is lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from plans import free_volume, prepare, volume_of_plan, wall
from shapely.geometry import Polygon
from solids import build
from statics3d import assembled, in_one_piece

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.building.footprints import BuildingPlan
from structures.building.widths import NARROW, fat_pieces, least_width, without_tails

LEAST_PART = 0.05  # width of a convex part, in thicknesses of the thinnest wall


def corner(seed: int) -> dict[str, Any]:
    """Three walls that end in one place: in any directions, or two of them nearly in line on both sides of the third."""
    random = np.random.default_rng(seed)
    thickness = random.uniform(0.4, 1.0, 3).round(3)
    if seed % 2:
        angles, back = random.uniform(0.0, 6.0) + 2.0 * np.pi / 3.0 * (np.arange(3) + random.uniform(-0.13, 0.13, 3)), np.zeros(3)
    else:
        first, bend, askew = random.uniform(0.0, 6.0), random.uniform(-0.3, 0.3), random.uniform(-0.5, 0.5)
        angles = first + np.array([0.0, 0.5 * np.pi + askew, 1.5 * np.pi + askew + bend])
        back = 0.15 * thickness[0] * np.array([0.0, 1.0, 1.0])
    out = np.column_stack([np.cos(angles), np.sin(angles)])
    height = [1.2, 1.2, random.choice([1.2, 1.8])]
    axes = np.stack([out * back[:, None], 4.0 * out], axis=1).tolist()
    walls = [wall(name, axis, float(t), float(h)) for name, axis, t, h in zip("abc", axes, thickness, height, strict=True)]
    return {"walls": walls, "course_height": 0.6, "block_length": 0.9}


def plan_of(vertices: np.ndarray) -> Polygon:
    return shapely.MultiPoint(vertices[:, :2]).convex_hull


def narrowest(blocks: list[Block]) -> tuple[float, float]:
    """Least width in plan of a stone, and of a convex part of one [m]."""
    stones, parts = [], []
    for block in blocks:
        if not block.fixed:
            plans = [plan_of(part.vertices) for part in block.convex_parts]
            parts += [least_width(np.array(plan.exterior.coords)[:-1]) for plan in plans]
            stones.append(2.0 * shapely.maximum_inscribed_circle(shapely.union_all(plans, grid_size=1e-8), 1e-3).length)
    return min(stones), min(parts)


@pytest.mark.parametrize("seed", range(12))
def test_a_corner_of_three_walls_has_no_slivers_and_keeps_its_volume(seed: int) -> None:
    keys = corner(seed)
    blocks = build("building", **keys)
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)
    assert in_one_piece(*assembled(blocks))
    thinnest = min(keys["walls"][k]["thickness"] for k in range(3))
    stone, part = narrowest(blocks)
    assert stone > NARROW * thinnest
    assert part > LEAST_PART * thinnest


def test_a_course_that_runs_out_over_a_crown_hangs_on_the_stones_above_each_its_own_piece() -> None:
    """The ring of a window in the facade of this church ends 1.2 mm below a bed: what the course over it has left lies under two stones."""
    size = {"length": 12.0, "width": 9.0, "height": 11.0, "thickness": 1.1}
    blocks = build("church", **size, block_length=0.85, course_height=0.325, aisles=True, bays=2, windows=1, tower=False, apse=False)
    assert min(least_extent(part) for block in blocks if block.group == "facade" for part in block.convex_parts) > 0.05


def least_extent(part: Polyhedron) -> float:
    """Least distance between two planes on both sides of a convex part, along the normal of a face [m]."""
    corners = [part.vertices[list(face[:3])] for face in part.faces]
    normals = np.array([np.cross(b - a, c - a) for a, b, c in corners])
    return float(np.ptp(part.vertices @ (normals / np.linalg.norm(normals, axis=1)[:, None]).T, axis=0).min())


def test_walls_whose_faces_cross_within_the_wall_between_them_leave_no_wedge() -> None:
    """A tower's wall and a chancel's on both sides of a nave's, 3.6 degrees out of line: their outer faces are 3.7 mm apart at most."""
    walls = [
        wall("nave", [[0.4, 0.5], [4.9, 0.66]], 0.995, 1.5),
        wall("chancel", [[4.66, 4.0], [4.89, 0.81]], 1.337, 1.5),
        wall("tower", [[5.05, 0.515], [5.17, -3.0]], 1.044, 2.25),
    ]
    blocks = build("building", walls=walls, block_length=1.5, course_height=0.75)
    stone, part = narrowest(blocks)
    assert stone > NARROW * 0.995
    assert part > LEAST_PART * 0.995
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare({"walls": walls, "course_height": 0.75})), rel=1e-9)


def test_a_top_that_steps_next_to_a_wall_at_an_angle_leaves_no_wedge() -> None:
    """The nave's wall goes on above its side walls, as one of a tower's, from where the other one begins; that one is out of square."""
    walls = [
        wall("nave", [[0, 0], [6, 0.2]], 0.9, top=[[0, 1.5], [3.53, 1.5], [3.53, 3.0], [6.003, 3.0]]),
        wall("tower", [[4, 0.133], [4, -3]], 0.9, 3.0),
    ]
    blocks = build("building", walls=walls, block_length=1.2, course_height=0.75)
    assert min(narrowest(blocks)) > NARROW * 0.9


def test_areas_that_meet_in_a_line_alone_are_no_less_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The remainder of a wall cut by another may come with lines of no width, which count for nothing."""
    keys = {"walls": [wall("a", [[0, 0], [4, 0]]), wall("b", [[2, 0], [2, 3]])]}
    plan: BuildingPlan = prepare(keys).plan
    whole = [shape.area for shape in plan.owned(1, 0, 0, 0.0, 0.3)]
    plan.areas.clear()
    difference = Polygon.difference
    monkeypatch.setattr(
        Polygon, "difference", lambda one, other: shapely.GeometryCollection([difference(one, other), shapely.LineString([[0, 0], [0, 1]])])
    )
    assert [shape.area for shape in plan.owned(1, 0, 0, 0.0, 0.3)] == whole


def test_tails_come_off_and_cuts_from_inner_corners_leave_wide_pieces() -> None:
    body = shapely.box(0, 0, 2, 1)
    tail = Polygon([(2, 0), (2.05, 0), (2, 0.9)])
    pieces = without_tails(body.union(tail).union(shapely.box(0.5, 1, 0.53, 1.4)), 0.1)
    assert sorted(round(piece.area, 6) for piece in pieces) == [0.012, 2.0225]  # a side that leans is not a tail
    assert without_tails(body, 0.1) == [body]
    bumped = Polygon([(0, 0), (2, 0), (2, 1), (1.2, 1), (1.2, 1.01), (0, 1.01)])
    assert min(least_width(piece) for piece in fat_pieces(bumped)) > 0.5


def test_stones_next_to_the_head_of_an_opening_are_cut_into_wide_parts() -> None:
    """A course that lies next to a door's arch and under a rose: cut from its inner corners, not into the triangles that fill it."""
    openings = [
        {"at": 2.5, "width": 1.1, "sill": 1.2, "height": 1.5, "shape": "round"},
        {"at": 5.0, "width": 1.1, "sill": 1.3, "height": 1.5, "shape": "round"},
    ]
    blocks = build("building", walls=[wall("a", [[0, 0], [7.5, 0]], 0.9, 4.5, openings=openings)], block_length=1.5, course_height=0.75)
    parts = [np.unique(part.vertices[:, [0, 2]].round(7), axis=0) for block in blocks if not block.fixed for part in block.convex_parts]
    hulls = [shapely.MultiPoint(part).convex_hull for part in parts]
    assert min(least_width(np.array(hull.exterior.coords)[:-1]) for hull in hulls) > 0.09
