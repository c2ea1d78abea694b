# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints in the state at rest about which a run vibrates: what is left of them.

A dry joint bears only where it is pressed together. Where the weight leaves it open, or lets it gape, it has no stiffness there: the run
swings slower than the linear model, which takes every joint as closed. A contact acts where it is bonded or pressed; each has the area that
its springs act by, so the share of the area that acts is the share of the normal and tangential stiffness that is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.quantities import counted
from masonry_cd.mechanics.contact.find_joints import find_joints, joint_parts
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

PRESSED = 1e-6  # normal impulse from which on a contact acts, as a share of the largest: below lies what solving leaves
CLOSED = 0.999  # share of the area from which on a joint counts as closed
LISTED = 12  # joints that are named, those with the least left


class JointAtRest(NamedTuple):
    """A joint, and what is left of it."""

    joint: int
    block_a: str
    block_b: str
    area: float  # [m2]
    share_left: float  # of the area that acts
    points_left: int
    points: int

    @property
    def line(self) -> str:
        """As text."""
        state = "open" if self.share_left == 0.0 else f"{100 * self.share_left:.0f} % of its area left"
        return f'  joint {self.joint}, "{self.block_a}" and "{self.block_b}": {state}, {self.points_left} of {self.points} contact points'


def joints_at_rest(machine: Stepper) -> list[JointAtRest]:
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
    pairs = ((assembly.names[int(a)], assembly.names[int(b)]) for a, b in zip(joints.block_a, joints.block_b, strict=True))
    numbers = zip(joints.area.tolist(), share.tolist(), points.tolist(), count.tolist(), strict=True)
    return [JointAtRest(j, *pair, *four) for j, (pair, four) in enumerate(zip(pairs, numbers, strict=True))]


def at_rest_summary(rows: Sequence[JointAtRest]) -> dict[str, Any]:
    """How many joints are open or partly so, and the share of the stiffness of all of them that is left, for JSON."""
    area = sum(row.area for row in rows)
    return {
        "joints": len(rows),
        "open": sum(row.share_left == 0.0 for row in rows),
        "partly": sum(0.0 < row.share_left < CLOSED for row in rows),
        "share_left": sum(row.area * row.share_left for row in rows) / area if area else 1.0,
        "not_closed": [row._asdict() for row in rows if row.share_left < CLOSED],
    }


def at_rest_lines(found: dict[str, Any]) -> list[str]:
    """Joints that are not closed, as text; nothing where all are."""
    if not found["not_closed"]:
        return []
    joints, left = counted(found["joints"], "joint"), f"{100 * found['share_left']:.0f} %"
    lines = [
        f"at rest under the weight {found['open']} of {joints} are open and {found['partly']} are only partly in contact: {left} of the "
        "stiffness of all joints is left. The linear model takes all of it, so the run swings slower; for the frequencies of a structure "
        "that is not cracked give its joints cohesion, or add what presses them together"
    ]
    worst = sorted((JointAtRest(**row) for row in found["not_closed"]), key=lambda row: (row.share_left, row.joint))
    lines += [row.line for row in worst[:LISTED]]
    more = len(worst) - LISTED
    return [*lines, *([f"  and {more} more, all in vibration.json"] if more > 0 else [])]
