# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of a time step that adapts: for summary.json, the closing lines, and the line that announces a run."""

from __future__ import annotations

from typing import Any

from masonry_cd.app.run_report import RunReport
from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.dynamics.settings import Run


def time_step_summary(settings: Run, report: RunReport, tolerance: float) -> dict[str, Any]:
    """For the summary; a run of fixed steps gets none of it. ``tolerance`` of the local error [m]."""
    if not settings.adaptive:
        return {}
    lengths = sorted((int(span), count) for span, count in report.spans.items())
    taken = [span for span, _ in lengths] or [1]
    return {
        "time_step": {
            "shortest": taken[0] * settings.dt,
            "median": _median(lengths) * settings.dt,
            "longest": taken[-1] * settings.dt,
            "dt_min": settings.dt,
            "dt_max": settings.longest_step,
            "tolerance": tolerance,
            "local_error_max": report.local_error_max,
            "repeated_for_error": report.repeated_error,
            "repeated_for_solver": report.repeated_solver,
            "steps_wanted_shorter": report.steps_too_long,
            "base_drift_max": report.base_drift_max,
            "steps_by_length": [{"dt": span * settings.dt, "steps": count} for span, count in lengths],
        }
    }


def _median(lengths: list[tuple[int, int]]) -> int:
    """The middle length of steps given as (length, how many), sorted."""
    half, passed = 0.5 * sum(count for _, count in lengths), 0
    for span, count in lengths:
        passed += count
        if passed >= half:
            return span
    return 1


def announced(settings: Run) -> str:
    """The steps that a run is about to make."""
    if settings.adaptive:
        return f"{settings.steps * settings.dt:g} s in steps of {length(settings.dt, 's')} to {length(settings.longest_step, 's')}"
    return f"{settings.steps} steps of {settings.dt:g} s"


def steps_in_words(summary: dict[str, Any]) -> str:
    """The steps of a run and their length."""
    found = summary.get("time_step")
    if not found:
        return f"{summary['steps']} steps of {length(summary['dt'], 's')}"
    between = f"{length(found['shortest'], 's')} to {length(found['longest'], 's')}"
    return f"{summary['steps']} steps of {between} (median {length(found['median'], 's')})"


def time_step_lines(summary: dict[str, Any]) -> list[str]:
    """How the lengths of the steps were found, in words."""
    found = summary.get("time_step")
    if not found:
        return []
    solver, error, bound = found["repeated_for_solver"], found["repeated_for_error"], found["steps_wanted_shorter"]
    return [
        f"time steps: local error {length(found['local_error_max'])} at most, {length(found['tolerance'])} aimed at; "
        f"{error or 'none'} repeated for it, {solver or 'none'} for the solver; "
        f"{bound or 'none'} at the shortest, {length(found['dt_min'], 's')}, that should have been shorter; "
        f"supports off their motion by {length(found['base_drift_max'])} at most"
    ]
