# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[material]`` of a scene: density, friction, what blocks are made of, and the laws of joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, WithJsonSchema, field_validator, model_validator

from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.table_schema import one_or_by_name
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.joint_laws.friction import Friction
from masonry_cd.mechanics.model.joint_laws.restitution import Restitution
from masonry_cd.mechanics.model.joint_laws.rolling import RollingFriction
from masonry_cd.mechanics.model.masonry_kinds import RIGID, Masonry, MasonryKey
from masonry_cd.mechanics.model.stones import Stones
from masonry_cd.mechanics.model.strength import KEY, Strength
from masonry_cd.mechanics.model.usual import DENSITY

LIGHTEST, HEAVIEST = 0.1, 1e6  # density [kg/m3], what numbers bear; what masonry has is in usual.py
_DENSITY = {"type": "number", "minimum": LIGHTEST, "maximum": HEAVIEST}


class Material(ElasticBlocks):
    """The table ``[material]``."""

    masonry: MasonryKey = None
    """Kind of existing masonry, which gives density, stiffness of the joints, and strength where stress is reported, by tables C8.5.I and
    C8.5.II of Circolare 7/2019: its name, or a table. Other keys of [material] and [material.joints] win."""
    density: Annotated[Number, Unit("kg/m3"), DENSITY, WithJsonSchema(_DENSITY)] | None = None
    """Density of every block that brings none of its own; that of the masonry when not given; a block file whose blocks all state theirs
    needs none."""
    friction: Friction
    """Coefficient of friction: one value, or values by pair of groups, ``friction.arch-base = 0.7``, and ``default``."""
    rolling_friction: RollingFriction = 0.0
    """Rolling friction of spheres: the arm of the moment that resists rolling, over the radius R, or over R_a R_b / (R_a + R_b) of two
    spheres; one value, or values by pair of groups, as friction. Pairs without a value roll freely."""
    restitution: Restitution = 0.0
    """Newton's coefficient of restitution of impacts: one value, or values by pair of groups, as friction. Rigid dry joints give back this
    share of the speed at which they are hit, and nothing without it."""
    compressive_strength: Strength = None
    """Compressive strength of the blocks, with which reports compare their stress: one value, or values by group,
    ``compressive_strength.arch = 5e6``, which may be patterns, and ``default``. Nothing crushes by it: ``joints.compressive_strength`` is
    where joints do."""
    joints: Annotated[dict[str, JointLaw], Field(json_schema_extra=one_or_by_name(JointLaw))] = Field(default_factory=dict)
    """Laws of the joints by pair of groups, ``[material.joints.arch-base]``, and ``default``, which plain keys stand for. A joint
    without a law is dry, and rigid where no masonry is named."""
    stones: Annotated[dict[str, Stones], Field(json_schema_extra=one_or_by_name(Stones))] = Field(default_factory=dict)
    """Stones that crack along planes laid beforehand: one law for all blocks that move, or laws by group, ``[material.stones.arch]``,
    which may be patterns, and ``default``; groups without a law have stones that do not break."""

    @field_validator("density")
    @classmethod
    def _density_in_kg_per_m3(cls, value: float | None) -> float | None:
        if value is not None and not LIGHTEST <= value <= HEAVIEST:
            raise ValueError(f"should be between {LIGHTEST:g} and {HEAVIEST:g} kg/m3")
        return value

    @field_validator("joints", "stones", mode="before")
    @classmethod
    def _laws(cls, value: Any, info: ValidationInfo) -> Any:
        """One law for all is the default of the pairs, or groups."""
        by = "pair" if info.field_name == "joints" else "group"
        if not isinstance(value, Mapping):
            raise ValueError(f"should be a table: keys of one law, or tables by {by}{' of groups' if by == 'pair' else ''}")
        plain = [key for key, law in value.items() if not isinstance(law, Mapping | Table)]
        if plain and len(plain) < len(value):
            raise ValueError(
                f'holds keys of one law ("{plain[0]}") and tables by {by}; put the keys under [material.{info.field_name}.default]'
            )
        return {"default": value} if plain else value

    @model_validator(mode="after")
    def _tension_is_stated(self) -> Material:
        """The tables of masonry have no tensile strength: cohesion over friction would be invented."""
        bonded = self.masonry is not None and self.masonry.shear_bond
        if bonded and any(law.tension is None and not law.cohesion for law in (self.joints or {"default": JointLaw()}).values()):
            raise ValueError("masonry.shear_bond needs joints.tension as well: the tensile strength of the bond [Pa], 0 for none")
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
        if self.masonry is None or self.joint_moduli is None:
            return self
        young = self.joint_moduli[0]
        stones = {group: own.model_copy(update={"young": own.modulus or young}) for group, own in self.stones.items()}
        return self.model_copy(update={"masonry": self.masonry.model_copy(update={"stiffness": RIGID}), "stones": stones})


def given_strength(table: Mapping[str, Any]) -> Any:
    """Compressive strength that a table [material] gives, as its key or by its masonry [Pa]; None: neither does."""
    masonry = table.get("masonry")
    if KEY in table or masonry is None:
        return table.get(KEY)
    return Masonry.model_validate({"kind": masonry} if isinstance(masonry, str) else masonry).strength
