# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a structure as the search for its least factor begins at them: the mechanisms of practice along a push, rigid bodies only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.limit.candidates import with_mechanisms, with_overturning
from masonry_cd.analysis.limit.macro import Effort, PartMechanism, analyse_element
from masonry_cd.analysis.limit.part import Whole

if TYPE_CHECKING:
    from masonry_cd.analysis.limit.analysis import Analysis
    from masonry_cd.analysis.limit.mechanism import Mechanism
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.static_loads import StaticLoads

ALONG = 0.999  # cosine of the angle between two pushes up to which they are one
BEGUN = 6  # mechanisms of parts at which the search begins, three or four cone programmes each
TOWARDS = 0.7  # cosine of the angle between a push and the line of one of a part's own up to which it may go that way: 45 degrees
RIGID = Effort(starts=0, most_points=0)  # no search block by block


def whole_of(built: LimitStructure, loads: StaticLoads) -> Whole:
    """A structure whose parts are looked at under gravity along -z."""
    from structures.macro_elements import rests

    gravity = math.hypot(*built.scene.run.gravity)
    return Whole(built.assembly, built.joints, loads.at().dead, loads.bars, gravity, rests, loads.masses, loads.arms)


def begun_at_parts(analysis: Analysis, built: LimitStructure, loads: StaticLoads, parts: Sequence[PartMechanism] = ()) -> Analysis:
    """An analysis under a push whose search has begun at mechanisms of parts as well, the given ones or those of rigid bodies, and at what
    would overturn below the factor found then. As it was where gravity is not along -z or the push not level."""
    down, way = np.asarray(built.scene.run.gravity), np.asarray(loads.direction)
    if down[2] >= 0.0 or down[:2].any() or abs(way[2]) > 0.0:
        return analysis
    known = _along(parts or mechanisms_along(built, loads), way)
    return with_overturning(with_mechanisms(analysis, built.assembly, built.joints, known), whole_of(built, loads), way)


def _along(parts: Sequence[PartMechanism], way: np.ndarray) -> list[Mechanism]:
    """The mechanisms of least factor of parts that are pushed as the whole is."""
    some = sorted((one for one in parts if one.found and float(one.direction @ way) > ALONG), key=lambda one: one.oscillator.alpha)
    return [one.found.mechanism for one in some[:BEGUN] if one.found]


def mechanisms_along(built: LimitStructure, loads: StaticLoads) -> list[PartMechanism]:
    """The least mechanism of rigid bodies of each part of a structure that may go along its push."""
    from structures.macro_elements import groups, macro_elements

    way = np.asarray(loads.direction)
    whole, kind = whole_of(built, loads), built.scene.kind
    found: list[PartMechanism] = []
    for element in macro_elements(built.made.blocks, groups if kind is None else kind.parts):
        if max(abs(float(np.sum(own * way))) for own in element.directions) >= TOWARDS:
            found += analyse_element(whole, element, tuple(way), RIGID).mechanisms[:1]
    return found
