# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise on the vertices: of the size asked for, the same for a seed, and of blocks that stay sound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import structures
from masonry_cd.cli.app import app
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.middle_plane import middle_plane
from structures.geometry.checks import Shells, check_convex, check_shells

SIZE = 1e-6
STORED = ["-0x1.800003b0696b4p+0", "-0x1.999999999999ap-3", "0x1.ef3635db3966bp-22"]  # first corner of the second block of a wall, seed 7
KINDS: list[dict[str, Any]] = [
    {"kind": "arch", "radius": 3.0, "thickness": 0.5, "voussoirs": 9},
    {"kind": "aqueduct", "spans": 1},
    {"kind": "wall"},
    {"kind": "tower"},
    {"kind": "column"},
    {"kind": "vault", "form": "cross", "voussoirs": 7},
    {"kind": "dome"},
    {"kind": "church", "block_length": 2.0},
]


def built(table: dict[str, Any], folder: Path = Path(), **noise: Any) -> list[Block]:
    return structures.build(table | ({"noise": noise} if noise else {}), 2000.0, folder)


def moved(noisy: list[Block], exact: list[Block]) -> np.ndarray:
    """How far the corner of each block moved that moved most [m]."""
    return np.array([np.linalg.norm(a.vertices - b.vertices, axis=1).max() for a, b in zip(noisy, exact, strict=True)])


@pytest.mark.parametrize("table", KINDS, ids=lambda table: str(table["kind"]))
def test_each_block_of_each_kind_moves_by_the_size_and_stays_sound(table: dict[str, Any]) -> None:
    exact, noisy = built(table), built(table, size=SIZE)
    assert moved(noisy, exact) == pytest.approx(SIZE, rel=1e-6)
    check_shells(noisy)
    parts = [(i, part) for i, block in enumerate(noisy) for part in block.convex_parts]
    check_convex(noisy, Shells.of(parts), np.ones(len(parts), dtype=bool))
    for block in noisy:  # parts of one block go with it
        filled = sum(mass_properties(part.vertices, part.faces).volume for part in block.parts)
        assert not block.parts or filled == pytest.approx(mass_properties(block.vertices, block.faces).volume, rel=1e-12)
    assert [block.name for block in noisy] == [block.name for block in exact]


def test_faces_stay_as_flat_as_rounding_allows() -> None:
    for block in built({"kind": "tower"}, size=5e-6, seed=3):
        for face in block.faces:
            corners = block.vertices[list(face)] - block.vertices[face[0]]
            normal = np.cross(corners[1], corners[2])
            assert np.abs(corners @ normal).max() < 1e-14 * np.linalg.norm(normal) * 10.0


def test_blocks_move_each_by_itself() -> None:
    exact, noisy = built({"kind": "wall"}), built({"kind": "wall"}, size=SIZE)
    shifts = np.array([(a.vertices - b.vertices).mean(axis=0) for a, b in zip(noisy, exact, strict=True)])
    assert len(np.unique(shifts.round(12), axis=0)) == len(exact)
    assert np.abs(shifts.mean(axis=0)).max() < 0.2 * SIZE  # no drift of the whole


def test_a_planar_structure_stays_planar_unless_asked_otherwise() -> None:
    table = {"kind": "aqueduct", "spans": 1}
    flat, spatial = built(table, size=SIZE), built(table, size=SIZE, axes="xyz")
    assert middle_plane(Assembly.from_blocks(flat, 0.5), 1) is not None
    assert middle_plane(Assembly.from_blocks(spatial, 0.5), 1) is None
    for now, then in zip(flat, built(table), strict=True):
        np.testing.assert_array_equal(now.vertices[:, 1], then.vertices[:, 1])


def test_only_the_axes_asked_for_move() -> None:
    exact, noisy = built({"kind": "church", "block_length": 2.0}), built({"kind": "church", "block_length": 2.0}, size=SIZE, axes="z")
    shifts = np.concatenate([a.vertices - b.vertices for a, b in zip(noisy, exact, strict=True)])
    assert not shifts[:, :2].any()
    assert np.abs(shifts[:, 2]).max() == pytest.approx(SIZE, rel=1e-6)


def test_a_seed_gives_the_same_bits_everywhere_and_another_one_others() -> None:
    first, again, other = (built({"kind": "wall"}, size=SIZE, seed=seed) for seed in (7, 7, 8))
    for a, b, c in zip(first, again, other, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes() != c.vertices.tobytes()
    assert [x.hex() for x in first[1].vertices[0].tolist()] == STORED


def test_no_noise_changes_nothing() -> None:
    for a, b in zip(built({"kind": "wall"}), built({"kind": "wall"}, size=0.0), strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()


def test_blocks_from_a_file_take_noise_too(tmp_path: Path) -> None:
    (tmp_path / "one.json").write_text(
        '{"units": "m", "blocks": [{"name": "v1", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],'
        '"faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}]}',
        encoding="utf-8",
    )
    table = {"kind": "file", "path": "one.json"}
    assert moved(built(table, tmp_path, size=1e-5), built(table, tmp_path)) == pytest.approx([1e-5], rel=1e-6)


def test_what_was_done_is_reported() -> None:
    _, notes = structures.build_with_notes({"kind": "wall", "noise": {"size": SIZE, "seed": 4}}, 2000.0, Path())
    assert notes == ["noise: corners moved by up to 1e-06 m along x, z, seed 4"]


@pytest.mark.parametrize(
    ("noise", "message"),
    [
        ({"size": -1e-6}, r"structure\.noise\.size: input should be greater than or equal to 0, got -1e-06"),
        ({"size": 1e-3}, r'structure\.noise\.size: 0\.001 m is more than 0\.0001 of the shortest edge, .* m of block ".*"'),
        ({"size": float("nan")}, r"structure\.noise\.size: "),
        ({}, r"structure\.noise\.size: missing"),
        ({"size": 1e-6, "seed": -1}, r"structure\.noise\.seed: "),
        ({"size": 1e-6, "seed": 2**63}, r"structure\.noise\.seed: "),
        ({"size": 1e-6, "axes": "yx"}, r"structure\.noise\.axes: "),
        ({"size": 1e-6, "sed": 1}, r'structure\.noise\.sed: unknown key \(did you mean "seed"\?\)'),
        (1e-6, r"structure\.noise: should be a table, as { size = 1e-6, seed = 0 }"),
    ],
)
def test_wrong_noise_is_refused_by_key(noise: object, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        structures.build({"kind": "wall", "noise": noise}, 2000.0, Path())


def test_the_command_line_names_file_and_line(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[structure]\nkind = "wall"\nnoise = { size = 1.0 }\n[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\n'
        "duration = 1.0\n",
        encoding="utf-8",
    )
    done = CliRunner().invoke(app, ["run", str(scene), "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert f"{scene}:3: structure.noise.size: 1 m is more than" in done.output
