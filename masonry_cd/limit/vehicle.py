# SPDX-License-Identifier: GPL-3.0-or-later
r"""The worst place of a vehicle on a bridge: the least factor of its axles over its position.

At each of some places of the first axle, from where it comes onto the bridge to where the last one leaves it, the largest factor that
equilibrium and friction allow is found, with dead loads, fill and all other loads as they are. Around the least of these, places are
halved until they are CLOSE. The analysis of the scene is then made at that place. The factors of the envelope are associated: where joints
slide at collapse the least factor, searched for at that place alone, lies below.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import STANDS, Domain, NoFiniteFactor, at_rest, largest_factor
from masonry_cd.analysis.limit.crushing import crushable, solved_finely
from masonry_cd.analysis.limit.interfaces import interfaces
from masonry_cd.analysis.limit.problem import plane_of, problem_at
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from loads.motion import Places
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.mechanics.model.fill import Fill

CROSSING_OUTPUTS = ("crossing.csv", "crossing.png")
IN_PLANE, IN_SPACE = 60, 16  # places looked at first; in space each takes cone programmes
CLOSE = 1.0 / 400.0  # of the length of the bridge: how finely the worst place is found
PATTERNS = ("push", "tilt", "live")  # keys of [limit] that multiply something


@dataclass(frozen=True, eq=False)
class Crossing:
    """The load factors of a vehicle that crosses a bridge."""

    load: int  # its place in [[loads]]
    vehicle: str  # its name, or how many axles it has
    position: np.ndarray  # (M,) of the first axle along the road [m], growing
    factor: np.ndarray  # (M,) associated; inf where any multiple is borne
    spans: tuple[tuple[float, float], ...]  # from springing to springing of the spans [m]

    @property
    def worst(self) -> int:
        """The place of the least factor."""
        return int(np.argmin(self.factor))

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        finite = [float(f) if math.isfinite(f) else None for f in self.factor]
        return {
            "load": self.load, "vehicle": self.vehicle, "position": self.position.tolist(), "factor": finite,
            "critical_position": float(self.position[self.worst]), "least": finite[self.worst],
        }  # fmt: skip

    def line(self) -> str:
        """The line that is shown."""
        least, place = float(self.factor[self.worst]), float(self.position[self.worst])
        first, last = float(self.position[0]), float(self.position[-1])
        return (
            f"loads[{self.load}] {self.vehicle}: of {len(self.position)} places of its first axle, from x = {first:.4g} to {last:.4g} m, "
            f"the worst is x = {place:.4g} m, factor {least:.5g} (associated)"
        )


def at_worst(structure: LimitStructure, quiet: bool = True, first: float | None = None) -> tuple[LimitStructure, Crossing | None]:
    """A structure with the vehicle that its limit analysis multiplies at its worst place; unchanged where no place is sought.

    It says how long the places still take, unless it is ``quiet``. With a place to look at ``first``, likely the worst one, factors of
    others are found only as far as they may be less, and are lower bounds.

    Raises:
        InputError: anything wrong with the scene.
    """
    scene = structure.scene
    number, middle = live_vehicle(scene), structure.of(somewhere(scene))
    if number is None or "position" in scene.loads[number]:
        return middle, None
    with scene.locating():
        found = envelope(middle, number, quiet, first)
        place = _places(middle, number).low if found is None else float(found.position[found.worst])
    return structure.of(_placed(middle.scene, number, place)), found


def somewhere(scene: Scene) -> Scene:
    """A scene whose limit analysis multiplies the vehicle that it has no place for, at some place; the scene itself where there is none."""
    number = live_vehicle(scene)
    if number is None:
        return scene
    asked = replace(scene, limit={**scene.limit, "live": scene.limit.get("live", [number])})
    return asked if "position" in scene.loads[number] else _placed(asked, number, 0.0)


def live_vehicle(scene: Scene) -> int | None:
    """The one vehicle that is multiplied: named in limit.live, or the only load that could be."""
    from loads import kind_of
    from loads.static import patterns

    with scene.locating():
        every = patterns(scene.loads, scene.folder)
    vehicles = [i for i, load in enumerate(scene.loads) if (kind := kind_of(load)) is not None and kind.places is not None]
    live = scene.limit.get("live")
    if live is not None:
        some = [i for i in vehicles if i in live]
        free = [i for i in some if "position" not in scene.loads[i]]
        if len(free) > 1:
            raise InputError("limit.live", f"the worst place of one vehicle is looked for; give loads{free[1:]} a position")
        return free[0] if free else (some[0] if some else None)
    alone = len(vehicles) == 1 and not any(pattern not in ("", "live") for pattern in every)
    return vehicles[0] if alone and not any(scene.limit.get(name) for name in PATTERNS) else None


def _placed(scene: Scene, number: int, position: float) -> Scene:
    """A scene whose vehicle stands at a place."""
    tables = [dict(load) for load in scene.loads]
    tables[number] = {**tables[number], "position": position}
    return replace(scene, loads=tuple(tables))


def anywhere(scene: Scene, number: int) -> Scene:
    """A scene whose vehicle has no place."""
    tables = [dict(load) for load in scene.loads]
    tables[number].pop("position", None)
    return replace(scene, loads=tuple(tables))


def _places(structure: LimitStructure, number: int) -> Places:
    """The first and last place of the first axle at which any axle stands on the bridge, and the vehicle."""
    from loads import kind_of, parse_load

    given, where = structure.scene.loads[number], f"loads[{number}]"
    kind = kind_of(given)
    assert kind is not None and kind.places is not None
    return kind.places(parse_load(given, where, structure.scene.folder), structure.made.fills, where)


def envelope(
    structure: LimitStructure, number: int, quiet: bool = True, first: float | None = None, domain: Domain = crushable
) -> Crossing | None:
    """The factors of a vehicle, by its number, over its places; None of a structure that does not stand.

    Args:
        structure: with the vehicle at some place.
        number: of the vehicle in ``[[loads]]``.
        quiet: do not say how long it still takes.
        first: see :func:`at_worst`.
        domain: puts into a problem what its joints bear.
    """
    from masonry_cd.app.progress import Progress

    low, high, words = _places(structure, number)
    problem, alone = at_rest(structure.assembly, structure.joints, structure.loads().at(), domain)
    if alone.factor < 1.0 - STANDS:
        return None
    known, factor_at = dict[float, float](), factors(structure, number, domain)

    def at(place: float) -> float:
        if place not in known:
            known[place] = factor_at(place, math.inf if first is None else min(known.values(), default=math.inf))
            progress(min(len(known), count))  # those around the least come last, and are few
        return known[place]

    count = structure.asked.positions or (IN_PLANE if problem.axis is not None else IN_SPACE)
    with Progress(count, quiet, what="place of the vehicle") as progress:
        even = np.linspace(low, high, count + 2)[1:-1].tolist()
        _look(at, even if first is None else [first, *even], CLOSE * (high - low))
    places = np.array(sorted(known))
    found = np.array([known[place] for place in places.tolist()])
    return Crossing(number, words, places, found, _spans(structure.made.fills[0]))


def _look(at: Callable[[float], float], places: Sequence[float], close: float) -> None:
    """Ask for a value at places, and halve those next to the least of them until they are close."""
    values = {place: at(place) for place in places}
    while True:
        ordered = sorted(values)
        k = ordered.index(min(ordered, key=lambda place: values[place]))
        near = [ordered[j] for j in (k - 1, k + 1) if 0 <= j < len(ordered) and abs(ordered[j] - ordered[k]) > close]
        if not near or not math.isfinite(values[ordered[k]]):
            return
        for place in near:
            values[0.5 * (place + ordered[k])] = at(0.5 * (place + ordered[k]))


def factors(structure: LimitStructure, number: int, domain: Domain = crushable) -> Callable[[float, float], float]:
    """The largest factor of the vehicle by the place of its first axle, above ``enough`` a lower bound of it; all other loads are those
    that the structure has. ``domain`` puts into a problem what its joints bear."""
    from masonry_cd.app.static_loads import live_alone

    scene, assembly, joints = structure.scene, structure.assembly, structure.joints
    loads, points = structure.loads().at(), cache(partial(interfaces, assembly, joints))

    def live(table: Mapping[str, Any]) -> np.ndarray:
        with scene.locating():
            return live_alone(table, scene.run.gravity, scene.folder, assembly, structure.made.fills)

    others = loads.live - live(scene.loads[number])

    def factor(place: float, enough: float) -> float:
        there = replace(loads, live=others + live(scene.loads[number] | {"position": place}))
        axis = plane_of(assembly, there)
        problem = domain(problem_at(assembly, points(axis), there, axis), assembly, joints)
        try:
            return solved_finely(problem, lambda finer: largest_factor(finer)[0], enough)[1].factor
        except NoFiniteFactor:
            return math.inf
        except Unbounded as failure:
            raise InputError("limit", f"no answer: {failure}") from None

    return factor


def _spans(fill: Fill) -> tuple[tuple[float, float], ...]:
    """The beginning and end of each arch of a bridge along the road [m]."""
    reach: dict[str, list[float]] = {}
    for face in fill.faces:
        if face.kind == "extrados":
            reach.setdefault(face.block.split(".v")[0].split("_")[0], []).extend((fill.along(face.corners)[:, 0]).tolist())
    return tuple((min(x), max(x)) for x in reach.values())


def write_crossing(found: Crossing, folder: Path, title: str, pictures: bool) -> list[Path]:
    """Write crossing.csv and crossing.png."""
    table, picture = (folder / name for name in CROSSING_OUTPUTS)
    rows = [[f"{x:.6g}", f"{factor:.8g}"] for x, factor in zip(found.position, found.factor, strict=True)]
    write_csv(table, ("position_m", "factor"), rows)
    if not pictures:
        return [table]
    from reports.limit.curve_picture import draw_crossing

    draw_crossing(found.position, found.factor, found.spans, picture, f"{title}: {found.vehicle}")
    return [table, picture]
