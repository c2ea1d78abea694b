# SPDX-License-Identifier: GPL-3.0-or-later
"""Rubble between the leaves of a wall: spheres dropped one after another into the slot, each where it comes to rest on what lies there.

Masons fill a core as they go up: course by course, before the next through-stones are laid. So does this. A sphere falls at a random place
and rolls down over the others, over the through-stones laid so far and along the leaves until it can sink no farther (Visscher & Bolsterli,
Nature 239, 1972). The height at which the centre of a sphere of radius r rests above a point (x, y) of the plan is

    h(x, y) = max(floor + r,  z_i + sqrt((r + r_i)^2 - d_i^2) of spheres at a distance d_i in plan,  z_s + sqrt(r^2 - e^2) of stones),

e the distance from the side of a stone, and where it rests is a minimum of h, found by going down in ever smaller steps. It touches what
carries it and overlaps nothing; the run then needs a few hundredths of a second for what friction does not hold. Pouring them in the run
instead would take longer than the shaking, and would load the leaves with spheres that fall from above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from structures.layout.loose_grains import Grains, number_shares

TRIES = 4  # places at which a sphere is dropped, of which it keeps the lowest: rubble is thrown where it is low
FULL = 50  # spheres in a row that find no place: the lift is full
TURNS = 32  # directions that are tried
FINEST = 1e-4  # last step of the way down, over the radius
SMALLER = 0.6  # share of the step that the next one has where none goes down
MOVES = 600  # at most
ASIDE, LEVEL = 0.02, 1e-3  # a sphere that sinks by so much at such a distance from its place would roll on, both over its radius
DIRECTIONS = np.array([[math.cos(2.0 * math.pi * k / TURNS), math.sin(2.0 * math.pi * k / TURNS)] for k in range(TURNS)])


class Slot(NamedTuple):
    """The room between two leaves [m]."""

    x0: float
    x1: float
    y0: float
    y1: float
    floor: float
    top: float


class Heap(NamedTuple):
    """Spheres that lie, in lists by where along x they are."""

    centre: np.ndarray  # (N, 3) [m]
    radius: np.ndarray  # (N,) [m]
    first: np.ndarray  # (cells,) the last one put into each cell, -1 for none
    after: np.ndarray  # (N,) the one before it in its cell, -1 for none
    cell: float  # length of a cell, at least the largest diameter [m]


class Dropped(NamedTuple):
    """A sphere, and where it falls."""

    x: float  # [m]
    y: float
    radius: float


def fill(slot: Slot, stones: np.ndarray, beds: Sequence[float], diameters: Sequence[float], shares: Sequence[float], seed: int) -> Grains:
    """Fill a slot with spheres.

    Args:
        slot: clear of leaves.
        stones: (S, 4) x0, x1, z0, z1 of those that reach through it, each within a course [m].
        beds: of the courses, from the floor to the top [m].
        diameters: below the width of the slot [m].
        shares: of the number of spheres thrown, for each of them; large ones find a place less often.
        seed: equal seeds give equal places.
    """
    random = np.random.default_rng(seed)
    weights = number_shares(diameters, shares, False)
    cell = max(diameters)
    most = int((slot.x1 - slot.x0) * (slot.y1 - slot.y0) * (slot.top - slot.floor) / min(diameters) ** 3 * 1.5) + 10
    cells = max(1, math.ceil((slot.x1 - slot.x0) / cell))
    heap = Heap(np.zeros((most, 3)), np.zeros(most), np.full(cells, -1), np.full(most, -1), cell)
    sizes: list[int] = []
    for low, high in pairwise(beds):
        course = 0.5 * (low + high)
        laid, to_come = stones[stones[:, 2] < course], stones[stones[:, 2] >= course]
        missed = 0
        while missed < FULL and len(sizes) < most:
            size = int(random.choice(len(diameters), p=weights))
            radius = 0.5 * diameters[size]
            starts = random.random((TRIES, 2)) * [slot.x1 - slot.x0, slot.y1 - slot.y0] + [slot.x0, slot.y0]
            found = [drop(Dropped(x, y, radius), heap, slot, laid, DIRECTIONS) for x, y in starts.tolist()]
            free = [p for p in found if not p[3] and p[2] <= min(high, slot.top - radius) and not _is_within(p, radius, to_come)]
            if not free:
                missed += 1
                continue
            place = min(free, key=lambda p: p[2])
            _lay(heap, len(sizes), place, radius, slot)
            sizes.append(size)
            missed = 0
    return Grains(heap.centre[: len(sizes)].copy(), np.array(sizes, dtype=int))


def _is_within(place: tuple[float, float, float, bool], radius: float, stones: np.ndarray) -> bool:
    """Return True if a sphere is in the way of stones (S, 4) that are laid later."""
    x, _, z, _ = place
    aside = np.maximum(np.maximum(stones[:, 0] - x, x - stones[:, 1]), 0.0)
    below = np.maximum(np.maximum(stones[:, 2] - z, z - stones[:, 3]), 0.0)
    return bool((np.hypot(aside, below) < radius).any())


def _lay(heap: Heap, i: int, place: tuple[float, float, float, bool], radius: float, slot: Slot) -> None:
    """Put sphere i where it came to rest."""
    cell = min(max(int((place[0] - slot.x0) / heap.cell), 0), len(heap.first) - 1)
    heap.centre[i], heap.radius[i] = place[:3], radius
    heap.after[i], heap.first[cell] = heap.first[cell], i


@entry()
def drop(ball: Dropped, heap: Heap, slot: Slot, stones: np.ndarray, directions: np.ndarray) -> tuple[float, float, float, bool]:
    """Where a sphere comes to rest, its centre [m]; and whether it would roll on from there under one that overhangs.

    Args:
        stones: (S, 4) x0, x1, z0, z1 of those laid so far [m].
        directions: (n, 2) unit vectors that are tried.
    """
    r = ball.radius
    x_low, x_high, y_low, y_high = slot.x0 + r, slot.x1 - r, slot.y0 + r, slot.y1 - r
    x, y = min(max(ball.x, x_low), x_high), min(max(ball.y, y_low), y_high)
    z = _rest_height(x, y, r, np.inf, heap, slot, stones)
    step, moves = r, 0
    while step > FINEST * r and moves < MOVES:
        best, best_x, best_y = z, x, y
        for k in range(directions.shape[0]):
            px = min(max(x + step * directions[k, 0], x_low), x_high)
            py = min(max(y + step * directions[k, 1], y_low), y_high)
            height = _rest_height(px, py, r, np.inf, heap, slot, stones)
            if height < best:
                best, best_x, best_y = height, px, py
        moves += 1
        if best < z:
            x, y, z = best_x, best_y, best
        else:
            step *= SMALLER
    rolls = False
    for k in range(directions.shape[0]):
        px = min(max(x + ASIDE * r * directions[k, 0], x_low), x_high)
        py = min(max(y + ASIDE * r * directions[k, 1], y_low), y_high)
        rolls = rolls or _rest_height(px, py, r, z, heap, slot, stones) < z - LEVEL * r
    return x, y, z, rolls


@kernel()
def _rest_height(x, y, r, ceiling, heap, slot, stones):
    """Height at which the centre of a sphere of radius r rests above a point of the plan, on what begins below a ceiling [m]."""
    height = slot.floor + r
    for s in range(stones.shape[0]):
        aside = max(stones[s, 0] - x, x - stones[s, 1], 0.0)
        if aside < r and stones[s, 2] < ceiling:
            height = max(height, stones[s, 3] + np.sqrt(r * r - aside * aside))
    cells = heap.first.shape[0]
    own = min(max(int((x - slot.x0) / heap.cell), 0), cells - 1)
    for cell in range(max(own - 1, 0), min(own + 2, cells)):
        i = heap.first[cell]
        while i >= 0:
            apart = r + heap.radius[i]
            dx, dy = x - heap.centre[i, 0], y - heap.centre[i, 1]
            square = apart * apart - dx * dx - dy * dy
            if square > 0.0 and heap.centre[i, 2] < ceiling:
                height = max(height, heap.centre[i, 2] + np.sqrt(square))
            i = heap.after[i]
    return height
