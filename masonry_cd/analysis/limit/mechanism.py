# SPDX-License-Identifier: GPL-3.0-or-later
r"""The mechanism of a limit analysis: how blocks move, and what that does to each joint.

Velocities are over the largest one of any corner of a free block. In a joint, u_n and u_t are those of its corners; it

    slides     where | u_t | of the corner that opens least is above STILL
    hinges     where the corners open by amounts that differ by more than STILL, or blocks turn that touch along a line only
    opens      where all corners open by more than STILL beyond what associated sliding lifts them, mu | u_t |
    crushes    where a corner closes by more than STILL, whatever else the joint does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

STILL = 1e-4  # share of the largest velocity below which nothing moves
BED = 0.5  # vertical component of a joint's normal from which on one block rests on the other
STATES = ("still", "hinge", "slide", "hinge and slide", "open")


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Velocities of B blocks and of J joints, over the largest of any corner: of length one, angular velocities per metre."""

    velocity: np.ndarray  # (B, 6)
    speed: np.ndarray  # (B,) largest of the block's corners
    opening: np.ndarray  # (J,) largest of the joint's corners
    least_opening: np.ndarray  # (J,)
    sliding: np.ndarray  # (J,) at the corner that opens least
    rotation: np.ndarray  # (J,) relative angular velocity [1/m]
    hinge: np.ndarray  # (J, 3) the corners that open least, their mean [m]
    state: np.ndarray  # (J,) index into STATES
    closing: np.ndarray  # (J,) largest of the joint's corners; zero of joints that do not crush

    @property
    def moving(self) -> np.ndarray:
        """(B,) blocks that move."""
        return self.speed > STILL

    @property
    def crushing(self) -> np.ndarray:
        """(J,) joints that crush."""
        return self.closing > STILL

    def stones(self, joints: Joints) -> int:
        """How many blocks of one course slide by themselves, none of which turns; none of another mechanism."""
        moving, works = self.moving, self.state > 0
        stacked = moving[joints.block_a] & moving[joints.block_b] & (np.abs(joints.normal[:, 2]) > BED)
        slides = np.isin(self.state[works], [STATES.index("slide"), STATES.index("open")])
        turns = self.rotation[works] > STILL
        return int(moving.sum()) if works.any() and slides.all() and not turns.any() and not stacked.any() else 0

    def count(self, state: str) -> int:
        """How many joints are in a state."""
        return int((self.state == STATES.index(state)).sum())


def mechanism(problem: LimitProblem, assembly: Assembly, joints: Joints, unknowns: np.ndarray) -> Mechanism:
    """The mechanism that belongs to velocities (unknowns,) of a problem."""
    velocity = problem.block_velocity(unknowns, assembly.count)
    speed = _corner_speeds(assembly, velocity)
    largest = max(float(speed.max(initial=0.0)), 1e-300)
    moved = problem.point_velocity(unknowns) / largest
    velocity, speed = velocity / largest, speed / largest
    joint, normal = problem.points.joint, moved[:, 0]
    slip = np.linalg.norm(moved[:, 1:], axis=1)
    most, least = np.full(joints.count, -np.inf), np.full(joints.count, np.inf)
    np.maximum.at(most, joint, normal)
    np.minimum.at(least, joint, normal)
    lowest = normal <= least[joint] + STILL
    sliding = np.zeros(joints.count)
    np.maximum.at(sliding, joint[lowest], slip[lowest])
    weight = np.bincount(joint[lowest], minlength=joints.count)
    place = [np.bincount(joint[lowest], part[lowest], minlength=joints.count) for part in problem.points.point.T]
    turning = velocity[joints.block_b, 3:] - velocity[joints.block_a, 3:]
    mu = np.zeros(joints.count)
    mu[joint] = problem.mu
    spin = np.linalg.norm(turning, axis=1)
    lines = (joints.area == 0.0) & (problem.length * spin > STILL)  # joints of one edge or corner, in moved structures
    hinges, slides = (most - least > STILL) | lines, sliding > STILL
    opens = least > STILL + 1.001 * mu * sliding
    state = np.where(opens, 4, np.where(hinges & slides, 3, np.where(slides, 2, np.where(hinges, 1, 0))))
    return Mechanism(
        velocity=velocity, speed=speed, opening=np.maximum(most, 0.0), least_opening=np.maximum(least, 0.0), sliding=sliding,
        rotation=spin, hinge=np.stack(place, axis=1) / np.maximum(weight, 1)[:, None], state=state,
        closing=np.maximum(-least, 0.0) if problem.sections is not None else np.zeros(joints.count),
    )  # fmt: skip


def _corner_speeds(assembly: Assembly, velocity: np.ndarray) -> np.ndarray:
    """Largest speed of a corner of each block, (B,); supports have none."""
    corners = np.concatenate([block.vertices for block in assembly.blocks])
    owner = np.repeat(np.arange(assembly.count), [len(block.vertices) for block in assembly.blocks])
    arm = corners - assembly.centre[owner]
    speed = np.linalg.norm(velocity[owner, :3] + np.cross(velocity[owner, 3:], arm), axis=1)
    out = np.zeros(assembly.count)
    np.maximum.at(out, owner, speed)
    return out
