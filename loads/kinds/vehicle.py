# SPDX-License-Identifier: GPL-3.0-or-later
r"""Vehicles on a bridge: axles that stand on the road or cross it slowly, spread by the fill onto the arches and supports below.

    [[loads]]
    kind = "vehicle"
    name = "double"                    # or axles = [115e3, 95e3, 95e3] and spacing = [5.0, 1.3]
    position = 3.2                     # of the first axle along the road [m]; or
    speed = 0.5                        # towards greater x [m/s]: a crossing

The share of an axle at X that a strip of the extrados from x_a to x_b at depth d below the road bears is F(x_b - X) - F(x_a - X) over the
sum of these of the whole road, so that all of them sum to the axle's load. F is, over the length c of a wheel's contact,

    2:1            even over c + d, one across for two down,
    Boussinesq     of the stress under a line load, 2 P d^3 / (pi (x^2 + d^2)^2), within 30 degrees of the vertical: with t = x / d,
                   F = (theta + sin theta cos theta + A) / (2 A), theta = arctan t, A its value at 30 degrees,

and across the road likewise about each wheel. A strip passes its share to the block below it, upright, where it lies. What is spread to the
road before and behind the bridge, and what lies on fixed blocks, the ground bears. An axle that is not on the bridge loads nothing.

Named vehicles: LM1, the tandem system of lane 1 of load model 1, and LM2, the single axle of load model 2, both of EN 1991-2:2003, 4.3;
"single", "double", "triple" (also "double 1.3", "double 1.0" and "triple 2.0"): the authorised axles of normal traffic of CS 454
revision 0, table 7.3.1a, for masonry arches, without lift-off and without partial factors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from loads.acted import Acted, over_time
from loads.bars import PointLoad
from loads.motion import LoadAction, LoadKind, LoadTable, Places, RunGrid, Static
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.foundation.fields import Instant, is_number
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.fill import Fill, FillFace
from masonry_cd.mechanics.model.usual import FORCES

TONNE = 9.81e3  # weight of one, as CS 454 takes it [N]
THIRTY = math.pi / 6.0  # where Boussinesq's stresses are cut off
ALONG, ACROSS, LINES = 3, 8, 5  # strips of a face along the road, and across it; lines that stand for a contact
LEAST_DEPTH = 0.01  # [m] at which a load is spread at least, so that none falls between two strips
MOST_AXLES = 40
AXLE = Usual(500.0, 1e6, "axles weigh 0.5 kN (a cart) to 1 MN (heavy transport)", FORCES)
CROSSING = Usual(0.0, 45.0, "vehicles cross bridges of masonry at up to 45 m/s, 160 km/h", ("km/h",))

ON = ("extrados", "top")


class Known(NamedTuple):
    """A vehicle by name."""

    loads: tuple[float, ...]  # [N]
    spacing: tuple[float, ...]  # [m]
    track: float  # [m]
    contact: tuple[float, float]  # of a wheel along and across [m]


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
    across: Literal["wheels", "line"] = "wheels"
    """Two wheels to an axle, or a line over the whole width between the walls, as in load tests."""
    track: Measure | None = None
    """Between the middles of the two wheels of an axle; 1.8 m when neither it nor a name is given."""
    contact: Annotated[tuple[float, float] | None, Unit("m"), BeforeValidator(_numbers)] = None
    """Contact area of a wheel, along and across the road; 0.3 m by 0.3 m when neither it nor a name is given."""
    offset: Annotated[float, Unit("m")] = 0.0
    """Offset of its middle from that of the bridge, along y."""
    position: Annotated[float, Unit("m")] | None = None
    """Position of the first axle along the road at the start; of a crossing before the bridge when not given."""
    speed: Annotated[float, Unit("m/s"), CROSSING, Field(ge=0.0)] = 0.0
    """Towards greater x; 0: it stands."""
    start: Instant = 0.0
    """When it is there, or sets off."""
    ramp: Instant = 0.0
    """Time in which one that stands is put on."""

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


@dataclass(frozen=True, eq=False)
class Strips:
    """S strips of the extradoses and tops of a bridge under the road, as a vehicle on it loads them."""

    face: np.ndarray  # (S,) its face
    ends: np.ndarray  # (S, 2) along the road [m]
    depth: np.ndarray  # (S,) [m]
    place: np.ndarray  # (S, 3) where the load of the strip acts, world frame [m]
    share: np.ndarray  # (S,) of a load on its part of the road that the strip bears, of those that lie next to each other

    def weights(self, at: np.ndarray, fill: Fill, contact: float) -> np.ndarray:
        """Shares (M, S) of loads at M places along the road, none of those off the bridge; the road next to it bears the rest."""
        low, high = self.ends.T
        before, behind = (float(self.depth[k]) for k in (int(np.argmin(low)), int(np.argmax(high))))
        own = self.share * (_below(high - at[:, None], self.depth, contact, fill) - _below(low - at[:, None], self.depth, contact, fill))
        rest = _below(low.min() - at, before, contact, fill) + 1.0 - _below(high.max() - at, behind, contact, fill)
        on = (at >= fill.deck[0]) & (at <= fill.deck[1])
        return np.asarray(np.where(on[:, None], own / (own.sum(axis=1) + rest)[:, None], 0.0))


def _below(x: np.ndarray, depth: np.ndarray | float, contact: float, fill: Fill) -> np.ndarray:
    """F of the head of this file at x [m]: the share of a load that is spread to less than x."""
    d = np.maximum(depth, LEAST_DEPTH)
    if fill.spread == "2:1":
        return np.asarray(np.clip(0.5 + x / (contact + d), 0.0, 1.0))
    whole = THIRTY + 0.25 * math.sqrt(3.0)
    total = np.zeros(np.broadcast(x, d).shape)
    for k in range(LINES):
        t = np.clip((x - contact * ((k + 0.5) / LINES - 0.5)) / d, -math.tan(THIRTY), math.tan(THIRTY))
        total = total + 0.5 * (libm.atan(t) + t / (1.0 + t * t) + whole) / whole
    return total / LINES


def strips_of(fill: Fill, table: VehicleTable) -> Strips:
    """Cut the faces below the road into strips, and share the wheels of an axle among those next to each other."""
    return _strips(fill, table.known, table.across, table.offset)


@lru_cache(maxsize=8)  # they are those of all places of a vehicle, which is asked for at many
def _strips(fill: Fill, vehicle: Known, line: str, offset: float) -> Strips:
    rows = list[tuple[int, np.ndarray, float, np.ndarray, float]]()
    for number, face in enumerate(fill.faces):
        if face.kind in ON:
            rows += [(number, *row) for row in _of_face(face, fill, vehicle, None if line == "line" else offset)]
    face_of, ends, depth, place, across = zip(*rows, strict=True)
    ends_of, share = np.array(ends), np.array(across)
    return Strips(np.array(face_of), ends_of, np.array(depth), np.array(place), share)


def _of_face(face: FillFace, fill: Fill, vehicle: Known, offset: float | None) -> list[tuple[np.ndarray, float, np.ndarray, float]]:
    """Ends along the road, depth, place and share across of the strips of one face, a quadrilateral over a line across the road; a vehicle
    without an offset is a line."""
    own = fill.along(face.corners)
    own[:, 0] -= fill.slant * own[:, 1]
    (x0, z0), (x1, z1) = own[0, [0, 2]], own[1, [0, 2]]
    near, far = float(own[0, 1]), float(own[2, 1])
    cuts = np.linspace(near, far, (ACROSS if fill.slant else 1) + 1)  # a slanted joint lies elsewhere under each wheel
    found = []
    for k, (a, b) in product(range(ALONG), pairwise(cuts.tolist())):
        m = (k + 0.5) / ALONG
        z = z0 + m * (z1 - z0)
        share, y = _across(a, b, fill.level - z, fill, vehicle, offset)
        place = np.array([x0 + m * (x1 - x0) + fill.slant * y, y, z])
        ends = x0 + (x1 - x0) * np.array([k, k + 1]) / ALONG + fill.slant * y
        if share > 0.0:
            found.append((ends, fill.level - z, fill.in_world(place), share))
    return found


def _across(near: float, far: float, depth: float, fill: Fill, vehicle: Known, offset: float | None) -> tuple[float, float]:
    """The share of an axle that a strip between two places across the road bears, of all that is between the walls, and its middle."""
    ends = np.linspace(near, far, ACROSS + 1)
    if offset is None:
        wide = fill.clear[1] - fill.clear[0]
        return (far - near) / wide, 0.5 * (near + far)
    part, whole = np.zeros(ACROSS), 0.0
    for wheel in (offset - 0.5 * vehicle.track, offset + 0.5 * vehicle.track):
        part = part + np.diff(_below(ends - wheel, depth, vehicle.contact[1], fill))
        whole += float(np.diff(_below(np.array(fill.clear) - wheel, depth, vehicle.contact[1], fill))[0])
    share = float(part.sum()) / whole
    middle = 0.5 * (ends[1:] + ends[:-1])
    return share, float(np.sum(part * middle) / part.sum()) if part.sum() > 0.0 else 0.5 * (near + far)


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
    reach = 0.5 * (table.known.track + table.known.contact[1])
    low, high = table.offset - reach, table.offset + reach
    if table.across == "wheels" and (low < fill.clear[0] - 1e-9 or high > fill.clear[1] + 1e-9):
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
    strips, vehicle = strips_of(fill, table), table.known
    axles = axles_at(table, first)
    total = np.zeros((len(first), len(strips.face)))
    for k, load in enumerate(vehicle.loads):
        total += load * strips.weights(axles[:, k], fill, vehicle.contact[0])
    return strips, total


def vehicle(table: VehicleTable, grid: RunGrid, where: str) -> LoadAction:
    """A vehicle that stands or crosses.

    Raises:
        InputError: no bridge, no place, or one that is next to the road or never on it.
    """
    fill, loads = _loads(table, grid, where)
    summary = table.facts("name", "offset", "position", "speed", "start")
    summary |= {"axles": list(table.known.loads), "spacing": list(table.known.spacing)}
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
    return f"{where} vehicle{named} of {len(vehicle.loads)} axles, {total:.4g} N, its first axle {moves}; spread {spread}"


def _end(table: VehicleTable, grid: RunGrid, where: str) -> float:
    """When its last axle has left the bridge, or when it stands; the run that is not long enough yet need not have it on the deck."""
    return _acted(table, on_bridge(table, grid.fills, where), where).end


def _static(table: VehicleTable, grid: RunGrid, where: str) -> Static:
    """All axles, standing where the first is at the position."""
    standing = table.model_copy(update={"speed": 0.0, "start": 0.0, "ramp": 0.0})
    return Static(f"{where} (vehicle)", tuple(_loads(standing, grid, where)[1]))


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
