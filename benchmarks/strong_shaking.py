# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures in space that are shaken hard, ten of them, each giving way in a way of its own, and one at rest that was built with gaps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import structures
from benchmarks.noise import noisy
from benchmarks.scenes import DENSITY, GRAVITY, BenchScene, cuboid
from masonry_cd.mechanics.model.blocks import Block

TOWER = {
    "kind": "tower", "side": 3.0, "height": 7.0, "thickness": 0.6, "course_height": 0.7, "belfry_width": 0.6, "belfry_height": 1.4,
    "door_width": 0.0,
}  # fmt: skip
CHURCH = {
    "kind": "church", "block_length": 1.6, "course_height": 0.75, "length": 7.0, "width": 4.8, "height": 6.0, "thickness": 0.9,
    "gable": 1.5, "windows": 1, "window_width": 0.8, "window_height": 1.5, "door_width": 1.2, "door_height": 2.0,
    "apse": False, "tower": False,
}  # fmt: skip
DOOR = {"centre": -0.75, "width": 0.8, "height": 1.25}
WINDOW = {"centre": 0.75, "width": 0.75, "sill": 0.75, "height": 0.5}


@dataclass(frozen=True)
class Shaking:
    """A sine of the base: peak acceleration [g], frequency [Hz], direction of any length, and for how long [s]."""

    acceleration: float
    frequency: float
    direction: tuple[float, float, float]
    seconds: float
    dt: float = 4e-3  # [s]


def strong_cases() -> Iterator[tuple[str, BenchScene, int]]:
    """Name, scene and number of steps of each."""
    wall = {"kind": "wall", "length": 3.0, "height": 2.0, "thickness": 0.4}
    aqueduct = {"kind": "aqueduct", "spans": 1, "pier_courses": 6}
    yield _case("wall across its plane, 1 g", wall, Shaking(1.0, 2.0, (0, 1, 0), 1.0))
    yield _case("wall with door and window, 1 g", wall | {"openings": [DOOR, WINDOW]}, Shaking(1.0, 3.0, (1, 1, 0), 1.0))
    yield _case("wall of two leaves, 1e+10 N/m3, 1 g", wall | {"leaves": 2}, Shaking(1.0, 4.0, (0.3, 1, 0), 0.6), stiffness=1e10)
    yield _case("tower with belfry, 0.7 g", TOWER, Shaking(0.7, 2.0, (1, 0.6, 0), 1.0))
    yield _case("church, 0.7 g", CHURCH, Shaking(0.7, 2.0, (1, 0.7, 0.4), 0.6))
    yield _case("dome on a drum, 1 g", {"kind": "dome", "span": 4.0, "sides": 8, "drum_height": 1.2}, Shaking(1.0, 3.0, (1, 0.5, 0), 0.8))
    vault = noisy(built({"kind": "vault", "form": "cross", "voussoirs": 7}), 1e-6)
    yield _case("cross vault, noise of 1e-6 m, 2 g", vault, Shaking(2.0, 4.0, (1, 0.4, 0), 0.6))
    yield _case("colonnade of drums, 1 g", colonnade(3), Shaking(1.0, 1.5, (0.7, 1, 0), 1.2, 1e-3))
    yield _case("aqueduct across, noise of 1e-6 m, 0.5 g", noisy(built(aqueduct), 1e-6), Shaking(0.5, 1.5, (0, 1, 0), 0.8))
    buttressed = {"kind": "arch", "span": 4.0, "thickness": 0.45, "voussoirs": 15, "buttress_width": 1.0, "buttress_height": 2.0}
    yield _case("arch on buttresses, also upwards, 1.5 g", buttressed, Shaking(1.5, 3.0, (1, 0.3, 0.8), 0.8))


def rest_cases() -> Iterator[tuple[str, BenchScene, int]]:
    """Name, scene and number of steps of an aqueduct of 320 blocks whose vertices are off by a micrometre, in its plane and in space."""
    table = {"kind": "aqueduct", "spans": 5, "clear_span": 4.0, "pier_width": 2.2, "pier_courses": 10, "ring_thickness": 0.6, "width": 1.6}
    for where, axes in (("a plane", "xz"), ("space", "xyz")):
        for dt in (1e-4, 1e-2):
            name = f"aqueduct of 5 spans in {where}, dt {dt:g} s"
            yield _case(name, noisy(built(table), 1e-6, axes), Shaking(0.0, 1.0, (1, 0, 0), 200 * dt, dt))


def built(keys: Mapping[str, Any]) -> list[Block]:
    """The blocks of a structure."""
    return structures.build(keys, DENSITY, Path())


def colonnade(columns: int) -> list[Block]:
    """Columns of drums in a row along x, and lintels from each to the next [m]."""
    pitch, height = 2.5, 4.0
    one = built({"kind": "column", "height": height, "diameter": 0.8, "drums": 4, "sides": 8})
    out = [
        replace(block, name=f"{k}.{block.name}", vertices=block.vertices + np.array([k * pitch, 0.0, 0.0]))
        for k in range(columns)
        for block in one
    ]
    half = 0.3
    ends = [-0.4, *(pitch * (k + 1) for k in range(columns - 2)), (columns - 1) * pitch + 0.4]
    return out + [cuboid(f"lintel{k}", (ends[k], -half, height), (ends[k + 1], half, height + 0.5)) for k in range(columns - 1)]


def _case(name: str, made: Mapping[str, Any] | list[Block], shaking: Shaking, stiffness: float = 0.0) -> tuple[str, BenchScene, int]:
    """A case from the keys of a structure, or from its blocks."""
    blocks = made if isinstance(made, list) else built(made)
    steps, direction = round(shaking.seconds / shaking.dt), np.array(shaking.direction, dtype=float)
    x, y, z = (direction / np.linalg.norm(direction)).tolist()
    scene = BenchScene(
        name, tuple(blocks), steps, dt=shaking.dt, amplitude=shaking.acceleration * GRAVITY / (2.0 * np.pi * shaking.frequency),
        frequency=shaking.frequency, stiffness=stiffness, direction=(x, y, z),
    )  # fmt: skip
    return name, scene, steps
