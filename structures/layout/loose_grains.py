# SPDX-License-Identifier: GPL-3.0-or-later
"""Spheres on a loose lattice, to be poured by gravity: none touches another, and the seed decides which lies where.

The plan of the container is divided into square cells, a little wider than the largest sphere, layer on layer of them. A cell takes as many
spheres of one size as fit into it, side by side and on one another, so that small ones are not lifted higher than large ones. The cells are
dealt out in a random order, and each sphere lies anywhere in its part of the cell.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

LOOSE = 0.05  # by which cells are wider than the spheres in them, at least
SOLID = 0.6  # share of the volume that poured spheres fill: 0.55 loose, 0.64 shaken; of several sizes more


class ContainerPlan(NamedTuple):
    """The inside of a container in plan: a rectangle about the origin, or the circle within a square."""

    length: float  # along x [m]
    width: float  # along y [m]
    round: bool = False

    @property
    def area(self) -> float:
        """[m2]."""
        return self.length * self.width * (0.25 * math.pi if self.round else 1.0)

    @property
    def clear(self) -> float:
        """Diameter of the largest sphere that a cell takes [m]."""
        return self.length / math.sqrt(2.0) if self.round else min(self.length, self.width)


class Grains(NamedTuple):
    """N spheres."""

    centre: np.ndarray  # (N, 3) [m]
    size: np.ndarray  # (N,) index of its diameter


def numbers_of(count: int, diameters: Sequence[float], shares: Sequence[float], by_volume: bool) -> list[int]:
    """How many of ``count`` spheres each diameter gets, by its share of their number or of their volume; they add up to ``count``."""
    weights = number_shares(diameters, shares, by_volume) * count
    out = np.floor(weights).astype(int)
    for k in np.argsort(out - weights, kind="stable")[: count - int(out.sum())].tolist():
        out[k] += 1
    return [int(n) for n in out]


def number_shares(diameters: Sequence[float], shares: Sequence[float], by_volume: bool) -> np.ndarray:
    """Shares of the number, that add up to one."""
    weights = np.array(shares, dtype=float) / (np.array(diameters) ** 3 if by_volume else 1.0)
    return np.asarray(weights / weights.sum())


def count_for(fill: float, plan: ContainerPlan, diameters: Sequence[float], shares: Sequence[float], by_volume: bool) -> float:
    """Number of spheres that fill a container to a height [m] once they have settled, at the solid fraction SOLID."""
    mean = float(number_shares(diameters, shares, by_volume) @ np.array(diameters) ** 3) * math.pi / 6.0
    return SOLID * plan.area * fill / mean if mean > 0.0 else math.inf  # a volume may underflow


def loose(plan: ContainerPlan, diameters: Sequence[float], numbers: Sequence[int], seed: int) -> Grains:
    """Lay a given number of spheres of each diameter into layers of cells from z = 0 upwards.

    Args:
        plan: takes a cell of the largest diameter at least.
        diameters: [m].
        numbers: of each.
        seed: the same one lays them in the same places.
    """
    cells, side = _cells(plan, (1.0 + LOOSE) * max(diameters))
    random = np.random.default_rng(seed)
    parts = [[max(1, math.floor(edge / ((1.0 + LOOSE) * d))) for edge in side] for d in diameters]
    needed = [math.ceil(n / math.prod(part)) for n, part in zip(numbers, parts, strict=True)]
    order = random.permutation(np.repeat(np.arange(len(diameters)), needed))
    left, centres, sizes = list(numbers), [], []
    for k, size in enumerate(order.tolist()):
        level, place = divmod(k, len(cells))
        corner = np.array([*cells[place], level * side[2]])
        split, diameter = np.array(parts[size]), diameters[size]
        spots = np.argwhere(np.ones(split))[: left[size]]
        left[size] -= len(spots)
        part = np.array(side) / split
        free = part - diameter
        centres.append(corner + (spots + 0.5) * part + (random.random((len(spots), 3)) - 0.5) * free)
        sizes += [size] * len(spots)
    return Grains(np.concatenate(centres), np.array(sizes))


def _cells(plan: ContainerPlan, least: float) -> tuple[np.ndarray, tuple[float, float, float]]:
    """Low corners of the cells of a layer (n, 2), and the measures of a cell, which are at least ``least`` where there is room [m]."""
    number = [max(1, math.floor(edge / least)) for edge in (plan.length, plan.width)]
    side = (plan.length / number[0], plan.width / number[1])
    x, y = (np.arange(n) * edge - 0.5 * n * edge for n, edge in zip(number, side, strict=True))
    corners = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    if plan.round:
        far = np.linalg.norm(np.abs(corners + 0.5 * np.array(side)) + 0.5 * np.array(side), axis=1)
        corners = corners[far <= 0.5 * plan.length]
    if not len(corners):  # of a round plan: those of the square within it, of which one at least takes a sphere
        edge = plan.length / math.sqrt(2.0)
        return _cells(ContainerPlan(edge, edge), least)
    return corners, (*side, least)
