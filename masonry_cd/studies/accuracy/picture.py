# SPDX-License-Identifier: GPL-3.0-or-later
"""A measurement of error against run time in files: tables, words, and its work-precision diagram.

The diagram has what a setting gives over the seconds that it takes, a line per solver, tolerance or time step. Colours are those of Okabe &
Ito with a marker each, so that it reads in grey as well. Hollow points missed their tolerance, or show a bias.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import markdown, write_rows
from reports.drawing.figure import FAINT, INK, format_axes, save
from reports.drawing.plots import MARKERS, add_legend, colour, halo, logarithmic, sheet

LEAST = 1e-17  # errors of nothing are drawn here
STRIP = "#e3e6e9"
SHORT = 3.0  # high over low of an axis that shows too few ticks, and is made as long

Bar = tuple[float, float]  # quartiles


class Point(NamedTuple):
    """A setting."""

    seconds: float
    value: float
    hollow: bool
    label: str = ""
    across: Bar | None = None  # of the seconds
    up: Bar | None = None  # of the value


@dataclass(frozen=True)
class TimePanel:
    """Quantity that is drawn over the seconds."""

    words: str  # at the axis
    lines: Sequence[tuple[str, Sequence[Point]]]  # by name
    strip: tuple[float, float, float] | None = None  # quartiles and median of what the lines should meet; else they are errors
    levels: Sequence[float] = ()  # faint lines across


@dataclass(frozen=True)
class PanelSheet:
    """A sheet of panels whose lines have the same names."""

    title: str
    facts: str
    across: str
    panels: Sequence[TimePanel]


def draw(diagram: PanelSheet, path: Path) -> None:
    """Draw a diagram into a PNG.

    Raises:
        InputError: the file cannot be written.
    """
    figure, axes = sheet(diagram.title, diagram.facts, len(diagram.panels))
    for one, panel in zip(axes, diagram.panels, strict=True):
        _draw(one, panel)
        format_axes(one, panel.words, diagram.across)
    add_legend(axes[0], min(4, len(diagram.panels[0].lines)))
    save(figure, path)


def _draw(axes: Any, panel: TimePanel) -> None:
    """The lines of a panel; errors on a logarithmic scale."""
    if panel.strip is not None:
        low, median, high = panel.strip
        axes.axhspan(low, high, color=STRIP, zorder=0)
        axes.axhline(median, color=FAINT, linewidth=1.0, zorder=1)
    for level in panel.levels:
        axes.axhline(level, color=STRIP, linewidth=0.8, zorder=0)
    for k, (name, points) in enumerate(panel.lines):
        _draw_line(axes, k, name, points)
    axes.margins(x=0.12, y=0.12)
    axes.set_xscale("log")
    axes.set_yscale("log" if panel.strip is None else "linear")
    for axis in (axes.xaxis, axes.yaxis)[: 2 if panel.strip is None else 1]:
        _widen(axis)
        logarithmic(axis)


def _draw_line(axes: Any, k: int, name: str, points: Sequence[Point]) -> None:
    """A line with its points, bars of quartiles and labels."""
    values = [max(point.value, LEAST) for point in points]
    axes.plot([point.seconds for point in points], values, color=colour(k), linewidth=1.4, zorder=2)
    for place, (point, value) in enumerate(zip(points, values, strict=True)):
        for x, y in (((point.seconds,) * 2, point.up), (point.across, (value,) * 2)):
            if x is not None and y is not None:
                axes.plot(x, y, color=colour(k), linewidth=2.0, zorder=3)
        axes.plot(
            point.seconds, value, MARKERS[k % len(MARKERS)], color=colour(k), markersize=7, markeredgewidth=1.6, zorder=4,
            markerfacecolor="white" if point.hollow else colour(k), label=name if place == 0 else None,
        )  # fmt: skip
        if point.label:
            axes.annotate(
                point.label, (point.seconds, value), (7, 6), textcoords="offset points", fontsize=8.5, color=INK,
                path_effects=halo(), zorder=5,
            )  # fmt: skip


def _widen(axis: Any) -> None:
    """Make a short logarithmic axis longer."""
    low, high = axis.get_view_interval()
    if high < SHORT * low:
        middle = (low * high) ** 0.5
        (axis.axes.set_xlim if axis.axis_name == "x" else axis.axes.set_ylim)(middle / SHORT**0.5, middle * SHORT**0.5)


def exponent(value: float) -> str:
    """A tolerance as people write it: 1e-4."""
    return f"{value:.2g}" if value >= 0.01 else f"{value:.1e}".replace(".0e", "e").replace("e-0", "e-")


Row = Mapping[str, Any]
CSV, MARKDOWN, PICTURE = OUTPUTS = ("accuracy.csv", "accuracy.md", "accuracy.png")


@dataclass(frozen=True)
class Measurement:
    """The numbers of a measurement, the lines on it and its diagram; rows of one table have equal keys."""

    heading: str  # of accuracy.md
    rows: Sequence[Row]  # of accuracy.csv
    read: Sequence[Row]  # of accuracy.md
    lines: Sequence[str]
    warnings: Sequence[str]
    diagram: PanelSheet

    def write(self, folder: Path) -> list[Path]:
        """Write accuracy.csv, accuracy.md and accuracy.png; their paths."""
        write_rows(folder / CSV, nine_digits(self.rows))
        lines = [*(f"- {line}" for line in self.lines), *(f"- **{line}**" for line in self.warnings)]
        with replacing(folder / MARKDOWN) as part:
            part.write_text("\n".join([f"# {self.heading}", "", table(self.read), *lines]) + "\n", encoding="utf-8")
        draw(self.diagram, folder / PICTURE)
        return [folder / name for name in OUTPUTS]


def nine_digits(rows: Sequence[Row]) -> list[Row]:
    """Rows for CSV."""
    return [{key: f"{v:.9g}" if isinstance(v, float) else v for key, v in row.items()} for row in rows]


def table(rows: Sequence[Row]) -> str:
    """Rows in Markdown, three digits; what was missed stands out."""
    return markdown([[key.replace("_", " ") for key in rows[0]], *([_cell(key, value) for key, value in row.items()] for row in rows)])


def _cell(key: str, value: Any) -> str:
    """A value for reading."""
    if isinstance(value, bool):
        return "yes" if value else "**missed**" if key == "reached" else ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
