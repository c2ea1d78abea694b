# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a structure as the search for its least factor begins at them: the mechanisms of practice along a push, rigid bodies only."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.limit.macro import Effort, PartMechanism, analyse_element
from masonry_cd.analysis.limit.part import Whole

if TYPE_CHECKING:
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.static_loads import StaticLoads

TOWARDS = 0.7  # cosine of the angle between a push and the line of one of a part's own up to which it may go that way: 45 degrees
RIGID = Effort(starts=0, most_points=0)  # no search block by block


def whole_of(built: LimitStructure, loads: StaticLoads) -> Whole:
    """A structure whose parts are looked at under gravity along -z."""
    from structures.macro_elements.by_kind import rests

    gravity = math.hypot(*built.scene.run.gravity)
    return Whole(built.assembly, built.joints, loads.at().dead, loads.bars, gravity, rests, loads.masses, loads.arms)


def mechanisms_along(built: LimitStructure, loads: StaticLoads) -> list[PartMechanism]:
    """The least mechanism of rigid bodies of each part of a structure that may go along its push; none where gravity is not along -z."""
    from structures.macro_elements import macro_elements

    down, way = np.asarray(built.scene.run.gravity), np.asarray(loads.direction)
    if down[2] >= 0.0 or down[:2].any() or abs(way[2]) > 0.0:
        return []
    whole = whole_of(built, loads)
    found: list[PartMechanism] = []
    for element in macro_elements(str(built.scene.structure.get("kind", "")), built.made.blocks):
        if max(abs(float(np.sum(own * way))) for own in element.directions) >= TOWARDS:
            found += analyse_element(whole, element, tuple(way), RIGID).mechanisms[:1]
    return found
