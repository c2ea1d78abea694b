# SPDX-License-Identifier: GPL-3.0-or-later
"""Coulomb friction: the key ``friction`` of ``[material]``, one coefficient or coefficients by pair of groups, and its words.

Every joint has it. Solvers of a step: ``masonry_cd/mechanics/solvers``. Limit analysis has it with dilation, and without where it searches
for the least factor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number, is_number
from masonry_cd.mechanics.model.by_group import by_group, pair_in_words, pair_table
from masonry_cd.mechanics.model.usual import FRICTION

KEY = "material.friction"
ROUGHEST = 20  # coefficient of friction: beyond, an angle was meant
LISTED = 6  # pairs whose values are listed


def _wrong(mu: Any) -> str:
    """The fault of a coefficient, empty where it has none."""
    if not (is_number(mu) or isinstance(mu, float)):
        return "should be a number"
    return "" if 0 <= mu <= ROUGHEST else f"a coefficient of friction (no angle) should be between 0 and {ROUGHEST}"


_SCHEMA = {"type": "number", "minimum": 0, "maximum": ROUGHEST}
Friction: TypeAlias = Annotated[Number | dict[str, Number], FRICTION, *by_group(_wrong, _SCHEMA)]


def friction_table(friction: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """Return the (G, G) symmetric table of friction coefficients between groups.

    Raises:
        InputError: an unknown group, a negative value, or a pair left without a value.
    """
    table = pair_table(friction, groups, KEY, np.nan)
    if np.isnan(table).any():
        i, j = np.argwhere(np.isnan(table))[0]
        raise InputError(KEY, f"no value for {groups[i]}-{groups[j]}; add it or a default")
    if (table < 0).any():
        raise InputError(KEY, f"a coefficient must not be negative, got {table.min():g}")
    return table


def friction_in_words(friction: float | Mapping[str, float]) -> str:
    """Coulomb's law with its numbers."""
    law = "Friction in the joints is Coulomb's, with the coefficient "
    if isinstance(friction, Mapping):
        listed = [f"{_with_angle(mu)} ({pair_in_words(pair)})" for pair, mu in friction.items()][:LISTED]
        return law + ", ".join(listed) + (" and others." if len(friction) > LISTED else ".")
    return f"{law}{_with_angle(friction)} in all joints."


def _with_angle(mu: float) -> str:
    return f"{mu:.3g}, an angle of {math.degrees(math.atan(mu)):.3g}°"
