# SPDX-License-Identifier: GPL-3.0-or-later
"""Shocks in a row and the pauses between them, in steps of the loads."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Shock:
    """When a shock acts: from step first to step last, from which on the base stands still."""

    name: str
    first: int
    last: int


@dataclass(frozen=True)
class Pause:
    """Steps during which nothing changes; :mod:`masonry_cd.mechanics.dynamics.pauses` says what a run does with it."""

    first: int
    last: int
    speed: float  # below which the structure counts as still [m/s]
    hold: int  # steps in a row that it has to be
    after: str  # the shock before
