# SPDX-License-Identifier: GPL-3.0-or-later
"""The factor of a vehicle over where it stands on a bridge."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reports.drawing.figure import INK, blank, plain_axes, save

LINE, WORST, SPAN = "#20506f", "#b3261e", "#e9e4d8"
SHOWN = 4.0  # times the least factor: the plot ends there
DPI = 150


def crossing_picture(position: np.ndarray, factor: np.ndarray, spans: Sequence[tuple[float, float]], path: Path, title: str) -> None:
    """Draw an envelope into a PNG.

    Args:
        position: (M,) of the first axle along the road [m].
        factor: (M,), inf where any multiple is borne.
        spans: where arches begin and end along the road [m].
        path: of the PNG.
        title: above the plot.

    Raises:
        InputError: the file cannot be written.
    """
    figure = blank((8.0, 4.0), DPI, layout="constrained")
    axes = figure.add_subplot()
    for k, (low, high) in enumerate(spans):
        axes.axvspan(low, high, color=SPAN, lw=0)
        axes.annotate(f"span {k + 1}", (0.5 * (low + high), 0.02), xycoords=("data", "axes fraction"), ha="center", color="#6d675a")
    worst = int(np.argmin(factor))
    axes.plot(position, np.where(np.isfinite(factor), factor, np.nan), color=LINE, marker=".", ms=4)
    if np.isfinite(factor[worst]):
        axes.plot(position[worst], factor[worst], "o", color=WORST)
        place = position[worst], factor[worst]
        axes.annotate(f"{place[1]:.4g} at {place[0]:.4g} m", place, (6, -14), textcoords="offset points", color=WORST)
        axes.set_ylim(0.0, SHOWN * factor[worst])
    plain_axes(axes, "load factor", "first axle along the road [m]", grid="y")
    axes.set_title(title, color=INK, fontsize=11, loc="left", parse_math=False)
    save(figure, path, title)
