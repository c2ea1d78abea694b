# SPDX-License-Identifier: GPL-3.0-or-later
"""The steppers of simulations: with own forces and an own solver, and copies that go on by themselves."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np

from masonry_cd.app.case import Case
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.plugins import CALLED
from masonry_cd.foundation.signatures import require_call
from masonry_cd.interface.own_forces import OwnForces
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.planar import find_plane
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.solvers import Solver
from masonry_cd.mechanics.solvers.by_name import GROUP, OWN, step_solver


def solved_by(solver: Solver, scene: Scene) -> Scene:
    """A scene whose results say that a function of Python solves it.

    Raises:
        InputError: it cannot be called as a solver is.
    """
    require_call(solver, CALLED[GROUP]["solve"], "solver", "solve")
    return replace(scene, run=scene.run.model_copy(update={"solver": OWN}))


def stepper_of(case: Case, own: OwnForces, velocity: np.ndarray, solver: Solver | None) -> Stepper:
    """The stepper of a case with own forces, whose blocks will begin with some velocities (B, 6): in a plane where all of it is."""
    loading, settings, assembly = case.loading, case.scene.run, case.assembly
    forces = own if own.own else loading.forces
    start = replace(State.at_rest(assembly), velocity=velocity)
    plane = find_plane(assembly, start, loading.support_velocity, loading.acceleration, forces) if settings.planar else None
    if plane is None:
        settings = settings.model_copy(update={"planar": False})
    own.axis = -1 if plane is None else plane.axis
    if solver is not None:
        settings = settings.model_copy(update={"solver": "auto"})
    stepper = Stepper(assembly, loading.support_velocity, loading.acceleration, settings, forces=forces, plane=plane)
    if solver is not None:
        stepper.islands.solver = step_solver(solver)
    return stepper


def independent(stepper: Stepper, forces: OwnForces | None) -> Stepper:
    """A stepper that stands where another does and shares with it only what does not change."""
    other = copy.copy(stepper)
    if forces is not None:
        other.system = replace(stepper.system, loads=replace(stepper.system.loads, forces=forces))
    other.detector, other.islands = stepper.detector.copied(), copy.deepcopy(stepper.islands)
    return other
