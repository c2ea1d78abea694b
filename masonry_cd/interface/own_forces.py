# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces and motions that Python gives, on top of those of the scene's loads, as the step asks for them: at the places of its middle, q_m.

A field is a function ``f(now)`` of all blocks at once, a history the force on one block over time, with a moment where it has six columns.
Both enter the free velocity as point loads do, so they are explicit: one that grows with displacement, of stiffness k on a mass m, needs a
time step below 2 sqrt(m / k). Blocks whose motion is given become supports, see :mod:`masonry_cd.interface.own_motions`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from loads.acted import Acted, by_integral
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.signatures import require_call
from masonry_cd.interface.values import numbers
from masonry_cd.mechanics.model.block_forces import Acting, BlockForces
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.place_on_block import require_on_block

ROUNDING = 1e-9  # share of the largest force
WRENCH = 6  # numbers of a force and a moment, or of a linear and an angular velocity
LOOKS = 65  # times over the run at which forces are looked at to tell whether the scene moves in a plane


class Now(NamedTuple):
    """The blocks in the middle of a step, as a field of forces sees them; its arrays are not to be changed."""

    time: float  # of the loads, in the middle of the step [s]
    position: np.ndarray  # (B, 3) centres of mass [m]
    rotation: np.ndarray  # (B, 3, 3) body to world
    velocity: np.ndarray  # (B, 6) at the beginning of the step, linear [m/s] and angular [rad/s]
    step: float  # its length [s]


@dataclass(frozen=True, eq=False)
class Force:
    """A force on a block with its point of attack, for ``forces`` of a :class:`masonry_cd.Simulation`.

    Attributes:
        history: of the force (3,) [N], or of force and moment (6,) [N, N m], in the world axes: a function of time [s], or times (N,) and
            values (N, 3 or 6). The moment is in addition to that of the force about the centre of mass.
        at: the point of attack as built, in the world, which moves with the block (3,) [m]; the centre of mass when not given.
    """

    history: Any
    at: Sequence[float] | None = None


class Pushes(NamedTuple):
    """Forces on blocks at points, and moments."""

    block: np.ndarray  # (N,)
    force: np.ndarray  # (N, 3) [N]
    arm: np.ndarray  # (N, 3) from the centre of mass [m]
    moment: np.ndarray | None = None  # (N, 3) in addition to those of the arms [N m]; None: there are none

    @classmethod
    def of(cls, block: np.ndarray, wrench: np.ndarray, arm: np.ndarray) -> Pushes:
        """Return the pushes of forces (N, 3) [N], or of forces and moments (N, 6) [N, N m]."""
        return cls(block, wrench[:, :3], arm, wrench[:, 3:] if wrench.shape[1] == WRENCH else None)


class Pushing(Protocol):
    """A source of forces on blocks. By default it remembers nothing."""

    keeps_plane: bool = False  # whether what leads out of the plane of a scene cancels in it

    def pushes(self, now: Now) -> Pushes:
        """The forces in the middle of a step. It may be asked several times for one step, and does not count steps by it."""

    def taken(self) -> None:
        """Accept the last requested step."""
        return

    def update_blocks(self, absent: np.ndarray | None) -> None:
        """Blocks (B,) bool are absent now; None: all are there."""
        return

    def copied(self) -> Pushing:
        """A copy with the same history, independent of this one."""
        return self


class ForceHistory:
    """A quantity over time: a function of it, or times (N,) and values (N, k), straight between and constant beyond.

    Args:
        given: the function, or the pair of arrays.
        sizes: k that are taken.
        where: for messages.

    Raises:
        InputError: anything else.
    """

    def __init__(self, given: Any, sizes: tuple[int, ...], where: str) -> None:
        self._where, self._sizes, self._function = where, sizes, given if callable(given) else None
        if self._function is not None:
            require_call(self._function, "time", where)
            return
        if not isinstance(given, Sequence) or isinstance(given, str | bytes) or len(given) != 2:
            raise InputError(where, "a function of time is needed, or a pair of arrays (times, values)")
        self._time, values = (numbers(item, where) for item in given)
        if self._time.ndim != 1 or values.ndim != 2 or values.shape[1] not in sizes or len(values) != len(self._time) or not len(values):
            raise InputError(where, f"times (N,) and values (N, {self._wanted}) are needed, got {self._time.shape} and {values.shape}")
        if (np.diff(self._time) <= 0.0).any():
            raise InputError(where, "its times do not increase")
        self._values = values

    @property
    def _wanted(self) -> str:
        return " or ".join(map(str, self._sizes))

    def at(self, time: float) -> np.ndarray:
        """(k,) at a time [s].

        Raises:
            InputError: the function gives something else than finite numbers of that shape.
        """
        if self._function is None:
            return np.array([np.interp(time, self._time, column) for column in self._values.T])
        found = numbers(self._function(time), f"{self._where}: at {time:g} s")
        if found.ndim != 1 or len(found) not in self._sizes:
            raise InputError(self._where, f"at {time:g} s an array of shape {found.shape}, ({self._wanted},) is needed")
        return found

    def acted(self, measure: str) -> Acted | None:
        """How much of arrays has acted by a time, by the integral of their size up to their last time; None of a function."""
        return None if self._function is not None else by_integral(self._where, measure, self._time, self._values)


class BlockHistories(Pushing):
    """Forces on single blocks over time.

    Raises:
        InputError: an unknown block, a support, no history, or a point off its block.
    """

    def __init__(self, given: Mapping[str, Any], assembly: Assembly) -> None:
        self._block = np.array([free_block(name, assembly, "forces") for name in given], dtype=np.int64)
        forces = [value if isinstance(value, Force) else Force(value) for value in given.values()]
        self._histories = [ForceHistory(force.history, (3, WRENCH), f'forces["{name}"]') for name, force in zip(given, forces, strict=True)]
        self._arms = np.zeros((len(forces), 3))  # body frames
        for i, (name, force) in enumerate(zip(given, forces, strict=True)):
            if force.at is not None:
                where, block = f'forces["{name}"].at', self._block[i]
                at = numbers(force.at, where, (3,))
                require_on_block(assembly.blocks[block], tuple(at.tolist()), where)
                self._arms[i] = at - assembly.centre[block]
        self._at_points = bool(self._arms.any())
        self.acted = tuple(acted for history in self._histories if (acted := history.acted("impulse")) is not None)

    def pushes(self, now: Now) -> Pushes:
        """The forces at a time."""
        values = [history.at(now.time) for history in self._histories]
        arms = np.sum(now.rotation[self._block] * self._arms[:, None, :], axis=-1) if self._at_points else self._arms
        if all(len(value) == 3 for value in values):
            return Pushes(self._block, np.array(values), arms)
        return Pushes.of(self._block, np.array([np.pad(value, (0, WRENCH - len(value))) for value in values]), arms)


class Field(Pushing):
    """A field of forces on all blocks."""

    def __init__(self, function: Callable[[Now], Any], assembly: Assembly) -> None:
        require_call(function, "now", "forces")
        self._function, self._fixed = function, assembly.fixed

    def pushes(self, now: Now) -> Pushes:
        """The forces at the places of now; those on supports do nothing, and are left out.

        Raises:
            InputError: no forces (B, 3), or forces and moments (B, 6), or such as are not finite.
        """
        found = numbers(self._function(now), f"forces: at {now.time:g} s")
        if found.shape not in ((len(self._fixed), 3), (len(self._fixed), WRENCH)):
            raise InputError(f"forces: at {now.time:g} s", f"an array of shape ({len(self._fixed)}, 3 or 6) is needed, got {found.shape}")
        block = np.flatnonzero(~self._fixed & found.any(axis=1))
        return Pushes.of(block, found[block], np.zeros((len(block), 3)))


@dataclass(eq=False)
class OwnForces:
    """The forces of a scene's loads, and own ones with them: in the shape in which the step asks for forces.

    ``axis`` is that across the plane in which the scene is solved, -1 in space; known once there is a stepper.
    """

    base: BlockForces | None
    own: tuple[Pushing, ...]
    dt: float
    end: float = 0.0  # of the run [s]
    axis: int = -1
    last: Now | None = None  # the last requested places

    def acting(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: int,
        ticks: int = 1,
        yielded: np.ndarray | None = None,
    ) -> Acting:
        """Return the forces over some steps from one on, see :class:`masonry_cd.mechanics.model.block_forces.BlockForces`.

        Raises:
            InputError: own forces that are not numbers, or lead out of the plane in which the scene is solved.
        """
        self.last = Now((step - 1 + 0.5 * ticks) * self.dt, position, rotation, velocity, ticks * self.dt)
        every = self._pushes(self.last) if step > 0 else []  # at 0 it is asked what ties pull with at the start
        none = np.zeros((0, 3))
        found = Acting(np.zeros(0, dtype=np.int64), none, none, np.zeros(0))
        if self.base is not None:
            found = self.base.acting(position, rotation, velocity, step, ticks, yielded)
        block = np.concatenate([found.block, *(item.block for item in every)])
        force, arm = (np.concatenate([getattr(found, name), *(getattr(item, name) for item in every)]) for name in ("force", "arm"))
        given = [(found.force, found.moment), *((item.force, item.moment) for item in every)]
        if all(moment is None for _, moment in given):
            return Acting(block, force, arm, found.tension)
        moments = np.concatenate([np.zeros_like(force) if moment is None else moment for force, moment in given])
        return Acting(block, force, arm, found.tension, moments)

    @property
    def guides(self) -> tuple[Guide, ...]:
        """Those of the scene's loads."""
        return () if self.base is None else self.base.guides

    def _pushes(self, now: Now) -> list[Pushes]:
        every = [item.pushes(now) for item in self.own]
        if self.axis >= 0 and any(_across(found, self.axis) for item, found in zip(self.own, every, strict=True) if not item.keeps_plane):
            raise InputError(
                "forces",
                f"at {now.time:g} s one acts along {'xyz'[self.axis]}, across the plane in which this scene moves, or turns out of it; "
                "run.planar = false has it move in space",
            )
        return every

    def copied(self) -> OwnForces:
        """A copy with the same history, independent of this one."""
        return replace(self, own=tuple(item.copied() for item in self.own))

    def taken(self) -> None:
        """A step was made."""
        for item in self.own:
            item.taken()

    def spread(self, step: int, ticks: int, assembly: Assembly) -> float:
        """Largest acceleration [m/s2] by which what acts differs in time from its mean over some steps, where blocks last were."""
        base = 0.0 if self.base is None else self.base.spread(step, ticks, assembly)
        if self.last is None or not self.own:
            return base
        total = np.zeros((2, ticks, assembly.count, 3))  # forces, and moments in addition to those of arms
        for k in range(ticks):
            for item in self._pushes(self.last._replace(time=(step - 0.5 + k) * self.dt)):
                for kind, each in enumerate((item.force, item.moment)):
                    if each is not None:
                        np.add.at(total[kind, k], item.block, each)
        away = np.sqrt(((total - total.mean(axis=1, keepdims=True)) ** 2).sum(axis=3))
        against = np.where(assembly.fixed, np.inf, [assembly.mass, assembly.turning_mass])
        return max(base, float((away / against[:, None]).max(initial=0.0)))

    @property
    def there(self) -> np.ndarray:
        """Which ties of the loads are there, (T,) bool."""
        return np.zeros(0, dtype=bool) if self.base is None else self.base.there

    @property
    def switches(self) -> Mapping[str, bool]:
        """Ties and guides of the loads that can come and go, by name, and whether they are there."""
        return {} if self.base is None else self.base.switches

    def switched(self, there: Mapping[str, bool]) -> OwnForces:
        """The forces whose ties and guides of some names are there or not."""
        return replace(self, base=None if self.base is None else self.base.switched(there))

    @property
    def jacked(self) -> np.ndarray:
        """Which ties of the loads keep their first tension while the structure settles, (T,) bool."""
        return np.zeros(0, dtype=bool) if self.base is None else self.base.jacked

    def ties_alone(self) -> BlockForces:
        """The ties of the loads."""
        return OwnForces(None if self.base is None else self.base.ties_alone(), (), self.dt)

    def stretches(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Return the elongation of each tie of the loads, (T,) [m]."""
        return np.zeros(0) if self.base is None else self.base.stretches(position, rotation)

    def yields(self, position: np.ndarray, rotation: np.ndarray, yielded: np.ndarray) -> np.ndarray:
        """Return the permanent stretch of each tie of the loads, (T,) [m], after ``yielded`` (T,) before."""
        return yielded if self.base is None else self.base.yields(position, rotation, yielded)

    def leaves_plane(self, axis: int, at: float, centre: np.ndarray) -> bool:
        """True when forces of the loads do, or own ones on blocks at rest at some time of the run; others are checked as the run goes."""
        if self.base is not None and self.base.leaves_plane(axis, at, centre):
            return True
        still = Now(0.0, centre, np.broadcast_to(np.eye(3), (len(centre), 3, 3)), np.zeros((len(centre), 6)), self.dt)
        looked_at = [item for item in self.own if not item.keeps_plane]
        times = np.linspace(0.0, self.end, LOOKS).tolist() if looked_at else []
        return any(_across(item.pushes(still._replace(time=t)), axis) for t in times for item in looked_at)


def _across(pushes: Pushes, axis: int) -> bool:
    """True where a force acts along an axis, or its moment about the centre of mass is about another, by more than rounding."""
    along = np.abs(pushes.force[:, axis])
    if (along > ROUNDING * np.abs(pushes.force).max(initial=0.0)).any():
        return True
    if pushes.arm.any():  # a force in the plane at a point off it
        size, arm = np.abs(pushes.force).max(axis=1), np.abs(pushes.arm)
        if (size * arm[:, axis] > ROUNDING * float(size.max()) * float(arm.max())).any():
            return True
    if pushes.moment is None:
        return False
    moment = np.abs(pushes.moment)
    return bool((moment[:, [d for d in range(3) if d != axis]] > ROUNDING * moment.max(initial=0.0)).any())


def own_forces(given: Any, assembly: Assembly) -> Pushing:
    """A field of forces, or forces on single blocks by name.

    Raises:
        InputError: anything else.
    """
    if isinstance(given, Mapping):
        return BlockHistories(given, assembly)
    if callable(given):
        return Field(given, assembly)
    raise InputError("forces", f"a function or a dict by block is needed, got a {type(given).__name__}")


def block_named(name: object, names: Sequence[str], where: str) -> int:
    """The number of a block.

    Raises:
        InputError: there is none of the name.
    """
    if name not in names:
        raise InputError(where, f'no block is named "{name}"{suggest(str(name), names)}')
    return names.index(str(name))


def free_block(name: object, assembly: Assembly, where: str) -> int:
    """The number of a free block.

    Raises:
        InputError: there is none of the name, or it is a support.
    """
    block = block_named(name, assembly.names, where)
    if assembly.fixed[block]:
        raise InputError(where, f'"{name}" is a support, which moves as its loads and "motions" say')
    return block
