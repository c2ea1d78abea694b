# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that go on until their blocks are still: how slow that is, and the rest behind the loads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from masonry_cd.app import time_step_checks
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.pauses import HOLD, STILL
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from loads import Loading

CORNERS = 4.0  # contacts of a joint


def still_speed(settings: Run, joints: Joints) -> float:
    """Below which a block counts as still at the end of a run: STILL, or what the tolerance resolves, should that be more [m/s]."""
    return max(
        STILL, time_step_checks.resolved_speed(settings.tolerance, math.hypot(*settings.gravity), settings.dt, CORNERS * joints.count)
    )


def until_still(scene: Scene, loading: Loading, still: float) -> Loading:
    """The loads, with a rest behind them where the run is to go on until its blocks are still.

    Raises:
        InputError: that is requested, and the base still moves when the duration ends.
    """
    from loads.rest import base_moves_at_end, with_rest

    settings = scene.run
    if not scene.until_still:
        return loading
    if base_moves_at_end(loading):
        if settings.until_still:
            raise InputError("run.until_still", f"the base still moves when run.duration, {settings.duration:g} s, ends; make it longer")
        return loading
    return with_rest(loading, settings.most_steps - settings.steps, still, max(1, math.ceil(HOLD / settings.dt)))
