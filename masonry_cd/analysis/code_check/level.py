# SPDX-License-Identifier: GPL-3.0-or-later
"""How high a mechanism is held: one meaning for the whole of a structure and for its parts.

A mechanism is held along the lines that constrain it (:mod:`masonry_cd.analysis.limit.held`). The height Z of their centroid counts from
the foundation of the building, at ``limit.check.foundation`` or at the lowest block, and is never less than ``limit.check.height``. Up to
ON_THE_GROUND the motion of the ground is that of the mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.code_check.verdicts import ON_THE_GROUND
from masonry_cd.analysis.limit.held import lowest_point
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.mechanics.model.blocks import Assembly


@dataclass(frozen=True)
class HeldLevel:
    """The height at which a mechanism is held, and whose motion is required there."""

    line: float  # z of the centroid of the lines that constrain it [m]
    height: float  # Z, above the foundation [m]
    by: str  # what says so: where the foundation is, or limit.check.height
    counted: float  # height of the building whose motion is wanted [m]; 0: the ground
    doubt: str = ""  # the reason why "satisfied" does not follow there; empty where it may

    @property
    def words(self) -> str:
        """The level in a line."""
        motion = "the motion of the building there" if self.counted else "the motion of the ground"
        return f"held at z = {self.line:.4g} m, {self.height:.4g} m above the foundation ({self.by}): {motion} is required"


def foundation_of(table: CheckTable | None, assembly: Assembly) -> float:
    """The z from which heights count [m].

    Raises:
        InputError: a foundation above the lowest block.
    """
    lowest = lowest_point(assembly, np.flatnonzero(~assembly.fixed))
    if table is None or table.foundation is None:
        return lowest
    if table.foundation > lowest + ON_THE_GROUND:
        up = f"a structure that begins {table.foundation:g} m above its foundation has {lowest - table.foundation:g}"
        raise InputError("limit.check.foundation", f"z = {table.foundation:g} m is above the lowest block, at {lowest:g} m; {up}")
    return table.foundation


def level_of(table: CheckTable, line: float, foundation: float) -> HeldLevel:
    """The level of a mechanism whose constraint lines have their centroid at a z [m]."""
    own = max(line - foundation, 0.0)
    height, doubt = max(own, table.height), ""
    if own > ON_THE_GROUND and not table.building:
        keys = "limit.check.building_height and building_period say that of the building"
        doubt = f"held {own:.3g} m above the ground, whose motion is required: {keys}"
    elif ON_THE_GROUND < own < table.height:
        keys = f"limit.check.foundation in place of height = {table.height:g} m says from where it counts"
        doubt = f"held {own:.3g} m above the lowest block: {keys}"
    raised = table.building and (height > ON_THE_GROUND or table.height)
    by = "limit.check.height" if height > own else f"z = {foundation:.4g} m{', the lowest block' if table.foundation is None else ''}"
    return HeldLevel(line, height, by, height if raised else 0.0, doubt)
