# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of whole runs: tables, summary, words, map, page and ParaView, against a column's own weight and a given strength."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import masonry_cd
from datasets import contents
from made_run import at_rest, write_run
from models import stepper, still, wall
from pictures import main_colours

from masonry_cd.analysis.stress.peaks import principal, stress_peaks, tensors
from masonry_cd.analysis.stress.summary import stress_lines, stress_summary
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.run_loop import Checkpoints, RunPlan, run
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.layout import EDGE_STRESS, MEAN_NORMAL_FORCE, STRESS
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from reports.maps.framing import MapStyle
from reports.maps.stress_map import Pressed, StressScale
from reports.page.stress import colours
from reports.paraview import export

GRAVITY, DENSITY, SIDE, HEIGHT, COUNT = 9.81, 2000.0, 0.5, 0.5, 4
SCENE = f"""
title = "Column"
[structure]
kind = "file"
path = "column.json"
[material]
density = {DENSITY}
friction = 0.6
{{strength}}
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = {{amplitude}}
frequency = 2.0
cycles = 1
[run]
dt = 2e-3
duration = {{duration}}
tolerance = 1e-10
frames_per_second = 100.0
until_still = false
[report]
stress = {{stress}}
"""


def scene(folder: Path, strength: str = "", amplitude: float = 0.0, duration: float = 0.1, stress: str = "true", *changes: str):
    """A column of four blocks of a group each, on a base."""
    corners = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]

    def block(name: str, low: float, wide: float, fixed: bool) -> dict:
        points = [[wide * (x - 0.5), wide * (y - 0.5), low + HEIGHT * z] for x, y, z in corners]
        return {"name": name, "vertices": points, "faces": faces, "fixed": fixed, "group": name}

    blocks = [block("base", -HEIGHT, 4 * SIDE, True), *(block(f"b{k}", k * HEIGHT, SIDE, False) for k in range(COUNT))]
    (folder / "column.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    path = folder / "scene.toml"
    path.write_text(SCENE.format(strength=strength, amplitude=amplitude, duration=duration, stress=stress))
    return read_scene(path, changes)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def weight_above(k: float) -> float:
    """Pressure of what lies above k blocks of the column [Pa]."""
    return DENSITY * GRAVITY * HEIGHT * (COUNT - k)


def test_tables_have_the_weight_above_each_block_and_joint(tmp_path):
    summary = run_case(prepare(scene(tmp_path)), tmp_path / "out")
    blocks = rows(tmp_path / "out" / "stress.csv")
    assert [row["block"] for row in blocks] == [f"b{k}" for k in range(COUNT)]  # no support
    assert [float(row["max_compression"]) for row in blocks] == pytest.approx([weight_above(k + 0.5) for k in range(COUNT)], rel=1e-6)
    assert [float(row["zz"]) for row in blocks] == pytest.approx([-weight_above(k + 0.5) for k in range(COUNT)], rel=1e-6)
    assert blocks[0]["strength"] == blocks[0]["ratio"] == ""
    joints = sorted(rows(tmp_path / "out" / "joint_stress.csv"), key=lambda row: -float(row["max_edge_stress"]))
    assert [float(row["max_edge_stress"]) for row in joints] == pytest.approx([weight_above(k) for k in range(COUNT)], rel=1e-6)
    found = summary.stress
    assert found.compression_max_block == "b0" and found.joints_at_edge == 0 and found.strength is None
    assert found.edge_max == pytest.approx(weight_above(0), rel=1e-6) and set(found.edge_max_blocks) == {"base", "b0"}
    assert found.tension_max == 0.0 and found.interval == pytest.approx(0.01)
    line = next(line for line in closing_lines(summary) if line.startswith("stress"))
    assert "means over the 10 ms between frames" in line and "34.3 kPa in b0" in line and "tension" not in line
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["stress"] == found.as_dict()
    compression = np.array([weight_above(k + 0.5) for k in range(COUNT)])
    assert {"#" + bytes(row).hex() for row in StressScale(weight_above(0.5))(compression)} <= main_colours(
        tmp_path / "out" / "stress_map.png"
    ), "one of each block"


def test_a_strength_asks_for_the_report_and_names_what_lies_above_it(tmp_path):
    """Block b0 is weaker than its mean stress, block b1 only than the edge of the joint below it; the others have no strength."""
    strength = "compressive_strength = { b0 = 3.0e4, b1 = 2.8e4 }"
    summary = run_case(prepare(scene(tmp_path, strength, stress="false")), tmp_path / "out")
    found = summary.stress.strength
    assert found.blocks_above_names == ("b0",) and found.blocks_compared == 2
    assert found.ratio_max == pytest.approx(weight_above(0.5) / 3.0e4, rel=1e-6)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        peaks, joints = stress_peaks(results, 1e-4), results.joints
        names = [{results.blocks[a].name, results.blocks[b].name} for a, b in zip(joints.block_a, joints.block_b, strict=True)]
    lower = dict(zip(map(frozenset, names), peaks.joint_strength.tolist(), strict=True))
    assert lower[frozenset({"base", "b0"})] == 3.0e4 and lower[frozenset({"b0", "b1"})] == 2.8e4  # the lower of both
    assert lower[frozenset({"b1", "b2"})] == 2.8e4 and np.isnan(lower[frozenset({"b2", "b3"})])
    above = [frozenset(names[j]) for j in np.flatnonzero(peaks.closed_above)]  # nothing opens
    assert set(above) == {frozenset({"base", "b0"}), frozenset({"b0", "b1"})} and found.joints_above == 2
    assert found.crushed_share_max == pytest.approx(weight_above(0) / 3.0e4, rel=1e-6)
    said = next(line for line in closing_lines(summary) if line.startswith("strength"))
    assert said.startswith("strength: 1 of 2 blocks by their mean and 2 of 3 joints (none of them while open) by their edge come above it")


def test_nothing_is_kept_that_is_not_asked_for(tmp_path):
    summary = run_case(prepare(scene(tmp_path, stress="false")), tmp_path / "out")
    assert summary.stress is None and not any("stress" in path.name for path in (tmp_path / "out").iterdir())
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert not results.has_stress and f"joints/{EDGE_STRESS}" not in results.file
        with pytest.raises(InputError, match=r"kept no stress; report\.stress = true"):
            stress_peaks(results, 1e-4)
    done = masonry_cd("report", tmp_path / "out", "--stress-map", "--no-crack-map")
    assert done.exit_code == 2 and "kept no stress" in done.output


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("-5.0", "should be between 0.1 and 1e+10 Pa (5 MPa is 5e6), got -5"),
        ("{ nave = 5e6 }", '"nave" is not a group of blocks'),
        ('{ b0 = "5e6" }', 'b0: "5e6" states no unit; write a number in Pa'),
        ("{}", "gives no value"),
    ],
)
def test_a_wrong_strength_is_one_line_that_names_the_key(tmp_path, value, line):
    with pytest.raises(InputError, match=r"material\.compressive_strength") as error:
        prepare(scene(tmp_path, f"compressive_strength = {value}"))
    assert line in str(error.value) and "\n" not in str(error.value) and "scene.toml:9" in str(error.value)


@pytest.mark.parametrize("after", [7, 20, 33])
def test_a_resumed_run_has_the_stress_of_an_unbroken_one(tmp_path, after):
    """Also where it was stopped between two frames."""
    steps, dt, every = 40, 2e-3, 10
    velocity = still(steps)
    velocity[:, 0, 0] = 0.5 * np.sin(2 * np.pi * 4.0 * np.arange(steps + 1) * dt)

    def machine():
        return stepper(wall(2, 3), steps, support_velocity=velocity, dt=dt, solver="auto", tolerance=1e-8)

    def stop(done: int) -> None:
        if done >= after:
            raise KeyboardInterrupt

    paths = tmp_path / "unbroken.h5", tmp_path / "broken.h5"
    saved, joints = tmp_path / checkpoint.NAME, find_joints(machine().assembly)
    with ResultWriter(paths[0], machine().assembly, joints, "scene") as writer:
        run(machine(), joints, writer, RunPlan(steps, every, stress=True))
    with ResultWriter(paths[1], machine().assembly, joints, "scene") as writer:
        run(machine(), joints, writer, RunPlan(steps, every, stress=True), stop, Checkpoints(saved))
    with ResultWriter.resumed(paths[1], checkpoint.load(saved)[1]["rows"]) as writer:
        run(machine(), joints, writer, RunPlan(steps, every, stress=True), checkpoints=Checkpoints(saved, resume=True))
    one, other = contents(paths[0]), contents(paths[1])
    assert one == other and STRESS in one


def test_keeping_stress_changes_no_bit_of_the_rest(tmp_path):
    for stress in ("true", "false"):
        (tmp_path / stress).mkdir()
        run_case(prepare(scene(tmp_path / stress, amplitude=0.3, duration=0.3, stress=stress)), tmp_path / stress / "out")
    kept, plain = (contents(tmp_path / stress / "out" / "result.h5") for stress in ("true", "false"))
    assert {name for name in kept if name not in plain} == {STRESS, f"joints/{EDGE_STRESS}", f"joints/{MEAN_NORMAL_FORCE}"}
    assert all(kept[name] == values for name, values in plain.items())


def made(path: Path, stress: np.ndarray, edge: np.ndarray) -> Path:
    """A result of two blocks on a base with stresses (F, 3, 6) and edges (F, 2) put in by hand."""
    from made_run import box

    blocks = [box("base", (-1, -1, -1), (1, 1, 0), "base", fixed=True), box("low", (0, 0, 0), (1, 1, 1)), box("top", (0, 0, 1), (1, 1, 2))]
    histories = {EDGE_STRESS: edge, MEAN_NORMAL_FORCE: np.full_like(edge, 1e4)}
    write_run(path, blocks, [at_rest(blocks)] * len(edge), histories=histories, scene="", stress=stress)
    return path


@pytest.fixture
def by_hand(tmp_path: Path) -> Path:
    stress = np.full((3, 3, 6), np.nan)
    stress[1:, 1:] = 0.0
    stress[1, 1] = [-3e3, -1e3, -2e5, 0.0, 0.0, 4e4]
    stress[2, 2] = [5e3, 0.0, -1e5, 0.0, 0.0, 0.0]
    return made(tmp_path / "result.h5", stress, np.array([[0.0, 0.0], [2e5, 1e5], [1e5, np.inf]]))


def test_principal_stresses_are_those_of_the_tensor():
    six = np.array([-3.0, 2.0, 1.0, 0.5, -0.25, 4.0])
    own = tensors(six)
    assert np.array_equal(own, own.T) and own[0, 1] == 0.5 and own[1, 2] == -0.25 and own[0, 2] == 4.0
    values = principal(six)
    assert values.sum() == pytest.approx(np.trace(own)) and (np.diff(values) < 0.0).all()
    assert all(abs(np.linalg.det(own - value * np.eye(3))) < 1e-9 for value in values)
    assert np.isnan(principal(np.full(6, np.nan))).all()


def test_peaks_are_over_all_frames_each_with_its_time(by_hand):
    with Results.open(by_hand) as results:
        peaks = stress_peaks(results, 1e-4)
        found = stress_summary(results, peaks)
    middle, radius = (-3e3 - 2e5) / 2, np.hypot((-3e3 + 2e5) / 2, 4e4)
    assert peaks.compression[1:] == pytest.approx([radius - middle, 1e5])
    assert peaks.compression_time[1:] == pytest.approx([0.1, 0.2]) and np.isnan(peaks.compression[0])
    assert peaks.tension[1:] == pytest.approx([middle + radius, 5e3])
    assert np.isinf(peaks.edge[1]) and peaks.edge[0] == 2e5 and peaks.finite_edge.tolist() == [2e5, 1e5]
    assert peaks.edge_time == pytest.approx([0.1, 0.2])
    assert found.joints_at_edge == 1 and peaks.closed_above.tolist() == [False, True]
    assert not peaks.open_above.any() and found.joints_at_edge_open == 0
    assert "in 1 joints" not in " ".join(stress_lines(found)) and "in 1 joint the force came to an edge" in " ".join(stress_lines(found))


def test_the_map_colours_blocks_by_class(by_hand):
    scale = StressScale(2.1e5)
    assert scale.unit == "kPa" and [bound * scale.factor for bound in scale.bounds] == pytest.approx([25.0 * k for k in range(9)])
    assert (np.diff(scale.colours.astype(int).sum(axis=1)) < 0).all()  # darker and darker, in grey print as well
    assert StressScale(3e6).unit == "MPa" and StressScale(0.0).bounds == [0.0, *StressScale(0.0).bounds[1:]]
    with Results.open(by_hand) as results:
        whole, last = Pressed.of(results, None), Pressed.of(results, 2)
        facts, arrays = colours(results, np.array([0, 2]))
    assert whole.compression[1] > 2e5 and last.compression[1] == 0.0 and last.compression[2] == 1e5
    assert last.closed_above.tolist() == whole.closed_above.tolist() == [False, True]
    assert arrays["pressed"][0].tolist() == [0, 0, 0] and arrays["pressed"][1, 0] == 0 and arrays["pressed"][1, 1] == 1
    assert arrays["pressed_most"][1] == len(facts["compression"]["colours"])


def test_vector_maps_colour_the_same_blocks_and_write_alike(by_hand, tmp_path):
    from reports.drawing.figure import save_polygons
    from reports.maps.stress_map import stress_scene

    with Results.open(by_hand) as results:
        paths = save_polygons(stress_scene(results, None, MapStyle()), tmp_path, "stress_map")
        once = [path.read_bytes() for path in paths]
        scene = stress_scene(results, None, replace(MapStyle(), thrust=True))
        again = [path.read_bytes() for path in save_polygons(scene, tmp_path, "stress_map")]
    assert [path.name for path in paths] == ["stress_map.svg", "stress_map.pdf"] and once == again
    assert b"<path" in once[0] and once[1].startswith(b"%PDF")


def test_paraview_has_tensors_and_principal_stresses(by_hand, tmp_path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    with Results.open(by_hand) as results:
        files = {path.name: path for path in export(results, tmp_path / "view")}

    def cells(name: str, step: int):
        reader = vtkHDFReader()
        reader.SetFileName(str(files[name]))
        reader.UpdateInformation()
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutputAsDataSet().GetCellData()
        return {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)).copy() for k in range(data.GetNumberOfArrays())}

    found = cells("blocks.vtkhdf", 1)
    low = found["block"] == 1
    assert found["stress"][low][0] == pytest.approx([-3e3, -1e3, -2e5, 0.0, 0.0, 4e4])
    assert found["principal_stress"][low][0].sum() == pytest.approx(-2.04e5) and np.isnan(found["stress"][found["block"] == 0]).all()
    assert cells("joints.vtkhdf", 1)["edge_stress"].tolist() == [2e5, 1e5]
    assert np.isnan(cells("joints.vtkhdf", 2)["edge_stress"][1])  # infinite, which has no colour


def test_python_has_the_stress_as_tables(tmp_path):
    import masonry_cd as mc

    run_case(prepare(scene(tmp_path, "compressive_strength = 1e5")), tmp_path / "out")
    found = mc.open(tmp_path / "out")
    table = found.stress()
    assert table.loc["b0", "zz"] == pytest.approx(-weight_above(0.5), rel=1e-6) and table.attrs["units"]["s3"] == "Pa"
    assert (table.loc[["b0", "b1"], "s3"] == table.loc[["b0", "b1"], ["s1", "s2", "s3"]].min(axis=1)).all() and table.loc[
        "base"
    ].isna().all()
    assert found.stress(0.0)["zz"].isna().all()
    assert found.block_stress.loc["b0", "ratio"] == pytest.approx(weight_above(0.5) / 1e5, rel=1e-6)
    assert found.block_stress.attrs["units"]["max_compression"] == "Pa"
    assert found.joint_stress["max_edge_stress"].max() == pytest.approx(weight_above(0), rel=1e-6)
    assert found.joint_history("edge_stress").attrs["units"]["0"] == "Pa"
    assert found.plot.stress_map().size[0] == found.plot.stress_map(0.05, view="side").size[0] == 1800


def test_the_page_has_a_section(tmp_path):
    prepared = prepare(scene(tmp_path, "compressive_strength = 3e4", 0.0, 0.1, "true", "report.html=true"))
    run_case(prepared, tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text()
    assert 'id="stress-title"' in page and "share of strength" in page and "34.3 kPa" in page and "1 of 4 blocks" in page
    run_case(prepare(scene(tmp_path, "", 0.0, 0.1, "false", "report.html=true")), tmp_path / "without")
    assert 'id="stress-title"' not in (tmp_path / "without" / "report.html").read_text()
