# SPDX-License-Identifier: GPL-3.0-or-later
"""study.html: the whole study on one page that needs nothing else; words first, then the pictures, the fits and the runs.

A run whose page is kept (runs/ID/report.html) is linked from its row.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility import words
from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.folder import FIRST, Study
from masonry_cd.analysis.fragility.measures import unit
from masonry_cd.analysis.outputs import STUDY_PAGE, numbers_in
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.quantities import counted
from reports.page.document import Head, pictures, script_of, write_document
from reports.page.title_block import rows_of_many
from reports.study.fragility_picture import METHODS

PAGE = "study.html"
ROWS = 3000  # of the table of runs; all are in runs.csv
PRINTED = 40
RESULTS = tuple(numbers_in(STUDY_PAGE))
CAPTIONS = {
    "fragility.png": "The probability that a limit state is exceeded, given the intensity. Points are what was counted, lines what was "
    "fitted; inside its band a line could as well lie with other records of the same kind. Where a curve leaves the points, trust those.",
    "ida.png": "A pale line per record, from weak to strong; where it turns flat, blocks fall. Half of the records open less than the "
    "median says.",
    "cloud.png": "A point per run as it was recorded. The line is the regression; runs in which blocks fell are known from below only.",
    "stripes.png": "All runs of a level above one another. Where the median, the thick bar, crosses a dashed line, half of the runs exceed "
    "that limit state.",
    "spread.png": "How far the runs differ. The steeper the line, the more one run says about all of them.",
    "tornado.png": "What goes with the damage: far right, more of it means more damage; far left, less. A whisker across zero shows "
    "nothing. The diamond is what is left once the intensity has been taken out: look there for the share of the material.",
    "probability_opened.png": "How often each joint opened over all runs. Runs at chosen intensities are no sample of earthquakes: "
    "compare joints with one another, and read probabilities level by level.",
    "probability_slid.png": "How often each joint slid.",
    "probability_lost.png": "How often each joint came apart for good.",
    "median_opening.png": "The largest opening that half of the runs exceed.",
}


@dataclass(frozen=True)
class Said:
    """What there is to say of a study."""

    verdict: Verdict
    lines: Sequence[str]
    warnings: Sequence[str]


def write_page(study: Study, fits: Sequence[Fit], drawn: Sequence[Path], said: Said) -> None:
    """Write study.html.

    Raises:
        InputError: it cannot be written.
    """
    title = str(study.asked["title"])
    notes = dict.fromkeys(fit.betas.note for fit in fits if fit.fitted and fit.betas.note)
    write_document(
        study.folder / PAGE,
        "study.html",
        title=title,
        page=Head(title, said.lines, said.warnings, _counts(study), _block(study), said.verdict),
        drawn=pictures({path: CAPTIONS.get(path.name, "How often each joint opened at this level.") for path in drawn}),
        measure=fits[0].measure if fits else "",
        fits=[_fit(fit) for fit in fits],
        on_beta="; ".join(notes),
        runs=_runs(study),
        printed=PRINTED,
        settings=[*words.settings(study).items()],
        script=script_of("reports.study", "study.js"),
    )


def _block(study: Study) -> list[tuple[str, str]]:
    """The rows of its title block."""
    asked = study.asked
    varied = [counted(len(study.motions), "record")] if study.motions else []
    varied += [f"{asked['measure']} at {counted(len(asked['levels']), 'level')}"] if asked["measure"] and asked["levels"] else []
    return rows_of_many(asked["scene"], asked.get("program", ""), ", ".join([*varied, *study.varied]) or "nothing but chance")


def _counts(study: Study) -> list[tuple[str, object, str]]:
    """The counts."""
    found = words.counts(study)
    return [
        ("runs done", found["done"], ""),
        ("records", len(study.motions), ""),
        ("failed or timed out", (found["failed"] or 0) + (found["timeout"] or 0), ""),
        ("runs in which blocks fell", int((study.collapsed & study.done).sum()), ""),
    ]


def _fit(fit: Fit) -> list[str]:
    """A row of the table of fits."""
    return [
        fit.limit.name,
        fit.limit.in_words(),
        METHODS[fit.method],
        f"{_number(fit.theta)} {unit(fit.measure)}" if fit.fitted else "no fit",
        _range(fit.theta_band),
        _number(fit.beta, 2),
        _range(fit.beta_band, 2),
        _number(fit.betas.record, 2),
        _number(fit.betas.model, 2),
        f"{fit.exceeded} of {fit.runs} {'records' if fit.method == 'ida' else 'runs'}",
    ]


@dataclass(frozen=True)
class Cell:
    """A cell of the table of runs."""

    text: str
    value: str | None = None  # by which a number is sorted
    page: str = ""  # of the run, where it is kept


def _runs(study: Study) -> dict[str, Any]:
    """The table of runs: its columns, its first rows, and how many there are."""
    shown = [*FIRST[:4], *study.varied, *([study.asked["measure"]] if study.asked["measure"] else [])]
    shown += [name for name in RESULTS if name in study.columns] + ["status", "reason"]
    shown = [name for name in dict.fromkeys(shown) if any(_raw(study, name, k) for k in range(study.count))]
    rows = [[_cell(study, name, k) for name in shown] for k in range(min(study.count, ROWS))]
    return {"columns": shown, "rows": rows, "count": study.count}


def _raw(study: Study, name: str, row: int) -> str:
    """A cell as text, empty where there is nothing."""
    column = study.columns[name]
    if isinstance(column, list):
        return column[row]
    return "" if math.isnan(column[row]) else repr(float(column[row]))


def _cell(study: Study, name: str, row: int) -> Cell:
    """A cell of the table of runs."""
    raw = _raw(study, name, row)
    if name == "run":
        address = f"runs/{raw}/report.html"
        known = re.fullmatch(r"[\w.-]+", raw) and (study.folder / address).exists()
        return Cell(raw, page=address if known else "")
    if isinstance(study.columns[name], list):
        return Cell(raw)
    return Cell(f"{float(raw):.4g}" if raw else "", raw)


def _number(value: float | None, digits: int | None = None) -> str:
    """Three digits, or so many after the point; empty where there is none."""
    if value is None or not math.isfinite(value):
        return "" if value is None or math.isnan(value) else "∞"
    return f"{value:.3g}" if digits is None else f"{value:.{digits}f}"


def _range(two: tuple[float, float], digits: int | None = None) -> str:
    return " to ".join(_number(value, digits) for value in two) if not math.isnan(two[0]) else ""
