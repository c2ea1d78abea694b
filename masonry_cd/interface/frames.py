# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames as labelled arrays: those of a run, or of a simulation that keeps them in memory as it goes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.app.measured_joints import MeasuredJoints
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.app.recorder import frame_rows
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joints import JointMeasures, Joints

if TYPE_CHECKING:
    from xarray import Dataset

REACTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
JOINTS = {"opening": "m", "sliding": "m", "rotation": "rad", "contact_area": "m2", "normal_force": "N", "shear_force": "N"}
OF_BLOCK, OF_JOINT = ("time", "block"), ("time", "joint")
VARIABLES = {  # dimensions and unit of each
    "position": ((*OF_BLOCK, "axis"), "m"),
    "orientation": ((*OF_BLOCK, "quaternion"), ""),
    "velocity": ((*OF_BLOCK, "velocity_component"), "m/s, rad/s"),
    **{name: (OF_JOINT, unit) for name, unit in JOINTS.items()},
    "force": ((*OF_JOINT, "axis"), "N"),
    "reaction": (("time", "support", "reaction_component"), "N, N m"),
}


def dataset(arrays: Mapping[str, np.ndarray], blocks: Sequence[Block], joints: Joints, about: Mapping[str, str]) -> Dataset:
    """A Dataset of xarray over time, block, joint and support, of arrays (F, ...) by the names of VARIABLES and the times (F,) [s]."""
    import xarray

    names = [block.name for block in blocks]
    variables = {name: (axes, arrays[name], {"units": unit} if unit else {}) for name, (axes, unit) in VARIABLES.items() if name in arrays}
    where: dict[str, Any] = {
        "time": ("time", arrays["time"], {"units": "s"}),
        "block": names,
        "joint": np.arange(joints.count),
        "support": [block.name for block in blocks if block.fixed],
        "axis": list("xyz"),
        "quaternion": list("wxyz"),
        "velocity_component": ["vx", "vy", "vz", "wx", "wy", "wz"],
        "reaction_component": list(REACTIONS),
        "block_a": ("joint", [names[b] for b in joints.block_a]),
        "block_b": ("joint", [names[b] for b in joints.block_b]),
        "area": ("joint", joints.area, {"units": "m2"}),
    }
    return xarray.Dataset(variables, where, dict(about))


class Frames:
    """Frames of a stepper, kept as it steps: the first is the current one. What a run writes of joints counts from where they have settled.

    Args:
        stepper: of the simulation.
        joints: as built.
        every: steps of length dt between two frames.
    """

    def __init__(self, stepper: Stepper, joints: Joints, every: int) -> None:
        self._joints, self._every, self._pair_joints = joints, every, PairJoints(stepper.assembly)
        self._rows: dict[str, list[Any]] = {name: [] for name in ("time", *VARIABLES)}
        self._measured, self._supports = MeasuredJoints(stepper, joints, changes=True), stepper.assembly.fixed
        self._take(stepper, self._measured.now())

    def after_step(self, stepper: Stepper, done: bool) -> None:
        """Keep a frame where one is due, or the run has ended. Joints are measured each step: those of blocks put in count again."""
        now = self._measured.now()
        if done or stepper.motion.ticks % self._every == 0:
            self._take(stepper, now)

    def dataset(self, blocks: Sequence[Block], about: Mapping[str, str]) -> Dataset:
        """Return the frames kept so far."""
        return dataset({name: np.array(rows) for name, rows in self._rows.items()}, blocks, self._joints, about)

    def _take(self, stepper: Stepper, now: JointMeasures) -> None:
        rows, _ = frame_rows(stepper, self._joints, now, self._pair_joints.of(stepper.detector.pairs), self._supports)
        for name, kept in self._rows.items():
            kept.append(np.array(rows[name] if name in rows else rows[f"joints/{name}"]))
