# SPDX-License-Identifier: GPL-3.0-or-later
"""How a run was computed."""

from __future__ import annotations

from masonry_cd.analysis.outputs import ASSESS, COMPARE, STUDY, STUDY_PAGE, Number

NUMBERS = {
    "steps": Number("steps", "time steps made", lambda run: run.summary.steps, {STUDY: 10, ASSESS: 6}, whole=True, judges=False),
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
        "why what is left at the end is not the last; empty where the run ended at rest",
        lambda run: run.summary.provisional,
        {STUDY: 13, ASSESS: 9},
        judges=False,
    ),
    "loads_acted": Number(
        "loads that acted",
        "least share of a load that has acted by the end of the run; 1 where all act from the start",
        lambda run: min((one.share for one in run.summary.loads.acted or ()), default=1.0),
        {STUDY: 14, ASSESS: 10},
        judges=False,
    ),
    "end": Number(
        "end of the run", "time of its last frame", lambda run: float(run.results.time[-1]), {COMPARE: 5}, "s", ("s", 1.0), judges=False
    ),
}
