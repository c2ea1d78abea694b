"""The damage of a run in numbers: its share of summary.json."""

from __future__ import annotations

from typing import Any

from masonry_cd.analysis.damage import joint_damage
from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.verdict import verdict_of
from masonry_cd.io.results import Results


def damage_numbers(results: Results, table: JointDamage, end: EndState, thresholds: Thresholds) -> dict[str, Any]:
    """The numbers of damage for a summary, those after each shock of a sequence among them."""
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
    return (
        numbers
        | end.as_summary()
        | verdict_of(results.closing | numbers, thresholds, end).as_summary()
        | ({"shocks": joint_damage.shock_rows(results, thresholds)} if results.shocks else {})
        | joint_damage.bonds(results)
    )
