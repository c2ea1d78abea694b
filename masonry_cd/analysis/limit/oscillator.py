# SPDX-License-Identifier: GPL-3.0-or-later
r"""The mechanism of a limit analysis as an oscillator with one degree of freedom, as the kinematic approach of codes takes it.

Its bodies are the parts of the structure that move as one: blocks with still joints between them. With their weights P_k, those of the
masses on them that the push moves as well included ((P + Q)_k of [C8.7.1.5]), the virtual displacements d_k of their common centres along
the push, and the factor alpha,

    M* = (sum P d)^2 / (g sum P d^2),      e* = g M* / sum P,      a = alpha g / e*,      d = D sum P d^2 / (d_C sum P d),

where D is the displacement of a control point C at which the capacity curve has the factor alpha, and d_C its virtual displacement.

A chain of a few bodies is such an oscillator. A mechanism that dilates moves blocks that friction would leave alone, and one that spreads
over a building is many oscillators: its e* falls as more blocks move a little, and a = alpha g / e* rises without a meaning. e* = 1 is then
taken, the largest that it can be: a is the least that these bodies may have, and no displacement is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.analysis.limit.capacity import CapacityCurve
from masonry_cd.analysis.limit.mechanism import STATES, Mechanism
from masonry_cd.analysis.limit.part import FreedPart
from masonry_cd.mechanics.model.joints import Joints

DILATES = 0.01  # share of the power of the loads; the search in space leaves 0.001 at most
FEW = 8.0  # bodies of equal weight: an arch has three, the panels of a dome or of a wall that bends both ways six to eight
ANOTHER = 0.05  # share of alpha by which a curve that begins elsewhere is of another mechanism; the starts of a search differ by less
BY_CURVE, BY_LINKAGE = "capacity curve of the blocks", "linkage of bodies"
TAKES_PART = 0.5  # e* of what is one oscillator: chains that overturn or bend have 0.5 to 1; with less, most of what moves takes no part


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
    end: str = ""  # the reason why no displacement is known
    doubt: str = ""  # the reason why the mechanism is not an oscillator with one degree of freedom; then e* = 1
    by: str = ""  # how the displacements were found: BY_CURVE or BY_LINKAGE; empty where there are none

    @property
    def mass(self) -> float:
        """M* [kg]."""
        return self.fraction * self.weight / self.gravity

    @property
    def fraction(self) -> float:
        """e*; one, the safe side, of what is not an oscillator."""
        return 1.0 if self.doubt else self.by_formula

    @property
    def by_formula(self) -> float:
        """e* by its formula, also of what is not an oscillator."""
        return self.first**2 / (self.weight * self.second)

    @property
    def reach(self) -> float:
        """d of the oscillator over that of the control point."""
        return self.second / self.first

    @property
    def falls(self) -> bool:
        """Return True if the factor is known to vanish at a finite displacement."""
        return len(self.displacement) > 0

    @property
    def last(self) -> float:
        """d0*, where the factor vanishes [m]; infinite where it does not."""
        return self.reach * float(self.displacement[-1]) if self.falls else np.inf

    def load_factor(self, displacement: float = 0.0) -> float:
        """Alpha at a displacement of the oscillator [m]."""
        return self.alpha if not self.falls else float(np.interp(displacement / self.reach, self.displacement, self.factor))

    def acceleration(self, displacement: float = 0.0) -> float:
        """a at a displacement of the oscillator [m/s2]."""
        return self.load_factor(displacement) * self.gravity / self.fraction


def oscillator(part: FreedPart, moves: Mechanism, factor: float, dilation: float, curve: CapacityCurve | None = None) -> Oscillator:
    """The oscillator of a mechanism.

    Args:
        part: what is free, under its push, which may move more than the blocks.
        moves: the mechanism.
        factor: at which it starts.
        dilation: work of normal forces on joints that open, as a share of the power of the loads.
        curve: of the same push, for the displacements; None where none is requested.
    """
    assembly, live, gravity = part.assembly, part.loads.live, float(np.linalg.norm(part.push))
    moving = moves.moving & ~assembly.fixed
    weight = np.where(moving, live[:, :3] @ part.push / gravity, 0.0)
    power = np.where(moving, np.einsum("bi,bi->b", live, moves.velocity), 0.0)
    body = bodies_of(moves, part.whole.joints, moving)
    whole, work = np.bincount(body, weight), np.bincount(body, power)
    second = float(np.sum(work[whole > 0.0] ** 2 / whole[whole > 0.0]))
    doubt = _doubt(dilation, whole, float(work.sum()) ** 2 / (float(whole.sum()) * second))
    unit, reach, factors = 1.0, np.zeros(0), np.zeros(0)
    end = _no_displacement(moves, factor, curve)
    if curve is not None and not doubt and not end:
        one = curve.control.block
        there = moves.velocity[one, :3] + np.cross(moves.velocity[one, 3:], curve.control.point - assembly.centre[one])
        unit = float(there @ curve.control.direction)
        reach, factors = curve.displacement, np.clip(curve.factor, 0.0, factor)
    return Oscillator(factor, gravity, float(weight.sum()), float(work.sum()) / unit, second / unit**2, reach, factors, end, doubt)


def _no_displacement(moves: Mechanism, factor: float, curve: CapacityCurve | None) -> str:
    """Why a curve does not say where the factor of a mechanism vanishes; empty where it does, and without one."""
    if curve is None:
        return ""
    first = float(curve.factor[0])
    if abs(first - factor) > ANOTHER * abs(factor) or not moves.moving[curve.control.block]:
        return f"the capacity curve is that of another mechanism, which starts at {first:.4g}"
    return "" if curve.falls else f"the capacity curve ends before the load factor vanishes: {curve.end}"


def _doubt(dilation: float, weight: np.ndarray, fraction: float) -> str:
    """Why a mechanism is not an oscillator, by its dilation, the weights of its bodies and its e*; empty where it is one."""
    if dilation > DILATES:
        return "the mechanism dilates, its joints open as they slide"
    bodies = float(weight.sum()) ** 2 / float(np.sum(weight**2))
    if bodies > FEW:
        return f"the mechanism spreads over as much as {bodies:.0f} bodies of equal weight"
    if fraction < TAKES_PART:
        return f"{100.0 * fraction:.0f} % only of the weight that moves takes part"
    return ""


def bodies_of(moves: Mechanism, joints: Joints, moving: np.ndarray) -> np.ndarray:
    """(B,) which body each block is part of; blocks that do not move are bodies of their own."""
    held = (moves.state == STATES.index("still")) & moving[joints.block_a] & moving[joints.block_b]
    pairs = (np.ones(int(held.sum())), (joints.block_a[held], joints.block_b[held]))
    return np.asarray(connected_components(coo_matrix(pairs, (len(moving), len(moving))), directed=False)[1])
