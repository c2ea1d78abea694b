# SPDX-License-Identifier: GPL-3.0-or-later
"""Building stones by kind: what the key ``material.stones.kind`` of a scene gives.

Tensile strength and modulus of elasticity of dried specimens of building stones, least and largest value, in thousands of psi: Technical
Papers 123, 305 and 349 of the National Bureau of Standards, and its J. Res. 11 and 25, as a table of handbooks of building design has
them, "Strength characteristics of commercial building stones". A run takes the mean of a range. The table has no fracture energy: a plane
breaks at once unless the scene gives one.
"""

from __future__ import annotations

from typing import NamedTuple

from masonry_cd.foundation.quantities import pressure
from masonry_cd.mechanics.model.masonry_kinds import Range

PSI = 4.4482216152605 / 0.0254**2  # pound-force per square inch [Pa]


class StoneKind(NamedTuple):
    """A row of the table."""

    tension: Range  # [ksi]
    modulus: Range  # [ksi]

    def ranges(self) -> dict[str, Range]:
        """Least and largest value of the keys of [material.stones] that the row gives [Pa]."""
        return {"tensile_strength": self.tension.times(1e3 * PSI), "young": self.modulus.times(1e3 * PSI)}


STONES = {
    "granite": StoneKind(Range(0.6, 1.0), Range(5700, 8200)),
    "limestone": StoneKind(Range(0.28, 0.89), Range(1500, 12400)),
    "sandstone": StoneKind(Range(0.28, 0.5), Range(1900, 7700)),
    "marble": StoneKind(Range(0.15, 2.3), Range(7200, 14500)),
}
"""Kinds by name."""


def stone_in_words(kind: str, given: set[str]) -> str:
    """Return a line on the values that a run takes of a kind of stone, but for the keys that the scene gives itself."""
    taken = [
        f"{key} {pressure(values.mean)} ({pressure(values.least)} to {pressure(values.largest)} by the table)"
        for key, values in STONES[kind].ranges().items()
        if key not in given
    ]
    return f"{kind}, {', '.join(taken) or 'of which the scene gives all itself'}"
