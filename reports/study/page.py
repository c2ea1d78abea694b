"""study.html: the whole study on one page that needs nothing else; words first, then the pictures, the fits and the runs.

A run whose page is kept (runs/ID/report.html) is linked from its row.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.folder import FIRST, Study
from masonry_cd.analysis.fragility.measures import unit
from reports.page.document import filled, header, plain_style, write_document
from reports.page.document import pictures as in_page
from reports.page.words import escaped
from reports.study import words
from reports.study.fragility_picture import METHODS

PAGE = "study.html"
ROWS = 3000  # of the table of runs; all are in runs.csv
PRINTED = 40
RESULTS = (
    "max_opening",
    "max_sliding",
    "displacement_max",
    "drift",
    "collapsed_blocks",
    "collapse_time",
    "grade",
    "steps_missed",
    "error_max",
)
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


def write_page(study: Study, fits: Sequence[Fit], pictures: Sequence[Path], lines: Sequence[str], warnings: Sequence[str]) -> None:
    """Write study.html.

    Raises:
        InputError: it cannot be written.
    """
    here = files("reports.study")
    shown = {path: CAPTIONS.get(path.name, "How often each joint opened at this level.") for path in pictures}
    values = {
        "header": header(study.asked["title"], lines, warnings, _counts(study)),
        "pictures": in_page(shown),
        "fits": _fits(fits),
        "runs": _runs(study),
        "settings": _settings(study),
    }
    style = plain_style() + (here / "study.css").read_text(encoding="utf-8")
    script = (here / "study.js").read_text(encoding="utf-8")
    body = filled((here / "study.html").read_text(encoding="utf-8"), values)
    write_document(study.folder / PAGE, study.asked["title"], body, style, script)


def _counts(study: Study) -> list[tuple[str, object]]:
    """The counts."""
    found = words.counts(study)
    return [
        ("runs done", found["done"]),
        ("records", len(study.motions)),
        ("failed or timed out", (found["failed"] or 0) + (found["timeout"] or 0)),
        ("runs in which blocks fell", int((study.collapsed & study.done).sum())),
    ]


def _fits(fits: Sequence[Fit]) -> str:
    """The table of fits."""
    if not fits:
        return ""
    heads = (
        "limit state",
        "exceeded where",
        "method",
        "median",
        "95 %",
        "beta",
        "95 %",
        "beta of records",
        "beta of the model",
        "exceeded",
    )
    rows = []
    for fit in fits:
        of = "records" if fit.method == "ida" else "runs"
        cells = [
            fit.limit.in_words(),
            METHODS[fit.method],
            f"{_number(fit.theta)} {unit(fit.measure)}" if fit.fitted else "no fit",
            _range(fit.theta_band),
            _number(fit.beta, 2),
            _range(fit.beta_band, 2),
            _number(fit.betas.record, 2),
            _number(fit.betas.model, 2),
            f"{fit.exceeded} of {fit.runs} {of}",
        ]
        rows.append(f'<tr><th scope="row">{escaped(fit.limit.name)}</th>{"".join(f"<td>{escaped(cell)}</td>" for cell in cells)}</tr>')
    head = "".join(f'<th scope="col">{escaped(text)}</th>' for text in heads)
    notes = dict.fromkeys(fit.betas.note for fit in fits if fit.fitted and fit.betas.note)
    return (
        f'<section aria-labelledby="fits-title"><h2 id="fits-title">Fragilities over {escaped(fits[0].measure)}</h2><div class="scroll">'
        f'<table id="fits"><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
        f'<p class="hint">Lognormal: P = &Phi;(ln(IM / median) / beta). On beta: {escaped("; ".join(notes))}.</p></section>'
    )


def _runs(study: Study) -> str:
    """The table of runs."""
    if not study.count:
        return ""
    shown = [*FIRST[:4], *study.varied, *([study.asked["measure"]] if study.asked["measure"] else [])]
    shown += [name for name in RESULTS if name in study.columns] + ["status", "reason"]
    shown = [name for name in dict.fromkeys(shown) if any(_raw(study, name, k) for k in range(study.count))]
    head = "".join(
        f'<th scope="col" aria-sort="none"><button type="button">{escaped(name.replace("_", " "))}</button></th>' for name in shown
    )
    rows = [f"<tr>{''.join(_cell(study, name, k) for name in shown)}</tr>" for k in range(min(study.count, ROWS))]
    more = f" The first {ROWS} of {study.count}; all are in runs.csv." if study.count > ROWS else ""
    return (
        f'<section aria-labelledby="runs-title"><h2 id="runs-title">Runs</h2><p class="hint">Lengths in m; a heading sorts.{more}</p>'
        f'<div class="scroll tall"><table id="runs"><caption class="hidden">Runs; headings sort</caption><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
        + (f'<p class="more">Printed: the first {PRINTED} of {study.count} rows.</p></section>' if study.count > PRINTED else "</section>")
    )


def _raw(study: Study, name: str, row: int) -> str:
    """A cell as text, empty where there is nothing."""
    column = study.columns[name]
    if isinstance(column, list):
        return column[row]
    return "" if math.isnan(column[row]) else repr(float(column[row]))


def _cell(study: Study, name: str, row: int) -> str:
    """A cell of the table of runs."""
    raw = _raw(study, name, row)
    if name == "run":
        address = f"runs/{raw}/report.html"
        known = re.fullmatch(r"[\w.-]+", raw) and (study.folder / address).exists()
        return f'<td><a href="{address}">{escaped(raw)}</a></td>' if known else f"<td>{escaped(raw)}</td>"
    if isinstance(study.columns[name], list):
        return f"<td>{escaped(raw)}</td>"
    return f'<td class="number" data-value="{raw}">{escaped(f"{float(raw):.4g}" if raw else "")}</td>'


def _settings(study: Study) -> str:
    rows = "".join(f"<dt>{escaped(name)}</dt><dd>{escaped(value)}</dd>" for name, value in words.settings(study).items())
    return f"<section><dl>{rows}</dl></section>"


def _number(value: float | None, digits: int | None = None) -> str:
    """Three digits, or so many after the point; empty where there is none."""
    if value is None or not math.isfinite(value):
        return "" if value is None or math.isnan(value) else "∞"
    return f"{value:.3g}" if digits is None else f"{value:.{digits}f}"


def _range(two: tuple[float, float], digits: int | None = None) -> str:
    return " to ".join(_number(value, digits) for value in two) if not math.isnan(two[0]) else ""
