# SPDX-License-Identifier: GPL-3.0-or-later
"""Formats of other programs: two boxes that share corners come as two blocks; what is written comes back; endings and content agree."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mesh_files as files
import numpy as np
import pytest
from command_line import masonry_cd
from models import tower
from solids import build as built

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties, triangles
from structures.files import meshfile
from structures.files.formats import FORMATS, format_of
from structures.files.shells import shells
from structures.geometry.prism import box as box_part

METRES = {"units": "m", "up": "z"}


def build(folder: Path, name: str, **keys: Any) -> list[Block]:
    return structures.build({"kind": "file", "path": name, **keys}, 2000.0, folder)


def boxes(folder: Path, name: str, content: str | bytes = "", **keys: Any) -> list[Block]:
    """The two boxes of a file, checked by their volumes and places."""
    if content:
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    made = build(folder, name, **keys)
    found = [mass_properties(block.vertices, block.faces) for block in made]
    assert [one.volume for one in found] == pytest.approx(files.SIZES)
    assert [one.centre for one in found] == [pytest.approx([1.0, 0.5, 0.5]), pytest.approx([0.5, 0.5, 1.5])]
    return made


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.off", files.off()),
        ("a.ply", files.ply()),
        ("a.ply", files.ply("binary_little_endian")),
        ("a.ply", files.ply("binary_big_endian")),
        ("a.dxf", files.dxf()),
        ("a.dxf", files.dxf(polyface=True)),
        ("a.json", files.compas()),
        ("a.compas", files.compas(assembly=False)),
        ("a.json", files.compas_0()),
        ("a.3ddat", files.threedec()),
        ("a.wrl", files.vrml()),
        ("a.msh", files.msh()),
        ("a.dat", files.PRISM),
        ("unknown", files.off()),
        ("unknown.txt", files.ply()),
    ],
)
def test_boxes_that_share_corners_are_two_blocks(tmp_path: Path, name: str, content: str | bytes) -> None:
    boxes(tmp_path, name, content, **METRES)


def test_what_files_say_of_blocks_is_kept(tmp_path: Path) -> None:
    assert [block.group for block in boxes(tmp_path, "a.dxf", files.dxf(), up="z")] == ["lower", "upper"]  # in metres by its header
    for text in (files.compas(), files.compas_0()):
        assert [block.fixed for block in boxes(tmp_path, "a.json", text, **METRES)] == [True, False]
    deck = boxes(tmp_path, "a.3dec", files.threedec(), **METRES)
    assert [(block.group, block.fixed) for block in deck] == [("base", True), ("stone", False)]
    assert [block.fixed for block in boxes(tmp_path, "b.dat", files.PRISM, **METRES)] == [True, False]


def test_lmgc90(tmp_path: Path) -> None:
    files.lmgc90(tmp_path)
    made = boxes(tmp_path, "BODIES.DAT", **METRES)
    assert [(b.group, b.fixed, b.density) for b in made] == [("BASEx", True, 2500.0), ("BLUEx", False, 1900.0)]


def placed_elements(*matrices: list[list[float]], inside: bool = True) -> str:
    """A COMPAS model of unit cubes, each in an element of its own with a transformation."""
    corners, faces = box_part((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    mesh = {"dtype": "compas.datastructures/Mesh", "data": {"vertices": corners.tolist(), "faces": [list(f) for f in faces]}}
    elements = [
        {"dtype": "compas_model.elements/BlockElement", "data": {"name": f"e{k}", "transformation": {"data": {"matrix": matrix}}}}
        for k, matrix in enumerate(matrices)
    ]
    for element in elements if inside else ():
        element["data"]["geometry"] = mesh
    return json.dumps({"dtype": "compas_model.models/Model", "data": {"elements": [*elements, *([] if inside else [mesh])]}})


def test_transformations_of_compas_elements_place_their_meshes(tmp_path: Path) -> None:
    """A cube at home, one turned by 90 degrees about x and lifted, and one mirrored and stretched: all solid, where they should be."""
    turned = [[1, 0, 0, 0], [0, 0, -1, 1], [0, 1, 0, 1], [0, 0, 0, 1]]
    mirrored = [[-2, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    (tmp_path / "a.json").write_text(placed_elements(np.eye(4).tolist(), turned, mirrored))
    made = {block.name: block for block in build(tmp_path, "a.json", **METRES)}
    assert made["e1"].vertices.min(axis=0) == pytest.approx([0, 0, 1]) and made["e1"].vertices.max(axis=0) == pytest.approx([1, 1, 2])
    assert made["e2"].vertices.min(axis=0) == pytest.approx([3, 0, 0]) and made["e2"].vertices.max(axis=0) == pytest.approx([5, 1, 1])
    assert [block.mass_properties.volume for block in made.values()] == pytest.approx([1.0, 1.0, 2.0])


@pytest.mark.parametrize(
    ("matrix", "inside", "words"),
    [
        ([[1, 0, 0, 0]] * 3, True, '"e0": its transformation is not an affine matrix of 4 x 4'),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]], True, '"e0": its transformation is not an affine matrix'),
        ([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], False, '"e0" moves others, which do not stand within it'),
    ],
)
def test_transformations_that_cannot_be_followed_are_refused(tmp_path: Path, matrix: list[list[float]], inside: bool, words: str) -> None:
    (tmp_path / "a.json").write_text(placed_elements(matrix, inside=inside))
    with pytest.raises(InputError, match=words):
        build(tmp_path, "a.json", **METRES)


def test_gltf_and_3mf_state_unit_and_axis(tmp_path: Path) -> None:
    files.gltf(tmp_path / "a.gltf")
    files.gltf(tmp_path / "a.glb", glb=True)
    files.threemf(tmp_path / "a.3mf")
    for name in ("a.gltf", "a.glb", "a.3mf"):
        assert [block.name for block in boxes(tmp_path, name)] == ["lower", "upper"]
    with pytest.raises(InputError, match=r'^structure\.units: "m", but a\.3mf says "mm"; leave the key out$'):
        build(tmp_path, "a.3mf", units="m")
    _, notes, *_ = structures.make({"kind": "file", "path": "a.glb", "up": "z"}, 2000.0, tmp_path)
    assert notes == ['a.glb: up "z" as the scene says, where the file has "y"']


@pytest.mark.parametrize("name", [name for name, format_ in FORMATS.items() if format_.written and name not in ("json", "stl")])
def test_what_is_written_comes_back_to_the_same_blocks(tmp_path: Path, name: str) -> None:
    blocks = [*tower(2), Block("loose one", tower(1)[1].vertices + [1.0, 0.0, 0.0], tower(1)[1].faces, 1900.0, "other--group")]
    meshfile.write(tmp_path / f"t.{name}", blocks)
    again = build(tmp_path, f"t.{name}")
    assert [(b.name, b.group, b.fixed, b.density) for b in again] == [(b.name, b.group, b.fixed, b.density) for b in blocks]
    for ours, theirs in zip(blocks, again, strict=True):
        assert np.array_equal(np.unique(ours.vertices, axis=0), np.unique(theirs.vertices, axis=0))  # to the bit
        assert len(ours.faces) == len(theirs.faces)


def test_an_stl_of_blocks_that_share_corners_comes_back(tmp_path: Path) -> None:
    blocks = built("arch", span=4.0, thickness=0.5, voussoirs=9)
    meshfile.write(tmp_path / "arch.stl", blocks)
    again = build(tmp_path, "arch.stl", **METRES, fixed="ground")
    volumes = [[mass_properties(b.vertices, b.faces).volume for b in some] for some in (blocks, again)]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-5)


def test_shells_do_not_depend_on_the_order_of_faces() -> None:
    blocks = tower(4)
    points = np.concatenate([block.vertices for block in blocks])
    loops = [[i + 8 * k for i in face] for k, block in enumerate(blocks) for face in triangles(block.faces).tolist()]
    np.random.default_rng(1).shuffle(loops)
    found = [mass_properties(*shell).volume for shell in shells(points, loops)]
    assert sorted(found) == pytest.approx(sorted(mass_properties(b.vertices, b.faces).volume for b in blocks))


def test_obj_groups_and_materials(tmp_path: Path) -> None:
    corners = "".join("v {:g} {:g} {:g}\n".format(*p) for p in files.POINTS)
    faces = ["".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in some) for some in (files.LOOPS[: files.HALF], files.LOOPS[files.HALF :])]
    made = boxes(tmp_path, "a.obj", f"{corners}o low\ng base\nusemtl tuff\n{faces[0]}o high\nusemtl brick\ng arch\n{faces[1]}", **METRES)
    assert [(block.name, block.group) for block in made] == [("low", "base"), ("high", "arch")]
    made = boxes(tmp_path, "b.obj", f"{corners}g low\nusemtl tuff\n{faces[0]}g high\n{faces[1]}", **METRES)
    assert [(block.name, block.group) for block in made] == [("low", "tuff"), ("high", "tuff")]
    assert [block.name for block in boxes(tmp_path, "c.obj", corners + "".join(faces), **METRES)] == ["b0", "b1"]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.xyz", "1 2 3\n", r"structure\.path: a\.xyz is not a file of blocks; .* \.dxf, "),
        ("a.dat", "ISO-10303-21;\n", r"a\.dat: cannot be read"),
        ("a.dxf", "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n0\nENDSEC\n0\nEOF\n", r"a\.dxf: no 3DFACE and no polyface mesh in it"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n", r"a\.off: not the counts, corners and faces of an OFF file"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n", r"a\.ply: not the corners and faces"),
        ("a.glb", "glTF....", r"a\.glb: not the nodes, meshes and accessors"),
        ("a.3mf", "PK..", r"a\.3mf: not the objects and the build of a 3MF file"),
        ("a.3dec", "block create sphere 1\n", r"a\.3dec: line 1: a block sphere that is not read"),
        ("a.json", '{"dtype": "compas.data/Data", "data": {}}', r"a\.json: no mesh and no polyhedron of COMPAS in it"),
        ("BODIES.DAT", "$bdyty\n RBDY3  1\n$nodty\n$tacty\n SPHER  1  color  BLUEx\n", r"BODIES\.DAT: RBDY3 1: no three coordinates"),
    ],
)  # fmt: skip
def test_what_is_no_such_file_is_named(tmp_path: Path, name: str, content: str, message: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=f"^{message}"):
        build(tmp_path, name, **METRES)


def test_formats_are_listed(tmp_path: Path) -> None:
    shown = masonry_cd("build", "--formats")
    assert shown.exit_code == 0
    assert [line.split()[0] for line in shown.output.splitlines()] == [*FORMATS, "solid", "step"]
    (tmp_path / "x.bin").write_bytes(b"\x00\x01")
    assert format_of(tmp_path / "x.bin") is None


def test_an_overlap_is_accepted_where_asked_for_and_reported(tmp_path: Path) -> None:
    blocks = [Block(b.name, b.vertices - [0.0, 0.0, 0.001 * k], b.faces, b.density, b.group, b.fixed) for k, b in enumerate(tower(2))]
    meshfile.write(tmp_path / "t.obj", blocks)
    with pytest.raises(InputError, match=r't\.obj: blocks "\w+" and "\w+": they overlap by 1 mm; 1 more pairs overlap'):
        build(tmp_path, "t.obj")
    made, notes, *_ = structures.make({"kind": "file", "path": "t.obj", "overlap": 0.002}, 2000.0, tmp_path)
    assert len(made) == 3
    assert notes == ["t.obj: 2 pairs of blocks overlap, by at most 1 mm"]
    with pytest.raises(InputError, match="overlap by 1 mm"):
        build(tmp_path, "t.obj", overlap=0.0005)


def text_stl() -> str:
    """The boxes as an STL in text, a solid each."""
    lines = []
    for k, loops in enumerate((files.LOOPS[: files.HALF], files.LOOPS[files.HALF :])):
        lines.append(f"solid b{k}")
        for loop in loops:
            corners = [f"vertex {x} {y} {z}" for x, y, z in files.POINTS[loop]]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        lines.append(f"endsolid b{k}")
    return "\n".join(lines) + "\n"


def binary_stl() -> bytes:
    """The boxes as an STL, whose heading begins as a text does."""
    soup = np.zeros(len(files.LOOPS), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
    soup["corners"] = files.POINTS[np.array(files.LOOPS)]
    return b"solid facet".ljust(80) + len(soup).to_bytes(4, "little") + soup.tobytes()


@pytest.mark.parametrize("content", [text_stl(), text_stl().replace("\n", "\r\n").upper(), binary_stl()])
def test_stl_in_text_and_binary(tmp_path: Path, content: str | bytes) -> None:
    boxes(tmp_path, "a.stl", content, **METRES)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", text_stl()[:-200], r"a\.stl: \d+ triangles could be read of [\d.]+: cut short or damaged"),
        ("a.stl", binary_stl()[:-60], r"a\.stl: announces 24 triangles and has bytes for 22: cut short or damaged"),
        ("a.stl", text_stl().replace(".", ","), r"a\.stl: not the facets and vertices of an STL"),
        ("a.dxf", files.dxf()[:-300], r"a\.dxf: does not end with EOF, as a DXF does: cut short"),
        ("a.dxf", files.dxf(polyface=True)[:-300], r"a\.dxf: does not end with EOF"),
    ],
)
def test_files_that_were_cut_short_lose_no_block_in_silence(tmp_path: Path, name: str, content: str | bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=said):
        build(tmp_path, name, up="z", **({} if name.endswith("dxf") else {"units": "m"}))


def test_a_density_that_another_program_has_spoilt_is_no_traceback(tmp_path: Path) -> None:
    meshfile.write(tmp_path / "a.obj", [Block("a", *box_part((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), 2000.0)])
    text = (tmp_path / "a.obj").read_text().replace('"density": 2000.0', '"density": "little"')
    assert '"little"' in text
    (tmp_path / "a.obj").write_text(text)
    assert len(meshfile.load(tmp_path / "a.obj", "obj").stones) == 1


def test_meshes_of_gmsh_come_back_with_their_groups(tmp_path: Path) -> None:
    """Nodes within plane faces go; volumes are those of the blocks."""
    from structures.files.solidfile import write

    given = structures.build({"kind": "arch", "radius": 5.0, "thickness": 1.0, "width": 1.0, "voussoirs": 5}, 2000.0, tmp_path)
    write(tmp_path / "a.msh", given)
    (tmp_path / "a.dat").write_text((tmp_path / "a.msh").read_text(encoding="utf-8").partition("$Comments")[0], encoding="utf-8")
    for name in ("a.msh", "a.dat"):
        blocks = build(tmp_path, name, fixed="ground", **METRES)
        assert [block.mass_properties.volume for block in blocks] == pytest.approx([b.mass_properties.volume for b in given], rel=1e-12)
        assert [len(block.vertices) for block in blocks] == [8] * len(given)
        assert [block.group for block in blocks] == [b.group for b in given]


def test_a_mesh_of_gmsh_without_volumes_is_refused(tmp_path: Path) -> None:
    import meshio

    meshio.write(tmp_path / "a.msh", meshio.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))]), file_format="gmsh22", binary=False)
    with pytest.raises(InputError, match=r"a\.msh: no volume cells"):
        build(tmp_path, "a.msh", **METRES)


def test_a_folder_of_meshes_is_a_stone_a_file(tmp_path: Path) -> None:
    """Files are sorted by name, numbers by their size; what is not a mesh is counted; a run depends on each file."""
    from masonry_cd.app.inputs import file_digests

    (tmp_path / "stones").mkdir()
    for k in (2, 10, 1):
        vertices, faces = box_part((0.0, 0.0, float(k)), (1.0, 1.0, k + 1.0))
        meshfile.write(tmp_path / "stones" / f"s{k}.{'stl' if k == 1 else 'obj'}", [Block("x", vertices, faces, 2000.0, "g")])
    (tmp_path / "stones" / "note.txt").write_text("found on a shelf")
    blocks, notes, *_ = structures.make({"kind": "file", "path": "stones", **METRES}, 2000.0, tmp_path)
    assert [block.name for block in blocks] == ["s1", "s2", "s10"] and "1 .txt" in notes[0]
    assert [block.vertices[:, 2].min() for block in blocks] == [1.0, 2.0, 10.0]
    assert len(file_digests([{"path": "stones"}], tmp_path)) == 4
    (tmp_path / "stones" / "s3.3mf").write_bytes(b"PK")
    with pytest.raises(InputError, match=r"s3\.3mf"):
        build(tmp_path, "stones", **METRES)
    (tmp_path / "none").mkdir()
    with pytest.raises(InputError, match="none: no mesh"):
        build(tmp_path, "none", **METRES)
