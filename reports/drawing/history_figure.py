# SPDX-License-Identifier: GPL-3.0-or-later
"""How some blocks move relative to the base over time, above the velocity of the base."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.io.results import Results
from reports.drawing.figure import COLOURS, INK, blank, plain_axes, zero_line

AXES = "xyz"
STROKES = ("-", "--", ":", "-.")


def history_figure(results: Results, names: Sequence[str] = (), axis: str = "") -> Any:
    """A figure of matplotlib.

    Args:
        results: of a run.
        names: of the blocks; by default the highest free one.
        axis: x, y or z; by default the one along which these blocks move most.

    Raises:
        InputError: no block has a name, or no such axis.
    """
    run, time = Measured(results), np.asarray(results.time, dtype=float)
    chosen = _chosen(run, names)
    moved = np.stack([run.moved(block) for block in chosen], axis=1)  # (F, n, 3) relative to the base [m]
    held = results.support  # whose velocity is that of the base [m/s]
    velocity = np.asarray(results.velocity[: results.frames, held, :3], dtype=float) if held >= 0 else np.zeros((results.frames, 3))
    along = _axis(axis, moved)
    figure = blank((11.0, 6.2), 110)
    figure.subplots_adjust(left=0.09, right=0.97, bottom=0.09, top=0.86, hspace=0.3)
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
        plain_axes(axes, words, "time [s]" if axes is lower else "")
        zero_line(axes)
    heading = f"Displacement relative to the base: {results.title}"
    figure.text(0.02, 0.96, heading, fontsize=15, fontweight="bold", color=INK, va="center", parse_math=False)
    return figure


def _chosen(run: Measured, names: Sequence[str]) -> list[int]:
    """Indices of the blocks."""
    known = [block.name for block in run.results.blocks]
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise InputError(f'no block is named "{unknown}"{suggest(unknown, known)}; the first are {", ".join(known[:5])}')
    return [known.index(name) for name in names] or [run.highest]


def _axis(asked: str, moved: np.ndarray) -> int:
    """Index of the axis."""
    if not asked:
        return int(np.argmax(np.abs(moved).max(axis=(0, 1))))
    if asked not in AXES or len(asked) != 1:
        raise InputError(f'axis: "{asked}" is none; x, y or z')
    return AXES.index(asked)
