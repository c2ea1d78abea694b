# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of every run: how far blocks and joints moved, how it was computed, what the structure comes to."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.damage.grades import grade_number
from masonry_cd.analysis.outputs import ANSWER, ASSESS, COMPARE, PAGE, STUDY, STUDY_PAGE, SUMMARY, Number
from masonry_cd.foundation.quantities import finite

MILLIMETRES = ("mm", 1e3)
NUMBERS = {
    # How far blocks moved relative to the base, and which fell
    "displacement_max": Number(
        "largest displacement",
        "largest displacement of a block relative to the base, over all time steps",
        lambda run: run.displacement_max,
        {SUMMARY: 0, STUDY: 2, STUDY_PAGE: 2, ASSESS: 0, ANSWER: 0, COMPARE: 0, PAGE: 2},
        "m",
        MILLIMETRES,
        short="displ.",
    ),
    "top_max": Number(
        "highest block, largest",
        "largest displacement of the highest block over the frames, along the horizontal direction of its largest displacement",
        lambda run: float(np.abs(run.top).max(initial=0.0)),
        {COMPARE: 1},
        "m",
        MILLIMETRES,
    ),
    "top_residual": Number(
        "highest block, residual",
        "displacement of the highest block along that direction at the end",
        lambda run: float(run.top[-1]) if len(run.top) else None,
        {COMPARE: 2},
        "m",
        MILLIMETRES,
    ),
    "drift": Number(
        "largest drift",
        "largest drift of the structure as a whole, horizontal displacement over height, over all time steps",
        lambda run: finite(run.whole["max_drift"]),
        {STUDY: 4, STUDY_PAGE: 3, COMPARE: 3},
        shown=("%", 100.0),
    ),
    "residual_drift": Number(
        "residual drift",
        "drift of the structure as a whole at the end",
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
    # How far joints opened and slid
    "max_opening": Number(
        "largest opening",
        "widest corner gap of a joint at any time step",
        lambda run: float(run.table.max_opening.max(initial=0.0)),
        {SUMMARY: 1, STUDY: 0, STUDY_PAGE: 0, ASSESS: 1, ANSWER: 1, PAGE: 0},
        "m",
        MILLIMETRES,
        short="opening",
        keys={SUMMARY: "opening_max"},
    ),
    "max_sliding": Number(
        "largest sliding",
        "farthest sliding of a joint at any time step",
        lambda run: float(run.table.max_sliding.max(initial=0.0)),
        {SUMMARY: 2, STUDY: 1, STUDY_PAGE: 1, PAGE: 1},
        "m",
        MILLIMETRES,
        keys={SUMMARY: "sliding_max"},
    ),
    "residual_opening": Number(
        "residual opening",
        "widest opening at the end, of a joint that is not separated",
        lambda run: float(run.table.residual_opening[run.table.state != "separated"].max(initial=0.0)),
        {STUDY: 3, ASSESS: 2, ANSWER: 2},
        "m",
        MILLIMETRES,
        short="residual",
    ),
    # How a run was computed
    "steps": Number("steps", "number of time steps", lambda run: run.summary.steps, {STUDY: 10, ASSESS: 6}, whole=True, judges=False),
    "steps_missed": Number(
        "steps missed",
        "steps whose error is above the tolerance",
        lambda run: run.summary.solver.steps_missed,
        {STUDY: 11, STUDY_PAGE: 7, ASSESS: 7},
        whole=True,
    ),
    "error_max": Number(
        "largest error",
        "largest natural map error of a step",
        lambda run: run.summary.solver.error_max,
        {STUDY: 12, STUDY_PAGE: 8, ASSESS: 8},
    ),
    "provisional": Number(
        "provisional",
        "why residual values are provisional; empty where the run ended at rest",
        lambda run: run.summary.provisional,
        {STUDY: 13, ASSESS: 9},
        judges=False,
    ),
    "loads_acted": Number(
        "loads that acted",
        "smallest share of a load that has acted by the end of the run; 1 where all act from the start",
        lambda run: min((one.share for one in run.summary.loads.acted or ()), default=1.0),
        {STUDY: 14, ASSESS: 10},
        judges=False,
    ),
    "end": Number(
        "end of the run", "time of the last frame", lambda run: float(run.results.time[-1]), {COMPARE: 5}, "s", ("s", 1.0), judges=False
    ),
    # What the structure comes to: its grade, the load factor that it bears
    "grade": Number(
        "grade",
        "damage grade of the structure as a whole, D0 to D5, or not graded",
        lambda run: run.whole["grade"],
        {STUDY: 7, STUDY_PAGE: 6, ASSESS: 3},
    ),
    "grade_number": Number(
        "damage grade",
        "number of the grade; empty for a run that is not graded",
        lambda run: grade_number(run.whole["grade"]),
        {STUDY: 8, ANSWER: 3},
        whole=True,
        short="grade",
    ),
    "load_factor": Number(
        "load factor",
        "load factor at which the structure failed under a push or a tilt; empty where it did not fail",
        lambda run: None if run.summary.load_factor is None else run.summary.load_factor.given_way,
        {STUDY: 9, ASSESS: 5, ANSWER: 5},
        short="factor",
    ),
}
