# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts of a drawn structure: what is left has the right area and place, for convex and other blocks."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from made_run import at_rest, box, turned, write_run
from pictures import crack_map, model_area, opening_scale, pixels, shares

from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import loop_area
from reports.drawing.bands import DrawnJoints
from reports.drawing.cut import Cut, caps_of, clipped, clipped_lines, clipped_ties, cut_named, traces
from reports.drawing.parts import Lines, Surface, Ties, view_named
from reports.drawing.solids import block_layers
from reports.maps.framing import MapStyle

BASE = box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True)
STACK = [BASE, *(box(f"s{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(3))]
FRONT, SIDE, ISOMETRIC = (view_named(name) for name in ("front", "side", "isometric"))


def areas(points: np.ndarray, loops: np.ndarray, start: np.ndarray) -> list[float]:
    return [loop_area(points[loops[a:b]]) for a, b in pairwise(start)]


def faces(solids: Solids) -> Surface:
    """The faces of blocks as built."""
    surface = block_layers(solids, solids.vertices, np.ones((len(solids.centre), 3)))[0]
    assert isinstance(surface, Surface)
    return surface


def test_a_cut_keeps_what_lies_behind_it_and_closes_the_blocks() -> None:
    solids = Solids.from_blocks(STACK)
    cut = cut_named("y=0.2", solids, FRONT)
    assert cut_named("y = 20 cm", solids, FRONT).value == cut.value == 0.2
    caps = caps_of(faces(solids), cut)
    assert caps.owner is not None and caps.owner.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(areas(caps.points, caps.loops, caps.loop_start), [4 * 0.5, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(caps.points[:, 1], 0.2)
    white = np.full((len(solids.face_block), 3), 255, np.uint8)
    left = clipped(Surface(solids.vertices, solids.loops, solids.loop_start, white), cut)
    assert left.points[:, 1].min() == pytest.approx(0.2)
    skin = 4 * (0.5 + 2 * 0.8) + 2 * 0.5 * 0.8 + 3 * (1.0 + 4 * 0.3)  # base: back, top and bottom, two sides; each stone likewise
    assert sum(areas(left.points, left.loops, left.loop_start)) == pytest.approx(skin)


def test_edges_end_in_the_plane() -> None:
    points = np.array([[0, 0, 0], [0, 2, 0], [1, 3, 0], [1, -3, 0]], dtype=float)
    cut = cut_named("y=0.5", Solids.from_blocks(STACK[1:] + [box("far", (0, -4, 0), (1, 4, 1))]), FRONT)
    left = clipped_lines(Lines(points, np.array([[0, 1], [1, 2], [3, 0]]), "#000000", 1.0), cut)
    np.testing.assert_allclose(left.points.reshape(-1, 2, 3), [[[0, 0.5, 0], [0, 2, 0]], [[0, 2, 0], [1, 3, 0]]])


def test_a_plane_through_corners_leaves_no_case_over() -> None:
    """The plane x = 0.5 holds a whole face of each stone, and z = 1 the joints between them."""
    solids = Solids.from_blocks([*STACK, box("slab", (-0.8, -0.5, 3), (0.8, 0.5, 3.5))])
    for text, view in (("x=0.5", SIDE), ("z=1", view_named("top"))):
        cut = cut_named(text, solids, view)
        caps = caps_of(faces(solids), cut)
        assert np.isfinite(caps.points).all()
        assert all(area > 0.1 for area in areas(caps.points, caps.loops, caps.loop_start))


def test_a_block_that_is_not_convex_gets_its_own_outline() -> None:
    """An L cut across: its cap is an L of area 3."""
    ell = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
    low, high = (np.column_stack([ell[:, 0], np.full(6, y), ell[:, 1]]) for y in (0.0, 1.0))
    sides = tuple((k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k) for k in range(6))
    # seen from -y the outline of x and z runs counter-clockwise, so the front face keeps its order
    block = Block("ell", np.concatenate([low, high]), (tuple(range(6)), tuple(range(11, 5, -1)), *(face[::-1] for face in sides)), 2000.0)
    solids = Solids.from_blocks([block])
    caps = caps_of(faces(solids), cut_named("y", solids, FRONT))
    assert areas(caps.points, caps.loops, caps.loop_start) == pytest.approx([3.0])


def test_traces_run_where_the_plane_crosses_the_joints(tmp_path: Path) -> None:
    rest = at_rest(STACK)
    with Results.open(write_run(tmp_path / "run.h5", STACK, [rest])) as results:
        solids, joints = Solids.from_blocks(results.blocks), results.joints
        drawn = DrawnJoints.at(joints, solids, Pose.of(results, solids), 1.0, 0.02)
        found = traces(replace(drawn, shown=np.array([True, False, True])), cut_named("y=0.2", solids, FRONT))
    assert found.joint.tolist() == [0, 2]
    np.testing.assert_allclose(found.corners[..., 1], 0.2)
    for corners, joint in zip(found.corners, found.joint, strict=True):
        assert np.ptp(corners[:, 2]) == pytest.approx(0.02)  # as thick as the band
        assert corners[:, 2].mean() == pytest.approx(joints.centres()[joint, 2])
        assert np.ptp(corners[:, 0]) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("text", "view", "message"),
    [
        ("w=1", FRONT, r'^cut: "w=1" is no plane; write x, y or z'),
        ("y=1e", FRONT, r'^cut: "y=1e" is no plane'),
        ("y=9", FRONT, r"^cut: y = 9 m does not pass through the structure, which spans -0.5 to 0.5 m$"),
        ("x=0", FRONT, r"^cut: the front view sees the plane x = 0 m edge-on; side and isometric show it$"),
    ],
)
def test_bad_cuts_are_one_line(text: str, view: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        cut_named(text, Solids.from_blocks(STACK), view)  # type: ignore[arg-type]


def test_a_crack_inside_shows_in_the_cut_only(tmp_path: Path) -> None:
    """An open joint between two thin leaves, hidden by a third in front of them."""
    blocks = [
        BASE,
        box("front", (-1, -0.6, 0), (1, -0.4, 2), "wall"),
        box("low", (-1, -0.4, 0), (1, 0.4, 1), "wall"),
        box("high", (-1, -0.4, 1), (1, 0.4, 2), "wall"),
    ]
    rest = at_rest(blocks)
    opened = turned(rest, 3, (1.0, 0.0, 1.0), 0.3)
    run = write_run(tmp_path / "run.h5", blocks, [rest, opened])
    seen = []
    with Results.open(run) as results:
        for name, style in (("whole", MapStyle(view="front", scale=1.0)), ("cut", MapStyle(scale=1.0, cut="y=0"))):
            crack_map(results, tmp_path / f"{name}.png", style=style)
            image = pixels(tmp_path / f"{name}.png")
            seen.append(int(shares(model_area(image, 1.0), opening_scale().colours).sum()))
    assert seen[1] > 20 * max(seen[0], 50)


def test_ties_end_at_the_plane_and_those_before_it_are_left_out() -> None:
    ends = np.array([[[0.0, 0.0, 1.0], [4.0, 0.0, 1.0]], [[3.0, 0.0, 1.0], [4.0, 2.0, 1.0]], [[0.0, 1.0, 1.0], [1.0, 1.0, 1.0]]])
    ties = Ties(ends, ("crossing", "before", "behind"), np.array([1.0, 2.0, 3.0]))
    left = clipped_ties(ties, Cut("x", 2.0, np.array([-1.0, 0.0, 0.0])))
    assert left.texts == ("crossing", "behind")
    assert left.tension.tolist() == [1.0, 3.0]
    assert left.ends.tolist() == [[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0]], [[0.0, 1.0, 1.0], [1.0, 1.0, 1.0]]]
