# SPDX-License-Identifier: GPL-3.0-or-later
"""No finite load factor as a result: what is borne without end, and what would end it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.app.limit_search import search_words
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import LAWS

if TYPE_CHECKING:
    from masonry_cd.analysis.limit.analysis import Analysis
    from masonry_cd.app.static_loads import StaticLoads


def unlimited_lines(loads: StaticLoads, assembly: Assembly, analysis: Analysis) -> list[str]:
    """What is said of loads of which any multiple is borne as long as joints that slide open."""
    if analysis.least is not None:
        return [
            f"{loads.words}: no finite associated load factor: where sliding opens joints the blocks are wedged, and bear any multiple",
            search_words(analysis),
            "what is wedged bears by forces that no load makes, as friction on faces that need not be pressed: count on the least factor",
        ]
    return [
        f"{loads.words}: no finite load factor: the load does no work on any mechanism of these joints, so that any multiple is borne",
        f"it would be finite with {', or '.join(_missing(loads, assembly))}",
        f"{search_words(analysis)}: where joints let go of a thrust as they slide, less may be borne",
    ]


def _missing(loads: StaticLoads, assembly: Assembly) -> list[str]:
    """What would make the factor finite, with the keys."""
    acting = loads.live[~assembly.fixed].any() or loads.support_velocity is not None
    if not acting:
        return ["a load on blocks that are free: it acts on supports alone"]
    out = [law.bounds for law in LAWS if law.bounds and not law.where(assembly.laws).all()]
    if np.isinf(loads.bars.strength).any():
        out.append("ties that yield (their yield_force)")
    if loads.support_velocity is None:
        out.append("supports that give way (blocks that hold them in place of fixed ones)")
    return out or ["blocks that are free where it acts"]
