# SPDX-License-Identifier: GPL-3.0-or-later
"""Exchange with other programs, of runs and scenes and into scenes: blocks, meshes, traces."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mesh_files
import numpy as np
import pytest
from hostile import refused_at

import masonry_cd as mc
from masonry_cd.app.case import prepare
from structures.files.formats import format_of

WEIGHT = 0.4 * 0.4 * 0.8 * 2000.0 * 9.81  # of b2 [N]; b1 has half of it


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> mc.Run:
    """Two blocks at rest."""
    from two_blocks import two_blocks

    tables = {key: value for key, value in two_blocks().items() if key != "loads"}
    return mc.run(tables, tmp_path_factory.mktemp("rest") / "run", progress=False)


def test_forces_and_reactions_are_vectors_that_carry_the_weight(run: mc.Run) -> None:
    forces = run.joint_forces()
    above = forces[forces["block_b"] == "b2"].iloc[0]
    assert above["fz"] == pytest.approx(WEIGHT, rel=1e-6) and above["z"] == pytest.approx(0.4)
    assert abs(above["fx"]) < 1e-6 * WEIGHT and forces.attrs["units"]["fz"] == "N"
    base = run.reactions().loc["b0"]
    assert base["fz"] == pytest.approx(1.5 * WEIGHT, rel=1e-6) and abs(base["mx"]) < 1e-4 * WEIGHT


def test_the_line_of_thrust_goes_down_the_middle(run: mc.Run) -> None:
    thrust = run.thrust()
    assert thrust.lines.shape == (len(thrust.force), 2, 3) and len(thrust.force)
    assert np.abs(thrust.lines[:, :, :2]).max() < 1e-3
    assert set(thrust.block.tolist()) <= {1, 2}
    assert thrust.force.max() == pytest.approx(1.5 * WEIGHT, rel=1e-6)


def test_variables_of_a_dataset_fit_their_dimensions(run: mc.Run) -> None:
    pytest.importorskip("xarray")
    made = run.to_xarray()
    size = {"time": len(run.time), "block": 3, "joint": 2, "support": 1, "axis": 3, "quaternion": 4}
    assert dict(made.sizes) == size | {"velocity_component": 6, "reaction_component": 6}
    assert {"position", "force", "reaction", "opening"} <= set(made)
    assert made.opening.attrs["units"] == "m" and made.opening.dims == ("time", "joint")
    weight = made.reaction.sel(support="b0", reaction_component="fz").isel(time=-1)
    assert float(weight) == pytest.approx(run.reactions().iloc[0]["fz"], rel=1e-12)


def test_meshes_lie_where_the_blocks_are(run: mc.Run) -> None:
    pytest.importorskip("pyvista")
    mesh = run.mesh()
    assert mesh.n_cells == 18 and np.allclose(mesh.bounds, (-2, 2, -1, 1, -0.5, 1.2), atol=1e-6)
    trimesh = pytest.importorskip("trimesh")
    scene = run.to_trimesh(0.0)
    assert isinstance(scene, trimesh.Scene) and set(scene.geometry) == {"b0", "b1", "b2"}
    for blocks in (scene, scene.dump()):  # and back, by their names
        again = mc.scene(
            structure={"blocks": blocks, "fixed": "b0"}, material={"density": 2000.0, "friction": 0.5}, run={"dt": 0.1}
        ).structure
        assert set(again.names) == {"b0", "b1", "b2"} and again["b0"].fixed
        assert again["b1"].vertices.mean(axis=0) == pytest.approx(scene.geometry["b1"].vertices.mean(axis=0))
    assert scene.geometry["b2"].volume == pytest.approx(0.128)


def test_a_block_becomes_traces_and_traces_a_motion(run: mc.Run, tables: dict[str, Any]) -> None:
    obspy = pytest.importorskip("obspy")
    stream = run.to_traces("b1")
    assert [trace.stats.channel for trace in stream] == ["X", "Y", "Z"] and stream[0].stats.delta == pytest.approx(0.02)
    time = np.arange(0.0, 0.4, 0.005)
    east, up = np.sin(20.0 * time) * np.sin(math.pi * time / 0.4), 0.1 * np.cos(20.0 * time)
    header = {"delta": 0.005}
    both = obspy.Stream([obspy.Trace(east, {**header, "channel": "HNE"}), obspy.Trace(up, {**header, "channel": "HNZ"})])
    table = mc.from_traces(both, scale=2.0, correction="none")
    assert np.allclose(table["acceleration"], 2.0 * np.column_stack([east, 0.0 * east, up]))
    assert "motion1.csv" in mc.scene(tables, loads=[table]).text
    single = mc.from_traces(both[0], direction="y")
    assert single["direction"] == "y" and single["acceleration"].shape == (80,)
    for bad, words in (
        (lambda: mc.from_traces(both[0]), "direction: missing"),
        (lambda: mc.from_traces([both[0], both[0]]), "an overlap of 0.4 s in ...HNE"),
        (lambda: mc.from_traces([both[0], obspy.Trace(east, {**header, "channel": "HGE"})]), "both along x"),
        (lambda: mc.from_traces(stream, scale=2.0), r"quantity: missing, .*X is a record of velocity \(what was done to it, quantity=vel"),
        (lambda: mc.from_traces(obspy.Stream([both[0], both[1].copy().trim(endtime=both[1].stats.endtime - 0.1)])), "lengths"),
        (lambda: mc.from_traces(both, axes={"HNE": "x"}), "channel HNZ is along x, y or z"),
        (lambda: mc.from_traces([1.0]), "a Trace of obspy"),
        (lambda: run.to_traces("b7"), 'no block is named "b7"'),
        (lambda: run.to_traces("b1", "jerk"), '"jerk" is none'),
    ):
        with pytest.raises(mc.InputError, match=words):
            bad()


def test_compas_data_goes_round(tables: dict[str, Any], tmp_path: Path) -> None:
    scene = mc.scene(tables)
    path = tmp_path / "blocks.json"
    path.write_text(json.dumps(scene.to_compas()), encoding="utf-8")
    again = mc.scene(tables, structure={"kind": "file", "blocks": mc.from_compas(path)})
    assert again.structure.names == scene.structure.names
    for one, other in zip(scene.structure, again.structure, strict=True):
        assert np.array_equal(one.vertices, other.vertices) and one.faces == other.faces
        assert (one.fixed, one.group) == (other.fixed, other.group)


def test_meshes_are_found_wherever_a_model_holds_them(tmp_path: Path) -> None:
    corners, faces = mc.box((0, 0, 0), (1, 1, 1))
    vertex = {str(10 + i): dict(zip("xyz", map(float, corner), strict=True)) for i, corner in enumerate(corners)}
    data = {"attributes": {}, "vertex": vertex, "face": {str(i): [10 + v for v in loop] for i, loop in enumerate(faces)}}
    element = {
        "dtype": "compas_dem.elements/Block",
        "data": {"is_support": True, "geometry": {"dtype": "compas.datastructures/Mesh", "data": data}},
    }
    found = mc.from_compas(
        {"dtype": "compas_dem.models/BlockModel", "data": {"elements": [element, {"data": {"geometry": {"data": data}}}]}}
    )
    assert [(block["name"], block["fixed"]) for block in found] == [("b0", True), ("b1", False)]
    assert np.array_equal(found[0]["vertices"], corners) and [tuple(loop) for loop in found[0]["faces"]] == list(faces)
    old = mc.from_compas(json.loads(mesh_files.compas_0()))  # of version 0: nodes next to blocks, keys as texts
    assert [(block["name"], block["fixed"]) for block in old] == [("Block", True), ("Block_1", False)]
    (tmp_path / "mesh.json").write_text(mesh_files.compas_0(assembly=False), encoding="utf-8")
    assert [len(block["faces"]) for block in mc.from_compas(tmp_path / "mesh.json")] == [6]
    assert format_of(tmp_path / "mesh.json") == "compas"
    data["face"]["0"] = [99, 10, 11]
    with pytest.raises(mc.InputError, match='mesh 0, "b0": its vertices and faces do not fit'):
        mc.from_compas(data)
    with pytest.raises(mc.InputError, match="no mesh of COMPAS"):
        mc.from_compas({"a": [1, 2]})
    (tmp_path / "bad.json").write_text("{", encoding="utf-8")
    with refused_at("bad.json"):
        mc.from_compas(tmp_path / "bad.json")


def test_blocks_come_from_anything_with_vertices_and_faces(tables: dict[str, Any]) -> None:
    corners, faces = mc.box((-0.2, -0.2, 0), (0.2, 0.2, 0.4))
    row = np.concatenate([[len(loop), *loop] for loop in faces])
    shapes = [
        SimpleNamespace(name="stone", vertices=corners, faces=faces),
        SimpleNamespace(points=corners, faces=row),
        SimpleNamespace(to_vertices_and_faces=lambda: (corners.tolist(), [list(loop) for loop in faces])),
    ]
    for shape, name in zip(shapes, ("stone", "b1", "b1"), strict=True):
        made = mc.scene(tables, structure={"blocks": [mc.box((-2, -1, -0.5), (2, 1, 0)), shape], "fixed": "b0"}).structure
        assert made.names == ["b0", name] and np.array_equal(made[1].vertices, corners) and made[1].faces == faces


def test_an_acceleration_may_be_a_function_of_time(tables: dict[str, Any]) -> None:
    time = np.arange(0.0, 0.2, 0.01)
    given = {"kind": "record", "time": time, "direction": "x", "correction": "none"}
    by_function = mc.scene(tables, loads=[{**given, "acceleration": lambda t: math.sin(9.0 * t)}])
    by_array = mc.scene(tables, loads=[{**given, "acceleration": [math.sin(9.0 * t) for t in time.tolist()]}])
    assert by_function.portable()[1] == by_array.portable()[1]


STEP = 0.005
TIME = STEP * np.arange(801)
WAVE = np.sin(np.pi * TIME / 4.0) ** 2 * np.sin(12.0 * TIME)


def trace(channel: str = "HNE", data: Any = WAVE, **stats: Any) -> SimpleNamespace:
    """A value with the attributes of a trace of obspy."""
    about = SimpleNamespace(delta=STEP, channel=channel, **({"starttime": 0.0} | stats))
    return SimpleNamespace(data=np.asanyarray(data), stats=about, id=f"XX.SITE..{channel}")


COUNTS = np.round(1e4 * WAVE).astype(np.int32)


@pytest.mark.parametrize(
    ("traces", "keys", "message"),
    [
        (trace("HHE"), {}, r"\.quantity: missing, .*HHE is a record of velocity"),
        (trace("BHZ"), {}, r"\.quantity: missing, .*BHZ is a record of velocity"),
        (trace("HLE"), {}, r"\.quantity: missing, .*low-gain sensor"),
        ([trace("HHE"), trace("HHN")], {}, r"\.quantity: missing"),
        (trace(data=COUNTS), {}, r"\.calibration: missing, .*HNE holds whole numbers"),
        ([trace(), trace("HNN", COUNTS)], {}, r"\.calibration: missing, .*HNN holds"),
        (trace(processing=["remove_response(output='VEL')"]), {}, r"\.quantity: missing, .* of velocity"),
        (trace(processing=["ObsPy 1.4: integrate(method='cumtrapz')"]), {}, r"\.quantity: missing, .* of velocity"),
        (trace("HHE"), {"quantity": "velocity", "units": "m/s2"}, r'\.units: "m/s2" is a unit of acceleration'),
        (trace(), {"units": "furlong"}, r"\.units: unknown unit"),
        (trace(), {"quantity": "jerk"}, r'quantity: "jerk" is none'),
        (trace(data=np.where(TIME == 1.0, np.nan, WAVE)), {}, "sample 201 of XX.SITE..HNE is not a finite number"),
        (trace(data=np.ma.masked_greater(WAVE, 0.9)), {}, "HNE has gaps"),
        ([trace(), trace(starttime=9.0)], {}, "a gap of 4.995 s"),
        (trace(data=1e300 * WAVE), {}, "an acceleration of"),
        (trace(data=[["a"]]), {}, "a row of real numbers is needed"),
    ],
)
def test_what_a_file_would_be_refused_for_a_trace_is_refused_for(traces: Any, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(mc.InputError, match=message):
        mc.from_traces(traces, direction="x", **keys)


@pytest.mark.parametrize(
    ("given", "keys", "factor"),
    [
        (trace(), {}, 1.0),
        (trace(), {"units": "cm/s2"}, 0.01),
        (trace(), {"scale": 2.0}, 2.0),
        (trace(data=COUNTS), {"scale": 1e-4}, 1.0),
        (trace(data=COUNTS), {"calibration": 1e-4}, 1.0),
        (trace(data=COUNTS), {"calibration": 1e-2, "units": "gal"}, 1.0),
        (trace("HHE"), {"quantity": "acceleration"}, 1.0),
        (trace("HHE", processing=["remove_response(output='ACC')"]), {}, 1.0),
        (trace("HHE", processing=["ObsPy 1.4: differentiate(method='gradient')"]), {}, 1.0),
        ([trace(data=WAVE[:400]), trace(data=WAVE[400:], starttime=2.0)], {}, 1.0),
    ],
)
def test_what_is_said_of_a_trace_counts(given: Any, keys: dict[str, Any], factor: float) -> None:
    found = mc.from_traces(given, direction="x", **keys)
    assert found["acceleration"] == pytest.approx(factor * WAVE, abs=1e-4)


def test_a_velocity_is_differentiated_on_request() -> None:
    found = mc.from_traces(trace("HHE"), direction="x", quantity="velocity")
    assert found["acceleration"][200:600] == pytest.approx(np.gradient(WAVE, STEP)[200:600], abs=0.02)


def test_channels_keep_their_names(tables: dict[str, Any]) -> None:
    made = mc.scene(tables, loads=[mc.from_traces([trace(), trace("HNZ", 0.5 * WAVE)])])
    assert [(load["column"], load["direction"]) for load in made.tables["loads"]] == [("XX.SITE..HNE", "x"), ("XX.SITE..HNZ", "z")]
    assert [one["column"] for one in prepare(made.checked).loading.summary["tables"][:2]] == ["XX.SITE..HNE", "XX.SITE..HNZ"]
