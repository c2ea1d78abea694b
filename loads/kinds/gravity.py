# SPDX-License-Identifier: GPL-3.0-or-later
"""Gravity, at once or ramped: a(t) = s(t / ramp) g with the smooth step s(x) = 3 x^2 - 2 x^3.

Rigid blocks on rigid joints stand at rest under full gravity from the first step, so nothing is ramped by default. A ramp helps
where joints are elastic (a load applied at once doubles their compression for a moment).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from loads.acted import over_time
from loads.motion import LoadAction, LoadKind, LoadTable, RunGrid, Static, smooth_step
from masonry_cd.foundation.fields import Instant


class GravityTable(LoadTable):
    """Keys of ``kind = "gravity"``."""

    kind: Literal["gravity"] = "gravity"
    ramp: Instant = 0.0
    """Time in which gravity smoothly rises to its full value."""


def gravity(table: GravityTable, grid: RunGrid, where: str) -> LoadAction:
    """The acceleration of gravity at the run's times, (N + 1, 3) [m/s2]."""
    factor = smooth_step(grid.times / table.ramp) if table.ramp > 0.0 else np.ones(grid.steps + 1)
    summary = table.facts("ramp") | {"gravity": [float(g) for g in grid.gravity]}
    lines = (f"{where} gravity: ramped smoothly from 0 to 1 over {table.ramp:g} s",) if table.ramp > 0.0 else ()
    acted = over_time(where, "weight", 0.0, table.ramp, lambda x: float(smooth_step(np.array(x))))
    return LoadAction(acceleration=np.outer(factor, grid.gravity), lines=lines, summary=summary, acted=acted if table.ramp > 0.0 else None)


KINDS = {
    "gravity": LoadKind(
        GravityTable,
        gravity,
        slow=lambda table: True,
        static=lambda table, grid, where: Static(),  # of all blocks, in every limit analysis
        gentle=True,
        starter={"ramp": 0.5},
    )
}
