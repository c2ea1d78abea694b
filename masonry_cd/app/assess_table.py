# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[assess]`` of a scene: ranges that ``masonry-cd assess`` varies instead of its own."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, WithJsonSchema, field_validator

from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.fields import Count, Number, Table, is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.joint_laws.friction import ROUGHEST
from masonry_cd.mechanics.model.usual import DAMPING, FRICTION, YOUNG

STRUCTURAL = ("joint stiffness", "friction", "block size", "bond", "bond energy", "stone strength", "soil stiffness")
NUMERICAL = ("damping", "joint points", "time step", "tolerance")
Modulus = Annotated[Number, Unit("Pa"), YOUNG, Field(gt=0)]
_RANGE = {"type": "array", "items": {"type": "number", "minimum": 0, "maximum": ROUGHEST}, "minItems": 2, "maxItems": 2}
_FRICTION: dict[str, Any] = {"anyOf": [_RANGE, {"type": "object", "minProperties": 1, "additionalProperties": _RANGE}]}


def assumptions() -> tuple[str, ...]:
    """All that may be varied, in order: those of every scene, and between them those that only some kinds of structure have."""
    from structures import every_kind

    own = dict.fromkeys(name for kind in every_kind() for name in kind.assumptions)
    return (*STRUCTURAL, *own, *NUMERICAL)


def _or_one_of(schema: dict[str, Any]) -> None:
    """Name the assumptions in the schema of a list of them."""
    schema["items"] = {"type": "string", "enum": list(assumptions())}


class AssessTable(Table):
    """The table ``[assess]``."""

    friction: Annotated[Any, FRICTION, WithJsonSchema(_FRICTION)] = None
    """Range of the coefficient, [0.5, 0.7], or ranges by pair of groups as material.friction names them; 20 % to either side when not
    given."""
    young: Annotated[tuple[Modulus, Modulus] | None, Field(strict=False)] = None
    """Range of E that the joints follow; that of the kind of masonry when not given."""
    damping: Annotated[tuple[Annotated[Number, Field(ge=0, le=1)], ...], DAMPING, Field(strict=False)] = (0.0, 0.02, 0.05)
    """Shares of critical damping, where joints are elastic."""
    members: Annotated[Count, Field(ge=3, le=1000)] = 8
    """Members of the ensemble that shows the effect of chance."""
    samples: Annotated[Count, Field(ge=20, le=100_000)] | None = None
    """Runs in which all properties of the structure vary at once, for ``--global``; ten for each of them when not given."""
    leave_out: Annotated[tuple[str, ...], Field(strict=False, json_schema_extra=_or_one_of)] = ()
    """Assumptions that are known, and not varied: "joint stiffness", "friction", "block size", "bond", "bond energy", "stone strength",
    "soil stiffness", "damping", "joint points", "time step", "tolerance", and of bridges "fill resistance", "fill spread",
    "fill pressure", "fill angle"."""

    @field_validator("friction", mode="before")
    @classmethod
    def _ranges(cls, value: Any) -> Any:
        if value is None:
            return None
        pairs = value if isinstance(value, dict) else {"": value}
        for pair, ends in pairs.items():
            if not _is_range(ends):
                where = f'"{pair}": ' if pair else ""
                raise ValueError(f"{where}should be a range of coefficients, [0.5, 0.7], the lower first, between 0 and {ROUGHEST}")
        return value

    @field_validator("young")
    @classmethod
    def _rises(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not value[0] < value[1]:
            raise ValueError("should be a range, the lower end first")
        return value

    @field_validator("leave_out")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for name in value:
            if name not in (*STRUCTURAL, *NUMERICAL) and name not in (every := assumptions()):
                raise ValueError(f'"{name}" is none{suggest(name, every)}; one of {", ".join(every)}')
        return value


def _is_range(ends: Any) -> bool:
    """Return True if a value is two coefficients of friction that rise."""
    two = isinstance(ends, (list, tuple)) and len(ends) == 2 and all(is_number(end) for end in ends)
    return two and 0.0 <= ends[0] < ends[1] <= ROUGHEST
