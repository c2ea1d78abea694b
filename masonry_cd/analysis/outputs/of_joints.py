# SPDX-License-Identifier: GPL-3.0-or-later
"""How far joints opened and slid."""

from __future__ import annotations

from masonry_cd.analysis.outputs import ANSWER, ASSESS, PAGE, STUDY, STUDY_PAGE, SUMMARY, Number

MILLIMETRES = ("mm", 1e3)
NUMBERS = {
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
        "widest opening that is left at the end, of a joint that is not separated",
        lambda run: float(run.table.residual_opening[run.table.state != "separated"].max(initial=0.0)),
        {STUDY: 3, ASSESS: 2, ANSWER: 2},
        "m",
        MILLIMETRES,
        short="residual",
    ),
}
