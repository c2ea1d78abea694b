# SPDX-License-Identifier: GPL-3.0-or-later
"""The fill of bridges: thrusts in closed form, and a passive resistance that grows, is capped, and is none on the way out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bridge_scenes import bridge, grid

from loads import fill
from loads.bars import Forces, PointLoad, Tie

SOLID = [{"rigid": False, "height": 2.0}]


def of_fill(shaken: bool = False, **keys: object) -> tuple:
    made, assembly = bridge(width=3.0, cover=0.4, abutments=SOLID, **keys)
    part = fill.part(made.fills[0], grid(made, assembly), shaken)
    pressed = [f for f in part.forces if isinstance(f, PointLoad)]
    return made.fills[0], assembly, pressed, [f for f in part.forces if isinstance(f, Tie)]


@pytest.mark.parametrize(("pressure", "k"), [("at_rest", 0.5), ("active", 1.0 / 3.0), ("none", 0.0)])
def test_the_back_of_an_abutment_is_pressed_by_half_k_gamma_of_the_depths_squared(pressure: str, k: float) -> None:
    found, assembly, pressed, _ = of_fill(fill={"pressure": pressure, "friction_angle": 30.0, "density": 1800.0})
    backs = [face for face in found.faces if face.kind == "back" and face.block.startswith("abutment1")]
    low, high = -2.0, max(float(face.corners[:, 2].max()) for face in backs)
    deep, shallow = found.level - low, found.level - high
    exact = 0.5 * k * 1800.0 * 10.0 * (deep**2 - shallow**2) * 3.0
    left = [load for load in pressed if assembly.names[load.block].startswith("abutment1")]
    assert sum(float(load.force[0]) for load in left) == pytest.approx(exact)  # towards the span
    if k:
        lever = sum(float(load.force[0]) * (assembly.centre[load.block] + load.arm)[2] for load in left) / exact
        middle = found.level - (deep**3 - shallow**3) / (1.5 * (deep**2 - shallow**2))
        assert lever == pytest.approx(middle)


def test_walls_are_pressed_outwards_and_both_sides_alike() -> None:
    _, assembly, pressed, _ = of_fill(walls={"course_height": 0.5, "unit_length": 1.0}, fill={"friction_angle": 0.0})
    total = {side: np.zeros(3) for side in ("front", "back")}
    for load in pressed:
        for side, sum_of in total.items():
            if assembly.names[load.block].startswith(f"spandrel_{side}"):
                sum_of += load.force
    assert total["front"][1] < 0.0
    assert total["front"] == pytest.approx(-total["back"])


@pytest.mark.parametrize(("shaken", "share"), [(False, 0.5), (True, 0.2)])
def test_passive_resistance_is_capped_at_its_share_of_k_p(shaken: bool, share: float) -> None:
    found, _, _, bars = of_fill(shaken, fill={"passive": 0.5, "passive_shaken": 0.2, "density": 1800.0})
    arches = [bar for bar in bars if "arch1" in bar.name]
    left = sum(bar.limit for bar in arches if bar.name.endswith("left"))
    crown, foot = found.level - 2.0, found.level - min(float(f.corners[:, 2].min()) for f in found.faces if f.kind == "extrados")
    # chords: the integral of depth over the level part is the mean depth times the rise of each, exact for any polyline
    assert left == pytest.approx(share * 3.0 * 1800.0 * 10.0 * 0.5 * (foot**2 - crown**2) * 3.0, rel=2e-3)  # but for the level chord
    assert left == pytest.approx(sum(bar.limit for bar in arches if bar.name.endswith("right")))


def test_an_arch_meets_it_only_where_it_moves_into_the_fill_and_in_proportion_up_to_the_cap() -> None:
    found, assembly, _, bars = of_fill(fill={"mobilised_at": 0.01})
    left = next(bar for bar in bars if bar.name == "fill of arch1, left")
    forces, turns = Forces((), (left,)), np.broadcast_to(np.eye(3), (assembly.count, 3, 3))

    def met(moved: float) -> float:
        position = assembly.centre.copy()
        position[left.blocks[0], 0] += moved
        yielded = forces.yields(position, turns, np.zeros(1))
        acting = forces.acting(position, turns, np.zeros((assembly.count, 6)), 0, 1, yielded)
        return float(acting.force[0, 0])

    assert met(0.005) == 0.0  # towards the span, out of the fill
    assert met(-0.005) == pytest.approx(0.5 * left.limit)
    assert met(-0.01) == pytest.approx(left.limit)
    assert met(-0.05) == pytest.approx(left.limit)
    assert found.mobilised_at == 0.01


def test_a_slanted_arch_meets_the_fill_at_right_angles_to_its_springings() -> None:
    made, assembly = bridge(width=3.0, skew=30.0)
    bars = [f for f in fill.part(made.fills[0], grid(made, assembly), False).forces if isinstance(f, Tie)]
    points = assembly.centre[list(bars[0].blocks)] + bars[0].arms
    way = (points[1] - points[0]) / fill.FAR
    assert abs(way[1] / way[0]) == pytest.approx(math.tan(math.radians(30.0)))
    assert way[2] == pytest.approx(0.0, abs=1e-12)
