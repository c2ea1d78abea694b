# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict on a study: the range of grades over its runs, and how far the runs bear out what is fitted to them."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.verdict import ENOUGH
from masonry_cd.analysis.fragility.fits import Fits
from masonry_cd.analysis.fragility.folder import Study
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, NOT_GRADED, UNKNOWN, Verdict
from masonry_cd.foundation.quantities import counted

FEW_RECORDS = 10  # with fewer the bands of fits are too narrow
MANY = 0.1  # share of runs without data or without a grade from which on fits are biased beyond what their bands say


def verdict_of(study: Study, fits: Fits) -> Verdict:
    """What the runs of a study come to."""
    done, asked = int(study.done.sum()), study.count
    if not done:
        return Verdict("", "", "", UNKNOWN, "no verdict, no run is done", "")
    lost = sum(study.text("status").count(state) for state in ("failed", "timeout"))
    ungraded = study.text("grade").count(NOT_GRADED) if "grade" in study.columns else 0
    missed = int((study.numbers("steps_missed")[study.done] > 0).sum())
    short = int((study.numbers("loads_acted")[study.done] < ENOUGH).sum())
    unfitted = [fit.limit.name for fit in fits.fits if not fit.fitted]
    few = bool(study.asked["measure"]) and 0 < len(study.motions) < FEW_RECORDS
    reasons = [
        f"{lost} of {asked} runs failed or timed out" if lost else "",
        f"{ungraded} of {done} runs cannot be relied on" if ungraded else "",
        f"{missed} of {done} runs missed the tolerance in some steps" if missed else "",
        f"{counted(len(study.motions), 'record')}, and {FEW_RECORDS} are wanted" if few else "",
        f"{short} of {done} runs ended before their loads had acted" if short else "",
        f"no fit of {', '.join(dict.fromkeys(unfitted))}" if unfitted else "",
        *fits.warnings,
    ]
    why, grade = "; ".join(filter(None, reasons)), _range(study)
    if (lost + ungraded) > MANY * asked:
        return Verdict(grade, "", "", DOUBTFUL, "do not rely on this study before its runs are mended", why)
    if why:
        return Verdict(grade, "", "", LOOK, "read what is fitted with care", why)
    return Verdict(grade, "", "", GOOD, "nothing in the runs speaks against what is fitted", "")


def _range(study: Study) -> str:
    """``D0 to D4``; empty where no run is graded."""
    found = study.numbers("grade_number")[study.done] if "grade_number" in study.columns else np.zeros(0)
    found = found[np.isfinite(found)].astype(int)
    if not len(found):
        return ""
    low, high = NAMES[found.min()], NAMES[found.max()]
    return low if low == high else f"{low} to {high}"
