# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that Python imposes on blocks: these become supports, driven on top of what moves all supports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from loads.motion import Part
from masonry_cd.app.case import Structure, assembled, structure_of
from masonry_cd.app.scene import Scene
from masonry_cd.interface.own_forces import History, block_named
from masonry_cd.mechanics.model.blocks import Block


def driven(scene: Scene, motions: Mapping[str, Any]) -> tuple[Structure, list[Part]]:
    """The structure of a scene with some blocks as supports, and what each of these adds to the loads.

    Args:
        scene: of the run.
        motions: by block, its velocity over time, (3,) [m/s]; see :class:`History`.

    Raises:
        InputError: an unknown block, or no history.
    """
    built = structure_of(scene)
    names = [block.name for block in built.blocks]
    numbers = [block_named(name, names, "motions") for name in motions]
    histories = [History(given, (3,), f'motions["{name}"]') for name, given in motions.items()]
    blocks = [replace(block, fixed=block.fixed or i in numbers) for i, block in enumerate(built.blocks)]
    made = replace(assembled(scene, blocks, built.notes, built.bars), fills=built.fills)
    return made, [_part(history, number, blocks) for history, number in zip(histories, numbers, strict=True)]


def _part(history: History, block: int, blocks: list[Block]) -> Part:
    """What drives one block."""
    share = np.zeros(len(blocks))
    share[block] = 1.0
    return Part(
        motion=lambda times: np.array([history.at(float(t)) for t in times]),
        share=share,
        summary={"kind": "python", "block": blocks[block].name},
        acted=history.acted("path"),
    )
