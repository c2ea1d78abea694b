# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.files.blockfile: a support needs no density; parts that do not fill their block are refused with what is wrong."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from masonry_cd.foundation.errors import InputError
from structures.files.blockfile import read
from structures.geometry.prism import box


def entry(name: str, low: tuple[float, float, float], high: tuple[float, float, float], **more: Any) -> dict[str, Any]:
    vertices, faces = box(low, high)
    return {"name": name, "vertices": vertices.tolist(), "faces": [list(face) for face in faces], **more}


def written(tmp_path: Path, *entries: dict[str, Any]) -> Path:
    path = tmp_path / "blocks.json"
    path.write_text(json.dumps({"units": "m", "blocks": list(entries)}))
    return path


def test_a_support_needs_no_density_and_a_free_block_does(tmp_path: Path) -> None:
    ground = entry("ground", (-1.0, -1.0, -1.0), (1.0, 1.0, 0.0), fixed=True)
    stone = entry("stone", (0.0, 0.0, 0.0), (0.5, 0.5, 0.5))
    base, own = read(written(tmp_path, ground, stone | {"density": 2200.0}), math.nan)
    assert own.density == 2200.0
    assert base.density > 0.0
    with pytest.raises(InputError, match='block "stone": brings no density of its own'):
        read(written(tmp_path, ground, stone), math.nan)


@pytest.mark.parametrize(("high", "why"), [(0.4, "some of it is in none of them"), (0.7, "they reach into each other or beyond it")])
def test_parts_that_do_not_fill_their_block_are_refused_with_why(high: float, why: str, tmp_path: Path) -> None:
    halves = [entry("", (0.0, 0.0, 0.0), (0.5, 1.0, 1.0)), entry("", (0.5, 0.0, 0.0), (0.5 + high, 1.0, 1.0))]
    parts = [{"vertices": half["vertices"], "faces": half["faces"]} for half in halves]
    with pytest.raises(InputError, match=f'block "b": its parts have .* {why}; parts left out have it cut'):
        read(written(tmp_path, entry("b", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), parts=parts)), 2000.0)
