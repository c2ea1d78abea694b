# SPDX-License-Identifier: GPL-3.0-or-later
"""Quantities as people read them: lengths, speeds and forces with a prefix, time spans in hours, minutes and seconds."""

from __future__ import annotations

import math


def length(value: float, unit: str = "m") -> str:
    """A number with the prefix that reads best: ``1.2 mm``, ``0.5 m``, ``4.59 km``, ``30 us``; what is but rounding as ``under 1 nm``."""
    if not math.isfinite(value):
        return f"{value} {unit}"
    for factor, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n")):
        if abs(value) >= factor * 0.9995:
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"under 1 n{unit}" if value else f"0 {unit}"


def force(value: float) -> str:
    """A force with the prefix that reads best: ``1.05 MN``, ``12 kN``, ``0.3 N``."""
    for factor, prefix in ((1e6, "M"), (1e3, "k")):
        if abs(value) >= factor * 0.9995:
            return f"{value / factor:.3g} {prefix}N"
    return f"{value:.3g} N"


def counted(number: int, noun: str) -> str:
    """A number of things whose plural ends in s: ``1 joint``, ``12 joints``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def pressure(value: float) -> str:
    """A stress with the prefix that reads best: ``1.05 MPa``, ``12 kPa``, ``0.3 Pa``; ``infinite`` where it is."""
    if math.isinf(value):
        return "infinite"
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(value) >= factor * 0.9995:
            return f"{value / factor:.3g} {prefix}Pa"
    return f"{value:.3g} Pa"


def in_words(seconds: float) -> str:
    """A time span: ``0.24 s``, ``12.3 s``, ``4 min 5 s``, ``2 h 10 min``."""
    if seconds < 1:
        return f"{seconds:.2g} s"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def nice(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that does not exceed a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1 + 1e-9)) * power)


def next_step(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten after a value."""
    base = nice(value)
    first = round(base / 10.0 ** math.floor(math.log10(base) + 1e-9))
    return base * {1: 2.0, 2: 2.5, 5: 2.0}[first]


def classes(smallest: float, largest: float) -> list[float]:
    """Lower bounds of classes in steps of 1-2-5, from a smallest value to where the last, open class begins."""
    bounds = [smallest]
    while bounds[-1] < largest * (1 - 1e-9):
        bounds.append(next_step(bounds[-1]))
    return bounds
