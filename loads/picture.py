# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of an accelerogram before and after its processing: acceleration, velocity, displacement, response spectrum, intensity.

matplotlib is imported here, inside the function, and drawn without a display.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from loads.motion import ROUNDING
from loads.signal.accelerogram import Accelerogram, Processed, process
from loads.signal.baseline import GroundHistory
from loads.signal.intensity import arias, significant_window
from loads.signal.response import default_periods, response_spectrum
from loads.signal.spectra.shape import ElasticSpectrum
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, in_a_line, parse_table
from masonry_cd.foundation.figures import blank

BEFORE, AFTER = "#9aa3ab", "#0b5fa5"
INK, FAINT = "#23272b", "#5f666d"
POINTS = 20_000  # drawn of a curve at most
DAMPING = 0.05
LONGEST_DRAWN = 4.0  # period of a spectrum that has no end [s]
DRIFTED = 8.0  # times the motion after correction: one before correction that is larger still may leave the picture


def draw_record(before: GroundHistory, after: GroundHistory, path: Path, title: str = "", begin: float = 0.0) -> None:
    """Draw a PNG (or PDF, SVG, by the name's ending).

    Args:
        before: as read.
        after: as used.
        path: of the picture.
        title: what it shows.
        begin: time of the first sample on the axis [s].
    """
    figure = blank((13.0, 8.0), layout="constrained")
    grid = figure.add_gridspec(6, 2, width_ratios=(1.75, 1.0))
    rows = [figure.add_subplot(grid[2 * i : 2 * i + 2, 0]) for i in range(3)]
    for axes, name, unit in zip(rows, ("acceleration", "velocity", "displacement"), ("m/s²", "m/s", "m"), strict=True):
        _draw_histories(axes, before, after, name, f"{name} [{unit}]", begin)
    rows[0].sharex(rows[2])
    rows[1].sharex(rows[2])
    rows[2].set_xlabel("time [s]")
    for axes in rows[:2]:
        axes.tick_params(labelbottom=False)
    _draw_spectra(figure.add_subplot(grid[:4, 1]), before, after)
    _build_up(figure.add_subplot(grid[4:, 1]), after, begin)
    figure.suptitle(title, color=INK, fontsize=13, x=0.01, ha="left")
    try:
        with replacing(path) as part:
            figure.savefig(part, dpi=110)
    except OSError as failure:
        raise InputError(path, f"the picture cannot be written: {(failure.strerror or str(failure)).lower()}") from None
    except ValueError as failure:  # an ending that no picture has
        raise InputError(path, f"the picture cannot be written ({in_a_line(failure)})") from None


def file_picture(file: Path, picture: Path | None, dt: float = 1e-3, **keys: Any) -> Processed:
    """Read a record file and draw it, processed as a ``[[loads]]`` table of kind "record" with these keys would have it.

    Args:
        file: the record.
        picture: where to draw it; nowhere when not given.
        dt: time step of the run, for ``resample = "run"`` [s].
        keys: units, column, window, taper, resample, band, correction ..., see ``loads.signal.accelerogram``.

    Returns:
        What was read and what became of it, with its ``numbers()``.

    Raises:
        InputError: a bad key, or a bad file, named with its line.
    """
    table = parse_table(Accelerogram, {"path": file.name, **keys}, "record")
    processed = process(table, file.parent, dt, "record")
    if picture is None:
        return processed
    column = f" [{processed.column}]" if processed.column else ""
    done = [f"{table.correction} correction" if table.correction != "none" else "not corrected"]
    done += [f"{table.band[0]:g} to {table.band[1]:g} Hz"] if table.band else []
    draw_record(processed.before, processed.after, picture, f"{file.name}{column}: {', '.join(done)}", processed.begin)
    return processed


def spectrum_picture(spectrum: ElasticSpectrum, dampings: Sequence[float], title: str) -> Any:
    """A figure of accelerations and displacements over the period, a curve for each damping."""
    figure = blank((10.0, 4.2), layout="constrained")
    end = min(spectrum.longest, LONGEST_DRAWN)
    periods, shades = np.linspace(0.0, end, 1201), np.linspace(0.75, 0.0, len(dampings) + 1)[1:]
    for axes, values, label in zip(
        figure.subplots(1, 2), (spectrum.at, spectrum.displacement), ("pseudo-acceleration [m/s²]", "displacement [m]"), strict=True
    ):
        for damping, shade in zip(dampings, shades, strict=True):
            axes.plot(periods, values(periods, damping), color=AFTER, alpha=1.0 - shade, lw=1.6, label=f"damping {100.0 * damping:.3g} %")
        axes.set_xlabel("period [s]")
        axes.set_ylabel(label, color=INK)
        axes.set_xlim(0.0, end)
        axes.set_ylim(bottom=0.0)
        _format_axes(axes)
    axes.legend(frameon=False)
    figure.suptitle(title, color=INK, fontsize=12, x=0.01, ha="left")
    return figure


def _draw_histories(axes: Any, before: GroundHistory, after: GroundHistory, name: str, label: str, begin: float) -> None:
    """One quantity over time, with its peaks."""
    said, peaks = [], []
    for history, colour, width, word in ((before, BEFORE, 1.8, "before"), (after, AFTER, 0.9, "after")):
        values = getattr(history, name)
        peaks.append(float(np.abs(values).max()))
        end = values[-1] if abs(values[-1]) > ROUNDING * peaks[-1] else 0.0
        said.append(f"{word} {peaks[-1]:.3g}" + (f", end {end:.2g}" if name != "acceleration" else ""))
        axes.plot(*thin_curve(begin + history.step * np.arange(len(values)), values), color=colour, lw=width)
    if peaks[0] > DRIFTED * peaks[1] > 0.0:
        axes.set_ylim(-1.3 * peaks[1], 1.3 * peaks[1])
        said[0] += " (leaves the picture)"
    axes.axhline(0.0, color=FAINT, lw=0.5)
    axes.set_ylabel(label, color=INK)
    axes.set_title(f"peak {said[0]}; {said[1]}", fontsize=9, color=FAINT, loc="right")
    axes.margins(x=0.01)
    _format_axes(axes)


def _draw_spectra(axes: Any, before: GroundHistory, after: GroundHistory) -> None:
    """Pseudo-acceleration over the period."""
    periods = default_periods(120)
    for history, colour, width, word in ((before, BEFORE, 2.6, "before"), (after, AFTER, 1.3, "after")):
        spectrum = response_spectrum(history.acceleration, history.step, periods, DAMPING)
        axes.plot(periods, spectrum.acceleration, color=colour, lw=width, label=word)
    axes.set_xscale("log")
    axes.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0], ["0.02", "0.05", "0.1", "0.2", "0.5", "1", "2", "4"])
    axes.minorticks_off()
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("period [s]")
    axes.set_ylabel(f"pseudo-acceleration [m/s²], {100 * DAMPING:g} % damping", color=INK)
    axes.legend(frameon=False)
    _format_axes(axes)


def _build_up(axes: Any, after: GroundHistory, begin: float) -> None:
    """Arias intensity over time, with the significant duration."""
    built = arias(after)
    low, high = significant_window(after)
    axes.axvspan(begin + low, begin + high, color=AFTER, alpha=0.10, lw=0)
    axes.plot(*thin_curve(begin + after.step * np.arange(len(built)), built), color=AFTER, lw=1.4)
    axes.set_title(f"Arias intensity {built[-1]:.3g} m/s, 5 to 95 % in {high - low:.3g} s", fontsize=9, color=FAINT, loc="right")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("intensity [m/s]", color=INK)
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.01)
    _format_axes(axes)


def _format_axes(axes: Any) -> None:
    """Light lines, no frame."""
    axes.grid(color="#e3e6e8", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(colors=FAINT, labelsize=9)


def thin_curve(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep the smallest and largest value of each bin where a curve has more than POINTS samples, in their order.

    Args:
        times: (N,) [s].
        values: (N,) in any unit.
    """
    size = int(np.ceil(2 * len(values) / POINTS))
    if size <= 2:
        return times, values
    whole = len(values) // size * size
    bins = values[:whole].reshape(-1, size)
    order = np.sort(np.stack([bins.argmin(axis=1), bins.argmax(axis=1)], axis=1), axis=1)
    chosen = (order + size * np.arange(len(bins))[:, None]).ravel()
    return times[chosen], values[chosen]
