# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a set of records: its spectra, their mean and scatter, the target, and the 90 % of EN 1998-1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_cd.analysis.accelerogram_rule import SHARE
from masonry_cd.foundation import libm
from masonry_cd.studies.selection.candidates import ChosenSet
from masonry_cd.studies.selection.tables import Selection, TargetTable
from reports.drawing.figure import INK, format_axes, save
from reports.drawing.plots import PALE, add_legend, colour, logarithmic, sheet

BAND = "#f2f4f6"


def draw(selection: Selection, made: ChosenSet, path: Path) -> Path:
    """Draw a set, and where a standard deviation is required, how it has it; return the path."""
    target, rule = selection.tables.target, made.rule
    facts = (
        f"{len(made.members)} of {made.pool} motions, Sa ({target.of}) for 5 % damping\n"
        f"EN 1998-1, 3.2.3.1.2(4) {'holds' if all(rule.holds) else 'does not hold'}: mean of Sa over target {rule.least:.2f} "
        f"at {rule.at:.3g} s, where it is least, and {rule.rigid:.2f} at period zero"
    )
    panels = 1 + (target.sigma is not None)
    figure, axes = sheet(selection.title, facts, panels, (9.6, 6.6) if panels == 1 else (13.6, 6.6))
    _draw_spectra(axes[0], target, made)
    if target.sigma is not None:
        _draw_scatter(axes[1], target, made)
    for one in axes:
        one.set(xscale="log", xlim=made.grid.periods[[1, -1]])
        one.set_xlabel("period [s]")
        logarithmic(one.xaxis)
    return save(figure, path, selection.title)


def _draw_spectra(axes: Any, target: TargetTable, made: ChosenSet) -> None:
    """All spectra over the period."""
    t, goal, d = made.grid.periods, made.grid.target, made.differences
    axes.axvspan(*target.band, color=BAND, zorder=0, label="periods compared")
    for k, spectrum in enumerate(made.spectra):
        axes.plot(t[1:], spectrum[1:], color=PALE, linewidth=0.8, label="" if k else "records, scaled")
    for sign in (-1.0, 1.0) if len(d) > 1 else ():
        edge = goal * libm.exp(d.mean(axis=0) + sign * d.std(axis=0, ddof=1))
        label = "mean of ln Sa ± standard deviation" if sign > 0.0 else ""
        axes.plot(t[1:], edge[1:], color=colour(0), linewidth=1.1, linestyle=(0, (4, 3)), label=label)
    axes.plot(t[1:], (goal * libm.exp(d.mean(axis=0)))[1:], color=colour(0), linewidth=2.0, label="mean of ln Sa")
    axes.plot(t[1:], made.spectra.mean(axis=0)[1:], color=colour(1), linewidth=1.4, label="mean of Sa")
    axes.plot(t[1:], goal[1:], color=INK, linewidth=2.2, label="target")
    at = made.grid.judged[1:]
    axes.plot(t[at], SHARE * goal[at], color=INK, linewidth=1.2, linestyle=":", label=f"{100 * SHARE:g} % of the target")
    axes.set(yscale="log")
    format_axes(axes, "Sa [m/s²]")
    logarithmic(axes.yaxis)
    add_legend(axes, 3)


def _draw_scatter(axes: Any, target: TargetTable, made: ChosenSet) -> None:
    """The standard deviation of ln Sa over the period."""
    compared = made.grid.periods[made.grid.compared]
    axes.axvspan(*target.band, color=BAND, zorder=0)
    axes.plot(made.grid.periods[1:], made.differences.std(axis=0, ddof=1)[1:], color=colour(0), linewidth=2.0, label="of the set")
    axes.plot(compared, target.deviations(compared), color=INK, linewidth=2.2, label="required")
    axes.set_ylim(bottom=0.0)
    format_axes(axes, "standard deviation of ln Sa")
    add_legend(axes, 2)
