# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings and slips of the joints of a stepper, counted from their rest; those of an absent block are as built."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.dynamics.equilibrium import settles
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.joints import JointMeasures, Joints, measure_joints


class MeasuredJoints:
    """Measures the joints of a stepper.

    Args:
        stepper: at the start of its run.
        joints: of its blocks as built.
        changes: blocks may come and go.
    """

    def __init__(self, stepper: Stepper, joints: Joints, changes: bool) -> None:
        self._stepper, self._joints, self._absent = stepper, joints, stepper.assembly.absent
        # what opened before the run, or before a block was put in, is not damage
        self.rest = self._measured() if changes or settles(stepper.assembly) else None

    def restore(self, rest: JointMeasures) -> None:
        """Go on from the rest of a checkpoint, in whose stage the stepper is."""
        self.rest, self._absent = rest, self._stepper.assembly.absent

    def now(self) -> JointMeasures:
        """The measures of the joints."""
        found = self._measured()
        if self.rest is None:
            return found
        absent = self._stepper.assembly.absent
        if absent is not self._absent:
            self._take_in(found, absent)
        now = found.since(self.rest, self._joints.area)
        return now if absent is None else now.but(self._with_one_of(absent), self._joints.area)

    def _measured(self) -> JointMeasures:
        return measure_joints(self._joints, self._stepper.assembly, self._stepper.state)

    def _take_in(self, found: JointMeasures, absent: np.ndarray | None) -> None:
        """Measure joints of blocks that have been put in from how they are found now."""
        assert self.rest is not None
        none = np.zeros(self._stepper.assembly.count, dtype=bool)
        before, after = none if self._absent is None else self._absent, none if absent is None else absent
        came = self._with_one_of(before) & ~self._with_one_of(after)
        self.rest = JointMeasures(**{name: np.where(came, values, vars(self.rest)[name]) for name, values in vars(found).items()})
        self._absent = absent

    def _with_one_of(self, blocks: np.ndarray) -> np.ndarray:
        """(J,) joints of which one of the blocks (B,) bool is a side."""
        return np.asarray(blocks[self._joints.block_a] | blocks[self._joints.block_b])
