# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene, however it is drawn, whole or cut: pictures, polygons, viewer and ParaView show the same; a cut has the right area."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from made_run import at_rest, box, turned, write_run
from pictures import BASE, COLUMN, crack_map, model_area, opening_scale, pixels, shares

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.deformed import Pose, Solids, solids_of
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import loop_area
from reports.drawing.bands import DrawnJoints
from reports.drawing.cut import CutPlane, caps_of, clipped, clipped_lines, clipped_ties, cut_named, traces
from reports.drawing.figure import Sheet, save
from reports.drawing.parts import Lines, Surface, Ties, hexed, view_named
from reports.drawing.scene import PictureScene
from reports.drawing.solids import block_layers, structure_scene, structure_window
from reports.maps.crack_map import at_rest as scene_at_rest
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing
from reports.page.model import model_arrays
from reports.paraview import blocks_as_polydata


def hinged(folder: Path, opening: float) -> Path:
    """A column whose upper joint is a hinge, open by so much [m]."""
    rest = at_rest(COLUMN)
    return write_run(folder / "run.h5", COLUMN, [rest, turned(rest, 3, (0.5, 0.0, 2.0), float(np.degrees(opening)))])


def scene_of(results: Results) -> PictureScene:
    """The crack map of its last frame."""
    return crack_scene(results, 1, framing(results, [1], MapStyle()))


def test_a_picture_and_its_polygons_have_the_colour_that_the_scene_gives_to_a_joint(tmp_path: Path) -> None:
    with Results.open(hinged(tmp_path, 0.0101)) as results:
        scene = scene_of(results)
    assert scene.joints is not None
    joint = int(np.flatnonzero(scene.joints.shown)[0])
    colour = scene.joints.colours[0][joint]
    assert shares(model_area(Sheet.drawn(scene).pixels(), scene.window.width / scene.window.height), colour[None])[0] > 50
    svg = save(Sheet.as_polygons(scene).figure, tmp_path / "a.svg")
    assert f"fill: {hexed(colour)}" in svg.read_text()


def test_hairlines_are_no_cracks(tmp_path: Path) -> None:
    """An opening of 0.09 mm is not drawn, one of 0.11 mm is."""
    for opening, drawn in ((0.9e-4, 0), (1.1e-4, 1)):
        with Results.open(hinged(tmp_path, opening)) as results:
            joints = scene_of(results).joints
        assert joints is not None and int(joints.shown.sum()) == drawn


def test_viewer_and_paraview_take_their_faces_and_joints_from_it(tmp_path: Path) -> None:
    with Results.open(hinged(tmp_path, 0.0101)) as results:
        scene, solids = scene_at_rest(results, MapStyle()), solids_of(results.blocks)
        arrays, joints = model_arrays(scene), results.joints
        faces = blocks_as_polydata(results, 0, Thresholds())
    assert (arrays["vertex_block"] == solids.vertex_block).all()
    assert (arrays["joint_a"] == joints.block_a).all() and (arrays["polygon_start"] == joints.polygon_start).all()
    assert faces.n_cells == len(arrays["loop_start"]) - 1
    np.testing.assert_allclose(faces.points, solids.vertices, atol=1e-6)
    assert scene.joints is not None
    np.testing.assert_allclose(scene.joints.middles, joints.polygon)


def test_a_wide_plate_does_not_shrink_the_structure() -> None:
    """The window of a column is as high on a plate of 100 m as on one of 3 m, from wherever it is seen."""
    wide = box("base", (-50.0, -50.0, -0.3), (50.0, 50.0, 0.0), "base", fixed=True)
    for view in (view_named(name) for name in ("front", "side", "isometric")):
        narrow, broad = (structure_window(Solids.from_blocks([plate, *COLUMN[1:]]), view) for plate in (BASE, wide))
        assert broad.height <= 1.15 * narrow.height


def test_a_structure_gives_the_same_bytes_each_time(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        Sheet.drawn(structure_scene(COLUMN, "a column", ties=[np.array([[-0.5, -0.6, 1.5], [0.5, -0.6, 1.5]])])).save(tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


BASE_CUT = box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True)
STACK = [BASE_CUT, *(box(f"s{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(3))]
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


def test_a_crack_inside_shows_in_the_cut_only(tmp_path: Path) -> None:
    """An open joint between two thin leaves, hidden by a third in front of them."""
    blocks = [
        BASE_CUT,
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
    left = clipped_ties(ties, CutPlane("x", 2.0, np.array([-1.0, 0.0, 0.0])))
    assert left.texts == ("crossing", "behind")
    assert left.tension.tolist() == [1.0, 3.0]
    assert left.ends.tolist() == [[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0]], [[0.0, 1.0, 1.0], [1.0, 1.0, 1.0]]]
