# SPDX-License-Identifier: GPL-3.0-or-later
"""An elastic response spectrum as a value: that of a code, or a table of ordinates from arrays or a file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from loads.motion import STANDARD_GRAVITY
from loads.picture import spectrum_picture
from loads.signal.code_spectrum import SiteSpectrum
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.values import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DAMPINGS = (0.02, 0.05, 0.1)  # of a picture


class Spectrum(Sealed):
    """An elastic response spectrum, ``mc.Spectrum("EC8", ag=2.0, ground="B")``; ``keys`` bring it into a scene.

    Args:
        spectrum: the name of a code, as ``limit.check.spectrum`` has it, or "table".
        vertical: the vertical spectrum, of a code that has one.
        gravity: of the formulas of a code [m/s2].
        keys: those of a scene, ``table={"path": "site.csv"}`` or ``table={"period": ..., "acceleration": ...}`` among them.

    Raises:
        InputError: a key that does not apply, or a file that is not such a table.
    """

    def __init__(self, spectrum: str, *, vertical: bool = False, gravity: float = STANDARD_GRAVITY, **keys: Any) -> None:
        site = parse_table(SiteSpectrum, {"spectrum": spectrum} | plain(keys, "spectrum"), "spectrum")
        if vertical and not site.of_kind.vertical:
            raise InputError("spectrum", f"vertical: does not apply to a spectrum of {spectrum}")
        self._site = site.read(Path(), "spectrum")
        self._found = self._site.spectrum_of_site(vertical, gravity)

    @classmethod
    def read(cls, path: str | os.PathLike[str], **keys: Any) -> Spectrum:
        """The spectrum of a CSV file, a column "period [s]" and one or several of accelerations; ``ag`` where it begins above zero."""
        return cls("table", table={"path": path}, **keys)

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of a scene that make it, for ``[limit.check]`` or a load of kind "artificial"; files are read."""
        found: dict[str, Any] = plain(self._site.model_dump(exclude_unset=True), "spectrum")
        return found

    @property
    def longest(self) -> float:
        """The period up to which it is known [s]."""
        return self._found.longest

    def at(self, period: float | Sequence[float] | np.ndarray, damping: float = 0.05) -> np.ndarray:
        """Pseudo-accelerations at periods of zero or more [s], in their shape [m/s2].

        Raises:
            InputError: a negative period, one beyond a table, or a damping of zero or less.
        """
        return self._found.at(_periods(period, damping), damping)

    def displacement(self, period: float | Sequence[float] | np.ndarray, damping: float = 0.05) -> np.ndarray:
        """Displacements of oscillators relative to the ground, at periods of zero or more [s], in their shape [m].

        Raises:
            InputError: a negative period, one beyond a table, or a damping of zero or less.
        """
        return self._found.displacement(_periods(period, damping), damping)

    def plot(self, dampings: Sequence[float] = DAMPINGS) -> Figure:
        """Its accelerations and displacements over the period, a curve for each damping."""
        return spectrum_picture(self._found, dampings, str(self))

    def __str__(self) -> str:
        """Its kind, size and ground."""
        return f"{self._site.spectrum} spectrum{self._site.of_kind.words(self._site)}"


def _periods(period: Any, damping: float) -> np.ndarray:
    """Periods as an array [s], of which a damping ratio is requested."""
    if not damping > 0.0:
        raise InputError("damping", f"must be above 0, a share of critical, got {damping:g}")
    found = np.asarray(period, dtype=float)
    if not np.all(found >= 0.0):
        raise InputError("period", "must be 0 or more, in seconds")
    return found
