# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as people read them: lengths, forces and stresses with a prefix, shares in per cent, time spans in hours, minutes and seconds."""

from __future__ import annotations

import math

PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}


def _prefixed(value: float, unit: str, *prefixes: str) -> str:
    """A number by the first of some prefixes, the largest first, with which it is one at least; by the last where it is with none."""
    prefix = next((each for each in prefixes if abs(value) >= PREFIXES[each] * 0.9995), prefixes[-1])
    return f"{value / PREFIXES[prefix]:.3g} {prefix}{unit}"


def length(value: float, unit: str = "m") -> str:
    """A length, a speed or a time: ``1.2 mm``, ``0.5 m``, ``4.59 km``, ``30 us``; what is but rounding as ``under 1 nm``."""
    value += 0.0  # zero without a sign
    if 0.0 < abs(value) < PREFIXES["n"] * 0.9995:
        return f"under 1 n{unit}"
    return _prefixed(value, unit, "k", "", "m", "u", "n") if value and math.isfinite(value) else f"{value:g} {unit}"


def force(value: float) -> str:
    """A force: ``1.05 MN``, ``12 kN``, ``0.3 N``."""
    return _prefixed(value, "N", "M", "k", "")


def stiffness(value: float, unit: str = "N/m") -> str:
    """A stiffness, of a spring or per area: ``120 MN/m``, ``18 GN/m3``."""
    return _prefixed(value, unit, "G", "M", "k", "")


def pressure(value: float) -> str:
    """A stress: ``1.05 MPa``, ``12 kPa``, ``0.3 Pa``; ``infinite`` where it is."""
    return "infinite" if math.isinf(value) else _prefixed(value, "Pa", "G", "M", "k", "")


def per_cent(share: float) -> str:
    """A share of something whole, ``62.5 %``; less than 0.005 % is written as 0."""
    return f"{round(100.0 * share, 2):.4g} %"


def counted(number: int, noun: str) -> str:
    """A number of things whose plural ends in s: ``1 joint``, ``12 joints``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


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


def finite(value: float) -> float | None:
    """A number as files have it, or nothing where there is none."""
    return float(value) if math.isfinite(value) else None
