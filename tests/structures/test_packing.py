# SPDX-License-Identifier: GPL-3.0-or-later
"""Packings: a given number of spheres of each size, apart from one another and inside their container."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform
from solids import build

from masonry_cd.mechanics.model.blocks import Block

CASES: dict[str, dict[str, object]] = {
    "default": {},
    "two sizes": {"diameters": (0.12, 0.05), "shares": (1, 1), "share_of": "volume", "fill": 0.3, "length": 0.8, "width": 0.5},
    "cylinder": {"form": "cylinder", "diameter": 0.6, "count": 150},
    "three across": {"form": "cylinder", "diameter": 0.6, "diameters": (0.2,), "count": 15},
    "narrow cylinder": {"form": "cylinder", "diameter": 0.2, "diameters": (0.1, 0.03), "count": 40, "sides": 8},
    "heap": {"walls": False, "length": 0.4, "width": 0.4, "count": 100},
}


def spheres_of(blocks: list[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Centres (N, 3) and radii (N,) of the spheres [m]."""
    made = [block for block in blocks if block.radius]
    return np.array([block.vertices[0] for block in made]), np.array([block.radius for block in made])


@pytest.mark.parametrize("case", CASES)
def test_spheres_lie_apart_and_inside(case: str) -> None:
    keys = CASES[case]
    centre, radius = spheres_of(build("packing", **keys))
    apart = squareform(pdist(centre)) - radius[:, None] - radius + np.diag(np.full(len(radius), np.inf))
    assert apart.min() > 0.0
    assert (centre[:, 2] > radius).all()
    if keys.get("form") == "cylinder":
        assert (np.linalg.norm(centre[:, :2], axis=1) + radius).max() < 0.5 * float(str(keys["diameter"]))
    else:
        inner = 0.5 * np.array([keys.get("length", 1.0), keys.get("width", 1.0)], dtype=float)
        assert (np.abs(centre[:, :2]) + radius[:, None] < inner).all()


def test_shares_of_the_volume_are_met_and_groups_named_by_size() -> None:
    blocks = build("packing", **(CASES["two sizes"] | {"shares": (3, 1)}))
    volume = {group: sum(b.mass_properties.volume for b in blocks if b.group == group) for group in ("spheres.1", "spheres.2")}
    assert volume["spheres.1"] / volume["spheres.2"] == pytest.approx(3.0, rel=0.02)
    assert sum(volume.values()) == pytest.approx(0.6 * 0.8 * 0.5 * 0.3, rel=0.02)
    assert {b.group for b in blocks} == {"spheres.1", "spheres.2", "walls", "base"}


def test_shares_of_the_number_are_met_and_the_count_is_exact() -> None:
    _, radius = spheres_of(build("packing", diameters=(0.1, 0.08, 0.06), shares=(0.5, 0.3, 0.2), count=101))
    assert [int((np.abs(2.0 * radius - d) < 1e-12).sum()) for d in (0.1, 0.08, 0.06)] == [51, 30, 20]


def test_small_spheres_are_not_lifted_higher_than_large_ones() -> None:
    """So a mix is as high as its volume asks for, whatever the sizes."""
    mixed, _ = spheres_of(build("packing", diameters=(0.1, 0.02), share_of="volume", fill=0.3))
    alone, _ = spheres_of(build("packing", diameters=(0.1,), fill=0.3))
    assert mixed[:, 2].max() < 1.4 * alone[:, 2].max()


def test_the_seed_alone_decides_where_they_lie() -> None:
    first, second, other = (spheres_of(build("packing", count=50, seed=seed))[0] for seed in (3, 3, 4))
    assert first.tobytes() == second.tobytes()
    assert np.abs(first - other).max() > 1e-3


def test_the_ring_of_a_cylinder_touches_its_circle() -> None:
    walls = [b for b in build("packing", form="cylinder", diameter=0.6, count=20, sides=12) if b.group == "walls"]
    assert len(walls) == 12
    for wall in walls:
        plan = wall.vertices[:, :2]
        middle = plan.mean(axis=0) / np.linalg.norm(plan.mean(axis=0))
        assert (plan @ middle).min() == pytest.approx(0.3, abs=1e-12)


def test_the_default_fills_what_it_says() -> None:
    _, radius = spheres_of(build("packing"))
    assert (4.0 / 3.0 * math.pi * radius**3).sum() == pytest.approx(0.6 * 0.5, rel=0.01)
