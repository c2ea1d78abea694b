# SPDX-License-Identifier: GPL-3.0-or-later
"""Bonds that soften: past its strength a bond gives way bit by bit, and takes an energy per area, G_I in tension and G_II in shear.

Equations: ``masonry_cd/mechanics/dynamics/softening.py``. Limit analysis has these bonds at their strength, as it has brittle ones.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number
from masonry_cd.foundation.quantities import pressure
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.joint_laws.bonded import BondKeys, strengths
from masonry_cd.mechanics.model.joint_laws.law import Law
from masonry_cd.mechanics.model.usual import FRACTURE

ENERGIES = ("fracture_energy", "shear_fracture_energy")
HOW = {"linear": "linearly", "exponential": "exponentially"}


class SofteningKeys(BondKeys):
    """Keys of ``[material.joints]``."""

    fracture_energy: Annotated[Number, Unit("N/m"), FRACTURE, Field(gt=0)] | None = None
    """G_I, what the bond takes per area when it is pulled apart. With it a bond softens past its strength, point by point; without it
    breaks at once, all over the joint."""
    shear_fracture_energy: Annotated[Number, Unit("N/m"), FRACTURE, Field(gt=0)] | None = None
    """G_II, what the bond takes per area when it is sheared, friction not counted; it goes with ``fracture_energy``."""
    softening: Literal["linear", "exponential"] = "exponential"
    """Softening law: how the stress of a bond with a fracture energy falls with the separation."""

    @model_validator(mode="after")
    def _both_and_elastic(self) -> SofteningKeys:
        given = [key for key in ENERGIES if getattr(self, key) is not None]
        if len(given) == 1:
            other = ENERGIES[1 - ENERGIES.index(given[0])]
            raise ValueError(f"{given[0]} needs {other} next to it: what the bond takes in tension, and in shear")
        if given and self.normal_stiffness is None:
            raise ValueError("fracture_energy needs normal_stiffness next to it: a rigid joint cannot soften")
        if not given and "softening" in self.model_fields_set:
            raise ValueError("softening needs fracture_energy and shear_fracture_energy next to it: what the bond takes")
        return self


def _tables(law: SofteningKeys, mu: float, pair: str) -> dict[str, float]:
    """Energies, and the shape of the curve.

    Raises:
        InputError: there is no bond to soften, or its stress would have to snap back.
    """
    if law.fracture_energy is None or law.shear_fracture_energy is None:
        return dict.fromkeys(("fracture", "shear_fracture", "exponential"), 0.0)
    apex, tension = strengths(law, mu)
    modes = (("tension", tension, law.fracture_energy), ("cohesion", mu * apex, law.shear_fracture_energy))
    for key, (of, strength, energy), stiffness in zip(ENERGIES, modes, law.stiffness, strict=True):
        if not strength > 0.0:
            raise InputError("material.joints", f"{key} of the joint {pair} needs a {of} above 0: there is no bond that could soften")
        stored = strength * strength / (2.0 * stiffness)
        if energy <= stored:
            raise InputError(
                "material.joints",
                f"{key} of the joint {pair} is {energy:g} N/m, no more than its spring stores at the {of}, {pressure(strength)}: "
                f"{of}^2 / (2 stiffness) = {stored:.4g} N/m; give it more energy, or a stiffer joint",
            )
    return {
        "fracture": law.fracture_energy,
        "shear_fracture": law.shear_fracture_energy,
        "exponential": float(law.softening == "exponential"),
    }


def _words(law: SofteningKeys) -> str:
    if law.fracture_energy is None:
        return ""
    return f"softening {HOW[law.softening]} by {law.fracture_energy:.3g} N/m in tension and {law.shear_fracture_energy:.3g} N/m in shear"


LAW = Law(keys=SofteningKeys, tables=_tables, where=lambda laws: laws.fracture > 0.0, words=_words)
