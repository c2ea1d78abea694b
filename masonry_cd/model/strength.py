"""Compressive strength by group of blocks: the key ``material.compressive_strength`` of a scene, and what holds for each group."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema

from masonry_cd.errors import InputError, suggest
from masonry_cd.fields import is_number

WEAKEST, STRONGEST = 1e4, 1e10  # [Pa]: from loose rubble, of a hundredth of a MPa, to more than any ceramic
KEY = "material.compressive_strength"
_VALUE = {"type": "number", "minimum": WEAKEST, "maximum": STRONGEST}
_SCHEMA: dict[str, Any] = {"anyOf": [_VALUE, {"type": "object", "minProperties": 1, "additionalProperties": _VALUE}, {"type": "null"}]}


def _strengths(value: object) -> object:
    """One strength, or strengths by group."""
    groups: Mapping[str, Any] = value if isinstance(value, Mapping) else {"": value}
    if not groups:
        raise ValueError("gives no value")
    for group, strength in groups.items():
        name = f'"{group}": ' if group else ""
        if not is_number(strength):
            raise ValueError(f"{name}should be a number, in Pa")
        if not WEAKEST <= strength <= STRONGEST:
            raise ValueError(f"{name}should be between {WEAKEST:g} and {STRONGEST:g} Pa (5 MPa is 5e6), got {strength:g}")
    return {group: float(strength) for group, strength in groups.items()} if isinstance(value, Mapping) else float(groups[""])


Strength = Annotated[float | dict[str, float] | None, BeforeValidator(lambda value: None if value is None else _strengths(value)),
                     WithJsonSchema(_SCHEMA)]  # fmt: skip


def strength_by_group(given: float | Mapping[str, float] | None, groups: Sequence[str]) -> np.ndarray:
    """The strength of each of G groups, (G,) [Pa]; NaN where none is given. A name holds before a pattern, a pattern before ``default``.

    Raises:
        InputError: an unknown group.
    """
    pairs = given if isinstance(given, Mapping) else {} if given is None else {"default": given}
    out = np.full(len(groups), pairs.get("default", np.nan))
    for name in sorted((name for name in pairs if name != "default"), key=lambda name: "*" not in name):
        members = [k for k, group in enumerate(groups) if (fnmatchcase(group, name) if "*" in name else group == name)]
        if not members:
            raise InputError(f'{KEY}: "{name}" is no group of blocks{suggest(name, groups)}; groups: {", ".join(groups)}')
        out[members] = pairs[name]
    return out
