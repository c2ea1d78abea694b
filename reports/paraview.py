# SPDX-License-Identifier: GPL-3.0-or-later
"""A run for ParaView: the blocks and the joints as polygons over time, and the elements of meshed blocks.

Each mesh has its own file, so that any can be switched off: ``blocks``, the faces of all blocks in the world frame; ``joints``, the
interface polygons halfway between the two blocks; and, where the run kept the stress of meshed blocks, ``elements``, tetrahedra, or in a
plane triangles in the middle of the blocks. Formats:

- ``vtkhdf``: blocks.vtkhdf and so on, all times in one file each (VTKHDF 2.0, PolyData; elements UnstructuredGrid). The cells never
  change, so they are stored once: NumberOfPoints and the like have one entry, PartOffsets and CellOffsets are zero, and only points and
  data advance.
- ``pvd``: blocks.pvd and so on, lists of one .vtp or .vtu file per time, for older readers.

Arrays: of points ``displacement`` relative to the base [m]; of block faces ``block``, ``group``, ``fixed``, ``fallen``, ``velocity`` [m/s],
and, where the run kept it, ``stress`` (xx yy zz xy yz xz, ParaView's symmetric tensor) and ``principal_stress``, the largest tension first
[Pa], means over the block since the time before; of joints ``joint``, ``block_a``, ``block_b``, ``area`` [m2], ``opening``, ``sliding``
[m], ``rotation`` [rad], ``contact_area`` [m2], ``normal_force``, ``shear_force`` [N], likewise ``edge_stress`` [Pa], NaN where the force is
at an edge and the stress infinite, ``force_point`` in the world frame [m] and ``state`` (0 intact, 1 opened, 2 slid, 3 separated, at
that time); of elements ``block``, ``stress``, ``principal_stress``, ``compression``, the largest at that time [Pa], and, where a strength
is given, ``share_of_strength``. ``names.csv`` lists the names of blocks and groups by their numbers: as field data that lasts through all
times, VTK 9.7 fails to read texts from VTKHDF.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds, classify
from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, base_at, moved_nodes, solids_of
from masonry_cd.analysis.stress.peaks import principal, strengths
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.hdf5_file import created
from masonry_cd.io.layout import EDGE_STRESS, JOINT_HISTORIES
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.state import rotation_matrices
from reports.drawing.bands import DrawnJoints
from reports.drawing.parts import Surface
from reports.drawing.solids import block_layers

Format = Literal["vtkhdf", "pvd"]
Arrays = dict[str, np.ndarray]
Instant = tuple[np.ndarray, Arrays, Arrays]  # points (N, 3), data of points, data of cells
POLYGON, TRIANGLE, TETRAHEDRON = 7, 5, 10
KINDS = ("Vertices", "Lines", "Polygons", "Strips")  # of the cells of a PolyData, in the order in which cell data list them


@dataclass(frozen=True, eq=False)
class Mesh:
    """Polygons that move and carry data."""

    name: str
    loops: np.ndarray  # (L,) indices of points
    loop_start: np.ndarray  # (C + 1,)
    fixed: Arrays  # data of cells that do not change
    at: Callable[[int], Instant]  # of a frame
    kind: int = POLYGON  # of the cells, as VTK numbers them; solids and triangles of elements make an unstructured grid


def export(results: Results, folder: Path, form: str = "vtkhdf", thresholds: Thresholds | None = None) -> list[Path]:
    """Write a run for ParaView into a folder, which is created if missing; return the files to open, and names.csv.

    Raises:
        InputError: a format that is neither ``vtkhdf`` nor ``pvd``.
    """
    if form not in ("vtkhdf", "pvd"):
        raise InputError("--format", f'"{form}" is not a format; choose vtkhdf or pvd')
    folder.mkdir(parents=True, exist_ok=True)
    write = _write_vtkhdf if form == "vtkhdf" else _write_pvd
    meshes = [_blocks(results, thresholds or Thresholds())]
    if results.joints.count:
        meshes.append(_joints(results, thresholds or Thresholds()))
    if results.meshes is not None:
        meshes.append(_elements(results, results.meshes))
    files = [write(mesh, results.time, folder / f"{mesh.name}.{form}") for mesh in meshes]
    groups = list(dict.fromkeys(block.group for block in results.blocks))
    names = ((k, block.name, groups.index(block.group), block.group) for k, block in enumerate(results.blocks))
    write_csv(folder / "names.csv", ("block", "name", "group", "group_name"), names)
    return [*files, folder / "names.csv"]


def blocks_as_polydata(results: Results, frame: int, thresholds: Thresholds) -> Any:
    """The faces of the blocks at a frame with their arrays, a PolyData of pyvista."""
    return _as_pyvista(_blocks(results, thresholds), frame)


def _blocks(results: Results, thresholds: Thresholds) -> Mesh:
    """The faces of the blocks, those of their scene."""
    solids = solids_of(results.blocks)
    faces = block_layers(solids, solids.vertices, np.ones((len(results.blocks), 3)))[0]
    assert isinstance(faces, Surface) and faces.owner is not None
    block = faces.owner
    groups = list(dict.fromkeys(block.group for block in results.blocks))
    group = np.array([groups.index(block.group) for block in results.blocks], dtype=np.int32)

    def at(frame: int) -> Instant:
        position = np.asarray(results.position[frame], dtype=float)
        rotation = rotation_matrices(np.asarray(results.orientation[frame], dtype=float))
        world = Pose(float(results.time[frame]), position, rotation, results.gradient(frame))
        points = world.moved(solids, solids.vertices, solids.vertex_block)
        moved = base_at(results, solids, frame).seen(points) - solids.vertices
        down = DamageSnapshot.at(results, frame, thresholds).down
        velocity = np.asarray(results.velocity[frame, :, :3])
        data = {"fallen": down[block].astype(np.uint8), "velocity": velocity[block]}
        if results.has_stress:
            stress = np.asarray(results.stress[frame], dtype=float)
            data |= {"stress": stress[block], "principal_stress": principal(stress)[block]}
        return points, {"displacement": moved}, data

    fixed = {"block": block.astype(np.int32), "group": group[block], "fixed": solids.fixed[block].astype(np.uint8)}
    return Mesh("blocks", faces.loops, faces.loop_start, fixed, at)


def _joints(results: Results, thresholds: Thresholds) -> Mesh:
    """The interface polygons."""
    solids, joints = solids_of(results.blocks), results.joints
    histories = [name for name in JOINT_HISTORIES if results.has_joint_history(name)]

    def at(frame: int) -> Instant:
        snapshot = DamageSnapshot.at(results, frame, thresholds)
        points = DrawnJoints.at(joints, solids, snapshot.pose, 1.0, 0.0).middles
        data: Arrays = {name: results.joints_at(name, frame) for name in histories}
        if results.has_stress:
            edge = results.joints_at(EDGE_STRESS, frame)
            data[EDGE_STRESS] = np.where(np.isinf(edge), np.nan, edge)  # or no range of colours would fit
        data["state"] = classify(snapshot.opening, snapshot.sliding, snapshot.separated, thresholds).astype(np.uint8)
        return base_at(results, solids, frame).in_world(points), {"displacement": points - joints.polygon}, data

    fixed = {
        "joint": np.arange(joints.count, dtype=np.int32),
        "block_a": joints.block_a.astype(np.int32),
        "block_b": joints.block_b.astype(np.int32),
        "area": joints.area.astype(np.float32),
    }
    return Mesh("joints", np.arange(len(joints.polygon)), joints.polygon_start, fixed, at)


def _elements(results: Results, meshes: Meshes) -> Mesh:
    """The elements of meshed blocks."""
    solids, block = solids_of(results.blocks), meshes.block_of_element
    strength = strengths(results)[0][block]

    def at(frame: int) -> Instant:
        position = np.asarray(results.position[frame], dtype=float)
        world = Pose(float(results.time[frame]), position, rotation_matrices(np.asarray(results.orientation[frame], dtype=float)))
        points = moved_nodes(results, world, frame)
        stress = np.asarray(results.element_stress[frame], dtype=float)
        values = principal(stress)
        data = {"stress": stress, "principal_stress": values, "compression": -values[:, 2]}
        if np.isfinite(strength).any():
            data["share_of_strength"] = -values[:, 2] / strength
        return points, {"displacement": base_at(results, solids, frame).seen(points) - meshes.nodes}, data

    corners = meshes.elements.shape[1]
    start, kind = corners * np.arange(len(meshes.elements) + 1), TETRAHEDRON if corners == 4 else TRIANGLE
    return Mesh("elements", meshes.elements.ravel(), start, {"block": block.astype(np.int32)}, at, kind)


def _write_vtkhdf(mesh: Mesh, times: np.ndarray, path: Path) -> Path:
    """All times of a mesh in one file."""
    frames, cells = len(times), len(mesh.loop_start) - 1
    with replacing(path) as part, created(part, path) as (file, sink):
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        grid = mesh.kind != POLYGON
        kind = "UnstructuredGrid" if grid else "PolyData"
        root.attrs.create("Type", kind.encode(), dtype=h5py.string_dtype("ascii", len(kind)))
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(frames)
        steps["Values"] = times.astype(float)
        steps["PartOffsets"] = np.zeros(frames, dtype=np.int64)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros((frames, 1 if grid else len(KINDS)), dtype=np.int64)
        steps["NumberOfParts"] = np.ones(frames, dtype=np.int64)
        if grid:
            _write_cells(root, mesh)
            root["Types"] = np.full(cells, mesh.kind, dtype=np.uint8)
        else:
            for topology in KINDS:
                _write_cells(root.create_group(topology), mesh if topology == "Polygons" else None)
        for frame in range(frames):
            sink.check()
            points, of_points, of_cells = mesh.at(frame)
            if frame == 0:
                root["NumberOfPoints"] = np.array([len(points)], dtype=np.int64)
                steps["PointOffsets"] = np.arange(frames, dtype=np.int64) * len(points)
                for name, values in mesh.fixed.items():
                    root[f"CellData/{name}"] = values
                    steps[f"CellDataOffsets/{name}"] = np.zeros(frames, dtype=np.int64)
            _put(root, "Points", points, frame, frames)
            for place, arrays, rows in (("PointData", of_points, len(points)), ("CellData", of_cells, cells)):
                for name, values in arrays.items():
                    _put(root, f"{place}/{name}", values, frame, frames)
                    if frame == 0:
                        steps[f"{place}Offsets/{name}"] = np.arange(frames, dtype=np.int64) * rows
    return path


def _write_cells(group: h5py.Group, mesh: Mesh | None) -> None:
    """The cells of a mesh, or none of this kind."""
    offsets = mesh.loop_start if mesh is not None else np.zeros(1)
    loops = mesh.loops if mesh is not None else np.zeros(0)
    group["NumberOfCells"] = np.array([len(offsets) - 1], dtype=np.int64)
    group["NumberOfConnectivityIds"] = np.array([len(loops)], dtype=np.int64)
    group["Offsets"] = offsets.astype(np.int64)
    group["Connectivity"] = loops.astype(np.int64)


def _put(root: h5py.Group, name: str, values: np.ndarray, frame: int, frames: int) -> None:
    """Write the rows of a frame, in single precision where they are real numbers."""
    rows, dtype = len(values), np.float32 if values.dtype.kind == "f" else values.dtype
    if name not in root:
        shape = (frames * rows, *values.shape[1:])
        chunk = (max(1, min(rows, 1 << 14)), *values.shape[1:])
        root.create_dataset(name, shape, dtype, chunks=chunk, compression="gzip", compression_opts=1, shuffle=True)
    root[name][frame * rows : (frame + 1) * rows] = values


def _write_pvd(mesh: Mesh, times: np.ndarray, path: Path) -> Path:
    """A list of one file per time, in a folder next to it."""
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    ending, lines = "vtp" if mesh.kind == POLYGON else "vtu", []
    for frame, time in enumerate(times):
        data = _as_pyvista(mesh, frame)
        file = folder / f"{mesh.name}_{frame:05d}.{ending}"
        _write_xml(data, file)
        lines.append(f'    <DataSet timestep="{float(time)!r}" part="0" file="{folder.name}/{file.name}"/>')
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n  <Collection>\n'
    with replacing(path) as part:
        part.write_text(head + "\n".join(lines) + "\n  </Collection>\n</VTKFile>\n", encoding="utf-8")
    return path


def _as_pyvista(mesh: Mesh, frame: int) -> Any:
    """A mesh at a frame with its arrays."""
    require("this", "pyvista")
    import pyvista

    cells = np.insert(mesh.loops, mesh.loop_start[:-1], np.diff(mesh.loop_start))
    points, of_points, of_cells = mesh.at(frame)
    data: Any
    if mesh.kind == POLYGON:
        data = pyvista.PolyData(points.astype(np.float32), faces=cells)
    else:
        data = pyvista.UnstructuredGrid(cells, np.full(len(mesh.loop_start) - 1, mesh.kind), points.astype(np.float32))
    for name, values in of_points.items():
        data.point_data[name] = _single(values)
    for name, values in (mesh.fixed | of_cells).items():
        data.cell_data[name] = _single(values)
    return data


def _write_xml(data: Any, path: Path) -> None:
    """Write a mesh. VTK makes its text in memory, since it says nothing of a full disc, or crashes."""
    require("this", "vtkmodules")
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    writer = vtkXMLPolyDataWriter() if path.suffix == ".vtp" else vtkXMLUnstructuredGridWriter()
    writer.SetInputData(data)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    with replacing(path) as part:
        try:
            part.write_text(writer.GetOutputString(), encoding="utf-8")
        except OSError as failure:
            raise OSError(f"{path}: cannot be written: {failure.strerror}") from None


def _single(values: np.ndarray) -> np.ndarray:
    """Real numbers in single precision."""
    return values.astype(np.float32) if values.dtype.kind == "f" else values
