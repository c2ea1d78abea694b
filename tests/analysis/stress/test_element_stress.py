# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of the elements of meshed blocks in files, tables, ParaView and pictures, against the weight that they carry."""

from __future__ import annotations

import csv
import re
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from block_files import cuboid
from small_runs import write_scene

import masonry_cd as mc
from masonry_cd.analysis.deformed import Pose, Solids, solids_of
from masonry_cd.analysis.stress.elements import centres, volumes
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.block_mesh import block_mesh
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from reports.drawing.figure import Sheet, save_polygons
from reports.maps.framing import MapStyle
from reports.maps.meshed_solids import Facetted
from reports.maps.stress_map import Pressed, stress_scene
from reports.paraview import export

DENSITY, WIDTH, HEIGHT, YOUNG = 2000.0, 0.5, 0.25, 1e9
WEIGHT = DENSITY * 9.81 * HEIGHT  # of a block over its foot [Pa]
SCENE = """
[material]
density = 2000.0
friction = 0.6
deformable = {{ cut = "tetrahedra", default = "rigid" }}
young = 1e9
poisson = 0.0
mesh_size = 1.0
compressive_strength = {{ cut = {strength}, default = 1e7 }}
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 1e-7
frequency = 1.0
cycles = 1
[run]
dt = 1e-3
duration = 0.04
until_still = false
tolerance = 1e-12
[report]
stress = true
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> mc.Run:
    """Two meshed blocks and a rigid one on top, at rest; the upper meshed one bears 1 to 2 of its weights, so the lower one alone comes
    above its strength."""
    folder = tmp_path_factory.mktemp("elements")
    blocks = [cuboid((-1.0, -0.25, -0.5), (1.0, 0.25, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}]
    for k, (name, group) in enumerate((("low", "cut"), ("high", "cut"), ("lid", "hard"))):
        corners = (-WIDTH / 2, -0.25, HEIGHT * k), (WIDTH / 2, 0.25, HEIGHT * (k + 1))
        blocks.append(cuboid(*corners) | {"name": name, "group": group})
    scene = write_scene(folder, blocks, SCENE.format(strength=2.2 * WEIGHT))
    return mc.run(mc.scene(scene), folder / "out", progress=False)


def test_the_elements_carry_the_weight_above_them(run: mc.Run) -> None:
    """Without Poisson's ratio and on faces that do not bend: mean of a block 1.5 and 2.5 of its weight, the parts half of one around it."""
    table = run.elements()
    assert table.attrs["units"]["zz"] == table.attrs["units"]["s3"] == "Pa"
    with run.results() as results:
        assert results.meshes is not None
        volume = volumes(results, results.meshes)
    for name, above in (("high", 1.5), ("low", 2.5)):
        own = table.index.get_level_values("block") == name
        assert np.average(table["zz"][own], weights=volume[own]) == pytest.approx(-above * WEIGHT, rel=1e-4)
        assert np.abs(table["zz"][own] / WEIGHT + above).max() < 0.51
    assert volume[:4].sum() == pytest.approx(WIDTH * WIDTH * HEIGHT)
    assert np.abs(table["s3"] - table["zz"]).max() < 0.01 * WEIGHT


def test_the_nodes_come_down_as_their_blocks_shorten(run: mc.Run) -> None:
    nodes = run.nodes()
    assert nodes.attrs["units"]["uz"] == "m"
    top = nodes.loc["high"].query("z > 0.499")
    bottom = nodes.loc["low"].query("z < 1e-3")
    assert top["uz"].mean() == pytest.approx(-(1.5 + 2.5) * WEIGHT * HEIGHT / YOUNG, rel=0.02)
    assert bottom["uz"].abs().max() < 1e-9


def test_tables_and_summary_name_what_is_above_its_strength(run: mc.Run) -> None:
    with (run.folder / "element_stress.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["block"] for row in rows] == ["low"] * 4 + ["high"] * 4
    found = run.summary["stress"]["elements"]
    table = run.element_stress
    assert found["count"] == len(table) == 8
    assert found["compression_max_block"] == "low"
    assert found["compression_max"] == pytest.approx(table["max_compression"].max())
    assert found["above"] == sum(float(row["ratio"]) > 1.0 for row in rows) > 0
    assert found["blocks_above_names"] == ["low"]
    line = next(line for line in run.lines if line.startswith("elements of meshed blocks: largest compression"))
    assert "in low at" in line
    assert f"{found['above']} of 8 come above their strength, in low" in line


def test_paraview_gets_the_elements_with_principal_stresses(run: mc.Run, tmp_path: Path) -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    with run.results() as results:
        files = export(results, tmp_path)
        last, stress = results.frames - 1, np.asarray(results.element_stress[results.frames - 1])
    assert tmp_path / "elements.vtkhdf" in files
    reader = vtkHDFReader()
    reader.SetFileName(str(tmp_path / "elements.vtkhdf"))
    reader.UpdateInformation()
    reader.SetStep(last)
    reader.Update()
    data = reader.GetOutputAsDataSet()
    cells = data.GetCellData()
    np.testing.assert_array_equal(vtk_to_numpy(cells.GetArray("stress")), stress)
    share = vtk_to_numpy(cells.GetArray("share_of_strength"))
    np.testing.assert_allclose(share, vtk_to_numpy(cells.GetArray("compression")) / (2.2 * WEIGHT), rtol=1e-6)
    np.testing.assert_allclose(vtk_to_numpy(cells.GetArray("principal_stress"))[:, 2], -vtk_to_numpy(cells.GetArray("compression")))
    moved = vtk_to_numpy(data.GetPointData().GetArray("displacement"))
    np.testing.assert_allclose(moved[:, 2], run.nodes()["uz"], rtol=1e-5, atol=1e-10)


def test_lists_of_files_have_the_elements_too(run: mc.Run, tmp_path: Path) -> None:
    import pyvista

    with run.results() as results:
        export(results, tmp_path, "pvd")
        frames = results.frames
    assert (tmp_path / "elements.pvd").read_text().count("<DataSet") == frames
    data = pyvista.read(tmp_path / "elements" / f"elements_{frames - 1:05d}.vtu")
    assert data.n_cells == 8
    assert data.cell_data["principal_stress"].shape == (8, 3)


def test_the_map_colours_the_triangles_by_their_own_stress(run: mc.Run, tmp_path: Path) -> None:
    """The polygons of the vector map: all classes that the elements come to are drawn."""
    with run.results() as results:
        pressed = Pressed.of(results, None)
        assert pressed.of_elements is not None
        tints = {tuple(colour) for colour in pressed.scale(pressed.of_elements).tolist()}
        svg = save_polygons(stress_scene(results, None, MapStyle()), tmp_path, "stress_map")[0].read_text()
        last = Sheet.drawn(stress_scene(results, results.frames - 1, MapStyle()), samples=1)
    drawn = np.array([[int(fill[k : k + 2], 16) for k in (0, 2, 4)] for fill in re.findall(r"fill: #(\w{6}); stroke: #4a4640", svg)])
    assert len(tints) > 3  # two blocks have no more than two in the mean
    assert max(np.abs(drawn - tint).max(axis=1).min() for tint in tints) <= 6  # but for the light
    assert last.figure is not None


def test_the_facets_follow_the_nodes(run: mc.Run) -> None:
    with run.results() as results:
        assert results.meshes is not None
        solids, last = solids_of(results.blocks), results.frames - 1
        facetted = Facetted.of(solids, results.meshes)
        pose = Pose.of(results, solids, last)
        amplified = facetted.moved(results, pose, last, 1e4) - facetted.solids.vertices
        own = facetted.node >= 0
        np.testing.assert_allclose(amplified[own, 2], 1e4 * run.nodes()["uz"].to_numpy()[facetted.node[own]], rtol=1e-3, atol=1e-6)
        assert np.abs(amplified[own, 1]).max() < 1e-6  # both ends stay where they are
        assert np.abs(amplified[facetted.solids.vertex_block == 0]).max() < 1e-6


@pytest.mark.parametrize("axis", [-1, 1])
def test_facets_close_around_the_block(axis: int) -> None:
    """Their volume is the block's, in space and in a plane, next to one that is not meshed; behind each facet lies its element."""
    corners = np.array([[x, y, z] for x in (0.0, 0.7) for y in (0.0, 0.4) for z in (0.0, 0.3)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    blocks = [Block("whole", corners + [2.0, 0.0, 0.0], faces, 1.0), Block("cut", corners, faces, 1.0)]
    solids = Solids.from_blocks(blocks)
    mesh = block_mesh("cut", Polyhedron(corners - solids.centre[1], faces), 0.25, axis)
    ends = np.array([0, len(mesh.nodes)]), np.array([0, len(mesh.elements)])
    meshes = Meshes(np.array([1]), ends[0], mesh.nodes + solids.centre[1], ends[1], mesh.elements)
    found = Facetted.of(solids, meshes)
    flat, total = found.solids, np.zeros(2)
    for f, block in enumerate(flat.face_block):
        loop = flat.vertices[flat.loops[flat.loop_start[f] : flat.loop_start[f + 1]]] - flat.centre[block]
        for k in range(1, len(loop) - 1):
            total[block] += np.dot(loop[0], np.cross(loop[k], loop[k + 1])) / 6.0
        if found.element[f] >= 0:
            assert np.linalg.norm(loop.mean(axis=0) + flat.centre[block] - centres(meshes)[found.element[f]]) < 0.35
    assert total == pytest.approx(0.7 * 0.4 * 0.3)
    assert (found.element[flat.face_block == 0] == -1).all()


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("elements", lambda a: a + 99, "meshes/elements has indices out of range"),
        ("elements", lambda a: a[:, :2], "meshes/elements should have 3 or 4 nodes each, not 2"),
        ("block", lambda a: a + 99, "meshes/block has indices out of range"),
        ("node_start", lambda a: a[::-1], "meshes/node_start does not partition its"),
        ("nodes", lambda a: a[:, :2], "meshes/nodes should have the shape"),
        ("nodes", None, "meshes/nodes is missing"),
        ("stress", lambda a: a[:, :1], "meshes/stress should have real numbers"),
        ("displacement", None, "meshes/displacement is missing"),
    ],
)
def test_meshes_that_no_run_writes_are_named(run: mc.Run, tmp_path: Path, name: str, change: Any, message: str) -> None:
    """In a file without checksums."""
    shutil.copy(run.folder / "result.h5", tmp_path)
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        array = file[f"meshes/{name}"][...]
        del file[f"meshes/{name}"], file.attrs["format"]
        if change is not None:
            file.create_dataset(f"meshes/{name}", data=change(array), maxshape=(None,) * array.ndim)
    with pytest.raises(InputError, match=message):
        Results.open(tmp_path / "result.h5")


def test_the_room_that_a_frame_takes_is_known_beforehand(run: mc.Run) -> None:
    with run.results() as results:
        assert results.meshes is not None
        frame = sum(dataset[0].nbytes for dataset in (results.node_displacement, results.element_stress))
        assert 4 * results.meshes.numbers == frame == 4 * (3 * 10 + 6 * 8)


def test_a_run_without_meshed_blocks_says_so(run: mc.Run, tmp_path: Path) -> None:
    bare = mc.run(
        mc.scene(run.folder.parent / "scene.toml", "material.deformable=rigid", "run.duration=0.002"), tmp_path / "bare", progress=False
    )
    with Results.open(tmp_path / "bare" / "result.h5") as results:
        assert results.meshes is None
    with pytest.raises(InputError, match="no block is cut into elements"):
        bare.elements()
    assert not (tmp_path / "bare" / "element_stress.csv").exists()
