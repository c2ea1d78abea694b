# SPDX-License-Identifier: GPL-3.0-or-later
"""Arches: their geometry against closed forms, and whether they can stand at the published thickness."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from solids import moved_at_rest
from statics import can_stand, section

import structures
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import mass_properties


def build(**keys: object) -> list[Block]:
    return structures.build({"kind": "arch", **keys}, 2000.0, Path())


def ring_of(blocks: list[Block]) -> list[Block]:
    return [block for block in blocks if block.group == "arch"]


def volume(blocks: list[Block]) -> float:
    return sum(mass_properties(block.vertices, block.faces).volume for block in blocks)


@pytest.mark.parametrize(
    ("keys", "inner", "embrace"),
    [
        ({"radius": 10.0, "thickness": 1.069}, 10.0 - 1.069 / 2, 180.0),
        ({"span": 4.0, "thickness": 0.5}, 2.0, 180.0),
        ({"span": 4.0, "thickness": 0.5, "rise": 1.0}, 2.5, math.degrees(4 * math.atan(0.5))),
        ({"span": 4.0, "thickness": 0.5, "embrace": 120.0}, 2.0 / math.sin(math.radians(60)), 120.0),
        ({"radius": 5.0, "thickness": 0.5, "rise": 2.0}, 4.75, math.degrees(2 * math.acos(1 - 2 / 4.75))),
        ({"radius": 5.0, "thickness": 0.5, "span": 4.0}, 4.75, math.degrees(2 * math.asin(2 / 4.75))),
    ],
)
def test_ring_has_the_volume_span_and_rise_of_its_circle(keys: dict[str, float], inner: float, embrace: float) -> None:
    count, width = 14, 1.5
    ring = ring_of(build(**keys, voussoirs=count, width=width))
    outer, half = inner + keys["thickness"], math.radians(embrace / 2)
    exact = count * 0.5 * (outer**2 - inner**2) * math.sin(2 * half / count) * width
    assert volume(ring) == pytest.approx(exact, rel=1e-9)
    assert [block.name for block in ring] == [f"v{i + 1}" for i in range(count)]
    springing, crown = section(ring[0])[0], section(ring[count // 2])[0]
    assert springing == pytest.approx([-inner * math.sin(half), 0.0], abs=1e-12)
    assert crown == pytest.approx([0.0, inner * (1 - math.cos(half))], abs=1e-12)


@pytest.mark.parametrize("keys", [{"radius": 10.0}, {"span": 7.0, "rise": 2.0}, {"span": 7.0, "shape": "pointed"}])
@pytest.mark.parametrize("count", [12, 28])
def test_neighbours_share_their_joint_to_the_bit_and_the_arch_is_its_own_mirror_image(keys: dict, count: int) -> None:
    ring = ring_of(build(**keys, thickness=1.1, voussoirs=count))
    corners = [{tuple(corner) for corner in block.vertices} for block in ring]
    for here, following in pairwise(corners):
        assert len(here & following) == 4
    for here, opposite in zip(corners, corners[::-1], strict=True):
        assert {(-x, y, z) for x, y, z in here} == opposite


def test_semicircle_stands_on_level_seats_at_the_height_zero() -> None:
    blocks = build(radius=10.0, thickness=1.0, ground=False)
    assert set(section(blocks[0])[[0, -1], 1]) == {0.0}
    for block in blocks:
        if block.fixed:
            assert block.group == "base"
            assert block.vertices[:, 2].max() == 0.0


def test_seats_of_a_segmental_arch_lie_in_the_springing_joints() -> None:
    blocks = build(span=4.0, rise=1.0, thickness=0.5, abutment=0.8)
    joint = section(blocks[0])[[0, -1]]  # intrados and extrados end
    along = (joint[1] - joint[0]) / np.linalg.norm(joint[1] - joint[0])
    seat = section(next(block for block in blocks if block.name == "abutment1"))
    off = (seat - joint[0]) @ np.array([along[1], -along[0]])
    assert sorted(np.abs(off)) == pytest.approx([0.0, 0.0, 0.8, 0.8], abs=1e-12)
    assert (seat @ along).min() < (joint @ along).min() < (joint @ along).max() < (seat @ along).max()


def test_equilateral_pointed_arch_rises_to_its_apex() -> None:
    ring = ring_of(build(shape="pointed", span=4.0, thickness=0.4, voussoirs=20))
    assert section(ring[10])[0] == pytest.approx([0.0, 4.0 * math.sqrt(3) / 2], abs=1e-12)
    assert section(ring[0])[[0, -1]] == pytest.approx(np.array([[-2.0, 0.0], [-2.4, 0.0]]), abs=1e-12)


def test_no_abutment_when_none_is_asked_for() -> None:
    assert not any(block.fixed for block in build(radius=2.0, thickness=0.4, abutment=False))


def test_arch_of_27_voussoirs_can_stand_just_above_the_published_thickness_and_not_below() -> None:
    # exact limit analysis of straight-edged voussoirs: t/R = 0.10672
    assert can_stand(build(radius=10.0, thickness=1.0675, voussoirs=27), mu=0.5)
    assert not can_stand(build(radius=10.0, thickness=1.0668, voussoirs=27), mu=0.5)


def test_three_centred_arch_is_tangent_at_its_springings_and_rises_to_its_crown() -> None:
    blocks = build(shape="three-centred", span=6.0, rise=2.0, thickness=0.6, voussoirs=41)
    ring = [section(b) for b in blocks if b.group == "arch"]
    crown = ring[20]
    assert crown[:, 1].min() == pytest.approx(2.0, abs=0.01)  # the chord of the keystone
    first = ring[0]
    assert np.abs(first[:, 1]).min() == 0.0  # level springing joint
    for one, other in zip(ring, ring[::-1], strict=True):
        assert np.allclose(sorted(-one[:, 0]), sorted(other[:, 0]))
        assert np.allclose(sorted(one[:, 1]), sorted(other[:, 1]))
    assert can_stand(blocks, mu=0.6)


def test_flat_arch_wedges_between_its_skewbacks() -> None:
    def flat(skew: float) -> list[Block]:
        return build(shape="flat", span=2.0, thickness=0.6, voussoirs=9, skew=skew)

    area = 0.6 * (2.0 + 0.6 * math.tan(math.radians(20.0)))
    volume = sum(mass_properties(b.vertices, b.faces).volume for b in flat(20.0) if b.group == "arch")
    assert volume == pytest.approx(area)
    assert can_stand(flat(20.0), mu=0.0)  # wedges need no friction


@pytest.mark.parametrize("keys", [{"span": 6.0}, {"span": 6.0, "rise": 1.5}, {"span": 4.0, "shape": "flat"}])
def test_buttresses_carry_the_thrust_when_they_are_wide_enough(keys: dict[str, object]) -> None:
    def on(width: float, height: float) -> list[Block]:
        return build(thickness=0.7, buttress_width=width, buttress_height=height, **keys)

    blocks = on(2.2, 3.0)
    assert {b.group for b in blocks} == {"arch", "buttress1", "buttress2", "base"}
    assert can_stand(blocks, mu=0.6)
    assert not can_stand(on(1.0, 20.0), mu=0.6)


FORMS: dict[str, dict[str, object]] = {
    "round": {"span": 4.0},
    "segmental": {"span": 4.0, "rise": 1.0},
    "pointed": {"span": 4.0, "rise": 3.0, "shape": "pointed", "voussoirs": 16},
    "three-centred": {"span": 6.0, "rise": 2.0, "shape": "three-centred"},
    "flat": {"span": 2.0, "shape": "flat"},
    "on buttresses": {"span": 4.0, "buttress_width": 2.2, "buttress_height": 2.0},
}


@pytest.mark.parametrize("keys", FORMS.values(), ids=FORMS)
def test_every_joint_is_found_and_gravity_moves_nothing(keys: dict[str, object]) -> None:
    blocks = build(**{"thickness": 0.6, "width": 1.2, "voussoirs": 15, **keys})
    names = [block.name for block in ring_of(blocks)]
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints = find_joints(assembly)
    of_ring = np.isin(np.array(assembly.names)[joints.block_a], names) | np.isin(np.array(assembly.names)[joints.block_b], names)
    assert of_ring.sum() == len(names) + 1
    depth = joints.area[of_ring] / 1.2
    if keys.get("shape") != "flat":  # its joints are longer the more they lean
        assert np.sort(depth)[: len(names)] == pytest.approx(0.6, rel=1e-6)  # all but that at the apex of a pointed one
    assert moved_at_rest(blocks) < 1e-4
