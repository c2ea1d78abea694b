# SPDX-License-Identifier: GPL-3.0-or-later
"""Domes over polygons: plane faces that match, no joint along a meridian, standing."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from solids import build, exposed, free_volume, moved_at_rest
from statics3d import assembled, can_stand, in_one_piece

from masonry_cd.mechanics.model.polygon import polygon_area, polygon_centroid
from structures.courser import rings


def ring_volume(sides: int, profile: np.ndarray) -> float:
    """Volume of a ring over a polygon: a side at distance d has the length 2 d tan(pi/N) [m3]."""
    return 2.0 * sides * math.tan(math.pi / sides) * abs(polygon_area(profile)) * float(polygon_centroid(profile)[0])


@pytest.mark.parametrize("keys", [{"sides": 16, "oculus": 1.2, "drum_height": 1.5, "drum_thickness": 0.8}, {"sides": 9, "oculus": 2.0}])
def test_blocks_fill_the_rings_and_every_inner_face_is_a_joint(keys: dict[str, float]) -> None:
    blocks = build("dome", span=6.0, thickness=0.5, rows=8, **keys)
    sides, drum = int(keys["sides"]), keys.get("drum_height", 0.0)
    top = math.acos(keys["oculus"] / 6.0)
    rows = rings.dome_rows("dome", 3.0, 0.5, drum, 8, top)
    exact = sum(ring_volume(sides, row.profile) for row in rows)
    if drum:
        exact += ring_volume(sides, np.array([[3.0, 0.0], [3.8, 0.0], [3.8, drum], [3.0, drum]]))
    assert free_volume(blocks) == pytest.approx(exact, rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    tan = 2.0 * sides * math.tan(math.pi / sides)
    skin = 0.0
    for row in rows:
        low_in, low_out, high_out, high_in = row.profile
        skin += tan * sum(np.linalg.norm(b - a) * 0.5 * (a[0] + b[0]) for a, b in ((low_in, high_in), (low_out, high_out)))
    (d_out, z_out), (d_in, z_in) = rows[-1].profile[2:]
    skin += tan * math.hypot(d_out - d_in, z_out - z_in) * 0.5 * (d_in + d_out)  # round the oculus
    if drum:
        skin += tan * (drum * (3.0 + 3.8) + 0.5 * (3.8**2 - 3.5**2))
    assert exposed(blocks, assembly, joints) == pytest.approx(skin, rel=1e-6)


def test_a_closed_dome_has_a_key_that_touches_its_whole_ring() -> None:
    blocks = build("dome")
    assembly, joints = assembled(blocks)
    key = assembly.names.index("key")
    round_it = (joints.block_a == key) | (joints.block_b == key)
    assert joints.area[round_it].sum() == pytest.approx(16 * rings_side(blocks[key]), rel=1e-6)


def rings_side(key) -> float:
    """Area of one side of a key stone [m2]."""
    face = next(face for face in key.faces if len(face) == 4)
    corners = key.vertices[list(face)] - key.vertices[face[0]]
    return float(0.5 * np.linalg.norm(np.cross(corners[1:-1], corners[2:]).sum(axis=0)))


def test_no_joint_runs_along_a_meridian() -> None:
    blocks = build("dome", sides=12)
    rows: dict[str, set[float]] = {}
    for block in blocks:
        if block.group == "dome":
            directions = np.degrees(np.arctan2(block.vertices[:, 1], block.vertices[:, 0])).round(3) % 360.0
            corner = [float(a) for a in directions if (a + 15.0) % 30.0 in (0.0, 30.0)]
            if len(block.parts) < 2:
                rows.setdefault(block.name.split(".")[1], set()).update(corner)
            else:
                rows.setdefault(block.name.split(".")[1], set())
    closed = [not corners for _, corners in sorted(rows.items(), key=lambda item: int(item[0]))]
    assert all(one or other for one, other in itertools.pairwise(closed))  # of two rows one turns round every corner
    assert not all(closed)


def test_domes_stand_on_friction() -> None:
    blocks = build("dome")
    assert can_stand(blocks, mu=0.6)
    assert moved_at_rest(blocks) < 1e-4
    assert can_stand(build("dome", oculus=1.2, drum_height=1.5, sides=12), mu=0.6)
    assert not can_stand(blocks, mu=0.08)  # the rows slide on their beds


def test_sixteen_free_lunes_stand_from_a_thickness_of_0_0428_of_the_radius_on() -> None:
    """Radius to the middle of the shell, 24 rows: by limit analysis 0.0428; of one in bond the rows go round, and less does."""

    def lunes(ratio: float, bonded: bool = False) -> bool:
        return can_stand(build("dome", span=2.0 - ratio, thickness=ratio, sides=16, rows=24, bonded=bonded), mu=0.9)

    assert (lunes(0.0425), lunes(0.0431)) == (False, True)


def test_free_lunes_have_a_joint_along_every_meridian_and_the_volume_of_a_dome_in_bond() -> None:
    free, bonded = (build("dome", sides=8, rows=6, bonded=which) for which in (False, True))
    assert free_volume(free) == pytest.approx(free_volume(bonded), rel=1e-12)
    assert all(len(block.parts) < 2 for block in free)
    assert sum(block.group == "dome" for block in free) == 8 * 6
