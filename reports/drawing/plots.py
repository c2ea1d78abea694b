# SPDX-License-Identifier: GPL-3.0-or-later
"""The common look of diagrams: a heading, panels, axes, keys and colours as in the other pictures of the program."""

from __future__ import annotations

from textwrap import fill, shorten
from typing import Any

from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.foundation.figures import blank
from reports.drawing.figure import COLOURS, FAINT, INK, format_axes, halo

DPI = 150
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
STROKES = ("-", "--", ":", "-.")
PALE = "#b8bec4"
LETTERS, OF_TITLE = 13.0, 8.3  # on an inch, of the facts and of the title
FEW_TICKS = 10.0  # high over low of an axis on which 1, 2, 5 would leave less than three ticks


def colour(k: int) -> str:
    """Return the colour of the k-th of several."""
    return COLOURS[k % len(COLOURS)]


def add_heading(figure: Any, title: str, facts: str = "") -> None:
    """A title and lines of facts at the top of a figure, whose layout is constrained to what is left."""
    width, height = figure.get_size_inches()
    title = shorten(title, int(OF_TITLE * width), placeholder=" …")
    facts = "\n".join(fill(line, int(LETTERS * width)) for line in facts.splitlines())
    taken = 0.45 + 0.27 * bool(facts) + 0.18 * facts.count("\n")
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.08, wspace=0.06, rect=(0.0, 0.0, 1.0, 1.0 - taken / height))
    look = {"x": 0.16 / width}
    figure.text(y=1.0 - 0.26 / height, s=title, fontsize=14, fontweight="bold", color=INK, va="center", **look)
    figure.text(y=1.0 - 0.46 / height, s=facts, fontsize=10, color=FAINT, va="top", **look)


def sheet(title: str, facts: str, panels: int = 1, size: tuple[float, float] | None = None, rows: int = 1) -> tuple[Any, list[Any]]:
    """A figure with a title, a line of facts, and panels side by side, or in several rows."""
    width, height = size or ((8.2, 5.6) if panels == 1 else (1.4 + 4.9 * panels, 5.4))
    figure = blank((width, height), DPI, layout="constrained")
    add_heading(figure, title, facts)
    axes = list(figure.subplots(rows, -(-panels // rows), squeeze=False).flat)
    for spare in axes[panels:]:
        spare.remove()
    axes = axes[:panels]
    for one in axes:
        format_axes(one)
    return figure, axes


def logarithmic(axis: Any) -> None:
    """Ticks of a logarithmic axis in plain numbers: 1, 2, 5 where it is short, round numbers where it spans hardly a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    low, high = sorted(axis.get_view_interval())
    subs = (1.0, 2.0, 5.0) if high < 300.0 * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=12) if high > FEW_TICKS * low else MaxNLocator(5))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def add_legend(axes: Any, columns: int = 1, **more: Any) -> None:
    """A key below the axes."""
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        options: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.0, -0.13), "ncols": columns} | more
        axes.legend(fontsize=9.5, frameon=False, labelcolor=INK, **options)


def draw_limit_line(axes: Any, limit: LimitState, k: int, factor: float, across: bool) -> None:
    """The bound of a limit state, a dashed line with its name; ``across`` the picture, or upright."""
    look = {"color": colour(k), "linewidth": 1.1, "linestyle": (0, (5, 3)), "zorder": 2.5}
    words: dict[str, Any] = {"fontsize": 9.5, "color": colour(k), "path_effects": halo(), "zorder": 6}
    if across:
        axes.axhline(factor * limit.bound, **look)
        axes.annotate(
            limit.name, (0.0, factor * limit.bound), (4, 3), xycoords=("axes fraction", "data"), textcoords="offset points", **words
        )
    else:
        axes.axvline(factor * limit.bound, **look)
        at = (factor * limit.bound, 1.0)
        axes.annotate(
            limit.name, at, (3, -4), xycoords=("data", "axes fraction"), textcoords="offset points", rotation=90, va="top", **words
        )
