# SPDX-License-Identifier: GPL-3.0-or-later
"""Ties of a run as a picture shows them: straight lines, each with its tension."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.analysis.ties import histories
from masonry_cd.foundation.quantities import force
from masonry_cd.io.results import Results
from reports.drawing.parts import Ties


def ties_at(results: Results, solids: Solids, pose: Pose, factor: float) -> Ties:
    """The ties at a frame; displacements are drawn amplified by a factor."""
    ends, texts, tension = [], [], []
    for tie in histories(results):
        blocks = np.array([bar.blocks for bar in tie.bars])
        moved = [pose.moved(solids, np.array([bar.points[k] for bar in tie.bars]), blocks[:, k], factor) for k in range(2)]
        weight = np.array([bar.section for bar in tie.bars]) / tie.area
        ends.append([weight @ points for points in moved])
        now = tie.at(pose.time)
        yielded = tie.yielding[: max(1, int(np.searchsorted(tie.time, pose.time * (1.0 + 1e-12), side="right")))].any()
        tension.append(now)
        texts.append(("slack" if now == 0.0 else force(now)) + (", has yielded" if yielded else ""))
    return Ties(np.array(ends, dtype=float).reshape(-1, 2, 3), tuple(texts), np.array(tension))
