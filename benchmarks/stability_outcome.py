# SPDX-License-Identifier: GPL-3.0-or-later
"""Outcome of a case of the stability benchmark, and the limits that it is judged by; :mod:`benchmarks.stability` explains them."""

from __future__ import annotations

from dataclasses import dataclass

DRIFT = 1e-6
REST_OVERLAP, OVERLAP = 1e-6, 1e-2
BALANCE = 1e-6
GAINED = 1e-4


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case. Lengths are shares of the smallest block's width, energies shares of the largest work done."""

    group: str
    name: str
    at_rest: bool
    blocks: int
    steps: int
    drift: float
    travel: float  # of a block relative to the base in one step, the largest
    penetration: float
    balance: float
    gained: float  # energy that friction and impacts have given back
    missed: int
    error_max: float
    worst: float  # cost of the most expensive step but the first, in times of the median
    stopped: str

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Each measure with its limit."""
        found = {"penetration": (self.penetration, REST_OVERLAP if self.at_rest else OVERLAP), "balance": (self.balance, BALANCE)}
        found["dissipation"] = (self.gained, GAINED)
        return found | ({"drift": (self.drift, DRIFT)} if self.at_rest else {})

    @property
    def failures(self) -> list[str]:
        """List the limits that it exceeds; empty if it passed."""
        wrong = [name for name, (value, limit) in self.limits.items() if not value <= limit]
        return wrong + (["finite"] if self.stopped else [])
