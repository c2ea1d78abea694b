# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a scene that are likely in another unit: a line each, and never a refusal.

The line names the key, its value and what that means, and how it is written in the unit in which it would be usual; the key of a scene
``quiet_checks`` lists keys whose values are meant so. The ranges, and why they are such, are in :mod:`masonry_cd.app.ranges`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from loads.signal.plausible import doubts as implausible
from loads.supports import one_block, select
from masonry_cd.analysis.code_check.ground import record_of
from masonry_cd.app.ranges import RANGES, G, range_of
from masonry_cd.app.record_doubts import record_doubts, size_doubts
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import is_within, keys_of, parse_toml
from masonry_cd.app.scene_units import scene_in_si, unit_of_key
from masonry_cd.app.senses import astray
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import is_number
from masonry_cd.mechanics.model.blocks import Block

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.table import CheckRecord
    from masonry_cd.mechanics.model.blocks import Assembly
    from masonry_cd.mechanics.model.joints import Joints

PEAK = 1.875  # largest speed of the pulse of a settlement over its mean


class Doubt(NamedTuple):
    """A value that is not usual."""

    key: str
    value: float | None  # None: the words say it all
    words: str  # what the value comes to, and why that is not usual
    meant: str = ""  # how it would be written in another unit


def structure_doubts(scene: Scene, blocks: Sequence[Block], names: Sequence[str] = ("structure", "structures", "material")) -> list[str]:
    """What ``masonry-cd build`` says of some tables of a scene, and the refusal of a time step beside: what is seen without running."""
    tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    mine: dict[str, Any] = {key: tables[key] for key in names if key in tables}
    return _spoken([*_plain(mine), *_stated(tables, blocks), *_ties(mine), *_carried(mine, blocks)], tables, scene.quiet_checks)


def key_doubts(scene: Scene) -> list[str]:
    """What is said of the keys of a structure by themselves, as where it cannot be built; nothing where its texts are no numbers."""
    try:
        tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    except InputError:
        return []
    return _spoken(_plain({key: tables[key] for key in ("structure", "structures") if key in tables}), tables, scene.quiet_checks)


def assess_doubts(scene: Scene) -> list[str]:
    """What ``masonry-cd assess`` says of the table [assess]."""
    tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    return _spoken(_plain({"assess": tables.get("assess", {})}), tables, scene.quiet_checks)


def check_doubts(scene: Scene, record: CheckRecord) -> list[str]:
    """Lines on the record of a code check: its size, and what :mod:`loads.signal.plausible` finds."""
    tables, where = scene_in_si(parse_toml(scene.text, scene.origin.path)), "limit.check.record"
    processed = record_of(record, scene.folder)[0]
    found = [*size_doubts(tables["limit"]["check"]["record"], where, [processed.numbers()])]
    found += [(where, line) for line in implausible(processed, record.correction, where)]
    return _spoken([Doubt(key, None, line) for key, line in found], tables, scene.quiet_checks)


def doubts(scene: Scene, assembly: Assembly, joints: Joints, summaries: Sequence[Mapping[str, Any]] = ()) -> list[str]:
    """A line for each doubtful value of a scene.

    Args:
        scene: a checked one.
        assembly: its blocks.
        joints: between them, at rest.
        summaries: of its loads as they are built, where they are; a limit analysis builds none.
    """
    tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    size = math.hypot(*scene.run.gravity)
    found = [*_plain(tables), *_stated(tables, assembly.blocks), *_ties(tables), *_carried(tables, assembly.blocks)]
    found += _doubt("run.gravity", size, "gravity", _in_g(size))
    found += [Doubt(key, None, words) for key, words in astray(tables, scene.run.gravity, (assembly, joints))]
    for i, table in enumerate(tables.get("loads", [])):
        where, kind = f"loads[{i}]", table.get("kind")
        if kind == "point":
            found += _point(table, where, assembly, size)
        elif kind in ("settlement", "spreading"):
            found += _moved(table, where, assembly, joints)
        elif kind == "push":
            found += _pushed(table, where, assembly)
        elif i < len(summaries):
            found += _shaken(table, where, summaries[i])
    found += [Doubt(key, None, line) for key, line in record_doubts(tables.get("loads", []), summaries)]
    return _spoken(found, tables, scene.quiet_checks)


def _spoken(found: Sequence[Doubt], tables: Mapping[str, Any], quiet: Sequence[str]) -> list[str]:
    """The lines but for those of keys that are meant so; of one key in the rows of a list the first, and how many others."""
    rows: dict[tuple[str, str], list[Doubt]] = {}
    for doubt in found:
        if not any(is_within(doubt.key, name) for name in quiet):
            rows.setdefault((re.sub(r"\[\d+\]", "", doubt.key), doubt.words if doubt.value is None else ""), []).append(doubt)
    return [_line(own[0], len(own) - 1, tables) for own in rows.values()]


def _line(doubt: Doubt, others: int, tables: Mapping[str, Any]) -> str:
    """A doubt in words: ``ag = 0.25 m/s2 is 0.025 g: ...; if g is meant: "0.25 g"; if it is meant so, ...``"""
    unit = unit_of_key(tables, doubt.key)
    said = doubt.words if doubt.value is None else f"{doubt.key} = {doubt.value:g}{f' {unit}' if unit else ''}{doubt.words}"
    said += f" (and {others} more like it)" if others else ""
    return "; ".join([said, *([doubt.meant] if doubt.meant else []), f'if it is meant so, quiet_checks = ["{doubt.key}"] says so'])


def _doubt(key: str, value: float, name: str, means: str = "", per: float = 1.0) -> list[Doubt]:
    """The doubt of a value that is not usual.

    Args:
        key: its place in the scene.
        value: in the unit of the key.
        name: of its range.
        means: what the value comes to, in words.
        per: what the value is compared with, in relation to which the range is given.
    """
    usual = RANGES[name]
    if not per > 0.0 or usual.holds(value / per):
        return []
    return [Doubt(key, value, f"{f' is {means}' if means else ''}: {usual.reason}", usual.meant(value, per))]


def _in_g(acceleration: float) -> str:
    return f"{acceleration / G:.3g} g"


def _plain(tables: Mapping[str, Any]) -> list[Doubt]:
    """Values that are compared by themselves."""
    found: dict[str, Doubt] = {}  # by key: of a list of numbers the first that is not usual
    for key, value in keys_of(tables):
        unit = unit_of_key(tables, key) if is_number(value) else ""
        name = range_of(re.sub(r"\[\d+\]", "", key).replace("structures.", "structure.", 1), unit) if is_number(value) else ""
        if name:
            for doubt in _doubt(key, float(value), name, _in_g(float(value)) if unit == "m/s2" else ""):
                found.setdefault(re.sub(r"(\[\d+\])+$", "", key), doubt)
    return [*found.values()]


def _stated(tables: Mapping[str, Any], blocks: Sequence[Block]) -> Iterator[Doubt]:
    """Densities that files of blocks, or blocks that are given in Python, state themselves: the first of each that is not usual."""
    usual = RANGES["density"]
    for where, table in _structures(tables):
        key = next((f"{where}.{name}" for name in ("path", "blocks") if name in table), "")
        own = [block for block in blocks if key and not block.fixed and (where == "structure" or block.structure == table["name"])]
        odd = [block for block in own if not usual.holds(block.density) and block.density != tables["material"].get("density")]
        if odd:
            count = f" and of {len(odd) - 1} more" if len(odd) > 1 else ""
            words = f'{key}: the density of block "{odd[0].name}"{count} is {odd[0].density:g} kg/m3: {usual.reason}'
            yield Doubt(key, None, words, usual.meant(odd[0].density, 1.0))


def _structures(tables: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """The tables of what stands, with their places in the scene."""
    several = [(f"structures[{i}]", table) for i, table in enumerate(tables.get("structures", []))]
    return several or [("structure", tables.get("structure", {}))]


def _carried(tables: Mapping[str, Any], blocks: Sequence[Block]) -> Iterator[Doubt]:
    """What roofs and floors weigh, against the masonry that bears them."""
    for where, table in _structures(tables):
        name = f"{table['name']}." if where != "structure" else ""
        floors = {
            f"{name}{floor.get('name', f'floor{i + 1}')}": (f"{where}.floors[{i}].mass", floor["mass"])
            for i, floor in enumerate(table.get("floors", []))
        }
        roofs = [(f"{where}.roofs[{i}].mass", roof["mass"]) for i, roof in enumerate(table.get("roofs", []))]
        roofs += [(f"{where}.roof_mass", table["roof_mass"])] if "roof_mass" in table else []
        if roofs:  # all are one group
            floors[f"{name}roof"] = max(roofs, key=lambda found: found[1])
        own = [block for block in blocks if not block.fixed and (not name or block.structure == table["name"])]
        borne = math.fsum(_mass(block) for block in own if block.group not in floors)
        for group, (key, value) in floors.items():
            mass = math.fsum(_mass(block) for block in own if block.group == group)
            if mass and borne:
                yield from _doubt(key, value, "carried", f"{mass / 1e3:.3g} t on {borne / 1e3:.3g} t of masonry", value * borne / mass)


def _mass(block: Block) -> float:
    return block.density * block.mass_properties.volume


def _point(table: Mapping[str, Any], where: str, assembly: Assembly, gravity: float) -> list[Doubt]:
    """A point load against the weight and the section of its block."""
    block, size = one_block(table["block"], assembly, f"{where}.block"), math.hypot(*table["force"])
    weight, section = float(assembly.mass[block]) * gravity, float(assembly.volume[block]) ** (2.0 / 3.0)
    whole = float(assembly.mass[~assembly.fixed].sum()) * gravity
    key = f"{where}.force"
    light = _doubt(key, size, "force", f"{size / weight:.2g} times the weight of its block" if weight else "", weight)
    heavy = _doubt(key, size, "pressure", f"{size / section / 1e6:.3g} MPa on its block", section)
    return light or heavy or _doubt(key, size, "overload", f"{size / whole:.3g} times the weight of all blocks" if whole else "", whole)


def _ties(tables: Mapping[str, Any]) -> list[Doubt]:
    """What ties pull at the start and where they yield, by how far that stretches them."""
    places = _structures(tables)
    ties = [(f"{where}.ties[{i}]", tie) for where, table in places for i, tie in enumerate(table.get("ties", []))]
    ties += [
        (f"{where}.floors[{i}].anchors", floor["anchors"])
        for where, table in places
        for i, floor in enumerate(table.get("floors", []))
        if "anchors" in floor
    ]
    ties += [(f"loads[{i}]", table) for i, table in enumerate(tables.get("loads", [])) if table.get("kind") == "tie"]
    return [doubt for where, tie in ties for doubt in _stretched(where, tie)]


def _stretched(where: str, tie: Mapping[str, Any]) -> list[Doubt]:
    """The forces of a tie over the force that would stretch it to twice its length."""
    section = math.prod(tie["section"]) if "section" in tie else tie.get("area", 0.25 * math.pi * tie.get("diameter", 0.016) ** 2)
    modulus = tie.get("modulus", 1.1e10 if tie.get("material") == "timber" else 2.1e11)
    found = _doubt(f"{where}.section", max(tie["section"]), "side") if "section" in tie else []
    if found or not RANGES["section"].holds(section):  # which has a line of its own
        return found
    for key, name in (("yield_force", "yielding"), ("tension", "tension")):
        if key in tie:
            found += _doubt(f"{where}.{key}", tie[key], name, f"{tie[key] / section / 1e6:.2g} MPa in its section", modulus * section)
    return found


def _moved(table: Mapping[str, Any], where: str, assembly: Assembly, joints: Joints) -> list[Doubt]:
    """A settlement against the size of the structure, against the joints on its supports, and by its speed."""
    blocks = assembly.blocks
    corners = np.concatenate([block.vertices for block in blocks if not block.fixed] or [block.vertices for block in blocks])
    extent, key, value = np.ptp(corners, axis=0), f"{where}.displacement", float(table["displacement"])
    speed = PEAK * abs(value) / table["duration"]
    size, what = (float(extent[2]), "height") if table["kind"] == "settlement" else (float(extent.max()), "largest extent")
    means = f"{abs(value) / size:.2g} times the {what} of the structure, at up to {speed:.2g} m/s"
    depth = _depth(table, where, assembly, joints)
    parted = f"{abs(value) / depth:.3g} times the depth of the deepest joint on those supports, {depth:.3g} m" if depth else ""
    return (
        _doubt(key, value, table["kind"], means, size)
        or _doubt(key, value, "apart", parted, depth)
        or _doubt(key, value, "speed", means, float(table["duration"]) / PEAK)
    )


def _pushed(table: Mapping[str, Any], where: str, assembly: Assembly) -> list[Doubt]:
    """The target of a push that is farthest, against the height of the structure."""
    targets, corners = np.atleast_1d(table.get("targets", 0.0)), [block.vertices for block in assembly.blocks if not block.fixed]
    farthest, height = float(targets[np.abs(targets).argmax()]), float(np.ptp(np.concatenate(corners)[:, 2]))
    return _doubt(f"{where}.targets", farthest, "pushed", f"{abs(farthest) / height:.2g} times the height of the structure", height)


def _depth(table: Mapping[str, Any], where: str, assembly: Assembly, joints: Joints) -> float:
    """Depth of the deepest joint on the supports of a load that moves apart from others [m]: across it, the shorter way; zero of none."""
    bearing = np.zeros(assembly.count, dtype=bool)
    bearing[np.concatenate([joints.block_a, joints.block_b])] = True
    bearing &= assembly.fixed
    names = table.get("supports", "*")
    moving = select([names] if isinstance(names, str) else names, assembly, f"{where}.supports") & assembly.fixed
    if table["kind"] == "settlement" and moving[bearing].all():  # the structure goes down as a whole
        return 0.0
    on = np.flatnonzero((moving & bearing)[joints.block_a] | (moving & bearing)[joints.block_b])
    return max((_across(joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]]) for j in on), default=0.0)


def _across(polygon: np.ndarray) -> float:
    """Least width of a polygon (n, 3) in its plane [m]: between two lines along one of its sides."""
    sides = np.roll(polygon, -1, axis=0) - polygon
    normal = np.cross(sides[:-1], sides[1:]).sum(axis=0)
    across = np.cross(normal, sides)
    across = across[np.abs(across).max(axis=1) > 0.0]
    across /= np.sqrt((across * across).sum(axis=1))[:, None]
    return float(np.ptp(np.einsum("si,pi->sp", across, polygon), axis=1).min())


def _shaken(table: Mapping[str, Any], where: str, summary: Mapping[str, Any]) -> list[Doubt]:
    """The peak acceleration of a sine."""
    if table.get("kind") != "sinusoidal":
        return []
    pga, value = summary["after"]["pga"], float(table["amplitude"])
    return _doubt(f"{where}.amplitude", value, "sine", f"a PGA of {pga / G:.2g} g", abs(value) / pga) if pga else []
