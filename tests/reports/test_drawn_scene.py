# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene, however it is drawn: VTK, polygons, the page's viewer and the files for ParaView show the same joints, blocks and colours."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
from made_run import at_rest, box, turned, write_run
from pictures import BASE, COLUMN, model_area, shares

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.deformed import Solids, solids_of
from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, save
from reports.drawing.parts import hexed, view_named
from reports.drawing.scene import Scene
from reports.drawing.solids import structure_scene, structure_window
from reports.maps.crack_map import at_rest as scene_at_rest
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing
from reports.page.model import model_arrays
from reports.paraview import blocks_as_polydata


def hinged(folder: Path, opening: float) -> Path:
    """A column whose upper joint is a hinge, open by so much [m]."""
    rest = at_rest(COLUMN)
    return write_run(folder / "run.h5", COLUMN, [rest, turned(rest, 3, (0.5, 0.0, 2.0), float(np.degrees(opening)))])


def scene_of(results: Results) -> Scene:
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


def test_a_scene_loads_nothing_heavy() -> None:
    code = "import sys, reports.drawing.scene, reports.drawing.bands\nprint([m for m in ({!r}, {!r}) if m in sys.modules])"
    code = code.format("vtkmodules", "matplotlib")
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
