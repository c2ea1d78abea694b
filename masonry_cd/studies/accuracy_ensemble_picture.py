# SPDX-License-Identifier: GPL-3.0-or-later
"""Work-precision diagrams of ensembles: what a setting gives, its quartiles as bars, over the seconds that a run takes.

Points are filled where they show no bias against the finest setting, whose quartiles are the pale strip, and hollow where they do.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from masonry_cd.studies.accuracy_ensemble import LENGTHS, EnsembleRow
from reports.drawing.figure import FAINT, INK, plain_axes, save
from reports.drawing.plots import MARKERS, colour, halo, legend, logarithmic, sheet

MM = 1e3


def ensemble_picture(rows: Sequence[EnsembleRow], title: str, path: Path) -> None:
    """Draw opening, sliding and displacement over the cost of a run.

    Raises:
        InputError: the file cannot be written.
    """
    finest, count = rows[-1], len(rows[0].members)
    facts = f"{count} members each: median and quartiles; strip: quartiles of the finest setting; hollow: a bias shows; labels: tolerance"
    figure, panels = sheet(f"Error against run time: {title}", facts, len(LENGTHS))
    lines = list(dict.fromkeys((row.setting.solver, row.setting.dt) for row in rows))
    for axes, (key, number) in zip(panels, LENGTHS.items(), strict=True):
        best = finest.spreads[key]
        axes.axhspan(MM * best.low, MM * best.high, color="#e3e6e9", zorder=0)
        axes.axhline(MM * best.median, color=FAINT, linewidth=1.0, zorder=1)
        for k, (solver, dt) in enumerate(lines):
            own = [row for row in rows if (row.setting.solver, row.setting.dt) == (solver, dt)]
            own.sort(key=lambda row: -row.setting.tolerance)
            _line(axes, own, key, k, f"{solver}, dt {1e3 * dt:g} ms")
        axes.set_xscale("log")
        axes.margins(x=0.12, y=0.12)
        _widen(axes)
        logarithmic(axes.xaxis)
        plain_axes(axes, number.title, "processor time of a run, median [s]")
    legend(panels[0], min(4, len(lines)))
    save(figure, path)


def _line(axes: Any, rows: Sequence[EnsembleRow], key: str, k: int, name: str) -> None:
    """The tolerances of a solver and a time step."""
    x = [row.seconds for row in rows]
    spreads = [row.spreads[key] for row in rows]
    axes.plot(x, [MM * spread.median for spread in spreads], color=colour(k), linewidth=1.2, zorder=2)
    for place, (row, spread) in enumerate(zip(rows, spreads, strict=True)):
        low, middle, high = row.quartiles("seconds")
        axes.plot([middle, middle], [MM * spread.low, MM * spread.high], color=colour(k), linewidth=2.0, zorder=3)
        axes.plot([low, high], [MM * spread.median] * 2, color=colour(k), linewidth=2.0, zorder=3)
        axes.plot(
            middle, MM * spread.median, MARKERS[k % len(MARKERS)], color=colour(k), markersize=7, markeredgewidth=1.6,
            markerfacecolor="white" if spread.biased else colour(k), zorder=4, label=name if place == 0 else None,
        )  # fmt: skip
        axes.annotate(
            f"{row.setting.tolerance:.0e}".replace("e-0", "e-"), (middle, MM * spread.median), (7, 6), textcoords="offset points",
            fontsize=8.5, color=INK, path_effects=halo(), zorder=5,
        )  # fmt: skip


def _widen(axes: Any) -> None:
    """An axis of seconds over less than a factor three shows too few ticks."""
    low, high = axes.get_xlim()
    if high < 3.0 * low:
        middle = (low * high) ** 0.5
        axes.set_xlim(middle / 3.0**0.5, middle * 3.0**0.5)
