# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a scene that are likely in another unit, point the wrong way, belong to another code or leave a joint open: a line each, and
never a refusal.

The line names the key, its value and what that means, and how it is written in the unit in which it would be usual; the key of a scene
``quiet_checks`` lists keys whose values are intended. What is usual, and why, stands in the field of each key
(:class:`masonry_cd.foundation.units.Usual`); what some of these values are compared with is measured here (``MEASURES``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from loads import kind_of, parse_load
from loads.motion import STANDARD_GRAVITY, STEEP, lifts, parse_direction
from loads.signal.plausible import doubts as implausible
from loads.supports import one_block, select
from masonry_cd.analysis.code_check.ground import record_of
from masonry_cd.app.record_doubts import record_doubts, size_doubts
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import is_within, keys_of
from masonry_cd.app.scene_units import scene_in_si, usual_keys_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import is_number
from masonry_cd.foundation.quantities import counted, length
from masonry_cd.foundation.units import Key
from masonry_cd.mechanics.contact.find_joints import gaping
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.usual import DENSITY, SECTION

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.table import CheckRecord
    from masonry_cd.mechanics.model.blocks import Assembly
    from masonry_cd.mechanics.model.joints import Joints

PEAK = 1.875  # largest speed of the pulse of a settlement over its mean
PLACES = re.compile(r"(\[\d+\])+$")  # of numbers in a list


class Doubt(NamedTuple):
    """A value that is not usual."""

    key: str
    words: str  # the key, its value, what it comes to, and why that is not usual
    meant: str = ""  # how it would be written in another unit
    of_value: bool = True  # of rows of a list the first value is said for all


class Built(NamedTuple):
    """A scene as it is built, with which values are compared."""

    tables: Mapping[str, Any]  # of the scene
    blocks: Sequence[Block]
    gravity: float = 0.0  # [m/s2]
    structure: tuple[Assembly, Joints] | None = None
    summaries: Sequence[Mapping[str, Any]] = ()  # of loads as they are built


Measure = Callable[[float, Key, Built], tuple[float, str]]
"""Gives the size with which a value is compared, zero where it is not known, and says how large the value is against it."""


def structure_doubts(scene: Scene, blocks: Sequence[Block], names: Sequence[str] = ("structure", "structures", "material")) -> list[str]:
    """Return the lines of ``masonry-cd build`` on some tables of a scene, and the refusal of a time step: what is seen without running."""
    tables = _tables(scene)
    found = _unusual({key: tables[key] for key in names if key in tables}, scene, Built(tables, blocks))
    return _spoken([*found, *_stated(tables, blocks)], scene.quiet_checks)


def key_doubts(scene: Scene) -> list[str]:
    """Return the lines on the keys of a structure by themselves, as where it cannot be built; none where its texts are no numbers."""
    try:
        tables = _tables(scene)
    except InputError:
        return []
    return _spoken(_unusual({key: tables[key] for key in ("structure", "structures") if key in tables}, scene), scene.quiet_checks)


def assess_doubts(scene: Scene) -> list[str]:
    """Return the lines of ``masonry-cd assess`` on the table [assess]."""
    return _spoken(_unusual({"assess": _tables(scene).get("assess", {})}, scene), scene.quiet_checks)


def check_doubts(scene: Scene, record: CheckRecord) -> list[str]:
    """Lines on the record of a code check: its size, and what :mod:`loads.signal.plausible` finds."""
    where = "limit.check.record"
    processed = record_of(record, scene.folder)[0]
    found = [*size_doubts(_tables(scene)["limit"]["check"]["record"], where, [processed.numbers()])]
    found += [(where, line) for line in implausible(processed, record.correction, where)]
    return _spoken([Doubt(key, line, of_value=False) for key, line in found], scene.quiet_checks)


def doubts(scene: Scene, assembly: Assembly, joints: Joints, summaries: Sequence[Mapping[str, Any]] = ()) -> list[str]:
    """A line for each doubtful value of a scene.

    Args:
        scene: a checked one.
        assembly: its blocks.
        joints: between them, at rest.
        summaries: of its loads as they are built, where they are; a limit analysis builds none.
    """
    tables, gravity = _tables(scene), scene.run.gravity
    built = Built(tables, assembly.blocks, math.hypot(*gravity), (assembly, joints), summaries)
    found = [*_unusual(tables, scene, built), *_stated(tables, assembly.blocks)]
    others = [*astray(tables, gravity, (assembly, joints)), *record_doubts(tables.get("loads", []), summaries)]
    return _spoken([*found, *(Doubt(key, words, of_value=False) for key, words in others)], scene.quiet_checks)


def _tables(scene: Scene) -> dict[str, Any]:
    """The tables of a scene, as numbers."""
    return scene_in_si(scene.tables, scene.folder)


def _spoken(found: Sequence[Doubt], quiet: Sequence[str]) -> list[str]:
    """The lines but for those of keys that quiet_checks lists; of one key in the rows of a list the first, and how many others."""
    rows: dict[tuple[str, str], list[Doubt]] = {}
    for doubt in found:
        if not any(is_within(doubt.key, name) for name in quiet):
            rows.setdefault((re.sub(r"\[\d+\]", "", doubt.key), "" if doubt.of_value else doubt.words), []).append(doubt)
    return [_line(own[0], len(own) - 1) for own in rows.values()]


def _line(doubt: Doubt, others: int) -> str:
    """A doubt as text: ``ag = 0.25 m/s2 is 0.025 g: ...; for g write "0.25 g"; if it is intended, ...``"""
    said = doubt.words + (f" (and {others} more like it)" if others else "")
    return "; ".join([said, *([doubt.meant] if doubt.meant else []), f'if it is intended, set quiet_checks = ["{doubt.key}"]'])


def _unusual(tables: Mapping[str, Any], scene: Scene, built: Built | None = None) -> list[Doubt]:
    """The values of some tables that are not usual; those by themselves where nothing is built. Of a list of numbers the first."""
    found: dict[str, Doubt] = {}
    for key in usual_keys_of(tables, scene.folder):
        for path, value in _numbers(key):
            doubt = _doubt(path, value, key, built)
            if doubt is not None:
                found.setdefault(PLACES.sub("", path), doubt)
    return list(found.values())


def _numbers(key: Key) -> Iterator[tuple[str, float]]:
    """The numbers of a key, with their places; of a vector its size."""
    if key.usual[0].size:
        yield key.path, math.hypot(*key.value)
        return
    yield from ((path, float(value)) for path, value in keys_of(key.value, key.path) if is_number(value))


def _doubt(path: str, value: float, key: Key, built: Built | None) -> Doubt | None:
    """The doubt of a value that is not usual: the first of what is usual for its key that does not hold."""
    for usual in key.usual:
        per, means = 1.0, in_g(value) if key.unit == "m/s2" else ""
        if usual.over:
            per, means = (0.0, "") if built is None else MEASURES[usual.over](value, key, built)
        if per > 0.0 and not usual.holds(value / per):
            said = f"{path} = {value:g}{f' {key.unit}' if key.unit else ''}{f' is {means}' if means else ''}: {usual.reason}"
            return Doubt(path, said, usual.meant(value, key.unit, per))
    return None


def in_g(acceleration: float) -> str:
    """An acceleration [m/s2] as a share of gravity, ``0.25 g``."""
    return f"{acceleration / STANDARD_GRAVITY:.3g} g"


def _stated(tables: Mapping[str, Any], blocks: Sequence[Block]) -> Iterator[Doubt]:
    """Densities that files of blocks, or blocks that are given in Python, state themselves: the first of each that is not usual."""
    for where, table in _structures(tables):
        key = next((f"{where}.{name}" for name in ("path", "blocks") if name in table), "")
        own = [block for block in _of_structure(table, blocks) if key]
        odd = [block for block in own if not DENSITY.holds(block.density) and block.density != tables["material"].get("density")]
        if odd:
            count = f" and of {len(odd) - 1} more" if len(odd) > 1 else ""
            words = f'{key}: the density of block "{odd[0].name}"{count} is {odd[0].density:g} kg/m3: {DENSITY.reason}'
            yield Doubt(key, words, DENSITY.meant(odd[0].density, "kg/m3"), of_value=False)


def _structures(tables: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """The tables of what stands, with their places in the scene."""
    several = [(f"structures[{i}]", table) for i, table in enumerate(tables.get("structures", []))]
    return several or [("structure", tables.get("structure", {}))]


def _of_structure(table: Mapping[str, Any], blocks: Sequence[Block]) -> list[Block]:
    """The free blocks of a structure, which has a name where there are several."""
    return [block for block in blocks if not block.fixed and ("name" not in table or block.structure == table["name"])]


def _over_masonry(value: float, key: Key, built: Built) -> tuple[float, str]:
    """The mass of a roof or a floor, against that of the masonry that bears it."""
    table = next(table for where, table in _structures(built.tables) if key.path.startswith(f"{where}."))
    before = f"{table['name']}." if "name" in table else ""
    floors = [floor.get("name", f"floor{i + 1}") for i, floor in enumerate(table.get("floors", []))]
    at = re.search(r"floors\[(\d+)\]", key.path)
    group = before + (floors[int(at[1])] if at else "roof")  # all roofs are one group
    own = _of_structure(table, built.blocks)
    carried = {before + name for name in (*floors, "roof")}
    mass, borne = _mass(block for block in own if block.group == group), _mass(block for block in own if block.group not in carried)
    return (value * borne / mass if mass else 0.0), f"{mass / 1e3:.3g} t on {borne / 1e3:.3g} t of masonry"


def _mass(blocks: Iterator[Block]) -> float:
    return math.fsum(block.density * block.mass_properties.volume for block in blocks)


def _over_block(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A force on a block, against its weight."""
    assembly, block = _block_of(key, built)
    weight = float(assembly.mass[block]) * built.gravity
    return weight, f"{value / weight:.2g} times the weight of its block" if weight else ""


def _over_section(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A force on a block, against its mean section."""
    assembly, block = _block_of(key, built)
    section = float(assembly.volume[block]) ** (2.0 / 3.0)
    return section, f"{value / section / 1e6:.3g} MPa on its block"


def _over_all(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A force, against the weight of all blocks."""
    assembly, _ = _block_of(key, built)
    whole = float(assembly.mass[~assembly.fixed].sum()) * built.gravity
    return whole, f"{value / whole:.3g} times the weight of all blocks" if whole else ""


def _block_of(key: Key, built: Built) -> tuple[Assembly, int]:
    """The assembly, and the number of the block on which a point load acts."""
    assert built.structure is not None  # loads are looked at where they are
    return built.structure[0], one_block(key.table["block"], built.structure[0], f"{key.path.rpartition('.')[0]}.block")


def _over_stretch(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A force in a tie, against that which would stretch it to twice its length; not of a section that is doubted itself."""
    tie = key.table
    section = math.prod(tie["section"]) if "section" in tie else tie.get("area", 0.25 * math.pi * tie.get("diameter", 0.016) ** 2)
    modulus = tie.get("modulus", 1.1e10 if tie.get("material") == "timber" else 2.1e11)
    return (modulus * section if SECTION.holds(section) else 0.0), f"{value / section / 1e6:.2g} MPa in its section"


def _over_height(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A displacement, against the height of the structure."""
    height = float(_extent(built)[2])
    return height, f"{abs(value) / height:.2g} times the height of the structure"


def _over_extent(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A displacement, against the largest extent of the structure."""
    largest = float(_extent(built).max())
    return largest, f"{abs(value) / largest:.2g} times the largest extent of the structure"


def _over_duration(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A displacement of supports, against how long its fastest speed would take it."""
    per = float(key.table["duration"]) / PEAK
    return per, f"up to {abs(value) / per:.2g} m/s"


def _extent(built: Built) -> np.ndarray:
    """Extent of the free blocks, or of all where none is free, (3,) [m]."""
    corners = [block.vertices for block in built.blocks if not block.fixed] or [block.vertices for block in built.blocks]
    return np.asarray(np.ptp(np.concatenate(corners), axis=0))


def _over_joints(value: float, key: Key, built: Built) -> tuple[float, str]:
    """A displacement, against the deepest joint on the supports that move apart from others: across it, the shorter way."""
    assert built.structure is not None
    assembly, joints = built.structure
    bearing = np.zeros(assembly.count, dtype=bool)
    bearing[np.concatenate([joints.block_a, joints.block_b])] = True
    bearing &= assembly.fixed
    names = key.table.get("supports", "*")
    where = f"{key.path.rpartition('.')[0]}.supports"
    moving = select([names] if isinstance(names, str) else names, assembly, where) & assembly.fixed
    if key.table["kind"] == "settlement" and moving[bearing].all():  # the structure goes down as a whole
        return 0.0, ""
    on = np.flatnonzero((moving & bearing)[joints.block_a] | (moving & bearing)[joints.block_b])
    depth = max((_across(joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]]) for j in on), default=0.0)
    return depth, f"{abs(value) / depth:.3g} times the depth of the deepest joint on those supports, {depth:.3g} m" if depth else ""


def _across(polygon: np.ndarray) -> float:
    """Least width of a polygon (n, 3) in its plane [m]: between two lines along one of its sides."""
    sides = np.roll(polygon, -1, axis=0) - polygon
    normal = np.cross(sides[:-1], sides[1:]).sum(axis=0)
    across = np.cross(normal, sides)
    across = across[np.abs(across).max(axis=1) > 0.0]
    across /= np.sqrt((across * across).sum(axis=1))[:, None]
    return float(np.ptp(np.einsum("si,pi->sp", across, polygon), axis=1).min())


def _over_peak(value: float, key: Key, built: Built) -> tuple[float, str]:
    """The velocity of a sine, against what makes it its peak acceleration, where it is built."""
    at = re.search(r"\[(\d+)\]", key.path)
    pga = built.summaries[int(at[1])]["after"]["pga"] if at and int(at[1]) < len(built.summaries) else 0.0
    return (abs(value) / pga, f"a PGA of {pga / STANDARD_GRAVITY:.2g} g") if pga else (0.0, "")


MEASURES: Mapping[str, Measure] = {
    "mass of the masonry": _over_masonry, "weight of its block": _over_block, "section of its block": _over_section,
    "weight of all blocks": _over_all, "E A of the tie": _over_stretch, "height": _over_height, "largest extent": _over_extent,
    "duration": _over_duration, "joints": _over_joints, "its PGA": _over_peak,
}  # fmt: skip
"""Values of a structure that a key may be compared with, by the ``over`` of what is usual for the key."""


def astray(tables: Mapping[str, Any], gravity: Sequence[float], built: tuple[Assembly, Joints] | None = None) -> Iterator[tuple[str, str]]:
    """All that is doubtful in this way of checked tables; of gaps where the blocks and joints as ``built`` are known."""
    size = math.hypot(*gravity)
    if size and -gravity[2] < STEEP * size:
        way = [float(f"{part:.3g}") for part in gravity]
        yield "run.gravity", f"run.gravity = {way} m/s2 does not act along -z: heights, courses, floors and what stands on what are along z"
    down = np.asarray(gravity) / size if size else np.zeros(3)
    for i, table in enumerate(tables.get("loads", [])):
        kind = kind_of(table)
        if kind is not None and kind.senses is not None:
            yield from kind.senses(parse_load(table, f"loads[{i}]"), down, f"loads[{i}]")
    limit = tables.get("limit", {})
    if "push" in limit and lifts(_along(limit["push"]), down):
        yield "limit.push", "limit.push lifts the blocks: it acts against gravity"
    yield from _code(limit.get("check", {}))
    if built is not None:
        yield from _open(tables, *built)


def _along(direction: object) -> np.ndarray:
    """The unit vector (3,) of a direction as a scene gives it; zero of none."""
    try:
        return np.asarray(parse_direction(direction).vector)
    except (InputError, ValueError, TypeError):
        return np.zeros(3)


def _code(check: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """A spectrum of another code than that of the check."""
    if check.get("code") == "EC8" and check.get("spectrum") == "NTC":
        words = 'Eurocode 8 with its own ag and ground has spectrum = "EC8", the Italian check code = "NTC2018"'
        yield "limit.check.spectrum", f'limit.check.spectrum = "NTC" stands next to code = "EC8": {words}'


def _open(tables: Mapping[str, Any], assembly: Assembly, joints: Joints) -> Iterator[tuple[str, str]]:
    """Faces that lie against one another and do not touch."""
    pairs, gaps = gaping(assembly, joints)
    if not len(pairs):
        return
    key, names = "structure" if "structure" in tables else "structures", [assembly.names[b] for b in pairs[0]]
    which = f'{counted(len(pairs), "pair")} of blocks, as "{names[0]}" and "{names[1]}",'
    apart = (
        f"face one another {length(float(gaps.max()))} apart at most"
        if len(pairs) > 1
        else f"face one another {length(float(gaps[0]))} apart"
    )
    yield key, f"{key}: {which} {apart} and share no joint: they bear nothing there until they have closed"
