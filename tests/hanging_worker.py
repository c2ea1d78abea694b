# SPDX-License-Identifier: GPL-3.0-or-later
"""Loaded by workers of a test as they start: the set-up of some scenes never ends there."""

from __future__ import annotations

from threading import Event
from typing import Any

import studied

from masonry_cd.app import case
from masonry_cd.app.scene import Scene


def dask_setup(worker: Any) -> None:
    """Have `prepare` hang for the scenes whose first load has the amplitude HANGING."""
    prepare = case.prepare

    def hanging(scene: Scene, structure: case.BuiltStructure | None = None) -> case.Case:
        if scene.loads[0]["amplitude"] == studied.HANGING:
            Event().wait()
        return prepare(scene, structure)

    case.prepare = hanging
