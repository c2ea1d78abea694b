# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the steps of a case begin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_cd.app.case import Case
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.pauses import Pauses
from masonry_cd.mechanics.dynamics.start import drawn_velocities

if TYPE_CHECKING:
    from masonry_cd.app.events import Events


def stepper_of(case: Case) -> Stepper:
    """The stepper of a case as built, before :func:`begin`."""
    loading = case.loading
    return Stepper(case.assembly, loading.support_velocity, loading.acceleration, case.scene.run, forces=loading.forces)


def begin(stepper: Stepper, case: Case) -> None:
    """Bring a stepper as built to where its run begins: elastic joints take up the weight, and blocks get their first velocities.

    Raises:
        InputError: the structure does not come to rest.
    """
    settings = case.scene.run
    if settings.settle:
        with case.scene.locating():
            try:
                settle(stepper)
            except InputError as error:
                raise _crushed_at_rest(case) or error from None
    if settings.first_velocities is not None:
        stepper.kick(drawn_velocities(stepper.system, settings.first_velocities))


def _crushed_at_rest(case: Case) -> InputError | None:
    """Why a case does not come to rest whose joints crush under the dead loads alone, as limit analysis finds it: the joint, its stress and
    its strength. None where that is not why."""
    if not case.assembly.laws.crushing.any():
        return None
    from masonry_cd.analysis.limit.analysis import at_rest, refuse_crushed
    from masonry_cd.app.limit_structure import limit_structure
    from masonry_cd.app.limit_table import limit_table

    try:  # what limit analysis does not know is not a fault of the run
        built = limit_structure(case.scene)
        problem, _ = at_rest(built.assembly, built.joints, built.loads(limit_table({"push": "x"})).at())
    except InputError:
        return None
    try:
        refuse_crushed(problem, built.assembly)
    except InputError as crushed:
        return crushed
    return None


def events_of(case: Case, stepper: Stepper) -> Events:
    """The events of a case, which change the model of a stepper at the beginning of its run."""
    from masonry_cd.app.events import Events

    return Events.of(case.events, case.scene.tables["material"], stepper, case.joints, case.gauges)


def pauses_of(case: Case) -> Pauses | None:
    """The rests of a case that may end early, and its shocks; None without any."""
    loading = case.loading
    return Pauses(case.assembly, loading.pauses, loading.shocks, case.steps) if loading.shocks or loading.pauses else None
