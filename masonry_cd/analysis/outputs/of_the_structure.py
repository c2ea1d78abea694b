# SPDX-License-Identifier: GPL-3.0-or-later
"""What the structure comes to: its grade, the load factor that it bears."""

from __future__ import annotations

from masonry_cd.analysis.outputs import ANSWER, ASSESS, STUDY, STUDY_PAGE, Number
from masonry_cd.analysis.outputs.values import grade_number

NUMBERS = {
    "grade": Number(
        "grade",
        "of damage of the structure as a whole, D0 to D5, or not graded",
        lambda run: run.whole["grade"],
        {STUDY: 7, STUDY_PAGE: 6, ASSESS: 3},
    ),
    "grade_number": Number(
        "damage grade",
        "its number; empty of a run that is not graded",
        lambda run: grade_number(run.whole["grade"]),
        {STUDY: 8, ANSWER: 3},
        whole=True,
        short="grade",
    ),
    "load_factor": Number(
        "load factor",
        "at which the structure gave way to a push or a tilt; empty where it did not",
        lambda run: None if run.summary.load_factor is None else run.summary.load_factor.given_way,
        {STUDY: 9, ASSESS: 5, ANSWER: 5},
        short="factor",
    ),
}
