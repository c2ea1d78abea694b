# SPDX-License-Identifier: GPL-3.0-or-later
"""The results, the summary, and the tables of damage, ties, pushes and gauges."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from reports.files import Job, Output, never

DAMAGE = {
    "damage.csv": "every part: counts, largest and final values, drift, mechanism, grade with its reason",
    "damage_history.csv": "every part over time",
    "hinges.csv": "joints that were hinges, and where they touched",
    "drift.csv": "displacement and drift of every part, level by level",
    "damage_shocks.csv": "every part after each shock",
    "damage.json": "the tables of damage in one document, with all thresholds",
}


def _write_damage(job: Job) -> Iterable[Path]:
    """Write the damage by part, and its short form in the summary."""
    from masonry_cd.analysis.outputs.measured import in_short
    from masonry_cd.io.summary import Summary
    from reports.damage import write_part_damage

    if job.settings.damage:
        job.summary |= Summary(parts=in_short(job.damage.parts))
    return write_part_damage(job.damage, job.folder)


OUTPUTS = {
    "run": Output(
        {
            "result.h5": "all that the run recorded, frame by frame and step by step, with its blocks and its scene",
            "joints.csv": "every joint: largest and final opening and sliding, rotation, contact lost, state",
            "summary.json": "the results in numbers, with the verdict near the top",
            "ties.csv": "every tie: largest tension with its time, final tension, time of first yield",
        },
        asked=never,
        carried=("joints.csv",),
    ),
    "damage": Output(DAMAGE, _write_damage, place=10, carried=tuple(name for name in DAMAGE if name.endswith(".csv"))),
    "laboratory": Output(
        {
            "force_displacement.csv": "every push by displacement, step by step: displacement, reaction, remaining inertia",
            "push_cycles.csv": "every cycle of a push: dissipated energy, equivalent damping",
            "force_displacement.png": "the curves of pushes by displacement",
            "points.csv": "the motion of the points that the scene watches",
            "joint_gauges.csv": "the joints that the scene watches: opening, slip, forces, compressed depth",
            "cracks.csv": "the gauges between two points that the scene names",
            "supports.csv": "the reaction of every support over time",
            "gauges.png": "the histories of watched points, joints and gauges",
        },
        asked=never,
    ),
}
