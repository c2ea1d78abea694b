# SPDX-License-Identifier: GPL-3.0-or-later
"""The target of each mechanism: a load factor, or a share zeta_E of the motion of the ground of a check by accelerations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from masonry_cd.analysis.code_check.check import check_at
from masonry_cd.analysis.code_check.ground import Ground, ground_of
from masonry_cd.analysis.code_check.level import foundation_of, level_of
from masonry_cd.analysis.code_check.verdicts import LINEAR
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.analysis.limit.found import FoundMechanism
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.strengthen_table import StrengthenTable


@dataclass(frozen=True)
class Goal:
    """The target of all mechanisms."""

    value: float
    check: CheckTable | None = None  # None: a load factor is requested
    ground: Ground | None = None  # whose motion is the share zeta_E of that of the check
    foot: float = 0.0  # z from which heights count [m]

    def asked(self, one: FoundMechanism) -> float:
        """The load factor at which a mechanism may start at the earliest: the demand is met in proportion to it."""
        if self.check is None or self.ground is None:
            return self.value
        alone = replace(one.oscillator, alpha=1.0)
        made = check_at(self.check, level_of(self.check, one.height, self.foot), alone, self.ground)
        return 1.0 / next(each.met for each in made.verdicts if each.check == LINEAR)

    @property
    def words(self) -> str:
        """The target in a few words."""
        return f"load factor {self.value:g}" if self.check is None else f"zeta_E = {self.value:g}"


def goal_of(table: StrengthenTable, structure: LimitStructure) -> Goal:
    """The target of a table ``[strengthen]``.

    Raises:
        InputError: zeta_E without a check.
    """
    if table.zeta_E is None:
        return Goal(table.target)
    check = structure.asked.check
    if check is None:
        raise InputError("strengthen.zeta_E", "needs [limit.check], whose demand it is a share of")
    ground = ground_of(check, structure.scene.folder)
    return Goal(table.target, check, ground.scaled(table.target * ground.ag), foundation_of(check, structure.assembly))
