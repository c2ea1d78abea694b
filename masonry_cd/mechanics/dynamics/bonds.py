# SPDX-License-Identifier: GPL-3.0-or-later
"""Bonds that soften, as values: those of a step, and what they hand on to the next. See ``softening.py``."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.mechanics.dynamics.cohesive_curve import Curves
from masonry_cd.mechanics.dynamics.joint_law import JointMemory


class Bonds(NamedTuple):
    """The bonds of a step: K contacts, of which those that are in part dry come twice, and H of them with some bond."""

    taken: np.ndarray  # (K,) which contact of the detector it is
    twin: np.ndarray  # (K,) bool: the dry share of the contact before it
    held: np.ndarray  # (H,) which of the K are bonded shares
    curves: Curves  # (H,)
    damage: np.ndarray  # (H,) D at the beginning of the step
    share: np.ndarray  # (H,) D held in the step
    bound: np.ndarray  # (H,) tip of a cone that the stress of the bond stays in, over its whole area [Pa]
    spent: np.ndarray  # (H,) share of the fracture energy that is taken at the beginning
    false_slip: np.ndarray  # (K, m - 1) of these contacts before the step, see violations.py [m]

    def of_detector(self, values: np.ndarray) -> np.ndarray:
        """Values (K,) at the contacts as the detector has them."""
        return values[~self.twin]

    def rows(self, active: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which bonds are among the contacts ``active`` (C,) of a problem, and their rows in it."""
        row_of = np.full(len(self.taken), -1)
        row_of[active] = np.arange(len(active))
        row = row_of[self.held]
        which = np.flatnonzero(row >= 0)
        return which, row[which]

    def held_rows(self, active: np.ndarray) -> np.ndarray:
        """(C,) bool: rows of a problem that are bonded shares."""
        held = np.zeros(len(self.taken), dtype=bool)
        held[self.held] = True
        return held[active]


class BondMemory(NamedTuple):
    """Memory of bonds that soften from step to step, by contact of the last one, twins included; one entry at least."""

    damage: np.ndarray  # (K,) D; 1: dry
    spent: np.ndarray  # (K,) share of the fracture energy that is taken
    stretch: np.ndarray  # (K,) opening at the end of the last step [m]
    growth: np.ndarray  # (K,) way along the curve in it
    twin: np.ndarray  # (K,) bool: the dry share of the contact before it

    @classmethod
    def none(cls) -> BondMemory:
        """Memory of nothing yet."""
        return cls(np.ones(1), np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1, dtype=bool))

    @classmethod
    def of(cls, bonds: Bonds) -> BondMemory:
        """The bonds as they were at the beginning of a step."""
        count = max(1, len(bonds.taken))
        twin = np.zeros(count, dtype=bool)
        twin[: len(bonds.twin)] = bonds.twin
        out = cls(np.ones(count), np.ones(count), np.zeros(count), np.zeros(count), twin)
        out.damage[bonds.held], out.spent[bonds.held] = bonds.damage, bonds.spent
        return out

    def cut(self, gone: np.ndarray) -> BondMemory:
        """The bonds without those of contacts (K,) bool."""
        return self._replace(damage=np.where(gone, 1.0, self.damage), spent=np.where(gone, 1.0, self.spent))

    def freed(self, joints: JointMemory, gone: np.ndarray) -> JointMemory:
        """The memory of joints whose contacts (K,) bool have lost their bond: where a share of one was dry its slip stays, elastic."""
        first, slip = np.flatnonzero(self.twin & gone) - 1, joints.slip.copy()
        slip[first] = slip[first + 1]
        return joints._replace(slip=slip)

    def with_step(self, share: float) -> BondMemory:
        """The bonds as they go into a step of another length, by its share of the last one; 0: from rest."""
        return self._replace(growth=share * self.growth)


def check_bonds(stored: Stored, contacts: int) -> int:
    """Check what a checkpoint holds of bonds, with the contacts of the detector; return their number with the twins.

    Raises:
        InputError: an array that no run leaves.
    """
    twin = stored.flags("twin", None)
    if int((~twin).sum()) != max(1, contacts) or twin[0] or (twin[1:] & twin[:-1]).any():
        stored.refuse("twin", "not those of the contacts")
    for name in ("damage", "spent"):
        values = stored.real(name, len(twin))
        if not ((values >= 0.0) & (values <= 1.0)).all():
            stored.refuse(name, "not between 0 and 1")
    stored.real("stretch", len(twin))
    stored.real("growth", len(twin))
    stored.check_all_read()
    return len(twin) if contacts else 0
