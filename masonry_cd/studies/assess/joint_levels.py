# SPDX-License-Identifier: GPL-3.0-or-later
"""Levels of what only elastic joints have: their stiffness, their damping, the points over their depth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.scene import Scene
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.masonry_kinds import RIGID
from masonry_cd.studies.assess.levels import DAMPING, POINTS, STIFFNESS, Assumption, Change, LeftOut, Level, Tables, laws_of

STONE = {"least": 0.7e9, "mean": 1.5e9, "largest": 3.3e9}  # E [Pa]: of irregular stone to squared stone (Circolare 7/2019, table C8.5.I)
STAND_IN = "split stone"  # kind that gives G / E = 1/3, as all stone of that table; density stays that of the scene
OF_STIFFNESS = ("normal_stiffness", "tangential_stiffness")
OF_DAMPING = ("damping", "damping_frequency")
OF_SPRINGS = (*OF_STIFFNESS, *OF_DAMPING, "joint_points")
OVER_THE_DEPTH = {5: 0.9, 7: 0.95, 11: 1.1, 15: 1.2}  # joint points, and the cost of a run with them, times the default, about
GIGA = 1e9  # [Pa]
ELASTIC_COST = 1.5  # times a rigid run, about (church of 308 blocks)


def is_elastic(scene: Scene) -> bool:
    """Return True if some joint of the scene is elastic."""
    material = scene.material
    return material.joint_moduli is not None or any(law.normal_stiffness for law in material.joints.values())


def _remove_keys(tables: Tables, keys: tuple[str, ...]) -> None:
    """Take keys out of all laws."""
    for law in laws_of(tables):
        for key in keys:
            law.pop(key, None)


def _make_rigid(tables: Tables) -> None:
    """Rigid joints, without what springs have."""
    material = tables["material"]
    named = material.get("masonry")
    _remove_keys(tables, OF_SPRINGS if named is not None else (*OF_SPRINGS, "tension"))
    if named is not None:
        material["masonry"] = {**({"kind": named} if isinstance(named, str) else named), "stiffness": RIGID}


def _elastic(level: str, young: float | None) -> Change:
    """Joints as stiff as a level of the kind of masonry that is named, or as E says [Pa]."""

    def change(tables: Tables) -> None:
        material = tables["material"]
        _remove_keys(tables, OF_STIFFNESS)
        named = material.get("masonry")
        kind = {"kind": STAND_IN} if named is None else {"kind": named} if isinstance(named, str) else dict(named)
        kind.pop("E", None)
        kind.pop("G", None)
        material["masonry"] = kind | {"stiffness": level if young is None else "mean"} | ({} if young is None else {"E": young})

    return change


def stiffness(scene: Scene, asked: AssessTable) -> Assumption:
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
    base, moduli = base_stiffness(scene), scene.material.joint_moduli
    cost = ELASTIC_COST if base == RIGID else 1.0

    def between(u: float) -> Level:
        young = ends["least"] * (ends["largest"] / ends["least"]) ** u
        return Level(_modulus(young), _elastic("mean", young), cost)

    def rigid(tables: Tables) -> None:
        if moduli is not None and scene.material.stones:
            for law in laws_of(tables, "stones"):
                if "kind" not in law:  # which gives one
                    law.setdefault("young", moduli[0])
        _make_rigid(tables)

    levels = [Level(RIGID, rigid, 1.0 if base == RIGID else 1.0 / ELASTIC_COST)]
    for level in ("largest", "mean", "least"):
        change = _elastic(level, None if by_kind else ends[level])
        levels.append(Level(_modulus(ends[level]), change, cost))
    return Assumption(STIFFNESS, base, tuple(level for level in levels if level.name != base), between=between)


def base_stiffness(scene: Scene) -> str:
    """Describe the stiffness of its joints as the scene gives it."""
    given = sorted({law.normal_stiffness for law in scene.material.joints.values() if law.normal_stiffness})
    if given:
        return f"{given[0]:.3g}{f' to {given[-1]:.3g}' if len(given) > 1 else ''} N/m3"
    moduli = scene.material.joint_moduli
    return RIGID if moduli is None else _modulus(moduli[0])


def _modulus(young: float) -> str:
    """E in the unit of a range of it: ``E 0.7 GPa``."""
    return f"E {young / GIGA:.3g} GPa"


def damping(scene: Scene, asked: AssessTable, of_stiffness: Assumption) -> Assumption | LeftOut:
    """Shares of critical. Rigid joints do not vibrate: where the scene's are, all shares, 0 as well, are on joints of the mean E."""
    least, most = min(asked.damping, default=0.0), max(asked.damping, default=0.0)
    within = (lambda u: _damped(least + u * (most - least), None)) if most > least else None
    if not is_elastic(scene):
        mean = of_stiffness.levels[-2]
        levels = [_damped(share, mean) for share in sorted({0.0, *asked.damping})]
        if len(levels) < 2:
            return LeftOut(DAMPING, "no share above 0 is required")
        return Assumption(DAMPING, f"none: rigid; on {mean.name}", tuple(levels), reference=levels[0].name, between=within)
    given = {law.damping for law in scene.material.joints.values()} or {0.0}
    levels = [_damped(share, None) for share in asked.damping if given != {share}]
    if not levels:
        return LeftOut(DAMPING, "no other share is required")
    return Assumption(DAMPING, f"{100.0 * max(given):g} %", tuple(levels), between=within)


def _damped(share: float, on: Level | None) -> Level:
    """A share of critical damping in all laws that are elastic, of joints that another level makes elastic where one is given."""

    def change(tables: Tables) -> None:
        if on is not None:
            on.change(tables)
        if on is None or share > 0.0:
            _put_in_springs(tables["material"], "damping", share)

    return Level(f"{100.0 * share:.3g} %", change, 1.0 if on is None else on.cost)


def _put_in_springs(material: Tables, key: str, value: Any) -> None:
    """Give a key to all laws of elastic joints of a table [material]."""
    named = material.get("masonry")
    if not material.get("joints"):
        material["joints"] = {key: value}
        return
    for law in laws_of({"material": material}):
        if named is not None or law.get("normal_stiffness"):
            law[key] = value
    bonded = isinstance(named, Mapping) and named.get("shear_bond")  # a law of its own would bond the rest as well
    if named is not None and not bonded and all(isinstance(law, Mapping) for law in material["joints"].values()):
        material["joints"].setdefault("default", {key: value})


def points(scene: Scene) -> Assumption | LeftOut:
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
