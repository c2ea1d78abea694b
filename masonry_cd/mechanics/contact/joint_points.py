# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact points over the depth of elastic joints that open: rings on the lines from the centroid to the corners.

Corners and centroid have force and moments of the linear pressure of a closed joint. Once the joint opens, the pressure ends on the
line g = 0, and a corner that still carries for the strip that hangs open makes it up to 37 % too strong. Such a joint has points at shares
r_1 = 1 > r_2 > ... of the way from the centroid to each corner i instead, with shares s_1, s_2, ... of the area w_i that the corner had
alone, and the rest of the joint's area at the centroid. As long as

    sum s_k r_k^2 = 1,

which also holds of a mean of the rule with the corners alone, taken where little would be left for the centroid of a polygon of many
corners, area, centroid and second moments of a polygon of any shape are those of corners and centroid: a joint that is closed all over has
the same force, moments and energy with either. So the points are exchanged while the joint is closed, where it comes near opening, and back
where it is closed well again, and are fixed in the joint in between: its springs have a potential. About an axis along the sides of a
rectangle the rings are a rule of n = 2 rings + 1 points over the depth.

Up to nine points the rules are those of least error of the moment of a bed without tension, over all openings down to 3 % of the depth in
contact (``benchmarks/joint_points.py`` has the errors), beyond those of Gauss and Lobatto; three points are corners and centroid alone.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import Legendre

from masonry_cd.foundation.jit import borrower

# Shares r_k of the way, and s_k of the corner's area but for s_1, which follows; by the number of points over the depth.
LEAST_ERROR = {
    3: ((1.0,), ()),
    5: ((1.0, 0.683447), (1.663232,)),
    7: ((1.0, 0.855554, 0.510454), (0.738353, 1.38517)),
    9: ((1.0, 0.912794, 0.703483, 0.388777), (0.441718, 0.81366, 1.116285)),
}
MOST = 15  # points over the depth
OPENING, CLOSED = 0.3, 0.5  # overlap of the corner that is most open over that of the centroid: below, rings; above, corners again
LEAST = 0.05  # share of the area that the centroid keeps
LIGHT = 0.75  # share of the weight of the lighter block that a joint carries for its points to matter; the bed of a block on its own has 1
GRAVITY = 9.81  # by which that weight is found [m/s2]
CRUSHES = -1.0  # stands for it where a joint may crush, whose points are fixed, as each remembers by how much
EVEN = 1e-9  # gaps that differ by less than this share of the smaller part's width are rounding


def rule(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Shares r (rings,) of the way from the centroid to a corner, from 1 inwards, and s (rings,) of the area of that corner."""
    if points in LEAST_ERROR:
        way, inner = (np.array(numbers) for numbers in LEAST_ERROR[points])
        return way, np.array([1.0 - inner @ way[1:] ** 2, *inner])
    legendre = Legendre.basis(points - 1)
    way = np.array([1.0, *np.sort(legendre.deriv().roots())[::-1][: points // 2 - 1]])
    return way, 6.0 / (points * (points - 1) * legendre(way) ** 2)


def resolved_share(points: int) -> float:
    """The share of the depth of a rectangle in contact down to which a rule has two points or more of its depth carry; below, the
    outermost one carries alone, and has the force at the very edge instead of a third of that share inside."""
    way, share = rule(points)
    return float(np.sqrt(share[0] * (1.0 - (way[1] if len(way) > 1 else 0.0)) / 6.0))


def _tables() -> tuple[np.ndarray, np.ndarray]:
    """The rules by their number of rings, from 0: shares of the way, and of the area."""
    rings = MOST // 2
    way, share = np.zeros((2, rings + 1, rings))
    for k in range(1, rings + 1):
        way[k, :k], share[k, :k] = rule(2 * k + 1)
    return way, share


WAY, SHARE = _tables()


@borrower()
def is_spread(spread, rings, light, found, even, manifold):
    """Return True if a joint should have rings, that has them or not (``spread``).

    By the ``found`` points of a manifold, its corners and its centroid, the last. Gaps that differ by up to ``even`` [m] are one; ``light``
    is the overlap times area of a joint that carries so little that they do not matter [m3], CRUSHES of one that has rings all the time.
    """
    if light < 0.0:
        return True
    height, corners = manifold.height, found - 1
    least, most, middle = np.inf, -np.inf, height[corners]
    for i in range(corners):
        least, most = min(least, height[i]), max(most, height[i])
    if least >= 0.0 or most - least <= even or most <= (CLOSED if spread else OPENING) * min(0.0, middle):
        return False
    return spread or (_squeezed(found, manifold) > light and (most <= 0.0 or _gains_nothing(rings, found, manifold)))


@borrower()
def _squeezed(found, manifold):
    """Overlap times area of a joint with corners and centroid [m3], its force over its stiffness."""
    volume = 0.0
    for i in range(found):
        volume -= manifold.area[i] * min(0.0, manifold.height[i])
    return volume


@borrower()
def _gains_nothing(rings, found, manifold):
    """Return True if the springs of a joint store no more energy once rings are in place of its corners."""
    area, height, corners, (part, _) = manifold.area, manifold.height, found - 1, _shares(rings, found, manifold.area)
    middle, gain = height[corners], 0.0
    for i in range(corners):
        for k in range(rings):
            share = SHARE[rings, k] - (1.0 if k == 0 else 0.0)
            gap = middle + WAY[rings, k] * (height[i] - middle)
            gain += part * share * area[i] * (min(0.0, gap) ** 2 - min(0.0, middle) ** 2)
    return gain <= 0.0


@borrower()
def _shares(rings, found, area):
    """How much of the rule a joint takes, the rest being corners alone, and the area that its centroid hands to the rings [m2]."""
    outer, more = 0.0, -1.0
    for i in range(found - 1):
        outer += area[i]
    for k in range(rings):
        more += SHARE[rings, k]
    part = min(1.0, max(0.0, area[found - 1] - LEAST * (area[found - 1] + outer)) / (more * outer))
    return part, part * more * outer


@borrower()
def spread_out(rings, found, manifold):
    """Put rings in place of the corners of a joint, the first ``found`` - 1 points of a manifold; returns how many points there are then.

    The corners stay first, the centroid last.
    """
    area, corners = manifold.area, found - 1
    last, way, share = rings * corners, WAY[rings], SHARE[rings]
    part, handed = _shares(rings, found, area)
    centre = area[corners] - handed
    _copy_point(manifold, corners, last, 1.0, corners, 1.0)
    area[last] = centre
    for i in range(corners):
        for k in range(1, rings):
            _copy_point(manifold, i, k * corners + i, way[k], last, part * share[k])
        area[i] *= 1.0 + part * (share[0] - 1.0)
    return last + 1


@borrower()
def _copy_point(manifold, i, to, way, centre, share):
    """Put a point of a manifold a share of the way from its point ``centre`` to its point i, with a share of the area of that."""
    point, height = manifold.point, manifold.height
    for d in range(3):
        point[to, d] = point[centre, d] + way * (point[i, d] - point[centre, d])
    height[to] = height[centre] + way * (height[i] - height[centre])
    manifold.area[to] = share * manifold.area[i]
