"""The damage joint by joint in files: joints.csv, and its share of summary.json."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_cd.analysis.damage import joint_damage
from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import EndState, end_state
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.verdict import verdict_on
from masonry_cd.io.results import Results
from reports.settings import Report
from reports.ties import write_ties


def thresholds_of(settings: Report) -> Thresholds:
    """What counts as damage."""
    return Thresholds(opened=settings.opened, slid=settings.slid)


def write_joint_damage(results: Results, folder: Path, settings: Report) -> dict[str, Any]:
    """Write joints.csv, and ties.csv where there are ties; return the numbers of damage for the summary, see :func:`damage_numbers`."""
    thresholds = thresholds_of(settings)
    table = joint_damage.joint_damage(results, thresholds)
    end = end_state(results, thresholds)
    joint_damage.write_joints_csv(table, folder / "joints.csv", end.provisional)
    write_ties(results, folder)
    return damage_numbers(results, table, end, thresholds)


def damage_numbers(results: Results, table: JointDamage, end: EndState, thresholds: Thresholds) -> dict[str, Any]:
    """The numbers of damage for a summary, those after each shock of a sequence among them."""
    fallen = joint_damage.collapsed_blocks(results, thresholds)
    return (
        joint_damage.summary(table)
        | {
            "blocks": len(results.blocks),
            "joints": results.joints.count,
            "collapsed_blocks": len(fallen),
            "collapsed_block_names": list(fallen),
            "displacement_max": joint_damage.displacement_max(results),
            "opening_max": float(table.max_opening.max(initial=0.0)),
            "sliding_max": float(table.max_sliding.max(initial=0.0)),
        }
        | end.as_summary()
        | verdict_on(results, thresholds, end).as_summary()
        | ({"shocks": joint_damage.shock_rows(results, thresholds)} if results.shocks else {})
        | joint_damage.bonds(results)
    )
