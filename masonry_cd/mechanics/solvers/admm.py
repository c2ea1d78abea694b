r"""Alternating directions: with one sparse solve an iteration propagates the error through the whole structure.

With De Saxce's shift s = mu |u_t| n the problem reads: u + s in K*, p in K, orthogonal. The augmented Lagrangian of the convex
problem with s held (Cadoux, Ph.D. thesis, Grenoble 2009; Boyd et al., Found. Trends Mach. Learn. 3, 2011), split at z = H v + b + s,
gives two steps, here with the auxiliary z eliminated and s renewed in each:

    p+ = P_K( p - R (u + s) ),     u = H v + b,
    (M + H^T R H) (v+ - v) = M (v_free - v) + H^T (2 p+ - p).

At a fixed point M (v - v_free) = H^T p and p = P_K(p - R (u + s)), whatever R and whatever stands in the brackets on the left: the
matrix may be an old one, and R may change between iterations. R = diag(k / d_c), d_c = trace(W_cc) / m, makes k a pure number.

**Elastic contacts** have w = u + C p in place of u in the law, and a term p^T C p / 2 in the convex problem. The first step is then the
proximal map of cone and term together, the projection in the norm of R^-1 + C,

    p+ = P_K( p - S (w + s) ),     S^-1 = R^-1 + C,

and the second stays as it is. Where everything sticks an iteration leaves (1 + a^2 c) / ((1 + a c)(1 + a)) of the error, a = 1 / (R C),
c = C / W: half of it at R = 1 / C, whatever W, and least at R = (C W)^-1/2 if C > W. So R^-1 = d / k + C (1 + C / d)^-1/2 with the d of
W alone and the mean of C, which tends to that of a rigid contact.

**The answer.** p+ obeys the law's cones and v+ nearly its velocities, but the velocities of p+ are others: what p+ is off in the stiff
directions of the structure comes back multiplied. The impulses that belong to v+ follow from the second step,

    p^ = 2 p+ - p - R H (v+ - v),     M (v+ - v_free) = H^T p^.

They are a little outside the cones, and their map error is 5 to 20 times less: they are the answer. Where the iteration starts matters as
much. It starts from the impulses of the last step and their velocities, so that the pair fits. Where contacts rattle, these impulses may
fit worse than none would (map error above 1); then it starts from them and the velocities before the step, in a third of the iterations.

**Choice of k.** A large k holds closed joints together at once, but a contact that has to open or to slip then takes many iterations to do
so. Measured from rest, k = 1e4 takes 16 iterations for towers of 50 and 33 for walls of 100 courses, at k = 1e3 twice to five times
as many; on walls and arcades that are shaken without much damage 1e3 to 1e5 differ by less than a factor 2; smaller values pay where
much slides: a church of 5,000 blocks that rattles takes k = 1 to 10 to errors of 5e-3. So: start at 1e4; where an iteration has not won a
factor of 10 in 40 iterations, or is worse off after 20, look at the map error of the pair (p+, v+), which is what R is to make small, as
a share of that of p^. If it is nearly all, k grows by 5; if little, k falls with its square root. It also falls where the limit of
iterations ends a step too early. And over a run a neighbouring k is tried now and then and kept if it took fewer iterations.

**R by contact.** Contacts that stick want a large R, those that are open or slide a small one, and one k for all is a compromise. Where
much slides (k < 300) a rigid contact so has k / d_c if it sticks, a tenth of that if it is open and three tenths if it slides, by the trial
impulse p - R (u + s) when the matrix is factorised; it is factorised anew where k is looked at and more than a tenth of the contacts do
something else. The k that does best is then some three times larger, and a step takes a third to two fifths fewer iterations (churches of
308, 710 and 4,728 blocks). Shares of 0.03 and 0.3, 0.1 and 0.5, 0.05 and 0.2 gain no more.

**Relaxation.** The iteration goes on from p + a (p+ - p) and v + a (v+ - v), with the same fixed points for any a between 0 and 2
(Eckstein & Bertsekas, Math. Program. 55, 1992). What a = 1 takes away at once comes back with 1 - a, what spirals fades most slowly at
a = 2, and what hardly changes from one iteration to the next fades a times as fast. That is most of the error where much slides, at a small
k and far from the answer: there a = 1.5 saves a quarter of the iterations, 1.3 and 1.7 less (churches of 315 and 700 blocks, 1e-3). A wall
that stands, at k = 1e4, would take twice as many, and so would the last digits.

**Cost.** The factorisation costs as much as ten to fifty iterations and is kept from step to step while it pays. To measure the error costs
as much as one or two iterations; the change of p, which costs nothing, tells when to, by the ratio of the two as measured last, if need be
in the step before.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from operator import itemgetter

import numpy as np

from masonry_cd.mechanics.friction.joint_twists import size_of_twist
from masonry_cd.mechanics.friction.local_blocks import in_elimination_order, local_arrays
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Problem, Solution, first_impulse
from masonry_cd.mechanics.linalg.ordering import FIELDS, Pattern
from masonry_cd.mechanics.linalg.threads import run_by_team
from masonry_cd.mechanics.solvers.admm_kernels import admm_bodies
from masonry_cd.mechanics.solvers.admm_workspace import AdmmSettings, allocate_workspace
from masonry_cd.mechanics.solvers.contact_partition import group_contacts
from masonry_cd.mechanics.solvers.local_kernels import admm_local
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 2000  # iterations
FIRST_K = 1e4
FIRST_STIFFNESS = 1e3  # K of Newton, see newton.py
LOCAL_K = 1e3  # of local problems, which are solved once
OPEN, SLIDES = 0.1, 0.3  # shares of R of contacts that do not stick, where much slides
PROBE = 40  # steps between two trials of a neighbouring k
BESIDE = 3.0  # factor between neighbouring k
BETTER = 0.8  # share of the mean iterations below which a trial wins
SLOWER, MORE = 1.3, 3.0  # times the iterations with new factors, and so many more: then factors are out of date
NAMES = tuple(f"admm_{name}" for name in (*FIELDS, "bodies", "squares", "panels", "rho", "tally"))  # in the memory of a solution
_look_up = itemgetter(*NAMES)


@dataclass(slots=True)
class Tally:
    """What is learnt from step to step about the stiffness of ADMM and of Newton."""

    k: float = FIRST_K  # that did best
    stale: bool = True  # whether the next step is to factorise anew
    fresh_iterations: float = 0.0  # of the last step with new factors
    steps: int = 0
    mean_iterations: float = 0.0  # of a step at this k
    newton_stiffness: float = FIRST_STIFFNESS  # K with which Newton begins
    rate: float = 1.0  # error over the change of p in the last iteration that was measured; 1: none was
    newton_iterations: float = inf  # of Newton's last solve, with a minus while its K falls

    @classmethod
    def read(cls, array: np.ndarray) -> Tally:
        """A tally from what :meth:`array` gave."""
        k, stale, fresh_iterations, steps, *others = array.tolist()
        return cls(k, bool(stale), fresh_iterations, int(steps), *others)

    def array(self) -> np.ndarray:
        """The numbers (8,) for a checkpoint."""
        learnt = (self.k, self.stale, self.fresh_iterations, self.steps, self.mean_iterations)
        return np.array((*learnt, self.newton_stiffness, self.rate, self.newton_iterations), dtype=float)

    def next_k(self) -> float:
        """The k of the next step: the best so far, and now and then one beside it."""
        if self.steps % PROBE == PROBE - 1:
            return self.k * (BESIDE if self.steps // PROBE % 2 else 1.0 / BESIDE)
        return self.k

    def learn(self, k: float, k_end: float, iterations: int, factorisations: int) -> None:
        """Take a step into account that began with k and ended with k_end."""
        self.steps += 1
        if k_end != k:  # it had to change on the way
            self.k, self.stale, self.mean_iterations = k_end, True, 0.0
            return
        if k != self.k:  # a trial
            if iterations >= BETTER * self.mean_iterations:
                self.stale = True
                return
            self.k, self.mean_iterations = k, float(iterations)
        if factorisations:
            self.fresh_iterations = float(iterations)
        self.mean_iterations = 0.8 * self.mean_iterations + 0.2 * iterations if self.mean_iterations else float(iterations)
        self.stale = iterations > SLOWER * self.fresh_iterations + MORE


@dataclass(eq=False)
class Memory:
    """What the next step can use: the symbolic analysis, the factors, and the k that did best.

    It travels in ``Solution.memory`` as a dict of arrays, so that a checkpoint can hold it; the factors in it are overwritten by the next
    step.
    """

    pattern: Pattern
    bodies: np.ndarray  # (C, 2) of the contacts of the factors
    squares: np.ndarray  # of D^-1, flat, in single precision
    panels: np.ndarray  # of L, flat, in single precision
    rho: np.ndarray  # (C,) R
    tally: Tally

    @classmethod
    def empty(cls, pattern: Pattern, bodies: np.ndarray, n: int, tally: Tally) -> Memory:
        """Memory for the factors of a pattern; nothing is factorised yet."""
        tally.stale = True
        squares, panels = (
            np.empty(n * n * int(starts[-1]), dtype=np.float32) for starts in (pattern.symbolic.square, pattern.symbolic.panel)
        )
        return cls(pattern, bodies, squares, panels, np.empty(len(bodies)), tally)

    @classmethod
    def read(cls, arrays: dict[str, np.ndarray]) -> Memory | None:
        """The memory in a solution, None if there is none."""
        if "admm_order" not in arrays:
            return None
        values = _look_up(arrays)
        bodies, squares, panels, rho, tally = values[len(FIELDS) :]
        return cls(Pattern.read(values[: len(FIELDS)]), bodies, squares, panels, rho, Tally.read(tally))

    def arrays(self) -> dict[str, np.ndarray]:
        """The memory for a solution."""
        own = (self.bodies, self.squares, self.panels, self.rho, self.tally.array())
        return dict(zip(NAMES, self.pattern.arrays() + own, strict=True))


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Iterate until the natural map error is below the tolerance, or the limit is reached; the best iterate is returned.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts iterations (one sparse solve each).
        start: its impulse (C, m) is the first iterate, with its velocity or else that of the impulses; its memory that of the step before.
    """
    impulse = first_impulse(problem, start)
    limit = options.limit(LIMIT)
    if isinstance(problem, LocalProblem):
        return _solve_local(problem, options, impulse, limit)
    return _solve_bodies(problem, options, impulse, limit, start)


def _solve_bodies(problem: FrictionProblem, options: Options, impulse: np.ndarray, limit: int, start: Solution | None) -> Solution:
    """ADMM in the body velocities."""
    given = problem.arrays()
    moving = start is not None and start.velocity is not None
    velocity = start.velocity.copy() if start is not None and start.velocity is not None else np.empty(problem.v_free.shape)
    memory, index, block = recall(given, start)
    pattern, tally, k = memory.pattern, memory.tally, memory.tally.next_k()
    settings = AdmmSettings(k, (OPEN, SLIDES), tally.stale or k != tally.k, moving, tally.rate, options.tolerance, limit)
    groups = group_contacts(given, index, block, pattern.symbolic, size_of_twist(given.jacobian, given.bodies))
    work = allocate_workspace(given, pattern, groups, (memory.squares, memory.panels, memory.rho))
    threads = min(options.threads, int(pattern.symbolic.level[1]))  # as many as there are subtrees at first, at most
    iterations, error, k_end, factorisations, tally.rate = run_by_team(
        admm_bodies, threads, given, pattern.order, work, settings, impulse, velocity
    )
    tally.learn(k, k_end, iterations, factorisations)
    return Solution(impulse, velocity, iterations, _reason(error, options, iterations < limit), memory.arrays(), error)


def recall(given: ProblemArrays, start: Solution | None) -> tuple[Memory, np.ndarray, np.ndarray]:
    """The memory of the last step as far as it still fits, and the places (C, 2) and coupling blocks (C,) of the contacts."""
    bodies, (count, n) = given.bodies, given.v_free.shape
    memory = Memory.read(start.memory) if start is not None else None
    if memory is not None and len(memory.squares) != n * n * int(memory.pattern.symbolic.square[-1]):  # other unknowns
        memory = Memory.empty(memory.pattern, memory.bodies, n, memory.tally)
    if memory is None or memory.pattern.nodes != count:  # other bodies; the tally may outlive them
        learnt = start.memory.get("admm_tally") if start is not None else None
        memory = Memory.empty(Pattern.of(count, bodies[:, 0], bodies[:, 1]), bodies, n, Tally() if learnt is None else Tally.read(learnt))
    found = memory.pattern.locate(bodies, memory.bodies)
    if found is None:  # a new pair of bodies: those that were in touch may be again
        pattern = Pattern.of(count, bodies[:, 0], bodies[:, 1], memory.pattern.pairs)
        memory = Memory.empty(pattern, bodies, n, memory.tally)
        found = pattern.locate(bodies, bodies)
        assert found is not None
    index, block, same = found
    if not same:
        memory.bodies, memory.rho = bodies.copy(), np.empty(len(bodies))
        memory.tally.stale = True
    memory.pattern = memory.pattern.with_width(given.width)
    return memory, index, block


def with_stale_factors(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What :meth:`Memory.arrays` gave, for a problem in other unknowns: the next step is to factorise anew."""
    if NAMES[-1] not in arrays:
        return arrays
    tally = Tally.read(arrays[NAMES[-1]])
    tally.stale = True
    return arrays | {NAMES[-1]: tally.array()}


def _reason(error: float, options: Options, given_up: bool = False) -> str:
    """Say how it ended; given up is what has no hope of an end or no definite matrix."""
    if error <= options.tolerance:
        return "admm: converged"
    return f"admm: {'given up' if given_up else 'iteration limit reached'} at an error of {error:.1e}"


def _solve_local(problem: LocalProblem, options: Options, impulse: np.ndarray, limit: int) -> Solution:
    """ADMM in the impulses: the same iteration by Woodbury's identity, with (W + R^-1) in place of (M + H^T R H)."""
    given, _ = local_arrays(problem)
    given, pattern = in_elimination_order(given)
    iterations, error = admm_local(given, pattern.order, pattern.symbolic, impulse, LOCAL_K, options.tolerance, limit)
    return Solution(impulse, None, iterations, _reason(error, options))
