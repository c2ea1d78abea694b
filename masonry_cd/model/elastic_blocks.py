"""What blocks are made of, by group: rigid, or elastic with one strain each; the keys of ``[material]`` for it.

A key takes one value for all blocks, or values by group, ``young.arch = 2e9``, with ``default`` for the rest. A group may be a pattern,
``young."*-pier"``; a group by name holds before one by patterns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from masonry_cd.errors import InputError, suggest
from masonry_cd.fields import Number, Table, is_number

RIGID, UNIFORM = "rigid", "uniform"  # kinds of blocks
SOFTEST, STIFFEST = 1e3, 1e18  # Young's modulus [Pa]: from what flows to what only rounding tells from rigid


def _by_group(check: Callable[[Any], str], schema: dict[str, Any]) -> tuple[Any, Any]:
    """Validator and JSON schema of a key of one value, or of values by group; ``check`` says what is wrong with a value, or nothing."""

    def validate(value: Any) -> Any:
        values = value if isinstance(value, Mapping) else {"": value}
        if not values:
            raise ValueError("gives no value")
        for group, each in values.items():
            if wrong := check(each):
                raise ValueError(f'"{group}": {wrong}, got {each!r}' if group else wrong)
        return value

    return BeforeValidator(validate), WithJsonSchema(
        {"anyOf": [schema, {"type": "object", "minProperties": 1, "additionalProperties": schema}]}
    )


def _numbers(low: float, high: float) -> tuple[Any, Any]:
    """Of numbers between two bounds."""

    def check(value: Any) -> str:
        if not is_number(value):
            return "should be a number"
        return "" if low <= value <= high else f"should be between {low:g} and {high:g}"

    return _by_group(check, {"type": "number", "minimum": low, "maximum": high})


def _kind(value: Any) -> str:
    return "" if value in (RIGID, UNIFORM) else f'should be "{RIGID}" or "{UNIFORM}"'


Value: TypeAlias = Number | dict[str, Number]


class ElasticBlocks(Table):
    """The keys of ``[material]`` for blocks that deform."""

    deformable: Annotated[str | dict[str, str], *_by_group(_kind, {"type": "string", "enum": [RIGID, UNIFORM]})] = RIGID
    """"rigid", or "uniform": one strain per block, as in discontinuous deformation analysis; one value, or values by group,
    ``deformable.arch = "uniform"``, and ``default``."""
    young: Annotated[Value, *_numbers(SOFTEST, STIFFEST)] | None = None
    """Young's modulus of blocks that deform [Pa], one value or values by group."""
    poisson: Annotated[Value, *_numbers(0.0, 0.49)] = 0.2
    """Poisson's ratio of blocks that deform, one value or values by group."""
    damping: Annotated[Value, *_numbers(0.0, 10.0)] = 0.0
    """Viscous damping of blocks that deform, as a share of the critical damping of a vibration of ``damping_frequency``; proportional to
    the frequency of others. One value or values by group."""
    damping_frequency: Annotated[Value, *_numbers(1e-3, 1e6)] | None = None
    """At which ``damping`` of the blocks holds [Hz], one value or values by group."""
    strain_theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.6
    """Of the strains over the time step: 0.5 does not damp; above, a mode of frequency f is damped by (2 theta - 1) pi f dt."""

    @model_validator(mode="after")
    def _keys_have_a_use(self) -> ElasticBlocks:
        kinds = self.deformable.values() if isinstance(self.deformable, dict) else [self.deformable]
        deforms = any(kind != RIGID for kind in kinds)
        for key in ("young", "poisson", "damping", "damping_frequency", "strain_theta"):
            if key in self.model_fields_set and not deforms:
                raise ValueError(f'{key} needs deformable = "uniform" beside it: rigid blocks have no strain')
        if deforms and self.young is None:
            raise ValueError("deformable needs young beside it: Young's modulus of the blocks [Pa]")
        if self.damping and self.damping_frequency is None:
            raise ValueError("damping needs damping_frequency beside it: a share of critical, and the frequency at which it is that share")
        return self

    def of_group(self, group: str, groups: Sequence[str]) -> Elasticity | None:
        """The elasticity of the blocks of one of the groups; None: they are rigid.

        Raises:
            InputError: a key names a group that does not exist, or gives a group that deforms no value.
        """
        if _of_group(self.deformable, group, groups, "deformable", RIGID) == RIGID:
            return None
        share = _of_group(self.damping, group, groups, "damping", 0.0)
        frequency = _of_group(self.damping_frequency, group, groups, "damping_frequency") if share else math.inf
        return Elasticity(
            _of_group(self.young, group, groups, "young"),
            _of_group(self.poisson, group, groups, "poisson"),
            share / (math.pi * frequency),
        )


@dataclass(frozen=True)
class Elasticity:
    """Of an isotropic solid."""

    young: float  # [Pa]
    poisson: float
    retardation: float  # viscosity over elasticity, 2 damping / omega [s]


def _of_group(values: Any, group: str, groups: Sequence[str], key: str, otherwise: Any = None) -> Any:
    """The value of a key for a group, by its name, by a pattern or by default."""
    if not isinstance(values, Mapping):
        return values
    for name in values:
        if name != "default" and not any(fnmatchcase(each, name) for each in groups):
            raise InputError(f'material.{key}.{name}: "{name}" is no group of blocks{suggest(name, groups)}; groups: {", ".join(groups)}')
    names = [group, *(name for name in values if fnmatchcase(group, name)), "default"]
    found = next((values[name] for name in names if name in values), otherwise)
    if found is None:
        raise InputError(f"material.{key}: no value for the group {group}; add it or a default")
    return found
