# SPDX-License-Identifier: GPL-3.0-or-later
"""Hinges of an arch that pass to other joints along its capacity curve, against the four-bar linkage that the arch then is."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import GRAVITY, box
from released_from_curve import brackets

import structures
from masonry_cd.analysis.limit.analysis import LimitOptions
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.interfaces import interfaces
from masonry_cd.analysis.limit.problem import problem_at
from masonry_cd.analysis.limit.programme import least_unborne
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly

ARCH = {"kind": "arch", "span": 4.0, "thickness": 0.4, "width": 1.0, "voussoirs": 27}


@cache
def followed() -> tuple[Assembly, CapacityCurve]:
    """The arch of examples/arch.toml pushed sideways, and its curve."""
    assembly = Assembly.from_blocks(structures.make(ARCH, 2200.0, Path())[0], 0.6)
    return assembly, capacity_curve(assembly, find_joints(assembly), push_loads(assembly), CurveOptions(LimitOptions(starts=1)))


def linkage(assembly: Assembly, hinges: np.ndarray, split: np.ndarray, turn: float) -> np.ndarray:
    """Centres (B, 2) of blocks between four hinges (4, 2) when the first part has turned to the right by an angle.

    ``split`` (B,) counts the hinges to the left of a block.
    """
    first, second, third, last = hinges
    new_second = first + turned(second - first, -turn)
    reach, near, far = last - new_second, np.linalg.norm(third - second), np.linalg.norm(last - third)
    size = np.linalg.norm(reach)
    along = (size**2 + near**2 - far**2) / (2.0 * size)
    across = np.sqrt(max(near**2 - along**2, 0.0))
    sign = np.sign((last - second)[0] * (third - second)[1] - (last - second)[1] * (third - second)[0])
    new_third = new_second + (along * reach + sign * across * np.array([-reach[1], reach[0]])) / size
    out = assembly.centre[:, [0, 2]].copy()
    for part, old, new, pivot, goes_to in (
        (1, second - first, new_second - first, first, first),
        (2, third - second, new_third - new_second, second, new_second),
        (3, last - third, last - new_third, last, last),
    ):
        angle = np.arctan2(new[1], new[0]) - np.arctan2(old[1], old[0])
        out[split == part] = goes_to + turned(out[split == part] - pivot, angle)
    return out


def turned(vectors: np.ndarray, angle: float) -> np.ndarray:
    """Vectors (..., 2) turned."""
    return vectors @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def four_bars(assembly: Assembly, curve: CapacityCurve, k: int) -> float:
    """Factor, by virtual work, of the linkage with the hinges of a point of the curve, moved as far as the curve is there."""
    stage, joints = curve.stages[k], find_joints(assembly)
    known = {(int(a), int(b)): j for j, (a, b) in enumerate(zip(joints.block_a, joints.block_b, strict=True))}
    places = []
    for now in np.flatnonzero(stage.mechanism.state == 1):
        j = known[int(stage.joints.block_a[now]), int(stage.joints.block_b[now])]
        corners = joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]][:, [0, 2]]
        places.append(corners[np.argmin(np.linalg.norm(corners - stage.mechanism.hinge[now][[0, 2]], axis=1))])
    hinges = np.array(sorted(places, key=lambda place: place[0]))
    split = np.searchsorted(-round_the_arch(hinges), -round_the_arch(assembly.centre[:, [0, 2]]))
    weight = np.where(assembly.fixed, 0.0, assembly.mass)
    block, wanted = curve.control.block, curve.displacement[k] + curve.control.point[0]
    low, high = 0.0, 0.15
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if linkage(assembly, hinges, split, middle)[block, 0] < wanted else (low, middle)
    rate = weight @ (linkage(assembly, hinges, split, low + 1e-5) - linkage(assembly, hinges, split, low - 1e-5))
    return float(rate[1] / rate[0])


def round_the_arch(places: np.ndarray) -> np.ndarray:
    """Angles of places (N, 2) about the centre of the arch, from pi at the left to 0 at the right."""
    return np.arctan2(places[:, 1], places[:, 0])


def test_the_curve_of_a_thin_arch_goes_on_when_hinges_pass_to_other_joints():
    assembly, curve = followed()
    assert len(curve.jumps) == 4
    assert {k - 1 for k in curve.jumps}.isdisjoint(curve.jumps)
    work = [{(a, b) for a, b, _ in stage.at_work()} for stage in curve.stages]
    for k in curve.jumps:
        assert len(work[k] - work[k - 1]) == 1  # one hinge at a time, to the joint next to it
        (new,), (old,) = work[k] - work[k - 1], work[k - 1] - work[k]
        assert new == tuple(number + 1 for number in old)
    expected = [four_bars(assembly, curve, k) for k in range(len(curve.factor))]
    assert curve.factor == pytest.approx(expected, abs=1e-6)
    assert curve.end == "the factor falls below zero at once, where the mechanism changes"
    assert curve.falls


def test_while_hinges_pass_the_dead_loads_do_work_and_the_load_does_none():
    assembly, curve = followed()
    share = np.where(assembly.fixed, 0.0, assembly.mass) / assembly.mass[~assembly.fixed].sum()
    mean = np.array([share @ stage.assembly.centre for stage in curve.stages])
    for k in curve.jumps:
        assert mean[k, 2] < mean[k - 1, 2]
        assert mean[k, 0] == pytest.approx(mean[k - 1, 0], abs=2e-3 * (mean[-1, 0] - mean[0, 0]))


def test_the_dynamics_bracket_the_curve_where_hinges_have_passed():
    assembly, curve = followed()
    for bracket in brackets(curve, assembly.laws, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -GRAVITY])):
        assert bracket.low - 1e-3 * curve.factor[0] <= bracket.factor <= bracket.high
        assert bracket.high - bracket.low <= 0.011 * curve.factor[0]


def test_the_fall_of_two_blocks_over_opposite_edges_is_the_same_in_a_plane_and_in_space():
    plate = box("plate", (-1.0, -0.5, -0.5), (1.0, 0.5, 0.0), fixed=True)
    over = [box("left", (-1.4, -0.5, 0.0), (-0.8, 0.5, 1.0)), box("right", (0.7, -0.5, 0.0), (1.5, 0.5, 1.0))]
    assembly, joints = joined([plate, *over], 0.6)
    loads = push_loads(assembly)
    falls = []
    for axis in (1, None):
        problem = problem_at(assembly, interfaces(assembly, joints, axis), loads, axis)
        best = least_unborne(problem)
        speed = problem.block_velocity(best.velocity, assembly.count)
        assert problem.live @ best.velocity == pytest.approx(0.0, abs=1e-7)
        assert (problem.jacobian @ best.velocity).reshape(-1, problem.directions)[:, 0].min() > -1e-7
        assert np.abs(best.velocity).max() == pytest.approx(1.0, abs=1e-6)
        falls.append((problem.dead @ best.velocity, speed[1:]))
    (planar, in_plane), (spatial, in_space) = falls
    assert planar == pytest.approx(spatial, rel=1e-6)
    assert planar > 0.1
    assert in_plane[:, 2].max() < 0.0  # both go down
    assert in_space == pytest.approx(in_plane, abs=1e-5)
