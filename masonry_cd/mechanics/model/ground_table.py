# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[[ground]]`` of a scene: the soil below footings, or their springs and dashpots."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.impedance import Soil, impedance
from masonry_cd.mechanics.model.usual import COMPRESSION

LEAST, MOST = 0.0, 0.5  # Poisson's ratio
OF_BED = ("x", "z")  # stiffness that a bed without tension follows
Above = Annotated[Number, Field(gt=0.0)]
Least = Annotated[Number, Field(ge=0.0)]
Metres = Annotated[Above, Unit("m")]
Spring = Annotated[Above | None, Unit("N/m")]
Turning = Annotated[Above | None, Unit("N m")]
Dashpot = Annotated[Least | None, Unit("N s/m")]
TurningDashpot = Annotated[Least | None, Unit("N m s")]


def _names(value: object) -> tuple[str, ...]:
    """One name or a list of names."""
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names or not all(isinstance(name, str) for name in names):
        raise ValueError("must be the name of a fixed block or a group, or a list of names")
    return tuple(names)


_SCHEMA: dict[str, Any] = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]}
Names = Annotated[tuple[str, ...] | None, BeforeValidator(_names), WithJsonSchema(_SCHEMA)]


class FootingSprings(Table):
    """Stiffness of a footing in six directions, world axes, at the middle of its base."""

    x: Spring = None
    """Stiffness of a shift along x; by the soil where it is not given, as all others."""
    y: Spring = None
    """Along y."""
    z: Spring = None
    """Along z."""
    rx: Turning = None
    """Stiffness of a turn about x, per radian."""
    ry: Turning = None
    """About y."""
    rz: Turning = None
    """About z."""


class Dashpots(Table):
    """Dashpots of a footing in six directions, likewise."""

    x: Dashpot = None
    """Dashpot of a shift along x; by the soil where it is not given, as all others, and none without soil."""
    y: Dashpot = None
    """Along y."""
    z: Dashpot = None
    """Along z."""
    rx: TurningDashpot = None
    """Dashpot of a turn about x."""
    ry: TurningDashpot = None
    """About y."""
    rz: TurningDashpot = None
    """About z."""


class GroundTable(Table):
    """Keys of ``[[ground]]``."""

    supports: Names = None
    """Fixed blocks or groups that become footings, * stands for any letters; all on which something stands when not given."""
    shear_wave_velocity: Annotated[Above, Unit("m/s"), Usual(50.0, 3000.0, "soils have 100 to 800 m/s, rock up to 3000")] | None = None
    """Velocity of shear waves in the soil, for small strain or reduced for the strain of the shaking."""
    shear_modulus: Annotated[Above, Unit("Pa")] | None = None
    """Shear modulus of the soil, instead of its shear wave velocity."""
    density: Annotated[Above, Unit("kg/m3")] | None = None
    """Density of the soil."""
    poisson: Annotated[Number, Field(ge=LEAST, le=MOST)] | None = None
    """Poisson's ratio of the soil."""
    embedment: Annotated[Least, Unit("m")] = 0.0
    """Depth down to which soil holds the sides of a footing."""
    frequency: Annotated[Above, Unit("Hz")] | None = None
    """Frequency for the stiffness and dashpots of the soil; else static stiffness, and no radiation from rotations."""
    material_damping: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.0
    """Damping of the soil itself, as a share of critical at the frequency."""
    length: Metres | None = None
    """Longer side of the footing's base; else by its plan."""
    width: Metres | None = None
    """Shorter side."""
    projection: Annotated[Least, Unit("m")] | None = None
    """Projection of a footing beyond what stands on it, below which it is cut out of its support; else all of it, and 0 on the slab of a
    tower, wall, church or column."""
    added_mass: Annotated[Least, Unit("kg")] = 0.0
    """Mass that moves with the footing, spread over it."""
    uplift: bool = False
    """Footings stand on a bed that bears nothing but pressure, instead of springs and dashpots: they may lift off. The bed has the
    stiffness of shifts along z and x, per area."""
    bearing_strength: Annotated[Above, Unit("Pa"), COMPRESSION] | None = None
    """Pressure at which the bed yields for good; never when not given."""
    stiffness: FootingSprings = Field(default_factory=FootingSprings)
    """Stiffness of the springs, instead of those of the soil."""
    damping: Dashpots = Field(default_factory=Dashpots)
    """Dashpots, instead of those of the soil."""

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        soil = {name: getattr(self, name) is not None for name in ("density", "poisson")}
        moduli = [name for name in ("shear_wave_velocity", "shear_modulus") if getattr(self, name) is not None]
        if len(moduli) > 1:
            raise ValueError("give shear_wave_velocity or shear_modulus of the soil, not both")
        lacking = [name for name, given in soil.items() if not given]
        if moduli and lacking:
            raise ValueError(f"{moduli[0]} needs {' and '.join(lacking)} of the soil")
        if not moduli:
            needed = OF_BED if self.uplift else tuple(FootingSprings.model_fields)
            missing = [name for name in needed if getattr(self.stiffness, name) is None]
            if missing:
                raise ValueError(f"give the soil (shear_wave_velocity, density, poisson), or stiffness.{', stiffness.'.join(missing)}")
            idle = [name for name in ("density", "poisson", "frequency", "length", "width") if getattr(self, name) is not None]
            idle += [name for name in ("embedment", "material_damping") if getattr(self, name) > 0.0]
            if idle:
                raise ValueError(f"{idle[0]} counts with shear_wave_velocity or shear_modulus alone")
        if self.bearing_strength is not None and not self.uplift:
            raise ValueError("bearing_strength needs uplift = true: springs do not yield, a bed does")
        if self.uplift:
            idle = [
                f"stiffness.{name}"
                for name in FootingSprings.model_fields
                if name not in OF_BED and getattr(self.stiffness, name) is not None
            ]
            idle += [f"damping.{name}" for name in Dashpots.model_fields if getattr(self.damping, name) is not None]
            idle += ["material_damping"] if self.material_damping else []
            if idle:
                raise ValueError(f"{idle[0]} counts without uplift alone: a bed has the stiffness along z and x, and no dashpots")
        if self.material_damping and self.frequency is None:
            raise ValueError("material_damping needs the frequency at which it is that share of critical")
        if self.length is not None and self.width is not None and self.width > self.length:
            raise ValueError("the width is the shorter side, not more than the length")
        return self

    @property
    def soil(self) -> Soil | None:
        """The soil; None where springs are given."""
        if self.density is None or self.poisson is None:
            return None
        modulus = self.shear_modulus or self.density * (self.shear_wave_velocity or 0.0) ** 2
        return Soil(modulus, self.density, self.poisson, self.embedment)

    def of_footing(self, sides: tuple[float, float], along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stiffness and dashpots (6, 6) of a footing, world axes.

        Args:
            sides: length and width by its plan [m].
            along: (2,) unit vector of the longer side in plan.

        Raises:
            ValueError: one side is given, and the other by the plan does not go with it.
        """
        stiffness, damping, soil = np.zeros((6, 6)), np.zeros((6, 6)), self.soil
        if soil is not None:
            length, width = self.length or sides[0], self.width or sides[1]
            if width > length:
                raise ValueError(f"a base of {length:.4g} m by {width:.4g} m: the length is the longer side; give both")
            omega = 2.0 * math.pi * (self.frequency or 0.0)
            springs, dashpots = impedance(soil, length, width, omega)
            dashpots = dashpots + (2.0 * self.material_damping / omega * springs if omega else 0.0)
            frame = np.array([[along[0], -along[1], 0.0], [along[1], along[0], 0.0], [0.0, 0.0, 1.0]])
            for part in (slice(0, 3), slice(3, 6)):
                for values, out in ((springs, stiffness), (dashpots, damping)):
                    out[part, part] = np.sum(frame[:, None, :] * values[part] * frame[None, :, :], axis=2)
        for table, out in ((self.stiffness, stiffness), (self.damping, damping)):
            for i, value in enumerate(getattr(table, name) for name in type(table).model_fields):
                if value is not None:
                    out[i, :], out[:, i] = 0.0, 0.0
                    out[i, i] = value
        return stiffness, damping
