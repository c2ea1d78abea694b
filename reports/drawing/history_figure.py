# SPDX-License-Identifier: GPL-3.0-or-later
"""How some blocks move relative to the base over time, above the velocity of the base."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.figures import blank
from masonry_cd.io.results import Results
from reports.drawing.figure import COLOURS, INK, draw_zero_line, format_axes
from reports.drawing.plots import STROKES, add_heading

AXES = "xyz"


def history_figure(results: Results, names: Sequence[str] = (), axis: str = "") -> Any:
    """A figure of matplotlib, of some blocks, by default the highest free one, along an axis, by default that along which they move most.

    Raises:
        InputError: no block has a name, or no such axis.
    """
    run, time = Measured(results), np.asarray(results.time, dtype=float)
    known = [block.name for block in results.blocks]
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise InputError("", f'no block is named "{unknown}"{suggest(unknown, known)}; the first are {", ".join(known[:5])}')
    if axis and axis not in tuple(AXES):
        raise InputError("axis", f'"{axis}" is not an axis; choose x, y or z')
    chosen = [known.index(name) for name in names] or [run.highest]
    moved = np.stack([run.moved(block) for block in chosen], axis=1)  # (F, n, 3) relative to the base [m]
    held = results.support  # whose velocity is that of the base [m/s]
    velocity = np.asarray(results.velocity[: results.frames, held, :3], dtype=float) if held >= 0 else np.zeros((results.frames, 3))
    along = AXES.index(axis) if axis else int(np.argmax(np.abs(moved).max(axis=(0, 1))))
    figure = blank((11.0, 6.2), 110, layout="constrained")
    add_heading(figure, f"Displacement relative to the base: {results.title}")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1.0))
    values = moved[:, :, along]
    factor, unit = (1000.0, "mm") if np.abs(values).max(initial=0.0) < 0.5 else (1.0, "m")
    for k, block in enumerate(chosen):
        label, colour = results.blocks[block].name, COLOURS[k % len(COLOURS)]
        stroke = STROKES[k // len(COLOURS) % len(STROKES)]
        upper.plot(time, factor * values[:, k], label=label, color=colour, linestyle=stroke, linewidth=1.6)
    upper.legend(fontsize=10, frameon=False, ncols=min(6, len(chosen)), loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    lower.plot(time, velocity[:, along], color=INK, linewidth=1.3)
    for axes, words in ((upper, f"displacement along {AXES[along]} [{unit}]"), (lower, f"velocity of the\nbase along {AXES[along]} [m/s]")):
        format_axes(axes, words, "time [s]" if axes is lower else "")
        draw_zero_line(axes)
    return figure
