# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints: a spring across and one along the joint, with a dashpot next to each (``masonry_cd/mechanics/dynamics/joint_law.py``).

Without a stiffness of its own a joint follows the moduli of the masonry around it (``masonry_cd/mechanics/model/joint_stiffness.py``), and
without masonry it is rigid. Limit analysis has rigid blocks on rigid joints.
"""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator, model_validator

from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.joint_laws.law import Law, is_of_masonry
from masonry_cd.mechanics.model.usual import DAMPING

JOINT_POINTS = 9  # over the depth: the moment of an open joint is right to 1.9 %
SOFTER_ALONG = 2.4  # k_n over k_t of a material with Poisson's ratio 0.2: 2 (1 + nu)
STIFF = Usual(1e8, 1e15, "joints of masonry have 1e8 to 1e13 N/m3", ("N/mm3", "MN/m3", "kN/m3"))
Stiffness = Annotated[Number, Unit("N/m3"), STIFF, Field(ge=1.0, le=1e20)]  # on 1 Pa they shorten by a metre, and by less than rounding


class ElasticKeys(Table):
    """Keys of ``[material.joints]``."""

    normal_stiffness: Stiffness | None = None
    """Elastic force per area and shortening; that of the masonry when not given, and without masonry rigid."""
    tangential_stiffness: Stiffness | None = None
    """Elastic force per area and slip; the normal one over 2.4, as of a material with Poisson's ratio 0.2, when not given."""
    joint_points: Annotated[int, Field(ge=3, le=15, json_schema_extra={"not": {"multipleOf": 2}})] | None = None
    """Contact points over the depth of an elastic joint that opens: 9 when not given, 11 with a compressive strength, 3, its corners and
    centroid alone, or another odd number up to 15. A closed joint has the same force and moments with any number; an open one is up to
    1.9 % too strong with 9, 3.3 % with 7, 37 % with 3, which take up to a third less time."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.6
    """Theta of the spring over the time step: 0.5 does not damp; above, a mode of frequency f is damped by (2 theta - 1) pi f dt."""
    damping: Annotated[Number, DAMPING, Field(ge=0, le=10)] = 0.0
    """Damping of a dashpot parallel to the spring, as a share of the critical damping of a vibration at the first elastic period of the
    structure, or of ``damping_frequency`` where that is given; proportional to the frequency of others."""
    damping_frequency: Annotated[Number, Unit("Hz"), Field(gt=0, le=1e6)] | None = None
    """At which ``damping`` holds; that of the first mode of the blocks on their elastic joints when not given."""

    @field_validator("joint_points")
    @classmethod
    def _points_in_pairs(cls, value: int | None) -> int | None:
        if value is not None and value % 2 == 0:
            raise ValueError(f"should be odd: the centroid, and pairs on both sides of it; {value - 1} or {value + 1}")
        return value

    @model_validator(mode="after")
    def _of_elastic_joints(self, info: ValidationInfo) -> ElasticKeys:
        if self.damping_frequency is not None and "damping" not in self.model_fields_set:  # damping = 0 says none, as a study may
            raise ValueError("damping_frequency needs damping as well: the share of critical that it is at that frequency")
        if self.tangential_stiffness is not None and self.normal_stiffness is None:
            raise ValueError("tangential_stiffness needs normal_stiffness as well")
        if self.normal_stiffness is not None or is_of_masonry(info):
            return self
        if self.damping > 0.0:
            raise ValueError("damping needs normal_stiffness as well: a rigid joint does not vibrate")
        if self.joint_points is not None:
            raise ValueError("joint_points needs normal_stiffness as well: a rigid joint has its corners")
        return self

    @property
    def stiffness(self) -> tuple[float, float]:
        """Normal and tangential [N/m3]; zeros stand for none of its own."""
        normal = self.normal_stiffness or 0.0
        return normal, self.tangential_stiffness or normal / SOFTER_ALONG

    @property
    def points(self) -> int:
        """Over the depth, where the joint is elastic and opens."""
        return self.joint_points or JOINT_POINTS

    @property
    def retardation(self) -> float:
        """The coefficient of the dashpot over the stiffness [s]: 2 damping / omega, as Rayleigh's stiffness-proportional damping; zero as
        long as the frequency is not known."""
        return 0.0 if self.damping_frequency is None else self.damping / (math.pi * self.damping_frequency)


def _tables(law: ElasticKeys, mu: float, pair: str) -> dict[str, float]:
    normal, tangential = law.stiffness
    return {
        "normal_stiffness": normal,
        "tangential_stiffness": tangential,
        "points": law.points,
        "theta": law.theta,
        "retardation": law.retardation,
        "at_first_period": law.damping if law.damping_frequency is None else 0.0,
    }


def _words(law: ElasticKeys) -> str:
    normal, tangential = (value / 1e9 for value in law.stiffness)
    return f"elastic, {normal:.3g} GN/m³ across and {tangential:.3g} GN/m³ along" if normal else ""


LAW = Law(
    keys=ElasticKeys,
    tables=_tables,
    where=lambda laws: laws.elastic,
    words=_words,
    absent="springs in joints: none, joints are rigid (no masonry in [material], no normal_stiffness in [material.joints])",
)
