# SPDX-License-Identifier: GPL-3.0-or-later
"""The material: density, coefficients of friction and joint laws by pair of groups of blocks, in a scene's table and as arrays.

A scene gives one value for all joints, or values by pair of groups, ``arch-base``, with ``default`` for the rest. Either group of a pair
may be a pattern, ``*arch-*base``; a pair by name holds before one by patterns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field, ValidationInfo, WithJsonSchema, field_validator, model_validator

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Number, Table, is_number
from masonry_cd.foundation.table_schema import one_or_by_name
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.by_group import ANY, members
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.masonry_kinds import RIGID, Masonry, MasonryKey
from masonry_cd.mechanics.model.strength import KEY, Strength

Value = TypeVar("Value")
LIGHTEST, HEAVIEST = 0.1, 1e6  # density [kg/m3], what numbers bear; what masonry has is in masonry_cd/app/ranges.py
ROUGHEST = 20  # coefficient of friction: beyond, an angle was meant
_COEFFICIENT = {"type": "number", "minimum": 0, "maximum": ROUGHEST}
_FRICTION: dict[str, Any] = {"anyOf": [_COEFFICIENT, {"type": "object", "minProperties": 1, "additionalProperties": _COEFFICIENT}]}
NO_SHARE = "an arm over a radius should be a number between 0 and 1"
_SHARE = {"type": "number", "minimum": 0, "maximum": 1}
_ROLLING: dict[str, Any] = {"anyOf": [_SHARE, {"type": "object", "minProperties": 1, "additionalProperties": _SHARE}]}
TABLES = 9  # of JointLaws
JOINT_POINTS = 9  # over the depth: the moment of an open joint is right to 1.9 %
CRUSHING_POINTS = 11  # of a joint that crushes: its moment is right to 1.6 %
Stiffness = Annotated[Number, Unit("N/m3"), Field(ge=1.0, le=1e20)]  # on 1 Pa such joints shorten by a metre, and by less than rounding


class JointLaw(Table):
    """The law of a joint, a table ``[material.joints]`` or ``[material.joints.arch-base]``."""

    normal_stiffness: Stiffness | None = None
    """Elastic force per area and shortening; that of the masonry when not given, and without masonry rigid."""
    tangential_stiffness: Stiffness | None = None
    """Elastic force per area and slip; the normal one over 2.4, as of a material with Poisson's ratio 0.2, when not given."""
    cohesion: Annotated[Number, Unit("Pa"), Field(ge=0)] = 0.0
    """Shear strength without compression, of a joint that has not broken yet."""
    tension: Annotated[Number, Unit("Pa"), Field(ge=0)] | None = None
    """Tensile strength of a joint that has not broken yet; when not given, cohesion / friction, where Mohr-Coulomb's line ends."""
    compressive_strength: Annotated[Number, Unit("Pa"), Field(gt=0)] | None = None
    """Pressure at which the joint crushes; that of the masonry where ``masonry.crushing`` asks for it, else it never does. In a run the
    joint is to be elastic, and stays as much shorter as it was crushed."""
    joint_points: Annotated[int, Field(ge=3, le=15, json_schema_extra={"not": {"multipleOf": 2}})] | None = None
    """Contact points over the depth of an elastic joint that opens: 9 when not given, 11 beside a compressive strength, 3, its corners and
    centroid alone, or another odd number up to 15. A closed joint has the same force and moments with any number; an open one is up to
    1.9 % too strong with 9, 3.3 % with 7, 37 % with 3, which take up to a third less time."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.6
    """Of the spring over the time step: 0.5 does not damp; above, a mode of frequency f is damped by (2 theta - 1) pi f dt."""
    damping: Annotated[Number, Field(ge=0, le=10)] = 0.0
    """Of a dashpot beside the spring, as a share of the critical damping of a vibration at the first elastic period of the structure, or of
    ``damping_frequency`` where that is given; proportional to the frequency of others."""
    damping_frequency: Annotated[Number, Unit("Hz"), Field(gt=0, le=1e6)] | None = None
    """At which ``damping`` holds; that of the first mode of the blocks on their elastic joints when not given."""

    @model_validator(mode="after")
    def _damps_at_a_frequency(self, info: ValidationInfo) -> JointLaw:
        if self.damping_frequency is not None and "damping" not in self.model_fields_set:  # damping = 0 says none, as a study may
            raise ValueError("damping_frequency needs damping beside it: the share of critical that it is at that frequency")
        if self.damping > 0.0 and self.normal_stiffness is None and not _of_masonry(info):
            raise ValueError("damping needs normal_stiffness beside it: a rigid joint does not vibrate")
        return self

    @model_validator(mode="after")
    def _both_stiffnesses_or_none(self, info: ValidationInfo) -> JointLaw:
        if self.tangential_stiffness is not None and self.normal_stiffness is None:
            raise ValueError("tangential_stiffness needs normal_stiffness beside it")
        if self.tension is not None and self.normal_stiffness is None and not _of_masonry(info):
            raise ValueError(
                "tension needs normal_stiffness: how a rigid joint spreads its stress is not unique, it parts at cohesion / friction"
            )
        return self

    @field_validator("joint_points")
    @classmethod
    def _points_in_pairs(cls, value: int | None) -> int | None:
        if value is not None and value % 2 == 0:
            raise ValueError(f"should be odd: the centroid, and pairs on both sides of it; {value - 1} or {value + 1}")
        return value

    @model_validator(mode="after")
    def _opens_as_springs(self, info: ValidationInfo) -> JointLaw:
        if self.joint_points is not None and self.normal_stiffness is None and not _of_masonry(info):
            raise ValueError("joint_points needs normal_stiffness beside it: a rigid joint has its corners")
        return self

    @property
    def stiffness(self) -> tuple[float, float]:
        """Normal and tangential [N/m3]; zeros stand for none of its own."""
        normal = self.normal_stiffness or 0.0
        return normal, self.tangential_stiffness or normal / 2.4

    @property
    def points(self) -> int:
        """Over the depth, where the joint is elastic and opens."""
        return self.joint_points or (CRUSHING_POINTS if self.compressive_strength else JOINT_POINTS)

    @property
    def retardation(self) -> float:
        """Of the dashpot, its coefficient over the stiffness [s]: 2 damping / omega, as Rayleigh's stiffness-proportional damping; zero as
        long as the frequency is not known."""
        return 0.0 if self.damping_frequency is None else self.damping / (math.pi * self.damping_frequency)


def _of_masonry(info: ValidationInfo) -> bool:
    """Whether the law is read beside a kind of masonry, which makes its joint elastic."""
    return bool(info.data) and info.data.get("masonry") is not None


class Material(ElasticBlocks):
    """The table ``[material]``."""

    masonry: MasonryKey = None
    """Kind of existing masonry, which gives density, stiffness of the joints, and strength where stress is reported, by tables C8.5.I and
    C8.5.II of Circolare 7/2019: its name, or a table. Other keys of [material] and [material.joints] win."""
    density: Annotated[Number, Unit("kg/m3"), WithJsonSchema({"type": "number", "minimum": LIGHTEST, "maximum": HEAVIEST})] | None = None
    """Of every block that brings none of its own; that of the masonry when not given; a block file whose blocks all state theirs needs
    none."""
    friction: Annotated[Number | dict[str, Number], WithJsonSchema(_FRICTION)]
    """Coefficient of friction: one value, or values by pair of groups, ``friction.arch-base = 0.7``, and ``default``."""
    rolling_friction: Annotated[Number | dict[str, Number], WithJsonSchema(_ROLLING)] = 0.0
    """Of spheres: the arm of the moment that resists rolling, over the radius R, or over R_a R_b / (R_a + R_b) of two spheres; one value,
    or values by pair of groups, as friction. Pairs without a value roll freely."""
    compressive_strength: Strength = None
    """Of the blocks, with which reports compare their stress: one value, or values by group, ``compressive_strength.arch = 5e6``,
    which may be patterns, and ``default``. Nothing crushes by it: ``joints.compressive_strength`` is where joints do."""
    joints: Annotated[dict[str, JointLaw], Field(json_schema_extra=one_or_by_name(JointLaw))] = Field(default_factory=dict)
    """Laws of the joints by pair of groups, ``[material.joints.arch-base]``, and ``default``, which plain keys stand for. A joint
    without a law is dry, and rigid where no masonry is named."""

    @field_validator("density")
    @classmethod
    def _density_in_kg_per_m3(cls, value: float | None) -> float | None:
        if value is not None and not LIGHTEST <= value <= HEAVIEST:
            raise ValueError(f"should be between {LIGHTEST:g} and {HEAVIEST:g} kg/m3")
        return value

    @field_validator("joints", mode="before")
    @classmethod
    def _laws(cls, value: Any) -> Any:
        """One law for all joints is the default of the pairs."""
        if not isinstance(value, Mapping):
            raise ValueError("should be a table: keys of one law, or tables by pair of groups")
        plain = [key for key, law in value.items() if not isinstance(law, Mapping | JointLaw)]
        if plain and len(plain) < len(value):
            raise ValueError(f'holds keys of one law ("{plain[0]}") and tables by pair; put the keys under [material.joints.default]')
        return {"default": value} if plain else value

    @model_validator(mode="after")
    def _tension_is_stated(self) -> Material:
        """The tables of masonry have no tensile strength: cohesion over friction would be invented."""
        bonded = self.masonry is not None and self.masonry.shear_bond
        if bonded and any(law.tension is None and not law.cohesion for law in (self.joints or {"default": JointLaw()}).values()):
            raise ValueError("masonry.shear_bond needs joints.tension beside it: the tensile strength of the bond [Pa], 0 for none")
        return self

    @property
    def block_density(self) -> float | None:
        """Density of every block that brings none of its own [kg/m3]; None: all have to."""
        return self.density if self.density is not None or self.masonry is None else self.masonry.mean_density

    @property
    def strength(self) -> float | dict[str, float] | None:
        """Compressive strength of the blocks, where it is known [Pa]."""
        return self.compressive_strength if self.compressive_strength is not None or self.masonry is None else self.masonry.strength

    @property
    def joint_laws(self) -> dict[str, JointLaw]:
        """The laws of the joints, with the bond and the compressive strength that masonry gives them."""
        if self.masonry is None or not (self.masonry.cohesion or self.masonry.crushing):
            return self.joints
        strength = self.masonry.strength if self.masonry.crushing else None
        given = {"cohesion": self.masonry.cohesion, "compressive_strength": strength}
        laws = {pair: law.model_copy(update={k: v for k, v in given.items() if not getattr(law, k)}) for pair, law in self.joints.items()}
        return laws if strength is None else {"default": JointLaw(compressive_strength=strength), **laws}

    @property
    def joint_moduli(self) -> tuple[float, float] | None:
        """E and G of the masonry that joints without a stiffness of their own follow [Pa]; None: they are rigid."""
        return None if self.masonry is None else self.masonry.moduli

    @property
    def with_rigid_joints(self) -> Material:
        """The material with joints that are rigid but where they have a stiffness of their own; bonds and strengths stay."""
        rigid = None if self.masonry is None else self.masonry.model_copy(update={"stiffness": RIGID})
        return self.model_copy(update={"masonry": rigid})

    @field_validator("rolling_friction", mode="before")
    @classmethod
    def _shares(cls, value: Any) -> Any:
        return _numbers_by_pair(value, lambda share, _: "" if _is_number(share) and 0 <= share <= 1 else NO_SHARE)

    @field_validator("friction", mode="before")
    @classmethod
    def _coefficients(cls, value: Any) -> Any:
        return _numbers_by_pair(value, _no_coefficient)


def given_strength(table: Mapping[str, Any]) -> Any:
    """Compressive strength that a table [material] gives, as its key or by its masonry [Pa]; None: neither does."""
    masonry = table.get("masonry")
    if KEY in table or masonry is None:
        return table.get(KEY)
    return Masonry.model_validate({"kind": masonry} if isinstance(masonry, str) else masonry).strength


def _numbers_by_pair(value: Any, wrong: Callable[[Any, str], str]) -> float | dict[str, float]:
    """One number, or numbers by pair of groups; ``wrong`` says of a number, and its pair or "", what is wrong with it, or nothing."""
    pairs = value if isinstance(value, Mapping) else {"": value}
    if not pairs:
        raise ValueError("gives no value")
    for pair, number in pairs.items():
        if said := wrong(number, pair):
            raise ValueError(f'"{pair}": {said}' if pair else said)
    return {pair: float(number) for pair, number in pairs.items()} if isinstance(value, Mapping) else float(value)


def _no_coefficient(mu: Any, pair: str) -> str:
    """What is wrong with a coefficient of friction, or nothing."""
    if not _is_number(mu):
        return "should be a number"
    if not 0 <= mu <= ROUGHEST:
        return f"a coefficient of friction (no angle) should be between 0 and {ROUGHEST}" + (f", got {mu:g}" if pair else "")
    return ""


def _is_number(value: Any) -> bool:
    """Whether a value is a number, infinite ones and NaN among them."""
    return is_number(value) or isinstance(value, float)


@dataclass(frozen=True, eq=False)
class JointLaws:
    """The joint laws between G groups, (G, G) symmetric tables; zeros: rigid and dry."""

    normal_stiffness: np.ndarray  # [N/m3]; 0: by the moduli, or else rigid
    tangential_stiffness: np.ndarray  # [N/m3]
    tension: np.ndarray  # tensile strength [Pa]
    apex: np.ndarray  # tension at the tip of the Mohr-Coulomb cone, cohesion / mu [Pa]; 0: no bond
    theta: np.ndarray  # of the spring over the step, 1/2 to 1
    retardation: np.ndarray  # coefficient of the dashpot over the stiffness [s]
    at_first_period: np.ndarray  # share of critical of dashpots whose retardation follows from the first elastic period; 0 elsewhere
    crushing: np.ndarray  # compressive strength [Pa]; 0: never crushes
    points: np.ndarray  # over the depth, of elastic joints that open; odd
    moduli: tuple[float, float] | None = None  # E and G of the masonry, whose joints are as stiff as joint_stiffness.py has it [Pa]

    @property
    def elastic(self) -> np.ndarray:
        """(G, G) bool: joints that are not rigid."""
        return (self.normal_stiffness > 0.0) | (self.moduli is not None)

    @property
    def by_area(self) -> np.ndarray:
        """(G, G) bool: joints whose law goes by area, elastic ones and bonded ones."""
        return self.elastic | (self.apex > 0.0)

    def damped_at(self, frequency: float) -> JointLaws:
        """The laws where the first elastic frequency is known [Hz]."""
        beta = self.at_first_period / (math.pi * frequency)
        return replace(self, retardation=np.where(self.at_first_period > 0.0, beta, self.retardation))


def friction_table(friction: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """Return the (G, G) symmetric table of friction coefficients between groups.

    Raises:
        InputError: an unknown group, a negative value, or a pair left without a value.
    """
    table = np.full((len(groups), len(groups)), np.nan)
    pairs = friction if isinstance(friction, Mapping) else {"default": friction}
    for i, j, value in _by_pair(pairs, groups, "material.friction"):
        table[i, j] = value
    if np.isnan(table).any():
        i, j = np.argwhere(np.isnan(table))[0]
        raise InputError("material.friction", f"no value for {groups[i]}-{groups[j]}; add it or a default")
    if (table < 0).any():
        raise InputError("material.friction", f"a coefficient must not be negative, got {table.min():g}")
    return table


def rolling_table(rolling: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """Return the (G, G) symmetric table of rolling friction between groups, zero of pairs without a value.

    Raises:
        InputError: an unknown group.
    """
    table = np.zeros((len(groups), len(groups)))
    for i, j, value in _by_pair(rolling if isinstance(rolling, Mapping) else {"default": rolling}, groups, "material.rolling_friction"):
        table[i, j] = value
    return table


def joint_table(
    laws: Mapping[str, JointLaw], groups: Sequence[str], friction: np.ndarray, moduli: tuple[float, float] | None = None
) -> JointLaws:
    """The joint laws between groups; a pair without an entry is dry, and rigid where no moduli are given.

    Args:
        laws: by pair of groups ``"arch-base"``, with ``"default"`` for the rest.
        groups: G names.
        friction: (G, G) coefficients, which with the cohesion fix the tip of the cone.
        moduli: E and G of the masonry [Pa], by which joints without a stiffness of their own are elastic.

    Raises:
        InputError: an unknown group, cohesion without friction, or a tensile strength beyond the tip of the cone.
    """
    out = replace(JointLaws(*np.zeros((TABLES, len(groups), len(groups)))), moduli=moduli)
    laws = laws if moduli is None else {"default": JointLaw(), **laws}
    for i, j, law in _by_pair(laws, groups, "material.joints"):
        out.normal_stiffness[i, j], out.tangential_stiffness[i, j] = law.stiffness
        out.apex[i, j] = _apex(law, float(friction[i, j]), f"{groups[i]}-{groups[j]}")
        out.tension[i, j] = out.apex[i, j] if law.tension is None else law.tension
        out.theta[i, j], out.retardation[i, j] = law.theta, law.retardation
        out.at_first_period[i, j] = law.damping if law.damping_frequency is None else 0.0
        out.crushing[i, j] = law.compressive_strength or 0.0
        out.points[i, j] = law.points
    return out


def refuse_unfelt_laws(laws: Mapping[str, JointLaw], groups: Sequence[str], felt: np.ndarray) -> None:
    """Refuse laws that no joint can have; ``felt`` (G, G): whether blocks of two groups can touch with faces.

    Raises:
        InputError: a pair, or pattern, all of whose joints are with spheres.
    """
    for pair, law in laws.items():
        if not any(felt[i, j] for i, j, _ in _by_pair({pair: law}, groups, "material.joints")):
            raise InputError(
                f"material.joints.{pair}", "spheres touch in points, without springs and bonds, and no other joint has this law"
            )


def _apex(law: JointLaw, mu: float, pair: str) -> float:
    """Tension at the tip of the cone [Pa]: where the line of Mohr-Coulomb, mu p + c, comes to zero."""
    if mu == 0.0 and law.cohesion > 0.0:
        raise InputError("material.joints", f"the joint {pair} has cohesion but no friction; give it a coefficient of friction above 0")
    apex = law.cohesion / mu if mu > 0.0 else law.tension or 0.0
    if (law.tension or 0.0) > apex:
        raise InputError(
            "material.joints",
            f"the tension {law.tension:g} Pa of the joint {pair} is above its cohesion over its friction, "
            f"{law.cohesion:g} Pa / {mu:g} = {apex:g} Pa, where the line of Mohr-Coulomb ends",
        )
    return apex


def _by_pair(pairs: Mapping[str, Value], groups: Sequence[str], key: str) -> list[tuple[int, int, Value]]:
    """Entries (i, j, value) of a symmetric table: the default, patterns, pairs by name, so that each replaces those before it."""
    count = range(len(groups))
    out = [(i, j, pairs["default"]) for i in count for j in count] if "default" in pairs else []
    for pair in sorted((pair for pair in pairs if pair != "default"), key=lambda pair: ANY not in pair):
        first, second = _split_pair(pair, groups, key)
        for i in first:
            for j in second:
                out += [(i, j, pairs[pair]), (j, i, pairs[pair])]
    return out


def _split_pair(pair: str, groups: Sequence[str], key: str) -> tuple[list[int], list[int]]:
    """The groups of ``"a-b"``, where the names themselves may hold a dash, and may be patterns with ``*``."""
    for i, letter in enumerate(pair):
        if letter == "-" and (first := members(pair[:i], groups)) and (second := members(pair[i + 1 :], groups)):
            return first, second
    unknown = next((word for word in pair.split("-") if not members(word, groups)), pair)
    raise InputError(f"{key}.{pair}", f'"{unknown}" is no group of blocks{suggest(unknown, groups)}; groups: {", ".join(groups)}')
