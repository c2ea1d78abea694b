# SPDX-License-Identifier: GPL-3.0-or-later
"""The files for ParaView, read back by VTK's own readers; on a full disc they end in one line and leave nothing half-made."""

from __future__ import annotations

import os
import resource
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from forked import ended
from made_run import at_rest, box, shifted, turned, write_run

from masonry_cd.cli import main
from masonry_cd.io.results import Results
from reports.paraview import export

BASE = box("base", (-3, -1, -0.5), (3, 1, 0), "base", fixed=True)
PIER = [BASE, box("lower", (-0.5, -0.5, 0), (0.5, 0.5, 1)), box("upper", (-0.5, -0.5, 1), (0.5, 0.5, 2), "cap")]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Rest; the upper block slips by 12 mm while all ride along by 0.3 m; the upper block has fallen."""
    rest = at_rest(PIER)
    slipped = shifted(shifted(rest, 2, (0.012, 0, 0)), slice(None), (0.3, 0, 0))
    opened = turned(rest, 2, (0.5, 0.0, 1.0), 2.0)
    return write_run(tmp_path / "result.h5", PIER, [rest, slipped, opened, shifted(rest, 2, (2.0, 0, -1.0))])


def arrays(data: Any) -> dict[str, np.ndarray]:
    """The arrays of cells of a VTK data set."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    cells = data.GetCellData()
    return {cells.GetArrayName(k): vtk_to_numpy(cells.GetArray(k)).copy() for k in range(cells.GetNumberOfArrays())}


def points(data: Any) -> np.ndarray:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(data.GetPoints().GetData()).copy()


def steps_of_vtkhdf(path: Path) -> list[tuple[float, Any]]:
    """Time and data of each step, as VTK reads them."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    found = []
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        copy = vtkPolyData()
        copy.DeepCopy(reader.GetOutputAsDataSet())
        found.append((reader.GetTimeValue(), copy))
    return found


def steps_of_pvd(path: Path) -> list[tuple[float, Any]]:
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    found = []
    for entry in ET.parse(path).getroot().iter("DataSet"):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path.parent / entry.attrib["file"]))
        reader.Update()
        found.append((float(entry.attrib["timestep"]), reader.GetOutput()))
    return found


@pytest.mark.parametrize("form", ["vtkhdf", "pvd"])
def test_vtk_reads_what_the_run_holds(run: Path, tmp_path: Path, form: str) -> None:
    read = steps_of_vtkhdf if form == "vtkhdf" else steps_of_pvd
    with Results.open(run) as results:
        files = export(results, tmp_path / "view", form)
        assert [file.name for file in files] == [f"blocks.{form}", f"joints.{form}", "names.csv"]
        blocks, joints = read(files[0]), read(files[1])
        opening, sliding = results.joint_history("opening"), results.joint_history("sliding")
    for steps in (blocks, joints):
        assert [time for time, _ in steps] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    for _, data in blocks:
        assert (data.GetNumberOfCells(), data.GetNumberOfPoints()) == (18, 24)
    rest = points(blocks[0][1])
    np.testing.assert_allclose(rest, np.concatenate([b.vertices for b in PIER]), atol=1e-6)
    np.testing.assert_allclose(points(blocks[1][1])[16:], rest[16:] + [0.312, 0, 0], atol=1e-6)  # in the world frame
    np.testing.assert_allclose(points(blocks[1][1])[:16], rest[:16] + [0.3, 0, 0], atol=1e-6)
    faces = arrays(blocks[3][1])
    np.testing.assert_array_equal(faces["fallen"], np.repeat([0, 0, 1], 6))
    np.testing.assert_array_equal(faces["group"], np.repeat([0, 1, 2], 6))
    np.testing.assert_array_equal(faces["fixed"], np.repeat([1, 0, 0], 6))
    np.testing.assert_array_equal(arrays(blocks[0][1])["fallen"], 0)
    assert files[2].read_text().splitlines() == ["block,name,group,group_name", "0,base,0,base", "1,lower,1,block", "2,upper,2,cap"]
    for k, (_, data) in enumerate(joints):
        measures = arrays(data)
        np.testing.assert_allclose(measures["opening"], opening[k], atol=1e-6)
        np.testing.assert_allclose(measures["sliding"], sliding[k], atol=1e-6)
    states = np.array([arrays(data)["state"] for _, data in joints])
    upper = int(np.flatnonzero(states.any(axis=0))[0])
    assert states[:, upper].tolist() == [0, 2, 1, 3]


def test_displacements_are_relative_to_the_base(run: Path, tmp_path: Path) -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    with Results.open(run) as results:
        files = export(results, tmp_path)
    _, data = steps_of_vtkhdf(files[0])[1]
    moved = vtk_to_numpy(data.GetPointData().GetArray("displacement"))
    np.testing.assert_allclose(moved, np.repeat([[0, 0, 0], [0, 0, 0], [0.012, 0, 0]], 8, axis=0), atol=1e-7)


PATIENCE = 60  # [s]


def exported(folder: Path, form: str, limit: int) -> list[str]:
    """The lines on standard error of an export in a process whose files may have a given number of bytes, those of libraries among them."""

    def body() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        os.dup2(write, 2)
        sys.stderr, sys.argv = os.fdopen(2, "w"), ["masonry-cd", "export", str(folder), "--format", form, "-o", str(folder / "view")]
        try:
            main()
        finally:
            sys.stderr.flush()

    read, write = os.pipe()
    how = ended(body, PATIENCE)
    os.close(write)
    with os.fdopen(read) as said:
        lines = said.read().splitlines()
    assert how.endswith(f"SystemExit: {1 if lines else 0}\n"), how
    return lines


@pytest.mark.parametrize(("form", "limit"), [("vtkhdf", 0), ("vtkhdf", 30_000), ("pvd", 0), ("pvd", 2000)])
def test_an_export_that_cannot_be_written_is_one_line(tmp_path, form, limit):
    """No file may grow beyond a limit; the library that writes learns of it as of a full disc."""
    stack = [box("base", (0, 0, 0), (2, 2, 1), fixed=True), *(box(f"b{k}", (0, 0, 1 + k), (1, 1, 2 + k)) for k in range(60))]
    rest = at_rest(stack)
    scene = "[structure]\n[run]\ndt = 1e-3\n"
    write_run(tmp_path / "result.h5", stack, [shifted(rest, slice(1, None), (0.01 * k, 0, 0)) for k in range(12)], scene=scene)
    (line,) = exported(tmp_path, form, limit)
    assert "cannot be written" in line
    assert not [path for path in (tmp_path / "view").rglob("*") if path.is_file() and path.name.startswith("blocks.")]
    assert not list((tmp_path / "view").rglob("*.part.*"))
    assert exported(tmp_path, form, 1 << 40) == []
