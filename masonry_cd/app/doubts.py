"""Values of a scene that are likely in another unit: a line each, and never a refusal.

The line names the key, its value and what that means, and the unit in which it would be usual; the key of a scene ``quiet_checks`` lists
keys whose values are meant so. The ranges, and why they are such, are in :mod:`masonry_cd.app.ranges`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np

from loads.kinds.forces import one_block
from masonry_cd.app.ranges import PLAIN, RANGES, G
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import is_within, keys_of, parse_toml
from masonry_cd.app.scene_units import scene_in_si
from masonry_cd.foundation.fields import is_number
from masonry_cd.mechanics.model.blocks import Block

if TYPE_CHECKING:
    from masonry_cd.mechanics.model.blocks import Assembly

PEAK = 1.875  # largest speed of the pulse of a settlement over its mean
Doubt = tuple[str, str]  # key and line


def structure_doubts(scene: Scene) -> list[str]:
    """What ``masonry-cd build`` says: of the tables [structure] and [material]."""
    tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    mine: dict[str, Any] = {key: tables[key] for key in ("structure", "structures", "material") if key in tables}
    return _spoken([*_plain(mine), *_ties(mine)], scene.quiet_checks)


def doubts(scene: Scene, assembly: Assembly, summaries: Sequence[Mapping[str, Any]] = ()) -> list[str]:
    """A line for each doubtful value of a scene.

    Args:
        scene: a checked one.
        assembly: its blocks.
        summaries: of its loads as they are built, where they are; a limit analysis builds none.
    """
    tables = scene_in_si(parse_toml(scene.text, scene.origin.path))
    size = math.hypot(*scene.run.gravity)
    found = [*_plain(tables), *_ties(tables), *_doubt("run.gravity", size, "gravity", f"{size / G:.3g} g")]
    for i, table in enumerate(tables.get("loads", [])):
        where, kind = f"loads[{i}]", table.get("kind")
        if kind == "point":
            found += _point(table, where, assembly, size)
        elif kind in ("settlement", "spreading"):
            found += _moved(table, where, assembly.blocks)
        elif i < len(summaries):
            found += _shaken(table, where, summaries[i])
    return _spoken(found, scene.quiet_checks)


def _spoken(found: Sequence[Doubt], quiet: Sequence[str]) -> list[str]:
    """The lines but for those of keys that are meant so."""
    return [line for key, line in found if not any(is_within(key, name) for name in quiet)]


def _doubt(key: str, value: float, name: str, means: str = "", per: float = 1.0) -> list[Doubt]:
    """The line on a value that is not usual.

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
    unit = f" {usual.unit}" if usual.unit else ""
    other = next(((word, size) for word, size in usual.others if usual.holds(value * size / per)), None)
    meant = f"; if {value:g} {other[0]} is meant, write {value * other[1]:.4g}" if other else ""
    said = f"{key} = {value:g}{unit}{f' is {means}' if means else ''}: {usual.reason}{meant}"
    return [(key, f'{said}; if it is meant so, quiet_checks = ["{key}"] says so')]


def _plain(tables: Mapping[str, Any]) -> list[Doubt]:
    """Values that are compared by themselves."""
    found: list[Doubt] = []
    for key, value in keys_of(tables):
        if not is_number(value):
            continue
        path = re.sub(r"\[\d+\]", "", key).replace("structures.", "structure.", 1)
        name = next((name for pattern, name in PLAIN.items() if fnmatchcase(path, pattern)), None)
        if name is not None:
            means = f"{float(value) / G:.3g} g" if RANGES[name].unit == "m/s2" else ""
            found += _doubt(key, float(value), name, means)
    return found


def _point(table: Mapping[str, Any], where: str, assembly: Assembly, gravity: float) -> list[Doubt]:
    """A point load against the weight and the section of its block."""
    block, size = one_block(table["block"], assembly, f"{where}.block"), math.hypot(*table["force"])
    weight, section = float(assembly.mass[block]) * gravity, float(assembly.volume[block]) ** (2.0 / 3.0)
    light = _doubt(f"{where}.force", size, "force", f"{size / weight:.2g} times the weight of its block" if weight else "", weight)
    return light or _doubt(f"{where}.force", size, "pressure", f"{size / section / 1e6:.3g} MPa on its block", section)


def _ties(tables: Mapping[str, Any]) -> list[Doubt]:
    """What ties pull at the start and where they yield, by how far that stretches them."""
    one = [("structure", tables.get("structure", {}))]
    places = [*one, *((f"structures[{i}]", table) for i, table in enumerate(tables.get("structures", [])))]
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


def _moved(table: Mapping[str, Any], where: str, blocks: Sequence[Block]) -> list[Doubt]:
    """A settlement against the size of the structure, and by its speed."""
    corners = np.concatenate([block.vertices for block in blocks if not block.fixed] or [block.vertices for block in blocks])
    extent, key, value = np.ptp(corners, axis=0), f"{where}.displacement", float(table["displacement"])
    speed = PEAK * abs(value) / table["duration"]
    size, what = (float(extent[2]), "height") if table["kind"] == "settlement" else (float(extent.max()), "largest extent")
    means = f"{abs(value) / size:.2g} times the {what} of the structure, at up to {speed:.2g} m/s"
    return _doubt(key, value, table["kind"], means, size) or _doubt(key, value, "speed", means, float(table["duration"]) / PEAK)


def _shaken(table: Mapping[str, Any], where: str, summary: Mapping[str, Any]) -> list[Doubt]:
    """The peak acceleration of a sine, of a record and of the components of a sequence."""
    if table.get("kind") == "sinusoidal":
        pga, value = summary["after"]["pga"], float(table["amplitude"])
        return _doubt(f"{where}.amplitude", value, "sine", f"a PGA of {pga / G:.2g} g", abs(value) / pga) if pga else []
    shocks = table.get("shocks", [])
    if shocks:
        made = zip(shocks, summary["shocks"], strict=True)
        return [doubt for i, (shock, one) in enumerate(made) for doubt in _recorded(shock, f"{where}.shocks[{i}]", one["components"])]
    return _recorded(table, where, [summary]) if table.get("kind") == "record" else []


def _recorded(table: Mapping[str, Any], where: str, made: Sequence[Mapping[str, Any]]) -> list[Doubt]:
    """The peak acceleration that a record has come to; one that is asked for is looked at by itself."""
    if "target_pga" in table:
        return []
    pga = max(one["after"]["pga"] for one in made)
    key = next((name for name in ("scale", "units", "path") if name in table), "components")  # of which a shock has several
    given = f" = {table[key]:g}" if key == "scale" else ""
    line = unusual_pga(pga, f"{where}.{key}{given} makes a")
    return [(f"{where}.{key}", f'{line}; if it is meant so, quiet_checks = ["{where}.{key}"] says so')] if line else []


def unusual_pga(pga: float, what: str) -> str:
    """A line on the peak acceleration [m/s2] that a record has, which begins with ``what`` has it; empty where it is usual."""
    usual = RANGES["scaled"]
    return "" if usual.holds(pga) else f"{what} PGA of {pga:.3g} m/s2 ({pga / G:.3g} g): {usual.reason}"
