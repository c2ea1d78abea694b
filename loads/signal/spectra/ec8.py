# SPDX-License-Identifier: GPL-3.0-or-later
r"""EN 1998-1:2004, 3.2.2.2 (3.2 to 3.5) and 3.2.2.3; the shape is that of :mod:`loads.signal.spectra.shape`.

level:     a = ag S,        s = 1,       P = 2.5;     S, T_B, T_C, T_D by type of spectrum and ground (tables 3.2 and 3.3)
vertical:  a = avg,         s = 1,       P = 3.0;     avg = 0.90 ag (type 1) or 0.45 ag (type 2), table 3.4
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from loads.signal.spectra.kind import Fact, SiteKeys, SpectrumKind, ag_and_ground, by_ag
from loads.signal.spectra.shape import LONG_PERIODS, PEAK, VERTICAL_PERIODS, CodeQuantity, CodeSpectrum, common_rows

LEVEL = {  # type of spectrum, ground: S, T_B, T_C, T_D
    (1, "A"): (1.0, 0.15, 0.4, 2.0),
    (1, "B"): (1.2, 0.15, 0.5, 2.0),
    (1, "C"): (1.15, 0.20, 0.6, 2.0),
    (1, "D"): (1.35, 0.20, 0.8, 2.0),
    (1, "E"): (1.4, 0.15, 0.5, 2.0),
    (2, "A"): (1.0, 0.05, 0.25, 1.2),
    (2, "B"): (1.35, 0.05, 0.25, 1.2),
    (2, "C"): (1.5, 0.10, 0.25, 1.2),
    (2, "D"): (1.8, 0.10, 0.30, 1.2),
    (2, "E"): (1.6, 0.05, 0.25, 1.2),
}
VERTICAL = {1: 0.90, 2: 0.45}  # avg / ag
CLAUSE = "EN 1998-1, 3.2.2.2"
ROWS = {
    "ag": CodeQuantity("m/s2", CLAUSE, "peak acceleration on rock"),
    "S": CodeQuantity("", CLAUSE, "soil factor, tables 3.2 and 3.3"),
    "TB": CodeQuantity("s", CLAUSE, "where the plateau begins"),
    "TC": CodeQuantity("s", CLAUSE, "where it ends"),
    "TD": CodeQuantity("s", CLAUSE, "where constant displacements begin"),
    "F0": CodeQuantity("", CLAUSE, "amplification of the plateau"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "S ag"),
} | common_rows(CLAUSE)


class Ec8Keys(SiteKeys):
    """Keys of EC8 alone."""

    type: Literal[1, 2] | None = None
    """Type of the spectrum, EC8 only; 1 when not given."""


def ec8(ag: float, ground: str = "A", type_: int = 1, vertical: bool = False) -> CodeSpectrum:
    """The spectrum of a design ground acceleration on rock (times the importance factor) [m/s2], ground A to E, type 1 or 2."""
    if vertical:
        return CodeSpectrum(VERTICAL[type_] * ag, 1.0, 3.0, VERTICAL_PERIODS)
    soil, *corners = LEVEL[type_, ground]
    return CodeSpectrum(soil * ag, 1.0, 2.5, (corners[0], corners[1], corners[2]), LONG_PERIODS[ground] if type_ == 1 else None, soil)


def _made(keys: Ec8Keys, vertical: bool, gravity: float) -> CodeSpectrum:
    assert keys.ag is not None
    return ec8(keys.ag, keys.ground, keys.type or 1, vertical)


def _facts(keys: Ec8Keys, found: CodeSpectrum) -> Iterator[Fact]:
    assert keys.ag is not None
    yield "ag", keys.ag
    yield "F0", found.plateau
    yield "S", found.soil
    yield from zip(("TB", "TC", "TD"), found.corners, strict=True)


SPECTRA = {
    "EC8": SpectrumKind(
        Ec8Keys, ("ag",), _made, ROWS, _facts, lambda keys, _: keys.ag, by_ag, ("type",), "ABCDE", vertical=True, words=ag_and_ground
    )
}
