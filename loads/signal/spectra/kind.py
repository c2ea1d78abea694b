# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of spectrum: all that the program knows of it. A module next to this one lists its own in ``SPECTRA``, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, BeforeValidator, Field

from loads.motion import Positive, strict
from loads.signal.spectra.shape import CodeQuantity, ElasticSpectrum
from masonry_cd.foundation.extensions import Entries
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

GROUND = Usual(0.6, 10.0, "hazard maps give 0.6 to 10 m/s2 (0.06 to 1 g) where masonry is checked", ACCELERATIONS)
ORDINATE = Usual(0.05, 40.0, "plateaus of spectra are 1 to 30 m/s2 (0.1 to 3 g)", ACCELERATIONS)
Keys = TypeVar("Keys", bound=BaseModel)
Fact = tuple[str, float] | tuple[str, float, str]
"""A symbol, its value, and its formula where it is not that of the row."""


def _known(name: object) -> object:
    """The name of a kind."""
    if name not in KINDS:
        raise ValueError(f"is none of {', '.join(KINDS)}")
    return name


def _names(schema: dict[str, Any]) -> None:
    """The names of the kinds in the JSON schema."""
    schema["enum"] = [*KINDS]


SpectrumName = Annotated[str, BeforeValidator(_known), Field(json_schema_extra=_names)]


class SiteKeys(BaseModel):
    """The keys that several kinds share."""

    model_config = strict

    spectrum: SpectrumName | None = None
    """Spectrum of EN 1998-1:2004 or 1998-1-1:2024, NTC 2018, ASCE 7 or NZS 1170.5, or a table of ordinates."""
    ag: Annotated[Positive, Unit("m/s2"), GROUND] | None = None
    """Peak ground acceleration on rock, EC8 and NTC; of a table its ordinate at T = 0, where it begins above."""
    ground: Literal["A", "B", "C", "D", "E"] = "A"
    """Ground type, site category or subsoil class."""


@dataclass(frozen=True)
class SpectrumKind:
    """A kind of spectrum; its functions get a table that has its keys."""

    keys: type[SiteKeys]
    needs: tuple[str, ...]
    make: Callable[[Any, bool, float], ElasticSpectrum]  # of keys; vertical or level; gravity of the formulas [m/s2]
    rows: Mapping[str, CodeQuantity]  # of the steps of a check
    facts: Callable[[Any, Any], Iterator[Fact]]  # the first of these steps, of keys and spectrum
    size: Callable[[Any, Any], float]  # ag, of keys and spectrum [m/s2]
    grown: Callable[[Any, float, float], Any]  # the keys of another ag, of the one that they have and of that one [m/s2]
    takes: tuple[str, ...] = ()
    grounds: str = ""  # that it knows; empty: the ground does not apply
    vertical: bool = False  # it has a vertical spectrum
    words: Callable[[Any], str] = lambda _: ""  # that follow its name
    check: Callable[[Any], None] = lambda _: None  # raises a ValueError on keys which do not fit one another
    read: Callable[[Any, Path, str], Any] | None = None  # the keys with their files read, of folder and place


KINDS: Entries[SpectrumKind] = Entries("loads.signal.spectra", "SPECTRA")


def in_proportion(*names: str) -> Callable[[Any, float, float], Any]:
    """The function that makes keys grow as ag does."""

    def grown(keys: Keys, have: float, want: float) -> Keys:
        return keys.model_copy(update={name: getattr(keys, name) * want / have for name in names})

    return grown


def by_ag(keys: Keys, have: float, want: float) -> Keys:
    """The keys with another ag."""
    return keys.model_copy(update={"ag": want})


def ag_and_ground(keys: SiteKeys) -> str:
    """The words on a spectrum that has both."""
    return f", ag {keys.ag:g} m/s2, ground {keys.ground}"
