r"""The mechanism of a limit analysis as an oscillator with one degree of freedom, as the kinematic approach of codes takes it.

Its bodies are the parts of the structure that move as one: blocks with still joints between them. With their weights P_k, the virtual
displacements d_k of their centres along the push, and the factor alpha,

    M* = (sum P d)^2 / (g sum P d^2),      e* = g M* / sum P,      a = alpha g / e*,      d = D sum P d^2 / (d_C sum P d),

where D is the displacement of a control point C at which the capacity curve has the factor alpha, and d_C its virtual displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.limit.analysis import Analysis
from masonry_cd.limit.capacity import CapacityCurve
from masonry_cd.limit.mechanism import STATES, Mechanism
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.joints import Joints


@dataclass(frozen=True, eq=False)
class Oscillator:
    """The equivalent oscillator of a mechanism."""

    alpha: float  # factor at which it starts
    gravity: float  # g [m/s2]
    weight: float  # sum P of the blocks that move [N]
    first: float  # sum P d over that of the control point [N]
    second: float  # sum P d^2 over the square of that of the control point [N]
    displacement: np.ndarray  # (n,) of the control point, from zero [m]; empty where none is known at which the factor vanishes
    factor: np.ndarray  # (n,) alpha there, at most that at which it starts; the last is zero
    end: str = ""  # why the capacity curve ends, in words

    @property
    def mass(self) -> float:
        """M* [kg]."""
        return self.first**2 / (self.gravity * self.second)

    @property
    def fraction(self) -> float:
        """e*."""
        return self.gravity * self.mass / self.weight

    @property
    def reach(self) -> float:
        """d of the oscillator over that of the control point."""
        return self.second / self.first

    @property
    def falls(self) -> bool:
        """Whether the factor is known to vanish at a finite displacement."""
        return len(self.displacement) > 0

    @property
    def last(self) -> float:
        """d0*, where the factor vanishes [m]; infinite where it does not."""
        return self.reach * float(self.displacement[-1]) if self.falls else np.inf

    def acceleration(self, displacement: float = 0.0) -> float:
        """a at a displacement of the oscillator [m/s2]."""
        there = self.alpha if not self.falls else float(np.interp(displacement / self.reach, self.displacement, self.factor))
        return there * self.gravity / self.fraction


def oscillator(analysis: Analysis, assembly: Assembly, joints: Joints, push: np.ndarray, curve: CapacityCurve | None) -> Oscillator:
    """The oscillator of the mechanism of the least factor found, or else of the associated one.

    Args:
        analysis: of a structure that stands, under a push along the direction.
        assembly: its blocks.
        joints: of them.
        push: (3,) as large as gravity, along the push [m/s2].
        curve: of the same push, for the displacements; None where none is asked for.
    """
    governing = analysis.governing
    moves, gravity = governing.mechanism, float(np.linalg.norm(push))
    weight = np.where(moves.moving & ~assembly.fixed, gravity * assembly.mass, 0.0)
    along = moves.velocity[:, :3] @ push / gravity
    body = _bodies(moves, joints, weight > 0.0)
    whole, work = np.bincount(body, weight), np.bincount(body, weight * along)
    second = float(np.sum(work[whole > 0.0] ** 2 / whole[whole > 0.0]))
    unit, reach, factor = 1.0, np.zeros(0), np.zeros(0)
    if curve is not None and curve.falls and moves.moving[curve.control.block]:
        unit = float(moves.velocity[curve.control.block, :3] @ curve.control.direction)
        reach, factor = curve.displacement, np.clip(curve.factor, 0.0, governing.factor)
    end = "" if curve is None else curve.end
    return Oscillator(governing.factor, gravity, float(weight.sum()), float(work.sum()) / unit, second / unit**2, reach, factor, end)


def _bodies(moves: Mechanism, joints: Joints, moving: np.ndarray) -> np.ndarray:
    """(B,) which body each block is part of; blocks that do not move are bodies of their own."""
    held = (moves.state == STATES.index("still")) & moving[joints.block_a] & moving[joints.block_b]
    pairs = (np.ones(int(held.sum())), (joints.block_a[held], joints.block_b[held]))
    return np.asarray(connected_components(coo_matrix(pairs, (len(moving), len(moving))), directed=False)[1])
