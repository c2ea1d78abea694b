# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges drawn at random: blocks that are convex, touch without gap or overlap, and fill the space up to the road; and that stand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.contact.find_joints import built_gap
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.geometry import mass_properties

RISES = {"segmental": (0.15, 0.5), "elliptical": (0.15, 0.5), "pointed": (0.55, 0.9)}  # of the span


def span_of(draw: np.random.Generator, thickness: tuple[float, float]) -> dict[str, Any]:
    """A span of any shape; its ring is a share of it thick."""
    length, shape = float(draw.uniform(2.0, 10.0)), str(draw.choice(["semicircular", *RISES]))
    span: dict[str, Any] = {"span": length, "shape": shape, "thickness": length * float(draw.uniform(*thickness))}
    if shape in RISES:
        span["rise"] = length * float(draw.uniform(*RISES[shape]))
    if draw.random() < 0.3:
        span["thickness_springing"] = span["thickness"] * float(draw.uniform(1.0, 1.5))
    return span


def bridge_of(seed: int) -> dict[str, Any]:
    """A bridge with walls: of one to three spans, square or skew."""
    draw = np.random.default_rng(seed)
    spans = [{**span_of(draw, (0.06, 0.12)), "rings": int(draw.integers(1, 4))} for _ in range(int(draw.integers(1, 4)))]
    return {
        "kind": "bridge", "spans": spans, "width": float(draw.uniform(3.0, 7.0)), "skew": float(draw.choice([0.0, draw.uniform(-45, 45)])),
        "cover": float(draw.uniform(0.05, 0.8)), "strips": int(draw.integers(1, 4)),
        "piers": [{"width": float(draw.uniform(3.0, 4.0)), "height": float(draw.uniform(1.0, 8.0)), "rigid": bool(draw.random() < 0.3)}],
        "abutments": [{"width": 3.0, "height": float(draw.uniform(0.5, 3.0)), "rigid": bool(draw.random() < 0.5)}],
        "walls": {"thickness": float(draw.uniform(0.3, 0.6)), "course_height": 0.6, "unit_length": 1.2, "wing_length": 2.0},
    }  # fmt: skip


STEPPED = {  # a flat arch next to a pier whose top slopes up to the higher springings of the next
    "kind": "bridge",
    "spans": [
        {"span": 4.3, "rise": 0.7, "thickness": 0.35},
        {"span": 8.6, "rise": 1.4, "thickness": 0.6, "springing": 0.84},
        {"span": 3.6, "rise": 1.6, "thickness": 0.34, "shape": "elliptical"},
    ],
    "width": 4.5,
    "cover": 0.6,
    "piers": [{"width": 2.1}],
    "walls": {"thickness": 0.5},
}


@pytest.mark.parametrize("table", [STEPPED, *(bridge_of(seed) for seed in range(4))])
def test_walls_and_fill_take_the_space_between_the_extradoses_and_the_road(table: dict[str, Any]) -> None:
    made = structures.make(table, 2000.0, Path())  # which checks that blocks are convex or of convex parts, and do not overlap
    assert built_gap(Assembly.from_blocks(made.blocks, 0.6)) < 1e-9
    (fill,) = made.fills
    clear = fill.clear[1] - fill.clear[0]
    filled = sum(abs(face.area[2]) * face.pressed(fill.level)[0] for face in fill.faces if face.kind in ("extrados", "top"))
    stones = sum(mass_properties(b.vertices, b.faces).volume for b in made.blocks if b.group.startswith("spandrel"))
    assert stones == pytest.approx(filled * (table["width"] - clear) / clear, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_thick_arches_on_low_piers_stand(seed: int) -> None:
    draw = np.random.default_rng(seed)
    structure = {"kind": "bridge", "spans": [span_of(draw, (0.1, 0.13)) for _ in range(2)], "piers": [{"width": 3.0, "height": 3.0}]}
    structure["abutments"] = [{"width": 4.0}]
    vehicle = {"kind": "vehicle", "axles": [1e3], "position": 1.0}
    scene = {"structure": structure, "material": {"density": 2200.0, "friction": 0.7}, "loads": [vehicle]}
    case = limit_case(parse_scene(dump_toml({**scene, "limit": {"live": [0], "starts": 0}}), Path("random.toml")))
    assert case.whole.analysis.stands


def test_a_pointed_arch_of_many_rings_has_no_more_voussoirs_by_default_than_its_apex_takes() -> None:
    span = {"span": 10.0, "shape": "pointed", "rise": 5.6, "thickness": 1.4, "rings": 4}
    made = structures.make({"kind": "bridge", "spans": [span], "width": 1.0}, 2000.0, Path())
    volumes = [mass_properties(b.vertices, b.faces).volume for b in made.blocks if b.group == "arch1_ring1"]
    assert min(volumes) > 0.4 * max(volumes)
