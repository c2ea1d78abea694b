# SPDX-License-Identifier: GPL-3.0-or-later
"""No finite load factor as a result: what is borne without end, and what would end it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly

if TYPE_CHECKING:
    from masonry_cd.app.static_loads import StaticLoads


def unlimited_lines(loads: StaticLoads, assembly: Assembly) -> list[str]:
    """What is said of loads of which any multiple is borne."""
    said = f"{loads.words}: no finite load factor: the load does no work on any mechanism of these joints, so that any multiple is borne"
    return [
        said,
        f"it would be finite with {', or '.join(_missing(loads, assembly))}",
        "sliding without dilation is not searched for: where joints let go of a thrust as they slide, less may be borne",
    ]


def _missing(loads: StaticLoads, assembly: Assembly) -> list[str]:
    """What would make the factor finite, with the keys."""
    acting = loads.live[~assembly.fixed].any() or loads.support_velocity is not None
    if not acting:
        return ["a load on blocks that are free: it acts on supports alone"]
    out = []
    if not (assembly.laws.crushing > 0.0).all():
        out.append("joints that crush (material.joints.compressive_strength)")
    if np.isinf(loads.bars.strength).any():
        out.append("ties that yield (their yield_force)")
    if loads.support_velocity is None:
        out.append("supports that give way (blocks that hold them in place of fixed ones)")
    return out or ["blocks that are free where it acts"]
