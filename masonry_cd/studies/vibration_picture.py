# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a sweep: how much a block moves relative to the base by frequency, in a run and in its linear model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.figures import blank
from reports.drawing.figure import COLOURS, FAINT, INK


def sweep_picture(found: Mapping[str, Any], path: Path) -> None:
    """Draw what :func:`masonry_cd.studies.vibration.vibration` found in a sweep into a PNG.

    Raises:
        InputError: a file that cannot be written.
    """
    rows, axis = found["sweep"], found["direction"]
    f, own, linear = (np.array([row[key] for row in rows]) for key in ("frequency_hz", "nscd_ratio", "linear_ratio"))
    figure = blank((11.0, 6.2), 110)
    axes = figure.add_axes((0.1, 0.11, 0.86, 0.73))
    axes.plot(f, linear, color=FAINT, linewidth=1.6, label="linear: rigid blocks on the same elastic joints, never open")
    axes.plot(f, own, color=COLOURS[0], linewidth=1.2, marker="o", markersize=5, label="run: joints that open and slide")
    axes.set_yscale("log")
    axes.set_xlim(0.0, 1.03 * f[-1])
    for row in found["modes"]:
        if row["linear_hz"] <= f[-1] and row[f"mass_{axis}"] > 0.01:
            axes.axvline(row["linear_hz"], color=FAINT, linewidth=0.8, linestyle=":")
            words = f"mode {row['mode']}: {row['linear_hz']:.4g} Hz\nrun {row['nscd_hz']:.4g} Hz"
            place = (row["linear_hz"], 0.03)
            axes.annotate(
                words, place, xycoords=("data", "axes fraction"), xytext=(5, 0), textcoords="offset points", fontsize=10, color=INK
            )
    axes.set_xlabel("frequency of the base [Hz]", fontsize=12, color=INK)
    axes.set_ylabel("largest displacement relative to the base,\nover that of the base", fontsize=12, color=INK)
    axes.tick_params(labelsize=10.5, colors=FAINT)
    axes.grid(color="#e8eaed", linewidth=0.8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_ylim(top=4.0 * axes.get_ylim()[1])  # room for the legend above the peak
    axes.legend(frameon=False, fontsize=11, loc="upper left")
    figure.text(0.02, 0.945, f"Sweep: {found['title']}", fontsize=15, fontweight="bold", color=INK, va="center")
    words = f"block {found['block']} along {axis}; base moved by v(t) = C sin(2 pi f t), C = {found['velocity']:.3g} m/s"
    figure.text(0.02, 0.895, words, fontsize=11, color=INK, va="center")
    try:
        with replacing(path) as part:
            figure.savefig(part)
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}") from None
