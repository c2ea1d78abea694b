# SPDX-License-Identifier: GPL-3.0-or-later
"""A study in words: its closing lines, which the command prints and the page begins with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.verdict import ENOUGH
from masonry_cd.analysis.fragility.bootstrap import LEVEL
from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.folder import Study
from masonry_cd.analysis.fragility.measures import with_unit
from masonry_cd.analysis.fragility.sensitivity import SIGNIFICANT, Correlation
from masonry_cd.analysis.fragility.verdict import FEW_RECORDS
from masonry_cd.analysis.outputs import NUMBERS, STUDY_PAGE, lengths_in
from masonry_cd.analysis.verdict import NOT_GRADED

ORDER = ("mle", "ida", "cloud", "probit")  # the first of these that a limit state has speaks for it
PANELS = 3  # quantities looked at, as many as pictures have side by side
GENERAL = tuple(lengths_in(STUDY_PAGE))  # drawn where the limit states look at none that is continuous
NAMED = 3  # of what varied, in the line on what matters


def quantity(column: str) -> tuple[str, float]:
    """How an axis names a column, with its unit, and the factor into that unit."""
    part, _, name = column.rpartition(".")
    known, where = NUMBERS.get(name or column), f" of {part}" if part else ""
    if known is None:
        return f"{name or column}{where}", 1.0
    unit, factor = known.shown
    return f"{known.name}{where}{f' [{unit}]' if unit else ''}", factor


def quantities_of(study: Study) -> list[str]:
    """Columns worth a panel: those of continuous limit states, else what every run has; as many as fit."""
    asked = dict.fromkeys(limit.column for limit in study.limit_states if limit.continuous)
    drawn = [name for name in (asked or GENERAL) if np.isfinite(study.numbers(name)[study.done]).any()]
    return drawn[:PANELS]


def first_fits(fits: Sequence[Fit]) -> list[Fit]:
    """One fit per limit state, by the method that its data suit best, of those that have one."""
    out = []
    for limit in dict.fromkeys(fit.limit for fit in fits):
        own = [fit for fit in fits if fit.limit == limit and fit.fitted]
        out += sorted(own, key=lambda fit: ORDER.index(fit.method))[:1]
    return out


def counts(study: Study) -> dict[str, int | None]:
    """Runs by their state."""
    words = study.text("status")
    return {"planned": study.asked["runs"], "rows": study.count} | {state: words.count(state) for state in ("done", "failed", "timeout")}


def spreads(study: Study) -> dict[str, dict[str, float]]:
    """Median and quartiles of each quantity over the runs that are done."""
    columns = dict.fromkeys([*quantities_of(study), *(limit.column for limit in study.limit_states)])
    out = {}
    for column in columns:
        values = study.numbers(column)[study.done]
        values = values[np.isfinite(values)]
        if len(values):
            low, middle, high = (float(value) for value in np.percentile(values, [25.0, 50.0, 75.0]))
            out[column] = {"median": middle, "quartile_low": low, "quartile_high": high, "runs": len(values)}
    return out


def lines_of(study: Study, fits: Sequence[Fit], rows: Sequence[Correlation]) -> list[str]:
    """The closing lines."""
    out = [_first(study)]
    chosen = first_fits(fits)
    out += [fit_line(fit) for fit in chosen]
    if not chosen:
        out += [_spread_line(column, found) for column, found in spreads(study).items() if not column.endswith("grade_number")]
    return out + _matters(rows)


def _first(study: Study) -> str:
    """How many runs there are."""
    found = counts(study)
    other = [f"{found[state]} {words}" for state, words in (("failed", "failed"), ("timeout", "timed out")) if found[state]]
    planned = f" of {found['planned']}" if found["planned"] not in (None, found["done"]) else ""
    records = f" under {len(study.motions)} records" if study.motions else ""
    fell = int((study.collapsed & study.done).sum())
    some = f"; blocks fell in {fell}" if fell else ""
    return f"{study.asked['title']}: {found['done']}{planned} runs done{records}{''.join(f', {word}' for word in other)}{some}"


def fit_line(fit: Fit) -> str:
    """``collapse: median PGA 2.4 m/s² (95 %: 2.2 to 2.7), beta 0.43 (0.31 to 0.52), 45 of 320 runs exceed it``"""
    low, high = fit.theta_band
    found = f"{low:.3g} to {with_unit(high, fit.measure)}" if np.isfinite(high) else f"from {low:.3g} on, without an upper bound"
    of = "records reach" if fit.method == "ida" else "runs exceed"
    text = (
        f"{fit.limit.name}: median {fit.measure} {with_unit(fit.theta, fit.measure)} ({100 * LEVEL:.0f} %: {found}), "
        f"beta {fit.beta:.2f} ({fit.beta_band[0]:.2f} to {fit.beta_band[1]:.2f}), {fit.exceeded} of {fit.runs} {of} it"
    )
    parts = [f"{name} {value:.2f}" for name, value in (("records", fit.betas.record), ("model", fit.betas.model)) if value is not None]
    return text + (f"; of this beta {', '.join(parts)}" if len(parts) == 2 else "")


def _spread_line(column: str, found: Mapping[str, float]) -> str:
    """``largest opening: median 50.1 mm, quartiles 45.2 to 53 mm, over 50 runs``"""
    words, factor = quantity(column)
    name, _, rest = words.partition(" [")
    low, middle, high = (factor * found[key] for key in ("quartile_low", "median", "quartile_high"))
    suffix = f" {rest.rstrip(']')}" if rest else ""
    return f"{name}: median {middle:.3g}{suffix}, quartiles {low:.3g} to {high:.3g}{suffix}, over {found['runs']} runs"


def _matters(rows: Sequence[Correlation]) -> list[str]:
    """Which of what varied goes with which quantity, by the correlation that the intensity does not hide."""
    out = []
    for column in dict.fromkeys(row.quantity for row in rows):
        own = [row for row in rows if row.quantity == column and row.kind == "varied"]
        clear = [row for row in own if row.p < SIGNIFICANT and row.low * row.high > 0]
        name = quantity(column)[0].split(" [")[0]
        if clear:
            found = ", ".join(f"{row.variable} ({row.rho:+.2f})" for row in clear[:NAMED])
            out.append(f"{name} goes with {found}, by rank correlation")
        elif own:
            out.append(f"{name} goes with nothing that varied clearly enough to show in these runs")
    return out


def warnings_of(study: Study) -> list[str]:
    """On the runs themselves."""
    found, out = counts(study), []
    lost = (found["failed"] or 0) + (found["timeout"] or 0)
    if lost:
        out.append(f"{lost} of {study.count} runs failed or timed out: they are no data, and where they are the strongest, fits are biased")
    if not found["done"]:
        out.append("no run is done: there is nothing to fit")
    if study.asked["measure"] and 0 < len(study.motions) < FEW_RECORDS:
        out.append(f"{len(study.motions)} records are few: with less than {FEW_RECORDS} the bands are too narrow")
    missed = study.numbers("steps_missed")[study.done]
    some = int((missed > 0).sum())
    if some:
        out.append(f"{some} of {found['done']} runs missed the solver's tolerance in some steps")
    short = int((study.numbers("loads_acted")[study.done] < ENOUGH).sum())
    if short:
        out.append(f"{short} of {found['done']} runs ended before {100 * ENOUGH:g} % of a load had acted: run.duration is too short")
    ungraded = study.text("grade").count(NOT_GRADED) if "grade" in study.columns else 0
    if ungraded:
        out.append(f"{ungraded} of {found['done']} runs cannot be relied on and are {NOT_GRADED}: fits by grade leave them out")
    return out


def settings(study: Study) -> dict[str, Any]:
    """What was asked, for the page."""
    asked = study.asked
    return {
        "design": asked["design"],
        "scene": asked["scene"],
        "seed": asked["seed"],
        "intensity measure": asked["measure"] or "none",
        "levels": ", ".join(f"{level:g}" for level in asked["levels"]) if asked["levels"] else "none",
        "varied": ", ".join(study.varied) or "nothing in the scene",
        "records": str(len(study.motions)) if study.motions else "none",
        **{f"limit state {limit.name}": limit.in_words() for limit in study.limit_states},
    }
