# SPDX-License-Identifier: GPL-3.0-or-later
"""The assumptions of a scene and the levels to which each is set: other tables of the scene, everything else as it is.

joint stiffness   rigid; E the largest, the mean and the least of the masonry's kind, of stone in general where none is named
friction          20 % to either side, or the range that [assess] states
block size        times 0.7 and 1.4, where the kind of structure has a key for it
bond              straight joints, another seed, where the kind has a key for it
others            what a kind of structure says may be assumed of it, as of the fill of a bridge
soil              half and twice the shear modulus of each [[ground]], or its springs
damping           0, 2 and 5 % of critical, on elastic joints; where the scene's are rigid, all of them on joints of the mean E
joint points      over the depth of elastic joints that open: 5, 7, 11 and 15
time step         half of it
tolerance         a tenth of it
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import loads
from masonry_cd.analysis.assessment.assessment import Known
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.case import make_structures
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.settings import AUTO, LONGEST_STEP, RUNGS
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.masonry_kinds import RIGID
from structures.kind import StructureKind

Tables = dict[str, Any]
Change = Callable[[Tables], None]
Structures = list[tuple[StructureKind, Tables]]

STIFFNESS, FRICTION, SIZE, BOND, SOIL, DAMPING, POINTS, STEP, TOLERANCE = (
    "joint stiffness", "friction", "block size", "bond", "soil stiffness", "damping", "joint points", "time step", "tolerance",
)  # fmt: skip
NUMERICAL = (POINTS, STEP, TOLERANCE)  # no property of the structure: the answer should not depend on them
SMALLER, LARGER = 0.7, 1.4  # sizes of blocks
SOFTER, STIFFER = 0.5, 2.0  # shear moduli of the soil, which its strain and its survey leave as uncertain
ASIDE = 0.2  # share by which friction is varied
STONE = {"least": 0.7e9, "mean": 1.5e9, "largest": 3.3e9}  # E [Pa]: of irregular stone to squared stone (Circolare 7/2019, table C8.5.I)
STAND_IN = "split stone"  # kind that gives G / E = 1/3, as all stone of that table; density stays that of the scene
OF_STIFFNESS = ("normal_stiffness", "tangential_stiffness")
OF_DAMPING = ("damping", "damping_frequency")
OF_SPRINGS = (*OF_STIFFNESS, *OF_DAMPING, "joint_points")
OVER_THE_DEPTH = {5: 0.9, 7: 0.95, 11: 1.1, 15: 1.2}  # joint points, and the cost of a run with them, times the default, about
GIGA = 1e9  # [Pa]
TIGHTER_COST = 4.0  # of a tenth of the tolerance, times the base case, about (church of 308 blocks: 6)
ELASTIC_COST = 1.5  # times a rigid run, about (church of 308 blocks)


@dataclass(frozen=True)
class Level:
    """A level of an assumption."""

    name: str
    change: Change  # of the tables of the scene, in place
    cost: float = 1.0  # of a run, times that of the base case, about
    coarser: bool = False  # than the base case, of a setting of the computation: shown, but no measure of its error


@dataclass(frozen=True)
class Assumption:
    """An assumption, what the scene says of it, and its other levels."""

    name: str
    base: str
    levels: tuple[Level, ...]
    reference: str = ""  # of its levels, that which the others are compared with; empty: the base case
    statics: bool = False  # whether a limit analysis depends on it

    @property
    def known(self) -> Known:
        """Facts on it for an assessment."""
        levels, coarser = (tuple(one.name for one in self.levels if one.coarser or not only) for only in (False, True))
        return Known(self.name, self.base, levels, self.reference, self.name in NUMERICAL, coarser)


@dataclass(frozen=True)
class LeftOut:
    """An assumption that is not varied."""

    name: str
    why: str


def assumptions_of(scene: Scene, tables: Tables, shakes: bool) -> tuple[list[Assumption], list[LeftOut]]:
    """Return the assumptions of a scene that are varied, and those that are not.

    Args:
        scene: checked.
        tables: its tables, as numbers.
        shakes: whether it is run; else it is for limit analysis alone, of rigid blocks at rest.
    """
    asked = scene.assess
    stiffness = _stiffness(scene, asked)
    size, refused = _size(scene, tables)
    found: list[Assumption | LeftOut] = [stiffness, _friction(tables, asked), size, *_of_kinds(scene, tables)]
    found += [*_soil(scene), _damping(scene, asked, stiffness), _points(scene), _step(tables), _tolerance(scene)]
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


def is_elastic(scene: Scene) -> bool:
    """Return True if some joint of the scene is elastic."""
    material = scene.material
    return material.joint_moduli is not None or any(law.normal_stiffness for law in material.joints.values())


def _laws(tables: Tables) -> list[Tables]:
    """The laws of the joints in the tables, which may be changed; none where there are none."""
    joints = tables["material"].get("joints") or {}
    return list(joints.values()) if all(isinstance(law, Mapping) for law in joints.values()) else [joints]


def _without(tables: Tables, keys: tuple[str, ...]) -> None:
    """Take keys out of all laws."""
    for law in _laws(tables):
        for key in keys:
            law.pop(key, None)


def _rigid(tables: Tables) -> None:
    """Rigid joints, without what springs have."""
    material = tables["material"]
    named = material.get("masonry")
    _without(tables, OF_SPRINGS if named is not None else (*OF_SPRINGS, "tension"))
    if named is not None:
        material["masonry"] = {**({"kind": named} if isinstance(named, str) else named), "stiffness": RIGID}


def _elastic(level: str, young: float | None) -> Change:
    """Joints as stiff as a level of the kind of masonry that is named, or as E says [Pa]."""

    def change(tables: Tables) -> None:
        material = tables["material"]
        _without(tables, OF_STIFFNESS)
        named = material.get("masonry")
        kind = {"kind": STAND_IN} if named is None else {"kind": named} if isinstance(named, str) else dict(named)
        kind.pop("E", None)
        kind.pop("G", None)
        material["masonry"] = kind | {"stiffness": level if young is None else "mean"} | ({} if young is None else {"E": young})

    return change


def _stiffness(scene: Scene, asked: AssessTable) -> Assumption:
    """Rigid joints, and the ends and the mean of a range of E."""
    masonry = scene.material.masonry
    if asked.young is not None:
        ends: dict[str, float] = {"least": asked.young[0], "mean": 0.5 * sum(asked.young), "largest": asked.young[1]}
    elif masonry is not None:
        E = masonry.ranges()["E"]
        ends = {"least": E.least, "mean": E.mean, "largest": E.largest}
    else:
        ends = STONE
    by_kind = masonry is not None and asked.young is None
    base = _base_stiffness(scene)
    levels = [Level(RIGID, _rigid, 1.0 if base == RIGID else 1.0 / ELASTIC_COST)]
    for level in ("largest", "mean", "least"):
        change = _elastic(level, None if by_kind else ends[level])
        levels.append(Level(_modulus(ends[level]), change, ELASTIC_COST if base == RIGID else 1.0))
    return Assumption(STIFFNESS, base, tuple(level for level in levels if level.name != base))


def _base_stiffness(scene: Scene) -> str:
    """Describe the stiffness of its joints as the scene gives it."""
    given = sorted({law.normal_stiffness for law in scene.material.joints.values() if law.normal_stiffness})
    if given:
        return f"{given[0]:.3g}{f' to {given[-1]:.3g}' if len(given) > 1 else ''} N/m3"
    moduli = scene.material.joint_moduli
    return RIGID if moduli is None else _modulus(moduli[0])


def _modulus(young: float) -> str:
    """E in the unit of a range of it: ``E 0.7 GPa``."""
    return f"E {young / GIGA:.3g} GPa"


def _friction(tables: Tables, asked: AssessTable) -> Assumption:
    """Coefficients at both ends of their ranges."""
    given = tables["material"]["friction"]
    levels = []
    for end, factor in ((0, 1.0 - ASIDE), (1, 1.0 + ASIDE)):
        value = _at_end(given, asked.friction, end, factor)
        name = f"{value:.3g}" if not isinstance(value, Mapping) else f"x {factor:g}" if asked.friction is None else ("lower", "upper")[end]

        def change(tables: Tables, value: Any = value) -> None:
            tables["material"]["friction"] = value

        levels.append(Level(name, change))
    base = f"{given:.3g}" if not isinstance(given, Mapping) else "by pair of groups"
    return Assumption(FRICTION, base, tuple(levels), statics=True)


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
    every = _structures(scene, tables)
    if not any(kind.resized for kind, _ in every):
        return LeftOut(SIZE, f"{_kinds(tables)} has no key for the size of its blocks"), []
    for factor in (SMALLER, LARGER):
        level = Level(f"x {factor:g}", _put([kind.resized(table, factor) if kind.resized else None for kind, table in every]), factor**-2.5)
        why = _refusal(scene, tables, level) if factor == LARGER else ""
        if why:
            refused.append(LeftOut(f"{SIZE} {level.name}", why))
        else:
            levels.append(level)
    return Assumption(SIZE, "as given", tuple(levels), statics=True), refused


def _refusal(scene: Scene, tables: Tables, level: Level) -> str:
    """Return the reason why the structure of a level is refused; empty where it is not."""
    changed = copy.deepcopy(tables)
    level.change(changed)
    try:
        make_structures(replace(scene, structure=changed.get("structure", {}), structures=tuple(changed.get("structures", ()))))
    except InputError as error:
        return str(error.unsourced())
    return ""


def _of_kinds(scene: Scene, tables: Tables) -> Iterator[Assumption | LeftOut]:
    """Other bonds, and what else may be assumed of structures of these kinds; those of one kind together."""
    every = _structures(scene, tables)
    crossed = any((kind := loads.kind_of(load)) is not None and kind.places is not None for load in tables.get("loads") or ())
    yield _in_turn(BOND, every, [kind.bonds(table) for kind, table in every], f"{_kinds(tables)} has no key for its bond")
    for name in dict.fromkeys(name for kind, _ in every for name in kind.assumptions):
        found = [kind.assumptions[name](table, crossed) if name in kind.assumptions else {} for kind, table in every]
        why = next((one for one in found if isinstance(one, str)), "")
        yield _in_turn(name, every, [{} if isinstance(one, str) else one for one in found], why)


def _in_turn(name: str, every: Structures, found: list[Tables], why: str) -> Assumption | LeftOut:
    """An assumption whose levels are other keys of the structures, by their names; left out for a reason where there are none."""
    names = dict.fromkeys(level for one in found for level in one)
    made = {level: [table | one[level] if level in one else None for (_, table), one in zip(every, found, strict=True)] for level in names}
    levels = tuple(Level(level, _put(tables)) for level, tables in made.items())
    return Assumption(name, "as given", levels, statics=True) if levels else LeftOut(name, why)


def _structures(scene: Scene, tables: Tables) -> Structures:
    """The structures, one or several: the kind and the table of each."""
    from structures import kind_of

    return [(kind_of(str(table["kind"]), scene.folder), table) for table in _tables_of(tables)]


def _tables_of(tables: Tables) -> list[Tables]:
    return list(tables.get("structures") or [tables["structure"]])


def _kinds(tables: Tables) -> str:
    """The kinds of the structures, as text."""
    return "a structure of kind " + ", ".join(dict.fromkeys(f'"{table["kind"]}"' for table in _tables_of(tables)))


def _put(made: Sequence[Tables | None]) -> Change:
    """Puts structures into the place of those that they were made of; None leaves one as it is."""

    def change(tables: Tables) -> None:
        now = [copy.deepcopy(new) if new is not None else old for new, old in zip(made, _tables_of(tables), strict=True)]
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

        return Level(f"x {factor:g}", change)

    return [Assumption(SOIL, "as given", (scaled(SOFTER), scaled(STIFFER)))] if scene.ground else []


def _damping(scene: Scene, asked: AssessTable, stiffness: Assumption) -> Assumption | LeftOut:
    """Shares of critical. Rigid joints do not vibrate: where the scene's are, all shares, 0 as well, are on joints of the mean E."""
    if not is_elastic(scene):
        mean = stiffness.levels[-2]
        levels = [_damped(share, mean) for share in sorted({0.0, *asked.damping})]
        if len(levels) < 2:
            return LeftOut(DAMPING, "no share above 0 is asked for")
        return Assumption(DAMPING, f"none: rigid; on {mean.name}", tuple(levels), reference=levels[0].name)
    given = {law.damping for law in scene.material.joints.values()} or {0.0}
    levels = [_damped(share, None) for share in asked.damping if given != {share}]
    return Assumption(DAMPING, f"{100.0 * max(given):g} %", tuple(levels)) if levels else LeftOut(DAMPING, "no other share is asked for")


def _damped(share: float, on: Level | None) -> Level:
    """A share of critical damping in all laws that are elastic, of joints that another level makes elastic where one is given."""

    def change(tables: Tables) -> None:
        if on is not None:
            on.change(tables)
        if on is None or share > 0.0:
            _put_in_springs(tables["material"], "damping", share)

    return Level(f"{100.0 * share:g} %", change, 1.0 if on is None else on.cost)


def _put_in_springs(material: Tables, key: str, value: Any) -> None:
    """Give a key to all laws of elastic joints of a table [material]."""
    named = material.get("masonry")
    if not material.get("joints"):
        material["joints"] = {key: value}
        return
    for law in _laws({"material": material}):
        if named is not None or law.get("normal_stiffness"):
            law[key] = value
    bonded = isinstance(named, Mapping) and named.get("shear_bond")  # a law of its own would bond the rest as well
    if named is not None and not bonded and all(isinstance(law, Mapping) for law in material["joints"].values()):
        material["joints"].setdefault("default", {key: value})


def _points(scene: Scene) -> Assumption | LeftOut:
    """Points over the depth of elastic joints. Coarser levels than the scene's are made to be seen, and do not count against it."""
    if not is_elastic(scene):
        return LeftOut(POINTS, "rigid joints have their corners alone")
    material = scene.material
    laws = [law for law in material.joint_laws.values() if material.joint_moduli is not None or law.normal_stiffness] or [JointLaw()]
    given = sorted({law.points for law in laws})
    if given[0] >= max(OVER_THE_DEPTH):
        return LeftOut(POINTS, f"it has {given[0]}, the most there are")
    levels = [_pointed(points, cost, points < given[-1]) for points, cost in OVER_THE_DEPTH.items() if given != [points]]
    return Assumption(POINTS, f"{given[0]}{f' to {given[-1]}' if len(given) > 1 else ''}", tuple(levels))


def _pointed(points: int, cost: float, coarser: bool) -> Level:
    """All elastic joints with as many points."""

    def change(tables: Tables) -> None:
        _put_in_springs(tables["material"], "joint_points", points)

    return Level(str(points), change, cost, coarser)


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
