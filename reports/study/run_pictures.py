# SPDX-License-Identifier: GPL-3.0-or-later
"""What the runs did: IDA curves with quantiles, clouds with their regression, stripes by level, distributions where no intensity varies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.bootstrap import bands
from masonry_cd.analysis.fragility.fits import CloudFit
from masonry_cd.analysis.fragility.folder import Study
from masonry_cd.analysis.fragility.ida import QUANTILES, Curve, demand_quantiles, quantiles
from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.analysis.fragility.measures import label
from masonry_cd.analysis.outputs import STUDY_PAGE, lengths_in
from reports.drawing.figure import FAINT, INK, plain_axes, save
from reports.study.plots import MARKERS, PALE, PANELS, colour, legend, limit_line, logarithmic, quantity, sheet

GENERAL = tuple(lengths_in(STUDY_PAGE))  # drawn where the limit states look at none that is continuous


def quantities_of(study: Study) -> list[str]:
    """Columns worth a panel: those of continuous limit states, else what every run has; as many as fit."""
    asked = dict.fromkeys(limit.column for limit in study.limit_states if limit.continuous)
    drawn = [name for name in (asked or GENERAL) if np.isfinite(study.numbers(name)[study.done]).any()]
    return drawn[:PANELS]


def _limits(study: Study, column: str) -> list[tuple[int, LimitState]]:
    """The limit states of a quantity, with their place among all."""
    return [(k, limit) for k, limit in enumerate(study.limit_states) if limit.column == column and limit.continuous]


def _largest_shown(study: Study, column: str, values: np.ndarray) -> float:
    """Where the axis of a demand ends: at what stands, and at all limits."""
    standing = values[study.done & ~study.collapsed & np.isfinite(values)]
    bounds = [limit.bound for _, limit in _limits(study, column)]
    shown = max([float(np.percentile(standing, 95)) if len(standing) else 0.0, *(1.3 * bound for bound in bounds)])
    return 1.1 * shown or 1.0


def ida_picture(study: Study, curves: Sequence[Curve], path: Path) -> None:
    """Draw the curves of the records, intensity upwards, and their 16, 50 and 84 % quantiles."""
    columns, measure = quantities_of(study), str(study.asked["measure"])
    facts = f"{len(curves)} curves; a bar at the end: blocks fell in the next run"
    figure, panels = sheet(f"{study.asked['title']}: incremental dynamic analysis", facts, len(columns))
    for axes, column in zip(panels, columns, strict=True):
        words, factor = quantity(column)
        values = study.numbers(column)
        most = factor * _largest_shown(study, column, values)
        for curve in curves:
            _ida_curve(axes, curve, factor * values, study.collapsed, most)
        grid, demand = demand_quantiles(curves, values, study.collapsed)
        for k, (share, line) in enumerate(zip(QUANTILES, demand, strict=True)):
            there = np.isfinite(line)
            x, y = np.concatenate([[0.0], factor * line[there]]), np.concatenate([[0.0], grid[there]])
            if not there.all():
                x, y = np.append(x, 2.0 * most), np.append(y, y[-1])
            stroke = ("--", "-", ":")[k]
            name = "median" if share == 0.5 else f"{100 * share:.0f} % quantile of the demand"
            axes.plot(x, y, color=INK, linewidth=2.2, linestyle=stroke, label=name, zorder=4)
        for k, limit in _limits(study, column):
            limit_line(axes, limit, k, factor, across=False)
        axes.set_xlim(0.0, most)
        axes.set_ylim(0.0, 1.05 * max(float(curve.intensity[-1]) for curve in curves))
        plain_axes(axes, label(measure), words)
    legend(panels[0], 3)
    save(figure, path)


def _ida_curve(axes: Any, curve: Curve, values: np.ndarray, collapsed: np.ndarray, most: float) -> None:
    """One record, up to its collapse."""
    down = collapsed[curve.rows]
    first = int(np.argmax(down)) if down.any() else len(down)
    x, y = np.concatenate([[0.0], values[curve.rows][:first]]), np.concatenate([[0.0], curve.intensity[:first]])
    axes.plot(x, y, color=PALE, linewidth=0.9, zorder=2)
    axes.plot(x[1:], y[1:], ".", color=PALE, markersize=3.5, zorder=2)
    if first < len(down):
        at = float(np.sqrt(y[-1] * curve.intensity[first])) if y[-1] > 0 else float(curve.intensity[first])
        axes.plot([x[-1], x[-1], most], [y[-1], at, at], color=PALE, linewidth=0.9, zorder=1.5)
        axes.plot(min(x[-1], most), at, "|", color="#8b9299", markersize=7, zorder=3)


def cloud_picture(study: Study, clouds: Sequence[CloudFit], path: Path) -> None:
    """Draw the runs in logarithms, their regression with its scatter and band, and what is known from one side only."""
    shown = list(clouds)[:PANELS]
    facts = "line: regression, pale: its scatter of one standard deviation, darker: 95 % band by the bootstrap over records"
    figure, panels = sheet(f"{study.asked['title']}: cloud", facts, len(shown))
    for axes, fit in zip(panels, shown, strict=True):
        words, factor = quantity(fit.column)
        cloud, x = fit.cloud, np.exp(fit.cloud.measure)
        y = factor * np.exp(cloud.demand)
        kinds = (
            (cloud.exact, "o", f"standing ({int(cloud.exact.sum())})", "#56b4e9"),
            (cloud.above, "^", f"blocks fell, known from below ({int(cloud.above.sum())})", "#d55e00"),
            (cloud.below, "v", f"next to nothing, known from above ({int(cloud.below.sum())})", "#999999"),
        )
        for rows, marker, name, hue in kinds:
            if rows.any():
                axes.plot(
                    x[rows], y[rows], marker, color=hue, markersize=5, markeredgecolor="white", markeredgewidth=0.4, label=name, zorder=3
                )
        grid = np.linspace(cloud.measure.min(), cloud.measure.max(), 60)
        if np.isfinite(fit.line.b[0]):
            middle = fit.line.a[0] + fit.line.b[0] * grid
            low, high = bands(fit.replicated.a[:, None] + fit.replicated.b[:, None] * grid)
            for lower, upper, strength in ((middle - fit.line.s[0], middle + fit.line.s[0], 0.08), (low, high, 0.2)):
                axes.fill_between(
                    np.exp(grid), factor * np.exp(lower), factor * np.exp(upper), color=INK, alpha=strength, linewidth=0, zorder=1
                )
            name = f"ln EDP = {fit.line.a[0]:.3g} + {fit.line.b[0]:.3g} ln IM, scatter {fit.line.s[0]:.2f}"
            axes.plot(np.exp(grid), factor * np.exp(middle), color=INK, linewidth=2.0, label=name, zorder=4)
        axes.set_xscale("log")
        axes.set_yscale("log")
        for k, limit in _limits(study, fit.column):
            limit_line(axes, limit, k, factor, across=True)
        for axis in (axes.xaxis, axes.yaxis):
            logarithmic(axis)
        plain_axes(axes, words, label(fit.measure))
        legend(axes)
    save(figure, path)


def stripes_picture(study: Study, path: Path) -> None:
    """Draw each run at its level, the median and the 16 to 84 % of each stripe, and how many collapsed."""
    columns, level = quantities_of(study), study.numbers("level")
    rows = study.done & np.isfinite(level)
    levels = np.unique(level[rows])
    near = float(np.diff(levels).min()) if len(levels) > 1 else float(levels[0])
    facts = "a dot per run that stands; bars: 16, 50 and 84 % of all runs of a level; above: share in which blocks fell"
    figure, panels = sheet(f"{study.asked['title']}: stripes", facts, len(columns))
    for axes, column in zip(panels, columns, strict=True):
        words, factor = quantity(column)
        values = study.numbers(column)
        least = 1e-3 * min([limit.bound for _, limit in _limits(study, column)], default=float(np.nanmax(values[rows], initial=1e-6)))
        for one in levels:
            stripe = rows & (level == one)
            own = np.maximum(values[stripe & ~study.collapsed & np.isfinite(values)], least)
            spread = np.linspace(-0.13, 0.13, len(own)) * near if len(own) > 1 else np.zeros(len(own))
            axes.plot(one + spread, factor * own, ".", color="#56b4e9", markersize=4, zorder=5)
            everything = np.where(study.collapsed[stripe], np.inf, values[stripe])
            everything = np.maximum(everything[~np.isnan(everything)], least)
            if len(everything):
                _bars(axes, one, 0.3 * near, [factor * value for value in quantiles(everything, QUANTILES)])
            fell = int(study.collapsed[stripe].sum())
            if fell:
                axes.annotate(
                    f"{100 * fell / int(stripe.sum()):.0f} %", (one, 1.0), (0, 3), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="center", fontsize=8.5, color="#a33c00",
                )  # fmt: skip
        axes.set_yscale("log")
        for k, limit in _limits(study, column):
            limit_line(axes, limit, k, factor, across=True)
        logarithmic(axes.yaxis)
        axes.set_xlim(max(0.0, levels[0] - near), levels[-1] + near)
        plain_axes(axes, words, label(str(study.asked["measure"])) if study.asked["measure"] else "level")
    save(figure, path)


def _bars(axes: Any, at: float, half: float, three: Sequence[float]) -> None:
    """The quantiles of a stripe; those that are infinite are left out."""
    for value, width in zip(three, (1.2, 2.4, 1.2), strict=True):
        if np.isfinite(value):
            axes.plot([at - half, at + half], [value, value], color=INK, linewidth=width, solid_capstyle="butt", zorder=4)
    if np.isfinite(three[2]):
        axes.plot([at, at], [three[0], three[2]], color=INK, linewidth=0.9, zorder=3.5)


def spread_picture(study: Study, path: Path) -> None:
    """Draw how each quantity is distributed over the runs: their share up to a value, the median and the quartiles."""
    columns = quantities_of(study)
    figure, panels = sheet(
        f"{study.asked['title']}: spread over the runs", "share of the runs up to a value; marks: quartiles", len(columns)
    )
    for k, (axes, column) in enumerate(zip(panels, columns, strict=True)):
        words, factor = quantity(column)
        values = study.numbers(column)
        own = np.sort(factor * values[study.done & np.isfinite(values)])
        share = np.arange(1, len(own) + 1) / len(own)
        axes.step(np.concatenate([own[:1], own]), np.concatenate([[0.0], share]), where="post", color=colour(k), linewidth=2.0)
        three = quantiles(own, (0.25, 0.5, 0.75))  # of the steps, so that the marks lie on the line
        axes.plot(three, [0.25, 0.5, 0.75], MARKERS[k], color=INK, markersize=7, markerfacecolor="white", zorder=4)
        for value, height in zip(three, (0.25, 0.5, 0.75), strict=True):
            axes.annotate(f"{value:.3g}", (value, height), (9, -4), textcoords="offset points", fontsize=9.5, color=INK)
        for place, limit in _limits(study, column):
            if factor * limit.bound < own[-1] + 3.0 * max(float(np.ptp(own)), 0.1 * abs(own[-1])):
                limit_line(axes, limit, place, factor, across=False)
        axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
        axes.margins(x=0.12)
        plain_axes(axes, "runs" if axes is panels[0] else "", words)
        axes.text(0.99, 0.03, f"{len(own)} runs", transform=axes.transAxes, fontsize=9.5, color=FAINT, ha="right")
    save(figure, path)
