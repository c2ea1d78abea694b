# SPDX-License-Identifier: GPL-3.0-or-later
"""The assumptions of a scene and the levels to which each is set: other tables of the scene, everything else as it is.

joint stiffness   rigid; E the largest, the mean and the least of the masonry's kind, of stone in general where none is named; half and
                  twice that of joints whose bond softens
friction          20 % to either side, or the range that [assess] states
block size        times 0.7 and 1.4, where the kind of structure has a key for it
bond              straight joints, another seed, where the kind has a key for it
others            what a kind of structure says may be assumed of it, as of the fill of a bridge
bond energy       half and twice the fracture energies of bonds that soften, but no less than the springs of the joints store
stone strength    whole stones; times 0.7 and 1.4, of stones that crack, which stay as brittle
soil              half and twice the shear modulus of each [[ground]], or its springs
damping           0, 2 and 5 % of critical, on elastic joints; where the scene's are rigid, all of them on joints of the mean E
joint points      over the depth of elastic joints that open: 5, 7, 11 and 15
time step         half of it
tolerance         a tenth of it
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import loads
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.scene import Scene
from masonry_cd.mechanics.dynamics.settings import AUTO, LONGEST_STEP, RUNGS
from masonry_cd.studies.assess.breaking import bond_energy, softening_stiffness, softens, stone_strength
from masonry_cd.studies.assess.joint_levels import damping, points, stiffness
from masonry_cd.studies.assess.levels import (
    BOND,
    FRICTION,
    SIZE,
    SOIL,
    STEP,
    TOLERANCE,
    Assumption,
    Change,
    LeftOut,
    Level,
    Tables,
    refusal,
)
from structures.kind import StructureKind

Structures = list[tuple[StructureKind, Tables]]
Make = Callable[[StructureKind, Tables], Tables]
Found = Callable[[StructureKind, Tables], Tables | str]  # other keys of a structure by level, or why there are none

SMALLER, LARGER = 0.7, 1.4  # sizes of blocks
SOFTER, STIFFER = 0.5, 2.0  # shear moduli of the soil, which its strain and its survey leave as uncertain
ASIDE = 0.2  # share by which friction is varied
TIGHTER_COST = 4.0  # of a tenth of the tolerance, times the base case, about (church of 308 blocks: 6)


def assumptions_of(scene: Scene, tables: Tables, shakes: bool) -> tuple[list[Assumption], list[LeftOut]]:
    """Return the assumptions of a scene that are varied, and those that are not.

    Args:
        scene: checked.
        tables: its tables, as numbers.
        shakes: whether it is run; else it is for limit analysis alone, of rigid blocks at rest.
    """
    asked = scene.assess
    of_joints = stiffness(scene, asked)
    own = softening_stiffness(scene, tables) if softens(scene) else [of_joints]
    size, refused = _size(scene, tables)
    found: list[Assumption | LeftOut] = [*own, _friction(tables, asked), size, *_of_kinds(scene, tables)]
    found += [
        *bond_energy(scene, tables),
        *stone_strength(scene, tables),
        *_soil(scene),
        damping(scene, asked, of_joints),
        points(scene),
        _step(tables),
        _tolerance(scene),
    ]
    known, left = [], [] if SIZE in asked.leave_out else refused
    for one in found:
        why = "left out by the scene, assess.leave_out" if one.name in asked.leave_out else one.why if isinstance(one, LeftOut) else ""
        if not why and isinstance(one, Assumption) and not shakes and not one.statics:
            why = "limit analysis is of rigid blocks at rest"
        if why:
            left.append(LeftOut(one.name, why))
        elif isinstance(one, Assumption):
            known.append(one)
    return known, left


def _friction(tables: Tables, asked: AssessTable) -> Assumption:
    """Coefficients at both ends of their ranges."""
    given = tables["material"]["friction"]
    ends = [_at_end(given, asked.friction, end, factor) for end, factor in ((0, 1.0 - ASIDE), (1, 1.0 + ASIDE))]

    def level(name: str, value: Any) -> Level:
        def change(tables: Tables) -> None:
            tables["material"]["friction"] = value

        return Level(name if isinstance(value, Mapping) else f"{value:.3g}", change)

    def between(u: float) -> Level:
        low, high = ends
        if not isinstance(low, Mapping):
            return level("", low + u * (high - low))
        return level(f"{u:.2g} of its ranges", {pair: mu + u * (high[pair] - mu) for pair, mu in low.items()})

    names = ("lower", "upper") if asked.friction is not None else (f"x {1.0 - ASIDE:g}", f"x {1.0 + ASIDE:g}")
    levels = tuple(level(name, value) for name, value in zip(names, ends, strict=True))
    base = f"{given:.3g}" if not isinstance(given, Mapping) else "by pair of groups"
    return Assumption(FRICTION, base, levels, statics=True, between=between)


def _at_end(given: Any, ranges: Any, end: int, factor: float) -> Any:
    """Friction at an end of its range: a number, or numbers by pair of groups; a pair without a range stays as it is."""
    if ranges is None:
        return {pair: factor * mu for pair, mu in given.items()} if isinstance(given, Mapping) else factor * given
    if isinstance(ranges, Mapping):
        return {**(given if isinstance(given, Mapping) else {"default": given}), **{pair: ends[end] for pair, ends in ranges.items()}}
    return dict.fromkeys(given, ranges[end]) if isinstance(given, Mapping) else ranges[end]


def _size(scene: Scene, tables: Tables) -> tuple[Assumption | LeftOut, list[LeftOut]]:
    """Smaller and larger blocks, and what larger ones are refused for: openings and corners leave them no place."""
    levels: list[Level] = []
    refused: list[LeftOut] = []
    if not any(kind.resized for kind, _ in _structures(scene.folder, tables)):
        return LeftOut(SIZE, f"{_kinds(tables)} has no key for the size of its blocks"), []
    for factor in (SMALLER, LARGER):

        def resized(kind: StructureKind, table: Tables, factor: float = factor) -> Tables:
            return table if kind.resized is None else kind.resized(table, factor)

        level = Level(f"x {factor:g}", _put(scene.folder, resized), factor**-2.5)
        why = refusal(scene, tables, level) if factor == LARGER else ""
        if why:
            refused.append(LeftOut(f"{SIZE} {level.name}", why))
        else:
            levels.append(level)
    return Assumption(SIZE, "as given", tuple(levels), statics=True), refused


def _of_kinds(scene: Scene, tables: Tables) -> Iterator[Assumption | LeftOut]:
    """Other bonds, and what else may be assumed of structures of these kinds; those of one kind together."""
    every = _structures(scene.folder, tables)
    crossed = any((kind := loads.kind_of(load)) is not None and kind.places is not None for load in tables.get("loads") or ())
    yield _in_turn(BOND, scene.folder, every, lambda kind, table: kind.bonds(table), f"{_kinds(tables)} has no key for its bond")
    for name in dict.fromkeys(name for kind, _ in every for name in kind.assumptions):

        def found(kind: StructureKind, table: Tables, name: str = name) -> Tables | str:
            return kind.assumptions[name](table, crossed) if name in kind.assumptions else {}

        yield _in_turn(name, scene.folder, every, found)


def _in_turn(name: str, folder: Path, every: Structures, found: Found, none: str = "") -> Assumption | LeftOut:
    """An assumption whose levels are other keys of the structures, by their names; left out for a reason where there are none."""
    there = [found(kind, table) for kind, table in every]
    names = dict.fromkeys(level for one in there if not isinstance(one, str) for level in one)

    def level(chosen: str) -> Level:
        def put(kind: StructureKind, table: Tables) -> Tables:
            keys = found(kind, table)
            return table if isinstance(keys, str) else table | keys.get(chosen, {})

        return Level(chosen, _put(folder, put))

    why = next((one for one in there if isinstance(one, str)), none)
    return Assumption(name, "as given", tuple(level(one) for one in names), statics=True) if names else LeftOut(name, why)


def _structures(folder: Path, tables: Tables) -> Structures:
    """The structures, one or several: the kind and the table of each."""
    from structures import kind_of

    return [(kind_of(str(table["kind"]), folder), table) for table in _tables_of(tables)]


def _tables_of(tables: Tables) -> list[Tables]:
    return list(tables.get("structures") or [tables["structure"]])


def _kinds(tables: Tables) -> str:
    """The kinds of the structures, as text."""
    return "a structure of kind " + ", ".join(dict.fromkeys(f'"{table["kind"]}"' for table in _tables_of(tables)))


def _put(folder: Path, make: Make) -> Change:
    """Puts in the place of each structure what is made of it as it then is, so that several changes may follow each other."""

    def change(tables: Tables) -> None:
        now = [make(kind, copy.deepcopy(table)) for kind, table in _structures(folder, tables)]
        if tables.get("structures"):
            tables["structures"] = now
        else:
            tables["structure"] = now[0]

    return change


def _soil(scene: Scene) -> list[Assumption]:
    """Softer and stiffer soil below footings; none where supports do not stand on ground."""

    def scaled(factor: float) -> Level:
        def change(tables: Tables) -> None:
            for ground in tables["ground"]:
                for key in {"shear_modulus", "shear_wave_velocity"} & ground.keys():
                    ground[key] *= factor if key == "shear_modulus" else factor**0.5
                ground["stiffness"] = {way: factor * value for way, value in ground.get("stiffness", {}).items()}

        return Level(f"x {factor:.3g}", change)

    def between(u: float) -> Level:
        return scaled(SOFTER * (STIFFER / SOFTER) ** u)

    return [Assumption(SOIL, "as given", (scaled(SOFTER), scaled(STIFFER)), between=between)] if scene.ground else []


def _step(tables: Tables) -> Assumption:
    """Half the time step, or all of an adaptive one's halved."""
    run = tables["run"]
    if run.get("dt") != AUTO:
        half = 0.5 * run["dt"]

        def change(tables: Tables) -> None:
            tables["run"]["dt"] = half

        return Assumption(STEP, _time(run["dt"]), (Level(_time(half), change, 2.0),))
    longest = run.get("dt_max", LONGEST_STEP)
    shortest = run.get("dt_min", longest * 2.0**-RUNGS)

    def halve(tables: Tables) -> None:
        tables["run"] |= {"dt_max": 0.5 * longest, "dt_min": 0.5 * shortest}

    return Assumption(STEP, f"up to {_time(longest)}", (Level(f"up to {_time(0.5 * longest)}", halve, 2.0),))


def _tolerance(scene: Scene) -> Assumption:
    """A tenth of the tolerance."""
    now = scene.run.tolerance

    def change(tables: Tables) -> None:
        tables["run"]["tolerance"] = 0.1 * now

    return Assumption(TOLERANCE, f"{now:.3g}", (Level(f"{0.1 * now:.3g}", change, TIGHTER_COST),))


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.4g} ms"
