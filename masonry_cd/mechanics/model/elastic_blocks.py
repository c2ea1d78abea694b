# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformation of blocks, by group: rigid, elastic with one strain each, or meshed; its keys in ``[material]``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from pydantic import Field, model_validator

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.by_group import by_group, numbers, of_group
from masonry_cd.mechanics.model.usual import DAMPING, YOUNG

RIGID, UNIFORM, TETRAHEDRA = KINDS = ("rigid", "uniform", "tetrahedra")  # of blocks
POISSON = 0.2  # ratio, when not given
SOFTEST, STIFFEST = 10.0, 1e18  # Young's modulus [Pa]: from adobe in MPa, which is doubted, to what only rounding tells from rigid


def _kind(value: Any) -> str:
    return "" if value in KINDS else f'should be "{RIGID}", "{UNIFORM}" or "{TETRAHEDRA}"'


Value: TypeAlias = Number | dict[str, Number]


class ElasticBlocks(Table):
    """The keys of ``[material]`` for blocks that deform."""

    deformable: Annotated[str | dict[str, str], *by_group(_kind, {"type": "string", "enum": list(KINDS)})] = RIGID
    """"rigid"; "uniform": one strain per block, as in discontinuous deformation analysis; or "tetrahedra": blocks cut into elements of one
    strain each, triangles where the scene moves in a plane. One value, or values by group, ``deformable.arch = "uniform"``, and
    ``default``. Where "rigid" is given for all, the keys below have no effect."""
    mesh_size: Annotated[Value, Unit("m"), *numbers(1e-6, 1e6)] | None = None
    """Size of the elements of tetrahedra, one value or values by group; larger than a block: as few as it can have."""
    young: Annotated[Value, Unit("Pa"), YOUNG, *numbers(SOFTEST, STIFFEST, "Pa (1.5 GPa is 1.5e9)")] | None = None
    """Young's modulus of blocks that deform, one value or values by group."""
    poisson: Annotated[Value, *numbers(0.0, 0.49)] = POISSON
    """Poisson's ratio of blocks that deform, one value or values by group."""
    damping: Annotated[Value, DAMPING, *numbers(0.0, 10.0)] = 0.0
    """Viscous damping of blocks that deform, as a share of the critical damping of a vibration of ``damping_frequency``; proportional to
    the frequency of others. One value or values by group."""
    damping_frequency: Annotated[Value, Unit("Hz"), *numbers(1e-3, 1e6)] | None = None
    """At which ``damping`` of the blocks holds, one value or values by group."""
    strain_theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.6
    """Theta of the strains over the time step: 0.5 does not damp; above, a mode of frequency f is damped by (2 theta - 1) pi f dt."""

    @model_validator(mode="after")
    def _keys_have_a_use(self) -> ElasticBlocks:
        kinds = self.deformable.values() if isinstance(self.deformable, dict) else [self.deformable]
        deforms = any(kind != RIGID for kind in kinds)
        if not deforms and "deformable" in self.model_fields_set:  # rigid as the scene says: the rest waits, to compare
            return self
        for key in ("young", "poisson", "damping", "damping_frequency", "strain_theta"):
            if key in self.model_fields_set and not deforms:
                raise ValueError(f'{key} needs deformable = "uniform" or "tetrahedra": rigid blocks have no strain')
        if self.mesh_size is not None and TETRAHEDRA not in kinds:
            raise ValueError('mesh_size needs deformable = "tetrahedra": no other block is meshed')
        if self.mesh_size is None and TETRAHEDRA in kinds:
            raise ValueError('deformable = "tetrahedra" needs mesh_size as well: the size of the elements [m]')
        if deforms and self.young is None:
            raise ValueError("deformable needs young as well: Young's modulus of the blocks [Pa]")
        if self.damping and self.damping_frequency is None:
            raise ValueError("damping needs damping_frequency as well: a share of critical, and the frequency at which it is that share")
        return self

    def of_group(self, group: str, groups: Sequence[str]) -> Elasticity | None:
        """The elasticity of the blocks of one of the groups; None: they are rigid.

        Raises:
            InputError: a key names a group that does not exist, or gives a group that deforms no value.
        """
        kind = of_group(self.deformable, group, groups, "deformable", RIGID)
        if kind == RIGID:
            return None
        share, poisson = of_group(self.damping, group, groups, "damping", 0.0), of_group(self.poisson, group, groups, "poisson", POISSON)
        young, frequency, size = (of_group(getattr(self, key), group, groups, key) for key in ("young", "damping_frequency", "mesh_size"))
        if young is None:
            raise InputError("material.young", f"no value for the group {group}; add it or a default")
        if share and frequency is None:
            raise InputError("material.damping_frequency", f"no value for the group {group}; add it or a default")
        if kind == TETRAHEDRA and size is None:
            raise InputError("material.mesh_size", f"no value for the group {group}; add it or a default")
        return Elasticity(young, poisson, share / (math.pi * frequency) if share else 0.0, float(size) if kind == TETRAHEDRA else 0.0)


@dataclass(frozen=True)
class Elasticity:
    """Moduli of an isotropic solid."""

    young: float  # [Pa]
    poisson: float
    retardation: float  # viscosity over elasticity, 2 damping / omega [s]
    mesh_size: float = 0.0  # of its elements [m]; 0: one strain per block
