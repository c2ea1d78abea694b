# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left of the joints in the state at rest about which a run vibrates.

A dry joint bears only where it is pressed together. Where the weight leaves it open, or lets it gape, it has no stiffness there: the run
swings slower than the linear model, which takes every joint as closed. A contact acts where it is bonded or pressed; each has the area that
its springs go by, so the share of the area that acts is the share of the normal and tangential stiffness that is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.foundation.quantities import counted
from masonry_cd.mechanics.contact.find_joints import find_joints, joint_parts
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

PRESSED = 1e-6  # normal impulse from which on a contact acts, as a share of the largest: below lies what solving leaves
CLOSED = 0.999  # share of the area from which on a joint counts as closed
LISTED = 12  # joints that are named in words, those with the least left


def joints_at_rest(machine: Stepper) -> list[dict[str, Any]]:
    """Each joint of a stepper that has settled: its blocks, the share of its area that acts, and how many of its points do.

    Args:
        machine: at rest, with elastic joints.
    """
    assembly, made = machine.assembly, machine.last
    joints = find_joints(assembly)
    place = {(a, b): j for j, (a, b) in enumerate(joint_parts(assembly).tolist())}
    area, count = np.zeros(joints.count), np.zeros(joints.count, dtype=np.int64)
    points = np.zeros_like(count)
    if made is not None and made.springs is not None:
        of_pair = np.array([place.get((a, b), -1) for a, b in machine.detector.pairs.tolist()], dtype=np.int64)
        active, joint_of = made.rows.active, of_pair[made.found.pair]
        count = np.bincount(joint_of[joint_of >= 0], minlength=joints.count)  # those that gape are among them, until they lie far apart
        joint = joint_of[active]
        normal = machine.solution.impulse[:, 0]
        acts = (normal > PRESSED * normal.max(initial=0.0)) | machine.motion.joints.bonded[active].astype(bool)
        acts &= joint >= 0
        np.add.at(area, joint[acts], made.springs.area[acts])
        np.add.at(points, joint[acts], 1)
    share = np.minimum(1.0, area / joints.area)
    return [
        {
            "joint": j,
            "block_a": assembly.names[int(joints.block_a[j])],
            "block_b": assembly.names[int(joints.block_b[j])],
            "area": float(joints.area[j]),
            "share_left": float(share[j]),
            "points_left": int(points[j]),
            "points": int(count[j]),
        }
        for j in range(joints.count)
    ]


def at_rest_summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """How many joints are open or partly so, and the share of the stiffness of all of them that is left, for JSON."""
    area = sum(row["area"] for row in rows)
    return {
        "joints": len(rows),
        "open": sum(row["share_left"] == 0.0 for row in rows),
        "partly": sum(0.0 < row["share_left"] < CLOSED for row in rows),
        "share_left": sum(row["area"] * row["share_left"] for row in rows) / area if area else 1.0,
        "not_closed": [row for row in rows if row["share_left"] < CLOSED],
    }


def at_rest_lines(found: dict[str, Any]) -> list[str]:
    """Joints that are not closed, in words; nothing where all are."""
    if not found["not_closed"]:
        return []
    joints, left = counted(found["joints"], "joint"), f"{100 * found['share_left']:.0f} %"
    lines = [
        f"at rest under the weight {found['open']} of {joints} are open and {found['partly']} are only partly in contact: {left} of the "
        "stiffness of all joints is left. The linear model takes all of it, so the run swings slower; for the frequencies of a structure "
        "that is not cracked give its joints cohesion, or add what presses them together"
    ]
    worst = sorted(found["not_closed"], key=lambda row: (row["share_left"], row["joint"]))
    for row in worst[:LISTED]:
        state = "open" if row["share_left"] == 0.0 else f"{100 * row['share_left']:.0f} % of its area left"
        points = f"{row['points_left']} of {row['points']} contact points"
        lines.append(f'  joint {row["joint"]}, "{row["block_a"]}" and "{row["block_b"]}": {state}, {points}')
    more = len(worst) - LISTED
    return [*lines, *([f"  and {more} more, all in vibration.json"] if more > 0 else [])]
