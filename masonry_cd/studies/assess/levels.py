# SPDX-License-Identifier: GPL-3.0-or-later
"""What may be assumed of a scene: levels, each by itself, and where it has one the range that they lie in, for all at once."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from masonry_cd.analysis.assessment.assessment import KnownAssumption
from masonry_cd.analysis.assessment.indices import Unknown, chosen
from masonry_cd.app.case import assembled, make_structures
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.materials import Material

Tables = dict[str, Any]
Change = Callable[[Tables], None]

STIFFNESS, FRICTION, SIZE, BOND, ENERGY, STONES = "joint stiffness", "friction", "block size", "bond", "bond energy", "stone strength"
SOIL, DAMPING, POINTS, STEP, TOLERANCE = "soil stiffness", "damping", "joint points", "time step", "tolerance"
NUMERICAL = (POINTS, STEP, TOLERANCE)  # no property of the structure: the answer should not depend on them


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
    between: Callable[[float], Level] | None = (
        None  # over its range, by a share of it; without one, what the scene says and the levels are choices
    )

    @property
    def known(self) -> KnownAssumption:
        """Facts on it for an assessment."""
        levels, coarser = (tuple(one.name for one in self.levels if one.coarser or not only) for only in (False, True))
        return KnownAssumption(self.name, self.base, levels, self.reference, self.name in NUMERICAL, coarser)

    @property
    def unknown(self) -> Unknown:
        """Facts on it where all vary at once."""
        if self.between is not None:
            return Unknown(self.name, f"{self.between(0.0).name} to {self.between(1.0).name}")
        choices = (self.base, *(one.name for one in self.levels))
        return Unknown(self.name, ", ".join(choices), choices)

    def at(self, u: float) -> Level:
        """The level at a coordinate of the unit cube."""
        if self.between is not None:
            return self.between(u)
        choices = (Level(self.base, lambda _: None), *self.levels)
        return choices[chosen(u, len(choices))]


@dataclass(frozen=True)
class LeftOut:
    """An assumption that is not varied."""

    name: str
    why: str


def laws_of(tables: Tables, key: str = "joints") -> list[Tables]:
    """The laws of the joints, or the stones, in the tables, which may be changed; none where there are none."""
    laws = tables["material"].get(key) or {}
    return list(laws.values()) if all(isinstance(law, Mapping) for law in laws.values()) else [laws]


def refusal(scene: Scene, tables: Tables, level: Level) -> str:
    """Return the reason why the structure of a level, or its material, is refused; empty where it is not."""
    changed = copy.deepcopy(tables)
    level.change(changed)
    try:
        material = parse_table(Material, changed["material"], "material")
        structures = tuple(changed.get("structures", ()))
        other = replace(scene, structure=changed.get("structure", {}), structures=structures, material=material)
        made = make_structures(other)
        if material != scene.material:
            assembled(other, made.blocks, (), made.ties)
    except InputError as error:
        return str(error.unsourced())
    return ""
