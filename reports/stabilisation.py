# SPDX-License-Identifier: GPL-3.0-or-later
"""The stabilisation diagram: poles of an ambient record over the order of the model, the modes among them, and the record's spectrum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.signal import welch

from masonry_cd.analysis.modal.ambient import AmbientRecord, Identification
from reports.drawing.figure import FAINT, INK, save
from reports.drawing.plots import PALE, add_legend, colour, sheet

LINES = 100  # of the spectrum between 0 and the lowest frequency and as wide up to the highest, at most


def draw_stabilisation(found: Identification, record: AmbientRecord, path: Path, title: str) -> None:
    """Draw the stabilisation diagram of a record into a PNG.

    Raises:
        InputError: matplotlib is not installed, or a path that cannot be written.
    """
    facts = (
        f"{len(record.values) * record.step:.4g} s of {record.values.shape[1]} channels at {found.rate:.4g} Hz · {found.rows} block rows · "
        f"modes: stable at a third of {found.orders} orders or more"
    )
    figure, (axes,) = sheet(title, facts, size=(10.0, 5.8))
    power = axes.twinx()
    axes.set_zorder(power.get_zorder() + 1)
    axes.patch.set_visible(False)
    length = min(len(record.values), 2 ** int(np.log2(LINES / (found.band[0] * record.step))))
    frequency, density = welch(record.values, 1.0 / record.step, nperseg=length, axis=0)
    seen = (frequency >= found.band[0]) & (frequency <= found.band[1])
    power.semilogy(frequency[seen], density.sum(axis=1)[seen], color=FAINT, linewidth=0.8, alpha=0.6)
    power.set_ylabel("spectral density, sum of the channels [(m/s²)²/Hz]", color=FAINT)
    look = {"linestyle": "none", "markersize": 3.5}
    axes.plot(found.frequency[~found.stable], found.order[~found.stable], "o", color=PALE, label="pole", **look)
    axes.plot(found.frequency[found.stable], found.order[found.stable], "o", color=colour(0), label="stable pole", **look)
    for k, mode in enumerate(found.modes, start=1):
        axes.axvline(mode.frequency, color=colour(1), linewidth=1.0, label="" if k > 1 else "identified mode")
        axes.annotate(
            f"{k}", (mode.frequency, 1.0), (0, 3), xycoords=("data", "axes fraction"), textcoords="offset points", ha="center", color=INK
        )
    axes.set(xlim=found.band, xlabel="frequency [Hz]", ylabel="order of the model", ylim=(0, 2 * found.orders + 2))
    add_legend(axes, 3)
    save(figure, path)
