# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of simulations and their checkpoints: what all later steps depend on, but for what functions of Python remember."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np

from masonry_cd.app.advance import Advance
from masonry_cd.app.beginning import pauses_of
from masonry_cd.app.case import Case
from masonry_cd.app.changes import read_changes
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.signatures import require_picklable
from masonry_cd.interface.events import EventCallbacks
from masonry_cd.interface.joint_law import BoundLaw
from masonry_cd.interface.model_changes import ModelChanges
from masonry_cd.interface.scenes import Scene
from masonry_cd.interface.simulation_views import SimulationViews
from masonry_cd.interface.steppers import independent
from masonry_cd.io import checkpoint
from masonry_cd.mechanics.dynamics.snapshot import part, prefixed


class Copies(ModelChanges, SimulationViews):
    """Simulations that can be copied, saved, restored and pickled."""

    _given: dict[str, Any]
    _busy: bool
    _events: EventCallbacks

    def copy(self) -> Self:
        """A second simulation in the state of this one, which continues with the same bits.

        What functions of Python remember is shared, and both call those that are called on events.
        """
        self._refuse_when_busy("copy")
        other = object.__new__(type(self))
        vars(other).update(vars(self), _frames=None)
        other._own = self._own.copied()
        other._stepper = independent(self._stepper, other._own if self._own.own else None)
        other._changed = self._changed.copied(other._stepper, other._take_model)
        other._advance = other._fresh_advance()
        other._restore_pace(self._pace_arrays())
        other._pair_joints = PairJoints(self._case.assembly)
        other._events = self._events.copied()
        return other

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a checkpoint, all that later steps depend on but what functions of Python remember.

        Raises:
            InputError: called in the middle of a step.
        """
        self._refuse_when_busy("save")
        checkpoint.save(Path(path), self._arrays(), {"simulation": self.scene.text, "changes": self._changes_of_python()})

    def restore(self, path: str | os.PathLike[str]) -> None:
        """Continue from a checkpoint that :meth:`save` wrote, in this process or another; the scene must be the same.

        Raises:
            InputError: no such file, another scene, or a file that no such simulation has written. Then nothing is changed.
        """
        self._refuse_when_busy("restore")
        arrays, numbers_there = checkpoint.load(Path(path))
        if numbers_there.get("simulation") != self.scene.text:
            raise InputError(path, "no checkpoint of a simulation of this scene")
        before, kept = self._stepper, self._changed
        self._stepper = independent(before, None)
        self._changed = self._changed.copied(self._stepper, self._take_model)
        try:
            self._take_stage(arrays, numbers_there.get("changes"))
            self._stepper.check(Stored(_of_stepper(arrays)))
        except InputError as reason:
            self._stepper, self._changed = before, kept
            raise reason.under(path) from None
        self._take(arrays)
        self._events.forget()

    def __reduce__(self) -> tuple[Any, ...]:
        """Return, for pickle, the scene, the other arguments of the simulation, and all that later steps depend on.

        Raises:
            InputError: called in the middle of a step; a function that pickle cannot name.
        """
        self._refuse_when_busy("pickle")
        require_picklable(self._given | {f"on {event}": functions for event, functions in self._events.functions.items()})
        made = self._arrays(), self._changes_of_python()
        return _again, (type(self), self.scene, self._given, self._touched, made, self._events.parcel())

    def _arrays(self) -> dict[str, np.ndarray]:
        """All that later steps depend on but what functions of Python remember."""
        arrays = self._stepper.snapshot() | self._pace_arrays() | prefixed("events", self._changed.snapshot())
        return arrays | {f"law/{i}": law.history for i, law in enumerate(self._laws)}

    def _take_stage(self, arrays: Mapping[str, np.ndarray], changes: Any) -> None:
        """Be in the stage of what :meth:`_arrays` gave, with the changes of Python as tables.

        Raises:
            InputError: changes that this simulation does not know.
        """
        self._changed.changes.known[len(self._changed.tables) :] = read_changes(changes)
        self._changed.restore(Stored(part("events", arrays)), part("events", arrays))

    def _take(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Continue from what :meth:`_arrays` gave."""
        self._stepper.restore(_of_stepper(arrays))
        for i, law in enumerate(self._laws):
            law.history = arrays[f"law/{i}"].copy() if f"law/{i}" in arrays else np.zeros_like(law.history)
        self._advance = self._fresh_advance()
        self._go_on()
        self._restore_pace(arrays)
        self._stepper.last = None

    @property
    def _laws(self) -> list[BoundLaw]:
        return [item for item in self._own.own if isinstance(item, BoundLaw)]

    def _refuse_when_busy(self, what: str) -> None:
        if self._busy:
            raise InputError(what, "this simulation is in the middle of a step; ask between steps")

    def _fresh_advance(self) -> Advance:
        case: Case = self._case
        return Advance.of(self._stepper, case.steps, case.scene.run.frame_every, pauses_of(case), self._changed)

    def _pace_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays that the lengths of steps and the rests of the loads depend on."""
        pace, pauses = self._advance.pace, self._advance.pauses
        out = {} if pace is None else prefixed("pace", pace.snapshot())
        return out | {"rest/quiet": np.array([0 if pauses is None else pauses.quiet])}

    def _restore_pace(self, arrays: Mapping[str, np.ndarray]) -> None:
        if self._advance.pace is not None:
            self._advance.pace.restore(part("pace", arrays))
        if self._advance.pauses is not None:
            self._advance.pauses.quiet = int(arrays["rest/quiet"][0])


def _again(kind: Any, scene: Scene, given: Mapping[str, Any], touched: bool, made: tuple[Any, Any], events: Any) -> Any:
    """A simulation that was pickled."""
    sim, (arrays, changes) = kind(scene, **given), made
    sim._touched = touched
    sim._take_stage(arrays, changes)
    sim._take(arrays)
    sim._events.take(events)
    return sim


def _of_stepper(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays of the stepper among those of a simulation."""
    return {name: array for name, array in arrays.items() if not name.startswith(("pace/", "rest/", "law/", "events/"))}
