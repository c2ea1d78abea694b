# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study's folder gets from the reports: tables, pictures and the page, as far as its design and its runs allow."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility import words
from masonry_cd.analysis.fragility.fits import Fit, Fits, fit_study
from masonry_cd.analysis.fragility.folder import FIRST, Study, read_study
from masonry_cd.analysis.fragility.measures import unit
from masonry_cd.analysis.fragility.sensitivity import COLUMNS, Correlation, correlations
from masonry_cd.analysis.fragility.verdict import verdict_of
from masonry_cd.analysis.fragility.words import counts, first_fits, lines_of, quantities_of, spreads, warnings_of
from masonry_cd.analysis.outputs import STUDY_PAGE, numbers_in
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.quantities import counted
from reports.drawing.render import NoContext
from reports.page.document import Badge, Head, pictures, rows_of_many, script_of, write_document
from reports.study.joint_maps import draw_joint_maps
from reports.study.pictures import METHODS, cloud_picture, fragility_picture, ida_picture, spread_picture, stripes_picture, tornado_picture
from reports.study.tables import COLUMNS_OF_FITS, entry_of, row_of, write_json, write_openquake

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
MADE = ("runs.csv", "runs.parquet", "limits.csv")  # by the study itself, run by run
FILES = tuple(name for name in files_of("study") if name not in MADE)
MAPS = "probability_*.png"


@dataclass(eq=False)
class Written:
    """What has been written, and what there is to say of it."""

    pictures: list[Path] = field(default_factory=list)
    tables: list[Path] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def add(self, files: Sequence[Path], lines: Sequence[str], warnings: Sequence[str]) -> None:
        """More of them."""
        self.pictures += [path for path in files if path.suffix == ".png"]
        self.tables += [path for path in files if path.suffix != ".png"]
        self.lines += lines
        self.warnings += warnings


def write_study(folder: Path) -> dict[str, Any]:
    """Fit, draw and write all that a study's design and its runs allow; what an earlier call wrote and this one does not is removed.

    The folder holds study.json, runs.csv, and, for the maps, joints/ and reference/. What summary.json gets is returned.

    Raises:
        InputError: something in the folder is missing or broken.
    """
    study = read_study(folder)
    fits, rows = fit_study(study), correlations(study)
    own_files.begin(folder, (*FILES, MAPS), lambda _: True)  # which study.json proves, read above
    own_files.remove(folder, (*FILES, MAPS))
    out = Written(lines=lines_of(study, fits.fits, rows), warnings=[*warnings_of(study), *fits.warnings])
    _write_tables(study, fits, rows, out)
    for name, draw in diagrams(study, fits, rows).items():
        draw(folder / name)
        out.pictures.append(folder / name)
    try:
        out.add(*draw_joint_maps(study))
    except NoContext as failure:
        out.warnings.append(str(failure))
    found = verdict_of(study, fits)
    write_page(study, fits.fits, out, found)
    summary = _summary(study, fits.fits, rows, out, found)
    write_json(folder / "summary.json", summary)
    return summary


def _write_tables(study: Study, fits: Fits, rows: Sequence[Correlation], out: Written) -> None:
    """fragility.csv, .json and .xml, sensitivity.csv."""
    table, facts, nrml = (study.folder / f"fragility.{form}" for form in ("csv", "json", "xml"))
    sensitivity = study.folder / "sensitivity.csv"
    if fits.fits:
        write_csv(table, COLUMNS_OF_FITS, (row_of(fit).values() for fit in fits.fits), digits=6)
        write_json(facts, {"format": 1, "fits": [entry_of(fit) for fit in fits.fits], "warnings": list(fits.warnings)})
        out.warnings += write_openquake(nrml, str(study.asked["title"]), fits.fits)
    if rows:
        write_csv(sensitivity, COLUMNS, rows, digits=6)
    out.tables += [path for path in (table, facts, nrml, sensitivity) if path.exists()]


def diagrams(study: Study, fits: Fits, rows: Sequence[Correlation]) -> dict[str, Callable[[Path], None]]:
    """The diagrams that a study's design and its runs allow: of each its file's name, and what draws it there."""
    title, quantities = str(study.asked["title"]), quantities_of(study)
    levels = study.numbers("level")[study.done]
    in_stripes = study.asked["design"] != "ida" and len(np.unique(levels[np.isfinite(levels)])) > 1
    drawn = any(fit.runs for fit in fits.fits)
    known: list[tuple[str, bool, Callable[[Path], None]]] = [
        ("fragility.png", drawn, lambda path: fragility_picture([fit for fit in fits.fits if fit.runs], f"{title}: fragility", path)),
        ("ida.png", bool(fits.curves and quantities), lambda path: ida_picture(study, fits.curves, path)),
        ("cloud.png", bool(fits.clouds), lambda path: cloud_picture(study, fits.clouds, path)),
        ("stripes.png", in_stripes and bool(quantities), lambda path: stripes_picture(study, path)),
        ("spread.png", not drawn and not in_stripes and bool(quantities), lambda path: spread_picture(study, path)),
        ("tornado.png", bool(rows), lambda path: tornado_picture(rows, title, path)),
    ]
    return {name: draw for name, allowed, draw in known if allowed}


def _summary(study: Study, fits: Sequence[Fit], rows: Sequence[Correlation], out: Written, found: Verdict) -> dict[str, Any]:
    """What summary.json holds."""
    return {
        "format": 1,
        "verdict": found.as_dict(),
        "title": study.asked["title"],
        "design": study.asked["design"],
        "measure": study.asked["measure"],
        "runs": counts(study),
        "records": len(study.motions),
        "collapsed": int((study.collapsed & study.done).sum()),
        "fragility": [row_of(fit) | dict(fit.betas.as_dict()) for fit in first_fits(fits)],
        "spread": spreads(study),
        "sensitivity": [row._asdict() for row in rows if row.kind == "varied"],
        "files": [path.name for path in (*out.tables, *out.pictures)] + [PAGE],
        "lines": out.lines,
        "warnings": out.warnings,
    }


def write_page(study: Study, fits: Sequence[Fit], out: Written, found: Verdict) -> None:
    """Write study.html: words first, then the pictures, the fits and the runs; a run whose page is kept is linked from its row."""
    title = str(study.asked["title"])
    asked = study.asked
    varied = [counted(len(study.motions), "record")] if study.motions else []
    varied += [f"{asked['measure']} at {counted(len(asked['levels']), 'level')}"] if asked["measure"] and asked["levels"] else []
    block = rows_of_many(asked["scene"], asked.get("program", ""), ", ".join([*varied, *study.varied]) or "nothing but chance")
    notes = dict.fromkeys(fit.betas.note for fit in fits if fit.fitted and fit.betas.note)
    write_document(
        study.folder / PAGE,
        "study.html",
        title=title,
        page=Head(title, out.lines, out.warnings, _counts(study), block, found),
        drawn=pictures({path: CAPTIONS.get(path.name, "How often each joint opened at this level.") for path in out.pictures}),
        measure=fits[0].measure if fits else "",
        fits=[_fit(fit) for fit in fits],
        on_beta="; ".join(notes),
        runs=_runs(study),
        printed=PRINTED,
        settings=[*words.settings(study).items()],
        script=script_of("reports.study", "study.js"),
    )


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


def _runs(study: Study) -> dict[str, Any]:
    """The table of runs: its columns, its first rows, which are numbers, and how many rows there are."""
    shown = [*FIRST[:4], *study.varied, *([study.asked["measure"]] if study.asked["measure"] else [])]
    shown += [name for name in RESULTS if name in study.columns] + ["status", "reason"]
    shown = [name for name in dict.fromkeys(shown) if any(_raw(study, name, k) for k in range(study.count))]
    rows = [[_cell(study, name, k) for name in shown] for k in range(min(study.count, ROWS))]
    numbers = [k for k, name in enumerate(shown) if not isinstance(study.columns[name], list)]
    return {"columns": [name.replace("_", " ") for name in shown], "rows": rows, "numbers": numbers, "count": study.count}


def _raw(study: Study, name: str, row: int) -> str:
    """A cell as text, empty where there is nothing."""
    column = study.columns[name]
    if isinstance(column, list):
        return column[row]
    return "" if math.isnan(column[row]) else repr(float(column[row]))


def _cell(study: Study, name: str, row: int) -> str | Badge:
    """A cell of the table of runs; a run whose page is kept has its address."""
    raw, address = _raw(study, name, row), f"runs/{_raw(study, 'run', row)}/report.html"
    if name == "run" and re.fullmatch(r"[\w.-]+", raw) and (study.folder / address).exists():
        return Badge("", raw, address)
    return f"{float(raw):.4g}" if raw and not isinstance(study.columns[name], list) else raw


def _number(value: float | None, digits: int | None = None) -> str:
    """Three digits, or so many after the point; empty where there is none."""
    if value is None or not math.isfinite(value):
        return "" if value is None or math.isnan(value) else "∞"
    return f"{value:.3g}" if digits is None else f"{value:.{digits}f}"


def _range(two: tuple[float, float], digits: int | None = None) -> str:
    return " to ".join(_number(value, digits) for value in two) if not math.isnan(two[0]) else ""
