# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes that no machine holds: refused from an estimate, before the first block."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from structures import size

KINDS: list[dict[str, Any]] = [
    {"kind": "wall", "leaves": 2, "gable": 2.0},
    {"kind": "tower"},
    {"kind": "church"},
    {"kind": "church", "aisles": True, "roof": "vault", "windows": 2},
    {"kind": "dome", "drum_height": 3.0, "oculus": 1.0},
    {"kind": "dome", "unit_length": 0.3},
    {"kind": "packing"},
    {"kind": "packing", "diameters": (0.1, 0.04), "count": 100},
    {"kind": "vault"},
    {"kind": "vault", "form": "cross"},
    {"kind": "arch", "span": 5.0, "thickness": 0.5, "buttress_width": 1.0, "buttress_courses": 50},
    {"kind": "aqueduct"},
    {"kind": "aqueduct", "spans": 5, "tiers": 2, "channel_width": 0.8},
]


@pytest.mark.parametrize("table", KINDS, ids=lambda table: "-".join(map(str, table.values())))
def test_estimates_are_near_the_blocks_that_are_built(table: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    estimates: list[float] = []
    monkeypatch.setattr(size, "within", lambda estimate, key: estimates.append(estimate))
    count = len(structures.build(table, 2000.0, Path()))
    assert 0.5 * count < estimates[0] < 2.0 * count


@pytest.mark.parametrize(
    ("table", "key", "number"),
    [
        ({"kind": "wall", "course_height": 1e-9}, "course_height", r"6e\+18"),
        ({"kind": "wall", "course_height": 1e-12}, "course_height", r"6e\+24"),
        ({"kind": "wall", "unit_length": 1e-9}, "course_height", r"4.8e\+10"),
        ({"kind": "tower", "course_height": 1e-9}, "course_height", r"2e\+20"),
        ({"kind": "church", "block_length": 1e-9}, "block_length", r"2.4e\+21"),
        ({"kind": "church", "gable": 1e6}, "gable", r"1\.8e\+07"),
        ({"kind": "dome", "thickness": 1e-9, "rows": 400, "unit_length": 1e-9}, "unit_length", r"4.6e\+12"),
        ({"kind": "dome", "thickness": 1e-9}, "thickness", r"3.6e\+19"),
        ({"kind": "vault", "unit_length": 1e-9}, "unit_length", r"6e\+10"),
        ({"kind": "vault", "form": "cross", "unit_length": 1e-9}, "unit_length", r"9.9e\+10"),
        ({"kind": "arch", "span": 5.0, "thickness": 0.5, "buttress_width": 1.0, "buttress_height": 1e6}, "buttress_height", r"4e\+06"),
        ({"kind": "aqueduct", "spans": 100_000}, "spans", r"5.6e\+06"),
        ({"kind": "aqueduct", "course_height": 1e-9}, "course_height", r"9.9e\+18"),
        ({"kind": "aqueduct", "pier_courses": 10**9}, "spans", r"6e\+09"),
        ({"kind": "aqueduct", "clear_span": 1e200}, "course_height", "."),
    ],
)
def test_too_many_blocks_are_refused_by_key_and_limit(table: dict[str, Any], key: str, number: str) -> None:
    with pytest.raises(
        InputError, match=rf"^structure\.{key}: makes about {number}.* blocks, at most 100000 are allowed; most_blocks = N "
    ):
        structures.build(table, 2000.0, Path())


OPENING = {"centre": 0.0, "head": "round"}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "wall", "openings": [OPENING | {"depth": 1e-9}]}, r"openings\[0\]: its depth must be at least 0\.01 m, got 1e-09"),
        ({"kind": "wall", "openings": [OPENING | {"width": 1e-12}]}, r"openings\[0\]: its width must be at least 0\.01 m"),
        ({"kind": "wall", "openings": [OPENING | {"sill": 1e6}]}, r"openings\[0\]: with its head it reaches up to z = 1e\+06 m"),
        ({"kind": "wall", "core": "rubble", "core_diameters": [1e-300]}, r"core_diameters\[0\]: should be at least 1e-12"),
        ({"kind": "tower", "door_height": 1e6}, r"door_width and door_height: with its head it reaches up to z = 1e\+06 m"),
        ({"kind": "church", "buttresses": 2, "buttress_depth": 1e6}, r"block_length: makes about"),
        ({"kind": "church", "aisles": True, "aisle_height": 0.01}, r"aisle_height: must be at least four courses, 2 m"),
        (
            {"kind": "packing", "count": 50, "diameters": [1e-6]},
            r"diameters: a layer of the container, 1 m by 1 m, would hold more than 1e\+06",
        ),
        ({"kind": "packing", "count": 50, "length": 1e6, "width": 1e6}, r"diameters: a layer of the container"),
        ({"kind": "packing", "count": 50, "diameters": [0.1, 1e-5]}, r"diameters\[1\]: must be at least 0\.001 m beside 0\.1 m"),
        ({"kind": "aqueduct", "clear_span": 1e-9}, r"clear_span: must be at least 0\.2 m"),
        ({"kind": "wall", "foundations": {"x": 1000, "y": 1000}}, r"foundations: makes about 1e\+06 blocks"),
        ({"kind": "wall", "ties": [{"along": "x", "height": 1.0, "diameter": 0.02, "spacing": 1e-12}]}, r"spacing: makes 4e\+11 ties"),
    ],
)
def test_counts_that_explode_are_refused_by_the_key_that_makes_them(table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=r"^structure\.(ties\[0\]\.)?" + message):
        structures.build(table, 2000.0, Path())


def test_the_scene_raises_or_lowers_the_limit() -> None:
    assert len(structures.build({"kind": "wall", "most_blocks": 96}, 2000.0, Path())) == 103
    with pytest.raises(InputError, match=r"makes about 96 blocks, at most 95 are allowed"):
        structures.build({"kind": "wall", "most_blocks": 95}, 2000.0, Path())
    assert size.most_blocks() == size.MOST


@pytest.mark.parametrize("value", [0, -1, True, 2.5, "many", None, [1]])
def test_a_limit_is_a_whole_number(value: object) -> None:
    with pytest.raises(InputError, match=r"^structure\.most_blocks: should be a whole number above 0, got "):
        structures.build({"kind": "wall", "most_blocks": value}, 2000.0, Path())


@pytest.mark.parametrize("size_of_ring", [1e-9, 5e-324, (0.6, 1e-9)])
def test_a_ring_too_thin_to_be_built_is_refused_instead_of_left_out(size_of_ring: object) -> None:
    with pytest.raises(InputError, match=r"structure\.ring_thickness: must be at least 0\.001 m"):
        structures.build({"kind": "aqueduct", "tiers": 2, "spans": 5, "ring_thickness": size_of_ring}, 2000.0, Path())


@pytest.mark.parametrize("key", ["door_width", "window_width", "thickness", "block_length"])
def test_a_measure_that_numbers_cannot_divide_by_is_refused(key: str) -> None:
    with pytest.raises(InputError, match=rf"structure\.{key}: should be at least 1e-12, got 5e-324"):
        structures.build({"kind": "church", key: 5e-324}, 2000.0, Path())


WALL = {"name": "a", "axis": [[0.0, 0.0], [40.0, 0.0]], "thickness": 0.5}


@pytest.mark.parametrize(
    ("table", "begins"),
    [
        ({"walls": [{**WALL, "top": [[0.008 * k, 3.0 + k % 2] for k in range(5001)]}]}, r"structure\.walls\[0\]\.top: .*5001"),
        (
            {"walls": [{**WALL, "height": 3.0, "openings": [{"at": 0.01 * k, "width": 0.5} for k in range(3000)]}]},
            r"structure\.walls\[0\]\.openings: .*3000",
        ),
        (
            {"walls": [{**WALL, "height": 3.0}], "columns": [{"at": [2.0, 3.0], "height": 3.0, "size": 0.4, "drum": 0.005}]},
            r"structure\.columns\[0\]\.drum",
        ),
        (
            {
                "walls": [{**WALL, "height": 3.0}],
                "columns": [{"at": [2.0, 3.0], "height": 3.0, "size": 0.4, "drum": 1e-6, "section": "square"}],
            },
            r"structure\.columns\[0\]\.drum",
        ),
    ],
)
def test_what_would_take_minutes_is_refused_by_its_key(tmp_path: Path, table: dict[str, object], begins: str) -> None:
    with pytest.raises(InputError, match=begins):
        structures.build({"kind": "building", **table}, 2000.0, tmp_path)


def test_a_face_of_thousands_of_corners_is_refused_by_its_block(tmp_path: Path) -> None:
    n = 1200
    turn = 2.0 * np.pi * np.arange(n) / n
    ring = [[float(np.cos(t)), float(np.sin(t)), z] for z in (0.0, 1.0) for t in turn]
    faces = [[*range(n)][::-1], [*range(n, 2 * n)], *([i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n))]
    (tmp_path / "a.json").write_text(json.dumps({"units": "m", "blocks": [{"name": "drum", "vertices": ring, "faces": faces}]}))
    with pytest.raises(InputError, match=r'a\.json: block "drum": face 0 has 1200 corners'):
        structures.build({"kind": "file", "path": "a.json"}, 2000.0, tmp_path)
