# SPDX-License-Identifier: GPL-3.0-or-later
"""The tornado: which of what varied, and which intensity measure, goes with the damage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.sensitivity import Correlation
from masonry_cd.analysis.fragility.words import PANELS, quantity
from reports.drawing.figure import FAINT, INK, plain_axes, save
from reports.study.plots import legend, sheet

BARS = 14  # per panel at most
HUES = {"varied": "#d55e00", "intensity": "#7fb2d6"}
HATCHES = {"varied": "", "intensity": "////"}
NAMES = {"varied": "what varied", "intensity": "intensity measure"}


def tornado_picture(rows: Sequence[Correlation], title: str, path: Path) -> None:
    """Draw the rank correlations, a panel per quantity, the strongest on top.

    Raises:
        InputError: the file cannot be written.
    """
    columns = list(dict.fromkeys(row.quantity for row in rows))[:PANELS]
    groups = [[row for row in rows if row.quantity == column][:BARS] for column in columns]
    tall = 2.3 + 0.34 * max(len(group) for group in groups)
    facts = "Spearman's rank correlation; whiskers: 95 %, bootstrap over records; diamond: the study's measure taken out"
    figure, panels = sheet(f"{title}: what matters", facts, len(columns), (max(8.4, 1.4 + 4.9 * len(columns)), tall))
    for axes, column, group in zip(panels, columns, groups, strict=True):
        plain_axes(axes, "", f"rank correlation with {quantity(column)[0].split(' [')[0]}")
        _bars(axes, group)
    legend(panels[0], 3, bbox_to_anchor=(0.0, -0.55 / (tall - 1.7)))
    save(figure, path)


def _bars(axes: Any, group: Sequence[Correlation]) -> None:
    """A panel."""
    named = set()
    for k, row in enumerate(group):
        label = None if row.kind in named else NAMES[row.kind]
        named.add(row.kind)
        axes.barh(k, row.rho, 0.66, color=HUES[row.kind], hatch=HATCHES[row.kind], edgecolor="white", linewidth=0.0, label=label, zorder=2)
        if np.isfinite([row.low, row.high]).all():
            axes.plot([row.low, row.high], [k, k], color=INK, linewidth=1.1, zorder=3)
            axes.plot([row.low, row.high], [k, k], "|", color=INK, markersize=6, zorder=3)
        if np.isfinite(row.given_measure):
            axes.plot(row.given_measure, k, "D", color=INK, markersize=5, markerfacecolor="white", zorder=4)
    axes.axvline(0.0, color=FAINT, linewidth=1.0, zorder=2.5)
    axes.set_yticks(np.arange(len(group)), [row.variable for row in group])
    for text in axes.get_yticklabels():
        text.set_parse_math(False)
        text.set_color(INK)
    axes.set_ylim(len(group) - 0.4, -0.6)
    axes.set_xlim(-1.04, 1.04)
    axes.set_xticks([-1.0, -0.5, 0.0, 0.5, 1.0])
    axes.grid(axis="y", visible=False)
