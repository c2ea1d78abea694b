# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a sweep: how much a block moves relative to the base by frequency, in a run and in its linear model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reports.drawing.figure import FAINT, INK, plain_axes, save
from reports.drawing.plots import colour, legend, sheet


def sweep_picture(found: Mapping[str, Any], path: Path) -> None:
    """Draw what :func:`masonry_cd.studies.vibration.vibration` found in a sweep into a PNG.

    Raises:
        InputError: a file that cannot be written.
    """
    rows, axis = found["sweep"], found["direction"]
    f, own, linear = (np.array([row[key] for row in rows]) for key in ("frequency_hz", "nscd_ratio", "linear_ratio"))
    facts = f"block {found['block']} along {axis}; base moved by v(t) = C sin(2 pi f t), C = {found['velocity']:.3g} m/s"
    figure, (axes,) = sheet(f"Sweep: {found['title']}", facts, size=(11.0, 6.4))
    axes.plot(f, linear, color=FAINT, linewidth=1.6, label="linear: rigid blocks on the same elastic joints, never open")
    axes.plot(f, own, color=colour(0), linewidth=1.2, marker="o", markersize=5, label="run: joints that open and slide")
    axes.set_yscale("log")
    axes.set_xlim(0.0, 1.03 * f[-1])
    for row in found["modes"]:
        if row["linear_hz"] <= f[-1] and row[f"mass_{axis}"] > 0.01:
            axes.axvline(row["linear_hz"], color=FAINT, linewidth=0.8, linestyle=":")
            words, place = f"mode {row['mode']}: {row['linear_hz']:.4g} Hz\nrun {row['nscd_hz']:.4g} Hz", (row["linear_hz"], 0.03)
            axes.annotate(words, place, (5, 0), ("data", "axes fraction"), "offset points", fontsize=10, color=INK)
    plain_axes(axes, "largest displacement relative to the base,\nover that of the base", "frequency of the base [Hz]")
    legend(axes, 2)
    save(figure, path)
