# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joints that stay closed: thrust within the middle third of their depth.

A rectangular joint of depth t without tension is closed over all of its depth as long as |M| <= N t / 6. Its resultants are then those of
two forces, t / 6 on either side of its middle: two cells without a limit (:mod:`masonry_cd.analysis.limit.crushing`), the strips from the
middle to a third of the depth on either side, whose centroids lie there. Where no forces in such joints bear a load, some joint has to
open, however stiff the parts are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.analysis.limit.crushing import with_cells, with_rates
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.sections import sections
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints


def middle_third(problem: LimitProblem, assembly: Assembly, joints: Joints) -> LimitProblem:
    """A problem in a plane whose joints with a compressive strength, whatever it is, stay closed, and have no limit of stress."""
    found = sections(assembly, joints, problem.points, problem.axis)
    if found is None:
        return problem
    outline = found.outline
    low, high = (part.reduceat(outline.corners[:, 0], outline.start[:-1]) for part in (np.minimum, np.maximum))
    across, middle, third = np.tile([1.0, 0.0], (len(low), 1)), 0.5 * (low + high), (high - low) / 3.0
    strips = outline.beyond(across, middle - third).beyond(-across, -middle - third).cut(across, middle)
    endless = replace(found, strength=np.full_like(found.strength, np.inf), cells=strips)
    return replace(with_cells(with_rates(problem, endless), endless), sections=None)  # there is nothing to cut more finely
