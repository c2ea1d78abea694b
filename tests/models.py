# SPDX-License-Identifier: GPL-3.0-or-later
"""Small assemblies and steppers for the tests: boxes placed by hand, towers, walls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.state import State, rotation_matrices

GRAVITY = 9.81
BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def box(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float], fixed: bool = False, density: float = 2000.0
) -> Block:
    """An axis-parallel box between two corners [m]; a fixed one belongs to the group ``base``."""
    corners = np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    return Block(name, corners, BOX_FACES, density, "base" if fixed else "block", fixed)


def ground(size: float = 10.0) -> Block:
    """A fixed plate whose top is z = 0."""
    return box("ground", (-size, -size, -0.5), (size, size, 0.0), fixed=True)


def tower(count: int, side: float = 0.5, height: float = 0.25, density: float = 2000.0) -> list[Block]:
    """Cuboids on top of each other, on the ground."""
    half = side / 2
    return [ground(2.0)] + [box(f"b{k}", (-half, -half, k * height), (half, half, (k + 1) * height), density=density) for k in range(count)]


def wall(columns: int, courses: int, length: float = 0.4, height: float = 0.2, width: float = 0.2, running: bool = True) -> list[Block]:
    """A running bond: odd courses start and end with half units; or straight joints from bottom to top."""
    blocks = [ground(1.0 + columns * length)]
    for course in range(courses):
        inner = (np.arange(columns) + 0.5) * length
        edges = np.arange(columns + 1) * length if course % 2 == 0 or not running else np.concatenate([[0.0], inner, [columns * length]])
        for k, (x0, x1) in enumerate(pairwise(edges)):
            low, high = (x0, -width / 2, course * height), (x1, width / 2, (course + 1) * height)
            blocks.append(box(f"c{course}.{k}", low, high))
    return blocks


def still(steps: int) -> np.ndarray:
    """Supports that do not move, (N + 1, 1, 3)."""
    return np.zeros((steps + 1, 1, 3))


def gravity(steps: int, vector: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)) -> np.ndarray:
    """Constant body acceleration, (N + 1, 3)."""
    return np.tile(vector, (steps + 1, 1)).astype(float)


def material_of(
    friction: float | dict[str, float],
    joints: Mapping[str, JointLaw] | None = None,
    elastic: ElasticBlocks | None = None,
    rolling: float = 0.0,
    **keys: Any,
) -> Material:
    """A material with laws by pair of groups, blocks that deform, spheres that roll with friction, and other keys."""
    keys |= {} if elastic is None else elastic.model_dump(exclude_unset=True)
    return Material(friction=friction, joints=dict(joints or {}), rolling_friction=rolling, **keys)


def stepper(
    blocks: list[Block],
    steps: int,
    *,
    friction: float = 0.6,
    support_velocity: np.ndarray | None = None,
    acceleration: np.ndarray | None = None,
    start: State | None = None,
    joints: Mapping[str, JointLaw] | None = None,
    material: ElasticBlocks | None = None,
    rolling: float = 0.0,
    room: int = 0,
    **settings: object,
) -> Stepper:
    """A stepper for a number of steps; ``joints`` are laws by pair of groups, ``settings`` keys of the table [run].

    ``material`` says which blocks deform, ``rolling`` is the rolling friction of spheres, ``room`` how many unknowns meshed blocks have at
    the least: kernels are compiled for the number.
    """
    run = Run.model_validate({"dt": 1e-3, "duration": 1e3, "solver": "nlgs", "tolerance": 1e-10} | settings)
    velocity = still(steps) if support_velocity is None else support_velocity
    pull = gravity(steps) if acceleration is None else acceleration
    assembly = Assembly.from_blocks(blocks, material_of(friction, joints, material, rolling))
    if assembly.deformation is not None:
        assembly = replace(assembly, deformation=replace(assembly.deformation, room=room))
    return Stepper(assembly, velocity, pull, run, start)


def advance(machine: Stepper, steps: int) -> None:
    """Make some steps."""
    for _ in range(steps):
        machine.step()


def turned(assembly: Assembly, block: int, axis: tuple[float, float, float], angle: float, pivot: tuple[float, float, float]) -> State:
    """The assembly at rest but for one block, turned by an angle [rad] about an axis through a pivot [m]."""
    state = State.at_rest(assembly)
    state.orientation[block] = [np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis))]
    rotation = rotation_matrices(state.orientation)[block]
    state.position[block] = pivot + rotation @ (assembly.centre[block] - pivot)
    return state
