# SPDX-License-Identifier: GPL-3.0-or-later
"""The spectra of a code check, of the ground and at the height of the mechanism, with what is required and what is borne."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.code_check.verdicts import LINEAR, CheckSpectrum
from masonry_cd.foundation.quantities import per_cent
from reports.drawing.figure import COLOURS, FAINT, INK, halo, save
from reports.drawing.plots import add_legend, sheet

UNITS = {"m": (1e3, "mm"), "m/s2": (1.0, "m/s²")}  # of a check: by which its values are drawn, and the name
GROUND, FLOOR, BORNE = FAINT, COLOURS[0], COLOURS[2]
ASKED = COLOURS[1]
ROOM = 1.25  # over the largest value, where an axis ends
OFFSET, APART = 9, 7  # of words from their point, along and up or down [points]
LOW = 0.08  # share of an axis below which a point is near its end
SAME = 1e-3  # share by which a demand may exceed the curve and lie on it


def draw_spectra(spectra: Sequence[CheckSpectrum], path: Path, title: str, facts: str) -> Path:
    """Draw the spectrum of each check with the points of demand and capacity into a PNG, SVG or PDF; return its path.

    Raises:
        InputError: matplotlib is not installed, or a path that cannot be written.
    """
    figure, panels = sheet(title, facts, len(spectra), (12.0, 5.4) if len(spectra) > 1 else (8.2, 5.4))
    for axes, spectrum in zip(panels, spectra, strict=True):
        _draw_panel(axes, spectrum)
    return save(figure, path, title)


def _draw_panel(axes: Any, spectrum: CheckSpectrum) -> None:
    """One check."""
    check, (scale, unit) = spectrum.check, UNITS[spectrum.check.unit]
    damped = per_cent(check.damping)
    axes.plot(spectrum.period, scale * spectrum.ground, color=GROUND, linewidth=1.4, label=f"ground, damping {damped}")
    if spectrum.raised is not None:
        axes.plot(spectrum.period, scale * spectrum.raised, color=FLOOR, linewidth=2.0, label="required at the height of the mechanism")
    if check.q != 1.0:
        axes.plot(
            spectrum.period, scale * spectrum.asked / check.q, color=ASKED, linewidth=1.1, linestyle="--", label=f"over q = {check.q:g}"
        )
    if check.demand > (1.0 + SAME) * spectrum.asked[np.searchsorted(spectrum.period, check.period)]:
        first = spectrum.period[spectrum.largest]
        axes.plot([first, check.period], 2 * [scale * check.demand], color=ASKED, linewidth=1.1, linestyle=":", label="the largest up to T")
    top = ROOM * scale * max(float(np.max(spectrum.asked)), check.demand, check.capacity)
    low, high = sorted((check.demand, check.capacity))
    sunk = APART if scale * low < LOW * top else 0.0  # words below the lower point would lie on the axis
    for value, colour, marker, words in ((check.demand, ASKED, "s", "required"), (check.capacity, BORNE, "o", "borne")):
        up = sunk + (APART if value == high else -APART)
        _draw_point(axes, (check.period, scale * value), (colour, marker), f"{words}: {scale * value:.4g} {unit}", up)
    if check.period > 0.0:
        axes.axvline(check.period, color=FAINT, linewidth=0.8, linestyle=":", zorder=1)
        axes.annotate(
            f"T = {check.period:.3g} s", (check.period, 1.0), (4, -4), xycoords=("data", "axes fraction"), textcoords="offset points",
            va="top", fontsize=9.5, color=FAINT,
        )  # fmt: skip
    what = "pseudo-acceleration" if check.check == LINEAR else "displacement"
    axes.set_title(f"{check.check} check: {check.state}, ratio {check.ratio:.3g}", fontsize=11, color=INK, loc="left")
    axes.set_xlabel("period [s]", fontsize=11, color=INK)
    axes.set_ylabel(f"{what} [{unit}]", fontsize=11, color=INK)
    axes.set_xlim(0.0 if check.period > 0.0 else -0.02 * spectrum.period[-1], spectrum.period[-1])
    axes.set_ylim(0.0, top)
    add_legend(axes)


def _draw_point(axes: Any, at: tuple[float, float], look: tuple[str, str], words: str, up: float) -> None:
    """A point in a colour and with a marker, and words at its side, moved up by some points of type."""
    colour, marker = look
    axes.plot(*at, marker, color=colour, markersize=8, markeredgecolor="white", zorder=5, clip_on=False)
    right = at[0] < 0.7 * axes.get_xlim()[1]
    axes.annotate(
        words, at, (OFFSET if right else -OFFSET, up), textcoords="offset points", ha="left" if right else "right", va="center",
        fontsize=10, color=colour, fontweight="bold", path_effects=halo(), zorder=6,
    )  # fmt: skip
