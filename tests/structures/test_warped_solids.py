# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids nearly flat, doubled, open or degenerate: taken soundly, or refused in one line that says what is wrong with them as given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.geometry import convex
from structures.geometry.checks import check, warp
from structures.geometry.compound_block import compound_block
from structures.geometry.convex import split
from structures.geometry.loops import single_loop
from structures.geometry.merge_coplanar import merge_coplanar
from structures.geometry.prism import box, prism_xz

ELL = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
pytestmark = pytest.mark.filterwarnings("error")
INSIDES = ("part", "vertices must be", "inf", "nan")


def fans(faces: Sequence[Sequence[int]]) -> tuple[tuple[int, ...], ...]:
    return tuple((face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1))


def noisy(size: float, seed: int, triangles: bool) -> Block:
    """A box of 1 x 0.6 x 0.5 m out of all planes, its corners moved."""
    random = np.random.default_rng(seed)
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 0.6, 0.5))
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    moved = vertices @ (turn * np.sign(np.linalg.det(turn))) + random.uniform(-size, size, vertices.shape)
    return Block("stone", moved, fans(faces) if triangles else faces, 2000.0)


@pytest.mark.parametrize("seed", range(20))
def test_faces_as_flat_as_is_allowed_are_all_kept(seed: int) -> None:
    """Warped by more than what counts as one plane when merging, by less than what counts as flat."""
    block = noisy(3e-6, seed, triangles=False)
    check([block])
    (merged,) = merge_coplanar([block])
    assert len(merged.faces) == 6
    assert mass_properties(merged.vertices, merged.faces).volume == mass_properties(block.vertices, block.faces).volume


@pytest.mark.parametrize("size", [1e-6, 1e-5, 2e-5, 1e-4])
def test_warped_stones_are_taken_soundly_or_refused_for_their_warp(size: float, tmp_path: Path) -> None:
    for seed in range(10):
        block = noisy(size, seed, triangles=True)
        try:
            built = from_obj(tmp_path, obj(block.vertices, block.faces))
        except InputError as refusal:
            assert 'block "s": not convex, and cannot be split into convex parts' in str(refusal)
            assert f"warped by up to {1e3 * warp(block):.3g} mm" in str(refusal)
        else:
            check(built)


def obj(vertices: np.ndarray, faces: Sequence[Sequence[int]]) -> str:
    return (
        "o s\n"
        + "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
        + "".join("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces)
    )


def from_obj(folder: Path, text: str, **keys: Any) -> list[Block]:
    (folder / "s.obj").write_text(text)
    return structures.build({"kind": "file", "path": "s.obj", "units": "m", "up": "z", **keys}, 2000.0, folder)


def test_warp_is_that_of_neighbours_that_continue_each_other() -> None:
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    vertices = vertices.copy()
    top = next(face for face in faces if all(vertices[i, 2] == 1.0 for i in face))
    vertices[top[2], 2] += 0.003
    assert warp(Block("b", vertices, fans(faces), 2000.0)) == pytest.approx(0.003, rel=0.01)
    assert warp(Block("b", *box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), 2000.0)) == 0.0


def test_a_split_ends_by_count(monkeypatch: pytest.MonkeyPatch) -> None:
    block = Block("ell", *prism_xz(ELL, 0.0, 0.7), 2000.0)
    assert len(split(block).parts) == 2
    monkeypatch.setattr(convex, "WORK", 300)
    with pytest.raises(InputError, match='block "ell": not convex, and cannot be split into convex parts: it takes too many cuts'):
        split(block)
    monkeypatch.setattr(convex, "MOST_FACES", 7)
    with pytest.raises(InputError, match="it has 8 faces, more than 7"):
        split(block)


@pytest.mark.parametrize("size", [1e-6, 1e-5, 1e-4, 1e-3])
def test_notched_solids_with_noise_end(size: float, tmp_path: Path) -> None:
    vertices, faces = prism_xz(ELL, 0.0, 0.7)
    random = np.random.default_rng(3)
    for seed in range(3):
        text = obj(vertices + random.uniform(-size, size, vertices.shape), faces if seed else fans(faces))
        try:
            check(from_obj(tmp_path, text))
        except InputError as refusal:
            assert 'block "s"' in str(refusal) and not any(word in str(refusal).split("convex parts")[-1] for word in INSIDES)


def test_faces_given_twice_are_named_and_repaired(tmp_path: Path) -> None:
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 0.6, 0.5))
    text = obj(vertices, [*faces, *faces])
    with pytest.raises(InputError, match="are one face given twice"):
        from_obj(tmp_path, text)
    (block,) = from_obj(tmp_path, text, repair=True)
    assert len(block.faces) == 6


@pytest.mark.parametrize("face", ["f", "f 1", "f 1 2", "f 0 1 2"])
def test_a_face_of_too_few_corners_is_named_by_its_line(face: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"s\.obj: line 4: a face has three corners or more, counted from 1"):
        from_obj(tmp_path, f"o a\nv 0 0 0\nv 1 0 0\n{face}\n")


def test_a_file_of_unknown_ending_is_named_with_those_that_are_read(tmp_path: Path) -> None:
    (tmp_path / "plan.xyz").write_text("a plan\n")
    with pytest.raises(InputError, match=r"plan\.xyz is not a file of blocks; kind = \"file\" reads \.json, \.obj, .*\.step"):
        structures.build({"kind": "file", "path": "plan.xyz", "units": "mm", "up": "z"}, 2000.0, tmp_path)


def test_a_file_of_unknown_ending_that_cannot_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plan.xyz").write_text("a plan\n")

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"structure\.path: plan\.xyz: cannot be read, Permission denied"):
        structures.build({"kind": "file", "path": "plan.xyz"}, 2000.0, tmp_path)


def test_far_too_large_coordinates_are_refused() -> None:
    vertices, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match=r"vertex [0-7] is more than 1e\+15 m away"):
        check([Block("b", 1e300 * vertices, faces, 2000.0)])


def test_a_solid_smaller_than_the_welding_distance_is_refused(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    text = obj(1e-8 * random.normal(size=(300, 3)), [(k, k + 1, k + 2) for k in range(298)])
    with pytest.raises(InputError, match="mind the units"):
        from_obj(tmp_path, text, repair=True)


def test_a_text_of_several_solids_gives_a_block_each(tmp_path: Path) -> None:
    """Also where they share corners, as stacked stones do."""
    lines = []
    for k in range(2):
        vertices, faces = box((0.0, 0.0, float(k)), (1.0, 1.0, k + 1.0))
        corners = ["outer loop\n" + "".join("vertex {} {} {}\n".format(*vertices[i]) for i in face) + "endloop" for face in fans(faces)]
        lines += [f"solid s{k}", *(f"facet normal 0 0 0\n{loop}\nendfacet" for loop in corners), f"endsolid s{k}"]
    (tmp_path / "s.stl").write_text("\n".join(lines) + "\n")
    blocks = structures.build({"kind": "file", "path": "s.stl", "units": "m", "up": "z"}, 2000.0, tmp_path)
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([1.0, 1.0])


def test_parts_share_the_first_corner_that_is_near() -> None:
    below, above = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))
    whole = compound_block("b", [below, (above[0] + 3e-8, above[1])], 2000.0, "block")
    assert len(whole.vertices) == 12 and len(whole.faces) == 10


@pytest.mark.parametrize(
    ("edges", "loop"),
    [
        ([(0, 1), (1, 2), (2, 0)], (1, 2, 0)),
        ([(0, 1), (1, 2), (2, 1)], None),  # never comes back to its beginning
        ([(0, 1), (1, 2)], None),
        ([(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)], None),
        ([(0, 1), (1, 2), (2, 0), (0, 3)], None),
        ([], None),
    ],
)
def test_only_a_single_loop_is_one(edges: list[tuple[int, int]], loop: tuple[int, ...] | None) -> None:
    assert single_loop(edges, preferred=1) == loop
