# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of a run over time: the work done, where it went, and the error of the balance
(:mod:`masonry_cd.mechanics.dynamics.moreau_jean`).

    put in = work of the supports + work of gravity (+ of point loads and ties)  =  kinetic + friction + impact (+ stored) + balance

The losses lie on top of each other, so that their upper edge should follow the line of what was put in; the balance, what is left over, has
a panel of its own as a share of the largest work. The work of gravity is taken without the lifts that take overlaps away (a correction of
positions, not of velocities): what these put in is drawn next to it, where there are any.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.figures import blank
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.energy_terms import LIFT, LOSSES, WORKS
from reports.drawing.figure import INK, draw_zero_line, format_axes, save
from reports.drawing.palette import ENERGIES
from reports.drawing.plots import STROKES, add_heading, colour
from reports.files import Job, Output

GOES = dict(reversed(LOSSES.items()))  # from below
HUES = dict(zip(GOES, ENERGIES, strict=True))
UNITS = ((1e-6, "MJ"), (1e-3, "kJ"), (1.0, "J"), (1e3, "mJ"), (1e6, "µJ"))
POINTS = 4000  # steps drawn at most; more of them share a pixel


def energy_figure(results: Results) -> Any:
    """The energies of a run as a figure of matplotlib.

    Raises:
        InputError: a run without a step.
    """
    time, energy = energies(results)
    if not len(time):
        raise InputError(results.path, "the run made no step, so there is no energy to draw")
    works, goes = _present(energy, WORKS), _present(energy, GOES)
    size = max(float(np.abs(energy[key]).max()) for key in (*works, *goes))
    factor, unit = next((row for row in UNITS if size * row[0] >= 1.0), UNITS[-1])
    put_in = factor * sum((energy[key] for key in works), np.zeros(len(time)))
    figure = blank((12.0, 8.2), 110, layout="constrained")
    add_heading(figure, f"Energy: {results.title}")
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(3.2, 2.2, 1.1))
    hues, labels = [HUES[key] for key in goes], [GOES[key] for key in goes]
    upper.stackplot(time, [factor * energy[key] for key in goes], colors=hues, labels=labels, alpha=0.75, linewidth=0)
    upper.plot(time, put_in, color=INK, linewidth=1.4, linestyle="--", label="put in")
    for k, key in enumerate([*works, *_present(energy, LIFT)]):
        look = {"color": INK, "linestyle": ":"} if key in LIFT else {"color": colour(2 - k), "linestyle": STROKES[(0, 1, 3, 2)[k % 4]]}
        middle.plot(time, factor * energy[key], linewidth=1.8, label=(WORKS | LIFT)[key], **look)
    largest = max(float(np.abs(energy[key]).max()) for key in ("kinetic", *works, *_present(energy, LIFT)))
    lower.plot(time, energy["balance"] / largest if largest > 0.0 else energy["balance"], color=INK, linewidth=1.2)
    for axes, words in ((upper, f"where it went [{unit}]"), (middle, f"put in [{unit}]"), (lower, "balance\n[share of the\nlargest work]")):
        format_axes(axes, words, "time [s]" if axes is lower else "")
        draw_zero_line(axes)
    for axes in (upper, middle):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), reverse=True, fontsize=11, frameon=False)
    return figure


def energies(results: Results) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times of the steps [s] and the energies after them [J], thinned evenly to POINTS."""
    time, energy = results.per_step("step_time"), results.energies
    count = min(map(len, (time, *energy.values())))  # of a run that an older version made and that was killed
    kept = np.unique(np.linspace(0, count - 1, min(count, POINTS)).round().astype(np.int64)) if count else np.zeros(0, dtype=np.int64)
    return time[:count][kept], {name: values[:count][kept] for name, values in energy.items()}


def _present(energy: Mapping[str, np.ndarray], asked: Mapping[str, str]) -> list[str]:
    """Those that the run has; the kinetic energy and the work of the supports always, others where they are not nothing throughout."""
    always = ("kinetic", "base_work", "gravity_work", "friction", "impact")
    return [key for key in asked if key in energy and (key in always or energy[key].any())]


def _write(job: Job) -> Iterable[Path]:
    save(energy_figure(job.results), job.folder / FILE)
    return [job.folder / FILE]


FILE = "energy.png"
OUTPUTS = {
    "energy": Output({FILE: "energy over time: the work done, where it went, and the error of the balance"}, _write, needs=("matplotlib",))
}
