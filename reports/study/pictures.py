# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a study: fragilities, IDA curves, clouds, stripes, distributions where no intensity varies, and rank correlations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.bootstrap import bands
from masonry_cd.analysis.fragility.findings import PANELS, Findings, quantity
from masonry_cd.analysis.fragility.fits import ORDER, Fit
from masonry_cd.analysis.fragility.folder import StudyResults
from masonry_cd.analysis.fragility.fragility import by_level
from masonry_cd.analysis.fragility.ida import QUANTILES, IdaCurve, demand_quantiles, quantiles
from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.analysis.fragility.measures import label, with_unit
from masonry_cd.analysis.fragility.sensitivity import RankCorrelation
from reports.drawing.figure import FAINT, INK, format_axes, save
from reports.drawing.plots import MARKERS, PALE, add_legend, colour, draw_limit_line, halo, logarithmic, sheet

METHODS = {
    "mle": "maximum likelihood on counts per level",
    "probit": "probit on each run's own intensity",
    "cloud": "regression of the cloud",
    "ida": "capacities of the records",
}
BEYOND = {"mle": (0, (6, 2)), "ida": (0, (6, 2)), "cloud": (0, (6, 2)), "probit": (0, (2, 2))}  # strokes of further methods
POINTS = {"mle": "points: share of the runs of a level", "ida": "steps: capacities of the records"}
EIGHTHS = "points: share of the runs in eight groups by intensity"
GRID = 240
BINS = 8  # of runs whose intensities are their own
BARS = 14  # per panel at most
HUES = {"varied": "#d55e00", "intensity": "#7fb2d6"}
HATCHES = {"varied": "", "intensity": "////"}
KINDS = {"varied": "what varied", "intensity": "intensity measure"}
LABELLED = 2  # limit states whose points have their counts written to them


def draw_fragilities(found: Findings, path: Path) -> None:
    """Draw the fragilities of all limit states over one measure."""
    fits, title = [fit for fit in found.fits if fit.runs], f"{found.study.asked.title}: fragility"
    limits = list(dict.fromkeys(fit.limit for fit in fits))
    points = next((words for method, words in POINTS.items() if method in {fit.method for fit in fits}), EIGHTHS)
    tall = 5.4 + 0.23 * sum(fit.is_fitted for fit in fits)
    figure, (axes,) = sheet(title, f"{points}; bands: 95 %, bootstrap over records", size=(8.4, tall))
    top = 1.06 * max(float(fit.intensity.max(initial=0.0)) for fit in fits)
    grid = np.linspace(0.0, top, GRID + 1)[1:]
    for k, limit in enumerate(limits):
        own = sorted((fit for fit in fits if fit.limit == limit), key=lambda fit: ORDER.index(fit.method))
        _draw_points(axes, own[0], k, counts=len(limits) <= LABELLED)
        drawn = [fit for fit in own if fit.is_fitted]
        for place, fit in enumerate(drawn):
            _draw_curve(axes, fit, k, grid, main=place == 0)
        if not drawn:
            axes.plot([], [], MARKERS[k % len(MARKERS)], color=colour(k), markerfacecolor="white", label=f"{limit.name}: no fit")
    axes.set_xlim(0.0, top)
    axes.set_ylim(-0.02, 1.04)
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    format_axes(axes, "probability that a limit state is exceeded", label(fits[0].measure))
    add_legend(axes)
    save(figure, path)


def _draw_curve(axes: Any, fit: Fit, k: int, grid: np.ndarray, main: bool) -> None:
    """A fitted curve; the first method of a limit state with its band."""
    words = f"{fit.limit.name}: median {with_unit(fit.theta, fit.measure)}, beta {fit.beta:.2f}, {METHODS[fit.method]}"
    if main:
        low, high = bands(fit.replicated.probability(grid))
        axes.fill_between(grid, low, high, color=colour(k), alpha=0.16, linewidth=0, zorder=1)
    stroke: Any = "-" if main else BEYOND[fit.method]
    axes.plot(
        grid, fit.curve.probability(grid)[0], color=colour(k), linewidth=2.2 if main else 1.3, linestyle=stroke, label=words, zorder=3
    )


def _draw_points(axes: Any, fit: Fit, k: int, counts: bool) -> None:
    """Draw the points to which the curve was fitted."""
    if not fit.runs:
        return
    look: dict[str, Any] = {"color": colour(k), "markerfacecolor": "white", "markeredgewidth": 1.6, "markersize": 6.5, "zorder": 4}
    if fit.found is not None:
        reached = np.sort(fit.found.intensity[~fit.found.above])
        share = np.arange(1, len(reached) + 1) / fit.runs
        axes.step(np.concatenate([[0.0], reached]), np.concatenate([[0.0], share]), where="post", color=colour(k), linewidth=1.0, zorder=2)
        return
    if fit.method == "mle":
        levels, exceeded, runs = by_level(fit.intensity, fit.over, np.ones((1, len(fit.over))))
        level, share, over, of = levels, exceeded[0] / runs[0], exceeded[0], runs[0]
    else:
        parts = np.array_split(np.argsort(fit.intensity, kind="stable"), min(BINS, fit.runs))
        level = np.array([np.exp(np.log(fit.intensity[rows]).mean()) for rows in parts])
        over, of = np.array([fit.over[rows].sum() for rows in parts]), np.array([len(rows) for rows in parts])
        share = over / of
    axes.plot(level, share, MARKERS[k % len(MARKERS)], **look)
    if counts and len(level) <= 14:
        for x, y, some, total in zip(level, share, over, of, strict=True):
            axes.annotate(
                f"{some:.0f}/{total:.0f}", (x, y), (0, -14 if y > 0.5 else 9), textcoords="offset points", fontsize=8, color=FAINT,
                ha="center", path_effects=halo(), zorder=5,
            )  # fmt: skip


def _limits(study: StudyResults, column: str) -> list[tuple[int, LimitState]]:
    """The limit states of a quantity, with their place among all."""
    return [(k, limit) for k, limit in enumerate(study.limit_states) if limit.column == column and limit.is_continuous]


def _largest_shown(study: StudyResults, column: str, values: np.ndarray) -> float:
    """Where the axis of a demand ends: at what stands, and at all limits."""
    standing = values[study.done & ~study.collapsed & np.isfinite(values)]
    bounds = [limit.bound for _, limit in _limits(study, column)]
    shown = max([float(np.percentile(standing, 95)) if len(standing) else 0.0, *(1.3 * bound for bound in bounds)])
    return 1.1 * shown or 1.0


def draw_ida(found: Findings, path: Path) -> None:
    """Draw the curves of the records, intensity upwards, and their 16, 50 and 84 % quantiles."""
    study, curves, columns, measure = found.study, found.all_fits.curves, found.quantities, str(found.study.asked.measure)
    facts = f"{len(curves)} curves; a bar at the end: blocks fell in the next run"
    figure, panels = sheet(f"{study.asked.title}: incremental dynamic analysis", facts, len(columns))
    for axes, column in zip(panels, columns, strict=True):
        words, factor = quantity(column)
        values = study.numbers(column)
        most = factor * _largest_shown(study, column, values)
        for curve in curves:
            _draw_ida_curve(axes, curve, factor * values, study.collapsed, most)
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
            draw_limit_line(axes, limit, k, factor, across=False)
        axes.set_xlim(0.0, most)
        axes.set_ylim(0.0, 1.05 * max(float(curve.intensity[-1]) for curve in curves))
        format_axes(axes, label(measure), words)
    add_legend(panels[0], 3)
    save(figure, path)


def _draw_ida_curve(axes: Any, curve: IdaCurve, values: np.ndarray, collapsed: np.ndarray, most: float) -> None:
    """One record, up to its collapse."""
    y, x, at = curve.demands(values, collapsed)
    axes.plot(x, y, color=PALE, linewidth=0.9, zorder=2)
    axes.plot(x[1:], y[1:], ".", color=PALE, markersize=3.5, zorder=2)
    if np.isfinite(at):
        axes.plot([x[-1], x[-1], most], [y[-1], at, at], color=PALE, linewidth=0.9, zorder=1.5)
        axes.plot(min(x[-1], most), at, "|", color="#8b9299", markersize=7, zorder=3)


def draw_cloud(found: Findings, path: Path) -> None:
    """Draw the runs in logarithms, their regression with its scatter and band, and what is known from one side only."""
    study, shown = found.study, found.all_fits.clouds[:PANELS]
    facts = "line: regression, pale: its scatter of one standard deviation, darker: 95 % band by the bootstrap over records"
    figure, panels = sheet(f"{study.asked.title}: cloud", facts, len(shown))
    for axes, fit in zip(panels, shown, strict=True):
        words, factor = quantity(fit.column)
        cloud, x = fit.cloud, np.exp(fit.cloud.measure)
        y = factor * np.exp(cloud.demand)
        kinds = (
            (cloud.exact, "o", f"standing ({int(cloud.exact.sum())})", "#56b4e9"),
            (cloud.above, "^", f"blocks fell: lower bound ({int(cloud.above.sum())})", "#d55e00"),
            (cloud.below, "v", f"almost no damage: upper bound ({int(cloud.below.sum())})", "#999999"),
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
            draw_limit_line(axes, limit, k, factor, across=True)
        for axis in (axes.xaxis, axes.yaxis):
            logarithmic(axis)
        format_axes(axes, words, label(fit.measure))
        add_legend(axes)
    save(figure, path)


def draw_stripes(found: Findings, path: Path) -> None:
    """Draw each run at its level, the median and the 16 to 84 % of each stripe, and how many collapsed."""
    study, columns, level = found.study, found.quantities, found.study.numbers("level")
    rows = study.done & np.isfinite(level)
    levels = np.unique(level[rows])
    near = float(np.diff(levels).min()) if len(levels) > 1 else float(levels[0])
    facts = "a dot per run that stands; bars: 16, 50 and 84 % of all runs of a level; above: share in which blocks fell"
    figure, panels = sheet(f"{study.asked.title}: stripes", facts, len(columns))
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
                _draw_bars(axes, one, 0.3 * near, [factor * value for value in quantiles(everything, QUANTILES)])
            fell = int(study.collapsed[stripe].sum())
            if fell:
                axes.annotate(
                    f"{100 * fell / int(stripe.sum()):.0f} %", (one, 1.0), (0, 3), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="center", fontsize=8.5, color="#a33c00",
                )  # fmt: skip
        axes.set_yscale("log")
        for k, limit in _limits(study, column):
            draw_limit_line(axes, limit, k, factor, across=True)
        logarithmic(axes.yaxis)
        axes.set_xlim(max(0.0, levels[0] - near), levels[-1] + near)
        format_axes(axes, words, label(str(study.asked.measure)) if study.asked.measure else "level")
    save(figure, path)


def _draw_bars(axes: Any, at: float, half: float, three: Sequence[float]) -> None:
    """The quantiles of a stripe; those that are infinite are left out."""
    for value, width in zip(three, (1.2, 2.4, 1.2), strict=True):
        if np.isfinite(value):
            axes.plot([at - half, at + half], [value, value], color=INK, linewidth=width, solid_capstyle="butt", zorder=4)
    if np.isfinite(three[2]):
        axes.plot([at, at], [three[0], three[2]], color=INK, linewidth=0.9, zorder=3.5)


def draw_spread(found: Findings, path: Path) -> None:
    """Draw how each quantity is distributed over the runs: their share up to a value, the median and the quartiles."""
    study, columns = found.study, found.quantities
    figure, panels = sheet(f"{study.asked.title}: spread over the runs", "share of the runs up to a value; marks: quartiles", len(columns))
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
                draw_limit_line(axes, limit, place, factor, across=False)
        axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
        axes.margins(x=0.12)
        format_axes(axes, "runs" if axes is panels[0] else "", words)
        axes.text(0.99, 0.03, f"{len(own)} runs", transform=axes.transAxes, fontsize=9.5, color=FAINT, ha="right")
    save(figure, path)


def draw_tornado(found: Findings, path: Path) -> None:
    """Draw the rank correlations, a panel per quantity, the strongest on top."""
    rows, title = found.correlations, found.study.asked.title
    columns = list(dict.fromkeys(row.quantity for row in rows))[:PANELS]
    groups = [[row for row in rows if row.quantity == column][:BARS] for column in columns]
    tall = 2.3 + 0.34 * max(len(group) for group in groups)
    facts = "Spearman's rank correlation; whiskers: 95 %, bootstrap over records; diamond: effect of the study's measure removed"
    figure, panels = sheet(f"{title}: what matters", facts, len(columns), (max(8.4, 1.4 + 4.9 * len(columns)), tall))
    for axes, column, group in zip(panels, columns, groups, strict=True):
        format_axes(axes, "", f"rank correlation with {quantity(column)[0].split(' [')[0]}")
        _draw_correlations(axes, group)
    add_legend(panels[0], 3, bbox_to_anchor=(0.0, -0.55 / (tall - 1.7)))
    save(figure, path)


def _draw_correlations(axes: Any, group: Sequence[RankCorrelation]) -> None:
    """A panel."""
    named = set()
    for k, row in enumerate(group):
        label = None if row.kind in named else KINDS[row.kind]
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
        text.set_color(INK)
    axes.set_ylim(len(group) - 0.4, -0.6)
    axes.set_xlim(-1.04, 1.04)
    axes.set_xticks([-1.0, -0.5, 0.0, 0.5, 1.0])
    axes.grid(axis="y", visible=False)
