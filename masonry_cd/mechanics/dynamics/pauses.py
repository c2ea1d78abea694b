# SPDX-License-Identifier: GPL-3.0-or-later
r"""Shocks in a row: the pauses between them end as soon as the structure is still; what each shock leaves behind.

The loads of a run are laid out over steps k = 0 .. N in which every pause has its full length. The step of the loads runs next to that
of the run; in a pause of the loads, during which nothing changes, it jumps to the end of the pause once

    max (|v| + |w| r)  over the blocks that stand   <   the pause's speed       for its ``hold`` steps in a row,

r being the farthest corner of a block from its centre. Velocities are those of the step or, where that is slower, the mean of it and the
step before: a loose stone that rattles to and fro between its neighbours, in one step each way, goes nowhere. A block that has fallen (it
has dropped by more than DROP of its height, or is turned by more than TILT) may roll on the ground for as long as it likes. Spheres are
fill, which settles and rolls without harm: one has fallen when it has dropped and lies outside the plan of the structure as built, as what
runs out of a wall does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.shocks import Pause, Shock
from masonry_cd.mechanics.model.state import State, rotation_matrices

DROP = 0.5  # of a block's height
TILT = 45.0  # [degrees]
STILL = 1e-3  # speed below which a block counts as still at the end of a run [m/s]
ALIKE = 1e-6  # share of the largest motion of a support by which others may differ and count as moving alike
HOLD = 0.5  # for which all blocks have to be still [s]


@dataclass(frozen=True)
class Aftermath:
    """A shock whose rest is over, in the time of the run."""

    name: str
    start: float  # [s]
    end: float  # from when on the base stands still [s]
    frame: int  # at the end of the rest


class Pauses:
    """Leads the loads through their pauses.

    Args:
        assembly: the blocks.
        pauses: that may end early.
        shocks: in order of time.
        steps: N of the loads.
    """

    def __init__(self, assembly: Assembly, pauses: Sequence[Pause], shocks: Sequence[Shock], steps: int) -> None:
        self.quiet = 0  # steps of the loads in a row in which all that stands was still
        ends = [(each.first, each.last) for each in pauses] + [(each.first, each.last) for each in shocks]
        self.stops = sorted({step for pair in ends for step in pair})  # of the loads, at which something begins or ends
        self._assembly, self._pauses, self._shocks = assembly, pauses, shocks
        self._over = [*(shock.first for shock in shocks[1:]), steps][: len(shocks)]  # where the rest after each shock ends
        self._built = standing_of(assembly)
        self._reach = assembly.reach

    def watch(self, assembly: Assembly) -> None:
        """Go on with blocks of which others are free."""
        self._assembly = assembly

    @property
    def has_shocks(self) -> bool:
        """Return True if there are shocks to report on; a run that only goes on until its blocks are still has none."""
        return bool(self._shocks)

    def next_step(self, load_step: int, state: State, made: int = 1, earlier: np.ndarray | None = None) -> int:
        """The step of the loads at which to go on after ``load_step``, with the state that it led to by ``made`` of them at once.

        ``earlier``: velocities (B, 6) before the step; None: not known.
        """
        pause = next((p for p in self._pauses if p.first < load_step < p.last), None)
        if pause is None:
            self.quiet = 0
            return load_step
        self.quiet = self.quiet + made if self._fastest(state, earlier) < pause.speed else 0
        return pause.last if self.quiet >= pause.hold else load_step

    def over(self, before: int, after: int) -> Shock | None:
        """The shock whose rest ends when the loads go on from one step to another."""
        return next((shock for shock, end in zip(self._shocks, self._over, strict=True) if before < end <= after), None)

    def _fastest(self, state: State, earlier: np.ndarray | None) -> float:
        """The largest speed of a point of a block that stands [m/s]."""
        standing = ~self._assembly.fixed & ~fallen(self._assembly, self._built, state)
        speed = self._speeds(state.velocity)
        if earlier is not None:
            speed = np.minimum(speed, self._speeds(0.5 * (state.velocity + earlier)))
        return float(speed[standing].max(initial=0.0))

    def _speeds(self, velocity: np.ndarray) -> np.ndarray:
        """Return the speed of the fastest point of each block with velocities (B, 6), (B,) [m/s]."""
        return np.asarray(np.linalg.norm(velocity[:, :3], axis=1) + np.linalg.norm(velocity[:, 3:], axis=1) * self._reach)


@dataclass(frozen=True)
class FallSigns:
    """Signs by which B blocks are known to have fallen."""

    height: np.ndarray  # (B,) of which a drop is a share [m]
    rolls: np.ndarray  # (B,) spheres
    plan: np.ndarray  # (B, 2, 2) low and high x, y of the structure of each [m]


def standing_of(assembly: Assembly) -> FallSigns:
    """That of the blocks as built."""
    height = np.array([np.ptp(block.vertices[:, 2]) for block in assembly.blocks])
    return FallSigns(height, np.array([block.radius > 0.0 for block in assembly.blocks]), plans_of(assembly.blocks))


def plans_of(blocks: Sequence[Block]) -> np.ndarray:
    """Low and high x, y (B, 2, 2) of all free blocks of the structure that each block belongs to, as built [m]."""
    corners: dict[str, list[np.ndarray]] = {}
    for block in blocks:
        own = corners.setdefault(block.structure, [])
        own += [] if block.fixed else [block.vertices[:, :2].min(axis=0), block.vertices[:, :2].max(axis=0)]
    nowhere = np.full((1, 2), np.inf)
    boxes = {name: np.stack([np.min(own or nowhere, axis=0), np.max(own or -nowhere, axis=0)]) for name, own in corners.items()}
    return np.array([boxes[block.structure] for block in blocks])


def outside(plan: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(B,) True where a place (B, 3) is beyond a plan (B, 2, 2)."""
    return np.asarray(((place[:, :2] < plan[:, 0]) | (place[:, :2] > plan[:, 1])).any(axis=1))


def fallen(assembly: Assembly, standing: FallSigns, state: State) -> np.ndarray:
    """(B,) True where a block has dropped or is turned, relative to the base, by more than DROP or TILT say.

    A sphere has fallen where it has dropped and lies outside the plan of its structure.

    The base is the support that has moved least, the first of equals, so that one which settles takes no block with it.
    """
    moved = state.position - assembly.centre
    base = moved[_staying(assembly, state)] if assembly.fixed.any() else np.zeros(3)
    turn = 0.5 * (np.trace(rotation_matrices(state.orientation), axis1=1, axis2=2) - 1.0)  # cosine
    dropped = base[2] - moved[:, 2] > DROP * standing.height
    out = dropped & outside(standing.plan, state.position - base)
    return np.asarray(np.where(standing.rolls, out, dropped | (turn < math.cos(math.radians(TILT)))))


def _staying(assembly: Assembly, state: State) -> int:
    """The support that has moved least, the first of those that have moved alike."""
    fixed = np.flatnonzero(assembly.fixed)
    shift = state.position[fixed] - assembly.centre[fixed]
    far = np.sqrt((shift * shift).sum(axis=1))
    return int(fixed[np.argmax(far <= far.min() + ALIKE * far.max())])
