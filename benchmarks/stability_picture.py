# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the stability sheet: each measure of each case as a share of its limit; what passes lies left of the line.

The measures of a row lie a little above one another, so that none hides another; at the left edge stand those that are zero or nearly so.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.stability_outcome import Outcome
from reports.drawing.figure import COLOURS, FAINT, INK

MEASURES = {"drift": "o", "penetration": "s", "balance": "^", "dissipation": "D"}
LEAST, MOST = 1e-13, 1e4  # shares of a limit beyond these are drawn there
APART = 0.19  # of the height of a row, between two measures
MISSED, WORST = 1.33, 1.455  # right ends of the columns next to the verdicts, in widths of the axes


def draw(outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw the sheet into a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    places = _places(outcomes)
    tall = 1.9 + 0.25 * (places[-1] + 1.0)
    figure: Any = Figure(figsize=(11.0, tall), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.33, 0.65 / tall, 0.44, (tall - 1.95) / tall))
    axes.set_xscale("log")
    axes.set_xlim(LEAST / 3.0, MOST * 3.0)
    axes.set_ylim(places[-1] + 0.8, -1.0)
    axes.axvline(1.0, color=INK, linewidth=1.2)
    for found, place in zip(outcomes, places, strict=True):
        axes.axhline(place, color="#eceef0", linewidth=0.8, zorder=0)
        _row(axes, found, place)
    _groups(axes, outcomes, places)
    passed = sum(not found.failures for found in outcomes)
    head = f"Stiff and extreme cases: {passed} of {len(outcomes)} pass"
    figure.text(0.015, 1.0 - 0.32 / tall, head, fontsize=15, fontweight="bold", color=INK, va="center")
    figure.text(
        0.015,
        1.0 - 0.74 / tall,
        "each measure as a share of its limit, which is the line; missed: share of the steps that missed their tolerance;\n"
        "worst: counted cost of the most expensive step but the first, in times of the median",
        fontsize=11,
        color=FAINT,
        va="center",
    )
    _key(figure, axes)
    axes.set_yticks([])
    axes.set_xticks([LEAST, *(10.0**k for k in range(-8, 5, 4))])
    axes.set_xticklabels(["0", "$10^{-8}$", "$10^{-4}$", "1", "$10^{4}$"])
    axes.minorticks_off()
    axes.set_xlabel("share of the limit", fontsize=10, color=FAINT)
    axes.tick_params(labelsize=10, colors=FAINT)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    figure.savefig(path)


def _places(outcomes: Sequence[Outcome]) -> list[float]:
    """Rows from the top, a heading of a row and a half before each group."""
    places, at, group = [], -1.0, ""
    for found in outcomes:
        at += 1.0 if found.group == group else 2.4 if group else 1.6
        group = found.group
        places.append(at)
    return places


def _row(axes: Any, found: Outcome, place: float) -> None:
    """A case: its name, its measures, its verdict."""
    side = {"transform": axes.get_yaxis_transform(), "va": "center", "fontsize": 9.5, "clip_on": False}
    axes.text(-0.02, place, found.name, ha="right", color=INK, **side)
    for k, (name, marker) in enumerate(MEASURES.items()):
        if name in found.limits:
            value, limit = found.limits[name]
            share = min(max(value / limit, LEAST), MOST)
            axes.plot(
                share,
                place + APART * (k - 1.5),
                marker,
                color=COLOURS[k],
                markersize=5.5,
                markerfacecolor=COLOURS[k] if share <= 1.0 else "white",
                mew=1.5,
            )
    words = f"fails: {', '.join(found.failures)}" if found.failures else "passes"
    weight = "bold" if found.failures else "normal"
    axes.text(1.015, place, words, color=INK if found.failures else FAINT, fontweight=weight, **side)
    axes.text(
        MISSED, place, f"{100.0 * found.missed / max(found.steps, 1):.1f} %" if found.missed else "0", ha="right", color=FAINT, **side
    )
    axes.text(WORST, place, f"{found.worst:.0f}", ha="right", color=FAINT, **side)


def _groups(axes: Any, outcomes: Sequence[Outcome], places: Sequence[float]) -> None:
    """The heading of each group above its first row, and those of the columns on the right."""
    for at, word in ((MISSED, "missed"), (WORST, "worst")):
        axes.text(
            at, places[0] - 1.0, word, transform=axes.get_yaxis_transform(), ha="right", va="center", fontsize=9.5, color=INK, clip_on=False
        )
    for k, found in enumerate(outcomes):
        if k == 0 or found.group != outcomes[k - 1].group:
            axes.text(
                -0.70, places[k] - 1.0, found.group, transform=axes.get_yaxis_transform(), fontsize=10.5, fontweight="bold", color=INK,
                va="center", clip_on=False,
            )  # fmt: skip


def _key(figure: Any, axes: Any) -> None:
    """Names of the measures."""
    from matplotlib.lines import Line2D

    signs = [Line2D([], [], marker=marker, color=COLOURS[k], linestyle="", label=name) for k, (name, marker) in enumerate(MEASURES.items())]
    figure.legend(handles=signs, loc="upper right", ncols=4, frameon=False, fontsize=10.5, bbox_to_anchor=(0.99, 0.998), columnspacing=1.2)
