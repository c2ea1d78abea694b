# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage of a run in numbers: its share of summary.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.damage import joint_damage
from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.macro_elements import can_be_graded
from masonry_cd.analysis.damage.part_damage import Row, part_damage
from masonry_cd.analysis.damage.verdict import checks_of
from masonry_cd.analysis.outputs import SUMMARY, values_in
from masonry_cd.analysis.outputs.measured import Measured

SHORT = (
    "part", "blocks", "joints", "grade", "grade_label", "grade_reason", "mechanism", "opened", "slid", "separated", "lost_blocks",
    "max_opening", "max_sliding", "residual_opening", "residual_sliding", "residual_drift", "only_opened", "only_slid", "opened_and_slid",
    "provisional",
)  # fmt: skip


def damage_numbers(run: Measured, end: EndState) -> dict[str, Any]:
    """The numbers of damage for a summary, the verdict and those after each shock of a sequence among them."""
    results, thresholds = run.results, run.settings.thresholds
    numbers = joint_damage.summary(run.table) | {
        "blocks": len(results.blocks),
        "joints": results.joints.count,
        "collapsed_blocks": len(run.fallen),
        "collapsed_block_names": list(run.fallen),
        **values_in(SUMMARY, run),
    }
    checks = checks_of(results.closing | numbers, thresholds, end)
    return (
        numbers
        | end.as_summary()
        | checks.as_summary(_whole(run) if checks.reliable else None)
        | ({"shocks": joint_damage.shock_rows(results, thresholds)} if results.shocks else {})
        | joint_damage.bonds(results)
        | joint_damage.crushing(results)
    )


def _whole(run: Measured) -> dict[str, Any] | None:
    """The damage of the structure as a whole at the end; None of groups that no table of parts can have."""
    if not can_be_graded(run.results.blocks):
        return None
    return part_damage(run.results, run.settings, np.array([run.results.frames - 1])).parts[-1]


def in_short(parts: Sequence[Row]) -> list[Row]:
    """The columns of damage.csv that go into a summary."""
    return [{key: row[key] for key in SHORT} for row in parts]
