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
    monkeypatch.setattr(size, "check_size", lambda estimate, key: estimates.append(estimate))
    count = len(structures.build(table, 2000.0, Path()))
    assert 0.5 * count < estimates[0] < 2.0 * count


def test_the_scene_raises_or_lowers_the_limit() -> None:
    assert len(structures.build({"kind": "wall", "most_blocks": 96}, 2000.0, Path())) == 103
    assert size.most_blocks() == size.MOST


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
