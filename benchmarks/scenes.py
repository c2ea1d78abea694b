# SPDX-License-Identifier: GPL-3.0-or-later
r"""Scenes of the benchmarks: towers, walls in running bond, arcades and arches on a base that shakes along x.

The base moves with v(t) = C sin(2 pi f t), so that nothing jumps at the start. Every scene is a few numbers: both programs
build it from the same vertices, ours directly and the peers from the JSON file that :meth:`BenchScene.write` makes.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import Faces
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from structures.geometry.prism import box, prism_xz
from structures.kinds import church as churches

GRAVITY = 9.81  # [m/s2]
DENSITY = 2000.0  # [kg/m3]


@dataclass(frozen=True, eq=False)
class BenchScene:
    """Blocks, friction and a shaken base."""

    name: str
    blocks: tuple[Block, ...]
    steps: int  # of a comparison, where the command line names no other number
    friction: float = 0.6
    dt: float = 1e-3  # [s]
    theta: float = 0.5
    amplitude: float = 0.0  # C [m/s]
    frequency: float = 2.0  # f [Hz]
    stiffness: float = 0.0  # of all joints, normal; 0: rigid [N/m3]
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)  # along which the base moves, of unit length
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)  # held on the last block, at its centre [N]

    def base_velocity(self, steps: int) -> np.ndarray:
        """Velocity of the base along its direction at t_k = k dt, (N + 1,) [m/s]."""
        return self.amplitude * np.sin(2.0 * np.pi * self.frequency * self.dt * np.arange(steps + 1))

    def assembly(self) -> Assembly:
        """The blocks as the core takes them."""
        joints = {"default": JointLaw(normal_stiffness=self.stiffness)} if self.stiffness else {}
        return Assembly.from_blocks(self.blocks, Material(friction=self.friction, joints=joints))

    def write(self, path: Path, steps: int) -> None:
        """Write the scene for a peer: blocks, friction, time step and the base velocity of its steps.

        Raises:
            ValueError: the base does not move along x, as peers move it.
        """
        if self.direction != (1.0, 0.0, 0.0):
            raise ValueError(f"{self.name}: peers move the base along x only")
        blocks = [
            {"vertices": b.vertices.tolist(), "faces": [list(f) for f in b.faces], "density": b.density, "fixed": b.fixed}
            for b in self.blocks
        ]
        scene = {"blocks": blocks, "friction": self.friction, "dt": self.dt, "theta": self.theta, "steps": steps}
        path.write_text(json.dumps(scene | {"base_velocity": self.base_velocity(steps + 2).tolist()}), encoding="utf-8")


def cuboid(name: str, low: tuple[float, float, float], high: tuple[float, float, float], fixed: bool = False) -> Block:
    """An axis-parallel cuboid between two corners [m]."""
    vertices, faces = box(low, high)
    return _block(name, vertices, faces, fixed)


def _block(name: str, vertices: np.ndarray, faces: Faces, fixed: bool = False) -> Block:
    return Block(name, vertices, faces, DENSITY, "base" if fixed else "block", fixed)


def ground(x0: float, x1: float, half_width: float) -> Block:
    """A fixed plate whose top is z = 0 [m]."""
    return cuboid("ground", (x0, -half_width, -0.5), (x1, half_width, 0.0), fixed=True)


def block(amplitude: float = 0.25) -> BenchScene:
    """A slender block that rocks on the ground [m]: the least that a step can cost."""
    return BenchScene("block", (ground(-2.0, 2.0, 0.5), cuboid("block", (-0.1, -0.2, 0.0), (0.1, 0.2, 0.8))), 2000, amplitude=amplitude)


def tower(count: int, amplitude: float = 0.1, side: float = 0.5, height: float = 0.25) -> BenchScene:
    """Cuboids on top of each other [m]."""
    half = side / 2
    blocks = [cuboid(f"b{k}", (-half, -half, k * height), (half, half, (k + 1) * height)) for k in range(count)]
    name = f"tower {count}" if amplitude else f"tower {count}, at rest"
    return BenchScene(name, (ground(-2 * side, 2 * side, 2 * side), *blocks), steps=200, amplitude=amplitude)


def wall(columns: int, courses: int, amplitude: float = 0.2, length: float = 0.4, height: float = 0.2, width: float = 0.2) -> BenchScene:
    """Running bond, one block thick; every second course begins and ends with half a block [m]."""
    end, half = columns * length, width / 2
    blocks = []
    for course in range(courses):
        inner = (np.arange(columns) + 0.5) * length
        edges = np.arange(columns + 1) * length if course % 2 == 0 else np.concatenate([[0.0], inner, [end]])
        low, high = course * height, (course + 1) * height
        blocks += [cuboid(f"c{course}.{k}", (x0, -half, low), (x1, half, high)) for k, (x0, x1) in enumerate(pairwise(edges))]
    steps = 200 if len(blocks) < 500 else 40
    return BenchScene(f"wall {columns} x {courses}", (ground(-length, end + length, 3 * width), *blocks), steps, amplitude=amplitude)


def _ring(name: str, count: int, radius: float, thickness: float, width: float, x: float, z: float) -> list[Block]:
    """A semicircle of straight-edged voussoirs around (x, z), from the right springing to the left [m]."""
    angle = np.linspace(0.0, np.pi, count + 1)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner, outer = (np.array([x, z]) + r * ray for r in (radius - thickness / 2, radius + thickness / 2))
    quads = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(count)]
    return [_block(f"{name}{k}", *prism_xz(quad, -width / 2, width / 2)) for k, quad in enumerate(quads)]


def arch(voussoirs: int = 27, ratio: float = 0.15, amplitude: float = 0.1, radius: float = 5.0, width: float = 1.0) -> BenchScene:
    """A semicircular arch of thickness ``ratio`` times its mean radius [m], its springings on the ground."""
    ring = _ring("v", voussoirs, radius, ratio * radius, width, 0.0, 0.0)
    blocks = (ground(-2 * radius, 2 * radius, width), *ring)
    return BenchScene(f"arch {voussoirs}", blocks, steps=300, friction=1.0, amplitude=amplitude)


def arcade(spans: int, amplitude: float = 0.1, voussoirs: int = 12, courses: int = 8) -> BenchScene:
    """Semicircular arches of mean radius 2 m and thickness 0.5 m on piers of single blocks 1.5 x 1.5 x 0.5 m."""
    radius, thickness, pier, height = 2.0, 0.5, 1.5, 0.5
    pitch, half = 2 * radius - thickness + pier, pier / 2
    blocks = [ground(-pier - 1.0, spans * pitch + pier + 1.0, pier)]
    for k in range(spans + 1):
        x = k * pitch
        blocks += [cuboid(f"p{k}.{j}", (x - half, -half, j * height), (x + half, half, (j + 1) * height)) for j in range(courses)]
    for k in range(spans):
        blocks += _ring(f"a{k}.", voussoirs, radius, thickness, pier, (k + 0.5) * pitch, courses * height)
    return BenchScene(f"arcade {spans}", tuple(blocks), steps=200 if spans < 100 else 20, amplitude=amplitude)


def church(block_length: float, amplitude: float = 0.2) -> BenchScene:
    """The church of ``structures.kinds.church`` with blocks of that length [m]: a building in space."""
    blocks = churches.build({"block_length": block_length}, DENSITY, Path())
    return BenchScene(f"church {block_length:g} m", tuple(blocks), steps=20, amplitude=amplitude)


SCENES = {
    "block": block,
    "arch27": lambda: arch(27),
    "tower50": lambda: tower(50),
    "tower50-rest": lambda: tower(50, amplitude=0.0),
    "wall10x10": lambda: wall(10, 10),
    "wall40x25": lambda: wall(40, 25),
    "arcade3": lambda: arcade(3),
    "arcade50": lambda: arcade(50),
    "arcade250": lambda: arcade(250),
}


def scene(name: str, dt: float | None = None) -> BenchScene:
    """A scene by its name in :data:`SCENES`, or ``towerN``, ``wallNxM``, ``arcadeN``, ``archN`` of any size, ``churchN`` (N in mm).

    Raises:
        ValueError: no such scene.
    """
    made = SCENES[name]() if name in SCENES else _sized(name)
    return made if dt is None else replace(made, dt=dt)


def _sized(name: str) -> BenchScene:
    word = name.rstrip("0123456789x")
    numbers = [int(part) for part in name[len(word) :].split("x") if part]
    makers: dict[str, tuple[Callable[..., BenchScene], int]] = {
        "tower": (tower, 1),
        "wall": (wall, 2),
        "arcade": (arcade, 1),
        "arch": (arch, 1),
        "church": (lambda millimetres: church(1e-3 * millimetres), 1),
    }
    if word not in makers or len(numbers) != makers[word][1]:
        raise ValueError(
            f'no scene "{name}"; known: {", ".join(SCENES)}, or towerN, wallNxM, arcadeN, archN of any size N, churchN of blocks N mm long'
        )
    return makers[word][0](*numbers)
