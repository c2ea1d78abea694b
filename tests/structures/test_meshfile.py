# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in and out: the same blocks come back, units and axes are stated, repairable damage is repaired."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mesh_files
import numpy as np
import pytest
from models import box, tower
from solids import build

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import Polyhedron, mass_properties
from structures.files import meshfile
from structures.geometry.prism import prism_xz


def file(folder: Path, name: str, **keys: object) -> list[Block]:
    return structures.build({"kind": "file", "path": name, "units": "m", "up": "z", **keys}, 2000.0, folder)


def volumes(blocks: list[Block]) -> list[float]:
    return sorted(mass_properties(block.vertices, block.faces).volume for block in blocks)


@pytest.mark.parametrize("suffix", ["obj", "stl", "vtu", "vtm"])
def test_blocks_come_back(tmp_path: Path, suffix: str) -> None:
    blocks = build("arch", span=4.0, thickness=0.5, voussoirs=9)
    apart = (
        [Block(b.name, b.vertices + [0.001 * i, 0.0, 0.0], b.faces, b.density) for i, b in enumerate(blocks)] if suffix == "stl" else blocks
    )
    meshfile.write(tmp_path / f"arch.{suffix}", apart)
    again = file(tmp_path, f"arch.{suffix}")
    assert len(again) == len(blocks)
    assert volumes(again) == pytest.approx(volumes(blocks), rel=1e-5 if suffix == "stl" else 1e-12)  # STL has single precision
    assert [len(b.faces) for b in again] == [6] * len(blocks)  # triangles of one plane are one face again


@pytest.mark.parametrize("suffix", ["obj", "vtu", "vtm", "vtkhdf"])
def test_blocks_of_several_numbers_of_corners_keep_their_names(tmp_path: Path, suffix: str) -> None:
    """A VTU has the cells with one number of corners together, whatever the order of the blocks."""
    corners = {"four": 4, "three": 3, "other four": 4}
    shapes = {name: np.array([[3.0 * k, 0.0], [3.0 * k + 1.0, 0.0], [3.0 * k + 1.0, 1.0], [3.0 * k, 1.0]])[:n] for k, (name, n) in
              enumerate(corners.items())}  # fmt: skip
    blocks = [Block(name, *prism_xz(shape, 0.0, 1.0), 2000.0, f"group {name}") for name, shape in shapes.items()]
    meshfile.write(tmp_path / f"blocks.{suffix}", blocks)
    found = {block.name: (block.group, len(block.vertices)) for block in file(tmp_path, f"blocks.{suffix}")}
    assert found == {name: (f"group {name}", 2 * n) for name, n in corners.items()}


@pytest.mark.parametrize("suffix", ["vtu", "vtm"])
def test_bent_blocks_keep_their_parts(tmp_path: Path, suffix: str) -> None:
    blocks = build("vault", form="cross", voussoirs=7)
    meshfile.write(tmp_path / f"cross.{suffix}", blocks)
    again = file(tmp_path, f"cross.{suffix}")
    assert sorted(len(b.parts) for b in again) == sorted(len(b.parts) for b in blocks)
    assert volumes(again) == pytest.approx(volumes(blocks), rel=1e-12)


def test_cells_of_a_block_that_share_no_face_are_named(tmp_path: Path) -> None:
    cells = [prism_xz(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, top], [0.0, top]]), y, y + 1.0) for y, top in ((0.0, 1.0), (1.0, 0.5))]
    parts = tuple(Polyhedron(*cell) for cell in cells)
    meshfile.write(tmp_path / "steps.vtu", [Block("steps", *cells[0], 2000.0, parts=parts)])
    with pytest.raises(InputError, match=r'^steps\.vtu: block "steps": its parts do not share whole faces$'):
        file(tmp_path, "steps.vtu")


def test_a_vtkhdf_holds_every_part_and_whose_it_is(tmp_path: Path) -> None:
    import pyvista

    blocks = build("vault", form="cross", voussoirs=7)
    meshfile.write(tmp_path / "cross.vtkhdf", blocks)
    grid = pyvista.read(tmp_path / "cross.vtkhdf")
    assert np.bincount(grid.cell_data["block"]).tolist() == [len(b.convex_parts) for b in blocks]
    sizes = grid.compute_cell_sizes().cell_data["Volume"]
    assert np.bincount(grid.cell_data["block"], sizes) == pytest.approx([mass_properties(b.vertices, b.faces).volume for b in blocks])


@pytest.mark.parametrize("suffix", ["obj", "vtm"])
def test_names_come_back(tmp_path: Path, suffix: str) -> None:
    meshfile.write(tmp_path / f"stack.{suffix}", tower(2))
    assert [block.name for block in file(tmp_path, f"stack.{suffix}")] == ["ground", "b0", "b1"]


def test_a_mesh_that_is_not_convex_gets_parts(tmp_path: Path) -> None:
    lintel = np.array([[0, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)  # a U
    vertices, faces = prism_xz(lintel, 0.0, 1.0)
    meshfile.write(tmp_path / "u.obj", [Block("u", vertices, faces, 2000.0), box("in it", (1.0, 0.0, 1.0), (2.0, 1.0, 2.0))])
    u, cube = file(tmp_path, "u.obj")
    assert (len(u.parts), len(cube.parts)) == (3, 0)
    assert find_joints(Assembly.from_blocks([u, cube], 0.6)).area == pytest.approx([1.0, 1.0, 1.0])  # three faces, no more


def test_units_and_axes(tmp_path: Path) -> None:
    meshfile.write(tmp_path / "box.obj", [box("a", (0.0, 0.0, 0.0), (1.0, 2.0, 3.0))])
    (metres,) = file(tmp_path, "box.obj")
    (small,) = file(tmp_path, "box.obj", units="mm", up="y")
    assert np.ptp(metres.vertices, axis=0) == pytest.approx([1.0, 2.0, 3.0])
    assert np.ptp(small.vertices, axis=0) == pytest.approx([0.001, 0.003, 0.002])
    assert small.vertices[:, 2].min() == 0.0  # the y axis of the file points upwards
    assert mass_properties(small.vertices, small.faces).volume > 0


def test_supports_are_named(tmp_path: Path) -> None:
    meshfile.write(tmp_path / "stack.obj", tower(3))
    blocks = file(tmp_path, "stack.obj", fixed=["gro*"])
    assert [(b.name, b.fixed, b.group) for b in blocks if b.fixed] == [("ground", True, "base")]


def test_repair_welds_corners_and_turns_faces(tmp_path: Path) -> None:
    (block,) = tower(1)[1:]
    lines = ["o b"]
    for number, face in enumerate(block.faces):  # every face with corners of its own, every second one reversed
        corners = block.vertices[list(face)]
        lines += [f"v {x + 1e-8 * number} {y} {z}" for x, y, z in (corners if number % 2 else corners[::-1])]
        lines.append("f -4 -3 -2 -1")
    (tmp_path / "soup.obj").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r'soup\.obj: block "b": open shell'):
        file(tmp_path, "soup.obj")
    (again,) = file(tmp_path, "soup.obj", repair=True)
    assert len(again.vertices) == 8
    assert mass_properties(again.vertices, again.faces).volume == pytest.approx(0.5 * 0.5 * 0.25, rel=1e-6)


@pytest.mark.parametrize(
    ("keys", "text", "message"),
    [
        ({"units": None}, "", "structure.units: missing; bad.obj does not say it, so take one of m, cm, mm"),
        ({"up": None}, "", "structure.up: missing; bad.obj does not say it, so take one of y, z"),
        ({"units": "inch"}, "", "structure.units: input should be 'm', 'cm' or 'mm', got 'inch'"),
        ({}, "o a\nv 0 0 zero\n", "bad.obj: line 2: no number where one belongs"),
        ({}, "o a\nv 0 0 0\nf 1 2 3\n", 'bad.obj: block "a": a face names a vertex outside 1 to 1'),
        ({}, "# nothing\n", "bad.obj: no blocks in it"),
        ({"fixed": ["base"]}, "good", 'structure.fixed: no block is named "base"; the first are ground, b0'),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, keys: dict[str, object], text: str, message: str) -> None:
    if text == "good":
        meshfile.write(tmp_path / "bad.obj", tower(1))
    else:
        (tmp_path / "bad.obj").write_text(text)
    with pytest.raises(InputError) as failure:
        file(tmp_path, "bad.obj", **keys)
    assert str(failure.value).startswith(message)


def test_files_that_are_none_are_named(tmp_path: Path) -> None:
    for name in ("bad.vtu", "bad.stl", "bad.vtm"):
        (tmp_path / name).write_text("nonsense")
        with pytest.raises(InputError, match=name.replace(".", r"\.")):
            file(tmp_path, name)
    with pytest.raises(InputError, match=r"structure\.units: belongs to \.obj, \.stl, \.vtu, \.vtm files"):
        (tmp_path / "b.json").write_text("{}")
        file(tmp_path, "b.json")
    with pytest.raises(InputError, match=r"b\.dxf: blocks are written as"):
        meshfile.write(tmp_path / "b.dxf", tower(1))


def objects(*blocks: Block, name: str = "o b") -> str:
    """An OBJ in which every block has one name."""
    text, count = "", 1
    for block in blocks:
        text += f"{name}\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in block.vertices.tolist())
        text += "".join("f " + " ".join(str(count + i) for i in face) + "\n" for face in block.faces)
        count += len(block.vertices)
    return text


@pytest.mark.parametrize("mark", ["o b", "g b"])
def test_solids_of_one_name_stay_apart(tmp_path: Path, mark: str) -> None:
    """Else a structure whose objects all have one name would be a single rigid body."""
    (tmp_path / "twins.obj").write_text(objects(*tower(2)[1:], name=mark))
    assert [block.name for block in file(tmp_path, "twins.obj")] == ["b.0", "b.1"]


def test_a_solid_whose_name_comes_again_with_its_next_material_is_whole(tmp_path: Path) -> None:
    lines = objects(tower(1)[1]).splitlines()
    (tmp_path / "sorted.obj").write_text("\n".join([*lines[:12], "usemtl other", "o b", *lines[12:]]))
    assert [block.name for block in file(tmp_path, "sorted.obj")] == ["b"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda block: (block.vertices * [1.0, 1.0, 0.0], block.faces), r'a\.obj: block "b": '),
        (lambda block: (block.vertices, (*block.faces, (0, 0, 1))), ""),
    ],
)
def test_solids_and_faces_without_extent_are_said_or_dropped(tmp_path: Path, change: Any, said: str) -> None:
    """Neither a message of a library nor a warning of numpy."""
    stone = tower(1)[1]
    (tmp_path / "a.obj").write_text(objects(replace(stone, **dict(zip(("vertices", "faces"), change(stone), strict=True)))))
    if not said:
        assert volumes(file(tmp_path, "a.obj")) == pytest.approx(volumes([stone]))
        return
    with pytest.raises(InputError, match=said) as refusal:
        file(tmp_path, "a.obj")
    assert "\n" not in str(refusal.value)


def test_a_face_without_corners_is_named(tmp_path: Path) -> None:
    text = mesh_files.ply().decode().replace(f"element face {len(mesh_files.LOOPS)}", f"element face {len(mesh_files.LOOPS) + 1}")
    (tmp_path / "a.ply").write_text(text + "0\n")
    with pytest.raises(InputError, match=r"a\.ply: a face without corners"):
        file(tmp_path, "a.ply", fixed={"below": 0.9})


def _cells(*cells: tuple[int, int, int]) -> tuple[list[tuple[int, int, int]], list[list[int]]]:
    """Corners and outward squares of the surface of some unit cubes, whose corners are one where they meet."""
    number: dict[tuple[int, int, int], int] = {}
    faces = []
    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                adjacent = tuple(c + (2 * side - 1) * (k == axis) for k, c in enumerate(cell))
                if adjacent in cells:
                    continue
                u, w = (k for k in range(3) if k != axis)
                loop = []
                for du, dw in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = tuple(c + side * (k == axis) + du * (k == u) + dw * (k == w) for k, c in enumerate(cell))
                    loop.append(number.setdefault(corner, len(number)))
                faces.append(loop if (side == 1) != (axis == 1) else loop[::-1])
    return list(number), faces


PINCHED = ((0, 0, 0), (1, 1, 0), (0, 0, 1), (1, 1, 1), (0, 1, 1), (1, 0, 1))
UNSOUND = {
    "a fin": (((0, 0, 0),), [[0, 1, 8]], 1.0),
    "a wall inside": (((0, 0, 0), (0, 0, 1)), "between", 2.0),
    "cubes that share an edge": (((0, 0, 0), (1, 1, 0)), [], 2.0),
    "a surface that touches itself": (PINCHED, [], 6.0),
}


@pytest.mark.parametrize("what", UNSOUND)
@pytest.mark.parametrize("turned", [False, True])
def test_edges_of_more_than_two_faces_are_repaired(tmp_path: Path, what: str, turned: bool) -> None:
    """Also where some faces are turned inwards; volumes are those of the cubes. Without repair the edge is named by its place."""
    cells, more, volume = UNSOUND[what]
    corners, faces = _cells(*cells)
    if more == "between":
        more = [[corners.index((x, y, 1)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]]
    faces = [loop[::-1] if turned and k % 3 == 0 else loop for k, loop in enumerate([*faces, *more])]
    lines = ["o a", *(f"v {x} {y} {z}" for x, y, z in [*corners, (3, 3, 3)][: max(map(max, faces)) + 1])]
    (tmp_path / "a.obj").write_text("\n".join([*lines, *("f " + " ".join(str(i + 1) for i in loop) for loop in faces), ""]))
    (block,) = meshfile_blocks(tmp_path, repair=True)
    assert block.mass_properties.volume == pytest.approx(volume)
    if what == "a surface that touches itself" and not turned:
        with pytest.raises(InputError, match=r"4 faces meet in edge \d+-\d+ at \("):
            meshfile_blocks(tmp_path)


def meshfile_blocks(folder: Path, **keys: Any) -> list[Block]:
    return structures.build({"kind": "file", "path": "a.obj", "units": "m", "up": "z", **keys}, 2000.0, folder)


def test_a_hole_is_not_repaired_and_named_by_its_place(tmp_path: Path) -> None:
    corners, faces = _cells((0, 0, 0))
    lines = ["o a", *(f"v {x} {y} {z}" for x, y, z in corners), *("f " + " ".join(str(i + 1) for i in loop) for loop in faces[1:]), ""]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"open shell, edge \d-\d at \("):
        meshfile_blocks(tmp_path, repair=True)
