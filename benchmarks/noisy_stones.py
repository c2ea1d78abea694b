# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones as scans and exports of low precision give them: how many are taken as their corners are moved at random.

    python -m benchmarks.noisy_stones 1000

Convex stones are boxes cut by up to five planes; the others are L, U and voussoirs with a step. Each is turned at random, given by polygons
or by triangles, near the origin or 10 km away, and each of its corners is moved along x, y and z by up to a share of its size. "As it was"
counts those whose faces are as many as before the noise at most; the others have some of them in pieces.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, mass_properties, triangles
from structures.files.blockfile import sound
from structures.geometry.convex import halves, size_of, split
from structures.geometry.flatten import flattened
from structures.geometry.prism import box

NOISES = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
AWAY = np.array([7e3, 6e3, 3.9e3])  # [m]


def cut_box(rng: np.random.Generator) -> Block:
    """A box of 1 x 0.6 x 0.4 m without some of its corners and edges."""
    vertices, faces = box((-0.5, -0.3, -0.2), (0.5, 0.3, 0.2))
    block = Block("stone", np.asarray(vertices, dtype=float), faces, 2000.0)
    for _ in range(rng.integers(1, 6)):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        heights = np.sum(block.vertices * normal, axis=1)
        block = halves(block, normal, float(heights.min() + np.ptp(heights) * rng.uniform(0.6, 0.9)))[0] or block
    return block


def stepped(rng: np.random.Generator) -> Block:
    """A prism that is not convex: an L, a U, or a voussoir with a step."""
    a, b = rng.uniform(0.2, 0.4, 2)
    outline = (
        [(0, 0), (1, 0), (1, a), (b, a), (b, 0.8), (0, 0.8)],
        [(0, 0), (1, 0), (1, 0.8), (1 - a / 2, 0.8), (1 - a / 2, b), (a / 2, b), (a / 2, 0.8), (0, 0.8)],
        [(0, 0), (1, 0.05), (0.95, 0.5), (0.7, 0.5), (0.7, 0.5 + a / 2), (0.05, 0.5)],
    )[rng.integers(3)]
    n = len(outline)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    corners = np.array([(*point, z) for z in (0.0, 0.4) for point in outline])
    return Block("stone", corners, (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides), 2000.0)


def noisy(block: Block, faces: Faces, noise: float, away: bool, rng: np.random.Generator) -> Block:
    """A stone turned, moved, and with noise on its corners."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    corners = np.einsum("ij,vj->vi", turn, block.vertices)
    return replace(
        block, vertices=corners + noise * size_of(block) * rng.uniform(-1, 1, corners.shape) + away * AWAY, faces=faces, parts=()
    )


def row(make: Callable[[np.random.Generator], Block], in_triangles: bool, noise: float, away: bool, count: int) -> str:
    """A row of the table."""
    rng, refused, same, furthest, lost, slowest = np.random.default_rng(1), 0, 0, 0.0, 0.0, 0.0
    for _ in range(count):
        stone = make(rng)
        faces = tuple(map(tuple, triangles(split(stone).faces).tolist())) if in_triangles else stone.faces
        given, begin = noisy(stone, faces, noise, away, rng), time.process_time()
        try:
            (flat,), far, _ = flattened([given], None)
            (taken,) = sound([flat], "stone")
        except InputError:
            refused += 1
            continue
        finally:
            slowest = max(slowest, time.process_time() - begin)
        volume = mass_properties(stone.vertices, stone.faces).volume
        furthest = max(furthest, far / size_of(stone))
        lost = max(lost, abs(mass_properties(taken.vertices, taken.faces).volume / volume - 1.0))
        same += len(taken.faces) <= len(split(stone).faces)
    kind = f"{'convex' if make is cut_box else 'not convex'}, {'triangles' if in_triangles else 'polygons'}"
    figures = f"{count - refused} | {same} | {furthest:.1e} | {lost:.1e} | {slowest:.2f}"
    return f"| {kind} | {noise:g} | {'10 km' if away else '0'} | {figures} |"


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    print("| stones | noise over size | from the origin | taken | as it was | corners moved, over size | volume changed by | slowest [s] |")
    print("|---|---|---|---|---|---|---|---|")
    for make, in_triangles, noise, away in product((cut_box, stepped), (False, True), NOISES, (False, True)):
        print(row(make, in_triangles, noise, away, count), flush=True)


if __name__ == "__main__":
    main()
