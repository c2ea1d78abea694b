# SPDX-License-Identifier: GPL-3.0-or-later
"""Block files: what is written comes back, what is wrong is named, files of other programs are read."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from places import SHARED

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.files import blockfile
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.prism import prism_xz, rectangle

PEERS = SHARED / "peers" / "scenes.py"


def cube(**changes: Any) -> dict[str, Any]:
    vertices, faces = prism_xz(rectangle(0, 1, 0, 1), 0, 1)
    return {"name": "c", "vertices": vertices.tolist(), "faces": [list(face) for face in faces], **changes}


def ball(**changes: Any) -> dict[str, Any]:
    return {"name": "s", "centre": [0.5, 0.5, 1.4], "radius": 0.5, **changes}


def saved(folder: Path, content: Any) -> Path:
    path = folder / "blocks.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_blocks_come_back_to_the_bit(tmp_path: Path) -> None:
    blocks = structures.build({"kind": "arch", "radius": 3.0, "thickness": 0.5, "voussoirs": 9}, 2100.0, tmp_path)
    blockfile.write(tmp_path / "arch.json", blocks)
    for here, there in zip(blocks, structures.build({"kind": "file", "path": "arch.json"}, 1.0, tmp_path), strict=True):
        assert here.vertices.tobytes() == there.vertices.tobytes()
        assert (here.name, here.faces, here.density, here.group, here.fixed) == (
            there.name,
            there.faces,
            there.density,
            there.group,
            there.fixed,
        )


def test_spheres_come_back_to_the_bit(tmp_path: Path) -> None:
    blocks = [*blockfile.read(saved(tmp_path, {"blocks": [cube(fixed=True)]}), 2000.0), Block.sphere("s", np.array([0.1, 0.2, 1.7]), 0.3)]
    blockfile.write(tmp_path / "blocks.json", blocks)
    there = blockfile.read(tmp_path / "blocks.json", 2000.0)[1]
    assert (there.radius, there.name, there.group, there.density) == (0.3, "s", "block", 2000.0)
    assert there.vertices.tobytes() == blocks[1].vertices.tobytes()
    assert there.faces == blocks[1].faces


def test_the_centre_and_the_radius_of_a_sphere_are_in_units_of_the_file(tmp_path: Path) -> None:
    (made,) = blockfile.read(saved(tmp_path, {"units": "cm", "blocks": [ball(centre=[50, 50, 140], radius=50)]}), 2000.0)
    assert made.radius == 0.5
    assert made.mass_properties.centre == pytest.approx([0.5, 0.5, 1.4])


def test_what_a_file_leaves_out_has_defaults(tmp_path: Path) -> None:
    ground = {key: value for key, value in cube(fixed=True).items() if key != "name"}
    block = {**ground, "fixed": False, "density": 1800, "vertices": (np.array(ground["vertices"]) + [0, 0, 1]).tolist()}
    first, second = blockfile.read(saved(tmp_path, {"blocks": [ground, block], "note": "ours"}), 2200.0)
    assert (first.name, first.group, first.density, first.fixed) == ("b0", "base", 2200.0, True)
    assert (second.name, second.group, second.density, second.fixed) == ("b1", "block", 1800.0, False)


@pytest.mark.parametrize(("units", "volume"), [("m", 1.0), ("cm", 1e-6), ("mm", 1e-9)])
def test_units_are_converted_to_metres(tmp_path: Path, units: str, volume: float) -> None:
    (block,) = blockfile.read(saved(tmp_path, {"units": units, "blocks": [cube()]}), 2000.0)
    assert mass_properties(block.vertices, block.faces).volume == pytest.approx(volume, rel=1e-12)


def test_faces_in_triangles_become_the_faces_of_the_block() -> None:
    vertices, faces = prism_xz(rectangle(0, 2, 0, 1), 0, 1)
    middle = np.concatenate([vertices, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]])  # in the middle of two edges of the lower face
    loops = [loop for face in faces[:2] + faces[3:] for loop in (face[:3], (face[0], *face[2:]))]
    loops = [tuple(loop) for loop in loops]
    # the front and back faces and the lower one share the middle vertices
    loops[0:4] = [(0, 8, 3), (8, 1, 2), (8, 2, 3), (7, 6, 9), (6, 5, 9), (7, 9, 4)]
    loops += [(8, 0, 4, 9), (1, 8, 9, 5)]
    block = Block("split", middle, tuple(loops), 2000.0)
    structures.geometry.checks.check([block])
    (whole,) = merge_coplanar([block])
    assert len(whole.vertices) == 8
    assert sorted(len(face) for face in whole.faces) == [4] * 6
    structures.geometry.checks.check([whole])
    assert mass_properties(whole.vertices, whole.faces).volume == pytest.approx(2.0, rel=1e-12)


def test_a_plain_block_is_left_as_it_is() -> None:
    block = Block("p", *prism_xz(rectangle(0, 1, 0, 1), 0, 1), 2000.0)
    assert merge_coplanar([block])[0] is block


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('{"blocks": [\n{"name": }]}', "blocks.json: line 2, column 10: Expecting value"),
        ('{"units": "m", "units": "mm", "blocks": []}', 'blocks.json: an object with the key "units" twice'),
        ("[1, 2]", 'blocks.json: must be an object with the key "blocks"'),
        ({"units": "m"}, 'blocks.json: "blocks" must be a list'),
        ({"units": "ft", "blocks": [cube()]}, 'blocks.json: unknown units "ft"'),
        ({"units": 3, "blocks": [cube()]}, 'blocks.json: unknown units "3"'),
        ({"units": ["m"], "blocks": [cube()]}, "blocks.json: unknown units"),
        ({"blocks": [7]}, "blocks.json: blocks[0]: must be an object"),
        ({"blocks": [cube(), cube()]}, 'blocks.json: block "c": two blocks have this name'),
        ({"blocks": [cube(densty=1.0)]}, 'blocks.json: block "c".densty: unknown key (did you mean "density"?)'),
        ({"blocks": [cube(density="1.9 m")]}, 'blocks.json: block "c".density: '),
        ({"blocks": [cube(density=-1.0)]}, 'blocks.json: block "c".density: input should be greater than 0'),
        ({"blocks": [cube(vertices=[[0, 0, "x"]] * 4)]}, 'blocks.json: block "c".vertices[0][2]: input should be a valid number'),
        ({"blocks": [cube(faces=cube()["faces"][:-1])]}, 'blocks.json: block "c": open shell'),
        ({"blocks": [cube(faces=[*cube()["faces"][:-1], [0, 1, 100]])]}, 'blocks.json: block "c": face 5 names a vertex outside 0 to 7'),
        ({"blocks": [cube(faces=[face[::-1] for face in cube()["faces"]])]}, 'blocks.json: block "c": its faces are reversed'),
        ({"blocks": [cube(), cube(name="d")]}, 'blocks.json: blocks "c" and "d": they overlap by 1000 mm'),
        ({"blocks": [ball(radius=0.0)]}, 'blocks.json: block "s".radius: input should be greater than 0'),
        ({"blocks": [{"name": "s", "radius": 1.0}]}, 'blocks.json: block "s".centre: missing'),
        ({"blocks": [ball(centre=[0, 0])]}, 'blocks.json: block "s".centre: list should have at least 3 items'),
        ({"blocks": [ball(vertices=[])]}, 'blocks.json: block "s".vertices: unknown key'),
        ({"blocks": [cube(), ball()]}, 'blocks.json: blocks "c" and "s": they overlap by 100 mm'),
        ({"blocks": [ball(), ball(name="t", centre=[0.5, 0.5, 2.2])]}, 'blocks.json: blocks "s" and "t": they overlap by 200 mm'),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path: Path, content: Any, message: str) -> None:
    with pytest.raises(InputError) as failure:
        structures.build({"kind": "file", "path": saved(tmp_path, content).name}, 2000.0, tmp_path)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "structure.kind: missing; one of aqueduct, arch, bridge, building, church, "),
        ({"kind": "aquaduct"}, 'structure.kind: unknown kind "aquaduct" (did you mean "aqueduct"?)'),
        ({"kind": ["arch"]}, "structure.kind: unknown kind"),
        ({"kind": "file"}, "structure.path: missing"),
        ({"kind": "file", "path": "none.json"}, 'structure.path: no file "none.json"'),
    ],
)
def test_kinds_and_paths_are_named(tmp_path: Path, table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as failure:
        structures.build(table, 2000.0, tmp_path)
    assert str(failure.value).startswith(message)


@pytest.mark.skipif(not PEERS.is_file(), reason="the scene generators of ../shared/peers are absent")
@pytest.mark.parametrize(("kind", "count"), [("arcade", 69), ("wall", 106), ("tower", 11), ("arch", 22), ("rocking", 2)])
def test_scenes_of_the_peers_are_read(tmp_path: Path, kind: str, count: int) -> None:
    spec = importlib.util.spec_from_file_location("peer_scenes", PEERS)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    blocks = blockfile.read(saved(tmp_path, module.KINDS[kind]()), 2000.0)
    assert len(blocks) == count
    assert {block.group for block in blocks} == {"base", "block"}


def test_a_bent_block_keeps_its_parts(tmp_path: Path) -> None:
    blocks = structures.build({"kind": "vault", "form": "cross", "voussoirs": 7}, 2100.0, tmp_path)
    blockfile.write(tmp_path / "cross.json", blocks)
    for one, other in zip(blocks, blockfile.read(tmp_path / "cross.json", 1.0), strict=True):
        assert one.name == other.name
        assert len(one.parts) == len(other.parts)
        assert one.vertices.tobytes() == other.vertices.tobytes()
        for part, again in zip(one.parts, other.parts, strict=True):
            assert part.faces == again.faces
            assert part.vertices.tobytes() == again.vertices.tobytes()


def test_a_moved_block_changes_nothing_else(tmp_path: Path) -> None:
    blocks = structures.build({"kind": "arch", "radius": 3.0, "thickness": 0.5, "voussoirs": 9}, 2100.0, tmp_path)
    moved = [replace(blocks[0], vertices=blocks[0].vertices + [0.0, 0.0, 0.01]), *blocks[1:]]
    blockfile.write(tmp_path / "moved.json", moved)
    with pytest.raises(InputError, match=r'moved\.json: blocks "v1" and "v2": they overlap'):
        blockfile.read(tmp_path / "moved.json", 2100.0)


def test_a_density_may_have_a_unit_of_its_own(tmp_path: Path) -> None:
    (block,) = blockfile.read(saved(tmp_path, {"units": "mm", "blocks": [cube(density="1.9 t/m3")]}), 2000.0)
    assert block.density == pytest.approx(1900.0)


def test_blocks_that_all_bring_their_density_need_none_of_the_material(tmp_path):
    bare, own = cube(name="bare"), cube(name="own", density=2000.0)
    bare["vertices"] = [[x + 3.0, y, z] for x, y, z in bare["vertices"]]
    (tmp_path / "blocks.json").write_text(json.dumps({"blocks": [own]}))
    (block,) = structures.build({"kind": "file", "path": "blocks.json"}, None, tmp_path)
    assert block.density == 2000.0
    (tmp_path / "blocks.json").write_text(json.dumps({"blocks": [own, bare]}))
    with pytest.raises(InputError, match='block "bare": brings no density of its own, and'):
        structures.build({"kind": "file", "path": "blocks.json"}, None, tmp_path)


def test_a_slight_overlap_names_what_mends_it_and_that_does(tmp_path):
    low, high = cube(name="low", density=2000.0), cube(name="high", density=2000.0)
    high["vertices"] = [[x, y, z + 1.0 - 6e-5] for x, y, z in high["vertices"]]
    (tmp_path / "blocks.json").write_text(json.dumps({"blocks": [low, high]}))
    table = {"kind": "file", "path": "blocks.json"}
    with pytest.raises(InputError, match=r"overlap by 0\.06 mm; of a file, structure\.gaps = 0\.0002 \[m\] brings their faces together"):
        structures.build(table, None, tmp_path)
    assert len(structures.build(table | {"gaps": 2e-4}, None, tmp_path)) == 2
