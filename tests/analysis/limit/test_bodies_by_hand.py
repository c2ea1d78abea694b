# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies as a hand calculation draws them: which overturn below a factor, how two bend, which stones lie above a crack."""

from __future__ import annotations

import numpy as np
import pytest
from models import box, ground
from test_macro import element, stack, whole_of

from masonry_cd.analysis.limit.overturning import overturning_below
from masonry_cd.analysis.limit.restrictions import Restriction, restrictions
from structures.macro_elements.element import IN_PLANE, VERTICAL_BENDING

X = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize(("factor", "bodies"), [(0.33, 0), (0.34, 1)])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_pile_overturns_at_half_its_width_over_half_its_height(factor: float, bodies: int, way: float) -> None:
    """0.25 / 0.75, wherever it stands; its upper courses overturn later, and are part of it."""
    whole = whole_of([ground(8.0), *stack("wall", 3, x=1.2)])
    found = overturning_below(whole, way * X, factor)
    assert len(found) == bodies
    for moves in found:
        assert (way * moves[1:, 0] > 0.0).all() and moves[1:, 4] == pytest.approx(np.full(3, way))


def test_two_bodies_bend_about_the_edge_between_them_while_the_top_stays_in_its_upright() -> None:
    whole = whole_of([ground(8.0), *stack("wall", 4)])
    lower, upper = np.array([1, 2]), np.array([3, 4])
    _, moves = Restriction(VERTICAL_BENDING, ~whole.assembly.fixed, (lower, upper)).by_hand(whole, X)

    def velocity(block: int, place: tuple[float, float, float]) -> np.ndarray:
        return np.asarray(moves[block, :3] + np.cross(moves[block, 3:], np.array(place) - whole.assembly.centre[block]))

    assert velocity(1, (0.5, 0.0, 0.0)) == pytest.approx(np.zeros(3), abs=1e-12)  # the toe
    assert velocity(2, (0.0, 0.0, 1.0)) == pytest.approx(velocity(3, (0.0, 0.0, 1.0)), abs=1e-12)  # the hinge
    assert velocity(2, (0.0, 0.0, 1.0))[0] == pytest.approx(1.0)
    assert velocity(4, (0.0, 0.0, 2.0))[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_what_lies_above_a_crack_from_the_toe_moves_and_the_corner_below_it_stays(way: float) -> None:
    """Cubes of 0.5 m, four by four: of the lowest course the one over the toe alone is above each crack."""
    cubes = [box(f"wall.{i}{k}", (0.5 * i, 0.0, 0.5 * k), (0.5 * i + 0.5, 0.5, 0.5 * k + 0.5)) for i in range(4) for k in range(4)]
    whole = whole_of([ground(8.0), *cubes])
    whole_wall, *cracked = restrictions(whole, element(whole, "wall", mechanisms=(IN_PLANE,)), way * X)
    assert len(whole_wall.bodies[0]) == 16 and len(cracked) == 3
    sizes = [len(one.bodies[0]) for one in cracked]
    assert sizes == sorted(sizes, reverse=True) and 4 < sizes[-1] < sizes[0] < 16
    for one in cracked:
        names = {whole.assembly.names[b] for b in one.bodies[0]}
        assert (f"wall.{3 if way > 0 else 0}0" in names) and (f"wall.{0 if way > 0 else 3}0" not in names)
