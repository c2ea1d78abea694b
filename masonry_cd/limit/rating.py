# SPDX-License-Identifier: GPL-3.0-or-later
"""The load rating of a bridge: the permitted weight of each vehicle at the load factor that ``[limit.rating]`` requires.

Each vehicle stands in place of the scene's own, along the same line, at the place that is its worst. Its load factor is the least found,
with all that the scene leaves open of fill and strength assumed against the bridge (:mod:`masonry_cd.limit.assumed`), and its axles may
weigh that factor over the one asked times what they do. Of the levels of CS 454, table 7.3.1a, the heaviest is named of which every axle
is borne so.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from loads.kinds.vehicle import TONNE, VEHICLES, VehicleName, VehicleTable
from masonry_cd.app.progress import Progress
from masonry_cd.foundation import system
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.workers import workers
from masonry_cd.limit.assumed import ENDLESS, against
from masonry_cd.limit.search import ways
from masonry_cd.limit.vehicle import at_worst, factors, live_vehicle
from masonry_cd.limit.whole import WholeAnalysis, analyse_whole

if TYPE_CHECKING:
    from collections.abc import Mapping

    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.scene import Scene

KEPT = ("offset", "across")  # keys of the scene's vehicle that hold for each that is rated
BY_ITSELF = "as the scene states it"
RESTRICTIONS: dict[str, dict[VehicleName, float]] = {
    "normal traffic": {"single": 11.5, "double": 10.0, "double 1.3": 9.5, "double 1.0": 8.0, "triple": 8.0, "triple 2.0": 7.0},
    "33 t": {"single": 11.5, "double 1.3": 9.5},
    "26 t": {"single": 11.5, "double 1.3": 9.5},
    "18 t": {"single": 11.5},
    "13 t": {"single": 9.0},
    "10 t": {"single": 7.0},
    "7.5 t": {"single": 5.5},
    "3 t": {"single": 2.0},
}
"""Assessment live loading levels of CS 454 revision 0, table 7.3.1a, the heaviest first, by the loads of their axles [t]."""


@dataclass(frozen=True)
class Rated:
    """A vehicle and what the bridge bears of it."""

    vehicle: str
    axles: tuple[float, ...]  # [N]
    asked: float  # the load factor
    computed: float | None = None  # the load factor as the scene states it, or has it by default
    factor: float | None = None  # the one that counts, 0 where the bridge does not stand; None where there is no finite one
    why: str = ""  # there is none
    decides: str = BY_ITSELF  # what is assumed
    key: str = ""  # of the scene that assumes it
    position: float | None = None  # of the first axle at its worst [m]
    gives_way: tuple[str, ...] = ()  # arches, piers and abutments that move at collapse

    @property
    def ratio(self) -> float | None:
        """The load factor over that asked."""
        return None if self.factor is None else self.factor / self.asked

    @property
    def axle_load(self) -> float | None:
        """The load of the heaviest axle with the factor asked [N]."""
        return None if self.ratio is None else self.ratio * max(self.axles)

    @property
    def line(self) -> str:
        """The line that is shown."""
        if self.factor is None or self.axle_load is None or self.ratio is None:
            return f"{self.vehicle}: {self.why}"
        borne = f"axles of {1e-3 * self.axle_load:.4g} kN ({self.axle_load / TONNE:.3g} t) with the factor asked"
        there = "" if self.position is None else f" at x = {self.position:.4g} m"
        moves = f"; {', '.join(self.gives_way)} give{'s' if len(self.gives_way) == 1 else ''} way" if self.gives_way else ""
        return f"{self.vehicle}: load factor {self.factor:.4g}{there}, {self.ratio:.3g} of that asked: {borne}{moves}; {self.decides}"

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        borne = self.axle_load
        tonnes = None if borne is None else borne / TONNE
        return asdict(self) | {"ratio": self.ratio, "axle_load_n": borne, "axle_load_t": tonnes, "line": self.line}


@dataclass(frozen=True)
class Rating:
    """The vehicles, and the heaviest level of CS 454 that is borne."""

    asked: float
    rows: tuple[Rated, ...]

    @property
    def level(self) -> str | None:
        """The heaviest level of which each axle is borne with the factor asked; None where none is, or its vehicles were not looked at."""
        borne = {row.vehicle: row.axle_load / TONNE for row in self.rows if row.axle_load is not None}
        for level, axles in RESTRICTIONS.items():
            if all(borne.get(name, 0.0) >= tonnes for name, tonnes in axles.items()):
                return level
        return None

    @property
    def lines(self) -> list[str]:
        """The lines that are shown."""
        level = "none" if self.level is None else self.level
        return [
            f"rating with a load factor of {self.asked:g}: heaviest level of CS 454 that is borne: {level}",
            *(r.line for r in self.rows),
        ]

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        return {"asked": self.asked, "level": self.level, "lines": self.lines, "rows": [row.numbers() for row in self.rows]}


def refuse_rating(structure: LimitStructure) -> None:
    """Refuse to rate what no vehicle loads.

    Raises:
        InputError: the scene multiplies no vehicle.
    """
    if structure.asked.rating is not None and live_vehicle(structure.scene) is None:
        raise InputError("limit.rating", 'rates vehicles on a bridge: name a load of kind "vehicle" in limit.live')


def rating(structure: LimitStructure, jobs: int, quiet: bool = True) -> Rating:
    """Rate the vehicles that the table ``[limit.rating]`` of a structure names, in processes that share it."""
    table, number = structure.asked.rating, live_vehicle(structure.scene)
    assert table is not None and number is not None
    asked, scene = table.factor, structure.scene
    own = [] if "name" in scene.loads[number] else [f"loads[{number}]"]
    names = [*own, *(table.vehicles or VEHICLES)]
    known = own_axles(scene.loads[number]) if own else ()
    blank = [Rated(name, known if name in own else VEHICLES[name].loads, asked) for name in names]
    with workers(jobs, system.INHERITS, _set_shared, structure, number) if jobs > 1 and len(blank) > 1 else nullcontext() as pool:
        _set_shared(structure, number)
        runs = [pool.submit(_one, row) for row in blank] if pool else []
        rows = []
        with Progress(len(blank), quiet, what="vehicle rated") as progress:
            for k, row in enumerate(blank):
                rows.append(runs[k].result() if pool else _one(row))
                progress(k + 1)
    return Rating(asked, tuple(rows))


def own_axles(load: Mapping[str, Any]) -> tuple[float, ...]:
    """The axles that a load has of its own [N]."""
    return VehicleTable.model_validate(dict(load)).known.loads


_SHARED: list[Any] = []  # structure and the number of its vehicle, in each process of a pool


def _set_shared(structure: LimitStructure, number: int) -> None:
    _SHARED[:] = [structure, number]


def _one(row: Rated) -> Rated:
    """A vehicle with its rating, or why there is none."""
    structure, number = _SHARED
    try:
        return _rated(structure.of(_with(structure.scene, number, row)), number, row)
    except InputError as failure:
        return replace(row, why=f"no answer, {failure}")


def _with(scene: Scene, number: int, row: Rated) -> Scene:
    """A scene with a vehicle in place of its own, without a place."""
    tables = [dict(load) for load in scene.loads]
    own = tables[number]
    kept = {key: own[key] for key in KEPT if key in own} | {"kind": "vehicle", "name": row.vehicle}
    tables[number] = kept if row.vehicle in VEHICLES else {key: value for key, value in own.items() if key != "position"}
    return replace(scene, loads=tuple(tables), limit={**scene.limit, "live": scene.limit.get("live", [number])})


def _rated(structure: LimitStructure, number: int, row: Rated) -> Rated:
    """The vehicle at its worst place, as the scene states it, and with unstated values assumed unfavourably."""
    placed, crossing = at_worst(structure)
    found = _analysed(placed)
    if not found.analysis.stands or found.analysis.is_endless or crossing is None:
        return replace(row, why="" if found.analysis.stands else "the bridge does not stand", factor=None if found.analysis.stands else 0.0)
    place = float(crossing.position[crossing.worst])
    row = _with_outcome(row, found, place)
    row = replace(row, computed=row.factor)
    least = float(crossing.factor[crossing.worst])
    other = against(structure, lambda changed: factors(changed.of(placed.scene), number)(place, least) < least)
    if other is None:
        return row
    assumed, changed = other
    if found.analysis.problem.axis is None:  # in space the places take too long once more
        changed = changed.of(placed.scene)
    else:
        changed, crossing = at_worst(changed.of(structure.scene), first=place)
        place = place if crossing is None else float(crossing.position[crossing.worst])
    again = _with_outcome(row, _analysed(changed), place)
    if again.factor is None or (row.factor is not None and again.factor >= row.factor):
        return row
    return replace(again, decides=assumed.words, key=assumed.key)


def _analysed(structure: LimitStructure) -> WholeAnalysis:
    plain = replace(structure, asked=structure.asked.model_copy(update={"check": None, "curve": None}))
    loads = plain.loads()
    return analyse_whole(plain, loads, ways(plain, loads), ())


def _with_outcome(row: Rated, found: WholeAnalysis, place: float) -> Rated:
    """A row with the outcome of an analysis."""
    analysis = found.analysis
    if not analysis.stands:
        return replace(row, factor=0.0, position=None, gives_way=_moving(found))
    if analysis.is_endless:
        return replace(row, why=ENDLESS)
    return replace(row, factor=analysis.governing.factor, position=place, gives_way=_moving(found))


def _moving(found: WholeAnalysis) -> tuple[str, ...]:
    """The groups of the blocks that move, the rings of an arch as one."""
    assembly, moving = found.assembly, np.flatnonzero(found.collapse.mechanism.moving)
    return tuple(sorted({assembly.groups[g].split("_ring")[0] for g in assembly.group_of[moving]}))
