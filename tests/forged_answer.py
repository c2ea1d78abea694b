# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader of files from elsewhere whose answer is not what it should be; a child process loads it, so it brings numpy alone."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

SOUND = {
    "number": [0],
    "name": ["b"],
    "group": [""],
    "fixed": [0],
    "density": [0.0],
    "vertices": [[0.0] * 3] * 4,
    "vertex_start": [0, 4],
    "face_start": [0, 1],
    "loops": [0, 1, 2],
    "loop_start": [0, 3],
    "figures": [1.0],
    "notes": [""],
}  # one block with one face, as arrays


def forge(path: Path, change: dict[str, list[object]], compressed: bool = False) -> None:
    """Write the arrays of a sound answer, but for some of them, where the caller looks for it, and leave at once."""
    arrays = {name: np.array(value) for name, value in {**SOUND, **change}.items()}
    (np.savez_compressed if compressed else np.savez)("answer.npz", **arrays)
    os._exit(0)
