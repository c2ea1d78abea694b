# SPDX-License-Identifier: GPL-3.0-or-later
"""Rolling friction of spheres: the key ``rolling_friction`` of ``[material]``, the arm of the moment that resists, over the radius.

It bounds the moment of a contact by its normal force times the arm (``masonry_cd/mechanics/contact/round_contact.py`` spreads the contact
over a ring of points). Limit analysis knows no spheres.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np

from masonry_cd.foundation.fields import Number, is_number
from masonry_cd.mechanics.model.by_group import by_group, pair_table


def _wrong(share: Any) -> str:
    """The fault of an arm over a radius, empty where it has none."""
    return "" if is_number(share) and 0 <= share <= 1 else "an arm over a radius should be a number between 0 and 1"


RollingFriction: TypeAlias = Annotated[Number | dict[str, Number], *by_group(_wrong, {"type": "number", "minimum": 0, "maximum": 1})]


def rolling_table(rolling: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """Return the (G, G) symmetric table of rolling friction between groups, zero of pairs without a value.

    Raises:
        InputError: an unknown group.
    """
    return pair_table(rolling, groups, "material.rolling_friction", 0.0)
