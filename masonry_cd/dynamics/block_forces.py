"""Forces on single blocks, as the step asks for them. Point loads and ties of the room ``loads`` have this shape."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class BlockForces(Protocol):
    """Forces that depend on where the blocks are and how they move; B blocks, T ties. World frame."""

    def wrench(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> np.ndarray:
        """Force [N] and moment about the centre of mass [N m] on every block, (B, 6), mean over some steps of the loads from one on.

        Positions (B, 3) [m], rotations (B, 3, 3) body to world, velocities (B, 6) [m/s, rad/s], lasting stretch of the ties (T,) [m].
        """

    def virial(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> np.ndarray:
        """Sum over the forces on each block of force (x) arm from the centre of mass, (B, 3, 3) [N m]; arguments as of :meth:`wrench`."""

    def acting(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The blocks (N,) that forces act on, the forces (N, 3) [N], and their arms from the centres of mass (N, 3) [m]; arguments as of
        :meth:`wrench`."""

    def spread(self, step: int, ticks: int, mass: np.ndarray) -> float:
        """Largest acceleration [m/s2] by which forces given in time differ from their mean over some steps; masses (B,) [kg]."""

    def tensions(self, position: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, yielded: np.ndarray | None = None) -> np.ndarray:
        """Tension of each tie, (T,) [N]."""

    def yields(self, position: np.ndarray, rotation: np.ndarray, yielded: np.ndarray) -> np.ndarray:
        """By how much each tie has stretched for good, (T,) [m], after ``yielded`` (T,) before."""

    def leaves_plane(self, axis: int, at: float, centre: np.ndarray) -> bool:
        """True when a force moves blocks out of the plane where coordinate ``axis`` equals ``at``; centres (B, 3) at the start [m]."""
