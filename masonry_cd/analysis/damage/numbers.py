"""The damage of a run in numbers: its share of summary.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.analysis.damage import joint_damage
from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.macro_elements import can_be_graded
from masonry_cd.analysis.damage.part_damage import Settings, part_damage
from masonry_cd.analysis.damage.verdict import checks_of
from masonry_cd.io.results import Results


def damage_numbers(results: Results, table: JointDamage, end: EndState, settings: Settings) -> dict[str, Any]:
    """The numbers of damage for a summary, the verdict and those after each shock of a sequence among them."""
    thresholds = settings.thresholds
    fallen = joint_damage.collapsed_blocks(results, thresholds)
    numbers = joint_damage.summary(table) | {
        "blocks": len(results.blocks),
        "joints": results.joints.count,
        "collapsed_blocks": len(fallen),
        "collapsed_block_names": list(fallen),
        "displacement_max": joint_damage.displacement_max(results),
        "opening_max": float(table.max_opening.max(initial=0.0)),
        "sliding_max": float(table.max_sliding.max(initial=0.0)),
    }
    checks = checks_of(results.closing | numbers, thresholds, end)
    return (
        numbers
        | end.as_summary()
        | checks.as_summary(_whole(results, settings) if checks.reliable else None)
        | ({"shocks": joint_damage.shock_rows(results, thresholds)} if results.shocks else {})
        | joint_damage.bonds(results)
    )


def _whole(results: Results, settings: Settings) -> dict[str, Any] | None:
    """The damage of the structure as a whole at the end; None of groups that no table of parts can have."""
    if not can_be_graded(results.blocks):
        return None
    return part_damage(results, settings, np.array([results.frames - 1])).parts[-1]
