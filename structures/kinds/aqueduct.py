# SPDX-License-Identifier: GPL-3.0-or-later
"""Aqueducts and arcades: piers, semicircular rings and spandrels in courses, in one to three tiers.

A tier is a bridge (:mod:`structures.bridge`) of equal semicircular spans on equal piers, whose spandrel walls
(:mod:`structures.bridge.spandrels`) are as thick as it is wide, in place of fill. Upper tiers stand on the level top of the tier below, by
default with the same pitch. The default, of the order of Roman work in large squared blocks, is three openings of 5 m on piers of 2 m.

Groups, for friction and for damage by part: ``base``, ``pier1`` ..., ``arch1`` ..., ``spandrel1`` ... over the pier of that
number, ``top`` for the courses that run over the crowns, and ``channel`` for walls and slabs of the channel on top; from a second
tier on, ``tier2_pier1`` and so on. The tier starts with its left end at x = 0 and is centred on y = 0; the feet of the lowest piers
are at z = 0.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.bridge import layout as bridge
from structures.bridge.layout import SAME, BridgeSupport
from structures.bridge.masonry import arches, drawn_out
from structures.bridge.spandrels import STEP, bed_over, pieces
from structures.bridge.table import AbutmentTable, BridgeSupportTable, BridgeTable, SpandrelTable, SpanTable
from structures.courser import wall_plan
from structures.courser.bond import LEAST_BOND, cleared
from structures.courser.courses import divided
from structures.geometry.prism import box, prism_xz, rectangle
from structures.kind import Keys, StructureKind, scaled, value_of
from structures.macro_elements import AROUND, EAST, HINGES, NORTH, OVERTURNING, WEST, BlockLayout, MacroElement
from structures.schema import COVER, THICK, Length, Table, WallHeight

LEAST_RING = 0.001  # thickness of the arches [m]: thinner ones would be lost among corners that are taken for one
LEAST_CHANNEL = 0.1  # height of the walls of the channel, in courses
LEAST_GAP = 0.4  # between two rings at the springing, in courses
MOST_VOUSSOIRS = 2000  # to an arch, as of any ring
LEAST_CHORD = 0.35  # of a voussoir on the extrados, in courses
SPAN, PIER = re.compile(r"(?:tier\d+_)?arch\d*$"), re.compile(r"(?:tier\d+_)?pier\d+$")  # groups


def _per_tier(unit: str, kind: type) -> Callable[[Any], tuple[Any, ...]]:
    """A reader of one number above zero, or of a list with one such number per tier."""
    number = "a whole number" if kind is int else "a number"

    def read(value: Any) -> tuple[Any, ...]:
        values = tuple(value) if isinstance(value, (list, tuple)) else (value,)
        allowed = (int,) if kind is int else (int, float)
        if not values or any(isinstance(v, bool) or not isinstance(v, allowed) or not 0 < v < math.inf for v in values):
            raise ValueError(f"must be {number} above 0{unit}, or a list with one per tier")
        return tuple(kind(v) for v in values)

    return read


def _one_or_many(kind: str) -> dict[str, Any]:
    """Return the JSON schema of such a key."""
    one = {"type": kind, "exclusiveMinimum": 0}
    return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1, "maxItems": 3}]}


Lengths = Annotated[tuple[float, ...], Unit("m"), BeforeValidator(_per_tier(" [m]", float)), WithJsonSchema(_one_or_many("number"))]
Counts = Annotated[tuple[int, ...], BeforeValidator(_per_tier("", int)), WithJsonSchema(_one_or_many("integer"))]


class AqueductTable(Table):
    """The [structure] table of an aqueduct. Plural types take one value, or a list with one value per tier."""

    tiers: int = Field(1, ge=1, le=3)
    """rows of arches on one another"""
    spans: Counts = (3,)
    """number of arches"""
    clear_span: Lengths = (5.0,)
    """between the faces of the piers"""
    pier_width: Lengths = (2.0,)
    """along the aqueduct"""
    pier_courses: Counts = (8,)
    """below the springings"""
    pier_blocks: int = Field(2, ge=1, le=2)
    """blocks to a course of a pier; 2 stand in alternating bond"""
    course_height: WallHeight = Field(0.5)
    ring_thickness: Annotated[Lengths, THICK] = (0.6,)
    """of the arches"""
    voussoirs: Counts | None = None
    """to an arch; by default their length is that of 1.2 courses"""
    cover: Annotated[Lengths, COVER] | None = None
    """from the crown of the extrados to the level top; by default 1.5 courses"""
    width: Lengths = (2.0,)
    """across the aqueduct, along y"""
    unit_length: Length | None = None
    """of the blocks in the spandrels; by default 2 courses"""
    ends: Literal["pier", "abutment"] = "pier"
    """support of the last arches"""
    channel_width: Length | None = None
    """clear width of a channel on top; none by default"""
    channel_height: WallHeight | None = None
    """clear, of the channel; by default its width"""
    base_margin: Length | None = None
    """of the base around the feet; by default half the height"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build an aqueduct on its base, lowest tier first.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    aqueduct = parse_table(AqueductTable, table, "structure")
    size.check_size(_estimate(aqueduct), "course_height" if aqueduct.course_height < 0.01 * min(aqueduct.clear_span) else "spans")
    tiers = tiers_of(aqueduct)
    blocks = _base(aqueduct, tiers, density)
    if aqueduct.ends == "abutment":
        blocks += _abutments(tiers, density)
    for tier, over in zip(tiers, [*tiers[1:], None], strict=True):
        blocks += _tier_blocks(tier, over, density, prefix=f"tier{tier.number}_" if len(tiers) > 1 else "")
    blocks += _channel(aqueduct, tiers[-1], density)
    return blocks


@dataclass(frozen=True, eq=False)
class Tier:
    """A bridge of equal semicircular spans on equal piers whose spandrels are masonry over its whole width."""

    number: int
    layout: bridge.BridgeLayout
    course: float  # height of a course [m]
    unit: float  # length of a block of the spandrels [m]
    pier_courses: int
    pier_blocks: int

    @property
    def ends(self) -> tuple[float, float]:
        """x of its ends [m]."""
        return self.layout.ends

    @property
    def length(self) -> float:
        """[m]"""
        return self.ends[1] - self.ends[0]

    @property
    def pitch(self) -> float:
        """Distance between the axes of neighbouring piers [m]."""
        return self.layout.supports[1].left - self.layout.supports[0].left

    @property
    def half(self) -> float:
        """Half the width, along y [m]."""
        return 0.5 * self.layout.keys.width


def _estimate(aqueduct: AqueductTable) -> float:
    """About how many blocks an aqueduct has, by the largest value of each key."""
    course, pier, clear = aqueduct.course_height, max(aqueduct.pier_width), max(aqueduct.clear_span)
    outer = 0.5 * clear + max(aqueduct.ring_thickness)
    ring = max(aqueduct.voussoirs or (math.pi * outer / (1.2 * course),))
    cover = max(aqueduct.cover or (1.5 * course,))
    spandrel = (clear + pier) * (outer + cover) - 0.5 * math.pi * outer * outer
    stones = max(spandrel, 0.0) / course / (aqueduct.unit_length or 2.0 * course)
    per_span = max(aqueduct.pier_courses) * aqueduct.pier_blocks + ring + stones
    channel = 2.0 * (clear + pier) * (aqueduct.channel_height or aqueduct.channel_width or 0.0) / course / (2.0 * course)
    return max(aqueduct.spans) * (aqueduct.tiers * per_span + channel)


def _channel(aqueduct: AqueductTable, tier: Tier, density: float) -> list[Block]:
    """The channel on the level top: a wall along either side, and slabs across them."""
    from structures.building import square_plan

    wide = aqueduct.channel_width
    if wide is None:
        if aqueduct.channel_height is not None:
            raise InputError("structure.channel_width", "missing; it makes the channel whose height is given")
        return []
    most = 2.0 * tier.half - 0.4 * tier.course
    if wide > most:
        raise InputError("structure.channel_width", f"must be at most {most:g} m, which leaves two walls, got {wide:g}")
    height, least = aqueduct.channel_height or wide, LEAST_CHANNEL * tier.course
    if height < least:
        key = "channel_width" if aqueduct.channel_height is None else "channel_height"
        raise InputError(f"structure.{key}", f"the walls of the channel must be at least {least:g} m high, got {height:g}")
    low, high = tier.layout.deck, tier.layout.deck + height
    (start, end), half = tier.ends, tier.half
    walls = [
        wall_plan.PlanWall(f"channel_{name}", "channel", 0, start, end, near, far, low, high)
        for name, near, far in (("front", -half, -0.5 * wide), ("back", 0.5 * wide, half))
    ]
    sizes = wall_plan.Sizes(tier.course, tier.unit)
    blocks = square_plan.build(walls, square_plan.beds_of(walls, sizes), sizes, density)
    for number, (x0, x1) in enumerate(pairwise(divided(start, end, tier.unit)), start=1):
        slab = box((x0, -half, high), (x1, half, high + max(0.5 * tier.course, 0.15 * wide)))
        blocks.append(Block(f"channel_slab.{number}", *slab, density, "channel"))
    return blocks


def tiers_of(aqueduct: AqueductTable) -> list[Tier]:
    """The tiers of an aqueduct, lowest first.

    Raises:
        InputError: measures that do not fit together.
    """
    tiers: list[Tier] = []
    for i in range(aqueduct.tiers):
        tiers.append(_tier(aqueduct, i, tiers[-1] if tiers else None))
        if i:
            _check_on(tiers[i], tiers[i - 1], aqueduct.ends)
    return tiers


def _tier(aqueduct: AqueductTable, i: int, below: Tier | None) -> Tier:
    course, unit = aqueduct.course_height, aqueduct.unit_length or 2.0 * aqueduct.course_height
    pier_width = _of_tier(aqueduct, "pier_width", i)
    clear_span = _of_tier(aqueduct, "clear_span", i)
    if below and len(aqueduct.clear_span) == 1:  # the pitch of the tier below
        clear_span = below.pitch - pier_width
        if clear_span <= 0:
            raise InputError("structure.pier_width", f"must be below the pitch, {below.pitch:g} m, in tier {i + 1}, got {pier_width:g}")
    thickness = _of_tier(aqueduct, "ring_thickness", i)
    if thickness < LEAST_RING:
        raise InputError("structure.ring_thickness", f"must be at least {LEAST_RING:g} m, got {thickness:g}")
    extrados = math.pi * (0.5 * clear_span + thickness)
    natural = max(5, 2 * round((extrados / (1.2 * course) - 1) / 2) + 1)  # odd: with a keystone
    courses = _of_tier(aqueduct, "pier_courses", i)
    span = SpanTable.model_construct(
        shape="semicircular", span=clear_span, thickness=thickness, voussoirs=_of_tier(aqueduct, "voussoirs", i) or natural,
        springing=(below.layout.deck if below else 0.0) + courses * course,
    )  # fmt: skip
    pier = {"width": pier_width, "height": courses * course, "course_height": course, "rigid": False}
    cover = _of_tier(aqueduct, "cover", i) or 1.5 * course
    _check_arch(span, pier_width, cover, course, f" in tier {i + 1}" if i else "")
    if unit < 0.5 * course:
        raise InputError("structure.unit_length", f"must be at least half a course, {0.5 * course:g} m, got {unit:g}")
    count, pitch = _of_tier(aqueduct, "spans", i), clear_span + pier_width
    length, width = count * pitch + pier_width, _of_tier(aqueduct, "width", i)
    left = (0.5 * sum(below.ends) if below else 0.5 * length) - 0.5 * length + pier_width
    keys = BridgeTable.model_construct(
        spans=tuple(span.model_copy(update={"start": left + n * pitch}) for n in range(count)), width=width, cover=cover,
        piers=(BridgeSupportTable.model_construct(**pier),), abutments=(AbutmentTable.model_construct(**pier),),
        walls=SpandrelTable.model_construct(thickness=width, course_height=course, unit_length=unit),
    )  # fmt: skip
    return Tier(i + 1, bridge.laid_out(keys), course, unit, courses, aqueduct.pier_blocks)


def _of_tier(aqueduct: AqueductTable, key: str, i: int) -> Any:
    """The value of a key for a tier, None where the key is not given."""
    values = getattr(aqueduct, key)
    if values is None:
        return None
    if len(values) not in (1, aqueduct.tiers):
        raise InputError(f"structure.{key}", f"one value or one per tier, {aqueduct.tiers}, got {len(values)}")
    return values[0 if len(values) == 1 else i]


def _check_arch(span: SpanTable, pier_width: float, cover: float, course: float, where: str) -> None:
    """Measures of one tier that exclude each other."""
    least, ring, clear = 2.0 * span.thickness + LEAST_GAP * course, span.thickness, span.span
    if pier_width < least - 1e-9:
        what = "seats two rings with a course between them"
        raise InputError("structure.pier_width", f"must be at least {least:g} m{where}, which {what}, got {pier_width:g}")
    if clear < LEAST_GAP * course:
        raise InputError("structure.clear_span", f"must be at least {LEAST_GAP * course:g} m{where}, {LEAST_GAP:g} courses, got {clear:g}")
    if ring >= clear:
        raise InputError("structure.ring_thickness", f"must be below the clear span, {clear:g} m{where}, got {ring:g}")
    most = math.floor(math.pi / (2.0 * math.asin(min(1.0, 0.5 * LEAST_CHORD * course / (0.5 * clear + ring)))))
    most = min(most, MOST_VOUSSOIRS)
    if span.voussoirs is None or not 3 <= span.voussoirs <= most:
        raise InputError("structure.voussoirs", f"must be 3 to {most} for courses of {course:g} m{where}, got {span.voussoirs}")
    if cover < STEP * course - 1e-9:
        raise InputError("structure.cover", f"must be at least half a course, {STEP * course:g} m{where}, got {cover:g}")


def _check_on(tier: Tier, below: Tier, ends: str) -> None:
    """A tier must stand on the one below."""
    n = tier.number
    if tier.length > below.length * (1.0 + 1e-9):
        pier = tier.layout.supports[0]
        most = math.floor((below.length - (pier.right - pier.left)) / tier.pitch + 1e-9)
        raise InputError(
            "structure.spans", f"tier {n} is {tier.length:g} m long, longer than the {below.length:g} m below; at most {most} spans"
        )
    wide, own = below.layout.keys.width, tier.layout.keys.width
    if own > wide * (1.0 + 1e-9):
        raise InputError("structure.width", f"tier {n} must be at most as wide as the one below, {wide:g} m, got {own:g}")
    if ends == "abutment" and tier.length < below.length * (1.0 - 1e-9):
        raise InputError("structure.ends", f"abutments need tiers of one length, tier {n} has {tier.length:g} of {below.length:g} m")


def _tier_blocks(tier: Tier, over: Tier | None, density: float, prefix: str) -> list[Block]:
    """The blocks of a tier by their parts: ``pier1.3``, ``arch1.v5``, ``spandrel2.7`` over the second pier, ``top.4``."""
    supports, layout = tier.layout.supports, tier.layout
    spandrels: dict[str, list[np.ndarray]] = {name: [] for name in (*(f"spandrel{i}" for i in range(1, len(supports) + 1)), "top")}
    middles = np.array([0.5 * (support.left + support.right) for support in supports])
    level = bed_over(layout.profiles[0].crown, tier.course, layout.deck)  # the first bed that runs over the crowns
    for polygon in pieces(layout, _feet(over) if over else ()):
        nearest = int(np.argmin(np.abs(middles - polygon[:, 0].mean()))) + 1
        spandrels["top" if polygon[:, 1].min() > level - SAME else f"spandrel{nearest}"].append(polygon)
    piers = {f"pier{i}": _pier(tier, support, spandrels[f"spandrel{i}"]) for i, support in enumerate(supports, start=1)}
    rings = [replace(block, name=prefix + block.name, group=prefix + block.group) for block in arches(layout, density)[0]]
    return [*_drawn(tier, piers, density, prefix), *rings, *_drawn(tier, spandrels, density, prefix)]


def _drawn(tier: Tier, parts: Mapping[str, Sequence[np.ndarray]], density: float, prefix: str) -> list[Block]:
    """The stones (n, 2) of parts by the name of each, drawn out over the whole width and numbered."""
    return [
        Block(f"{prefix}{part}.{number}", *drawn_out(tier.layout, polygon, -tier.half, tier.half), density, prefix + part)
        for part, polygons in parts.items()
        for number, polygon in enumerate(polygons, start=1)
    ]


def _pier(tier: Tier, support: BridgeSupport, spandrel: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The blocks (4, 2) of a pier up to the springing, from its foot; head joints of its last course are clear of what stands on it."""
    beds = np.linspace(support.foot, support.springing, tier.pier_courses + 1).tolist()
    met = [float(x) for stone in spandrel for x, z in stone if abs(z - support.springing) <= SAME]
    found = list[np.ndarray]()
    for course, (low, high) in enumerate(pairwise(beds)):
        heads = _pier_heads(tier, support, course)
        heads = [cleared(x, met, LEAST_BOND * tier.unit, (support.left, support.right)) for x in heads] if high == beds[-1] else heads
        found += [rectangle(a, b, low, high) for a, b in pairwise([support.left, *heads, support.right])]
    return found


def _pier_heads(tier: Tier, support: BridgeSupport, course: int) -> list[float]:
    """x of the head joint of a course of a pier, at one third and two thirds in turn [m]."""
    if tier.pier_blocks == 1:
        return []
    return [support.left + (support.right - support.left) * (1 if course % 2 else 2) / 3.0]


def _feet(tier: Tier) -> list[float]:
    """x of the faces of the piers of a tier and of the head joints in their first course [m]."""
    return [x for support in tier.layout.supports for x in (support.left, *_pier_heads(tier, support, 0), support.right)]


def _base(aqueduct: AqueductTable, tiers: list[Tier], density: float) -> list[Block]:
    """A fixed slab under each pier of the lowest tier, from midspan to midspan and on all around."""
    tier = tiers[0]
    margin = aqueduct.base_margin or 0.5 * tiers[-1].layout.deck
    ends = [tier.ends[0] - margin, *(profile.axis for profile in tier.layout.profiles), tier.ends[1] + margin]
    half = tier.half + margin
    return [
        Block(f"base{pier}", *prism_xz(rectangle(a, b, -tier.course, 0.0), -half, half), density, "base", fixed=True)
        for pier, (a, b) in enumerate(pairwise(ends), start=1)
    ]


def _abutments(tiers: list[Tier], density: float) -> list[Block]:
    """Fixed blocks at both ends, from the base to the level top of the highest tier, as wide as a pier."""
    tier, top = tiers[0], tiers[-1].layout.deck
    wide = tier.layout.supports[0].right - tier.layout.supports[0].left
    return [
        Block(f"abutment{number}", *prism_xz(rectangle(x, x + outwards, 0.0, top), -tier.half, tier.half), density, "base", fixed=True)
        for number, (x, outwards) in enumerate(zip(tier.ends, (-wide, wide), strict=True), start=1)
    ]


def resized(table: Keys, factor: float) -> Keys:
    """The courses of the piers are counted, and their height is what the piers keep: it follows from the whole number."""
    before, height = (value_of(AqueductTable, table, name) for name in ("pier_courses", "course_height"))
    made = scaled(AqueductTable, {"cover": 1.5 * height} | table, factor, ("unit_length",), {"pier_courses": 2, "voussoirs": 2})
    total, now = (sum(n) if isinstance(n, (list, tuple)) else n for n in (before, made["pier_courses"]))
    return made | {"course_height": height * total / now}


def bonds(table: Keys) -> dict[str, Keys]:
    """Piers of whole courses, or of two blocks in bond."""
    whole = value_of(AqueductTable, table, "pier_blocks") == 1
    return {"piers in bond" if whole else "whole courses in piers": {"pier_blocks": 2 if whole else 1}}


def parts(layout: BlockLayout) -> list[MacroElement]:
    """Spans and piers, each with what rests on it."""
    free, found = np.flatnonzero(~layout.fixed), []
    for name in layout.names:
        own = layout.of_groups(name)
        low, high = layout.low[own].min(axis=0), layout.high[own].max(axis=0)
        middle = layout.middle[free, 0]
        if SPAN.search(name):
            over = free[(layout.low[free, 2] >= low[2]) & (middle > low[0]) & (middle < high[0])]
            over = over[[not PIER.search(str(layout.group[b])) for b in over]]
            found.append(MacroElement(f"span {name}", "span", np.union1d(own, over), (EAST, WEST, NORTH), (HINGES,)))
        elif PIER.search(name):
            over = free[(layout.low[free, 2] >= high[2] - 1e-6) & (middle >= low[0]) & (middle <= high[0])]
            found.append(MacroElement(f"{name} with what stands on it", "pier", np.union1d(own, over), AROUND, (OVERTURNING,)))
    return found


KIND = StructureKind(
    build, AqueductTable, first={"spans": 3, "clear_span": 5.0, "pier_width": 2.0, "ring_thickness": 0.6, "width": 2.0},
    resized=resized, bonds=bonds, parts=parts,
)  # fmt: skip
