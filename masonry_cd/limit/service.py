# SPDX-License-Identifier: GPL-3.0-or-later
"""A bridge under a vehicle in service, ``[limit.service]``: when its joints have to open, and when stresses pass a share of the strength.

Two load factors at the worst place of the vehicle, as the largest that forces in equilibrium allow

- which keep within the middle third of the joints of arches, of piers and of springings: above it some joint has to open
  (:mod:`masonry_cd.analysis.limit.middle_third`), below it none need do so. Beds between rings may open, as they do in collapse;
- whose stress blocks bear no more than a share of the compressive strength.

This is a check of its own name. It is none of a guide's: what CIRIA C800 and CS 454 call the permissible limit state was not read.
Fill resists as the scene has it; where the scene leaves that open, once more as if it did not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import Domain
from masonry_cd.analysis.limit.crushing import crushable
from masonry_cd.analysis.limit.middle_third import middle_third
from masonry_cd.analysis.limit.problem import plane_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import per_cent, pressure
from masonry_cd.limit.assumed import against_fill, strength_of
from masonry_cd.limit.vehicle import anywhere, envelope, live_vehicle, somewhere

if TYPE_CHECKING:
    from masonry_cd.app.limit_structure import LimitStructure

PARTS = ("arch", "pier", "abutment", "base")  # how the groups begin whose joints are to stay closed
OPENING, STRESS = "opening", "stress"


@dataclass(frozen=True)
class ServiceRow:
    """The load factor up to which a check is met."""

    check: str  # opening or stress
    words: str
    asked: float
    factor: float | None  # None where the dead loads alone do not meet it
    position: float | None  # of the first axle at its worst [m]

    @property
    def met(self) -> bool:
        """True where the factor asked is reached."""
        return self.factor is not None and self.factor >= self.asked

    @property
    def line(self) -> str:
        """The line that is shown."""
        if self.factor is None:
            return f"{self.words}: not met, not even under the dead loads alone"
        limit = f"up to a load factor of {self.factor:.4g}" if np.isfinite(self.factor) else "under any load factor"
        there = "" if self.position is None else f" at x = {self.position:.4g} m"
        return f"{self.words}: {limit}{there}, {'met' if self.met else 'not met'}"

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        finite = self.factor if self.factor is not None and np.isfinite(self.factor) else None
        return asdict(self) | {"factor": finite, "met": self.met, "line": self.line}


@dataclass(frozen=True)
class Service:
    """The checks in service."""

    asked: float
    rows: tuple[ServiceRow, ...]

    @property
    def lines(self) -> list[str]:
        """The lines that are shown."""
        return [f"in service, a load factor of {self.asked:g} asked:", *(row.line for row in self.rows)]

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        return {"asked": self.asked, "lines": self.lines, "rows": [row.numbers() for row in self.rows]}


def refuse_service(structure: LimitStructure) -> None:
    """Refuse a check of what no vehicle loads.

    Raises:
        InputError: the scene multiplies no vehicle.
    """
    if structure.asked.service is not None and live_vehicle(structure.scene) is None:
        raise InputError("limit.service", 'checks a bridge under a vehicle: name a load of kind "vehicle" in limit.live')


def service(structure: LimitStructure, quiet: bool = True) -> Service:
    """The checks that the table ``[limit.service]`` of a structure asks for, at the worst place of its vehicle.

    Raises:
        InputError: a bridge in space, whose joints bend about two axes.
    """
    asked, number = structure.asked.service, live_vehicle(structure.scene)
    assert asked is not None and number is not None
    free = structure.of(somewhere(anywhere(structure.scene, number)))
    if plane_of(free.assembly, free.loads().at()) is None:
        raise InputError("limit.service", "checks bridges that are computed in their plane: without walls and skew")
    bare = against_fill(free)
    rows = []
    for words, built in (("", free), *(() if bare is None else ((f", {bare[0].words}", bare[1]),))):
        for check, said, checked, domain in _checks(built, asked.stress):
            found = envelope(checked, number, quiet, domain=domain)
            least = None if found is None else (float(found.factor[found.worst]), float(found.position[found.worst]))
            rows.append(ServiceRow(check, f"{said}{words}", asked.factor, *(least or (None, None))))
    return Service(asked.factor, tuple(rows))


def _checks(structure: LimitStructure, share: float | None) -> Iterator[tuple[str, str, LimitStructure, Domain]]:
    """Each check with its words, the structure whose joints it limits, and how."""
    assembly = structure.assembly
    laws, named = assembly.laws, [assembly.groups.index(name) for name in assembly.groups if name.startswith(PARTS)]
    closed = np.zeros_like(laws.crushing)
    closed[np.ix_(named, named)] = np.inf
    rings = [g for g in named if assembly.groups[g].startswith("arch")]
    for one in rings:
        closed[one, [other for other in rings if other != one]] = 0.0
    yield OPENING, "no joint need open", _bearing(structure, closed), middle_third
    if share is not None:
        strength, source = strength_of(structure)
        most = share * (laws.crushing if laws.crushing.any() else np.full_like(laws.crushing, strength))
        words = f"stresses within {per_cent(share)} of {pressure(strength)} ({source})"
        yield STRESS, words, _bearing(structure, most), crushable


def _bearing(structure: LimitStructure, crushing: np.ndarray) -> LimitStructure:
    """A structure whose joints crush at other stresses (G, G) [Pa]."""
    return replace(structure, assembly=replace(structure.assembly, laws=replace(structure.assembly.laws, crushing=crushing)))
