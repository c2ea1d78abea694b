# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a posterior: unknowns before and after, every two of them, and the observations next to what is predicted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.calibration.posterior import Posterior
from reports.drawing.figure import INK, format_axes, save
from reports.drawing.plots import PALE, colour, sheet

PICTURE = "calibrate.png"
MOST = 5  # unknowns that are drawn: those that were narrowed most
BINS = 14
CELL, ASIDE, ROW = 2.6, 2, 0.34  # [inches] of a cell, how many the observations take next to them, and [inches] of one of these
SPOT = 160.0  # area of the weightiest sample [points2]


def draw_posterior(found: Posterior, path: Path) -> None:
    """Draw a posterior."""
    names = sorted(found.numbers, key=lambda name: found.ranges[name]["std"] / (np.std(found.numbers[name]) or 1.0))[:MOST]
    names = [name for name in found.numbers if name in names]
    d, across = len(names), len(names) + ASIDE
    size = (1.2 + CELL * across, max(1.2 + CELL * d, 2.2 + ROW * len(found.observations)))
    facts = f"{len(found.weights)} samples, {found.sizes[-1]:.3g} effective; grey: before, blue: after; verdict: {found.verdict.words}"
    figure, cells = sheet(f"{found.title}: what explains the observations", facts, d * across, size, d)
    grid = cells[0].get_gridspec()
    for i, name in enumerate(names):
        for j in range(across):
            axes = cells[across * i + j]
            if j > i:
                axes.remove()
            elif j == i:
                _draw_before_and_after(axes, found, name)
            else:
                _draw_pair(axes, found, names[j], name)
            if j <= i:
                unit, _ = found.shown(names[j])
                axes.set_xlabel(f"{names[j]}{f' [{unit}]' if unit else ''}" if i == d - 1 else "", fontsize=9)
                axes.set_ylabel(name if j == 0 and i > 0 else "", fontsize=9)
                axes.tick_params(labelsize=8)
                axes.locator_params(nbins=4)
    _draw_observations(figure.add_subplot(grid[:, d:]), found)
    save(figure, path)


def _draw_before_and_after(axes: Any, found: Posterior, name: str) -> None:
    """Draw the histograms of an unknown, and its range."""
    values, one, (_, factor) = _scaled(found, name), found.ranges[name], found.shown(name)
    for w, look in ((found.prior, {"color": PALE}), (found.weights, {"color": colour(0), "alpha": 0.75})):
        axes.hist(values, BINS, range=(values.min(), values.max()), weights=w, density=True, **look)
    for key, style in (("low", ":"), ("median", "-"), ("high", ":")):
        axes.axvline(factor * one[key], color=INK, linestyle=style, linewidth=1.0)
    axes.set_yticks([])


def _draw_pair(axes: Any, found: Posterior, across: str, up: str) -> None:
    """Draw the samples of two unknowns."""
    x, y = _scaled(found, across), _scaled(found, up)
    axes.plot(x, y, ".", color=PALE, markersize=2.0, zorder=1)
    axes.scatter(x, y, SPOT * found.weights / found.weights.max(), color=colour(0), alpha=0.45, linewidths=0.0, zorder=2)


def _scaled(found: Posterior, name: str) -> np.ndarray:
    """An unknown in the unit in which it is read, (N,)."""
    return found.shown(name)[1] * found.numbers[name]


def _draw_observations(axes: Any, found: Posterior) -> None:
    """Draw each observation in standard deviations of its error, from its value, or else from its median prediction."""
    format_axes(axes, "", "distance from what was observed [std of error]")
    for row, one in enumerate(found.checks):
        middle = float(one["median"] if one["value"] is None else one["value"])
        ends = {key: (one[key] - middle) / one["error"] for key in ("low", "median", "high", "prior_low", "prior_high")}
        axes.plot([ends["prior_low"], ends["prior_high"]], [row, row], color=PALE, linewidth=7, solid_capstyle="butt")
        axes.plot([ends["low"], ends["high"]], [row, row], color=colour(0), linewidth=4, solid_capstyle="butt")
        if one["value"] is not None:
            axes.errorbar(0.0, row, xerr=1.0, fmt="D", color=INK, markersize=4.5, linewidth=1.0, capsize=2)
    axes.set_yticks(range(len(found.checks)), [one["name"] for one in found.checks], fontsize=9)
    axes.set_ylim(len(found.checks) - 0.4, -0.6)
