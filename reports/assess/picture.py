# SPDX-License-Identifier: GPL-3.0-or-later
"""The tornado of an assessment: a bar per assumption and answer, from its least to its largest value, over the band that chance spans.

A bar that shows beyond chance is full, one that does not is hollow: noise reads as noise. Marks are the levels, with their names.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.assessment.assessment import GRADE, AssessedNumber, Assessment, KnownAssumption
from masonry_cd.analysis.damage.grades import NAMES
from reports.drawing.figure import FAINT, INK, format_axes, save
from reports.drawing.plots import halo, sheet

PICTURE, INDICES = "assess.png", "assess_global.png"
FULL, HOLLOW, BAND, LINE = "#d55e00", "#ffffff", "#d3d9df", "#7a838c"
HEIGHT = 0.46  # of a bar, in rows
ROW, ABOVE, PANEL = 0.62, 1.1, 5.0  # [inches]: height of a row, of what else a panel needs, and its width
COLUMNS = 3  # panels side by side at most
LETTER = 0.0165  # width of a letter of a level's name, as a share of a panel's
ROOM = 0.14  # next to the bars, as a share of their range


def draw_tornado(found: Assessment, path: Path) -> None:
    """Draw the tornado."""
    answers, known = found.answers, [one for one in found.ranked if found.is_tested(one)]
    rows = -(-len(answers) // COLUMNS)
    across = -(-len(answers) // rows)
    size = (1.8 + PANEL * across, 0.9 + rows * (ABOVE + ROW * (len(known) + 1)))
    count = sum(one.row.done for one in found.ensemble)
    chance = f"grey: {count} runs whose amplitudes differ by 1e-9 (chance)" if count > 1 else "limit analysis"
    facts = f"full: beyond chance and 5 % of the base case; hollow: within them; {chance}; line: base case"
    figure, panels = sheet(f"{found.title}: what the answer depends on", facts, len(answers), size, rows)
    for place, (axes, answer) in enumerate(zip(panels, answers, strict=True)):
        _draw_panel(axes, found, known, answer, first=place % across == 0)
    save(figure, path)


def draw_indices(found: Assessment, path: Path) -> bool:
    """Draw the Sobol indices of the answers that have some; return False where none has."""
    there = {answer: one for answer, one in found.indices.items() if not one.refused}
    if not there:
        return False
    order = np.argsort(-np.mean([one.total for one in there.values()], axis=0))
    rows = -(-len(there) // COLUMNS)
    across = -(-len(there) // rows)
    size = (1.8 + PANEL * across, 0.9 + rows * (ABOVE + ROW * len(order)))
    facts = f"share of the variance; full: alone; hollow: with interactions; whiskers: 95 %; {len(found.sampled)} runs"
    figure, panels = sheet(f"{found.title}: all varied together", facts, len(there), size, rows)
    for place, (axes, (answer, one)) in enumerate(zip(panels, there.items(), strict=True)):
        format_axes(axes, "", f"{answer.name} (error of the surrogate {100 * one.error:.0f} %)")
        at = np.arange(len(order))
        for values, band, height, colour in ((one.total, one.total_band, HEIGHT, HOLLOW), (one.first, one.first_band, 0.5 * HEIGHT, FULL)):
            axes.barh(at, values[order], height, color=colour, edgecolor=FULL, linewidth=1.2, zorder=2)
            up = 0.3 * HEIGHT if colour == HOLLOW else 0.0
            axes.hlines(at - up, band[0][order], band[1][order], color=INK, linewidth=1.2, zorder=4)
        names = [found.unknowns[k].name for k in order]
        axes.set_yticks(at, names if place % across == 0 else [""] * len(names), fontsize=11)
        axes.set_ylim(len(names) - 0.4, -0.6)
        axes.set_xlim(min(0.0, float(one.first_band[0].min())) - 0.01, 1.05)
        axes.grid(axis="y", visible=False)
    save(figure, path)
    return True


def _draw_panel(axes: Any, found: Assessment, known: list[KnownAssumption], answer: AssessedNumber, first: bool) -> None:
    """The bars of an answer."""
    format_axes(axes, "", f"{answer.name}{f' [{answer.unit}]' if answer.unit else ''}")
    low, high = (answer.factor * value for value in found.chance(answer))
    if np.isfinite(low) and high > low:
        axes.axvspan(low, high, color=BAND, zorder=0.5, linewidth=0.0)
    base = answer.factor * found.base.of(answer)
    axes.axvline(base, color=INK, linewidth=1.2, zorder=1.5)
    ends = _limits(axes, found, answer)
    values = [answer.factor * one.of(answer) for one in found.ensemble]
    axes.plot(values, np.zeros(len(values)), "|", color=INK, markersize=13, markeredgewidth=1.1, zorder=4)
    for row, one in enumerate(known, 1):
        _draw_bar(axes, found, one, answer, row, ends)
    if answer != GRADE:
        axes.locator_params(axis="x", nbins=7)
    names = ["chance (ensemble)", *(one.name for one in known)]
    axes.set_yticks(np.arange(len(names)), names if first else [""] * len(names), fontsize=11)
    for text in axes.get_yticklabels():
        text.set_color(INK)
    axes.set_ylim(len(names) - 0.35, -0.75)
    axes.grid(axis="y", visible=False)


def _limits(axes: Any, found: Assessment, answer: AssessedNumber) -> tuple[float, float]:
    """Set the ends of an axis, so that names of levels have a place next to the bars."""
    low, high = (answer.factor * value for value in found.range(answer))
    if answer == GRADE:
        axes.set_xticks(range(len(NAMES)), NAMES)
        low, high = 0.0, len(NAMES) - 1.0
    wide = (high - low) or abs(high) or 1.0
    ends = (low - ROOM * wide, high + ROOM * wide)
    axes.set_xlim(*ends)
    return ends


def _draw_bar(axes: Any, found: Assessment, one: KnownAssumption, answer: AssessedNumber, row: int, ends: tuple[float, float]) -> None:
    """The bar of an assumption with its levels."""
    bar = found.bar(one, answer)
    if not bar.values:
        return
    low, high = answer.factor * bar.low, answer.factor * bar.high
    colour = FULL if bar.shows else HOLLOW
    axes.barh(row, high - low, HEIGHT, left=low, color=colour, edgecolor=FULL if bar.shows else LINE, linewidth=1.2, zorder=2)
    if one.reference:
        axes.plot(answer.factor * bar.reference, row, "D", color=INK, markersize=5.5, markerfacecolor="white", zorder=4)
    levels = [(answer.factor * value, name) for name, value in bar.values]
    axes.plot([value for value, _ in levels], [row] * len(levels), "o", color=INK, markersize=4.5, zorder=5)
    if one.reference:
        levels.append((answer.factor * bar.reference, one.reference))
    if high == low:  # where nothing changes there is nothing to name
        return
    _draw_names(axes, sorted(levels), row, ends)


def _draw_names(axes: Any, levels: list[tuple[float, str]], row: int, ends: tuple[float, float]) -> None:
    """Names of levels above the bar, or below it where one above is in the way; those of one place, and what fits nowhere, together."""
    wide = ends[1] - ends[0]
    texts: list[list[Any]] = []  # middle, half the width, text, side
    for value, name in levels:
        half = 0.5 * LETTER * (len(name) + 1) * wide
        middle = min(max(value, ends[0] + half), ends[1] - half)
        sides = [side for side in (0, 1) if all(middle - half >= at + width for at, width, _, other in texts if other == side)]
        if sides and not (texts and abs(middle - texts[-1][0]) < 0.01 * wide):
            texts.append([middle, half, name, sides[0]])
            continue
        texts[-1][2] += f", {name}"
        texts[-1][1] = 0.5 * LETTER * len(texts[-1][2]) * wide
        texts[-1][0] = min(max(texts[-1][0], ends[0] + texts[-1][1]), ends[1] - texts[-1][1])
    for middle, _, text, side in texts:
        up, place = (-0.5 * HEIGHT - 0.04, "bottom") if side == 0 else (0.5 * HEIGHT + 0.04, "top")
        look = {"fontsize": 9, "color": FAINT, "ha": "center", "va": place, "zorder": 6, "path_effects": halo()}
        axes.text(middle, row + up, text, **look)
