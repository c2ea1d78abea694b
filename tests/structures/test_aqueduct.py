# SPDX-License-Identifier: GPL-3.0-or-later
"""Aqueducts: blocks that fill the solid without gap or overlap, and that can stand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from solids import moved_at_rest
from statics import can_stand, section, stretches
from statics3d import can_stand as can_stand_in_space

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.bridge.masonry import arches, supports
from structures.kinds import aqueduct

CASES: dict[str, dict[str, object]] = {
    "default": {},
    "two tiers": {"tiers": 2, "pier_courses": [8, 5], "pier_width": [2.0, 1.8]},
    "small arches on top": {
        "tiers": 3,
        "spans": [2, 2, 6],
        "clear_span": [10.0, 10.0, 2.2],
        "pier_width": [3.0, 3.0, 2.0],
        "pier_courses": [6, 5, 4],
        "ring_thickness": [1.2, 1.2, 0.6],
        "course_height": 0.6,
    },
    "fine voussoirs": {"voussoirs": 31, "course_height": 0.4, "ends": "abutment"},
    "even coarse voussoirs": {"voussoirs": 8, "clear_span": 8.0, "cover": 1.9, "pier_blocks": 1},
    "least cover": {"cover": 0.25, "spans": 1},
}


def build(**keys: object) -> list[Block]:
    return structures.build({"kind": "aqueduct", **keys}, 2200.0, Path())


def free(blocks: Sequence[Block]) -> list[Block]:
    return [block for block in blocks if not block.fixed]


@pytest.fixture(scope="module", params=CASES)
def built(request: pytest.FixtureRequest) -> tuple[dict[str, object], list[Block]]:
    keys = CASES[request.param]
    return keys, build(**keys)


def test_volume_and_joints_are_those_of_closed_forms(built: tuple[dict[str, object], list[Block]]) -> None:
    """All the volume between the piers and under the rings is missing; each side is a whole joint or an outer side."""
    keys, blocks = built
    tiers = aqueduct.tiers_of(aqueduct.AqueductTable.model_validate(keys))
    volume = outer = 0.0
    for tier in tiers:
        span, count = tier.layout.keys.spans[0], len(tier.layout.profiles)
        assert span.voussoirs is not None
        radius, turn, pier = 0.5 * span.span, math.pi / span.voussoirs, tier.pier_courses * tier.course
        high = pier + radius + span.thickness + tier.layout.keys.cover
        if span.voussoirs % 2:  # the keystone's chord lies below the circle
            high -= (radius + span.thickness) * (1.0 - math.cos(0.5 * turn))
        opening = span.span * pier + 0.5 * span.voussoirs * radius**2 * math.sin(turn)
        volume += (tier.length * high - count * opening) * tier.layout.keys.width
        outer += 2.0 * high + tier.length + count * (2.0 * pier + 2.0 * span.voussoirs * radius * math.sin(0.5 * turn))
        feet = tier.length - count * span.span
        outer += feet if tier is tiers[0] else -feet  # on a level top they are joints
    assert sum(mass_properties(block.vertices, block.faces).volume for block in free(blocks)) == pytest.approx(volume, rel=1e-9)
    perimeter = sum(length for block in free(blocks) for length in _sides(section(block)))
    joints = sum(np.linalg.norm(ends[1] - ends[0]) for _, _, ends, _ in stretches(free(blocks)))
    assert perimeter == pytest.approx(outer + 2 * joints, rel=1e-9)


def _sides(polygon: np.ndarray) -> list[float]:
    return list(np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1))


def test_joints_are_closed_to_rounding(built: tuple[dict[str, object], list[Block]]) -> None:
    _, blocks = built
    for first, second, ends, normal in stretches(blocks):
        below, above = (section(blocks[second]) @ normal).max(), (section(blocks[first]) @ normal).min()
        assert abs(above - below) < 1e-12
        assert np.linalg.norm(ends[1] - ends[0]) > 0.05, (blocks[first].name, blocks[second].name)


def test_no_slivers(built: tuple[dict[str, object], list[Block]]) -> None:
    _, blocks = built
    for block in free(blocks):
        polygon = section(block)
        sides = np.roll(polygon, -1, axis=0) - polygon
        normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1, keepdims=True)
        assert np.ptp(polygon @ normals.T, axis=0).min() > 0.1, block.name


def test_it_can_stand_at_rest(built: tuple[dict[str, object], list[Block]]) -> None:
    _, blocks = built
    assert can_stand(blocks, mu=0.6)


@pytest.mark.parametrize("keys", [{}, CASES["two tiers"]], ids=["default", "two tiers"])
def test_gravity_moves_nothing(keys: dict[str, object]) -> None:
    assert moved_at_rest(build(**keys), seconds=0.04) < 1e-4


def test_default_is_a_three_span_aqueduct_in_named_parts() -> None:
    blocks = build()
    assert len(free(blocks)) >= 150
    groups = {block.group for block in blocks}
    assert groups == {"base", "top", *(f"{p}{i}" for p, n in (("pier", 4), ("arch", 3), ("spandrel", 4)) for i in range(1, n + 1))}
    assert {block.group for block in blocks if block.fixed} == {"base"}
    assert len([block for block in blocks if block.group == "arch2"]) % 2 == 1  # with a keystone
    levels = np.concatenate([block.vertices[:, 2] for block in blocks if block.group == "top"])
    assert len(set(levels)) == 2  # one level course on top
    crown = min(section(block)[:, 1].max() for block in blocks if block.name == "arch1.v9")
    assert crown < levels.min()


def test_channel_runs_over_the_whole_top() -> None:
    plain, blocks = build(spans=1), build(spans=1, channel_width=0.8, channel_height=1.0)
    channel = blocks[len(plain) :]
    assert {block.group for block in channel} == {"channel"}
    length, top = 9.0, max(block.vertices[:, 2].max() for block in plain)
    volume = sum(mass_properties(block.vertices, block.faces).volume for block in channel)
    assert volume == pytest.approx(length * (1.2 * 1.0 + 2.0 * 0.25), rel=1e-9)
    assert min(block.vertices[:, 2].min() for block in channel) == pytest.approx(top)
    assert can_stand_in_space(blocks, mu=0.6)


def test_tall_piers_without_abutments_cannot_carry_the_thrust_but_abutments_do() -> None:
    slender: dict[str, object] = {"pier_courses": 30, "pier_width": 1.5, "ring_thickness": 0.6, "spans": 1, "clear_span": 9.0}
    assert not can_stand(build(**slender), mu=0.6)
    assert can_stand(build(**slender, ends="abutment"), mu=0.6)


def test_upright_joints_of_successive_courses_go_on_or_keep_clear_of_each_other(built: tuple[dict[str, object], list[Block]]) -> None:
    keys, blocks = built
    least = 0.12 * 2.0 * float(keys.get("course_height", 0.5))  # type: ignore[arg-type]
    upright = []
    for _, _, ends, normal in stretches(free(blocks)):
        if abs(normal[0]) > 1.0 - 1e-9:
            upright.append((ends[0, 0], *sorted(ends[:, 1])))
    assert upright
    for x, _, high in upright:
        apart = [abs(x - other) for other, low, _ in upright if abs(low - high) < 1e-6]
        assert all(a < 1e-9 or a > least - 1e-9 for a in apart)


def test_same_table_gives_the_same_bits() -> None:
    for one, other in zip(build(), build(), strict=True):
        assert one.name == other.name
        assert one.vertices.tobytes() == other.vertices.tobytes()


def test_rings_and_piers_are_those_of_the_bridge_that_it_is_a_preset_of() -> None:
    keys = {"spans": 2, "clear_span": 4.7, "pier_width": 2.1, "pier_courses": 5, "pier_blocks": 1}
    (tier,) = aqueduct.tiers_of(aqueduct.AqueductTable.model_validate(keys))
    made = [block for part in (arches, supports) for block in part(tier.layout, 2200.0)[0] if not block.fixed]
    own = {block.name: block for block in build(**keys) if block.group.startswith(("arch", "pier"))}
    names = {"abutment1": "pier1", "pier1": "pier2", "abutment2": "pier3"}  # an aqueduct counts its ends among its piers
    assert len(made) == len(own)
    for block in made:
        group = names.get(block.group, block.group)
        corners = own[f"{group}.{block.name.split('.')[1]}"].vertices
        assert np.abs(corners[:, None] - block.vertices).max(axis=2).min(axis=0) == pytest.approx(0.0, abs=1e-12)


def test_a_ring_as_thick_as_its_opening_is_refused() -> None:
    with pytest.raises(InputError, match=r"^structure\.ring_thickness: must be below the clear span, 0\.6 m, got 0\.7$"):
        build(clear_span=0.6, ring_thickness=0.7, pier_width=2.0)
