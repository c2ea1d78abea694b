# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints that crush: their pressure ends at a compressive strength, and what they are shorter for good stays.

Kernels: ``masonry_cd/mechanics/dynamics/crushing.py``, and the contact points, which remember by how much. Limit analysis cuts such joints
into cells of uniform stress (``masonry_cd/analysis/limit/sections.py``).
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from masonry_cd.foundation.fields import Number
from masonry_cd.foundation.quantities import pressure
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.joint_laws.elastic import JOINT_POINTS, ElasticKeys
from masonry_cd.mechanics.model.joint_laws.law import JointHistory, Law
from masonry_cd.mechanics.model.usual import COMPRESSION

CRUSHING_POINTS = 11  # over the depth of a joint that crushes: its moment is right to 1.6 %


class CrushingKeys(ElasticKeys):
    """Keys of ``[material.joints]``."""

    compressive_strength: Annotated[Number, Unit("Pa"), COMPRESSION, Field(gt=0)] | None = None
    """Pressure at which the joint crushes; that of the masonry where ``masonry.crushing`` asks for it, else it never does. In a run the
    joint is to be elastic, and stays as much shorter as it was crushed."""

    @property
    def points(self) -> int:
        """Over the depth, more of them where the joint crushes."""
        return self.joint_points or (CRUSHING_POINTS if self.compressive_strength else JOINT_POINTS)


def _tables(law: CrushingKeys, mu: float, pair: str) -> dict[str, float]:
    return {"crushing": law.compressive_strength or 0.0}


def _words(law: CrushingKeys) -> str:
    return f"crushed at {pressure(law.compressive_strength)}, for good" if law.compressive_strength else ""


def _needs(law: CrushingKeys, elastic: bool) -> tuple[str, str] | None:
    if law.compressive_strength is None or law.normal_stiffness is not None or elastic:
        return None
    return (
        "normal_stiffness",
        "missing with compressive_strength: in a run a rigid joint does not shorten, "
        "and cannot crush; masonry-cd limit takes rigid joints that crush",
    )


HISTORY = JointHistory("crushed", "m", "by how much the joint is shorter for good where it is most so")
LAW = Law(
    keys=CrushingKeys,
    tables=_tables,
    where=lambda laws: laws.crushing > 0.0,
    words=_words,
    needs=_needs,
    history=HISTORY,
    in_limit="joints that crush bear their strength however far they shorten; masonry softens: with that the factor is an upper bound",
    at_start_only="joints that crush are not followed at finite displacements",
    bounds="joints that crush (material.joints.compressive_strength)",
)
