# SPDX-License-Identifier: GPL-3.0-or-later
"""Fragility curves with what they were fitted to, and their bands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.bootstrap import bands
from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.fragility import by_level
from masonry_cd.analysis.fragility.measures import label, with_unit
from masonry_cd.analysis.fragility.words import ORDER
from reports.drawing.figure import FAINT, plain_axes, save
from reports.study.plots import MARKERS, colour, halo, legend, sheet

METHODS = {
    "mle": "maximum likelihood on counts per level",
    "probit": "probit on each run's own intensity",
    "cloud": "regression of the cloud",
    "ida": "capacities of the records",
}
BEYOND = {"mle": (0, (6, 2)), "ida": (0, (6, 2)), "cloud": (0, (6, 2)), "probit": (0, (2, 2))}  # strokes of further methods
GRID = 240
BINS = 8  # of runs whose intensities are their own
LABELLED = 2  # limit states whose points have their counts written to them


def fragility_picture(fits: Sequence[Fit], title: str, path: Path) -> None:
    """Draw the fragilities of all limit states over one measure.

    Raises:
        InputError: the file cannot be written.
    """
    limits = list(dict.fromkeys(fit.limit for fit in fits))
    figure, (axes,) = sheet(title, _facts(fits), size=(8.4, 5.4 + 0.23 * len([fit for fit in fits if fit.fitted])))
    top = 1.06 * max(float(fit.intensity.max(initial=0.0)) for fit in fits)
    grid = np.linspace(0.0, top, GRID + 1)[1:]
    for k, limit in enumerate(limits):
        own = sorted((fit for fit in fits if fit.limit == limit), key=lambda fit: ORDER.index(fit.method))
        _points(axes, own[0], k, counts=len(limits) <= LABELLED)
        drawn = [fit for fit in own if fit.fitted]
        for place, fit in enumerate(drawn):
            _curve(axes, fit, k, grid, main=place == 0)
        if not drawn:
            axes.plot([], [], MARKERS[k % len(MARKERS)], color=colour(k), markerfacecolor="white", label=f"{limit.name}: no fit")
    axes.set_xlim(0.0, top)
    axes.set_ylim(-0.02, 1.04)
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    plain_axes(axes, "probability that a limit state is exceeded", label(fits[0].measure))
    legend(axes)
    save(figure, path)


def _facts(fits: Sequence[Fit]) -> str:
    """What points and bands are."""
    methods = {fit.method for fit in fits}
    points = (
        "points: share of the runs of a level"
        if "mle" in methods
        else "steps: capacities of the records"
        if "ida" in methods
        else "points: share of the runs in eighths of them, by intensity"
    )
    return f"{points}; bands: 95 %, bootstrap over records"


def _curve(axes: Any, fit: Fit, k: int, grid: np.ndarray, main: bool) -> None:
    """A fitted curve; the first method of a limit state with its band."""
    words = f"{fit.limit.name}: median {with_unit(fit.theta, fit.measure)}, beta {fit.beta:.2f}, {METHODS[fit.method]}"
    if main:
        low, high = bands(fit.replicated.probability(grid))
        axes.fill_between(grid, low, high, color=colour(k), alpha=0.16, linewidth=0, zorder=1)
    stroke: Any = "-" if main else BEYOND[fit.method]
    axes.plot(
        grid, fit.curve.probability(grid)[0], color=colour(k), linewidth=2.2 if main else 1.3, linestyle=stroke, label=words, zorder=3
    )


def _points(axes: Any, fit: Fit, k: int, counts: bool) -> None:
    """What the curve was fitted to."""
    if not fit.runs:
        return
    look: dict[str, Any] = {"color": colour(k), "markerfacecolor": "white", "markeredgewidth": 1.6, "markersize": 6.5, "zorder": 4}
    if fit.found is not None:
        reached = np.sort(fit.found.intensity[~fit.found.above])
        share = np.arange(1, len(reached) + 1) / fit.runs
        axes.step(np.concatenate([[0.0], reached]), np.concatenate([[0.0], share]), where="post", color=colour(k), linewidth=1.0, zorder=2)
        return
    if fit.method == "mle":
        levels, exceeded, runs = by_level(fit.intensity, fit.over, np.ones((1, len(fit.over))))
        level, share, over, of = levels, exceeded[0] / runs[0], exceeded[0], runs[0]
    else:
        parts = np.array_split(np.argsort(fit.intensity, kind="stable"), min(BINS, fit.runs))
        level = np.array([np.exp(np.log(fit.intensity[rows]).mean()) for rows in parts])
        over, of = np.array([fit.over[rows].sum() for rows in parts]), np.array([len(rows) for rows in parts])
        share = over / of
    axes.plot(level, share, MARKERS[k % len(MARKERS)], **look)
    if counts and len(level) <= 14:
        for x, y, some, total in zip(level, share, over, of, strict=True):
            axes.annotate(
                f"{some:.0f}/{total:.0f}", (x, y), (0, -14 if y > 0.5 else 9), textcoords="offset points", fontsize=8, color=FAINT,
                ha="center", path_effects=halo(), zorder=5,
            )  # fmt: skip
