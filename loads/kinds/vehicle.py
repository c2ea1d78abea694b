# SPDX-License-Identifier: GPL-3.0-or-later
r"""Vehicles on a bridge: axles that stand on the road or cross it slowly, spread by the fill onto the arches and supports below.

    [[loads]]
    kind = "vehicle"
    name = "double"                    # or axles = [115e3, 95e3, 95e3] and spacing = [5.0, 1.3]
    position = 3.2                     # of the first axle along the road [m]; or
    speed = 0.5                        # towards greater x [m/s]: a crossing

How the fill spreads its wheels: :mod:`loads.wheels`. An axle that is not on the bridge loads nothing.

Named vehicles: LM1, the tandem system of lane 1 of load model 1, and LM2, the single axle of load model 2, both of EN 1991-2:2003, 4.3;
"single", "double", "triple" (also "double 1.3", "double 1.0" and "triple 2.0"): the authorised axles of normal traffic of CS 454
revision 0, table 7.3.1a, for masonry arches, without lift-off and without partial factors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from loads.acted import Acted, over_time
from loads.bars import PointLoad
from loads.motion import LoadAction, LoadKind, LoadTable, Places, RunGrid, Static
from loads.wheels import ON, Known, Strips, places_on, stress_under, strips_of
from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.foundation.fields import Instant, is_number
from masonry_cd.foundation.quantities import force
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.usual import FORCES

TONNE = 9.81e3  # weight of one, as CS 454 takes it [N]
MOST_AXLES = 40
AXLE = Usual(500.0, 1e6, "axles weigh 0.5 kN (a cart) to 1 MN (heavy transport)", FORCES)
CROSSING = Usual(0.0, 45.0, "vehicles cross bridges of masonry at up to 45 m/s, 160 km/h", ("km/h",))


def _assessed(tonnes: float, axles: int, spacing: float) -> Known:
    """Axles of CS 454: wheels 1.8 m apart, on 0.3 m by 0.3 m."""
    return Known((tonnes * TONNE,) * axles, (spacing,) * (axles - 1), 1.8, (0.3, 0.3))


VehicleName = Literal["LM1", "LM2", "single", "double", "double 1.3", "double 1.0", "triple", "triple 2.0"]
VEHICLES: dict[VehicleName, Known] = {
    "LM1": Known((300e3, 300e3), (1.2,), 2.0, (0.4, 0.4)),
    "LM2": Known((400e3,), (), 2.0, (0.35, 0.6)),
    "single": _assessed(11.5, 1, 0.0),
    "double": _assessed(10.0, 2, 1.8),
    "double 1.3": _assessed(9.5, 2, 1.3),
    "double 1.0": _assessed(8.0, 2, 1.0),
    "triple": _assessed(8.0, 3, 1.3),
    "triple 2.0": _assessed(7.0, 3, 1.0),
}


def _numbers(value: object) -> tuple[float, ...] | None:
    if value is None:
        return None
    numbers = list(value) if isinstance(value, (list, tuple)) else [value]
    if len(numbers) > MOST_AXLES or not all(is_number(n) and n > 0 for n in numbers):  # type: ignore[operator]
        raise ValueError(f"must be numbers above 0, at most {MOST_AXLES}, e.g. [100e3, 100e3]")
    return tuple(float(n) for n in numbers)  # type: ignore[arg-type]


Numbers = Annotated[
    tuple[float, ...] | None,
    BeforeValidator(_numbers),
    WithJsonSchema({"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}}),
]
Measure = Annotated[float, Unit("m"), Field(gt=0.0)]


class VehicleTable(LoadTable):
    """Keys of ``kind = "vehicle"``."""

    kind: Literal["vehicle"] = "vehicle"
    name: VehicleName | None = None
    """Name of EN 1991-2, load models 1 and 2, or of CS 454: axles of normal traffic; or give axles."""
    axles: Annotated[Numbers, Unit("N"), AXLE] = None
    """Loads of its axles, the first one leading."""
    spacing: Annotated[Numbers, Unit("m")] = None
    """Distances between them."""
    across: Literal["wheels", "line", "strip"] = "wheels"
    """Two wheels to an axle; a line over the whole width between the walls, as in load tests; or wheels on the strip of a bridge in its
    plane over which they spread 2:1, up to the edges."""
    track: Measure | None = None
    """Between the middles of the two wheels of an axle; 1.8 m when neither it nor a name is given."""
    contact: Annotated[tuple[float, float] | None, Unit("m"), BeforeValidator(_numbers)] = None
    """Contact area of a wheel, along and across the road; 0.3 m by 0.3 m when neither it nor a name is given."""
    offset: Annotated[float, Unit("m")] = 0.0
    """Offset of its middle from that of the bridge, along y."""
    position: Annotated[float, Unit("m")] | None = None
    """Position of the first axle along the road at the start; of a crossing before the bridge when not given."""
    speed: Annotated[float, Unit("m/s"), CROSSING, Field(ge=0.0)] = 0.0
    """Speed towards greater x; 0: it stands."""
    start: Instant = 0.0
    """Time at which it is in place, or sets off."""
    ramp: Instant = 0.0
    """Time over which a standing vehicle is applied."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if (self.name is None) == (self.axles is None):
            raise ValueError("give exactly one of name and axles")
        if self.axles is not None and len(self.spacing or ()) != len(self.axles) - 1:
            raise ValueError(f"spacing: {len(self.axles)} axles have {len(self.axles) - 1} distances, got {len(self.spacing or ())}")
        if self.name is not None and self.spacing is not None:
            raise ValueError("spacing: a vehicle by name has its own")
        if self.contact is not None and len(self.contact) != 2:
            raise ValueError("contact: must be two lengths, along and across")
        if self.speed > 0.0 and self.ramp > 0.0:
            raise ValueError("ramp: belongs to a vehicle that stands")
        return self

    @property
    def known(self) -> Known:
        """Its axles and wheels."""
        of_name = VEHICLES[self.name] if self.name else Known(self.axles or (), self.spacing or (), 1.8, (0.3, 0.3))
        contact = of_name.contact if self.contact is None else self.contact
        return of_name._replace(track=self.track or of_name.track, contact=(contact[0], contact[1]))


def on_bridge(table: VehicleTable, fills: Sequence[Fill], where: str) -> Fill:
    """The bridge on which a vehicle is.

    Raises:
        InputError: there is none, several, or it stands next to the road.
    """
    fill = _bridge(fills, where)
    _check_road(table, fill, where)
    return fill


def _bridge(fills: Sequence[Fill], where: str) -> Fill:
    """The only one that there is."""
    if len(fills) != 1:
        raise InputError(where, f'a vehicle needs one structure of kind "bridge", whose fill spreads its wheels; there are {len(fills)}')
    return fills[0]


def _check_road(table: VehicleTable, fill: Fill, where: str) -> None:
    """Refuse wheels that stand off the road."""
    if table.across == "strip" and strips_of(fill, table.known, "line", 0.0).share.min() < 1.0 - 1e-9:
        raise InputError(f"{where}.across", "a strip carries wheels where voussoirs are as wide as the road, without skew; take wheels")
    reach = 0.5 * (table.known.track + table.known.contact[1])
    low, high = table.offset - reach, table.offset + reach
    if table.across != "line" and (low < fill.clear[0] - 1e-9 or high > fill.clear[1] + 1e-9):
        raise InputError(
            f"{where}.offset",
            f"the vehicle stands next to the road: its wheels from y = {low:.4g} to {high:.4g} m, the road from "
            f"{fill.clear[0]:.4g} to {fill.clear[1]:.4g} m",
        )


def axles_at(table: VehicleTable, first: np.ndarray) -> np.ndarray:
    """Places (M, axles) of all axles along the road, of M places of the first [m]."""
    behind = np.concatenate([[0.0], np.cumsum(table.known.spacing)])
    return np.asarray(first[:, None] - behind)


def strip_loads(table: VehicleTable, fill: Fill, first: np.ndarray) -> tuple[Strips, np.ndarray]:
    """The strips, and the load (M, S) [N] on each with the first axle at M places."""
    strips, vehicle = strips_of(fill, table.known, table.across, table.offset), table.known
    axles = axles_at(table, first)
    total = np.zeros((len(first), len(strips.face)))
    for k, load in enumerate(vehicle.loads):
        total += load * strips.weights(axles[:, k], fill, vehicle.contact[0])
    return strips, total * strips.heavier


def vehicle(table: VehicleTable, grid: RunGrid, where: str) -> LoadAction:
    """A vehicle that stands or crosses.

    Raises:
        InputError: no bridge, no place, or one that is next to the road or never on it.
    """
    fill, loads = _loads(table, grid, where)
    of_axles = {"axles": list(table.known.loads), "spacing": list(table.known.spacing)}
    summary = table.facts("name", "offset", "position", "speed", "start") | of_axles
    return LoadAction(forces=tuple(loads), lines=(_line(table, fill, where),), summary=summary, acted=_acted(table, fill, where))


def _loads(table: VehicleTable, grid: RunGrid, where: str) -> tuple[Fill, list[PointLoad]]:
    """The bridge, and the loads on its blocks."""
    fill, faults = _bridge(grid.fills, where), Faults()
    first = _begin(table, fill) + table.speed * np.maximum(grid.times - table.start, 0.0)
    with faults.of():
        _check_road(table, fill, where)
    with faults.of():
        _check_on_deck(table, fill, grid, where, first)
    faults.refuse()
    return fill, point_loads(table, fill, grid, first)


def _acted(table: VehicleTable, fill: Fill, where: str) -> Acted:
    """Return the effect by the way over the deck, from where the first axle reaches it, or begins on it, to where the last one leaves; one
    that stands by its load."""
    if table.speed == 0.0:
        return over_time(where, "load", table.start, table.ramp)
    begin, leaves = _begin(table, fill), fill.deck[1] + sum(table.known.spacing)
    before = max(fill.deck[0] - begin, 0.0) / table.speed
    return over_time(where, "way over the deck", table.start + before, (leaves - max(begin, fill.deck[0])) / table.speed)


def _check_on_deck(table: VehicleTable, fill: Fill, grid: RunGrid, where: str, first: np.ndarray) -> None:
    """Refuse a vehicle that has no place, or none on the deck while the run lasts, with its first axle at places (N + 1,) [m]."""
    if table.position is None and table.speed == 0.0:
        asked = "missing; give the place of the first axle along the road, or a speed (masonry-cd limit looks for it)"
        raise InputError(f"{where}.position", asked)
    axles = axles_at(table, first)
    if not ((axles >= fill.deck[0]) & (axles <= fill.deck[1])).any():
        key, reached = "position", f"x = {first[0]:.4g} m"
        if table.speed > 0.0:
            key, reached = "speed", f"its first axle goes from x = {first[0]:.4g} to {first[-1]:.4g} m"
        deck = f"which is from x = {fill.deck[0]:.4g} to {fill.deck[1]:.4g} m"
        raise InputError(f"{where}.{key}", f"the vehicle never stands on the deck, {deck}: {reached}")
    if table.start > grid.end:
        late = f"it is there from {table.start:g} s on, the run ends at {grid.end:g} s"
        raise InputError(f"{where}.start", f"the vehicle never stands on the deck: {late}")


def _begin(table: VehicleTable, fill: Fill) -> float:
    """The first place of the first axle [m]."""
    return fill.deck[0] if table.position is None else table.position


def point_loads(table: VehicleTable, fill: Fill, grid: RunGrid, first: np.ndarray) -> list[PointLoad]:
    """The loads of all strips on free blocks, over the times of a run; of blocks that are fixed the ground bears them."""
    assembly = grid.blocks("loads")
    strips, load = strip_loads(table, fill, first)
    since = grid.times - table.start
    load = load * (np.clip(since / table.ramp, 0.0, 1.0) if table.ramp > 0.0 else (since >= 0.0).astype(float))[:, None]
    number, down, found = {name: b for b, name in enumerate(assembly.names)}, grid.gravity, list[PointLoad]()
    way = down / math.hypot(*down) if down.any() else np.array([0.0, 0.0, -1.0])
    for s in np.flatnonzero(load.max(axis=0) > 0.0):
        block = number[fill.faces[strips.face[s]].block]
        if not assembly.fixed[block]:
            most = float(load[:, s].max())
            found.append(PointLoad(block, strips.place[s] - assembly.centre[block], most * way, load[:, s] / most))
    return found


def _line(table: VehicleTable, fill: Fill, where: str) -> str:
    vehicle = table.known
    spread = "2:1" if fill.spread == "2:1" else "by Boussinesq within 30 degrees"
    moves = f"from x = {_begin(table, fill):.4g} m on at {table.speed:g} m/s" if table.speed > 0.0 else f"at x = {table.position:g} m"
    named = f" {table.name}" if table.name else ""
    total = sum(vehicle.loads)
    return f"{where} vehicle{named} of {len(vehicle.loads)} axles, {force(total)}, its first axle {moves}; spread {spread}"


def _end(table: VehicleTable, grid: RunGrid, where: str) -> float:
    """When its last axle has left the bridge, or when it stands; the run that is not long enough yet need not have it on the deck."""
    return _acted(table, on_bridge(table, grid.fills, where), where).end


def _static(table: VehicleTable, grid: RunGrid, where: str) -> Static:
    """All axles, standing where the first is at the position, and their pressure on walls and backs of abutments."""
    standing = table.model_copy(update={"speed": 0.0, "start": 0.0, "ramp": 0.0})
    fill, loads = _loads(standing, grid, where)
    return Static(f"{where} (vehicle)", (*loads, *_pressing(standing, fill, grid)))


def _pressing(table: VehicleTable, fill: Fill, grid: RunGrid) -> list[PointLoad]:
    """K_a times the upright stress under wheels, at right angles to walls and backs that may move; nothing where fill does not press."""
    assembly, k = grid.blocks("loads"), 0.0 if fill.pressure == "none" else fill.coefficients["active"]
    axles = axles_at(table, np.array([_begin(table, fill)]))[0]
    number, found = {name: b for b, name in enumerate(assembly.names)}, list[PointLoad]()
    for face in fill.faces if k > 0.0 else ():
        block = number.get(face.block)
        if face.kind in ON or block is None or assembly.fixed[block]:
            continue
        places, areas = places_on(face)
        force = areas * stress_under(fill, table.known, table.across, table.offset, axles, places)
        total = float(force.sum())
        if total > 0.0:
            place = (force[:, None] * places).sum(axis=0) / total
            way = -face.area / np.sqrt((face.area**2).sum())
            found.append(PointLoad(block, place - assembly.centre[block], k * total * way, np.ones(len(grid.times))))
    return found


def _places(table: VehicleTable, fills: Sequence[Fill], where: str) -> Places:
    """Return the places of the first axle, from where it comes onto the bridge to where the last one leaves it."""
    fill, words = on_bridge(table, fills, where), f"vehicle {table.name}" if table.name else f"vehicle of {len(table.known.loads)} axles"
    return Places(fill.deck[0], fill.deck[1] + sum(table.known.spacing), words)


KINDS = {
    "vehicle": LoadKind(
        VehicleTable,
        vehicle,
        _end,
        slow=lambda table: True,
        static=_static,
        pattern=lambda table: "live",
        places=_places,
        gentle=True,
        starter={"name": "double", "position": 2.0},
    )
}
