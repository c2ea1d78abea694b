# SPDX-License-Identifier: GPL-3.0-or-later
"""Small bridges for tests of fill and vehicles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import structures
from loads.motion import RunGrid
from masonry_cd.mechanics.model.blocks import Assembly
from structures import MadeStructure

SPAN = {"span": 6.0, "rise": 1.5, "thickness": 0.5, "voussoirs": 15}
GRAVITY = np.array([0.0, 0.0, -10.0])


def bridge(*spans: dict, **keys: object) -> tuple[MadeStructure, Assembly]:
    """A bridge of stone of 2,000 kg/m3 and its assembly."""
    made = structures.make({"kind": "bridge", "spans": list(spans or (SPAN,)), **keys}, 2000.0, Path())
    return made, Assembly.from_blocks(made.blocks, 0.6)


def grid(made: MadeStructure, assembly: Assembly, steps: int = 1, dt: float = 1e-3) -> RunGrid:
    """Return the grid that loads are given for a run on it."""
    return RunGrid(dt, steps, GRAVITY, Path(), assembly, fills=made.fills)
