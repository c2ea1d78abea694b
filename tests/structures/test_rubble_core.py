# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls with a core: rubble that lies where it can stay, through-stones, and the same wall with a solid core."""

from __future__ import annotations

import numpy as np
import pytest
from models import advance, gravity, material_of, still
from scipy.optimize import nnls
from solids import build

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from structures.layout import rubble

WALL: dict[str, object] = {"length": 1.6, "height": 1.0, "thickness": 0.6, "course_height": 0.25, "through": 2, "core_thickness": 0.2}
SPHERES = {"core": "rubble", "core_diameters": (0.12, 0.08)}


def balls(blocks: list[Block]) -> list[Block]:
    return [block for block in blocks if block.radius]


def boxes(blocks: list[Block]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Low and high corners of all but the spheres [m]."""
    return [(block.vertices.min(axis=0), block.vertices.max(axis=0)) for block in blocks if not block.radius]


def test_each_sphere_lies_on_what_can_carry_it() -> None:
    """Its weight is a sum of pushes, none negative, along the normals of what touches it."""
    blocks = build("wall", **WALL, **SPHERES)
    made, stones = balls(blocks), boxes(blocks)
    centre, radius = np.array([b.vertices[0] for b in made]), np.array([b.radius for b in made])
    assert len(made) > 50
    for i, own in enumerate(centre):
        away = own - np.concatenate([np.delete(centre, i, axis=0), [np.clip(own, low, high) for low, high in stones]])
        gap = np.linalg.norm(away, axis=1) - radius[i]
        gap[: len(made) - 1] -= np.delete(radius, i)
        assert gap.min() > -1e-9
        near = away[gap < 5e-3 * radius.max()]
        normal = near / np.linalg.norm(near, axis=1)[:, None]
        assert nnls(normal.T, np.array([0.0, 0.0, 1.0]))[1] < 0.2, own


def test_rubble_fills_a_third_of_the_slot_at_least() -> None:
    """A slot of two diameters holds less than a wide box, for its sides."""
    blocks = build("wall", **WALL, **SPHERES)
    filled = sum(b.mass_properties.volume for b in balls(blocks))
    through = sum(float(np.prod(high - low)) for low, high in boxes(blocks)[:-1] if high[1] - low[1] > 0.59)
    slot = (1.6 * 1.0 - through / 0.6) * 0.2
    assert 1.0 / 3.0 < filled / slot < 0.6


def test_rubble_is_at_rest_in_a_tenth_of_a_second_and_the_leaves_stay() -> None:
    blocks = build("wall", **WALL, **SPHERES)
    run = Run.model_validate({"dt": 2e-3, "duration": 1.0, "solver": "nlgs", "tolerance": 1e-4})
    machine = Stepper(Assembly.from_blocks(blocks, material_of(0.6, rolling=0.1)), still(100), gravity(100), run)
    advance(machine, 50)
    moved = np.linalg.norm(machine.state.position - machine.assembly.centre, axis=1)
    rolls = np.array([block.radius > 0.0 for block in blocks])
    assert moved[~rolls].max() < 5e-4
    assert np.median(moved[rolls]) < 1e-3
    assert moved[rolls].max() < 0.06


def test_the_seed_alone_decides_where_the_rubble_lies() -> None:
    first, second, other = (np.array([b.vertices[0] for b in balls(build("wall", **WALL, **SPHERES, core_seed=k))]) for k in (1, 1, 2))
    assert first.tobytes() == second.tobytes()
    assert len(first) != len(other) or np.abs(first - other).max() > 1e-3


def test_leaves_and_through_stones_are_those_of_the_wall_with_a_solid_core() -> None:
    hollow, solid = build("wall", **WALL, **SPHERES), build("wall", **WALL, core="solid")
    leaves = {b.name: b for b in hollow if b.group == "wall"}
    assert {b.name for b in solid if b.group == "wall"} == set(leaves)
    for block in solid:
        if block.group == "wall":
            assert np.array_equal(block.vertices, leaves[block.name].vertices)
    assert sum(b.mass_properties.volume for b in solid if not b.fixed) == pytest.approx(1.6 * 1.0 * 0.6)
    through = [b for b in solid if b.group == "wall" and np.ptp(b.vertices[:, 1]) > 0.59]
    inner = [b for b in through if np.abs(b.vertices[:, 0]).max() < 0.79]
    assert len(inner) > 0
    none = build("wall", **(WALL | {"through": 0}), core="solid")
    assert all(np.abs(b.vertices[:, 0]).max() > 0.79 for b in none if b.group == "wall" and np.ptp(b.vertices[:, 1]) > 0.59)


def test_a_core_has_a_density_of_its_own() -> None:
    for core in ("solid", "rubble"):
        densities = {b.group: b.density for b in build("wall", **WALL, core=core, core_density=1600.0)}
        assert densities == {"wall": 2000.0, "core": 1600.0, "base": 2000.0}


def test_a_single_sphere_falls_to_the_floor_of_a_slot_and_rests_between_two() -> None:
    """One stone lies at its radius; two as wide as the slot side by side; a third in their hollow, at the height of its closed form."""
    slot = rubble.Slot(0.0, 0.2, 0.0, 0.1, 0.0, 0.25)
    made = rubble.fill(slot, np.empty((0, 4)), [0.0, 0.25], [0.0999], [1.0], 3)
    z = np.sort(made.centre[:, 2])
    assert z[:2] == pytest.approx([0.04995] * 2)
    assert z[2] > 1.4 * z[1]
