# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of an elastic response spectrum at a site: those of all kinds in :mod:`loads.signal.spectra`, of which those of one apply."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import create_model, model_validator

from loads.motion import STANDARD_GRAVITY
from loads.signal.spectra.kind import KINDS, SiteKeys, SpectrumKind
from loads.signal.spectra.shape import ElasticSpectrum

if TYPE_CHECKING:
    _AllKeys = SiteKeys
else:  # the first kind by name comes first in the list of keys, which is read from the last base on
    _AllKeys = create_model("_AllKeys", __base__=tuple(kind.keys for kind in reversed(list(KINDS.values()))))


class SiteSpectrum(_AllKeys):
    """The elastic response spectrum at a site."""

    @model_validator(mode="after")
    def _keys_of_one_kind(self) -> Self:
        if self.spectrum is None:
            return self
        kind, name = self.of_kind, self.spectrum
        missing = next((key for key in kind.needs if getattr(self, key) is None), None)
        if missing is not None:
            raise ValueError(f"{missing}: missing, a spectrum of {name} needs it")
        known = {"spectrum", *kind.needs, *kind.takes, *(["ground"] if kind.grounds else [])}
        stray = next((key for key in type(self).keys_of_kinds() if key in self.model_fields_set - known), None)
        if stray is not None and getattr(self, stray) is not None:
            raise ValueError(f"{stray}: does not apply to a spectrum of {name}")
        if kind.grounds and self.ground not in kind.grounds:
            raise ValueError(f"ground: a spectrum of {name} knows {', '.join(kind.grounds)}, got {self.ground}")
        kind.check(self)
        return self

    @classmethod
    def keys_of_kinds(cls) -> tuple[str, ...]:
        """The keys of all kinds."""
        return tuple(SiteSpectrum.model_fields)

    @property
    def of_kind(self) -> SpectrumKind:
        """All that the program knows of the spectrum; of keys that name one."""
        assert self.spectrum is not None
        return KINDS[self.spectrum]

    def read(self, folder: Path, where: str) -> Self:
        """The keys with the files read that they name, relative to a folder; ``where`` is their place.

        Raises:
            InputError: a file that is not such a table.
        """
        if self.spectrum is None or self.of_kind.read is None:
            return self
        found: Self = self.of_kind.read(self, folder, where)
        return found

    def spectrum_of_site(self, vertical: bool = False, gravity: float = STANDARD_GRAVITY) -> ElasticSpectrum:
        """The spectrum; of keys that name one and are read. Gravity [m/s2] is that of the formulas of a code."""
        return self.of_kind.make(self, vertical, gravity)
