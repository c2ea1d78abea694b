# SPDX-License-Identifier: GPL-3.0-or-later
"""Vaults: barrels and groins without gap or overlap, standing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from solids import build, exposed, free_volume, moved_at_rest
from statics3d import assembled, can_stand, in_one_piece

from masonry_cd.mechanics.model.polygon import polygon_area, polygon_centroid


def ring(count: int, inner: float, outer: float) -> list[np.ndarray]:
    """The voussoirs of a semicircle."""
    ends = [math.pi * (1.0 - k / count) for k in range(count + 1)]
    unit = np.array([[math.cos(a), math.sin(a)] for a in ends])
    return [np.array([inner * unit[k], inner * unit[k + 1], outer * unit[k + 1], outer * unit[k]]) for k in range(count)]


def volume_of_cross_vault(count: int, inner: float, outer: float, end: float) -> float:
    """Four webs, each the integral of its length from the groin |y| to the end over the ring [m3]."""
    total = 0.0
    for quad in ring(count, inner, outer):
        pieces = [quad] if quad[0, 0] * quad[1, 0] >= -1e-12 else _halves(quad)
        for piece in pieces:
            total += abs(polygon_area(piece)) * (end - abs(polygon_centroid(piece)[0]))
    return 4.0 * total


def _halves(quad: np.ndarray) -> list[np.ndarray]:
    (_, z0), (x1, z1), (x2, z2), (_, z3) = quad
    half = np.array([(0.0, 0.5 * (z0 + z1)), (x1, z1), (x2, z2), (0.0, 0.5 * (z2 + z3))])
    return [half, half * [-1.0, 1.0]]


def test_barrel_fills_its_ring_and_its_courses_are_bonded() -> None:
    blocks = build("vault", span=4.0, thickness=0.5, voussoirs=11, length=5.0, ground=False)
    exact = 5.0 * sum(abs(polygon_area(q)) for q in ring(11, 2.0, 2.5))
    assert free_volume(blocks) == pytest.approx(exact, rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    ends = 2.0 * exact / 5.0
    shells = sum(np.linalg.norm(q[1] - q[0]) + np.linalg.norm(q[3] - q[2]) for q in ring(11, 2.0, 2.5)) * 5.0
    assert exposed(blocks, assembly, joints) == pytest.approx(ends + shells, rel=1e-9)
    separate = build("vault", span=4.0, thickness=0.5, voussoirs=11, length=5.0, bonded=False)
    places = {round(float(b.vertices[:, 1].min()), 6) for b in separate if not b.fixed}
    assert len(places) < len({round(float(b.vertices[:, 1].min()), 6) for b in blocks if not b.fixed})


@pytest.mark.parametrize("count", [15, 14])
def test_cross_vault_fills_four_webs_and_every_inner_face_is_a_joint(count: int) -> None:
    blocks = build("vault", form="cross", span=4.0, thickness=0.5, voussoirs=count, pier=0.8, ground=False)
    assert free_volume(blocks) == pytest.approx(volume_of_cross_vault(count, 2.0, 2.5, 2.8), rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    front = 4.0 * sum(abs(polygon_area(q)) for q in ring(count, 2.0, 2.5))
    shells = 0.0
    for quad in ring(count, 2.0, 2.5):
        for (y0, z0), (y1, z1) in ((quad[0], quad[1]), (quad[3], quad[2])):
            mean = 0.5 * (abs(y0) + abs(y1)) if y0 * y1 >= -1e-12 else 0.25 * abs(y0 - y1)
            shells += 4.0 * math.hypot(y1 - y0, z1 - z0) * (2.8 - mean)
    assert exposed(blocks, assembly, joints) == pytest.approx(front + shells, rel=1e-6)


def test_stones_on_the_groin_are_bent_and_the_boss_has_four_arms() -> None:
    blocks = build("vault", form="cross", voussoirs=15)
    groin = [b for b in blocks if b.group == "groin"]
    assert sorted(len(b.parts) for b in groin) == [2] * 28 + [4]


def test_vaults_stand_and_a_thin_one_falls() -> None:
    for keys in ({"voussoirs": 11}, {"form": "cross"}, {"form": "cross", "shape": "pointed", "voussoirs": 12}):
        blocks = build("vault", **keys)
        assert can_stand(blocks, mu=0.6), keys
        assert moved_at_rest(blocks) < 1e-4, keys
    assert not can_stand(build("vault", thickness=0.18, voussoirs=27, length=1.0), mu=0.6)
