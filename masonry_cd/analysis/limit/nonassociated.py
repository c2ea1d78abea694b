# SPDX-License-Identifier: GPL-3.0-or-later
r"""Coulomb friction that does not dilate, in a plane: the least factor that is found.

Sliding that opens nothing, u_n = 0, is not the associated flow rule, and the factor of collapse is then not unique. A factor belongs to it
when forces and velocities satisfy together, with r' = r + a n and u_t = s_1 - s_2,

    r as in the static problem, v with u_n >= 0 and w_1 . v = 1,
    u_n (r_n + f) = 0,    s_1 (mu r'_n + r_t) = 0,    s_2 (mu r'_n - r_t) = 0.

The least is a linear programme with complementarity constraints (Ferris & Tin-Loi, Int. J. Mech. Sci. 43, 2001). It is sought in two moves.

1. **A sequence of associated problems** (Gilbert, Casapulla & Ahmed, Computers & Structures 84, 2006): the cone at each point is replaced
   by the strip |r_t| <= mu N_k, whose flow rule opens nothing. N_k is renewed from the normal forces found, N_k+1 = b N_k + (1 - b) r'_n,
   until they agree. Its mechanism is that of a problem without dilation.
2. **Descent between forces and velocities.** The products above are a sum g(r, v) that is linear in each. For the mechanism at hand the
   forces of least lambda + M g are found, for these forces the velocities of least g, and so on: linear programmes both.

A pair with g = 0 is a proof that its factor is one of those that Coulomb's law allows; that no other is less is no proof but the
agreement of starts. The first begins at the normal forces of the associated problem, which wedge blocks between their neighbours wherever
that bears more. The second begins at the least normal forces in equilibrium, which press together nothing that need not be, and keeps them
in move 1. The others are random, by turns around the one and the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, diags, hstack, identity, vstack

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Optimum

STEPS = 40  # of the sequence at most
SETTLED = 1e-5  # change of the factor, as a share of it, at which the sequence ends
ROUNDS = 6  # of the descent at most
PENALTY = 1e4  # M, over w_1 . v = 1
STUCK = 1e-12  # shares of factor and g that a round of the descent changes at least
EXACT = 1e-7  # g of a pair that counts, as a share of the power of the loads
ALIKE = 2e-3  # factors that differ by no more than this share of the least agree
AGREE = 2  # starts that come to the least factor before it counts as known: one start alone may miss it

Pair = tuple[Optimum, float]  # forces and velocities, and g over the power of the loads


@dataclass(frozen=True, eq=False)
class LeastFound:
    """The least factor of sliding without dilation that was found."""

    optimum: Optimum
    gap: float  # g over the power of the loads
    starts: int
    ends: tuple[Optimum, ...]  # of each start that came to an end

    @property
    def found(self) -> tuple[float, ...]:
        """The factors of the starts that came to an end."""
        return tuple(end.factor for end in self.ends)

    @property
    def agreeing(self) -> int:
        """Starts that came to it."""
        best = self.optimum.factor
        return sum(factor <= best + ALIKE * abs(best) for factor in self.found)

    @property
    def agreed(self) -> bool:
        """Whether starts enough came to it for it to count as known, which is no proof that it is the least."""
        return self.agreeing >= AGREE

    @property
    def spread(self) -> float:
        """The largest factor found less the least, over the least."""
        return (max(self.found) - self.optimum.factor) / max(abs(self.optimum.factor), 1e-300)


def merged(one: LeastFound | None, other: LeastFound | None, starts: int) -> LeastFound | None:
    """Two searches as one of so many starts; None where neither found anything."""
    both = [each for each in (one, other) if each is not None]
    if not both:
        return None
    best = min(both, key=lambda each: each.optimum.factor)
    return LeastFound(best.optimum, best.gap, starts, tuple(end for each in both for end in each.ends))


def least_factor(problem: LimitProblem, associated: Optimum, starts: int, seed: int) -> LeastFound | None:
    """The least factor of a planar problem, None where no start came to an exact pair.

    Args:
        problem: in a plane.
        associated: its associated answer, where the first start begins.
        starts: how many.
        seed: of the random ones.
    """
    programmes = _Search(problem)

    def search(normal: np.ndarray, blend: float) -> Pair | None:
        velocity = programmes.sequence(normal, blend)
        return None if velocity is None else programmes.descend(velocity)

    return least_of_starts(search, (associated.force[:, 0] + problem.apex, programmes.least_normal), starts, seed)


def descend(problem: LimitProblem, velocity: np.ndarray) -> Pair | None:
    """The exact pair of least factor that a descent from a mechanism (unknowns,) comes to, None where there is none."""
    return _Search(problem).descend(velocity)


def least_of_starts(
    search: Callable[[np.ndarray, float], Pair | None],
    given: tuple[np.ndarray, Callable[[], np.ndarray | None]],
    starts: int,
    seed: int,
    begin: int = 0,
) -> LeastFound | None:
    """The least pair of a search from several normal forces, None where no start came to an end.

    Args:
        search: a pair from normal forces r'_n (P,) and a blend b of the sequence, None where it comes to no end.
        given: (P,) normal forces of the first start, whose blend is a half, and a function for those of the second, whose blend is one.
            Where that gives None, all others are around the first.
        starts: how many.
        seed: of the normal forces and blends of the others.
        begin: number of the first start that is made; those before it are left out.
    """
    random = np.random.default_rng(seed)
    ends: list[Pair] = []
    first, least = given[0], given[1]() if starts > 1 else None
    for start in range(starts):
        normal, blend = first, 0.5
        if start % 2 and least is not None:
            normal, blend = least * (1.0 if start == 1 else random.uniform(0.5, 1.5, len(least))), 1.0
        elif start:
            normal = first * random.random(len(first)) + random.exponential(float(first.mean()), len(first))
            blend = 0.3 + 0.4 * float(random.random())
        end = search(normal, blend) if start >= begin else None
        if end is not None:
            ends.append(end)
    if not ends:
        return None
    best, gap = min(ends, key=lambda end: end[0].factor)
    return LeastFound(best, gap, starts - begin, tuple(optimum for optimum, _ in ends))


class _Search:
    """The linear programmes of the two moves; P points, n unknowns, T ties."""

    def __init__(self, problem: LimitProblem) -> None:
        self.problem = problem
        self.normal, self.tangent = problem.jacobian[0::2], problem.jacobian[1::2]
        self.points, self.ties = problem.points.count, len(problem.strength)
        self.wanted = self.normal.T @ problem.apex - problem.dead
        self.floor = problem.apex - problem.tension  # of r'_n
        self.load = csr_matrix(problem.live[:, None])
        self.solved = 0

    def sequence(self, normal: np.ndarray, blend: float) -> np.ndarray | None:
        """The velocities of move 1 from normal forces r'_n (P,), None where a programme has no answer."""
        problem, count = self.problem, self.points
        matrix = hstack([self.normal.T, self.tangent.T, -problem.bars.T, self.load], format="csr")
        cost = np.zeros(matrix.shape[1])
        cost[-1] = -1.0
        bounds = np.full((matrix.shape[1], 2), [-np.inf, np.inf])
        bounds[:count, 0] = self.floor
        bounds[2 * count : -1] = np.stack([np.zeros(self.ties), problem.strength], axis=1)
        velocity, last = None, np.inf
        for _ in range(STEPS):
            most = problem.mu * np.maximum(normal, 0.0)
            bounds[count : 2 * count] = np.stack([-most, most], axis=1)
            answer = linprog(cost, A_eq=matrix, b_eq=self.wanted, bounds=bounds, method="highs-ds")
            self.solved += 1
            if answer.status != 0:
                return velocity
            factor, velocity = float(answer.x[-1]), -np.asarray(answer.eqlin.marginals)
            if abs(factor - last) <= SETTLED * abs(factor):
                break
            normal, last = blend * normal + (1.0 - blend) * answer.x[:count], factor
        return velocity

    def descend(self, velocity: np.ndarray) -> Pair | None:
        """Move 2 from a mechanism: the exact pair of least factor on the way and its gap, None where there is none."""
        best: Pair | None = None
        factor, last = np.inf, np.inf
        for _ in range(ROUNDS):
            forces = self._forces(velocity)
            if forces is None:
                break
            optimum, gap = forces
            if abs(optimum.factor - factor) <= STUCK * abs(factor) and gap > (1.0 - STUCK) * last > EXACT:
                break  # neither falls: further rounds would be the same again
            factor, last = optimum.factor, gap
            if gap <= EXACT:
                if best is not None and optimum.factor >= best[0].factor - 1e-9:
                    break
                best = forces
            renewed = self._velocity(optimum)
            if renewed is None:
                break
            velocity = renewed
        return best

    def _forces(self, velocity: np.ndarray) -> Pair | None:
        """The forces of least lambda + M g for a mechanism, and g over the power of the loads."""
        problem, count = self.problem, self.points
        velocity = velocity / float(problem.live @ velocity)
        opening = np.maximum(self.normal @ velocity, 0.0)
        slip = self.tangent @ velocity
        longer = problem.bars @ velocity
        yields = np.where(np.isfinite(problem.strength), np.maximum(longer, 0.0), 0.0)
        slack = np.where(np.isfinite(problem.strength), -longer, np.maximum(-longer, 0.0))
        work = np.concatenate(
            [opening + 2.0 * problem.mu * np.maximum(slip, 0.0), opening + 2.0 * problem.mu * np.maximum(-slip, 0.0), slack]
        )
        x = self._cheapest(np.append(PENALTY * work, 1.0))
        if x is None:
            return None
        along, against = x[:count], x[count : 2 * count]
        force = np.stack([along + against - problem.apex, problem.mu * (along - against)], axis=1)
        least = float(opening @ self.floor)  # of the sum: where the bond's tension is cut off, r'_n stays at it
        least -= float(yields @ np.where(yields > 0.0, problem.strength, 0.0))
        power = abs(float(problem.dead @ velocity)) + abs(float(x[-1])) + 1e-300
        made = Optimum(float(x[-1]), force, x[2 * count : -1], velocity, self.solved, "sequence of linear programmes (HiGHS)")
        return made, (float(work @ x[:-1]) - least) / power

    def least_normal(self) -> np.ndarray | None:
        """The normal forces r'_n (P,) of least sum that bear the dead loads with any factor."""
        x = self._cheapest(np.repeat([1.0, 0.0], [2 * self.points, self.ties + 1]))
        return None if x is None else x[: self.points] + x[self.points : 2 * self.points]

    def _cheapest(self, cost: np.ndarray) -> np.ndarray | None:
        """Shares of the edges of all cones, tensions of the ties and factor, of least cost in equilibrium; None without an answer."""
        problem, count = self.problem, self.points
        bounds = np.zeros((len(cost), 2))
        bounds[:, 1] = np.inf
        bounds[2 * count : -1, 1] = problem.strength
        bounds[-1, 0] = -np.inf
        held = np.flatnonzero(self.floor > 0.0)
        pick = identity(count, format="csr")[held]
        below = hstack([-pick, -pick, csr_matrix((len(held), self.ties + 1))]) if len(held) else None
        answer = linprog(
            cost, A_ub=below, b_ub=-self.floor[held] if len(held) else None, A_eq=self._edges, b_eq=self.wanted, bounds=bounds,
            method="highs-ds",
        )  # fmt: skip
        self.solved += 1
        return answer.x if answer.status == 0 else None

    def _velocity(self, optimum: Optimum) -> np.ndarray | None:
        """The velocities of least g for forces."""
        problem, count = self.problem, self.points
        lifted = optimum.force[:, 0] + problem.tension
        within = problem.mu * (optimum.force[:, 0] + problem.apex)
        strength = np.where(np.isfinite(problem.strength), problem.strength, 0.0)
        cost = np.concatenate([self.normal.T @ lifted, within + optimum.force[:, 1], within - optimum.force[:, 1], strength])
        cost[: problem.unknowns] -= problem.bars.T @ optimum.bars
        bounds = np.zeros((len(cost), 2))
        bounds[:, 1] = np.inf
        bounds[: problem.unknowns, 0] = -np.inf
        bounds[problem.unknowns + 2 * count :, 1] = np.where(np.isfinite(problem.strength), np.inf, 0.0)
        below, right, equal = self._kinematics
        answer = linprog(
            cost, A_ub=below, b_ub=np.zeros(below.shape[0]), A_eq=equal, b_eq=right, bounds=bounds, method="highs-ds"
        )  # fmt: skip
        self.solved += 1
        return answer.x[: problem.unknowns] if answer.status == 0 else None

    @cached_property
    def _edges(self) -> csr_matrix:
        """Equilibrium over the edges n + mu t and n - mu t of all cones, the ties, and lambda."""
        lean = diags(self.problem.mu) @ self.tangent
        return hstack([(self.normal + lean).T, (self.normal - lean).T, -self.problem.bars.T, self.load], format="csr")

    @cached_property
    def _kinematics(self) -> tuple[csr_matrix, np.ndarray, csr_matrix]:
        """Over v, s_1, s_2 and the rates at which ties yield: rows <= 0 (nothing closes, no tie grows longer but by yielding); right side
        and rows of slips that are s_1 - s_2, and of w_1 . v = 1."""
        count, ties = self.points, self.ties
        longer = hstack([self.problem.bars, csr_matrix((ties, 2 * count)), -identity(ties)])
        below = vstack([hstack([-self.normal, csr_matrix((count, 2 * count + ties))]), longer])
        one = identity(count)
        slips = hstack([self.tangent, -one, one, csr_matrix((count, ties))])
        power = hstack([csr_matrix(self.problem.live[None]), csr_matrix((1, 2 * count + ties))])
        return below.tocsr(), np.append(np.zeros(count), 1.0), vstack([slips, power], format="csr")
