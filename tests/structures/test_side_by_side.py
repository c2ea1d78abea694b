# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.site: several structures in one scene stand where their tables say, on one ground, and each behaves as it does alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import advance, stepper

import structures
from masonry_cd.analysis.damage.part_damage import part_damage
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures import site
from structures.files import blockfile

PIER = {"kind": "wall", "length": 1.0, "height": 2.0, "thickness": 1.0, "course_height": 0.5, "unit_length": 0.5}
ARCH = {"kind": "arch", "radius": 2.0, "thickness": 0.3, "voussoirs": 11}
WEIGHT = {"density": 2000.0, "friction": 0.6}
SHAKE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 2.0, "cycles": 1}


def build(*tables: dict[str, Any], folder: Path = Path()) -> list[Block]:
    return site.build(tables, 2000.0, folder).blocks


def of(blocks: list[Block], name: str) -> list[Block]:
    return [block for block in blocks if block.structure == name]


def run(folder: Path, scene: dict[str, Any]) -> dict[str, Any]:
    """Run a scene and return its summary."""
    folder.mkdir(exist_ok=True)
    (folder / "scene.toml").write_text(dump_toml(scene))
    return run_case(prepare(read_scene(folder / "scene.toml")), folder / "out")


def places(folder: Path, name: str = "") -> np.ndarray:
    """Displacements (F, B, 3) of the blocks of a structure, the first frame taken off."""
    with Results.open(folder / "out" / "result.h5") as results:
        mine = [i for i, block in enumerate(results.blocks) if block.structure == name]
        position = results.position[: results.frames][:, mine]
        return np.asarray(position - position[0])


def test_each_stands_at_its_place_under_its_name():
    arch = ARCH | {"ground": False}
    alone = structures.build(arch, 2000.0, Path())
    blocks = build(
        {"name": "a", **arch}, {"name": "b", **arch, "at": [10.0, 2.0, 1.0], "rotate": 90}, {"name": "c", **arch, "at": [0, 9, 0]}
    )
    assert [block.name for block in of(blocks, "b")] == [f"b.{block.name}" for block in alone]
    assert {block.group for block in of(blocks, "b")} == {"b.arch", "b.base"}
    for own, there, moved in zip(alone, of(blocks, "a"), of(blocks, "b"), strict=True):
        assert (there.vertices == own.vertices).all()  # to the bit
        x, y, z = own.vertices.T
        assert (moved.vertices == np.stack([10.0 - y, 2.0 + x, 1.0 + z], axis=1)).all()


def test_arches_side_by_side_stand_on_one_ground():
    """The slabs under their abutments meet halfway between them."""
    blocks = build({"name": "a", **ARCH}, {"name": "b", **ARCH, "at": [6.0, 0.0, 0.0]})
    ends = {block.structure: block.vertices[:, 0] for block in blocks if block.name.endswith("ground")}
    assert ends["a"].max() == pytest.approx(3.0)
    assert ends["b"].min() == pytest.approx(3.0)


def test_a_turn_of_any_angle_keeps_shapes():
    (own,) = (block for block in build({"name": "a", **PIER, "rotate": 30.0}) if block.name == "a.wall.1.1")
    before = next(block for block in structures.build(PIER, 2000.0, Path()) if block.name == "wall.1.1")
    assert mass_properties(own.vertices, own.faces).volume == pytest.approx(
        mass_properties(before.vertices, before.faces).volume, rel=1e-12
    )
    assert np.hypot(*own.vertices[:, :2].T) == pytest.approx(np.hypot(*before.vertices[:, :2].T))


def test_grounds_that_overlap_meet_halfway_and_leave_no_hole():
    blocks = build({"name": "a", **PIER}, {"name": "b", **PIER, "at": [1.5, 0.0, 0.0]}, {"name": "c", **PIER, "at": [40.0, 0.0, 0.0]})
    grounds = {block.structure: block for block in blocks if block.fixed}
    reach = structures.build(PIER, 2000.0, Path())[-1].vertices
    a, b = grounds["a"].vertices, grounds["b"].vertices
    assert a[:, 0].max() == b[:, 0].min() == pytest.approx(0.75)  # between 0.5 and 1.0 m
    assert (a[:, 0].min(), b[:, 0].max()) == pytest.approx((reach[:, 0].min(), 1.5 + reach[:, 0].max()))
    assert (grounds["c"].vertices == reach + [40.0, 0.0, 0.0]).all()  # far from both
    plan = sum(np.ptp(v[:, 0]) * np.ptp(v[:, 1]) for v in (a, b))
    assert plan == pytest.approx((b[:, 0].max() - a[:, 0].min()) * np.ptp(reach[:, 1]))


def test_the_ground_of_a_turned_neighbour_is_parted_where_the_space_is_widest():
    blocks = build({"name": "a", **PIER}, {"name": "b", **PIER, "at": [1.3, 1.3, 0.0], "rotate": 45.0})
    a, b = (next(block.vertices for block in of(blocks, name) if block.fixed) for name in "ab")
    along = np.array([1.0, 1.0]) / np.sqrt(2.0)
    halfway = 0.5 * (1.0 + 2.6 - 1.0) / np.sqrt(2.0)  # corner (0.5, 0.5) of one, face of the other 0.5 m before its middle
    low, high = (a[:, :2] @ along).max(), (b[:, :2] @ along).min()
    assert low == pytest.approx(high)
    assert low == pytest.approx(0.5 * (np.sqrt(0.5) + 1.3 * np.sqrt(2.0) - 0.5))
    assert abs(low - halfway) < 0.3


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ([{**PIER}], "structures[0].name: missing"),
        ([{"name": "a-b", **PIER}], "structures[0].name: string should match pattern"),
        ([{"name": "a", **PIER}, {"name": "a", **PIER}], 'structures[1].name: "a" is given twice'),
        ([{"name": "a", **PIER, "at": [1.0, 2.0]}], "structures[0].at: should be three numbers [x, y, z]"),
        ([{"name": "a", **PIER, "at": [1e9, 0, 0]}], "structures[0].at: should be numbers up to 100000 m"),
        ([{"name": "a", **PIER}, {"name": "b", **PIER, "hight": 2.0, "at": [9, 0, 0]}], "structures[1].hight: unknown key"),
        ([{"name": "a", **PIER}, {"name": "b", **PIER, "at": [0.5, 0, 0]}], 'structures: "a" and "b" overlap in plan by 0.5 m'),
        ([{"name": "a", "kind": "arc"}], 'structures[0].kind: unknown kind "arc" (did you mean "arch"?)'),
        ([{"name": "a", **ARCH}, {"name": "b", **ARCH, "at": [1.0, 0.0, 0.0]}], 'structures: "a" and "b" overlap in plan by'),
    ],
)
def test_what_is_wrong_is_named(tables, message):
    with pytest.raises(InputError) as failure:
        build(*tables)
    assert str(failure.value).startswith(message)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"structure": PIER, "structures": [{"name": "a", **PIER}]}, "structures: there is a [structure] as well"),
        ({}, "structure: missing"),
        ({"structures": [{"name": "a", **PIER, "height": -1.0}]}, "structures[0].height: "),
        ({"structures": {"name": "a"}}, "structures: every structure is a table of its own, headed [[structures]]"),
    ],
)
def test_a_scene_names_line_and_key(tmp_path, scene, message):
    (tmp_path / "s.toml").write_text(dump_toml({**scene, "material": WEIGHT, "run": {"dt": 1e-3, "duration": 0.1}}))
    with pytest.raises(InputError, match=r"^\S*s\.toml(:\d+)?: ") as failure:
        prepare(read_scene(tmp_path / "s.toml"))
    assert f": {message}" in str(failure.value)


def test_friction_by_patterns_of_groups(tmp_path):
    scene = {"structures": [{"name": "a", **ARCH}, {"name": "b", **ARCH, "at": [10, 0, 0]}], "run": {"dt": 1e-3, "duration": 0.1}}
    scene["material"] = {"density": 2000.0, "friction": {"b.arch-b.base": 0.2, "default": 0.5, "*arch-*base": 0.9}}
    (tmp_path / "s.toml").write_text(dump_toml(scene))
    assembly = prepare(read_scene(tmp_path / "s.toml")).assembly
    table = {(a, b): assembly.friction[i, j] for i, a in enumerate(assembly.groups) for j, b in enumerate(assembly.groups)}
    assert table["a.arch", "a.arch"] == 0.5
    assert table["a.arch", "a.base"] == table["b.base", "a.arch"] == 0.9
    assert table["b.arch", "b.base"] == 0.2  # by name before patterns


def test_one_of_several_at_the_origin_has_the_bits_of_one_alone_and_elsewhere_its_results(tmp_path):
    rest = {"material": WEIGHT, "loads": [SHAKE], "run": {"dt": 2e-3, "duration": 0.4, "tolerance": 1e-10}}
    run(tmp_path / "alone", {"structure": ARCH, **rest})
    run(tmp_path / "one", {"structures": [{"name": "a", **ARCH}], **rest})
    alone = places(tmp_path / "alone")
    assert (places(tmp_path / "one", "a") == alone).all()
    run(tmp_path / "two", {"structures": [{"name": "a", **ARCH, "at": [12.3, 0.0, 0.7]}, {"name": "b", **ARCH, "at": [-6, 0, 0]}], **rest})
    moved = np.abs(alone - alone[:, -1:]).max()
    assert moved > 2e-4  # relative to the abutment: the arch rocks
    for name in "ab":
        assert np.abs(places(tmp_path / "two", name) - alone).max() < 1e-7


def test_two_that_meet_keep_momentum_and_book_the_energy_they_lose(tmp_path):
    """Perfectly plastic: 1 m/s and rest become a common speed v = m1 / (m1 + m2), the loss is m1 m2 / (m1 + m2) / 2."""
    one = structures.build({**PIER, "height": 0.5, "unit_length": 1.0}, 2000.0, Path())[0]
    blockfile.write(tmp_path / "a.json", [one])
    table = {"kind": "file", "path": "a.json"}
    blocks = build({"name": "a", **table}, {"name": "b", **table, "at": [1.1, 0.0, 0.0]}, folder=tmp_path)
    pair = [blocks[0], Block("b.wall", blocks[1].vertices, blocks[1].faces, 3000.0, "b.wall", structure="b")]
    machine = stepper(pair, 300, acceleration=np.zeros((301, 3)), solver="auto")
    machine.kick(np.array([[1.0, 0, 0, 0, 0, 0], [0.0, 0, 0, 0, 0, 0]]))
    advance(machine, 200)
    masses = machine.assembly.mass
    common = masses[0] / masses.sum()
    assert machine.state.velocity[:, 0] == pytest.approx([common, common], rel=1e-9)
    assert machine.state.position[1, 0] - machine.state.position[0, 0] == pytest.approx(1.0, abs=1e-6)  # face on face
    assert machine.energy["impact"] == pytest.approx(0.5 * masses[0] * masses[1] / masses.sum(), rel=1e-9)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["impact"]


def test_damage_has_a_row_for_each_structure(tmp_path):
    """Only the slender one of two piers far apart rocks, and its row says so."""
    slender = {**PIER, "length": 0.25, "unit_length": 0.25, "height": 2.5}
    scene = {
        "structures": [{"name": "stout", **PIER}, {"name": "slender", **slender, "at": [8.0, 0.0, 0.0]}],
        "material": WEIGHT,
        "loads": [{**SHAKE, "amplitude": 0.25, "frequency": 1.0}],
        "run": {"dt": 2e-3, "duration": 1.2, "tolerance": 1e-6},
    }
    run(tmp_path, scene)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        rows = {row["part"]: row for row in part_damage(results).parts}
        assert {block.structure for block in results.blocks} == {"stout", "slender"}
    assert list(rows) == ["stout.wall", "slender.wall", "stout", "slender", "structure"]
    assert rows["stout"]["blocks"] + rows["slender"]["blocks"] == rows["structure"]["blocks"]
    assert rows["stout"]["joints"] + rows["slender"]["joints"] == rows["structure"]["joints"]
    assert rows["slender"]["max_opening"] == rows["structure"]["max_opening"] > 1e-3 > rows["stout"]["max_opening"]
