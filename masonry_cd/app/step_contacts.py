# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of the last step of a stepper as arrays, and what they add up to at joints and supports."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.step_problem import StepProblem


@dataclass(frozen=True, eq=False)
class Contacts:
    """C contacts of a step, where they were in its middle. World frame unless said otherwise.

    In a scene that is solved in its plane each stands for its mirror image as well: points lie in the plane, forces are those of both.

    Attributes:
        blocks: (C, 2) numbers of the first and the second block.
        joint: (C,) number of the joint that it belongs to, -1 where the blocks had none as built.
        point: (C, 3) [m].
        frame: (C, 3, 3) rows n, t1, t2: unit vectors, n from the second block to the first.
        gap: (C,) [m], negative where the blocks overlap or a spring is shortened.
        impulse: (C, 3) over the step along n, t1 and t2 [N s].
        force: (C, 3) mean over the step, on the first block [N]; its opposite acts on the second.
        velocity: (C, 3) of the first block relative to the second along n, t1 and t2, at the end of the step [m/s].
        slip: (C, 2) along t1 and t2 over the step, by that velocity [m].
    """

    blocks: np.ndarray
    joint: np.ndarray
    point: np.ndarray
    frame: np.ndarray
    gap: np.ndarray
    impulse: np.ndarray
    force: np.ndarray
    velocity: np.ndarray
    slip: np.ndarray

    def __len__(self) -> int:
        return len(self.gap)

    def of_joints(self, joints: int) -> np.ndarray:
        """The force of each of J joints on its block b, (J, 3) [N]: its opposite acts on block a."""
        out = np.zeros((joints, 3))
        on = self.joint >= 0
        np.add.at(out, self.joint[on], self.force[on])
        return out

    def wrenches(self, centre: np.ndarray) -> np.ndarray:
        """Force [N] and moment [N m] of all contacts on each block about a place of its own (B, 3) [m], (B, 6)."""
        out = np.zeros((len(centre), 6))
        for side, sign in ((0, 1.0), (1, -1.0)):
            block, force = self.blocks[:, side], sign * self.force
            np.add.at(out, block, np.concatenate([force, np.cross(self.point - centre[block], force)], axis=1))
        return out


def contacts_of(stepper: Stepper, pair_joint: np.ndarray) -> Contacts:
    """The contacts of the last step; none before the first. ``pair_joint`` (P,) is the joint of each pair of the detector or -1."""
    made = stepper.last
    if made is None:
        none = np.zeros((0, 3))
        whole = np.zeros(0, dtype=np.int64)
        return Contacts(np.zeros((0, 2), dtype=np.int64), whole, none, np.zeros((0, 3, 3)), none[:, 0], none, none, none, none[:, :2])
    rows, constants, m = made.rows, stepper.system.constants, made.problem.dimension
    point = made.found.point[rows.active].copy()
    if constants.plane_axis >= 0:
        point[:, constants.plane_axis] = constants.plane_at
    impulse, velocity = np.zeros((len(rows.gap), 3)), np.zeros((len(rows.gap), 3))
    impulse[:, :m], velocity[:, :m] = stepper.solution.impulse, _relative_velocity(stepper, made)
    step = stepper.motion.span * stepper.settings.dt
    return Contacts(
        blocks=rows.blocks.copy(),
        joint=pair_joint[rows.pair],
        point=point,
        frame=rows.frame.copy(),
        gap=rows.gap.copy(),
        impulse=impulse,
        force=np.einsum("ci,cij->cj", impulse, rows.frame) / step,
        velocity=velocity,
        slip=step * velocity[:, 1:],
    )


def _relative_velocity(stepper: Stepper, made: StepProblem) -> np.ndarray:
    """(C, m) at the end of the last step, without what a gap over the step or a spring adds in the law [m/s]."""
    rows, step = made.rows, stepper.motion.span * stepper.settings.dt
    offset = rows.offset.copy()
    offset[:, 0] -= np.maximum(rows.gap, 0.0) / step
    return replace(made.problem, offset=offset).relative_velocity(stepper.motion.v)


def reactions_of(stepper: Stepper, contacts: Contacts) -> np.ndarray:
    """Force [N] and moment [N m] of each support on what it carries, (B, 6), zero for free blocks; means over the last step.

    Moments are about the centre of mass of the support. Ties that end at a support take part, and springs on which a footing stands.
    """
    made, fixed = stepper.last, stepper.assembly.fixed
    if made is None:
        return np.zeros((len(fixed), 6))
    taken = contacts.wrenches(made.predicted.state.position)
    acting, founded = made.predicted.acting, made.predicted.founded
    if acting is not None:
        taken += acting.wrench(len(fixed))
    if founded is not None:
        taken -= founded.reactions(stepper.motion.v, len(fixed)) / (stepper.motion.span * stepper.settings.dt)
    if stepper.assembly.links_there:
        np.add.at(taken, np.array([link.blocks for link in stepper.assembly.links_there]), _link_wrenches(stepper, made))
    return np.where(fixed[:, None], -taken, 0.0)


@dataclass(frozen=True, eq=False)
class LinkForce:
    """Force, moment and error of a link over the last step, world frame.

    Attributes:
        kind: hinge, slider or rigid.
        blocks: names of its first and its second block.
        point: (3,) where it was in the middle of the step [m].
        force: (3,) mean over the step, on the first block [N]; its opposite acts on the second.
        moment: (3,) on the first block about the point [N m].
    """

    kind: str
    blocks: tuple[str, str]
    point: np.ndarray
    force: np.ndarray
    moment: np.ndarray


def links_of(stepper: Stepper) -> list[LinkForce]:
    """Return the forces of the links over the last step, in the order of the scene; empty before the first step.

    Where more is held than the motions need, as by two hinges on one axis, forces are not unique: they are those of the least links.
    """
    made, names, out = stepper.last, stepper.assembly.names, list[LinkForce]()
    if made is None or not stepper.assembly.links_there:
        return out
    state, rotation = made.predicted.state, made.predicted.rotation
    for link, wrench in zip(stepper.assembly.links_there, _link_wrenches(stepper, made)[:, 0], strict=True):
        first, second = link.blocks
        arm = rotation[first] @ (link.point - stepper.assembly.centre[first])
        moment = wrench[3:] - np.cross(arm, wrench[:3])
        out.append(LinkForce(link.kind, (names[first], names[second]), state.position[first] + arm, wrench[:3], moment))
    return out


def _link_wrenches(stepper: Stepper, made: StepProblem) -> np.ndarray:
    """Force [N] and moment about its centre [N m] of each link on both of its blocks, (L, 2, 6), over the last step."""
    linked, step = made.predicted.linked, stepper.motion.span * stepper.settings.dt
    assert linked is not None
    given = made.link_impulse(stepper.solution.impulse, stepper.motion.v)
    return np.asarray(linked.wrenches(linked.multipliers(given)) / step)
