# SPDX-License-Identifier: GPL-3.0-or-later
"""How Python changes the model of a simulation between two steps, by the keys and with the checks of the events of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from masonry_cd.app.advance import Advance
from masonry_cd.app.case import Case
from masonry_cd.app.changes import Change, check, without
from masonry_cd.app.events import Events
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.interface.own_forces import OwnForces
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper


class ModelChanges:
    """Blocks that come and go, supports that let go, and other friction, laws of joints, ties, props and gravity.

    Energy that a change puts in or takes out is in ``sim.energy["change_work"]``. Changes are part of what :meth:`Simulation.save` writes.
    """

    _stepper: Stepper
    _advance: Advance
    _changed: Events
    _own: OwnForces
    _touched: bool

    def remove(self, *blocks: str) -> None:
        """Take blocks away, by names, groups or patterns with ``*``.

        Raises:
            InputError: see :meth:`change`.
        """
        self.change(remove=blocks)

    def add(self, *blocks: str) -> None:
        """Put in blocks that are not there: those of ``waiting`` where they were built, removed ones where they were.

        Raises:
            InputError: see :meth:`change`.
        """
        self.change(add=blocks)

    def release(self, *supports: str) -> None:
        """Turn supports into free blocks, which continue with their velocity.

        Raises:
            InputError: see :meth:`change`.
        """
        self.change(release=supports)

    def material(self, **keys: Any) -> None:
        """Change ``friction`` or ``joints``, written as in [material]; joints stay rigid, elastic or bonded as they are.

        Raises:
            InputError: see :meth:`change`.
        """
        self.change(material=keys)

    def change(self, **keys: Any) -> None:
        """Change the model now, by the keys of [[events]]: remove, add, release, cut, take_out, put_in, material, gravity.

        Raises:
            InputError: names that fit nothing, a change of the kind of joints, a call in the middle of a step; nothing is changed.
        """
        if self._advance.at_work:
            raise InputError("change", "this simulation is in the middle of a step; change its model between steps")
        given = {key: list(value) if isinstance(value, tuple) else value for key, value in keys.items()}
        made = parse_table(Change, given, "change")
        if made.material is not None and made.material.friction is not None and self._stepper.friction is not None:
            raise InputError("change.material.friction", "a function gives the coefficients of this simulation")
        changes = self._changed.changes
        check(made, changes.model, "change")
        changes.known.append((made, "change"))
        try:
            changes.make(len(changes.known) - 1, self._stepper)
        except InputError:
            changes.known.pop()
            raise
        self._touched = True
        self._go_on()

    def _go_on(self) -> None:
        """Have what looks at the stepper look at the model that it has now."""
        self._take_model()
        self._advance.go_on()

    def _take_model(self) -> None:
        """Update own forces and laws to the present blocks, ties and props."""
        forces, absent = self._stepper.system.loads.forces, self._stepper.assembly.absent
        if self._own.own:
            assert isinstance(forces, OwnForces)
            self._own = forces
        for item in self._own.own:
            item.update_blocks(absent)

    def _changes_of_python(self) -> list[Mapping[str, Any]]:
        """As tables, in addition to those of the scene."""
        known: Sequence[tuple[Change, str]] = self._changed.changes.known[len(self._changed.tables) :]
        return [change.model_dump(mode="json", exclude_none=True) for change, _ in known]


def without_waiting(case: Case, waiting: str | Sequence[str] | None) -> Case:
    """The case whose blocks of some names are not there at first.

    Raises:
        InputError: names that fit nothing, or a support.
    """
    if not waiting:
        return case
    return replace(case, assembly=without(case.assembly, [waiting] if isinstance(waiting, str) else waiting, "waiting"))
