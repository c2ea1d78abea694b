# SPDX-License-Identifier: GPL-3.0-or-later
r"""NTC 2018, 3.2.3.2; the shape is that of :mod:`loads.signal.spectra.shape`.

level:     a = ag SS ST,    s = 1,       P = F0;      T_C = CC TC*, T_B = T_C / 3, T_D = 4 ag/g + 1.6
vertical:  a = ag ST,       s = FV / F0, P = FV;      FV = 1.35 F0 sqrt(ag/g); SS = 1
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np

from loads.motion import STANDARD_GRAVITY, Positive
from loads.signal.spectra.kind import Fact, SiteKeys, SpectrumKind, ag_and_ground, by_ag
from loads.signal.spectra.shape import LONG_PERIODS, PEAK, VERTICAL_PERIODS, CodeQuantity, CodeSpectrum, common_rows
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Usual

AMPLIFICATION = {  # SS = low <= base - slope F0 ag/g <= high (table 3.2.IV)
    "A": (1.0, 0.0, 1.0, 1.0),
    "B": (1.4, 0.4, 1.0, 1.2),
    "C": (1.7, 0.6, 1.0, 1.5),
    "D": (2.4, 1.5, 0.9, 1.8),
    "E": (2.0, 1.1, 1.0, 1.6),
}
PERIOD = {"A": (1.0, 0.0), "B": (1.1, -0.20), "C": (1.05, -0.33), "D": (1.25, -0.50), "E": (1.15, -0.40)}  # CC = factor TC*^power
TOPOGRAPHY = {"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4}  # ST (table 3.2.V)
CLAUSE = "NTC 2018, 3.2.3.2"
ROWS = {
    "ag": CodeQuantity("m/s2", "NTC 2018, 3.2", "peak acceleration on rock, of site and limit state"),
    "F0": CodeQuantity("", "NTC 2018, 3.2", "largest amplification, of site and limit state"),
    "TC*": CodeQuantity("s", "NTC 2018, 3.2", "where constant velocities begin on rock, of site and limit state"),
    "SS": CodeQuantity("", "NTC 2018, table 3.2.IV", "soil factor"),
    "ST": CodeQuantity("", "NTC 2018, table 3.2.V", "factor of topography"),
    "S": CodeQuantity("", CLAUSE, "both", "SS ST"),
    "CC": CodeQuantity("", "NTC 2018, table 3.2.IV", "by which the soil stretches TC*"),
    "TC": CodeQuantity("s", CLAUSE, "where the plateau ends", "CC TC*"),
    "TB": CodeQuantity("s", CLAUSE, "where it begins", "TC / 3"),
    "TD": CodeQuantity("s", CLAUSE, "where constant displacements begin", "4 ag / g + 1.6"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "S ag"),
} | common_rows(CLAUSE)


class NtcKeys(SiteKeys):
    """Keys of NTC alone."""

    f0: Positive | None = None
    """Largest amplification at the site, NTC only."""
    tc_star: Annotated[Span, Usual(0.05, 2.0, "T*_C is 0.1 to 1 s", ("ms",))] | None = None
    """Period at which the constant velocity of the spectrum begins at the site, NTC only."""
    topography: Literal["T1", "T2", "T3", "T4"] | None = None
    """Category of the site, NTC only; T1 when not given."""


def ntc(
    ag: float,
    f0: float,
    tc_star: float,
    ground: str = "A",
    topography: str = "T1",
    vertical: bool = False,
    gravity: float = STANDARD_GRAVITY,
) -> CodeSpectrum:
    """The spectrum of the site's ag [m/s2], F0 and TC* [s], category of ground A to E and of topography T1 to T4; gravity [m/s2]."""
    share, hill = ag / gravity, TOPOGRAPHY[topography]
    if vertical:
        fv = 1.35 * f0 * np.sqrt(share)
        return CodeSpectrum(ag * hill, float(fv / f0), float(fv), VERTICAL_PERIODS)
    base, slope, low, high = AMPLIFICATION[ground]
    soil = float(np.clip(base - slope * f0 * share, low, high))
    factor, power = PERIOD[ground]
    stretch = factor * tc_star**power
    tc = stretch * tc_star
    return CodeSpectrum(ag * soil * hill, 1.0, f0, (tc / 3.0, tc, 4.0 * share + 1.6), LONG_PERIODS[ground], soil, hill, stretch)


def _made(keys: NtcKeys, vertical: bool, gravity: float) -> CodeSpectrum:
    assert keys.ag is not None and keys.f0 is not None and keys.tc_star is not None
    return ntc(keys.ag, keys.f0, keys.tc_star, keys.ground, keys.topography or "T1", vertical, gravity)


def _facts(keys: NtcKeys, found: CodeSpectrum) -> Iterator[Fact]:
    assert keys.ag is not None and keys.tc_star is not None
    base, slope, low, high = AMPLIFICATION[keys.ground]
    factor, power = PERIOD[keys.ground]
    begin, end, far = found.corners
    yield "ag", keys.ag
    yield "F0", found.plateau
    yield "TC*", keys.tc_star
    yield "SS", found.soil, f"min(max({base:g} - {slope:g} F0 ag / g, {low:g}), {high:g})" if slope else ""
    yield "ST", found.hill
    yield "S", found.soil * found.hill
    yield "CC", found.stretch, f"{factor:g} TC*^({power:g})" if power else ""
    yield "TC", end
    yield "TB", begin
    yield "TD", far


SPECTRA = {
    "NTC": SpectrumKind(
        NtcKeys,
        ("ag", "f0", "tc_star"),
        _made,
        ROWS,
        _facts,
        lambda keys, _: keys.ag,
        by_ag,
        ("topography",),
        "ABCDE",
        vertical=True,
        words=ag_and_ground,
    )
}
