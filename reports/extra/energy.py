# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of a run over time: what was put in, where it went, and how well the account closes
(:mod:`masonry_cd.mechanics.dynamics.moreau_jean`).

    put in = work of the supports + work of gravity (+ of point loads and ties)  =  kinetic + friction + impact (+ stored) + balance

The losses lie on top of each other, so that their upper edge should follow the line of what was put in; the balance, what is left over, has
a panel of its own as a share of the largest work. The work of gravity is taken without the lifts that take overlaps away (a correction of
positions, not of velocities): what these put in is drawn beside it, where there are any.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from reports.drawing.figure import COLOURS, INK, blank, plain_axes, save, zero_line
from reports.extra import ExtraReport

WORKS = (("base_work", "work of the base", "-"), ("gravity_work", "work of gravity", "--"), ("force_work", "work of forces", "-."))
LIFT = (("correction", "lifts out of overlaps"),)
GOES = (
    ("impact", "lost in impacts"), ("friction", "lost in friction"), ("damping", "lost in damping"), ("elastic", "stored in joints"),
    ("kinetic", "kinetic"),
)  # fmt: skip
POINTS = 4000  # steps drawn at most; more of them share a pixel


def energy_picture(results: Results, path: Path) -> None:
    """Draw the energies of a run into a PNG.

    Raises:
        InputError: a run without a step, or a file that cannot be written.
    """
    save(energy_figure(results), path)


def energy_figure(results: Results) -> Any:
    """The energies of a run as a figure of matplotlib.

    Raises:
        InputError: a run without a step.
    """
    time, energy = energies(results)
    if not len(time):
        raise InputError(f"{results.path}: the run made no step: there is no energy to draw")
    figure = blank((12.0, 8.2), 110)
    figure.subplots_adjust(left=0.09, right=0.83, bottom=0.08, top=0.88, hspace=0.34)
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(3.2, 2.2, 1.1))
    works, goes = _present(energy, [(key, words) for key, words, _ in WORKS]), _present(energy, GOES)
    factor, unit = _unit(max(float(np.abs(energy[key]).max()) for key, _ in (*works, *goes)))
    put_in = factor * sum((energy[key] for key, _ in works), np.zeros(len(time)))
    colours = {key: COLOURS[k] for keys in (GOES, [(key, words) for key, words, _ in reversed(WORKS)]) for k, (key, _) in enumerate(keys)}
    upper.stackplot(time, [factor * energy[key] for key, _ in goes], colors=[colours[key] for key, _ in goes], alpha=0.75, linewidth=0)
    upper.plot(time, put_in, color=INK, linewidth=1.4, linestyle="--")
    ends = np.cumsum([0.0, *(factor * energy[key][-1] for key, _ in goes)])
    names = [(0.5 * (ends[k] + ends[k + 1]), words, colours[key]) for k, (key, words) in enumerate(goes)]
    _names(upper, [*names, (float(put_in[-1]), "put in", INK)])
    strokes = {key: stroke for key, _, stroke in WORKS} | {"correction": ":"}
    colours["correction"] = INK
    works += _present(energy, LIFT)
    for key, _ in works:
        middle.plot(time, factor * energy[key], color=colours[key], linestyle=strokes[key], linewidth=1.8)
    _names(middle, [(factor * float(energy[key][-1]), words, colours[key]) for key, words in works])
    largest = max(float(np.abs(energy[key]).max()) for key in ("kinetic", *(key for key, _ in works)))
    lower.plot(time, energy["balance"] / largest if largest > 0.0 else energy["balance"], color=INK, linewidth=1.2)
    for axes, words in ((upper, f"where it went [{unit}]"), (middle, f"put in [{unit}]"), (lower, "balance\n[share of the\nlargest work]")):
        plain_axes(axes, words, "time [s]" if axes is lower else "")
        zero_line(axes)
    figure.text(0.02, 0.955, f"Energy: {results.title}", fontsize=15, fontweight="bold", color=INK, va="center", parse_math=False)
    return figure


def energies(results: Results) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times of the steps [s] and the energies after them [J], thinned evenly to POINTS."""
    time, energy = results.per_step("step_time"), results.energies
    count = min(map(len, (time, *energy.values())))  # of a run that an older version made and that was killed
    kept = np.unique(np.linspace(0, count - 1, min(count, POINTS)).round().astype(np.int64)) if count else np.zeros(0, dtype=np.int64)
    return time[:count][kept], {name: values[:count][kept] for name, values in energy.items()}


def _present(energy: dict[str, np.ndarray], asked: Any) -> list[tuple[str, str]]:
    """Those that the run has; the kinetic energy and the work of the supports always, others where they are not nothing throughout."""
    always = ("kinetic", "base_work", "gravity_work", "friction", "impact")
    return [(key, words) for key, words in asked if key in energy and (key in always or energy[key].any())]


def _unit(largest: float) -> tuple[float, str]:
    """Factor and name of the unit in which a largest energy reads well."""
    for factor, unit in ((1e-6, "MJ"), (1e-3, "kJ"), (1.0, "J"), (1e3, "mJ")):
        if largest * factor >= 1.0:
            return factor, unit
    return 1e6, "µJ"


def _names(axes: Any, ends: list[tuple[float, str, str]]) -> None:
    """Write names beside the ends of lines and areas, apart enough to be read."""
    low, high = axes.get_ylim()
    pitch = 0.075 * (high - low) * (3.2 if axes.get_subplotspec().rowspan.start == 0 else 4.4) / 3.2
    places: list[float] = []
    for value, name, colour in sorted(ends, key=lambda end: end[0]):
        places.append(max(value, places[-1] + pitch) if places else value)
        axes.annotate(
            name, (1.015, places[-1]), xycoords=("axes fraction", "data"), fontsize=11.5, fontweight="bold", color=colour, va="center",
            annotation_clip=False,
        )  # fmt: skip


def _write(results: Results, folder: Path) -> None:
    """Draw the picture into the folder of the run."""
    energy_picture(results, folder / FILE)


FILE = "energy.png"
REPORTS = {"energy": ExtraReport((FILE,), _write, "what was put in over time, where it went, and how well the account closes")}
