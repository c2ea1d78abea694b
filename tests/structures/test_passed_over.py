# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of a file that change geometry are read, refused where they stand, or counted: copies, cuts, hidden layers, extensions."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mesh_files as files
import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

METRES = {"units": "m", "up": "z"}
BRICK = ((0.0, 0.0, 0.0), (0.5, 0.25, 0.2))


def made(folder: Path, name: str, **keys: Any) -> tuple[list[Block], str]:
    """The blocks of a file, and its notes."""
    blocks, notes, *_ = structures.make({"kind": "file", "path": name, **keys}, 2000.0, folder)
    return blocks, "\n".join(notes)


def low_corners(blocks: list[Block]) -> np.ndarray:
    return np.sort(np.round([block.vertices.min(axis=0) for block in blocks], 9), axis=0)


class Drawing:
    """A DXF of bricks, as 3DFACEs or as a mesh."""

    def __init__(self) -> None:
        import ezdxf

        self.document: Any = ezdxf.new("R2010")
        self.document.header["$INSUNITS"] = 6
        self.space = self.document.modelspace()

    def brick(self, space: Any, layer: str, place: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        corners, faces = files.box(*BRICK)
        for face in faces:
            space.add_3dface([tuple(corners[i] + place) for i in face], dxfattribs={"layer": layer})

    def block(self, name: str, layer: str = "STONE") -> Any:
        made = self.document.blocks.new(name)
        self.brick(made, layer)
        return made

    def read(self, folder: Path, binary: bool = False) -> tuple[list[Block], str]:
        self.document.saveas(folder / "a.dxf", fmt="bin" if binary else "asc")
        return made(folder, "a.dxf", up="z")


@pytest.mark.parametrize("binary", [False, True])
def test_inserts_of_a_drawing_place_their_blocks(tmp_path: Path, binary: bool) -> None:
    """One brick by itself, two by plain inserts, one mirrored, one within another insert on layer 0, and a row of three."""
    drawing = Drawing()
    drawing.brick(drawing.space, "ALONE")
    drawing.block("BRICK", "0")
    drawing.document.blocks.new("WALL").add_blockref("BRICK", (0, 0, 1))
    put = drawing.space.add_blockref
    put("BRICK", (1, 0, 0), dxfattribs={"layer": "A"})
    put("BRICK", (2, 0, 0), dxfattribs={"layer": "A"})
    put("BRICK", (4, 0, 0), dxfattribs={"layer": "B", "xscale": -1.0})
    put("WALL", (5, 0, 0), dxfattribs={"layer": "C"})
    put("BRICK", (6, 0, 0), dxfattribs={"layer": "D", "column_count": 3, "column_spacing": 1.0})
    blocks, notes = drawing.read(tmp_path, binary)
    assert [round(float(block.mass_properties.volume), 9) for block in blocks] == [0.025] * 8
    assert sorted(block.group for block in blocks) == ["A", "A", "ALONE", "B", "C", "D", "D", "D"]
    assert low_corners(blocks)[:, 0] == pytest.approx([0, 1, 2, 3.5, 5, 6, 7, 8]) and low_corners(blocks)[-1, 2] == 1.0
    assert notes == ""


def test_what_a_drawing_hides_is_counted_and_no_block(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.brick(drawing.space, "STONE")
    drawing.document.layers.add("OFF").off()
    drawing.document.layers.add("FROZEN").freeze()
    for layer in ("OFF", "FROZEN"):
        drawing.brick(drawing.space, layer, (3.0, 0.0, 0.0))
    drawing.block("BRICK")
    drawing.space.add_blockref("BRICK", (5, 0, 0), dxfattribs={"layer": "FROZEN"})
    drawing.brick(drawing.document.layout("Layout1"), "STONE", (7.0, 0.0, 0.0))
    drawing.space.add_line((0, 0), (1, 0), dxfattribs={"layer": "AXES"})
    blocks, notes = drawing.read(tmp_path)
    assert len(blocks) == 1
    for what in (
        "6 3DFACE on layer OFF",
        "6 3DFACE on layer FROZEN",
        "6 3DFACE on layer STONE: its layer is frozen",
        "1 LINE on layer AXES",
    ):
        assert what in notes
    assert "6 entities in paper space" in notes


def test_what_would_be_blocks_of_a_drawing_is_refused_by_its_handle(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.brick(drawing.space, "STONE")
    solid = drawing.space.add_3dsolid(dxfattribs={"layer": "VAULT"})
    solid.sat = ["400 0 1 0"]
    with pytest.raises(InputError, match=rf"3DSOLID {solid.dxf.handle} on layer VAULT"):
        drawing.read(tmp_path)


def test_a_mesh_of_a_drawing_is_a_block_and_an_external_reference_is_named(tmp_path: Path) -> None:
    from ezdxf.math import Matrix44

    drawing = Drawing()
    corners, faces = files.box(*BRICK)
    mesh = drawing.space.add_mesh(dxfattribs={"layer": "STONE"})
    with mesh.edit_data() as data:
        data.vertices, data.faces = [tuple(p) for p in corners], [tuple(face) for face in faces]
    mesh.transform(Matrix44.translate(1.0, 0.0, 0.0))
    drawing.document.add_xref_def("tower.dxf", "TOWER")
    drawing.space.add_blockref("TOWER", (0, 0, 0))
    blocks, notes = drawing.read(tmp_path)
    assert [block.vertices[:, 0].min() for block in blocks] == [1.0]
    assert "INSERT" in notes and "tower.dxf" in notes


DECK = "model new\n; two\nblock create brick 0 1 0 1 ...\n  0 1 group 'base'\nblock create brick 0 1 0 1 1 2 group 'stone'\n"


@pytest.mark.parametrize(
    ("line", "place"),
    [
        ("block cut joint-set dip 0 spacing 0.25", "line 6"),
        ("bl cut joint-set dip 0", "line 6"),
        ("jset dip 0 dd 0 spacing 0.25", "line 6"),
        ("block delete range group 'stone'", "line 6"),
        ("delete range group 'stone'", "line 6"),
        ("block rotate-mesh angle 10", "line 6"),
        ("block hide range group 'stone'", "line 6"),
        ("block join on", "line 6"),
        ("block densify segments 2", "line 6"),
        ("block gridpoint initialize position-x 1 add", "line 6"),
        ("block fix range id 3", "line 6"),
        ("block fix range group 'base' not", "line 6"),
        ("program call 'more.dat'", "line 6"),
        ("model restore 'built'", "line 6"),
        ("fish define turn\n  command\n    block delete\n  end_command\nend", "line 8"),
        ("fish define turn\n  a = block.delete(b)\nend", "line 7"),
    ],
)
def test_a_command_of_a_deck_that_changes_blocks_is_refused_by_its_line(tmp_path: Path, line: str, place: str) -> None:
    (tmp_path / "a.3ddat").write_text(DECK + line + "\nblock fix range group 'base'\n")
    with pytest.raises(InputError, match=rf"a\.3ddat: {place}: "):
        made(tmp_path, "a.3ddat", **METRES)


def test_commands_of_a_deck_that_leave_blocks_alone_are_passed_and_others_named(tmp_path: Path) -> None:
    rest = [
        "block property density 2000", "block group 'high' range position-z 1 2", "block fix range group 'base'", "model solve",
        "block gridpoint apply velocity-z 0", "frobnicate 3", "fish define f", "  a = 1", "end", "exit", "block delete",
    ]  # fmt: skip
    (tmp_path / "a.3ddat").write_text(DECK + "\n".join(rest))
    blocks, notes = made(tmp_path, "a.3ddat", **METRES)
    assert [(block.group, block.fixed) for block in blocks] == [("base", True), ("high", False)]
    for what in ("frobnicate", "line 11", "block gridpoint apply", "line 12"):
        assert what in notes
    assert "property" not in notes and "solve" not in notes


def threemf(folder: Path, build: str, objects: str = "", head: str = 'unit="meter"', more: str = "") -> None:
    """A 3MF of a unit cube with number 1."""
    corners, faces = files.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    vertices = "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*p) for p in corners)
    loops = [(f[0], f[k], f[k + 1]) for f in faces for k in (1, 2)]
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in loops)
    own = f'<object id="1"><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles>{more}</mesh></object>'
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    text = f'<model {head} xmlns="{core}" xmlns:p="http://x/production/2015/06" xmlns:b="http://x/beamlattice/2017/02">'
    with zipfile.ZipFile(folder / "a.3mf", "w") as whole:
        whole.writestr("3D/Objects/other.model", "<model/>")
        whole.writestr("3D/3dmodel.model", f"{text}<resources>{own}{objects}</resources><build>{build}</build></model>")
        whole.writestr("_rels/.rels", '<r><x Target="/3D/3dmodel.model" Type="http://schemas/3dmodel"/></r>')


def test_copies_of_a_3mf_are_blocks_with_names_of_their_own(tmp_path: Path) -> None:
    """Two by the build, and two by components of another object, which the build places once."""
    parts = "".join(f'<component objectid="1" transform="1 0 0 0 1 0 0 0 1 {x} 0 0"/>' for x in (4, 6))
    items = '<item objectid="1"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 2 0 0"/><item objectid="2"/>'
    threemf(tmp_path, items, f'<object id="2"><components>{parts}</components></object><object id="9"><mesh/></object>')
    blocks, notes = made(tmp_path, "a.3mf")
    assert low_corners(blocks)[:, 0] == pytest.approx([0, 2, 4, 6])
    assert len({block.name for block in blocks}) == 4
    assert "1 objects that its build does not place" in notes


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"build": '<item objectid="1" p:path="/3D/Objects/other.model"/>'}, "object 1 is in another part"),
        ({"build": '<item objectid="1"/>', "head": 'requiredextensions="b"'}, "beamlattice"),
        ({"build": '<item objectid="1"/>', "more": "<b:beamlattice/>"}, '"object1": beamlattice'),
        ({"build": '<item objectid="1"/>', "head": 'unit="cubit"'}, '"cubit"'),
    ],
)
def test_what_a_3mf_has_besides_meshes_is_refused(tmp_path: Path, keys: dict[str, str], words: str) -> None:
    threemf(tmp_path, **keys)
    with pytest.raises(InputError, match=rf"a\.3mf: .*{words}"):
        made(tmp_path, "a.3mf")


def gltf(folder: Path, change: Callable[[Any], object]) -> None:
    files.gltf(folder / "a.gltf")
    scene = json.loads((folder / "a.gltf").read_text())
    change(scene)
    (folder / "a.gltf").write_text(json.dumps(scene))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco"),
        (lambda s: s["nodes"][1].update(extensions={"EXT_mesh_gpu_instancing": {}}), 'node "upper": its instances'),
        (lambda s: s["nodes"][1].update(skin=0), 'node "upper": a skin'),
        (lambda s: s["meshes"][1].update(weights=[0.5]), 'node "upper": morph targets'),
        (lambda s: s["meshes"][1]["primitives"][0].update(mode=5), "strips"),
        (lambda s: s["accessors"][0].update(sparse={}), "accessor 0"),
    ],
)
def test_what_places_or_bends_meshes_of_a_gltf_is_refused(tmp_path: Path, change: Callable[[Any], object], words: str) -> None:
    gltf(tmp_path, change)
    with pytest.raises(InputError, match=rf"a\.gltf: .*{words}"):
        made(tmp_path, "a.gltf")


def test_nodes_of_another_scene_are_counted_and_copies_get_names(tmp_path: Path) -> None:
    def change(scene: Any) -> None:
        scene["nodes"] += [{"name": "lower", "mesh": 0, "translation": [9, 0, 0]}, {"mesh": 0}]
        scene.update(scenes=[{"nodes": [3]}, {"nodes": [0, 1, 2]}], scene=1)

    gltf(tmp_path, change)
    blocks, notes = made(tmp_path, "a.gltf")
    assert {block.name for block in blocks} == {"lower.0", "lower.1", "upper"}
    assert "1 nodes with a mesh that are in no scene" in notes


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.obj", "v 0 0 0\ncall more.obj\n", "line 2: call"),
        ("a.obj", "v 0 0 0\ncstype bezier\nsurf 0 1 0 1 1\n", "line 3: surf"),
        ("a.off", files.off().replace("OFF", "COFF", 1), "COFF"),
        ("a.off", files.off() + "1 1 1\n", "not the counts"),
        ("BODIES.DAT", "$bdyty\n MAILx      1\n", "MAILx 1"),
    ],
)  # fmt: skip
def test_lines_that_bring_or_change_faces_are_refused(tmp_path: Path, name: str, content: str, words: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=rf"{name}: .*{words}"):
        made(tmp_path, name, **METRES)


def test_lines_of_an_obj_that_are_no_faces_are_counted(tmp_path: Path) -> None:
    corners, faces = files.box(*BRICK)
    text = "".join("v {} {} {}\n".format(*p) for p in corners) + "".join(f"f {' '.join(str(i + 1) for i in f)}\n" for f in faces)
    (tmp_path / "a.obj").write_text(text + "l 1 2\nl 2 3\ns off\n")
    assert made(tmp_path, "a.obj", **METRES)[1] == "a.obj: lines not read: 2 of l"


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("BODIES.DAT", "coo4= 0.0000000D+00", "coo4= 0.5000000D+00", r"BODIES\.DAT: RBDY3 1: its node is turned"),
        ("DOF.INI", "", "$bdyty\n RBDY3      2\n$nodty\n NO6xx 1  X(1)= 0.1D+00\n", r"DOF\.INI: RBDY3 2: is moved"),
    ],
)
def test_bodies_of_lmgc90_that_stand_elsewhere_are_refused(tmp_path: Path, file: str, old: str, new: str, words: str) -> None:
    files.lmgc90(tmp_path)
    path = tmp_path / file
    path.write_text(path.read_text().replace(old, new) if old else new)
    with pytest.raises(InputError, match=words):
        made(tmp_path, "BODIES.DAT", **METRES)


def test_features_of_compas_elements_are_refused_and_other_shapes_counted(tmp_path: Path) -> None:
    content = json.loads(files.compas())
    content["data"]["more"] = {"dtype": "compas.geometry/Box", "data": {"xsize": 1.0, "frame": None}}
    (tmp_path / "a.json").write_text(json.dumps(content))
    assert "1 Box" in made(tmp_path, "a.json", **METRES)[1]
    element = {"name": "e", "features": [{"cut": 1}], "geometry": json.loads(files.compas())["data"]["graph"]}
    (tmp_path / "b.json").write_text(json.dumps({"dtype": "compas_model/Model", "data": {"elements": [{"dtype": "x", "data": element}]}}))
    with pytest.raises(InputError, match=r'b\.json: the element "e" has features'):
        made(tmp_path, "b.json", **METRES)


def test_faces_of_a_cad_model_that_bound_no_solid_are_counted(tmp_path: Path) -> None:
    from masonry_cd.foundation.gmsh_session import gmsh_session

    with gmsh_session() as gmsh:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.addRectangle(3, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "a.brep"))
    blocks, notes = made(tmp_path, "a.brep", units="m")
    assert len(blocks) == 1
    assert "1 faces that bound no solid" in notes


SETS = """model new
block create brick 0 1 0 0.5 -0.5 0 group 'base'
block create brick 0 1 0 0.5 0 1 group 'stone'
block cut joint-set {}
block fix range group 'base'
"""


@pytest.mark.parametrize(
    ("words", "volumes"),
    [
        ("dip 0 dip-direction 0 spacing 0.25 number 3 origin 0 0 0.25", [0.25, *[0.125] * 4]),
        ("dip 0 spacing 0.25 origin (0,0,0.125) range group 'stone'", [0.25, 0.0625, 0.125, 0.125, 0.125, 0.0625]),
        ("dip 90 dip-direction 90 number 1 origin 0.4 0 0 jointset-id 2", [0.1, 0.15, 0.2, 0.3]),
        ("dip 45 dip-direction 90 number 1 origin 0 0 1 range group 'stone'", [0.25, 0.25, 0.25]),
        ("dip 0 origin 0 0 5 number 1", [0.25, 0.5]),
    ],
)
def test_joint_sets_of_3dec_cut_blocks(tmp_path: Path, words: str, volumes: list[float]) -> None:
    (tmp_path / "a.3ddat").write_text(SETS.format(words))
    blocks, _ = made(tmp_path, "a.3ddat", **METRES)
    assert [block.mass_properties.volume for block in blocks] == pytest.approx(volumes)
    assert [block.fixed for block in blocks] == [block.vertices[:, 2].mean() < 0.0 for block in blocks]
    assert len({block.name for block in blocks}) == len(blocks)


@pytest.mark.parametrize(
    "words",
    [
        "dip 30 dip-direction 90 spacing 0.2 number 3 origin 0 0 0.5",  # to which side is not known
        "dip 0 5 spacing 0.25 origin 0 0 0",
        "dip 0 spacing 0.25 persistence 0.5 origin 0 0 0",
        "dip 0 number 3 origin 0 0 0",
        "dip 0 spacing 1e-9 origin 0 0 0",
        "dip 0 spacing 0.25",
        "dip 0 spacing 0.25 origin 0 0 0 join",
    ],
)
def test_joint_sets_that_are_not_read_are_refused_by_their_line(tmp_path: Path, words: str) -> None:
    (tmp_path / "a.3ddat").write_text(SETS.format(words))
    with pytest.raises(InputError, match=r"a\.3ddat: line 4"):
        made(tmp_path, "a.3ddat", **METRES)


def test_regions_and_joint_sets_of_older_decks(tmp_path: Path) -> None:
    """A prism and a brick of numbered regions, a vertical joint, and three level ones upwards from their origin."""
    deck = """new
poly region 1 prism &
a ( 0, 0, 0) ( 1, 0, 0) ( 1, 1, 0)&
( 0, 1, 0) b ( 0, 0, 1) ( 1, 0, 1) ( 1, 1, 1) ( 0, 1, 1)
poly reg 2 mat 3 brick 0 1 0 1 -1 0
jset dip 90 dd 90 org 0.5 0 0
jset dip 0 dd 0 spac 0.25 num 3 org 0 0 0.25
fix range z -1 0
"""
    (tmp_path / "a.3ddat").write_text(deck)
    blocks, _ = made(tmp_path, "a.3ddat", **METRES)
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([0.125] * 8 + [0.5] * 2)
    assert [block.fixed for block in blocks] == [False] * 8 + [True] * 2
