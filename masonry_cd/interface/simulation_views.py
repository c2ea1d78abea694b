# SPDX-License-Identifier: GPL-3.0-or-later
"""Read-only properties of a simulation between two steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.app.advance import Advance
from masonry_cd.app.case import Case
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.app.step_contacts import Contacts, LinkForce, contacts_of, links_of, reactions_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.frames import Frames
from masonry_cd.interface.scenes import Scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.structure import Structure
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport

if TYPE_CHECKING:
    from xarray import Dataset

    from masonry_cd.mechanics.friction.problem import FrictionProblem
    from masonry_cd.mechanics.model.joints import Joints


class SimulationViews(Sealed):
    """Times, blocks, contacts, forces, energies and frames."""

    scene: Scene
    _case: Case
    _stepper: Stepper
    _advance: Advance
    _pair_joints: PairJoints
    _report: StepReport | None
    _frames: Frames | None

    @property
    def time(self) -> float:
        """Time of the run [s]."""
        return self._stepper.state.time

    @property
    def steps(self) -> int:
        """Made so far."""
        return self._stepper.steps

    @property
    def done(self) -> bool:
        """True once the scene has ended."""
        return self._advance.done

    @property
    def report(self) -> StepReport | None:
        """Cost and accuracy of the last step: iterations, error, seconds, contacts, penetration; None before the first step."""
        return self._report

    @property
    def structure(self) -> Structure:
        """The blocks, in the order of all arrays."""
        return Structure(self._case.assembly.blocks, self._case.notes)

    @property
    def joints(self) -> Joints:
        """The joints as built: blocks, area, normal, polygons; their numbers are those of results."""
        return self._case.joints

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step, as arrays; none before the first."""
        return contacts_of(self._stepper, self._pair_joints.of(self._stepper.detector.pairs))

    def joint_forces(self) -> np.ndarray:
        """The force of each joint on its block b over the last step, (J, 3) [N]; its opposite acts on block a."""
        return self.contacts.of_joints(self._case.joints.count)

    def reactions(self) -> dict[str, np.ndarray]:
        """Force [N] and moment about its centre of mass [N m] of each support on what it carries, (6,) by its name; of the last step."""
        every = reactions_of(self._stepper, self.contacts)
        return {name: every[b] for b, name in enumerate(self._case.assembly.names) if self._case.assembly.fixed[b]}

    def links(self) -> list[LinkForce]:
        """Force [N] and moment [N m] of each link on its first block over the last step, in the order of the scene."""
        return links_of(self._stepper)

    @property
    def energy(self) -> dict[str, float]:
        """Energy put in since the start, where it went, and the balance [J]."""
        return dict(self._stepper.energy)

    @property
    def frames(self) -> Dataset:
        """The frames so far of a simulation that is recorded to memory.

        Raises:
            InputError: it is not.
        """
        if self._frames is None:
            raise InputError("frames", 'are kept by record(to="memory")')
        return self._frames.dataset(self._case.assembly.blocks, {"title": self.scene.title, "scene": self.scene.text})

    def problem(self) -> FrictionProblem:
        """The friction problem of the step that comes next; asking for it changes nothing.

        ``masonry_cd.io.problem_files.write_problem`` writes it as ``masonry-cd solve`` reads it.

        Raises:
            InputError: the scene has ended.
        """
        self._refuse_at_end("problem")
        return self._stepper.friction_problem().solved

    def _refuse_at_end(self, what: str) -> None:
        if self.done:
            raise InputError(what, f"the scene has ended, at {self.time:g} s; a longer run.duration continues it")
