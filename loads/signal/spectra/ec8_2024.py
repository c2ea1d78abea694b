# SPDX-License-Identifier: GPL-3.0-or-later
r"""EN 1998-1-1:2024, 5.2.2.2, the level spectrum; the shape is that of :mod:`loads.signal.spectra.shape`.

    a = S_alpha / F_A,   s = 1,   P = F_A = 2.5,   S_alpha = F_alpha S_alpha,RP,   S_beta = F_beta S_beta,RP,   F_T = 1
    T_A = 0.02 s,   T_B = T_C / 4, from 0.05 to 0.1 s,   T_C = T_beta S_beta / S_alpha,   T_beta = 1 s,   T_D = 1 + S_beta,RP, 2 s at least

with S_alpha,RP, the plateau, and S_beta,RP, the ordinate at 1 s, on site category A, and T_D for S_beta,RP in m/s2.

The standard itself was not read. Shape, T_D and the factors of categories A to D are those of the program PEUSP-beta (RS_EC82024.py); the
shape is that of rshalib, too (Royal Observatory of Belgium, refspec/en1998update.py, the draft of 2019). Left out are categories E and F
and the F_T of ridges, which only the draft has, and the vertical spectrum. eta is that of EN 1998-1:2004 (3.6) at all periods, that of the
draft is nearer to 1 below 0.5 s. Displacements stay S (T / 2 pi)^2 for long periods, too, where those of the draft fall.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from loads.motion import STANDARD_GRAVITY, Positive
from loads.signal.spectra.kind import ORDINATE, Fact, SiteKeys, SpectrumKind, in_proportion
from loads.signal.spectra.shape import PEAK, CodeQuantity, CodeSpectrum, common_rows
from masonry_cd.foundation.units import Unit

FLAT, PLATEAU, WIDTH, NARROWEST, WIDEST = 0.02, 2.5, 4.0, 0.05, 0.1  # T_A [s], F_A, T_C / T_B, bounds of T_B [s]
SITE = {  # F_alpha = f (1 - s S_alpha,RP / g) and F_beta in the same way: f, s of each
    "A": (1.0, 0.0, 1.0, 0.0),
    "B": (1.3, 0.1, 1.6, 0.2),
    "C": (1.6, 0.2, 2.3, 0.3),
    "D": (1.8, 0.3, 3.2, 1.0),
}
CLAUSE = "EN 1998-1-1:2024, 5.2.2.2"
ROWS = {
    "Salpha,RP": CodeQuantity("m/s2", CLAUSE, "plateau on site category A"),
    "Sbeta,RP": CodeQuantity("m/s2", CLAUSE, "ordinate at 1 s on site category A"),
    "F0": CodeQuantity("", CLAUSE, "F_A, the plateau over the peak of the ground"),
    "ag": CodeQuantity("m/s2", CLAUSE, "peak acceleration on site category A", "Salpha,RP / F0"),
    "Falpha": CodeQuantity("", CLAUSE, "site amplification of the plateau"),
    "Fbeta": CodeQuantity("", CLAUSE, "site amplification at 1 s"),
    "Salpha": CodeQuantity("m/s2", CLAUSE, "plateau", "Falpha Salpha,RP"),
    "Sbeta": CodeQuantity("m/s2", CLAUSE, "ordinate at 1 s", "Fbeta Sbeta,RP"),
    "TA": CodeQuantity("s", CLAUSE, "up to which the ordinate is the peak of the ground"),
    "TC": CodeQuantity("s", CLAUSE, "where the plateau ends", "Sbeta / Salpha"),
    "TB": CodeQuantity("s", CLAUSE, "where it begins", f"min(max(TC / {WIDTH:g}, {NARROWEST:g}), {WIDEST:g})"),
    "TD": CodeQuantity("s", CLAUSE, "where constant displacements begin", "max(2, 1 + Sbeta,RP)"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "Salpha / F0"),
} | common_rows(CLAUSE)


class Ec8Of2024Keys(SiteKeys):
    """Keys of EC8-2024 alone."""

    s_alpha: Annotated[Positive, Unit("m/s2"), ORDINATE] | None = None
    """S_alpha,RP, the plateau on site category A, EC8-2024 only."""
    s_beta: Annotated[Positive, Unit("m/s2"), ORDINATE] | None = None
    """S_beta,RP, the ordinate at 1 s on site category A, EC8-2024 only."""


def amplified(ground: str, s_alpha: float, s_beta: float, gravity: float) -> tuple[float, float]:
    """F_alpha and F_beta of a site category, for ordinates on category A and gravity [m/s2]."""
    alpha, less_alpha, beta, less_beta = SITE[ground]
    return alpha * (1.0 - less_alpha * s_alpha / gravity), beta * (1.0 - less_beta * s_beta / gravity)


def _made(keys: Ec8Of2024Keys, vertical: bool, gravity: float) -> CodeSpectrum:
    assert keys.s_alpha is not None and keys.s_beta is not None
    f_alpha, f_beta = amplified(keys.ground, keys.s_alpha, keys.s_beta, gravity)
    top = f_alpha * keys.s_alpha
    end = f_beta * keys.s_beta / top
    begin = min(max(end / WIDTH, NARROWEST), WIDEST)
    corners = (begin, end, max(2.0, 1.0 + keys.s_beta))
    return CodeSpectrum(top / PLATEAU, 1.0, PLATEAU, corners, soil=f_alpha, stretch=f_beta, flat=FLAT)


def _check(keys: Ec8Of2024Keys) -> None:
    """Raise unless the corners ascend."""
    found = _made(keys, False, STANDARD_GRAVITY)
    begin, end, far = found.corners
    if found.size <= 0.0 or not begin < end < far:
        raise ValueError(
            f"s_beta: with s_alpha and the site T_C is {end:.3g} s, which must lie between T_B and T_D, {begin:.3g} and {far:.3g} s"
        )


def _facts(keys: Ec8Of2024Keys, found: CodeSpectrum) -> Iterator[Fact]:
    assert keys.s_alpha is not None and keys.s_beta is not None
    alpha, less_alpha, beta, less_beta = SITE[keys.ground]
    begin, end, far = found.corners
    yield "Salpha,RP", keys.s_alpha
    yield "Sbeta,RP", keys.s_beta
    yield "F0", found.plateau
    yield "ag", keys.s_alpha / found.plateau
    yield "Falpha", found.soil, f"{alpha:g} (1 - {less_alpha:g} Salpha,RP / g)" if less_alpha else ""
    yield "Fbeta", found.stretch, f"{beta:g} (1 - {less_beta:g} Sbeta,RP / g)" if less_beta else ""
    yield "Salpha", found.soil * keys.s_alpha
    yield "Sbeta", found.stretch * keys.s_beta
    yield "TA", found.flat
    yield "TC", end
    yield "TB", begin
    yield "TD", far


SPECTRA = {
    "EC8-2024": SpectrumKind(
        Ec8Of2024Keys,
        ("s_alpha", "s_beta"),
        _made,
        ROWS,
        _facts,
        lambda keys, _: keys.s_alpha / PLATEAU,
        in_proportion("s_alpha", "s_beta"),
        grounds="ABCD",
        words=lambda keys: f", S_alpha,RP {keys.s_alpha:g} and S_beta,RP {keys.s_beta:g} m/s2, site category {keys.ground}",
        check=_check,
    )
}
