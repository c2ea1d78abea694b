# SPDX-License-Identifier: GPL-3.0-or-later
"""Junctions: where the strips of two walls overlap in plan, which of them end there, and whether that can be interlocked.

Two straight strips of a plan share a parallelogram. A wall whose middle line ends in it, at a corner or against the side of the other, is
taken on to the far face of the other one, so that every corner is filled; a wall that goes on crosses it. Walls that meet in one place make
one junction, of two walls or more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import shapely
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import Faults
from masonry_cd.mechanics.model.components import connected_components
from structures.building.axes import SAME, Facet, Leg, Span
from structures.building.table import BuildingTable, JunctionBond
from structures.plans.places import place

LEAST_ANGLE = math.radians(25.0)  # of two walls that meet: stones of a sharper one would be slivers
STUB = 0.1  # by which a wall that crosses another has to stick out beyond it [m]
MOST_PAIRS = 1000  # of walls that meet, whose junctions are looked for where others cannot be
NEARBY = 3.0  # of a wall that joins no other, from the nearest: farther off it is another building [m]
MORE = 0.2  # of a facet of an arc next to a junction [m]


@dataclass(frozen=True, eq=False)
class Arm:
    """A facet of a leg at a junction."""

    leg: int  # number of the leg
    facet: int  # number of its facet
    low: float  # s between which the other walls of the junction reach into its strip [m]
    high: float
    end: int  # -1 where it begins at the junction, 1 where it ends there, 0 where it goes through


@dataclass(frozen=True, eq=False)
class FacetPair:
    """Two facets that meet."""

    arms: tuple[Arm, Arm]
    point: np.ndarray  # (2,) where their middle lines meet [m]
    region: Polygon  # parallelogram that they share
    bond: JunctionBond = "bonded"
    through: int = 0  # which of the two runs through where courses do not interlock


@dataclass(frozen=True, eq=False)
class Junction:
    """Walls that meet in one place."""

    pairs: tuple[FacetPair, ...]
    legs: tuple[int, ...]  # in the order of the scene

    @property
    def point(self) -> np.ndarray:
        """(2,) about where it is [m]."""
        return np.asarray(np.mean([pair.point for pair in self.pairs], axis=0))


def find(legs: Sequence[Leg], table: BuildingTable, faults: Faults) -> list[Junction]:
    """The junctions of a plan; what cannot be one is added to the faults."""
    pairs, refused = [], set[frozenset[str]]()
    quads = [[strip(leg, facet) for facet in leg.facets] for leg in legs]
    for a, f, b, g in _candidates(legs, quads):
        if min(_highest(legs[a]), _highest(legs[b])) > max(legs[a].base, legs[b].base) + SAME:
            before = len(faults.found)
            pair = _meet(legs, (a, f), (b, g), (quads[a][f], quads[b][g]), faults)
            pairs += [pair] if pair else []
            refused |= {frozenset((legs[a].keys.name, legs[b].keys.name))} if len(faults.found) > before else set()
    if faults.found and len(pairs) > MOST_PAIRS:  # as of many walls into one point, which are refused in any case
        return []
    pairs = _without_doubles(pairs)
    bonds = _bonds(legs, pairs, table, refused, faults)
    pairs = [FacetPair(p.arms, p.point, p.region, *bond) for p, bond in zip(pairs, bonds, strict=True)]
    return _clusters(pairs)


def _candidates(legs: Sequence[Leg], quads: Sequence[Sequence[np.ndarray]]) -> Iterator[tuple[int, int, int, int]]:
    """Leg and facet of those whose strips may meet, and of the other, in the order of the legs."""
    boxes = np.array([[*quad.min(axis=0), *quad.max(axis=0)] for own in quads for quad in own]).reshape(-1, 4)
    owner = np.repeat(np.arange(len(legs)), [len(leg.facets) for leg in legs])
    first = np.concatenate([[0], np.cumsum([len(leg.facets) for leg in legs])]).astype(int)
    for a in range(len(legs)):
        near = [(f, first[a + 1] + np.flatnonzero(_near(boxes[first[a] + f], boxes[first[a + 1] :]))) for f in range(len(legs[a].facets))]
        found = sorted((int(owner[k]), f, int(k - first[owner[k]])) for f, own in near for k in own)
        yield from ((a, f, b, g) for b, f, g in found)


def along(legs: Sequence[Leg], wall: int) -> list[Span]:
    """The stretches of the axis of a wall that its junctions take up, and a little more [m]."""
    found = []
    own, others = ([(leg, facet) for leg in legs if (leg.wall == wall) is mine for facet in leg.facets] for mine in (True, False))
    for (leg, facet), (other, across) in product(own, others):
        if abs(facet.sine(across)) < math.sin(LEAST_ANGLE):
            continue
        s, t = facet.crossing(across)
        reach = _reach((other, across), (leg, facet))
        if -SAME <= s <= facet.length + SAME and -reach <= t <= across.length + reach:
            half = _reach((leg, facet), (other, across)) + MORE
            found.append((facet.at_of(s) - half, facet.at_of(s) + half))
    return found


def _reach(one: tuple[Leg, Facet], other: tuple[Leg, Facet]) -> float:
    """How far on either side of the point in which two walls meet the second takes up the first [m]."""
    (leg, facet), (its, across) = one, other
    cosine = float(facet.along[0] * across.along[0] + facet.along[1] * across.along[1])
    return (0.5 * its.thickness + 0.5 * leg.thickness * abs(cosine)) / abs(facet.sine(across))


def strip(leg: Leg, facet: Facet) -> np.ndarray:
    """The four corners (4, 2) of a facet in plan [m], without what junctions add."""
    half = 0.5 * leg.thickness
    low, high = facet.cuts
    corners = [(-half * low, -half), (facet.length - half * high, -half), (facet.length + half * high, half), (half * low, half)]
    return facet.place(np.array(corners))


def _highest(leg: Leg) -> float:
    return max(z for _, z in leg.tops)


def _near(box: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which boxes (N, 4) x0, y0, x1, y1 touch one (4,)."""
    return np.asarray((others[:, :2] <= box[2:] + 1e-6).all(axis=1) & (others[:, 2:] >= box[:2] - 1e-6).all(axis=1))


def _meet(
    legs: Sequence[Leg], first: tuple[int, int], second: tuple[int, int], quads: tuple[np.ndarray, np.ndarray], faults: Faults
) -> FacetPair | None:
    """How two facets of different legs meet; None where they do not."""
    one, other = (Polygon(quad) for quad in quads)
    if one.distance(other) > 1e-6:
        return None
    shared = one.intersection(other).area
    (leg, facet), (others, across) = ((legs[a], legs[a].facets[f]) for a, f in (first, second))
    sine = facet.sine(across)
    names = f"walls {leg.keys.name} and {others.keys.name}" if leg.wall != others.wall else f"legs of wall {leg.keys.name}"
    if abs(sine) < math.sin(LEAST_ANGLE):
        if shared > 1e-6:
            centre = one.intersection(other).centroid
            angle = math.degrees(math.asin(abs(sine)))
            faults.add(
                others.where,
                f"{names}: their strips overlap at {place(np.array([centre.x, centre.y]))}, at an angle of {angle:.0f} degrees; none "
                f"is possible below {math.degrees(LEAST_ANGLE):.0f}: let one end on the face of the other, or draw them as one wall",
            )
        return None
    s, t = facet.crossing(across)
    point = facet.start + s * facet.along
    arms, ends = [], ((leg, facet), (others, across))
    for k, ((number, f), at) in enumerate(((first, s), (second, t))):
        arm = _arm(ends[k][0], number, f, at, _reach(ends[k], ends[1 - k]))
        if isinstance(arm, str):
            if shared > 1e-6:
                faults.add(others.where, f"{names} at {place(point)}: {arm}")
            return None
        arms.append(arm)
    return FacetPair((arms[0], arms[1]), point, _parallelogram(leg, facet, others, across, point, sine))


def _arm(leg: Leg, number: int, f: int, s: float, reach: float) -> Arm | str:
    """Find out if a facet ends at another wall or goes through; a text where neither is possible."""
    facet = leg.facets[f]
    length, name = facet.length, leg.keys.name
    low, high = s - reach, s + reach
    at_start, at_end = facet.open[0] and low - 1e-6 <= 0.0 <= high + 1e-6, facet.open[1] and low - 1e-6 <= length <= high + 1e-6
    if at_start and at_end:
        return f"wall {name} is only {length:.3g} m long there, no longer than the other is thick"
    if high < -1e-6 or low > length + 1e-6:
        return f"wall {name} does not reach the other, it only touches its edge"
    for outer, is_open in ((low, facet.open[0]), (length - high, facet.open[1])):
        if is_open and not (at_start or at_end) and outer < STUB:
            return f"wall {name} sticks out {1e3 * outer:.0f} mm beyond the other; let it end there, or stick out {1e3 * STUB:.0f} mm"
    if (low < -1e-6 and not at_start and not facet.open[0]) or (high > length + 1e-6 and not at_end and not facet.open[1]):
        return f"wall {name} bends there; a junction has to lie within one of its straight pieces"
    if (at_start and high > length - STUB) or (at_end and low < STUB):
        return f"the straight piece of wall {name} there is only {length:.3g} m long; take a longer one"
    return Arm(number, f, low, high, -1 if at_start else 1 if at_end else 0)


def _parallelogram(leg: Leg, facet: Facet, other: Leg, across: Facet, point: np.ndarray, sine: float) -> Polygon:
    """Return the area that two strips without ends share."""
    a = 0.5 * other.thickness / sine * facet.along
    b = 0.5 * leg.thickness / sine * across.along
    return Polygon([point + a + b, point - a + b, point - a - b, point + a - b])


def _without_doubles(pairs: Sequence[FacetPair]) -> list[FacetPair]:
    """One pair of each two legs in one place: next to a bend two facets of a leg may touch the other wall."""
    found: list[FacetPair] = []
    for pair in sorted(pairs, key=lambda p: sum(arm.end != 0 for arm in p.arms), reverse=True):
        legs = [arm.leg for arm in pair.arms]
        twins = [p for p in found if [arm.leg for arm in p.arms] == legs and p.region.distance(pair.region) < 1e-6]
        if not twins:
            found.append(pair)
    return sorted(found, key=lambda p: [(arm.leg, arm.facet, arm.low) for arm in p.arms])


def _bonds(
    legs: Sequence[Leg], pairs: Sequence[FacetPair], table: BuildingTable, refused: set[frozenset[str]], faults: Faults
) -> list[tuple[JunctionBond, int]]:
    """How each pair is bonded, and which of its two walls runs through where it is not; names of walls whose junction is refused."""
    given, known = dict[tuple[str, str], tuple[JunctionBond, str]](), {leg.keys.name for leg in legs}
    for k, entry in enumerate(table.junctions):
        where = f"structure.junctions[{k}].walls"
        unknown = [name for name in entry.walls if name not in known]
        for name in unknown:
            faults.add(where, f'there is no wall "{name}"')
        if not unknown:
            given[entry.walls] = (entry.bond, where)
    found, used = [], set()
    for pair in pairs:
        a, b = (legs[arm.leg].keys.name for arm in pair.arms)
        key = next((names for names in ((a, b), (b, a)) if names in given), None)
        used.add(key)
        whole = 1 if pair.arms[0].end and not pair.arms[1].end else 0  # of a T, the one that goes on
        found.append((given[key][0], int(key != (a, b))) if key else (table.junction, whole))
    for names, (_, where) in given.items():
        if names not in used and frozenset(names) not in refused:
            faults.add(where, f"walls {names[0]} and {names[1]} do not meet")
    return found


def _clusters(pairs: Sequence[FacetPair]) -> list[Junction]:
    """Pairs whose parallelograms overlap make one junction."""
    links = [
        (i, j)
        for i in range(len(pairs))
        for j in range(i + 1, len(pairs))
        if {a.leg for a in pairs[i].arms} & {a.leg for a in pairs[j].arms} and pairs[i].region.intersection(pairs[j].region).area > 1e-9
    ]
    first, second = (np.array([link[k] for link in links], dtype=int) for k in (0, 1))
    label = connected_components(first, second, len(pairs))
    junctions = []
    for k in dict.fromkeys(label.tolist()):
        own = tuple(pairs[i] for i in np.flatnonzero(label == k).tolist())
        junctions.append(Junction(own, tuple(sorted({arm.leg for pair in own for arm in pair.arms}))))
    return junctions


def apart(legs: Sequence[Leg], found: Sequence[Junction]) -> list[str]:
    """A line on each wall, or set of walls, that is near others and joins none of them, though they are joined among themselves."""
    link = [(a, b) for junction in found for a, b in pairwise(junction.legs)]
    link += [(k, k + 1) for k in range(len(legs) - 1) if legs[k].wall == legs[k + 1].wall]
    first, second = (np.array([pair[k] for pair in link], dtype=int) for k in (0, 1))
    label = connected_components(first, second, len(legs))
    sizes = np.bincount(label, minlength=1)
    if len(sizes) < 2 or sizes.max() < 2:
        return []
    strips = [shapely.union_all([Polygon(strip(leg, facet)) for facet in leg.facets]) for leg in legs]
    lines = []
    for one in range(len(sizes)):
        own = np.flatnonzero(label == one)
        others = [(k, j) for k in own for j in np.flatnonzero(label != one) if sizes[one] < sizes.max() or label[j] < one]
        gap, k, j = min(((strips[k].distance(strips[j]), int(k), int(j)) for k, j in others), default=(math.inf, 0, 0))
        if SAME < gap <= NEARBY:
            at = np.array(shapely.shortest_line(strips[k], strips[j]).coords[0])
            more = f" and {len(own) - 1} joined to it" if len(own) > 1 else ""
            near = f"{legs[k].keys.name}{more} joins no other: it is {gap:.3g} m from wall {legs[j].keys.name} at {place(at)}"
            lines.append(f"wall {near}; draw its axis on to the other where they are one")
    return lines
