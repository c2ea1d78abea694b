# SPDX-License-Identifier: GPL-3.0-or-later
"""How far blocks moved relative to the base, and which fell."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.outputs import ANSWER, ASSESS, COMPARE, PAGE, STUDY, STUDY_PAGE, SUMMARY, Number
from masonry_cd.analysis.outputs.values import finite

NUMBERS = {
    "displacement_max": Number(
        "largest displacement",
        "of a block, relative to the base, at any time step",
        lambda run: run.displacement_max,
        {SUMMARY: 0, STUDY: 2, STUDY_PAGE: 2, ASSESS: 0, ANSWER: 0, COMPARE: 0, PAGE: 2},
        "m",
        ("mm", 1e3),
        short="displ.",
    ),
    "top_max": Number(
        "highest block, largest",
        "largest displacement of the highest block along the horizontal direction in which it goes farthest, over the frames",
        lambda run: float(np.abs(run.top).max(initial=0.0)),
        {COMPARE: 1},
        "m",
        ("mm", 1e3),
    ),
    "top_residual": Number(
        "highest block, residual",
        "what is left of it at the end",
        lambda run: float(run.top[-1]) if len(run.top) else None,
        {COMPARE: 2},
        "m",
        ("mm", 1e3),
    ),
    "drift": Number(
        "largest drift",
        "of the structure as a whole: horizontal displacement over height, over all steps",
        lambda run: finite(run.whole["max_drift"]),
        {STUDY: 4, STUDY_PAGE: 3, COMPARE: 3},
        shown=("%", 100.0),
    ),
    "residual_drift": Number(
        "residual drift",
        "what is left of it at the end",
        lambda run: finite(run.whole["residual_drift"]),
        {COMPARE: 4},
        shown=("%", 100.0),
    ),
    "collapsed_blocks": Number(
        "number of collapsed blocks",
        "blocks that have fallen",
        lambda run: len(run.fallen),
        {STUDY: 5, STUDY_PAGE: 4, ASSESS: 4, ANSWER: 4},
        whole=True,
        short="fallen",
    ),
    "collapse_time": Number(
        "first fall",
        "time of the first frame in which a block has fallen; empty where none has",
        lambda run: run.first_fall(),
        {STUDY: 6, STUDY_PAGE: 5},
        "s",
        ("s", 1.0),
    ),
}
