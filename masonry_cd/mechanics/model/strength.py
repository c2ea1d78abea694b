# SPDX-License-Identifier: GPL-3.0-or-later
"""Compressive strength by group of blocks: the key ``material.compressive_strength`` of a scene, and what holds for each group."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, TypeAlias

import numpy as np

from masonry_cd.foundation.fields import Number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.by_group import numbers, of_group
from masonry_cd.mechanics.model.usual import COMPRESSION

WEAKEST, STRONGEST = 0.1, 1e10  # [Pa]: a value in MPa is doubted, not refused; up to more than any ceramic
KEY = "compressive_strength"

Strength: TypeAlias = Annotated[
    Number | dict[str, Number] | None, Unit("Pa"), COMPRESSION, *numbers(WEAKEST, STRONGEST, "Pa (5 MPa is 5e6)")
]


def strength_by_group(given: float | Mapping[str, float] | None, groups: Sequence[str]) -> np.ndarray:
    """The strength of each of G groups, (G,) [Pa]; NaN where none is given.

    Raises:
        InputError: an unknown group.
    """
    return np.array([of_group(given, group, groups, KEY, np.nan) for group in groups], dtype=float)
