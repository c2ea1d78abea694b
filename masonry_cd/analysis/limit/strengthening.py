# SPDX-License-Identifier: GPL-3.0-or-later
r"""The least strengthening: which yield forces of candidate ties bring all mechanisms to the factors that are asked of them.

Ties with yield forces F take up F . w in a mechanism v, with w_i the rate at which tie i grows longer over the power w_1 . v of the loads,
and nothing where it is slack. A mechanism that starts at the factor alpha under forces F_0 starts under others at

    lambda(F) = alpha + w . (F - F_0)

by virtual work, which is an upper bound of the associated factor for every F, and exact at F_0. So each mechanism that starts too early is
a cut of a linear programme, or with prices of anchors of a mixed one (both by HiGHS):

    min  sum_i c_i F_i + a_i y_i      alpha_k + w_k . (F - F_k) >= asked_k   of all mechanisms k,      0 <= F_i <= most_i y_i,   y_i 0 or 1.

Its forces are those of least cost that these mechanisms ask for; what then starts too early is the next cut (Kelley, J. SIAM 8, 1960). For
associated sliding the factor is concave in F and the answer is the least cost. Mechanisms that slide without dilation are cuts in the same
way; that a tie presses joints together and so raises friction is then left out, which costs rather too much than too little.

**Prices.** The multipliers y_k of the cuts say that a factor higher by d costs d sum_k y_k, and that one N more in tie i, with the others
adjusted at equal cost, is worth sum_k y_k w_ki / sum_k y_k in factor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, linprog, milp

from masonry_cd.analysis.limit.analysis import STANDS
from masonry_cd.analysis.limit.crushing import solved_finely
from masonry_cd.analysis.limit.found import ASSOCIATED, FoundMechanism, dilation, found_in
from masonry_cd.analysis.limit.macro import HELD, MOST
from masonry_cd.analysis.limit.mechanism import mechanism
from masonry_cd.analysis.limit.part import FreedPart, Whole, part_of
from masonry_cd.analysis.limit.problem import Bars, bar_rows
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.mechanics.model.blocks import Assembly

NOTHING = 1e-6  # share of its largest force below which a tie is none
REACHED = 1e-9  # share of the target that a cut may miss
GAP = 1e-9  # of mixed programmes, over the cost


@dataclass(frozen=True, eq=False)
class Candidates:
    """N ties of unknown yield force, each of a bar or of a bundle; T bars in all."""

    bars: Bars  # T, with the share of its tie's force as strength
    tie: np.ndarray  # (T,) the tie of each
    most: np.ndarray  # (N,) largest yield force [N]
    per_force: np.ndarray  # (N,) price of the tie over its yield force [1/N]
    anchors: np.ndarray  # (N,) price of its anchors

    def bars_at(self, force: np.ndarray) -> Bars:
        """The bars of the ties with yield forces (N,) [N] above zero."""
        some = force[self.tie] > 0.0
        return Bars(self.bars.blocks[some], self.bars.points[some], (self.bars.strength * force[self.tie])[some])

    def growth(self, assembly: Assembly, velocity: np.ndarray) -> np.ndarray:
        """(N,) the rate at which each tie grows longer under velocities (B, 6) of the blocks, zero where it is slack."""
        rates = np.einsum("red,red->r", bar_rows(assembly, self.bars), velocity[self.bars.blocks])
        return np.bincount(self.tie, self.bars.strength * np.maximum(rates, 0.0), minlength=len(self.most))

    def cost(self, force: np.ndarray) -> float:
        """The cost of ties with yield forces (N,)."""
        return float(self.per_force @ force + self.anchors @ (force > 0.0))


@dataclass(frozen=True, eq=False)
class EarlyMechanism:
    """A mechanism that starts too early."""

    words: str  # which, of what and under which push
    alone: float  # its factor without any candidate
    worth: np.ndarray  # (N,) w: its factor for each N of a tie
    asked: float  # least factor that is asked of it
    of_target: bool = True  # False: of the dead loads, which are borne in full whatever the target
    dilates: bool = True  # False: found by the search for the least factor, and no cut of associated sliding


class OutOfReach(ValueError):
    """Raised where the candidates at their largest force leave a mechanism below what is asked; ``cut`` is that mechanism."""

    def __init__(self, cut: EarlyMechanism, most: float) -> None:
        super().__init__(cut.words)
        self.cut, self.most = cut, most


@dataclass(frozen=True, eq=False)
class Least:
    """The forces of least cost for some cuts."""

    force: np.ndarray  # (N,) [N]
    cost: float
    worth: np.ndarray  # (N,) of one N more, in factor, the others adjusted at equal cost
    one_more: float  # cost of one per cent more of the target


def cut_of(
    candidates: Candidates, assembly: Assembly, found: FoundMechanism, force: np.ndarray, asked: float, words: str
) -> EarlyMechanism:
    """The cut of a mechanism that was found with ties of yield forces (N,)."""
    assert found.mechanism is not None
    worth = candidates.growth(assembly, found.mechanism.velocity) / found.oscillator.first
    return EarlyMechanism(words, found.oscillator.alpha - float(worth @ force), worth, asked, dilates=found.source.startswith(ASSOCIATED))


def least_forces(candidates: Candidates, cuts: Sequence[EarlyMechanism], fewest: bool = False) -> Least:
    """The yield forces of least cost for some cuts.

    Args:
        candidates: ties.
        cuts: on them.
        fewest: as few ties as can be, and of these the least cost.

    Raises:
        OutOfReach: a mechanism that no forces bring to what is asked.
    """
    count, most = len(candidates.most), candidates.most
    if not cuts:
        return Least(np.zeros(count), 0.0, np.zeros(count), 0.0)
    sides = np.array([cut.worth for cut in cuts]) * most  # of forces over their largest
    right = np.array([cut.asked - cut.alone for cut in cuts])
    short = right - sides.sum(axis=1)
    worst = int(np.argmax(short))
    if short[worst] > REACHED * cuts[worst].asked:
        raise OutOfReach(cuts[worst], cuts[worst].alone + float(sides[worst].sum()))
    right = np.minimum(right, sides.sum(axis=1))
    prices, chosen = candidates.per_force * most, np.ones(count, dtype=bool)
    if fewest or candidates.anchors.any():
        each = candidates.anchors + (1.0 + prices.sum() + candidates.anchors.sum() if fewest else 0.0)
        of_chosen = np.hstack([-np.eye(count), np.eye(count)])
        both = [LinearConstraint(np.hstack([sides, 0.0 * sides]), right), LinearConstraint(of_chosen, 0.0)]
        whole, limits = np.repeat([0, 1], count), Bounds(0.0, 1.0)
        answer = milp(np.concatenate([prices, each]), constraints=both, integrality=whole, bounds=limits, options={"mip_rel_gap": GAP})
        chosen = answer.x[count:] > 0.5
    bounds = np.stack([np.zeros(count), chosen], axis=1)
    answer = linprog(prices, A_ub=-sides, b_ub=-right, bounds=bounds, method="highs-ds")
    share = np.where(answer.x > NOTHING, answer.x, 0.0)
    multiplier = np.maximum(-answer.ineqlin.marginals, 0.0)
    total = float(multiplier.sum())
    worth = (multiplier @ sides) / most / total if total else np.zeros(count)
    of_target = np.array([cut.asked if cut.of_target else 0.0 for cut in cuts])
    force = share * most
    return Least(force, candidates.cost(force), worth, 0.01 * float(multiplier @ of_target))


def associated(whole: Whole, free: np.ndarray, way: np.ndarray) -> FoundMechanism | None:
    """The associated mechanism of free blocks (B,) under a push along a direction (3,), all else held; None of what is held.

    Raises:
        Unbounded: the dead loads are not borne under any factor, or no answer.
    """
    part = part_of(whole, free, way)
    problem, best = solved_finely(part.problem, lambda finer: largest(finer, finer.dead, finer.live, MOST))
    if best.factor >= HELD * MOST:
        return None
    return found_in(replace(part, problem=problem), ASSOCIATED, best, dilation(problem, best))


def falling(
    candidates: Candidates, whole: Whole, free: np.ndarray, way: np.ndarray, force: np.ndarray, words: str
) -> EarlyMechanism | None:
    """The cut of the mechanism by which free blocks (B,) fall under the dead loads, with ties of yield forces (N,); None where they stand.

    Raises:
        Unbounded: no answer.
    """
    part: FreedPart = part_of(whole, free, way)
    problem, best = solved_finely(part.problem, lambda finer: largest(finer, np.zeros_like(finer.dead), finer.dead, 1.0))
    if best.factor >= 1.0 - STANDS:
        return None
    velocity = mechanism(problem, part.assembly, whole.joints, best.velocity).velocity
    power = float(np.sum(part.loads.dead[free] * velocity[free]))
    worth = candidates.growth(whole.assembly, velocity) / power
    return EarlyMechanism(words, best.factor - float(worth @ force), worth, 1.0, of_target=False)
