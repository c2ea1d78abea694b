# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that a checkpoint fits the run of a scene, made before any of it reaches a compiled kernel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from masonry_cd.analysis.damage.step_peaks import UNKNOWN, shapes
from masonry_cd.app.run_report import RunReport
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.layout import JOINT_PEAKS
from masonry_cd.mechanics.dynamics.adaptive import AdaptiveSteps
from masonry_cd.mechanics.dynamics.element_stress import elements_of
from masonry_cd.mechanics.dynamics.mean_stress import check_sums
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.snapshot import part
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joints import JointMeasures

if TYPE_CHECKING:
    from masonry_cd.app.events import Events

NUMBERS = {"frames": int, "quiet": int, "mark": str, "rows": dict, "report": dict, "format": int}


class KeptArrays(NamedTuple):
    """Sizes and names of the arrays that a run keeps besides its motion."""

    blocks: Sequence[Block]  # as results have them, whose drifts
    joints: int  # J, whose peaks
    stress: bool  # that of blocks and joints
    rest: bool  # the measures of the joints from which others count


def check_content(
    arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any], stepper: Stepper, kept: KeptArrays, events: Events | None = None
) -> None:
    """Check the content of a checkpoint, in whose stage the stepper is then.

    Args:
        arrays: of the checkpoint.
        numbers: of the checkpoint.
        stepper: of the scene.
        kept: what the run keeps.
        events: that change the model of the stepper.

    Raises:
        InputError: names what is not so.
    """
    for name, kind in NUMBERS.items():
        if not isinstance(numbers.get(name), kind) or (kind is int and not 0 <= numbers[name] < 2**53):
            raise InputError(name, "not what a run leaves")
    rows = numbers["rows"]
    if not all(isinstance(count, int) and 0 <= count < 2**53 for count in rows.values()):
        raise InputError("rows", "not what a run leaves")
    report = RunReport.read(numbers["report"])
    position = arrays.get("position")
    if position is not None and position.ndim == 2 and len(position) != stepper.assembly.count:
        raise InputError("", f"made by another structure ({len(position)} blocks); resume with the scene of that run")
    stored, joints = Stored(arrays), kept.joints
    if events is not None:
        events.restore(stored.part("events"), part("events", arrays))
    stepper.check(stored)
    peaks = stored.part("peaks")
    for name in (*JOINT_PEAKS, "_area"):
        peaks.real(name, joints, finite=name != "first_opening_time")
    peaks.check_all_read()
    _check_step_peaks(stored.part("step_peaks"), kept)
    if kept.rest:
        rest = stored.part("rest")
        for measure in fields(JointMeasures):
            rest.real(measure.name, joints)
        rest.check_all_read()
    if kept.stress:
        check_sums(stored.part("stress"), stepper.assembly.count, joints, elements_of(stepper.system.strains))
    if stepper.settings.is_adaptive:
        AdaptiveSteps(stepper).check(stored.part("pace"))
    stored.check_all_read()
    steps = int(arrays["steps"][0])
    if (rows.get("step_time"), rows.get("time"), report.steps) != (steps, numbers["frames"], steps):
        raise InputError("counts other steps than the results next to it", "the run cannot be resumed")


def _check_step_peaks(stored: Stored, kept: KeptArrays) -> None:
    """Check the largest drifts, displacements and hinges."""
    for name, shape in shapes(kept.blocks, kept.joints).items():
        values = stored.real(name, *shape, finite=name not in UNKNOWN)
        if np.isinf(values).any():
            stored.refuse(name, "not finite")
    stored.check_all_read()
