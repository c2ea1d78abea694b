# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces on single blocks, as the step asks for them. Point loads and ties of ``loads`` have this shape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.model.guides import Guide

if TYPE_CHECKING:
    from masonry_cd.mechanics.model.blocks import Assembly


class Acting(NamedTuple):
    """N forces on single blocks at one instant, those of T ties among them. World frame."""

    block: np.ndarray  # (N,) that each acts on
    force: np.ndarray  # (N, 3) [N]
    arm: np.ndarray  # (N, 3) from the centre of mass of the block [m]
    tension: np.ndarray  # (T,) of the ties [N]
    moment: np.ndarray | None = None  # (N, 3) in addition to those of the arms, which strain no block [N m]; None: there are none

    def wrench(self, blocks: int) -> np.ndarray:
        """Force [N] and moment about the centre of mass [N m] on each of B blocks, (B, 6)."""
        out = np.zeros((blocks, 6))
        add_wrenches(self.block, self.force, self.arm, out)
        if self.moment is not None:
            np.add.at(out[:, 3:], self.block, self.moment)
        return out

    def turning(self, assembly: Assembly) -> np.ndarray:
        """Most by which the moments accelerate a corner of each block, (B,) [m/s2]; the arms are left out."""
        out = np.zeros(assembly.count)
        if self.moment is not None:
            np.add.at(out, self.block, np.sqrt(np.sum(self.moment * self.moment, axis=1)))
        return np.asarray(out / assembly.turning_mass)

    def virial(self, blocks: int) -> np.ndarray:
        """Sum over the forces on each of B blocks of force (x) arm, (B, 3, 3) [N m]."""
        out = np.zeros((blocks, 3, 3))
        np.add.at(out, self.block, self.force[:, :, None] * self.arm[:, None, :])
        return out


@entry()
def add_wrenches(block: np.ndarray, force: np.ndarray, arm: np.ndarray, out: np.ndarray) -> None:
    """Add forces (N, 3) on blocks (N,) and their moments at arms (N, 3) to the rows of ``out`` (B, 6)."""
    for k in range(len(block)):
        for i in range(3):
            j, l = (i + 1) % 3, (i + 2) % 3  # noqa: E741
            out[block[k], i] += force[k, i]
            out[block[k], 3 + i] += arm[k, j] * force[k, l] - arm[k, l] * force[k, j]


class BlockForces(Protocol):
    """Forces that depend on where the blocks are and how they move; B blocks, T ties. World frame."""

    def acting(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> Acting:
        """Return the forces, loads as their mean over some steps from one on.

        Positions (B, 3) [m], rotations (B, 3, 3) body to world, velocities (B, 6) [m/s, rad/s], lasting stretch of the ties (T,) [m].
        """

    @property
    def guides(self) -> tuple[Guide, ...]:
        """Guides of blocks whose motion is given in part."""

    def spread(self, step: int, ticks: int, assembly: Assembly) -> float:
        """Largest acceleration [m/s2] by which forces and moments given in time differ from their mean over some steps."""

    @property
    def jacked(self) -> np.ndarray:
        """Which ties keep their first tension while the structure settles, (T,) bool; the others are there by then."""

    @property
    def there(self) -> np.ndarray:
        """Which ties are there, (T,) bool; the others do not pull."""

    @property
    def switches(self) -> Mapping[str, bool]:
        """Ties and guides that can come and go, by name, and whether they are there."""

    def switched(self, there: Mapping[str, bool]) -> BlockForces:
        """The forces whose ties and guides of some names are there or not."""

    def ties_alone(self) -> BlockForces:
        """The forces without those that are given in time, and guides at rest."""

    def stretches(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Return the elongation of each tie since it was built, (T,) [m]."""

    def yields(self, position: np.ndarray, rotation: np.ndarray, yielded: np.ndarray) -> np.ndarray:
        """Return the permanent stretch of each tie, (T,) [m], after ``yielded`` (T,) before."""

    def leaves_plane(self, axis: int, at: float, centre: np.ndarray) -> bool:
        """True when a force moves blocks out of the plane where coordinate ``axis`` equals ``at``; centres (B, 3) at the start [m]."""
