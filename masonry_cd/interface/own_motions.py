# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that Python gives to blocks, which become supports, on top of what the scene's loads do to all supports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from loads.motion import LoadAction, RunGrid, Turning
from loads.turning import Turned, by_rotation, by_velocity
from loads.value_history import ValueHistory, at_middles
from masonry_cd.app.case import BuiltStructure, assembled, structure_of
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.own_forces import WRENCH, ForceHistory, block_named
from masonry_cd.interface.values import numbers
from masonry_cd.mechanics.model.blocks import Block


@dataclass(frozen=True, eq=False)
class Motion:
    """How a block is driven, for ``motions`` of a :class:`masonry_cd.Simulation`.

    Attributes:
        history: a function of time [s], or times (N,) and values (N, 3 or 6), in the world axes. Of a velocity: linear [m/s], and angular
            [rad/s]; straight between its times. Of a displacement: [m], and axis times angle [rad]; smooth between its times, counted from
            the first, and at rest before and after.
        about: the point as built that the linear part is of, and about which the block turns (3,) [m]; its centre of mass when not given.
        of: "velocity" or "displacement".
    """

    history: Any
    about: Sequence[float] | None = None
    of: Literal["velocity", "displacement"] = "velocity"


def driven(scene: Scene, motions: Mapping[str, Any]) -> tuple[BuiltStructure, list[LoadAction]]:
    """The structure of a scene with some blocks as supports, and what each of these adds to the loads.

    Args:
        scene: of the run.
        motions: by block, its velocity over time, (3,) [m/s] or (6,) with the angular one [rad/s]; or a :class:`Motion`.

    Raises:
        InputError: an unknown block, or no history.
    """
    built = structure_of(scene)
    names = [block.name for block in built.blocks]
    driven = [block_named(name, names, "motions") for name in motions]
    blocks = [replace(block, fixed=block.fixed or i in driven) for i, block in enumerate(built.blocks)]
    parts = [
        _part(given if isinstance(given, Motion) else Motion(given), number, blocks, scene.run.dt)
        for given, number in zip(motions.values(), driven, strict=True)
    ]
    return replace(assembled(scene, blocks, built.notes, built.bars), fills=built.fills), parts


def _part(motion: Motion, block: int, blocks: list[Block], dt: float) -> LoadAction:
    """The part of the loads that drives one block.

    Raises:
        InputError: no history, or a kind of motion that there is not.
    """
    where, share = f'motions["{blocks[block].name}"]', np.zeros(len(blocks))
    share[block] = 1.0
    if motion.of not in ("velocity", "displacement"):
        raise InputError(where, f'of = "{motion.of}": "velocity" and "displacement" there are')
    history = ForceHistory(motion.history, (3, WRENCH), where)
    about = None if motion.about is None else numbers(motion.about, f"{where}.about", (3,))
    course = None
    if motion.of == "displacement" and not callable(motion.history):
        course = ValueHistory(*(numbers(each, where) for each in motion.history))
        course.check_steps(dt, where)

    def values(times: np.ndarray) -> np.ndarray:
        return np.array([history.at(float(t)) for t in times]) if course is None else course.at(times)

    def linear(times: np.ndarray) -> np.ndarray:
        if motion.of == "velocity":
            return values(times)[:, :3]
        return np.asarray(np.diff(at_middles(values, times, dt)[:, :3], axis=0) / dt)

    def turned(grid: RunGrid) -> Turned:
        if motion.of == "velocity":
            return by_velocity(values(grid.times)[:, 3:], dt, where)
        return by_rotation(at_middles(values, grid.times, dt)[:, 3:], dt, where)

    turns = values(np.zeros(1)).shape[1] == WRENCH
    return LoadAction(
        motion=linear,
        share=share,
        turning=Turning(turned, about) if turns else None,
        summary={"kind": "python", "block": blocks[block].name},
        acted=history.acted("path") if course is None else course.acted(where),
    )
