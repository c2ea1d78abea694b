# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton's coefficient of restitution: the key ``restitution`` of ``[material]``, the share e of the normal speed at which an impact throws
contacts back, u_n+ = -e u_n-. Without it impacts are perfectly plastic, e = 0.

It is of dry rigid joints: springs and bonds have their own way to give back. ``masonry_cd/mechanics/dynamics/restitution.py`` applies it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Number, is_number
from masonry_cd.mechanics.model.by_group import by_group, pair_table

KEY = "material.restitution"
WARNING = (
    f"{KEY}: Newton's law throws each contact back by its own speed, all at once: in stacks blows do not pass on from block to block, and "
    "impacts with friction may gain energy (impact in the energy balance falls)"
)


def _wrong(share: Any) -> str:
    """The fault of a coefficient, empty where it has none."""
    return "" if is_number(share) and 0 <= share <= 1 else "a coefficient of restitution should be a number between 0 and 1"


Restitution: TypeAlias = Annotated[Number | dict[str, Number], *by_group(_wrong, {"type": "number", "minimum": 0, "maximum": 1})]


def restitution_table(values: float | Mapping[str, float], groups: Sequence[str], by_area: np.ndarray, deformable: bool) -> np.ndarray:
    """Return the (G, G) symmetric table of coefficients between groups, zero of pairs without a value.

    Args:
        values: of the key.
        groups: all of them.
        by_area: (G, G) which pairs have joints with springs or bonds.
        deformable: whether a block deforms.

    Raises:
        InputError: an unknown group, or a pair whose joints have springs or bonds, or blocks that deform.
    """
    table = pair_table(values, groups, KEY, 0.0)
    if table.any() and deformable:
        raise InputError(KEY, "blocks that deform give back what they stored in an impact; it is for rigid blocks")
    bad = np.argwhere((table > 0.0) & by_area)
    if len(bad):
        pair = "-".join(groups[int(i)] for i in bad[0])
        raise InputError(KEY, f"joints {pair} have springs or bonds, which give back themselves; restitution.{pair} = 0 leaves them out")
    return table
