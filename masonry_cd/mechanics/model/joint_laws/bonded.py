# SPDX-License-Identifier: GPL-3.0-or-later
"""Bonded joints: Coulomb's cone with its tip at a tension, cohesion / mu, until the bond breaks, all over the joint and for good.

Kernels: ``masonry_cd/mechanics/dynamics/joint_law.py``. Limit analysis has the bond at the corners of a joint, by shares of its area.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationInfo, model_validator

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number
from masonry_cd.foundation.quantities import pressure
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.joint_laws.elastic import ElasticKeys
from masonry_cd.mechanics.model.joint_laws.law import JointHistory, Law, is_of_masonry
from masonry_cd.mechanics.model.usual import BOND


class BondKeys(ElasticKeys):
    """Keys of ``[material.joints]``."""

    cohesion: Annotated[Number, Unit("Pa"), BOND, Field(ge=0)] = 0.0
    """Shear strength without compression, of a joint that has not broken yet."""
    tension: Annotated[Number, Unit("Pa"), BOND, Field(ge=0)] | None = None
    """Tensile strength of a joint that has not broken yet; when not given, cohesion / friction, where Mohr-Coulomb's line ends."""

    @model_validator(mode="after")
    def _parts_at_its_cone(self, info: ValidationInfo) -> BondKeys:
        if self.tension is not None and self.normal_stiffness is None and not is_of_masonry(info):
            why = "how a rigid joint spreads its stress is not unique, it parts at cohesion / friction"
            raise ValueError(f"tension needs normal_stiffness as well: {why}")
        return self


def _tables(law: BondKeys, mu: float, pair: str) -> dict[str, float]:
    """``apex``: tension at the tip of the cone [Pa], where the line of Mohr-Coulomb, mu p + c, comes to zero."""
    if mu == 0.0 and law.cohesion > 0.0:
        raise InputError("material.joints", f"the joint {pair} has cohesion but no friction; give it a coefficient of friction above 0")
    apex, tension = strengths(law, mu)
    if (law.tension or 0.0) > apex:
        raise InputError(
            "material.joints",
            f"the tension {pressure(law.tension or 0.0)} of the joint {pair} is above its cohesion over its friction, "
            f"{pressure(law.cohesion)} / {mu:g} = {pressure(apex)}, where the line of Mohr-Coulomb ends",
        )
    return {"apex": apex, "tension": tension}


def strengths(law: BondKeys, mu: float) -> tuple[float, float]:
    """Tension at the tip of the cone, and tensile strength [Pa]."""
    apex = law.cohesion / mu if mu > 0.0 else law.tension or 0.0
    return apex, apex if law.tension is None else law.tension


def _words(law: BondKeys) -> str:
    if not (law.cohesion or law.tension):
        return "dry: without tension and cohesion"
    tension = "a tensile strength of cohesion over friction"
    if law.tension is not None:
        tension = f"a tensile strength of {law.tension / 1e3:.3g} kPa"
    bond = f"mortar with a cohesion of {law.cohesion / 1e3:.3g} kPa and {tension}"
    return bond if getattr(law, "fracture_energy", None) else f"{bond}; where it breaks, friction alone is left, at once"


HISTORY = JointHistory("bonded", "", "share of the area that is bonded")
LAW = Law(
    keys=BondKeys,
    tables=_tables,
    where=lambda laws: laws.apex > 0.0,
    words=_words,
    absent="cohesion: none, joints are dry",
    history=HISTORY,
    in_limit="bond counts as plastic: it is brittle, and what it adds to the factor is an upper bound",
)
