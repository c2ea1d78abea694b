# SPDX-License-Identifier: GPL-3.0-or-later
"""Data that the phases of a step share: constants of a run, the loads of one step, and the memory from one step to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.contact.facets import Facets
from masonry_cd.mechanics.contact.find_joints import built_gap
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays, StepConstants
from masonry_cd.mechanics.dynamics.bonds import BondMemory
from masonry_cd.mechanics.dynamics.joint_law import JointLawArrays, JointMemory, law_arrays
from masonry_cd.mechanics.dynamics.linkage import Linkage
from masonry_cd.mechanics.dynamics.pair_stiffness import PairStiffness, most_stretched
from masonry_cd.mechanics.dynamics.planar import Plane, find_plane
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.strain import Strains
from masonry_cd.mechanics.linalg.small_blocks import inverses, size_tuple
from masonry_cd.mechanics.model.block_forces import BlockForces
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.solvers import threads_that_pay

WITH_ROTATION = 6  # columns of the velocities of supports of which one turns
TOUCHING = 1e-8  # gaps up to this share of the smallest width count as closed, or those of the joints as built
NO_APPROACH = np.zeros(0)
NO_BONDS = BondMemory.none()
SLACK = 1.5  # times the latter: a joint that slips or turns a little stays closed


class StepLoads(NamedTuple):
    """The loads of one step, from t_k to t_k+n, with S prescribed motions."""

    number: int  # k + 1
    ticks: int  # n
    support_before: np.ndarray  # (S, 3 or 6) velocities of the supports at t_k, see Loads
    support_after: np.ndarray  # (S, 3 or 6) at t_k+n
    acceleration: np.ndarray  # (3,) body acceleration, gravity included, mean over the step [m/s2]


@dataclass(frozen=True, eq=False)
class RunLoads:
    """Loads of a run, sampled at N + 1 times a tick apart: the time step, or the shortest where it adapts."""

    support_velocity: np.ndarray  # (N + 1, S, 3) of support motion s at t_k, k ticks [m/s]; (N + 1, S, 6) with [rad/s] where one turns
    acceleration: np.ndarray  # (N + 1, 3) body acceleration at t_k, gravity included [m/s2]
    forces: BlockForces | None  # on single blocks

    def of_step(self, k: int, ticks: int = 1) -> StepLoads:
        """The loads of a step of some ticks from t_k on; the work of the body forces is that of as many short steps."""
        pull = self.acceleration[k + 1] if ticks == 1 else self.acceleration[k + 1 : k + ticks + 1].mean(axis=0)
        return StepLoads(k + 1, ticks, self.support_velocity[k], self.support_velocity[k + ticks], pull)

    @property
    def turning(self) -> bool:
        """True where supports turn."""
        return self.support_velocity.shape[2] == WITH_ROTATION

    @property
    def guides(self) -> tuple[Guide, ...]:
        """Guides of blocks whose motion is given in part."""
        return () if self.forces is None else self.forces.guides

    def at_rest(self) -> tuple[np.ndarray, np.ndarray]:
        """Support velocities (N + 1, S, 3 or 6) of none, and body accelerations (N + 1, 3) whose first two are the first of the run."""
        acceleration = self.acceleration.copy()
        acceleration[1] = acceleration[0]
        return np.zeros_like(self.support_velocity), acceleration


@dataclass(frozen=True, eq=False)
class System:
    """Constants of a run. Build it with :meth:`of`."""

    assembly: Assembly
    settings: Run
    loads: RunLoads
    plane: Plane | None  # in which the scene moves; None: in space
    free: np.ndarray  # (B,) bool
    blocks: BlockArrays
    constants: StepConstants
    laws: JointLawArrays | None  # of elastic and bonded joints; None: all joints are rigid and dry
    masonry: PairStiffness | None  # stiffness of joints that follow from masonry; None: no masonry gives them one
    strains: Strains | None  # of blocks that deform; None: all are rigid
    reach: np.ndarray  # (F,) farthest corner of each free block from its centre [m]
    width: float  # of the thinnest free block [m]
    inexact: float  # gaps and overlaps up to this count as none, since joints were built with such [m]
    gravity: float  # largest body acceleration of the run [m/s2]
    free_mass: np.ndarray  # (B,) [kg]; 0: a support
    stretch: float  # by which an intact joint can open at the most [m]
    support: int  # the first support; -1: none
    rows: int  # of a contact, m: 3 in space (normal, two tangents), 2 in a plane
    linkage: Linkage | None  # the links; None: there are none
    bounces: bool  # whether contacts have a restitution
    softens: bool  # whether some joints have a bond that softens
    absent: np.ndarray | None = None  # (B,) bool: blocks that are not there; None: all are

    @classmethod
    def of(cls, assembly: Assembly, settings: Run, loads: RunLoads, plane: Plane | None) -> System:
        """Collect what follows from the blocks and the settings."""
        free = ~assembly.fixed
        width, inexact = assembly.width, SLACK * built_gap(assembly)
        axis, at = (-1, 0.0) if plane is None else (plane.axis, float(plane.at))
        masonry, none = PairStiffness.of(assembly), np.full(assembly.count, -1)
        blocks = BlockArrays(
            mass=assembly.mass,
            inertia=assembly.inertia,
            inverse_inertia=inverses(assembly.inertia, size_tuple(3)),
            free_index=np.where(assembly.fixed, -1, np.cumsum(free) - 1),
            support_of=assembly.support_of,
            group_of=assembly.group_of,
            stone=none if assembly.planes is None else assembly.planes.stone,
            plane_row=none if assembly.planes is None else assembly.planes.row,
            columns=np.arange(6) if plane is None else plane.columns,
        )
        return cls(
            assembly=assembly,
            settings=settings,
            loads=loads,
            plane=plane,
            free=free,
            blocks=blocks,
            constants=StepConstants(float(settings.dt), axis, at, max(TOUCHING * width, inexact)),
            laws=law_arrays(assembly.laws) if assembly.laws.by_area.any() else None,
            masonry=masonry,
            strains=Strains.of(assembly, plane, float(settings.dt)),
            reach=assembly.reach[free],
            width=width,
            inexact=inexact,
            gravity=float(np.linalg.norm(loads.acceleration, axis=1).max()),
            free_mass=np.where(assembly.fixed, 0.0, assembly.mass),
            stretch=most_stretched(assembly.laws, masonry),
            support=int(np.argmax(assembly.fixed)) if assembly.fixed.any() else -1,
            rows=3 if plane is None else 2,
            linkage=Linkage.of(assembly),
            bounces=bool(assembly.restitution.any()),
            softens=bool(assembly.laws.fracture.any()),
            absent=assembly.absent,
        )

    def with_step(self, step: float) -> System:
        """The system as steps of length h [s] see it."""
        strains = None if self.strains is None else self.strains.with_step(step)
        return replace(self, constants=self.constants._replace(step=step), strains=strains)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a free block, n: those of its motion as a rigid one, then its strain rates."""
        return len(self.blocks.columns) + (0 if self.strains is None else len(self.strains.columns))

    @property
    def bodies(self) -> int:
        """Number of bodies in the friction problem: free blocks, with those that links join counted as one."""
        return len(self.reach) if self.linkage is None else self.linkage.bodies

    @property
    def unknowns_of_a_body(self) -> int:
        """Most unknowns of such a body."""
        return self.unknowns if self.linkage is None else max(self.unknowns * self.linkage.largest, 16)

    @property
    def facets(self) -> Facets | None:
        """Those of meshed blocks; None: there are none."""
        return None if self.strains is None or self.strains.warps is None else self.strains.warps.facets

    @cached_property
    def shifting(self) -> np.ndarray:
        """Which unknowns of a block are linear velocities."""
        return np.flatnonzero(self.blocks.columns < 3)

    @cached_property
    def turning(self) -> np.ndarray:
        """Which unknowns of a block are angular velocities."""
        return np.flatnonzero(self.blocks.columns >= 3)

    @cached_property
    def turning_axes(self) -> tuple[np.ndarray, ...]:
        """Index of the components of the angular momenta (B, 3) that the unknowns of the free blocks change."""
        return np.ix_(self.free, self.blocks.columns[self.turning] - 3)

    def threads_for(self, contacts: int) -> int:
        """Threads that pay for a given number of contacts, see :func:`masonry_cd.mechanics.solvers.options.threads_that_pay`."""
        return threads_that_pay(self.settings.threads, contacts, self.rows)

    def speeds(self, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Speed of the centre of each free block with velocities (F, n), (F,), and the most that any of its points may have [m/s]."""
        centre, point = np.empty_like(self.reach), np.empty_like(self.reach)
        fill_speeds(velocity, self.blocks.columns, self.reach, centre, point)
        return centre, point

    def unknowns_of(self, velocity: np.ndarray) -> np.ndarray:
        """The unknowns (F, n) of the free blocks in velocities (B, 6) of blocks without strain rates."""
        out = np.zeros((len(self.reach), self.unknowns))
        out[:, : len(self.blocks.columns)] = velocity[self.free][:, self.blocks.columns]
        return out


@entry()
def fill_speeds(velocity: np.ndarray, columns: np.ndarray, reach: np.ndarray, centre: np.ndarray, point: np.ndarray) -> None:
    """Fill what :meth:`System.speeds` gives, by the components (k,) that the first unknowns are."""
    for b in range(len(reach)):
        shifting, turning = 0.0, 0.0
        for k in range(len(columns)):
            if columns[k] < 3:
                shifting += velocity[b, k] * velocity[b, k]
            else:
                turning += velocity[b, k] * velocity[b, k]
        centre[b] = np.sqrt(shifting)
        point[b] = centre[b] + np.sqrt(turning) * reach[b]


def plane_of(assembly: Assembly, state: State, settings: Run, loads: RunLoads) -> Plane | None:
    """The plane in which a scene moves, where there is one and the settings want it looked for."""
    if not settings.planar:
        return None
    return find_plane(assembly, state, loads.support_velocity, loads.acceleration, loads.forces)


class EnergyBalance(NamedTuple):
    """The energies of a run so far, see ``energy.py``."""

    totals: dict[str, float]  # by the names of ENERGIES [J]
    begun: float  # energy at the start of the run, that of springs included from the first step on [J]
    changed: bool = False  # blocks or joints are others since the last step, and so is the energy of springs


class MotionState(NamedTuple):
    """Motion handed from one step to the next, apart from the memories of detector and solver."""

    state: State
    angular_momentum: np.ndarray  # (B, 3) of the free blocks [kg m2/s]
    v: np.ndarray  # (F, n) velocities of the free blocks
    impulse: np.ndarray  # (C, m) of all contacts of the last step, one row at least [N s], in steps of length ``span``
    carried_impulse: np.ndarray | None  # (F, n) generalised impulse that an impact leaves to the next step, see impacts.py
    false_slip: np.ndarray  # (C, m - 1) of all contacts, one row at least, see violations.py [m]
    joints: JointMemory  # of elastic and bonded joints
    tensions: np.ndarray  # (T,) of the ties, as applied in the last step [N]
    yielded: np.ndarray  # (T,) by how much they are longer for good, by settling and by yielding [m]
    energy: EnergyBalance
    steps: int  # done so far
    ticks: int  # of the loads' sampling, that they took together
    span: int  # ticks of the last one
    approach: np.ndarray = NO_APPROACH  # (N,) at which contacts of the last step will be hit, see restitution.py [m/s]; (0,): none
    bonds: BondMemory = NO_BONDS  # that soften
