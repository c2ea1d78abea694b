# SPDX-License-Identifier: GPL-3.0-or-later
r"""Point loads and bars between blocks, as the step asks for their forces.

A **tie** is a bar between a point of one block and a point of another, that pulls and never pushes. With the length L of the line between
the points, its length L_0 as built, stiffness k = E A / L_0, tension N_0 at the start, damping c = 2 xi sqrt(k m_e), and the stretch e
that the structure had settled by at the start, or that is left where the tie has yielded,

    S = N_0 + k (L - L_0 - e),        N = max(0, S + c L') where S > 0, and 0 elsewhere,        on each end along the line.

Where S would exceed N_y, the force at which it yields, e grows until S = N_y, and N is N_y at the most: elastic, perfectly plastic, slack
under compression. m_e is the mass that the bar feels at its ends, d its direction:

    1 / m_e = sum over the free ends of d . (1/m + [r]^T I^-1 [r]) d.

**In the step.** The forces are taken at the middle positions q_m with the velocities of the step's beginning, and enter the free velocity,
v_free = v + h M^-1 (f + wrench). For theta = 1/2 that is the leapfrog scheme, which keeps the energy of an elastic bar bounded as
long as w h < 2 with w = sqrt(k / m_e), and less where it is damped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from masonry_cd.mechanics.model.block_forces import Acting
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.guides import Guide

NO_TENSION = np.zeros(0)  # of no ties


@dataclass(frozen=True, eq=False)
class PointLoad:
    """A force and a moment on one block, which keep their directions."""

    block: int
    arm: np.ndarray  # (3,) from the centre of mass, body frame [m]
    force: np.ndarray  # (3,) [N]
    factor: np.ndarray  # (N + 1,)
    moment: np.ndarray | None = None  # (3,) in addition to that of its arm, world axes [N m]


@dataclass(frozen=True, eq=False)
class Tie:
    """A bar between two blocks."""

    blocks: tuple[int, int]
    arms: np.ndarray  # (2, 3) from the centres of mass, body frames [m]
    length: float  # L_0 [m]
    section: float  # A [m2]
    stiffness: float  # k [N/m]
    tension: float  # N_0 [N]
    damping: float  # c [N s/m]
    limit: float = math.inf  # N_y [N]
    name: str = ""  # for reports; bars of one name are one tie, spread over the blocks that its plates cover
    from_start: bool = False  # there while the structure takes up its weight; else drawn by a jack then, to N_0 however it gives way
    there: bool = True  # else it does not pull


@dataclass(frozen=True, eq=False)
class Forces:
    """All forces on single blocks: P point loads and T ties."""

    points: tuple[PointLoad, ...]
    ties: tuple[Tie, ...]
    guides: tuple[Guide, ...] = ()  # of blocks whose motion is given in part

    @classmethod
    def of(cls, forces: Sequence[PointLoad | Tie | Guide]) -> Forces | None:
        """The forces of all loads; None where there are none."""
        points = tuple(f for f in forces if isinstance(f, PointLoad))
        ties = tuple(f for f in forces if isinstance(f, Tie))
        return cls(points, ties, tuple(f for f in forces if isinstance(f, Guide))) if forces else None

    def acting(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> Acting:
        """Point loads, then the first ends of all ties, then their second ends, in the world frame.

        Args:
            position: (B, 3) centres of mass [m].
            rotation: (B, 3, 3) body to world.
            velocity: (B, 6) linear and angular [m/s, rad/s].
            step: k of the loads.
            ticks: n; point loads are the mean of those at t_k .. t_k+n-1.
            yielded: (T,) by how much each tie has stretched for good [m]; None: by nothing.
        """
        block = np.array([load.block for load in self.points], dtype=np.int64)
        push = np.array([load.factor[step : step + ticks].mean() * load.force for load in self.points]).reshape(-1, 3)
        arm = np.sum(rotation[block] * np.array([load.arm for load in self.points]).reshape(-1, 1, 3), axis=-1)
        moment = self._moments(step, ticks) if self._turns else None
        if not self.ties:
            return Acting(block, push, arm, NO_TENSION, moment)
        tension, along, arms = self._pull(position, rotation, velocity, yielded)
        pull = tension[:, None] * along
        blocks, arms_of_all = np.concatenate([block, *self._ends.T]), np.concatenate([arm, arms[:, 0], arms[:, 1]])
        moment = None if moment is None else np.pad(moment, ((0, 2 * len(self.ties)), (0, 0)))
        return Acting(blocks, np.concatenate([push, pull, -pull]), arms_of_all, tension, moment)

    @cached_property
    def _turns(self) -> bool:
        """True where a point load has a moment."""
        return any(load.moment is not None for load in self.points)

    def _moments(self, step: int, ticks: int) -> np.ndarray:
        """Those of the point loads next to their arms, (P, 3) [N m], as :meth:`acting` takes them."""
        of_one = [np.zeros(3) if load.moment is None else load.moment for load in self.points]
        return np.array([load.factor[step : step + ticks].mean() * each for load, each in zip(self.points, of_one, strict=True)])

    def spread(self, step: int, ticks: int, assembly: Assembly) -> float:
        """Largest acceleration [m/s2] by which point loads at t_k .. t_k+n-1 differ from their mean, at the centre and at a corner."""
        largest = 0.0
        for load in self.points:
            factor = load.factor[step : step + ticks]
            away, block = float(np.abs(factor - factor.mean()).max()), load.block
            largest = max(largest, away * math.hypot(*load.force) / float(assembly.mass[block]))
            if load.moment is not None:
                largest = max(largest, away * math.hypot(*load.moment) / float(assembly.turning_mass[block]))
        return largest

    def extended(self, steps: int) -> Forces:
        """The forces, with point loads that keep their last value for a given number of further steps."""
        points = tuple(replace(load, factor=np.pad(load.factor, (0, steps), mode="edge")) for load in self.points)
        return Forces(points, self.ties, tuple(guide.extended(steps) for guide in self.guides))

    def ties_alone(self) -> Forces:
        """The ties, and guides at rest."""
        return Forces((), self.ties, tuple(guide.at_rest() for guide in self.guides))

    @cached_property
    def there(self) -> np.ndarray:
        """Which ties are there, (T,) bool."""
        return np.array([tie.there for tie in self.ties], dtype=bool)

    @property
    def switches(self) -> Mapping[str, bool]:
        """Ties and guides that can come and go, by name, and whether they are there."""
        return {tie.name: tie.there for tie in self.ties if tie.name} | {guide.name: guide.there for guide in self.guides if guide.name}

    def switched(self, there: Mapping[str, bool]) -> Forces:
        """The forces whose ties and guides of some names are there or not."""
        ties = tuple(replace(tie, there=there.get(tie.name, tie.there)) for tie in self.ties)
        return replace(self, ties=ties, guides=tuple(replace(one, there=there.get(one.name, one.there)) for one in self.guides))

    def stretches(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """L - L_0 of each tie, (T,) [m]."""
        return self._lines(position, rotation)[1] - self._bars["length"]

    @cached_property
    def jacked(self) -> np.ndarray:
        """Which ties keep their first tension while the structure settles, (T,) bool."""
        return np.array([not tie.from_start for tie in self.ties], dtype=bool)

    def yields(self, position: np.ndarray, rotation: np.ndarray, yielded: np.ndarray) -> np.ndarray:
        """Return the permanent stretch (T,) [m] of each tie, after ``yielded`` (T,) before; for an absent tie, its whole stretch."""
        if not self.ties:
            return yielded
        bars, longer = self._bars, self.stretches(position, rotation)
        stretch = bars["tension"] + bars["stiffness"] * (longer - yielded)
        return np.where(self.there, yielded + np.maximum(0.0, stretch - bars["limit"]) / bars["stiffness"], longer)

    def _lines(self, position: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """From the first end of each tie to the second (T, 3), its length (T,) [m], and the arms in the world (T, 2, 3)."""
        arms = np.sum(rotation[self._ends] * self._arms[..., None, :], axis=-1)
        places = position[self._ends] + arms
        line = places[:, 1] - places[:, 0]
        return line, np.sqrt(np.sum(line * line, axis=1)), arms

    def _pull(
        self, position: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, yielded: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """N (T,) [N], unit vectors from the first end to the second (T, 3), and the arms in the world (T, 2, 3)."""
        ends, bars = self._ends, self._bars
        line, length, arms = self._lines(position, rotation)
        along = line / length[:, None]
        speed = velocity[ends, :3] + np.cross(velocity[ends, 3:], arms)
        stretch = bars["tension"] + bars["stiffness"] * (length - bars["length"] - (0.0 if yielded is None else yielded))
        force = stretch + bars["damping"] * np.sum(along * (speed[:, 1] - speed[:, 0]), axis=1)
        return np.where((stretch > 0.0) & self.there, np.clip(force, 0.0, bars["limit"]), 0.0), along, arms

    @cached_property
    def _ends(self) -> np.ndarray:
        """(T, 2) blocks."""
        return np.array([tie.blocks for tie in self.ties], dtype=np.int64).reshape(-1, 2)

    @cached_property
    def _arms(self) -> np.ndarray:
        """(T, 2, 3) in the body frames [m]."""
        return np.array([tie.arms for tie in self.ties]).reshape(-1, 2, 3)

    @cached_property
    def _bars(self) -> dict[str, np.ndarray]:
        """Numbers of the bars, (T,) each."""
        names = ("length", "stiffness", "tension", "damping", "limit")
        return {name: np.array([getattr(tie, name) for tie in self.ties]) for name in names}

    def leaves_plane(self, axis: int, at: float, centre: np.ndarray) -> bool:
        """True when a force or a point of attack lies outside the plane where coordinate ``axis`` equals ``at`` (centres (B, 3) [m])."""
        arms = [(load.block, load.arm) for load in self.points]
        arms += [(block, arm) for tie in self.ties for block, arm in zip(tie.blocks, tie.arms, strict=True)]
        size = 1e-9 * max(1.0, float(np.abs(centre).max()))
        off = any(abs(centre[block, axis] + arm[axis] - at) > size for block, arm in arms)
        off = off or any(guide.leaves_plane(axis, at, centre) for guide in self.guides)
        turning = [d for d in range(3) if d != axis]
        off = off or any(load.moment is not None and load.moment[turning].any() for load in self.points)
        return off or any(load.force[axis] != 0.0 for load in self.points)
