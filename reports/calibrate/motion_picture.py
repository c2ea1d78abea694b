# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of an unknown motion: its likelihood over two of its numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_cd.analysis.calibration.motion_map import SHARES, MotionMap
from masonry_cd.analysis.calibration.posterior import Posterior
from reports.calibrate.picture import SPOT
from reports.drawing.figure import INK, format_axes, save
from reports.drawing.plots import colour, sheet

MAP = "motion.png"
LEVELS = np.linspace(0.0, 1.0, 11)


def draw_motion_likelihood(found: Posterior, of: MotionMap, path: Path) -> None:
    """Draw the likelihood of a motion, the regions of the posterior, and the samples."""
    from matplotlib.colors import LinearSegmentedColormap

    facts = f"{len(found.weights)} samples, {found.sizes[-1]:.3g} effective; verdict: {found.verdict.words}"
    figure, (axes,) = sheet(f"{found.title}: likelihood of the motion", facts)
    (unit_x, x), (unit_y, y) = (found.shown(name) for name in of.names)
    shades = LinearSegmentedColormap.from_list("likelihood", ["#f2f4f6", colour(0)])
    filled = axes.contourf(x * of.across, y * of.up, of.likelihood, LEVELS, cmap=shades)
    figure.colorbar(filled, ax=axes, label="likelihood over its largest value", ticks=LEVELS[::2])
    lines = axes.contour(x * of.across, y * of.up, of.density, sorted(of.levels), colors=INK, linewidths=1.1)
    words = {level: f"{100 * share:.0f} %" for level, share in zip(of.levels, SHARES, strict=True)}
    axes.clabel(lines, fmt=words, fontsize=9)
    places = (x * found.numbers[of.names[0]], y * found.numbers[of.names[1]])
    axes.scatter(*places, 1.0 + SPOT * found.weights / found.weights.max(), color=INK, alpha=0.35, linewidths=0.0)
    likeliest = of.likeliest
    axes.plot(x * likeliest[of.names[0]], y * likeliest[of.names[1]], "x", color=INK, markersize=9.0, markeredgewidth=2.0)
    across, up = (f"{name}{f' [{unit}]' if unit else ''}" for name, unit in zip(of.names, (unit_x, unit_y), strict=True))
    format_axes(axes, up, across)
    save(figure, path)
