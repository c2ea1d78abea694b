# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a church: where its walls stand and what they are pierced by, the apse, the columns, the roof.

See :mod:`structures.kinds.church` for the whole. All measures are derived in one place (:class:`Church`) from the keys of the table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from structures.courser import rings
from structures.courser.arch_profiles import ring as circle
from structures.courser.columns import ColumnTable, column
from structures.courser.courses import divided
from structures.courser.vault_courses import barrel
from structures.courser.wall_plan import Opening, PlanWall, Sizes, natural_ring
from structures.geometry.prism import box
from structures.kinds.church_table import ChurchTable

PLATE = 0.3  # height of the wall plate that carries a timber roof [m]
GAP = 0.05  # between a wall plate and a gable [m]


@dataclass(frozen=True, eq=False)
class Church:
    """The measures of a church [m]; heights lie on whole courses."""

    keys: ChurchTable
    unit: float
    course: float
    thick: float
    length: float
    half: float  # clear half-width of the nave
    eaves: float
    aisle_eaves: float  # of the outer walls, where there are aisles
    apse_top: float  # where the half dome springs
    outer: float  # y of the outer face of the outermost side walls

    @classmethod
    def of(cls, keys: ChurchTable) -> Church:
        """Derive the measures from the keys."""
        course = keys.course_height or 0.5 * keys.block_length
        half, t = 0.5 * keys.width, keys.thickness or 1.0
        outer = half + t + (keys.aisle_width + t if keys.aisles else 0.0)
        whole = [course * round(z / course) for z in (keys.height, keys.aisle_height, keys.apse_height)]
        return cls(keys, keys.block_length, course, t, keys.length, half, whole[0], whole[1], whole[2], outer)

    @property
    def sizes(self) -> Sizes:
        """Sizes of the stones."""
        return Sizes(self.course, self.unit)

    @property
    def tower_x(self) -> tuple[float, float]:
        """Where the tower stands along x."""
        middle = 0.7 * self.length if self.keys.tower_place is None else self.keys.tower_place
        low, high = middle - 0.5 * self.keys.tower_side, middle + 0.5 * self.keys.tower_side
        clear = self.thick + 0.5 * self.unit
        if low < clear or high > self.length - clear:
            room = clear + 0.5 * self.keys.tower_side
            raise InputError(
                "structure.tower_place", f"must be between {room:.4g} and {self.length - room:.4g} m, clear of the ends, got {middle:g}"
            )
        return low, high

    @property
    def vault(self) -> float:
        """Thickness of the vault over the nave."""
        return self.keys.vault_thickness or 0.07 * self.keys.width

    @property
    def bay(self) -> tuple[float, float]:
        """Distance between the columns of an arcade, and the width of what its arches spring from."""
        bay = (self.length - 2.0 * self.thick) / self.keys.bays
        pier = max((0.2 * bay + 0.75 * self.unit) / 1.2, 0.7 * self.thick)
        return bay, pier

    @property
    def arch_ring(self) -> float:
        """Thickness of the arches of an arcade."""
        bay, pier = self.bay
        return 0.1 * (bay - pier)

    def window(self, centre: float, sill: float, top: float) -> tuple[Opening, ...]:
        """A window in a wall with its eaves at the top, or none where a window of the default height has no room."""
        keys, width = self.keys, self.keys.window_width
        if keys.window_height is not None:
            return (self.arched("window_width and window_height", centre, width, sill, keys.window_height),)
        low = self.level(sill)
        made = self.arched("window_width and window_height", centre, width, sill, min(2.5, 0.35 * top, top - low - 2.0 * self.course))
        return (made,) if made.crown + 0.5 * self.course < top and made.height >= width else ()

    def level(self, z: float) -> float:
        """The nearest whole course."""
        return self.course * round(z / self.course)

    def arched(self, key: str, centre: float, width: float, sill: float, height: float, depth: float | None = None) -> Opening:
        """A round-headed opening whose sill and springing lie on whole courses."""
        low = self.level(sill)
        springing = max(self.level(sill + height - 0.5 * width), low + self.course)
        ring = depth or natural_ring(width, self.course)
        return Opening(f"structure.{key}", centre, width, low, springing - low + 0.5 * width, "round", ring)


def walls(church: Church) -> list[PlanWall]:
    """All walls in plan."""
    found = [_facade(church), _arch_wall(church), *_side_walls(church), *_buttresses(church)]
    if church.keys.tower:
        found += _tower(church)
    return [replace(wall, leaves=church.keys.leaves) for wall in found]


def _across(church: Church, name: str, near: float, openings: tuple[Opening, ...]) -> PlanWall:
    """A wall across the whole church, with a gable over the nave."""
    a, b = church.half + church.thick, church.outer
    shoulder = (church.aisle_eaves, -a, a) if church.keys.aisles else None
    far, gable = near + church.thick, church.keys.gable or 0.0
    return PlanWall(name, name, 1, -b, b, near, far, 0.0, church.eaves, openings, gable, shoulder=shoulder)


def _facade(church: Church) -> PlanWall:
    keys, openings = church.keys, []
    if keys.door_width:
        openings.append(church.arched("door_width and door_height", 0.0, keys.door_width, 0.0, keys.door_height))
    if keys.windows:
        sill = max(0.6 * church.eaves, (openings[0].crown if openings else 0.0) + 2.0 * church.course)
        openings += church.window(0.0, sill, church.eaves + 0.5 * (keys.gable or 0.0))
    return _across(church, "facade", 0.0, tuple(openings))


def _arch_wall(church: Church) -> PlanWall:
    """The wall of the triumphal arch; without an apse a plain one."""
    keys, near = church.keys, church.length - church.thick
    if not keys.apse:
        return _across(church, "east_wall", near, ())
    room = keys.apse_radius / math.cos(0.5 * math.pi / keys.apse_sides) - 0.4 * church.unit
    most = 2.0 * room / 1.24
    span = keys.arch_span or most
    if not 0.2 * most <= span <= most * (1.0 + 1e-9):
        raise InputError("structure.arch_span", f"must be between {0.2 * most:.4g} and {most:.4g} m, within the apse, got {span:g}")
    springing = church.level(0.75 * keys.apse_height)
    opening = Opening("structure.arch_span", 0.0, span, 0.0, springing + 0.5 * span, "round", 0.12 * span)
    return _across(church, "triumphal_arch", near, (opening,))


def _side_walls(church: Church) -> list[PlanWall]:
    """The walls along the nave, and those of the aisles."""
    keys, found = church.keys, []
    low, springing, arches = (church.eaves, 0.0, ()) if not keys.aisles else (church.aisle_eaves, *_arcade(church))
    for side, name in ((-1.0, "south"), (1.0, "north")):
        near, far = sorted((side * church.half, side * (church.half + church.thick)))
        above = church.aisle_eaves + 0.3 * (church.eaves - church.aisle_eaves) if keys.aisles else 0.5 * church.eaves
        if arches:
            above = max(above, arches[0].crown + 2.0 * church.course)
            for number, (start, end) in enumerate(_responds(church), start=1):
                found.append(PlanWall(f"respond_{name}{number}", "nave_walls", 0, start, end, near, far, 0.0, springing, anchor=0.0))
        openings = (*arches, *_windows(church, above, church.eaves, name == "north" and not keys.aisles))
        found.append(PlanWall(f"nave_{name}", "nave_walls", 0, 0.0, church.length, near, far, springing, church.eaves, openings))
        if keys.aisles:
            near, far = sorted((side * church.outer, side * (church.outer - church.thick)))
            openings = _windows(church, 0.4 * low, low, name == "north")
            found.append(PlanWall(f"aisle_{name}", "aisle_walls", 0, 0.0, church.length, near, far, 0.0, low, openings))
    return found


def _windows(church: Church, sill: float, top: float, next_to_tower: bool) -> tuple[Opening, ...]:
    """The windows of a side wall; none opens into the tower."""
    keys, clear = church.keys, church.length - 2.0 * church.thick
    low, high = church.tower_x if keys.tower and next_to_tower else (math.inf, -math.inf)
    reach = 0.5 * keys.window_width + church.unit
    places = [church.thick + (i + 0.5) * clear / keys.windows for i in range(keys.windows)]
    return tuple(window for x in places if not low - reach < x < high + reach for window in church.window(x, sill, top))


def _arcade(church: Church) -> tuple[float, tuple[Opening, ...]]:
    """The springing of the arches between nave and aisles, and the arches."""
    bay, pier = church.bay
    width, springing = bay - pier, church.level(0.6 * church.aisle_eaves)
    if width < 2.0 * church.course:
        most = math.floor((church.length - 2.0 * church.thick) / (2.0 * church.course + pier))
        raise InputError("structure.bays", f"must be at most {most} for this length, got {church.keys.bays}")
    places = [church.thick + (i + 0.5) * bay for i in range(church.keys.bays)]
    arches = (Opening("structure.bays", x, width, springing, 0.5 * width, "round", church.arch_ring) for x in places)
    return springing, tuple(arches)


def _responds(church: Church) -> list[tuple[float, float]]:
    """Where the half piers at the ends of the arcades stand along x."""
    end = church.thick + 0.5 * church.bay[1]
    return [(0.0, end), (church.length - end, church.length)]


def _buttresses(church: Church) -> list[PlanWall]:
    """Short walls that stand out from the outermost side walls, halfway between the windows."""
    keys, t = church.keys, church.thick
    vault = keys.roof == "vault"
    count = keys.buttresses if keys.buttresses is not None else (max(0, keys.windows - 1) if vault else 0)
    depth = keys.buttress_depth or (keys.width / 3.0 if vault else t)
    clear, wide = church.length - 2.0 * t, max(0.8 * t, 1.2 * church.course)
    top = church.level(0.9 * (church.aisle_eaves if keys.aisles else church.eaves))
    found = []
    for i in range(count):
        x = t + (i + 1) * clear / (count + 1)
        near = [abs(x - window.centre) for window in _windows(church, 0.0, church.eaves, False)]
        if near and min(near) < 0.5 * (wide + keys.window_width) + 0.37 * church.unit:
            raise InputError(
                "structure.buttresses", f"must be {max(0, keys.windows - 1)}, one between every two windows, or 0, got {count}"
            )
        for side, name in ((-1.0, "south"), (1.0, "north")):
            if side > 0 and keys.tower and church.tower_x[0] - wide - church.unit < x < church.tower_x[1] + wide + church.unit:
                continue
            start, end = sorted((side * (church.outer - t), side * (church.outer + depth)))
            wall = PlanWall(f"buttress_{name}{i + 1}", "buttresses", 1, start, end, x - 0.5 * wide, x + 0.5 * wide, 0.0, top)
            found.append(wall)
    return found


def _tower(church: Church) -> list[PlanWall]:
    """The bell tower on the north side: the side wall of the church is its south wall up to the eaves."""
    keys, side, host = church.keys, church.keys.tower_side, church.thick
    t = min(host, side / 4.5)
    (x0, x1), y0 = church.tower_x, church.outer - host
    eaves, top = (church.aisle_eaves if keys.aisles else church.eaves), church.level(keys.tower_height)
    width = min(0.3 * side, (side - host - t - 0.75 * church.unit) / 1.7)  # leaves room for its arch between the corners
    belfry: dict[int, tuple[Opening, ...]] = {0: (), 1: ()}
    if width > 0.5 * church.course:
        sill = top - 2.0 * width - 0.2 * width - 2.5 * church.course
        belfry = {
            i: (church.arched("tower_side", c, width, sill, 2.0 * width),)
            for i, c in ((0, 0.5 * (x0 + x1)), (1, y0 + 0.5 * (host + side - t)))
        }
    above = y0 + (church.vault if keys.roof == "vault" and not keys.aisles else 0.0)  # the vault rests on the inner part of the wall
    walls_ = [
        PlanWall("tower_north", "tower", 0, x0, x1, y0 + side - t, y0 + side, 0.0, top, belfry[0]),
        PlanWall("tower_south", "tower", 0, x0, x1, above, y0 + host, eaves, top, belfry[0]),
    ]
    for name, near in (("west", x0), ("east", x1 - t)):
        if above == y0:
            walls_.append(PlanWall(f"tower_{name}", "tower", 1, y0, y0 + side, near, near + t, 0.0, top, belfry[1]))
        else:
            walls_.append(PlanWall(f"tower_{name}", "tower", 1, y0, y0 + side, near, near + t, 0.0, eaves))
            walls_.append(PlanWall(f"tower_{name}_high", "tower", 1, above, y0 + side, near, near + t, eaves, top, belfry[1], anchor=y0))
    return walls_


def with_apse(church: Church, walls_: Sequence[PlanWall], beds: Sequence[float], density: float) -> tuple[list[PlanWall], list[Block]]:
    """The apse with its half dome; every other course of its wall reaches into the wall that it leans on, which leaves room for it.

    Returns:
        all walls, and the blocks of the apse.
    """
    keys, t, r = church.keys, church.thick, church.keys.apse_radius
    if not keys.apse:
        return list(walls_), []
    half_circle = rings.Ring(2 * keys.apse_sides, keys.apse_sides, -0.5 * math.pi, (church.length, 0.0))
    wall_thickness, stretch = 0.75 * t, math.hypot(1.0, half_circle.slope)
    inner, outer = r * stretch, (r + wall_thickness) * stretch  # of the corners
    if outer > church.half + t:
        most = (church.half + t) / stretch - wall_thickness
        raise InputError("structure.apse_radius", f"must be at most {most:.4g} m to lean on the wall behind it, got {r:g}")
    own = [z for z in beds if z < church.apse_top + 1e-9]
    rows: list[rings.RingCourse] = []
    voids: list[tuple[float, float, float, float]] = []
    half = r * half_circle.slope
    windows = [i for i in range(keys.apse_sides) if i % 2 == 1] if keys.windows else []
    sill, head = 0.45 * church.apse_top, 0.75 * church.apse_top
    for j, row in enumerate(rings.wall_rows("apse", r, wall_thickness, own)):
        low, high = own[j], own[j + 1]
        if sill <= low and high <= head:
            row = replace(row, gaps=dict.fromkeys(windows, 0.35 * half))
        elif rows and rows[-1].gaps:
            row = replace(row, lintels=dict.fromkeys(windows, 0.65 * half))
        if keys.bonded and j % 2 == 1:
            stretches = [(-outer, -inner), (inner, outer)]
            ends = tuple(box((church.length - t, a, low), (church.length, b, high)) for a, b in stretches)
            row = replace(row, ends=ends)
            voids += [(a, b, low, high) for a, b in stretches]
        rows.append(row)
    shell = min(wall_thickness, max(0.3, 0.1 * r))
    top = math.acos(min(0.25, 0.8 * shell / r))
    rows += rings.dome_rows("half_dome", r, shell, church.apse_top, max(3, round(top * r / max(shell, church.course))), top)
    blocks = rings.build(half_circle, rows, church.unit, density)
    blocks.append(rings.key(half_circle, rows[-1], density, "half_dome.key", "half_dome"))
    return [replace(wall, voids=tuple(voids)) if wall.name == "triumphal_arch" else wall for wall in walls_], blocks


def columns(church: Church, density: float) -> list[Block]:
    """The columns of the arcades between nave and aisles."""
    bay, pier = church.bay
    wide, height = max(pier, church.thick), _arcade(church)[0]
    keys = ColumnTable.model_validate(
        {
            "height": height,
            "diameter": 0.75 * wide,
            "top_diameter": 0.7 * wide,
            "width": wide,
            "drums": max(1, round(0.8 * height / max(2.0 * church.course, 0.6))),
            "plinth": 0.08 * height,
            "capital": 0.12 * height,
        }
    )
    found = []
    for side, name in ((-1.0, "south"), (1.0, "north")):
        y = side * (church.half + 0.5 * church.thick)
        for i in range(1, church.keys.bays):
            found += column((church.thick + i * bay, y), 0.0, keys, density, f"column_{name}{i}.", "arcades")
    return found


def roof_plates(church: Church) -> list[Block]:
    """Timber plates on the side walls, as heavy as the part of the roof that each carries."""
    keys, t = church.keys, church.thick
    aisle = 0.5 * keys.aisle_width if keys.aisles else 0.0
    lines = [("nave", church.half, church.eaves, church.half + t + aisle)]
    if keys.aisles:
        lines.append(("aisle", church.outer - t, church.aisle_eaves, aisle + t))
    found: list[Block] = []
    for name, inner, z, carried in lines:
        for side in (-1.0, 1.0):
            cut = [church.tower_x] if keys.tower and side > 0 and inner + t > church.outer - 1e-9 else []
            for x0, x1 in _stretches(t + GAP, church.length - t - GAP, cut):
                y0, y1 = sorted((side * (inner + 0.2 * t), side * (inner + 0.8 * t)))
                heavy = keys.roof_mass * carried / (PLATE * 0.6 * t)
                for low, high in pairwise(divided(x0, x1, max(3.0, 2.0 * church.unit))):
                    label = f"plate_{name}_{'south' if side < 0 else 'north'}.{len(found) + 1}"
                    found.append(Block(label, *box((low, y0, z), (high, y1, z + PLATE)), heavy, "roof"))
    return found


def _stretches(low: float, high: float, cut: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the rest of an interval between the cuts, with a gap on each side."""
    found = [(low, high)]
    for a, b in cut:
        found = [part for x0, x1 in found for part in ((x0, min(x1, a - GAP)), (max(x0, b + GAP), x1)) if part[1] - part[0] > 0.5]
    return found


def nave_vault(church: Church, density: float) -> list[Block]:
    """A barrel vault over the nave, on the side walls between facade and triumphal arch."""
    inner, outer = church.half, church.half + church.vault
    count = 2 * round(0.5 * math.pi * inner / (1.2 * church.course)) + 1
    intrados, extrados = circle(inner, outer, 180.0, count)
    ends = (church.thick, church.length - church.thick)
    along_y = barrel(intrados, extrados, ends, church.unit, density, name="vault.")
    return [
        replace(b, vertices=b.vertices[:, [1, 0, 2]] + [0.0, 0.0, church.eaves], faces=tuple(tuple(reversed(f)) for f in b.faces))
        for b in along_y
    ]
