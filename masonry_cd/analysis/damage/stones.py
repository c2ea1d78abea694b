# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones that crack: which joints of a run are planes within a stone, and which of these are cracked.

A plane is cracked where less than CRACKED of its bond is left, by energy where it softens. A stone is cracked where one of its planes is.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.io.layout import BONDED
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary

CRACKED = 0.5  # share of the bond of a plane below which it is a crack


def stone_of_joints(results: Results) -> np.ndarray:
    """(J,) the name of the stone in which a joint is a plane; empty of a joint between stones."""
    stone, joints = np.array([block.stone for block in results.blocks], dtype=object), results.joints
    a, b = stone[joints.block_a], stone[joints.block_b]
    return np.asarray(np.where((a == b) & results.has_joint_history(BONDED), a, ""), dtype=object)


def has_stones(results: Results) -> bool:
    """Return True if stones of the run are in pieces, which crack from each other."""
    return any(block.stone for block in results.blocks) and results.has_joint_history(BONDED)


def cracked(results: Results, frame: int = -1) -> np.ndarray:
    """(J,) bool: planes within stones that are cracked at a frame."""
    if not has_stones(results):
        return np.zeros(results.joints.count, dtype=bool)
    return np.asarray((stone_of_joints(results) != "") & (results.joints_at(BONDED, frame) < CRACKED))


def cracked_stones(results: Results) -> Summary:
    """Stones that are in pieces, and those of them that are cracked at the end; nothing in a run without any."""
    if not has_stones(results):
        return Summary()
    stones = stone_of_joints(results)
    names = tuple(dict.fromkeys(stones[cracked(results)].tolist()))
    return Summary(stones=len(set(stones.tolist()) - {""}), cracked_stones=len(names), cracked_stone_names=names)
