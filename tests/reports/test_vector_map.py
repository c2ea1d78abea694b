# SPDX-License-Identifier: GPL-3.0-or-later
"""The crack map as polygons: what is nearer covers what is farther, joints are coloured as in the picture, equal runs give equal files."""

from __future__ import annotations

import re

import numpy as np
import pytest
from command_line import masonry_cd
from made_run import at_rest, box, shifted, turned, write_run
from pictures import scene_of

from masonry_cd.analysis.deformed import Solids
from masonry_cd.io.results import Results
from reports.drawing.figure import save_polygons
from reports.drawing.palette import OPENING, SLIDING
from reports.drawing.parts import Scale, view_named
from reports.drawing.solids import block_layers, mottled
from reports.drawing.vector import FacePlanes, hidden_sides, in_order, painting_order
from reports.maps.crack_map import MapSubject, crack_scene
from reports.maps.framing import MapStyle, framing
from reports.settings import report_of

VECTOR = ("crack_map.svg", "crack_map.pdf")


def bonded() -> list:
    """Two stones on a base, and a third that lies over the joint between them."""
    return [
        box("base", (-1, 0, -0.5), (3, 1, 0), "base", fixed=True),
        box("left", (0, 0, 0), (1, 1, 0.5), "wall"),
        box("right", (1, 0, 0), (2, 1, 0.5), "wall"),
        box("over", (0.5, 0, 0.5), (1.5, 1, 1), "wall"),
    ]


def run(path, blocks, *states):
    """A result of these states, the first at rest."""
    return write_run(path, blocks, [at_rest(blocks), *states], "A <wall> & more")


def order(view: str, blocks: list) -> np.ndarray:
    """The ranks of blocks at rest."""
    solids = Solids.from_blocks(blocks)
    return painting_order(planes(solids), view_named(view))


def planes(solids: Solids) -> FacePlanes:
    """Those of blocks at rest."""
    return FacePlanes(block_layers(solids, solids.vertices, np.ones((len(solids.centre), 3)))[0])


@pytest.mark.parametrize("view", ["isometric", "front", "side", "left", "top"])
def test_the_nearer_of_two_blocks_is_painted_later(view):
    towards = view_named(view).towards
    blocks = [box(f"{i}{j}{k}", (i, j, k), (i + 1, j + 1, k + 1)) for i in range(3) for j in range(3) for k in range(3)]
    rank = order(view, blocks)
    assert sorted(rank) == list(range(27))
    cells = [tuple(map(int, block.name)) for block in blocks]
    for a, first in enumerate(cells):
        for b, second in enumerate(cells):
            apart = np.subtract(second, first)
            if np.abs(apart).sum() == 1 and apart @ towards > 1e-6:  # neighbours over a face that looks at the viewer
                assert rank[a] < rank[b], (first, second)


def test_a_long_block_before_a_small_one_whose_middle_is_nearer_is_painted_later():
    long, small = box("long", (-20, 0, 0), (1, 1, 1)), box("small", (0, 1, 0), (1, 2, 1))  # the long one lies before it, seen from -y
    towards = view_named("isometric").towards
    assert (small.vertices.mean(axis=0) - long.vertices.mean(axis=0)) @ towards > 0  # depth alone would paint the small one last
    rank = order("isometric", [long, small])
    assert rank[0] > rank[1]


def test_where_planes_go_round_in_a_circle_the_farthest_is_painted_first():
    rank = in_order([[1], [2], [0], []], np.array([1, 1, 1, 0]), np.array([3.0, 1.0, 2.0, 5.0]))
    assert rank.tolist() == [3, 1, 2, 0]  # what waits for nothing, then the farthest of the circle and what it lets go


def test_a_side_below_a_stone_that_reaches_over_it_is_hidden(tmp_path):
    with Results.open(run(tmp_path / "result.h5", bonded(), shifted(at_rest(bonded()), 3, (0.01, 0, 0)))) as results:
        scene = crack_scene(results, 1, framing(results, [1], MapStyle(view="isometric")))
        hidden = np.logical_or(*hidden_sides(scene.joints, FacePlanes(scene.layers[1]), scene.view))
        joints = results.joints
    joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    middle = (joints.polygon + np.concatenate([np.roll(p, -1, axis=0) for p in np.split(joints.polygon, joints.polygon_start[1:-1])])) / 2
    upper = np.isclose(joints.centres()[joint][:, 2], 0.5)
    assert hidden[upper & np.isclose(middle[:, 0], 1.0)].all()  # over the joint between the two lower stones
    assert not hidden[upper & np.isclose(middle[:, 1], 0.0)].any()  # at the face of the wall
    assert not hidden[upper & np.isclose(middle[:, 0], 1.5)].any()  # at the end of the upper stone


def test_joints_have_the_colours_of_their_classes_and_files_are_equal_each_time(tmp_path):
    blocks = bonded()
    opened = turned(shifted(at_rest(blocks), 1, (-2e-3, 0, 0)), 3, (1.5, 0, 0.5), 0.4)
    path = run(tmp_path / "result.h5", blocks, opened)
    texts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        with Results.open(path) as results:
            assert [file.name for file in save_polygons(scene_of(results), tmp_path / name, "crack_map")] == list(VECTOR)
            snapshot = MapSubject.of(results, 1, framing(results, [1], MapStyle())).snapshot
        texts.append([(tmp_path / name / file).read_bytes() for file in VECTOR])
    assert texts[0] == texts[1]
    assert texts[0][1].startswith(b"%PDF")
    svg = texts[0][0].decode()
    assert "<image" not in svg  # polygons alone
    assert "A &lt;wall&gt; &amp; more" in svg
    scales = Scale(1e-4, 0.05, OPENING), Scale(1e-4, 0.05, SLIDING)
    drawn = set(re.findall(r"fill: (#\w{6})", svg[svg.index("PolyCollection") :]))
    for shown, values, scale in ((snapshot.open, snapshot.opening, scales[0]), (snapshot.slid, snapshot.sliding, scales[1])):
        assert shown.any()
        for colour in scale(values[shown]):
            assert "#" + "".join(f"{c:02x}" for c in colour) in drawn


def test_a_cut_shows_caps_and_no_block_before_the_plane(tmp_path):
    path = run(tmp_path / "result.h5", bonded(), shifted(at_rest(bonded()), 3, (0.01, 0, 0)))
    fills = {}
    for cut in ("", "x=0.75"):
        with Results.open(path) as results:
            save_polygons(scene_of(results, style=MapStyle(view="isometric", cut=cut)), tmp_path, "crack_map")
        fills[cut] = set(re.findall(r"fill: (#\w{6})", (tmp_path / "crack_map.svg").read_text()))
    with Results.open(path) as results:
        whole = MapSubject.of(results, 1, framing(results, [1], MapStyle(view="isometric"))).colours
    right = mottled(whole)[2]
    lit = {colour for colour in fills[""] - fills["x=0.75"] if np.allclose(hue(colour), right / right.max(), atol=0.01)}
    assert lit, "the stone before the plane is gone"
    cap = np.round(255 * 0.82 * whole[1]).astype(int)
    assert any(np.abs(np.array(channels(colour)) - cap).max() <= 1 for colour in fills["x=0.75"]), "the stone in it has a cap"


def channels(colour: str) -> list[int]:
    """``#rrggbb`` as numbers to 255."""
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def hue(colour: str) -> np.ndarray:
    """A colour without its brightness."""
    return np.array(channels(colour)) / max(channels(colour) + [1])


def test_the_scene_and_the_command_line_ask_for_it(block_on_plate, tmp_path):
    scene = block_on_plate(duration="duration = 0.02", report="[report]\nvector = true")
    assert masonry_cd("run", scene, "-o", tmp_path / "out", "-q").exit_code == 0
    for name in VECTOR:
        (tmp_path / "out" / name).unlink()
    asked = masonry_cd("report", tmp_path / "out", "--vector", "--no-crack-map")
    assert asked.exit_code == 0 and all(name in asked.stdout for name in VECTOR)
    assert all((tmp_path / "out" / name).exists() for name in VECTOR)
    assert report_of({"report": {"vector": True}}).asks
