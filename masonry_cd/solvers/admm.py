r"""Alternating directions: one sparse solve carries news through the whole structure in every iteration.

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

**Choice of k.** A large k holds closed joints together at once, but a contact that has to open or to slip then has to be told many
times. Measured from rest, k = 1e4 takes 16 iterations for towers of 50 and 33 for walls of 100 courses, at k = 1e3 twice to five times
as many; on walls and arcades that are shaken without much damage 1e3 to 1e5 differ by less than a factor 2; smaller values pay where
much slides: a church of 5,000 blocks that rattles takes k = 1 to 10 to errors of 5e-3. So: start at 1e4; where an iteration has not won a
factor of 10 in 40 iterations, or is worse off after 20, look at the map error of the pair (p+, v+), which is what R is to make small, as
a share of that of p^. If it is nearly all, k grows by 5; if little, k falls with its square root. It also falls where the limit of
iterations ends a step before its time. And over a run a neighbouring k is tried now and then and kept if it took fewer iterations.

**Cost.** The factorisation costs as much as ten to fifty iterations and is kept from step to step while it pays. To measure the error costs
as much as one or two iterations; the change of p, which costs nothing, tells when, by the ratio of the two when they were last measured,
be it in the step before.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter

import numpy as np

from masonry_cd.friction.problem import FrictionProblem, LocalProblem, Problem, Solution
from masonry_cd.linalg.ordering import FIELDS, Pattern
from masonry_cd.linalg.team import together
from masonry_cd.solvers import nlgs
from masonry_cd.solvers.admm_kernels import admm_bodies
from masonry_cd.solvers.admm_passes import AdmmWorkspace
from masonry_cd.solvers.contact_partition import partition_contacts
from masonry_cd.solvers.local_kernels import admm_local
from masonry_cd.solvers.options import Options

LIMIT = 2000  # iterations
FIRST_K = 1e4
FIRST_STIFFNESS = 1e3  # K of Newton, see newton.py
LOCAL_K = 1e3  # of local problems, which are solved once
PROBE = 40  # steps between two trials of a neighbouring k
NAMES = tuple(f"admm_{name}" for name in (*FIELDS, "bodies", "squares", "panels", "rho", "tally"))  # in the memory of a solution
_look_up = itemgetter(*NAMES)


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
    rho: np.ndarray  # (C,) in the order of the parts
    tally: np.ndarray  # (8,) k; 1: factorise anew; iterations after the last new factors; steps; mean iterations at this k; Newton's K;
    # error over change of p in the last iteration of the last step; iterations of Newton, with a minus while K falls

    @classmethod
    def empty(cls, pattern: Pattern, bodies: np.ndarray, n: int, tally: np.ndarray | None = None) -> Memory:
        """Room for the factors of a pattern; nothing factorised."""
        if tally is None:
            tally = np.array([FIRST_K, 1.0, 0.0, 0.0, 0.0, FIRST_STIFFNESS, 1.0, np.inf])
        tally[1] = 1.0
        squares, panels = (np.empty(n * n * int(starts[-1]), dtype=np.float32) for starts in (pattern.plan.square, pattern.plan.panel))
        return cls(pattern, bodies, squares, panels, np.empty(len(bodies)), tally)

    @classmethod
    def read(cls, arrays: dict[str, np.ndarray]) -> Memory | None:
        """The memory in a solution, None if there is none."""
        if "admm_order" not in arrays:
            return None
        values = _look_up(arrays)
        bodies, squares, panels, rho, tally = values[len(FIELDS) :]
        return cls(Pattern.read(values[: len(FIELDS)]), bodies, squares, panels, rho, tally.copy())

    def arrays(self) -> dict[str, np.ndarray]:
        """The memory for a solution."""
        own = (self.bodies, self.squares, self.panels, self.rho, self.tally)
        return dict(zip(NAMES, self.pattern.arrays() + own, strict=True))


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Iterate until the natural map error is below the tolerance, or the limit is reached; the best iterate is returned.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts iterations (one sparse solve each).
        start: its impulse (C, m) is the first iterate, with its velocity or else that of the impulses; its memory that of the step before.
    """
    impulse = np.zeros((problem.contacts, problem.dimension))
    if start is not None:
        impulse[:] = start.impulse
    limit = LIMIT if options.max_iterations is None else options.max_iterations
    if isinstance(problem, LocalProblem):
        return _solve_local(problem, options, impulse, limit)
    return _solve_bodies(problem, options, impulse, limit, start)


def _solve_bodies(problem: FrictionProblem, options: Options, impulse: np.ndarray, limit: int, start: Solution | None) -> Solution:
    """ADMM in the body velocities."""
    arrays, m, n = problem.arrays(), problem.dimension, problem.v_free.shape[1]
    moving = start is not None and start.velocity is not None
    velocity = start.velocity.copy() if start is not None and start.velocity is not None else np.empty(problem.v_free.shape)
    memory, index, spot = recall(arrays[2], len(velocity), n, start)
    k = _next_k(memory.tally)
    fresh = bool(memory.tally[1]) or k != memory.tally[0]
    pattern, plan = memory.pattern, memory.pattern.plan
    turns, desk = partition_contacts(index, spot, plan), _desk(pattern, *arrays[3:7])
    iterations, error, k_end, factorisations, rate = together(
        admm_bodies, options.threads, plan, *arrays[:7], pattern.order, plan, turns, desk, memory.squares, memory.panels,
        memory.rho, impulse, velocity, k, fresh, moving, memory.tally[6], options.tolerance, limit, (0,) * m, (0,) * n,
    )  # fmt: skip
    memory.tally[6] = rate
    _learn(memory.tally, k, k_end, iterations, factorisations)
    return Solution(impulse, velocity, iterations, _reason(error, options), memory.arrays())


def _desk(pattern: Pattern, jacobian: np.ndarray, offset: np.ndarray, mu: np.ndarray, compliance: np.ndarray) -> AdmmWorkspace:
    """Room to work in; what is not touched costs nothing. The contacts of a plan of one part stay where they are."""
    plan, count, (contacts, _, m, n) = pattern.plan, pattern.nodes, jacobian.shape
    rows = count + 1 + len(plan.copies)
    if len(plan.part) > 2:
        jacobian, offset, mu, compliance = (np.empty_like(array) for array in (jacobian, offset, mu, compliance))
    bodies, blocks, impulses = (count + 1, n), (count, n, n), (contacts, m)
    alone = len(plan.first) == len(plan.column) and len(plan.part) == 2  # the other factors are made in single precision
    panel, square = (n * n * int(starts[-1]) if alone else 0 for starts in (plan.panel, plan.square))
    return AdmmWorkspace(
        inverse=np.empty(blocks), mass=np.empty(blocks), free=np.empty((count, n)), v=np.empty(bodies), trial=np.empty(bodies),
        best_v=np.empty(bodies), push=np.empty((rows, n)), x=np.empty((rows, n), dtype=np.float32), jacobian=jacobian,
        offset=offset, mu=mu, compliance=compliance, even=np.empty(impulses), odd=np.empty(impulses),
        best=np.empty(impulses), carried=np.empty(impulses),
        d=np.empty(contacts), sums=np.empty((3, len(plan.part) - 1)), diagonal=np.empty((rows, n * n)),
        lower=np.empty((len(plan.row), n, n)), squares=np.empty(square), panels=np.empty(panel),
    )  # fmt: skip


def recall(bodies: np.ndarray, count: int, n: int, start: Solution | None) -> tuple[Memory, np.ndarray, np.ndarray]:
    """The memory of the last step as far as it still fits, and the places (C, 2) and coupling blocks (C,) of the contacts."""
    memory = Memory.read(start.memory) if start is not None else None
    if memory is None or memory.pattern.nodes != count:  # other bodies; what was learnt about k may be left
        learnt = start.memory.get("admm_tally") if start is not None else None
        memory = Memory.empty(Pattern.of(count, bodies[:, 0], bodies[:, 1]), bodies, n, None if learnt is None else learnt.copy())
    found = memory.pattern.locate(bodies, memory.bodies)
    if found is None:  # a new pair of bodies: those that were in touch may be again
        pattern = Pattern.of(count, bodies[:, 0], bodies[:, 1], memory.pattern.pairs)
        memory = Memory.empty(pattern, bodies, n, memory.tally)
        found = pattern.locate(bodies, bodies)
        assert found is not None
    index, spot, same = found
    if not same:
        memory.bodies, memory.rho = bodies.copy(), np.empty(len(bodies))
        memory.tally[1] = 1.0
    return memory, index, spot


def _next_k(tally: np.ndarray) -> float:
    """The k of this step: the best so far, and now and then one beside it."""
    steps = int(tally[3])
    if steps % PROBE == PROBE - 1:
        return float(tally[0]) * (3.0 if steps // PROBE % 2 else 1.0 / 3.0)
    return float(tally[0])


def _learn(tally: np.ndarray, k: float, k_end: float, iterations: int, factorisations: int) -> None:
    """Take the cost of a step into account."""
    tally[3] += 1.0
    if k_end != k:  # it had to change on the way
        tally[0], tally[1], tally[4] = k_end, 1.0, 0.0
        return
    if k != tally[0]:  # a trial
        if iterations < 0.8 * tally[4]:
            tally[0], tally[4] = k, iterations
        else:
            tally[1] = 1.0
            return
    if factorisations:
        tally[2] = iterations
    tally[4] = 0.8 * tally[4] + 0.2 * iterations if tally[4] else iterations
    tally[1] = float(iterations > 1.3 * tally[2] + 3)


def _reason(error: float, options: Options) -> str:
    """Say how it ended."""
    return "admm: converged" if error <= options.tolerance else f"admm: iteration limit reached at an error of {error:.1e}"


def _solve_local(problem: LocalProblem, options: Options, impulse: np.ndarray, limit: int) -> Solution:
    """ADMM in the impulses: the same iteration by Woodbury's identity, with (W + R^-1) in place of (M + H^T R H)."""
    blocks, indices, indptr, _ = nlgs.block_arrays(problem)
    pattern = contact_pattern(indices, indptr)
    iterations, error = admm_local(
        blocks, indices, indptr, problem.q, problem.mu, problem.scales(), pattern.order, pattern.place, pattern.plan, impulse, LOCAL_K,
        options.tolerance, limit, (0,) * problem.dimension,
    )  # fmt: skip
    return Solution(impulse, None, iterations, _reason(error, options))


def contact_pattern(indices: np.ndarray, indptr: np.ndarray) -> Pattern:
    """The pattern of W, contact by contact."""
    count = len(indptr) - 1
    return Pattern.of(count, np.repeat(np.arange(count), np.diff(indptr)), indices, in_parts=False)
