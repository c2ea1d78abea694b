# SPDX-License-Identifier: GPL-3.0-or-later
"""A measured run: the values from which numbers follow, each computed once, on first use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import (
    JointDamage,
    bonds,
    collapsed_blocks,
    crushing,
    displacement_max,
    fallen,
    joint_counts,
    joint_damage,
    shock_rows,
)
from masonry_cd.analysis.damage.macro_elements import can_be_graded
from masonry_cd.analysis.damage.part_damage import DamageSettings, PartDamage, Row, part_damage
from masonry_cd.analysis.damage.stones import cracked_stones
from masonry_cd.analysis.damage.verdict import checks_of
from masonry_cd.analysis.deformed import Solids, base_at, solids_of
from masonry_cd.analysis.outputs import SUMMARY, values_in
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import PartInShort


@dataclass(frozen=True, eq=False)
class Measured:
    """A run, and what counts as damage."""

    results: Results
    settings: DamageSettings = field(default_factory=DamageSettings)
    summary: Summary = field(default_factory=Summary)  # as far as it is known
    known: PartDamage | None = None  # the damage by part with a history of its own, where that is there already

    @cached_property
    def table(self) -> JointDamage:
        """The damage joint by joint."""
        return joint_damage(self.results, self.settings.thresholds)

    @cached_property
    def damage(self) -> PartDamage:
        """The damage by part; its history is the last frame alone where the run has kept the largest drifts of all steps."""
        last = np.array([self.results.frames - 1]) if self.results.has_peaks_of_steps else None
        return self.known or part_damage(self.results, self.settings, last)

    @property
    def whole(self) -> Row:
        """The damage of the structure as a whole."""
        return self.damage.parts[-1]

    @cached_property
    def solids(self) -> Solids:
        """The blocks as built."""
        return solids_of(self.results.blocks)

    @cached_property
    def fallen(self) -> tuple[str, ...]:
        """Names of the blocks that have fallen."""
        return collapsed_blocks(self.results, self.settings.thresholds)

    @cached_property
    def displacement_max(self) -> float:
        """Largest displacement of a block, relative to the base, over all steps [m]."""
        return displacement_max(self.results)

    @cached_property
    def highest(self) -> int:
        """The free block with the highest centre; -1 where none is free."""
        free = np.flatnonzero(~self.solids.fixed)
        return int(free[np.argmax(self.solids.centre[free, 2])]) if len(free) else -1

    def moved(self, block: int) -> np.ndarray:
        """(F, 3) how a block has moved relative to the base, over the frames [m]."""
        every = slice(0, self.results.frames)
        position = np.asarray(self.results.position[every, [block]], dtype=float)
        return np.asarray(base_at(self.results, self.solids, every).seen(position)[:, 0] - self.solids.centre[block])

    @cached_property
    def top(self) -> np.ndarray:
        """(F,) displacement of the highest block along the horizontal direction in which it goes farthest [m]; empty of none."""
        if self.highest < 0:
            return np.zeros(0)
        moved = self.moved(self.highest)[:, :2]
        farthest = moved[np.argmax(np.hypot(*moved.T))]
        along = farthest / max(float(np.hypot(*farthest)), 1e-300)
        return np.asarray(moved @ (along * (np.sign(along[np.argmax(np.abs(along))]) or 1.0)))

    def first_fall(self) -> float | None:
        """Time of the first frame in which a block has fallen, where one has at the end [s]; a fallen block stays one."""
        if not self.fallen:
            return None
        low, high = 0, self.results.frames - 1
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if fallen(self.results, self.settings.thresholds, middle).any() else (middle + 1, high)
        return float(self.results.time[high])


def damage_numbers(run: Measured, end: EndState) -> Summary:
    """The numbers of damage for a summary, the verdict and those after each shock of a sequence among them."""
    results, thresholds = run.results, run.settings.thresholds
    numbers = Summary(
        **joint_counts(run.table).as_dict(),
        blocks=len(results.blocks),
        joints=results.joints.count,
        collapsed_blocks=len(run.fallen),
        collapsed_block_names=run.fallen,
        **values_in(SUMMARY, run),
    )
    checks = checks_of((results.closing or Summary()) | numbers, thresholds, end)
    return (
        numbers
        | Summary(provisional=end.provisional, end=end.end)
        | checks.as_summary(_whole(run) if checks.is_reliable else None)
        | (Summary(shocks=shock_rows(results, thresholds)) if results.shocks else Summary())
        | bonds(results)
        | cracked_stones(results)
        | crushing(results)
    )


def _whole(run: Measured) -> dict[str, Any] | None:
    """The damage of the structure as a whole at the end; None of groups that no table of parts can have."""
    if not can_be_graded(run.results.blocks):
        return None
    return part_damage(run.results, run.settings, np.array([run.results.frames - 1])).parts[-1]


def in_short(parts: Sequence[Row]) -> tuple[PartInShort, ...]:
    """The columns of damage.csv that go into a summary."""
    return tuple(PartInShort(**{key: row[key] for key in PartInShort.model_fields}) for row in parts)
