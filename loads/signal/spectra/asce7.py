# SPDX-License-Identifier: GPL-3.0-or-later
r"""ASCE 7-16, 11.4.6 (11.4-5 to 11.4-7), and the two-period spectrum of ASCE 7-22, 11.4.5.2: the design spectrum, level.

    S_a = S_DS (0.4 + 0.6 T / T_0)      T   <= T_0 = 0.2 S_D1 / S_DS
          S_DS                          T_0 <= T <= T_S = S_D1 / S_DS
          S_D1 / T                      T_S <= T <= T_L
          S_D1 T_L / T^2                T_L <= T

That is the shape of :mod:`loads.signal.spectra.shape` with a = 0.4 S_DS, s = 1, P = 2.5 and the corners T_0, T_S and T_L. S_DS and S_D1
have the site coefficients in them. For other dampings eta is that of EN 1998-1:2004. The multi-period spectrum of ASCE 7-22 is a table.

Read in EzGM (utility.py, sae_asce7_16) and in the help of Tekla Structural Designer (ASCE 7 horizontal design spectrum), the numbers of the
equations in that of ideCAD (11.4.6); the standard itself was not read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from loads.motion import Positive
from loads.signal.spectra.kind import ORDINATE, Fact, SiteKeys, SpectrumKind, in_proportion
from loads.signal.spectra.shape import PEAK, CodeQuantity, CodeSpectrum, common_rows
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Unit

START, PLATEAU = 0.4, 2.5  # of S_DS at T = 0, and one over it
CLAUSE = "ASCE 7-16, 11.4.6"
ROWS = {
    "SDS": CodeQuantity("m/s2", CLAUSE, "plateau, site coefficient included"),
    "SD1": CodeQuantity("m/s2", CLAUSE, "ordinate at 1 s, site coefficient included"),
    "ag": CodeQuantity("m/s2", CLAUSE, "ordinate at T = 0", f"{START:g} SDS"),
    "F0": CodeQuantity("", CLAUSE, "the plateau over it"),
    "TB": CodeQuantity("s", CLAUSE, "T_0, where the plateau begins", "0.2 SD1 / SDS"),
    "TC": CodeQuantity("s", CLAUSE, "T_S, where it ends", "SD1 / SDS"),
    "TD": CodeQuantity("s", CLAUSE, "T_L, where constant displacements begin"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "ag"),
} | common_rows(CLAUSE)


class Asce7Keys(SiteKeys):
    """Keys of ASCE7 alone."""

    s_ds: Annotated[Positive, Unit("m/s2"), ORDINATE] | None = None
    """S_DS, the plateau at the site, ASCE7 only."""
    s_d1: Annotated[Positive, Unit("m/s2"), ORDINATE] | None = None
    """S_D1, the ordinate at 1 s at the site, ASCE7 only."""
    t_l: Span | None = None
    """T_L, where constant displacements begin, ASCE7 only."""


def _made(keys: Asce7Keys, vertical: bool, gravity: float) -> CodeSpectrum:
    assert keys.s_ds is not None and keys.s_d1 is not None and keys.t_l is not None
    end = keys.s_d1 / keys.s_ds
    return CodeSpectrum(START * keys.s_ds, 1.0, PLATEAU, (0.2 * end, end, keys.t_l))


def _check(keys: Asce7Keys) -> None:
    """Raise unless the plateau ends before T_L."""
    _, end, far = _made(keys, False, 1.0).corners
    if end >= far:
        raise ValueError(f"t_l: must be longer than T_S = s_d1 / s_ds, {end:.3g} s, got {far:g} s")


def _facts(keys: Asce7Keys, found: CodeSpectrum) -> Iterator[Fact]:
    assert keys.s_ds is not None and keys.s_d1 is not None
    yield "SDS", keys.s_ds
    yield "SD1", keys.s_d1
    yield "ag", found.size
    yield "F0", found.plateau
    yield from zip(("TB", "TC", "TD"), found.corners, strict=True)


SPECTRA = {
    "ASCE7": SpectrumKind(
        Asce7Keys,
        ("s_ds", "s_d1", "t_l"),
        _made,
        ROWS,
        _facts,
        lambda _, found: found.size,
        in_proportion("s_ds", "s_d1"),
        words=lambda keys: f", S_DS {keys.s_ds:g} and S_D1 {keys.s_d1:g} m/s2, T_L {keys.t_l:g} s",
        check=_check,
    )
}
