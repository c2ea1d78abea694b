# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy balance after a step; when it was made, how it was solved, and what is off in its solution."""

from __future__ import annotations

from masonry_cd.app.per_step import Quantity
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES

QUANTITIES = {
    **{
        f"energy/{name}": Quantity(lambda made, name=name: made.stepper.energy[name], words, "J")  # type: ignore[misc]
        for name, words in ENERGIES.items()
    },
    "step_time": Quantity(lambda made: made.stepper.state.time, "time at the end of the step", "s"),
    "load_step": Quantity(lambda made: made.load_step, "applied step of the loads", whole=True),
    "penetration": Quantity(lambda made: made.report.penetration, "largest overlap of rigid contacts", "m"),
    "solver/iterations": Quantity(lambda made: made.report.iterations, "iterations of the solver", whole=True),
    "solver/error": Quantity(lambda made: made.report.error, "natural map error"),
    "solver/seconds": Quantity(lambda made: made.report.seconds, "elapsed time", "s"),
    "solver/contacts": Quantity(lambda made: made.report.contacts, "number of contact points", whole=True),
    "solver/violation": Quantity(lambda made: made.report.violation.speed, "largest violation of the contact laws", "m/s"),
    "solver/false_slip": Quantity(lambda made: made.report.violation.slip, "largest slip accumulated from violations at a contact", "m"),
    "solver/false_opening": Quantity(lambda made: made.report.violation.opening, "largest opening left by a violation at a contact", "m"),
}
