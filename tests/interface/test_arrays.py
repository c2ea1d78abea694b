# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks and base motions as arrays: the same blocks and motions as from files, and one line on what is wrong with them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from places import EXAMPLES
from two_blocks import shaking

import masonry_cd as mc
from loads import Loading
from masonry_cd.app.case import prepare


def loading_of(scene: mc.Scene) -> Loading:
    """The loads of a scene; its files are there as long as it is."""
    return prepare(scene.checked).loading


def test_pairs_dicts_and_blocks_are_the_same_blocks_as_those_of_a_file(tables: dict[str, Any], tmp_path: Path) -> None:
    corners = ((-2.0, -1.0, -0.5), (2.0, 1.0, 0.0)), ((-0.1, -0.1, 0.0), (0.1, 0.1, 1 / 3))
    plain = [{"vertices": v.tolist(), "faces": [list(face) for face in f]} for v, f in (mc.box(*c) for c in corners)]
    dicts = [plain[0] | {"name": "b0", "fixed": True}, plain[1] | {"density": None}]
    blocks = [
        mc.Block("b0", np.array(plain[0]["vertices"]), plain[0]["faces"], fixed=True),
        (plain[1]["vertices"], np.array(plain[1]["faces"])),
    ]
    (tmp_path / "own.json").write_text(json.dumps({"blocks": [plain[0] | {"fixed": True}, plain[1]]}))
    of_file = mc.scene(tables | {"structure": {"kind": "file", "path": tmp_path / "own.json"}}).structure
    for structure in (dicts, blocks, {"blocks": [(p["vertices"], p["faces"]) for p in plain], "fixed": ["b0"]}):
        made = mc.scene(tables | {"structure": structure}).structure
        for one, other in zip(made, of_file, strict=True):
            assert (one.name, one.group, one.fixed, one.density) == (other.name, other.group, other.fixed, other.density)
            assert np.array_equal(one.vertices, other.vertices)
            assert one.faces == other.faces


def test_spheres_stand_next_to_polyhedra(tables: dict[str, Any]) -> None:
    ground, ball = mc.box((-1, -1, -1), (1, 1, 0)), {"centre": np.array([0.0, 0.0, 0.3]), "radius": 0.3, "group": "balls"}
    made = mc.scene(tables | {"structure": {"blocks": [ground, ball], "fixed": "b0"}}).structure
    again = mc.scene(tables | {"structure": list(made)}).structure
    for one in (made["b1"], again["b1"]):
        assert (one.radius, one.group, one.vertices[0].tolist()) == (0.3, "balls", [0.0, 0.0, 0.3])
    assert made.table["volume"].iloc[1] == pytest.approx(4 / 3 * np.pi * 0.027)


def test_keys_of_a_structure_stand_next_to_its_blocks(tables: dict[str, Any]) -> None:
    apart = [mc.box((-1, -1, -1), (1, 1, 0)), mc.box((-0.3, -0.3, 0.001), (0.3, 0.3, 1))]
    made = mc.scene(tables | {"structure": {"blocks": apart, "fixed": "b0", "gaps": 0.002}}).structure
    assert made["b0"].vertices[:, 2].max() == pytest.approx(made["b1"].vertices[:, 2].min(), abs=1e-15)
    assert "corners moved" in made.notes[0]


def test_blocks_and_a_file_exclude_each_other(tables: dict[str, Any]) -> None:
    for more in ({"path": "a.json"}, {"kind": "arch"}):
        with refused_at("structure.blocks"):
            mc.scene(tables | {"structure": tables["structure"] | more})
    with refused_at("structure.fixed"):
        mc.scene(tables | {"structure": tables["structure"] | {"fixed": "plate"}})


def test_a_reversed_block_is_refused_by_name(tables: dict[str, Any]) -> None:
    vertices, faces = mc.box((-0.3, -0.3, 0), (0.3, 0.3, 1))
    made = mc.scene(tables | {"structure": [mc.box((-1, -1, -1), (1, 1, 0)), (vertices, [face[::-1] for face in faces])]})
    with refused_at("blocks.json"):
        _ = made.structure


@pytest.mark.parametrize("components", [1, 2, 3])
def test_a_motion_by_arrays_is_that_of_a_record(tables: dict[str, Any], tmp_path: Path, components: int) -> None:
    motion = shaking(components) | ({"direction": "x"} if components == 1 else {})
    by_arrays = loading_of(mc.scene(tables | {"loads": [motion]}))
    table = np.column_stack([motion["time"], motion["acceleration"]])
    np.savetxt(
        tmp_path / "own.csv", table, fmt="%.17g", delimiter=",", header=",".join(["time_s", "x_m_s2", "y_m_s2", "z_m_s2"][: 1 + components])
    )
    records = [
        {"kind": "record", "path": str(tmp_path / "own.csv"), "column": axis, "direction": axis, "correction": "none"}
        for axis in "xyz"[:components]
    ]
    by_file = loading_of(mc.scene(tables | {"loads": records}))
    assert np.array_equal(by_arrays.support_velocity, by_file.support_velocity)
    assert by_arrays.support_velocity[:, 0, components - 1].any()


OWN_KINDS = [
    {"kind": "pulse", "direction": "x", "acceleration": 2.0, "duration": 0.05},
    {"kind": "settlement", "supports": "b0", "displacement": 1e-3, "duration": 1.0},
    {"kind": "gravity", "ramp": 0.01},
]


@pytest.mark.parametrize("load", OWN_KINDS, ids=[load["kind"] for load in OWN_KINDS])
def test_other_kinds_have_their_own_keys_of_these_names(tables: dict[str, Any], load: dict[str, Any]) -> None:
    made = mc.scene(tables, loads=[load])
    assert made.tables["loads"] == [load]
    both = made.changed(loads=[load, shaking() | {"direction": "x"}])
    assert [table.get("kind") for table in loading_of(both).summary["tables"][:2]] == [load["kind"], "record"]


def test_arrays_are_those_of_a_record_and_other_kinds_refuse_them(tables: dict[str, Any]) -> None:
    wave = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 1}
    with refused_at("loads[0].time"):
        loading_of(mc.scene(tables, loads=[wave | {"time": np.arange(5.0)}]))


@pytest.mark.parametrize(("quantity", "power"), [("velocity", 1), ("displacement", 2)])
def test_velocities_and_displacements_are_differentiated(tables: dict[str, Any], quantity: str, power: int) -> None:
    time, w = np.arange(0.0, 2.0005, 1e-3), 10.0 * np.pi
    swell = np.sin(np.pi * time / 2.0) ** 2 * np.sin(w * time)
    made = mc.scene(tables, loads=[{"kind": "record", "direction": "x", "time": time, quantity: 0.01 * swell, "correction": "none"}])
    summary = loading_of(made).summary["tables"][0]
    assert (summary["quantity"], made.tables["loads"][0]["quantity"]) == (quantity, quantity)
    assert summary["before"]["pga"] == pytest.approx(0.01 * w**power, rel=0.01)


def test_a_sequence_takes_arrays_as_components(tables: dict[str, Any]) -> None:
    one = {key: value for key, value in shaking(2).items() if key != "kind"}
    made = mc.scene(
        tables,
        loads=[{"kind": "sequence", "rest": 0.1, "shocks": [{"components": [one]}, {"components": [one | {"correction": "linear"}]}]}],
    )
    loading = loading_of(made)
    assert [len(shock["components"]) for shock in loading.summary["tables"][0]["shocks"]] == [2, 2]
    assert [[c["direction"] for c in s["components"]] for s in made.tables["loads"][0]["shocks"]] == [["x", "y"]] * 2


def test_a_component_of_zeros_is_left_out(tables: dict[str, Any]) -> None:
    motion = shaking(3)
    motion["acceleration"][:, 1] = 0.0
    made = mc.scene(tables | {"loads": [motion]})
    assert [load["direction"] for load in made.tables["loads"]] == ["x", "z"]


def test_times_that_are_uneven_are_refused_in_the_words_of_the_reader(tables: dict[str, Any]) -> None:
    motion = shaking() | {"direction": "x"}
    motion["time"] = motion["time"] + np.where(motion["time"] > 0.2, 0.1, 0.0)
    made = mc.scene(tables | {"loads": [motion]})
    with refused_at("loads[0].path: motion1.csv, line 203"):
        prepare(made.checked)


def test_arrays_in_the_scene_of_a_file_leave_its_other_files_where_they_are() -> None:
    made = mc.scene(EXAMPLES / "trilithon.toml", loads=[shaking() | {"direction": "x"}])
    assert made.tables["structure"]["path"] == str((EXAMPLES / "trilithon.json").absolute())
    assert made.tables["loads"][0]["path"] == "motion1.csv"
    assert prepare(made.checked).assembly.count == 4


def test_structures_side_by_side_are_of_files_wherever_they_run(tables: dict[str, Any], tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    mc.scene(tables).write(tmp_path / "one.toml")
    rest = {key: item for key, item in tables.items() if key != "structure"}
    places = [{"name": "a"}, {"name": "b", "at": [9.0, 0.0, 0.0]}]
    two = mc.scene(rest | {"structures": [{"kind": "file", "path": "blocks.json"} | place for place in places]})
    assert len(two.structure) == 2 * len(mc.scene(tables).structure)
    with refused_at("structures[1].blocks"):
        mc.scene(EXAMPLES / "two_piers.toml", structures=[{"kind": "arch"} | places[0], tables["structure"] | places[1]])


def test_changes_keep_the_arrays(tables: dict[str, Any]) -> None:
    first = mc.scene(tables | {"loads": [shaking() | {"direction": "x"}]})
    again = first.changed("run.duration=0.2", "loads[0].scale=2.0")
    assert np.array_equal(first.structure["b2"].vertices, again.structure["b2"].vertices)
    other = again.changed(loads=[shaking(3)])
    assert [load["path"] for load in other.tables["loads"]] == ["motion2.csv"] * 3
    assert np.abs(loading_of(again).support_velocity).max() > 0.2
