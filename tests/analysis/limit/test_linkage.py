# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms of macro-elements followed as linkages: walls that overturn and bend, floors and interlock on them, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from models import GRAVITY, box, ground
from test_macro import EFFORT, element, stack, toothed, whole_of

from masonry_cd.analysis.limit.found import FoundMechanism
from masonry_cd.analysis.limit.macro import analyse_element
from masonry_cd.analysis.limit.part import part_of, resting
from masonry_cd.analysis.limit.problem import Bars, PointMasses
from structures.macro_elements.element import OVERTURNING, VERTICAL_BENDING

X = (1.0, 0.0, 0.0)
FOLLOWED = replace(EFFORT, displacements=True)
WEIGHT = 2000.0 * GRAVITY  # per volume


def least(whole, part) -> FoundMechanism:
    """The mechanism of the least acceleration of a part that is pushed along x."""
    return analyse_element(whole, part, X, FOLLOWED).mechanisms[0]


def test_courses_that_overturn_are_a_free_standing_wall() -> None:
    """alpha = tan(beta - theta), and d0* = b/2; whatever it is laid of, and next to a wall that is held."""
    whole = whole_of([ground(8.0), *stack("wall", 6), *stack("held", 6, x=-0.5)])
    made = least(whole, element(whole, "wall")).oscillator
    assert made.alpha == pytest.approx(0.5 / 3.0, rel=1e-5) and made.fraction == pytest.approx(1.0, rel=1e-6)
    assert made.falls and made.last == pytest.approx(0.25, rel=1e-3) and made.by == "linkage of bodies"
    beta, radius = math.atan(0.5 / 3.0), 0.5 * math.hypot(0.5, 3.0)
    theta = beta - math.asin(0.6 * 0.25 / radius)
    assert made.acceleration(0.4 * made.last) == pytest.approx(math.tan(beta - theta) * GRAVITY, rel=1e-2)


def test_a_floor_and_a_mass_go_with_the_wall_and_count_in_its_oscillator() -> None:
    """The floor bears in the middle of its seat: alpha0, sum (P + Q) and d0* of the common centre of wall and load."""
    blocks = [ground(8.0), *stack("wall", 6), box("far", (-4.0, -1.0, 0.0), (-3.5, 1.0, 3.0), fixed=True)]
    blocks.append(replace(box("slab", (-4.0, -1.0, 3.0), (0.5, 1.0, 3.2)), group="floor"))
    whole = whole_of(blocks)
    wall, load = WEIGHT * 0.5 * 2.0 * 3.0, 0.5 * WEIGHT * 4.5 * 2.0 * 0.2
    one = least(whole, element(whole, "wall"))
    middle = (wall * 1.5 + load * 3.0) / (wall + load)
    assert one.oscillator.weight == pytest.approx(wall + load, rel=1e-9)
    assert one.oscillator.alpha == pytest.approx(0.25 / middle, rel=1e-4)
    assert one.oscillator.last == pytest.approx(0.25, rel=2e-2)  # the displacement is that of the beginning, times its size at the end
    masses = PointMasses(np.array([6]), np.array([[0.0, 0.0, 0.25]]), np.array([1000.0]))
    heavy = replace(whole, masses=masses, dead=whole.dead + masses.under(np.array([0.0, 0.0, -GRAVITY]), whole.assembly.count))
    assert least(heavy, element(whole, "wall")).oscillator.weight == pytest.approx(wall + load + 1000.0 * GRAVITY, rel=1e-9)


def test_the_friction_of_interlock_counts_at_the_start_only() -> None:
    """alpha0 has its work; d0* is that of the same facade without it."""
    whole = whole_of(toothed())
    facade = element(whole, "facade")
    one = analyse_element(whole, facade, X, replace(FOLLOWED, most_points=0)).mechanisms[0]
    assert one.name == "simple overturning"
    part = part_of(whole, resting(whole, facade.blocks), np.array(X))
    assert part.interlock > 0.0
    made = one.oscillator
    assert made.falls and made.acceleration() == pytest.approx(made.alpha * GRAVITY / made.fraction, rel=1e-9)
    assert made.alpha > 1.2 * made.acceleration(1e-3 * made.last) * made.fraction / GRAVITY


def test_a_wall_tied_at_its_top_bends_and_says_that_its_factor_does_not_vanish() -> None:
    """Two bodies between three hinges, the one at the back in a bed of height h: alpha0 = 1.5 P / (1.5 h P), at least 1/2.5; centres go
    h/2, so e* = 1. Where the upper one would fall back by itself no factor is borne, and the check by displacements says so."""
    top = np.array([[-3.0, 0.0, 3.0], [0.0, 0.0, 3.0]])
    blocks = [ground(8.0), *stack("wall", 6), box("far", (-3.5, -1.0, 0.0), (-3.0, 1.0, 3.0), fixed=True)]
    whole = whole_of(blocks, Bars(np.array([[7, 6]]), top[None], np.array([1e9])))
    found = analyse_element(whole, element(whole, "wall", mechanisms=(OVERTURNING, VERTICAL_BENDING)), X, FOLLOWED)
    made = found.mechanisms[0].oscillator
    assert made.alpha == pytest.approx(1.0 / 2.5, rel=1e-4) and made.fraction == pytest.approx(1.0, rel=1e-6)
    assert not made.falls and made.end.startswith("the capacity curve ends before the load factor vanishes: beyond, no factor")


def test_what_spreads_is_not_followed() -> None:
    """Slabs that lean each by itself are many oscillators: e* = 1, and no displacement."""
    whole = whole_of([ground(40.0), *(box(f"row.{k}", (1.2 * k, -1.0, 0.0), (1.2 * k + 0.5, 1.0, 3.0)) for k in range(10))])
    found = analyse_element(whole, element(whole, "row"), X, FOLLOWED).mechanisms
    spread = [one.oscillator for one in found if one.oscillator.doubt]
    assert all(not made.falls and made.fraction == 1.0 for made in spread)
