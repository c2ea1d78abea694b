# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs in a study's folder: tables, pictures and the page, as far as its design and its runs allow."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.fragility.findings import Findings, findings_in
from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.folder import FIRST, StudyResults
from masonry_cd.analysis.fragility.measures import unit
from masonry_cd.analysis.fragility.rates import Rate
from masonry_cd.analysis.fragility.sensitivity import COLUMNS
from masonry_cd.analysis.outputs import STUDY_PAGE, numbers_in
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import counted
from reports.drawing.render import NoContext
from reports.page.document import Badge, Head, pictures, rows_of_many, script_of, write_document
from reports.study.joint_maps import draw_joint_maps
from reports.study.pictures import METHODS, draw_cloud, draw_fragilities, draw_ida, draw_spread, draw_stripes, draw_tornado
from reports.study.tables import COLUMNS_OF_FITS, DIGITS, entry_of, row_of, write_openquake, write_vulnerability

PAGE = "study.html"
ROWS = 3000  # of the table of runs; all are in runs.csv
PRINTED = 40
RESULTS = tuple(numbers_in(STUDY_PAGE))
CAPTIONS = {
    "fragility.png": "The probability that a limit state is exceeded, given the intensity. Points are counted shares, lines are fits; with "
    "other records of the same kind a line could lie anywhere in its band. Where a curve and its points disagree, trust the points.",
    "ida.png": "One pale line per record, from weak to strong; where it turns flat, blocks fall. The median is exceeded by half of the "
    "records.",
    "cloud.png": "One point per recorded run. The line is the regression; runs in which blocks fell give a lower bound only.",
    "stripes.png": "The runs of each level, one above another. Where the median (thick bar) crosses a dashed line, half of the runs exceed "
    "that limit state.",
    "spread.png": "The spread of the results over the runs. The steeper the line, the better one run represents all of them.",
    "tornado.png": "Correlation with the damage: far right, a larger value means more damage; far left, less. A whisker that crosses zero "
    "shows no effect. The diamond is the correlation once the effect of the intensity is removed; it shows that of the material.",
    "probability_opened.png": "How often each joint opened over all runs. Runs at chosen intensities are not a sample of earthquakes: "
    "compare joints with each other, and read probabilities level by level.",
    "probability_slid.png": "How often each joint slid.",
    "probability_lost.png": "How often each joint came apart for good.",
    "median_opening.png": "The largest opening that half of the runs exceed.",
}
MADE = ("runs.csv", "runs.parquet", "limits.csv")  # by the study itself, run by run
FILES = tuple(name for name in files_of("study") if name not in MADE)
MAPS = "probability_*.png"


@dataclass(frozen=True)
class StudyReport:
    """Summary of a study, as summary.json has it."""

    verdict: Verdict
    lines: Sequence[str]
    warnings: Sequence[str]
    files: Sequence[Path]  # tables, then pictures


def write_study(folder: Path) -> StudyReport:
    """Fit, draw and write all that a study's design and its runs allow; what an earlier call wrote and this one does not is removed.

    The folder holds study.json, runs.csv, and, for the maps, joints/ and reference/.

    Raises:
        InputError: something in the folder is missing or broken.
    """
    found = findings_in(folder)
    own_files.begin(folder, (*FILES, MAPS), lambda _: True)  # which study.json proves, read above
    own_files.remove(folder, (*FILES, MAPS))
    tables, warnings = _write_tables(found)
    drawn = [folder / name for name in diagrams(found)]
    for path in drawn:
        DIAGRAMS[path.name].draw(found, path)
    try:
        maps, lines, more = draw_joint_maps(found.study)
    except NoContext as failure:
        maps, lines, more = [], [], [str(failure)]
    files = sorted([*tables, *drawn, *maps], key=lambda path: path.suffix == ".png")
    made = StudyReport(found.verdict, [*found.lines, *lines], [*found.warnings, *warnings, *more], files)
    write_page(found, made)
    write_json(folder / "summary.json", _summary(found, made), DIGITS)
    return made


def _write_tables(found: Findings) -> tuple[list[Path], list[str]]:
    """Write fragility.csv, .json and .xml, sensitivity.csv; those that there are, and warnings."""
    study, fits, warnings = found.study, found.fits, list[str]()
    table, facts, nrml = (study.folder / f"fragility.{form}" for form in ("csv", "json", "xml"))
    sensitivity, losses = study.folder / "sensitivity.csv", study.folder / "vulnerability.xml"
    if fits:
        write_csv(table, COLUMNS_OF_FITS, (row_of(fit).values() for fit in fits), digits=6)
        write_json(
            facts,
            {"format": 1, "fits": [entry_of(fit) for fit in fits], **_over_hazard(found), "warnings": found.all_fits.warnings},
            DIGITS,
        )
        warnings = write_openquake(nrml, study.asked.title, found.first_fits)
        warnings += write_vulnerability(losses, study.asked.title, found.first_fits, study.asked.loss_ratios)
    if found.correlations:
        write_csv(sensitivity, COLUMNS, found.correlations, digits=6)
    return [path for path in (table, facts, nrml, losses, sensitivity) if path.exists()], warnings


class StudyDiagram(NamedTuple):
    """A diagram: whether a study's design and its runs allow it, and what draws it."""

    allowed: Callable[[Findings], bool]
    draw: Callable[[Findings, Path], None]


def _has_fit(found: Findings) -> bool:
    return any(fit.runs for fit in found.fits)


def _is_in_stripes(found: Findings) -> bool:
    levels = found.study.numbers("level")[found.study.done]
    return found.study.asked.design != "ida" and len(np.unique(levels[np.isfinite(levels)])) > 1 and bool(found.quantities)


DIAGRAMS = {
    "fragility.png": StudyDiagram(_has_fit, draw_fragilities),
    "ida.png": StudyDiagram(lambda found: bool(found.all_fits.curves and found.quantities), draw_ida),
    "cloud.png": StudyDiagram(lambda found: bool(found.all_fits.clouds), draw_cloud),
    "stripes.png": StudyDiagram(_is_in_stripes, draw_stripes),
    "spread.png": StudyDiagram(lambda found: not _has_fit(found) and not _is_in_stripes(found) and bool(found.quantities), draw_spread),
    "tornado.png": StudyDiagram(lambda found: bool(found.correlations), draw_tornado),
}


def diagrams(found: Findings) -> list[str]:
    """Names of the diagrams that a study's design and its runs allow."""
    return [name for name, diagram in DIAGRAMS.items() if diagram.allowed(found)]


def _summary(found: Findings, made: StudyReport) -> dict[str, Any]:
    """Return the contents of summary.json."""
    asked = found.study.asked
    return {
        "format": 1,
        "verdict": made.verdict.as_dict(),
        "title": asked.title,
        "design": asked.design,
        "measure": asked.measure,
        "runs": found.counts,
        "records": len(found.study.motions),
        "collapsed": found.fell,
        "fragility": [row_of(fit) | dict(fit.betas.as_dict()) for fit in found.first_fits],
        **_over_hazard(found),
        "spread": {column: spread._asdict() for column, spread in found.spreads.items()},
        "sensitivity": [row._asdict() for row in found.correlations if row.kind == "varied"],
        "files": [*(path.name for path in made.files), PAGE],
        "lines": made.lines,
        "warnings": made.warnings,
    }


def write_page(found: Findings, made: StudyReport) -> None:
    """Write study.html: words first, then the pictures, the fits and the runs; a run whose page is kept is linked from its row."""
    study, fits, asked = found.study, found.fits, found.study.asked
    varied = [counted(len(study.motions), "record")] if study.motions else []
    varied += [f"{asked.measure} at {counted(len(asked.levels), 'level')}"] if asked.measure and asked.levels else []
    block = rows_of_many(asked.scene, asked.program, ", ".join([*varied, *study.varied]) or "nothing but chance")
    notes = dict.fromkeys(fit.betas.note for fit in fits if fit.is_fitted and fit.betas.note)
    numbers = [
        ("runs done", found.counts["done"], ""),
        ("records", len(study.motions), ""),
        ("failed or timed out", found.lost, ""),
        ("runs in which blocks fell", found.fell, ""),
    ]
    drawn = [path for path in made.files if path.suffix == ".png"]
    write_document(
        study.folder / PAGE,
        "study.html",
        title=asked.title,
        page=Head(asked.title, made.lines, made.warnings, numbers, block, made.verdict),
        drawn=pictures({path: CAPTIONS.get(path.name, "How often each joint opened at this level.") for path in drawn}),
        measure=fits[0].measure if fits else "",
        fits=[_fit(fit) for fit in fits],
        on_beta="; ".join(notes),
        rates=[_rate(rate) for rate in found.rates],
        hazard=study.asked.hazard,
        runs=_runs(study),
        printed=PRINTED,
        settings=[*_settings(study).items()],
        script=script_of("reports.study", "study.js"),
    )


def _settings(study: StudyResults) -> dict[str, str]:
    """Return the settings of the study."""
    asked = study.asked
    return {
        "design": asked.design,
        "scene": asked.scene,
        "seed": str(asked.seed),
        "intensity measure": asked.measure or "none",
        "levels": ", ".join(f"{level:g}" for level in asked.levels) if asked.levels else "none",
        "varied": ", ".join(study.varied) or "nothing in the scene",
        "records": str(len(study.motions)) if study.motions else "none",
        **{f"limit state {limit.name}": limit.in_words() for limit in study.limit_states},
    }


def _fit(fit: Fit) -> list[str]:
    """A row of the table of fits."""
    return [
        fit.limit.name,
        fit.limit.in_words(),
        METHODS[fit.method],
        f"{_number(fit.theta)} {unit(fit.measure)}" if fit.is_fitted else "no fit",
        _range(fit.theta_band),
        _number(fit.beta, 2),
        _range(fit.beta_band, 2),
        _number(fit.betas.record, 2),
        _number(fit.betas.model, 2),
        f"{fit.exceeded} of {fit.runs} {'records' if fit.method == 'ida' else 'runs'}",
    ]


def _over_hazard(found: Findings) -> dict[str, Any]:
    """The hazard of the site and how often limit states are exceeded, of a study whose scene has one."""
    hazard = found.study.asked.hazard
    return (
        {} if hazard is None else {"hazard": hazard, "frequencies": [rate.row() for rate in found.rates], "annual_loss": found.annual_loss}
    )


def _rate(rate: Rate) -> list[str]:
    """A row of the table of frequencies."""
    row, (low, high) = rate.row(), rate.band
    return [
        rate.limit,
        f"{rate.most:.2g}",
        f"{rate.least:.2g}",
        f"{low:.2g} to {high:.2g}",
        f"{row['return_period_years']:,.0f}",
        f"{100.0 * row['probability_50_years']:.2g} %",
        f"{100.0 * row['probability_low']:.2g} to {100.0 * row['probability_high']:.2g} %",
    ]


def _runs(study: StudyResults) -> dict[str, Any]:
    """The table of runs: its columns, its first rows, which are numbers, and how many rows there are."""
    shown = [*FIRST[:4], *study.varied, *([study.asked.measure] if study.asked.measure else [])]
    shown += [name for name in RESULTS if name in study.columns] + ["status", "reason"]
    shown = [name for name in dict.fromkeys(shown) if any(_raw(study, name, k) for k in range(study.count))]
    rows = [[_cell(study, name, k) for name in shown] for k in range(min(study.count, ROWS))]
    numbers = [k for k, name in enumerate(shown) if not isinstance(study.columns[name], list)]
    return {"columns": [name.replace("_", " ") for name in shown], "rows": rows, "numbers": numbers, "count": study.count}


def _raw(study: StudyResults, name: str, row: int) -> str:
    """A cell as text, empty where there is nothing."""
    column = study.columns[name]
    if isinstance(column, list):
        return column[row]
    return "" if math.isnan(column[row]) else repr(float(column[row]))


def _cell(study: StudyResults, name: str, row: int) -> str | Badge:
    """A cell of the table of runs; a run whose page is kept has its address."""
    raw, address = _raw(study, name, row), f"runs/{_raw(study, 'run', row)}/report.html"
    if name == "run" and re.fullmatch(r"[\w.-]+", raw) and (study.folder / address).exists():
        return Badge("", raw, address)
    return f"{float(raw):.4g}" if raw and not isinstance(study.columns[name], list) else raw


def _number(value: float | None, digits: int | None = None) -> str:
    """Three digits, or the given number of decimals; empty where there is none."""
    if value is None or not math.isfinite(value):
        return "" if value is None or math.isnan(value) else "∞"
    return f"{value:.3g}" if digits is None else f"{value:.{digits}f}"


def _range(two: tuple[float, float], digits: int | None = None) -> str:
    return " to ".join(_number(value, digits) for value in two) if not math.isnan(two[0]) else ""
