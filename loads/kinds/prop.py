# SPDX-License-Identifier: GPL-3.0-or-later
"""A prop: blocks that are held along a direction, and whose reaction is recorded. How is in :mod:`loads.kinds.driven`."""

from __future__ import annotations

from typing import Literal

import numpy as np

from loads.kinds.driven import GuidedKeys, counted, guide_of, named
from loads.motion import DirectionKey, LoadAction, LoadKind, LoadTable, RunGrid
from masonry_cd.foundation.errors import InputError


class PropTable(GuidedKeys, LoadTable):
    """Keys of ``kind = "prop"``."""

    kind: Literal["prop"] = "prop"
    direction: DirectionKey
    """Axis, vector or level angle from x to y along which the blocks are held; across it they are free: one along x holds no weight."""


def prop(table: PropTable, grid: RunGrid, where: str) -> LoadAction:
    """The guide of blocks that are held along a direction.

    Raises:
        InputError: unknown or fixed blocks, or a point off its block.
    """
    if table.blocks is None:
        raise InputError(f"{where}.blocks", "missing")
    guide = guide_of(table, table.direction, np.zeros(grid.steps + 1), grid, where)
    summary = table.facts("direction") | named(guide, grid, where)
    line = f"{where} prop: {counted(guide)} held along {table.direction.label}{', and from turning' if guide.held else ''}"
    return LoadAction(forces=(guide,), lines=(line,), summary=summary)


KINDS = {"prop": LoadKind(PropTable, prop, slow=lambda table: True, gentle=True, starter={"blocks": "v14", "direction": "x"})}
