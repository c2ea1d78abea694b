# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage of a run in numbers: its share of summary.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import bonds, crushing, joint_counts, shock_rows
from masonry_cd.analysis.damage.macro_elements import can_be_graded
from masonry_cd.analysis.damage.part_damage import Row, part_damage
from masonry_cd.analysis.damage.verdict import checks_of
from masonry_cd.analysis.outputs import SUMMARY, values_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import PartInShort


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
        | end.as_summary()
        | checks.as_summary(_whole(run) if checks.reliable else None)
        | (Summary(shocks=shock_rows(results, thresholds)) if results.shocks else Summary())
        | bonds(results)
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
