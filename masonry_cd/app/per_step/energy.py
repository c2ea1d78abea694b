# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy balance after a step."""

from __future__ import annotations

from masonry_cd.app.per_step import Quantity
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES

QUANTITIES = {
    f"energy/{name}": Quantity(lambda made, name=name: made.stepper.energy[name], words, "J")  # type: ignore[misc]
    for name, words in ENERGIES.items()
}
