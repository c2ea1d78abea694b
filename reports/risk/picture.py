# SPDX-License-Identifier: GPL-3.0-or-later
"""The hazard of a site as a curve, with the accelerations that are required and borne."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reports.drawing.figure import COLOURS, FAINT, INK, halo, save
from reports.drawing.plots import MARKERS, logarithmic, sheet

SIZE = (8.2, 4.2)


def draw_hazard(hazard: Mapping[str, Any], marks: Sequence[tuple[str, float, float]], path: Path, title: str) -> Path:
    """Draw return periods over accelerations with marked points into a PNG, SVG or PDF; return its path.

    Args:
        hazard: as limit.json has it: intensity [m/s2] and frequency [1/year] of its rows.
        marks: words, acceleration [m/s2] and return period [years] of each point.
        path: of the picture.
        title: of the picture.

    Raises:
        InputError: matplotlib is not installed, or a path that cannot be written.
    """
    figure, (axes,) = sheet(title, f"hazard of the site, {hazard['measure']} on rock", 1, SIZE)
    axes.loglog(hazard["intensity"], 1.0 / np.array(hazard["frequency"]), "-o", color=FAINT, linewidth=1.6, markersize=3.5)
    for k, (words, intensity, years) in enumerate(marks):
        colour = COLOURS[(1, 2, 0)[k % 3]]
        axes.plot(2 * [intensity], [axes.get_ylim()[0], years], ":", color=colour, linewidth=1.0)
        axes.plot(intensity, years, MARKERS[k], color=colour, markersize=8, markeredgecolor="white", zorder=5)
        axes.annotate(
            f"{words}: {intensity:.4g} m/s², {years:.4g} years", (intensity, years), (-10, 6 - 12 * (k % 2)), textcoords="offset points",
            ha="right", fontsize=9.5, color=colour, fontweight="bold", path_effects=halo(), zorder=6,
        )  # fmt: skip
    axes.set_xlabel("peak acceleration on rock [m/s²]", fontsize=11, color=INK)
    axes.set_ylabel("return period [years]", fontsize=11, color=INK)
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    return save(figure, path, title)
