r"""Coulomb's law at a contact, and the compiled loops that sweep over contacts.

One contact, all others held, sees u = W p + q with its own 3 x 3 block W of the Delassus operator, plus its compliance if it is elastic
(then u is what friction.py calls w). Signorini's condition and Coulomb's law then have one of three answers (Jean, Comput. Methods Appl.
Mech. Engrg. 177, 1999):

    separation   p = 0                              if q_n >= 0
    stick        p = -W^-1 q                        if that lies in the cone |p_t| <= mu p_n
    slip         u_n = 0,  u_t = -s p_t,  |p_t| = mu p_n   with s > 0

In slip the normal row is eliminated, p_n = -(q_n + w.p_t) / W_nn, which leaves (A + s I) p_t = -a with the Schur complement
A = W_tt - w w^T / W_nn and a = q_t - w q_n / W_nn. The one unknown s solves

    h(s) = mu p_n(s) / |p_t(s)| - 1 = 0,     h(0) < 0,  h(infinity) > 0,

which is exactly linear when W is diagonal and isotropic, and nearly so otherwise: Newton inside a shrinking bracket ends after two
or three steps (the idea of the secular equation of trust regions, More & Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983).

Planar contacts (one tangent) use the same step with a second tangent that carries nothing.

All kernels that call each other live in this one file: numba's cache does not notice a changed callee in another file. Hence its
length. What sweeps call for each contact takes numbers, not arrays: an array that is passed on, or a view of one, has its references
counted, which takes longer than the arithmetic. In order: the law and its natural map; Gauss-Seidel over bodies, coloured, and over local
problems; sparse blocks; ADMM; Newton; both for local problems; the interior point method; proximal points; these two for local
problems. What each method does and why stands in its file in ``solvers``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import prange, types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic

from masonry_cd.jit import njit

OPEN, STICK, SLIP = 0, 1, 2  # status of a contact
FREE, HELD = np.bool_(False), np.bool_(True)  # whether a status may change; for plain False and True numba would compile the code twice
GROUP = 16  # contacts visited in a row by a sweep, see _groups
EPSILON = 2.2e-16  # relative rounding error of a float
SHORT = 2  # columns: runs up to this length may be padded much, see runs
WIDEST = 16  # columns that are factorised together
THIN = 2.0  # mean number of rows below a column of L up to which columns stay alone
SYMMETRIC, UNSYMMETRIC = np.bool_(True), np.bool_(False)  # of a matrix; likewise
PATIENCE = 20  # iterations of ADMM without a look at the error, half as many where its ratio to the change of p is a guess
BALANCE, ALL = 0.6, 0.95  # shares of ADMM's error that lie in the law: its stiffness falls below the one, grows above the other
SOFTEST = 1e-3  # k of ADMM at which a factorisation that fails is not tried at a tenth of it again
PART = 4096  # blocks of L in a part of the first level
STIFFEST = 1e12  # K of interior and proximal points; stiff springs beside rigid contacts settle where K exceeds d / C
# The table of contacts: a row for each with all that a sweep reads besides G, so that it comes in a piece. First the local law, see
# _law_row, then d, s, mu, q, p and C at these places:
SCALE, START, MU, Q, P, C = 7, 8, 9, 10, 13, 16
ROW = 19


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _length(x: float, y: float) -> float:
    """Length of a tangential vector."""
    return np.sqrt(x * x + y * y)


@njit(cache=True, nogil=True, error_model="numpy")
def _slip(
    mu: float, qn: float, a1: float, a2: float, winv: float, c1: float, c2: float, s11: float, s12: float, s22: float, s: float
) -> tuple[float, float, float, float]:
    """Solve the slip equation from a first guess of s; a = (a1, a2), A = [[s11, s12], [s12, s22]], c = w / W_nn. Returns p and s.

    With t = det(A + s I) p_t, which is linear in s, and N = mu det(A + s I) p_n it reads N / |t| = 1: one root and one division a step.
    """
    low, high = 0.0, np.inf
    push = -qn * winv
    x1, x2 = s12 * a2 - s22 * a1, s12 * a1 - s11 * a2  # t at s = 0
    for _ in range(100):
        t1, t2 = x1 - s * a1, x2 - s * a2
        square = t1 * t1 + t2 * t2
        tangent = np.sqrt(square)
        normal = mu * (push * ((s11 + s) * (s22 + s) - s12 * s12) - c1 * t1 - c2 * t2)
        slope = mu * (push * (s11 + s22 + 2.0 * s) + c1 * a1 + c2 * a2)
        move = (tangent - normal) * square / (slope * square + normal * (t1 * a1 + t2 * a2))
        if abs(normal - tangent) <= 1e-8 * tangent:  # Newton is quadratic: one more step leaves 1e-16
            s += move
            break
        if normal < tangent:
            low = s
        else:
            high = s
        s += move
        if not (low < s < high):  # also when the slope is zero or not a number
            s = 0.5 * (low + high) if high < np.inf else 2.0 * low + s11 + s22
        if high < np.inf and high - low <= 4e-16 * high:
            break
    # the cone exactly, with the direction of slip found and u_n = 0: p_n (1 + mu c.t / |t|) = -q_n / W_nn
    t1, t2 = x1 - s * a1, x2 - s * a2
    tangent = _length(t1, t2)
    share = push / (tangent + mu * (c1 * t1 + c2 * t2))
    if not (share >= 0.0 and share < np.inf):  # never a NaN, never outside the cone
        return push, 0.0, 0.0, 0.0
    return share * tangent, mu * share * t1, mu * share * t2, s


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _local_step(
    qn: float, q1: float, q2: float, winv: float, c1: float, c2: float, s11: float, s12: float, s22: float, mu: float, s: float
) -> tuple[float, float, float, float]:
    """The exact answer (p, s) of one contact to the velocity (qn, q1, q2) that it sees without its own impulse, by its row of the table.

    The slip equation is solved from where the search of the last sweep ended: mostly one step, instead of three from s = 0.
    """
    if qn >= 0.0:
        return 0.0, 0.0, 0.0, s
    a1 = q1 - c1 * qn
    a2 = q2 - c2 * qn
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    p1 = (s12 * a2 - s22 * a1) * inverse
    p2 = (s12 * a1 - s11 * a2) * inverse
    pn = -qn * winv - c1 * p1 - c2 * p2
    if pn >= 0.0 and p1 * p1 + p2 * p2 <= mu * mu * pn * pn:
        return pn, p1, p2, s
    if mu < 1e-300:
        return -qn * winv, 0.0, 0.0, s
    return _slip(mu, qn, a1, a2, winv, c1, c2, s11, s12, s22, s)


@njit(cache=True, nogil=True, error_model="numpy")
def _law_row(w: np.ndarray, m: int, mu: float, law: np.ndarray, c: int) -> None:
    """Prepare the local law of contact c from W (3, 3) and mu: 1/W_nn, w/W_nn (2), A (3), W_nn, d = trace/m, s = 0, mu."""
    wnn = w[0, 0]
    w1, w2 = 0.5 * (w[0, 1] + w[1, 0]), 0.5 * (w[0, 2] + w[2, 0])
    tiny = 1e-14 * (w[0, 0] + w[1, 1] + w[2, 2])
    wnn = max(wnn, tiny)
    c1, c2 = w1 / wnn, w2 / wnn
    s11 = max(w[1, 1] - w1 * c1, tiny)
    s22 = max(w[2, 2] - w2 * c2, tiny) if m == 3 else s11
    s12 = 0.5 * (w[1, 2] + w[2, 1]) - w1 * c2 if m == 3 else 0.0
    bound = np.sqrt(s11 * s22) * (1.0 - 1e-14)
    s12 = min(max(s12, -bound), bound)
    law[c, 0], law[c, 1], law[c, 2] = 1.0 / wnn, c1, c2
    law[c, 3], law[c, 4], law[c, 5] = s11, s12, s22
    law[c, 6] = wnn
    law[c, SCALE] = (w[0, 0] + w[1, 1] + (w[2, 2] if m == 3 else 0.0)) / m
    law[c, START], law[c, MU] = 0.0, mu


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _own_velocity(
    pn: float, p1: float, p2: float, c1: float, c2: float, s11: float, s12: float, s22: float, wnn: float
) -> tuple[float, float, float]:
    """(W + C) p of a contact from its row of the table: with w = c W_nn and W_tt = A + w w^T / W_nn."""
    un = wnn * (pn + c1 * p1 + c2 * p2)
    return un, c1 * un + s11 * p1 + s12 * p2, c2 * un + s12 * p1 + s22 * p2


@njit(cache=True, nogil=True, error_model="numpy")
def _copy(source, target):
    """The first entries of target = source, both contiguous, of one shape but for the first length.

    Assigned to a slice, arrays are asked for overlaps and lengths first, which takes longer to compile than many a kernel.
    """
    a, b = source.reshape(source.size), target.reshape(target.size)
    for i in range(len(a)):
        b[i] = a[i]


# --- the natural map -------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _project(xn: float, x1: float, x2: float, mu: float) -> tuple[float, float, float]:
    """Project (xn, x1, x2) onto Coulomb's cone |x_t| <= mu x_n."""
    tangent = _length(x1, x2)
    if mu * tangent <= -xn:  # first, or else a frictionless contact that opens without sliding would pass for a point of the cone
        return 0.0, 0.0, 0.0
    if tangent <= mu * xn:
        return xn, x1, x2
    height = (xn + mu * tangent) / (1.0 + mu * mu)
    scale = mu * height / tangent
    return height, scale * x1, scale * x2


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _project_stretched(xn: float, x1: float, x2: float, mu: float, stretch: float) -> tuple[float, float, float]:
    """The same, but nearest in the norm sqrt(x_n^2 + stretch |x_t|^2): a projection onto a wider or narrower cone."""
    root = np.sqrt(stretch)
    height, y1, y2 = _project(xn, root * x1, root * x2, root * mu)
    return height, y1 / root, y2 / root


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _natural_map2(pn: float, p1: float, p2: float, un: float, u1: float, u2: float, mu: float, d: float) -> float:
    """Squared natural map residual of a contact in the scaled variables r = p sqrt(d), w = u / sqrt(d).

    What rounding hides counts as error: where p has grown beyond all bounds, r - w is r, and the residual alone would be zero.
    """
    xn, x1, x2 = _project(d * pn - un - mu * _length(u1, u2), d * p1 - u1, d * p2 - u2, mu)
    en, e1, e2 = d * pn - xn, d * p1 - x1, d * p2 - x2
    hidden = EPSILON * d
    return (en * en + e1 * e1 + e2 * e2 + hidden * hidden * (pn * pn + p1 * p1 + p2 * p2)) / d


@njit(cache=True, nogil=True, error_model="numpy")
def natural_map_norms(p: np.ndarray, u: np.ndarray, q: np.ndarray, mu: np.ndarray, d: np.ndarray) -> tuple[float, float]:
    """Norms of the natural map residual and of q / sqrt(d), for impulses p, velocities u, q (C, m) and scales d (C,)."""
    residual, size = 0.0, 0.0
    contacts, m = p.shape
    for c in range(contacts):
        p2 = p[c, 2] if m == 3 else 0.0
        u2 = u[c, 2] if m == 3 else 0.0
        residual += _natural_map2(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c])
        for i in range(m):
            size += q[c, i] * q[c, i] / d[c]
    return np.sqrt(residual), np.sqrt(size)


# --- random order ----------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _random(state: np.ndarray) -> np.uint64:
    """Next number of a xorshift64* generator (Marsaglia, J. Stat. Softw. 8, 2003; Vigna, ACM Trans. Math. Softw. 42, 2016)."""
    x = state[0]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    state[0] = x
    return x * np.uint64(2685821657736338717)


@njit(cache=True, nogil=True, error_model="numpy")
def _seeded(seed: int) -> np.ndarray:
    """Generator state for a seed, scrambled so that small seeds differ at once; never zero."""
    state = np.empty(1, dtype=np.uint64)
    state[0] = (np.uint64(seed) + np.uint64(1)) * np.uint64(11400714819323198485) | np.uint64(1)
    for _ in range(4):
        _random(state)
    return state


@njit(cache=True, nogil=True, error_model="numpy")
def _shuffle(order: np.ndarray, state: np.ndarray) -> None:
    """Fisher-Yates shuffle; the 32 high bits times the range replace a division."""
    for i in range(len(order) - 1, 0, -1):
        j = np.int64(((_random(state) >> np.uint64(32)) * np.uint64(i + 1)) >> np.uint64(32))
        order[i], order[j] = order[j], order[i]


# --- a problem over bodies, prepared for sweeping -----------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def _cholesky_small(a: np.ndarray, factor: np.ndarray, n: int) -> None:
    """Lower Cholesky factor of a symmetric (n, n) block, written into factor."""
    for i in range(n):
        for j in range(i + 1):
            total = 0.5 * (a[i, j] + a[j, i])
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i == j:
                factor[i, i] = np.sqrt(max(total, 0.0))
            else:
                factor[i, j] = total / factor[j, j] if factor[j, j] > 0.0 else 0.0
        for j in range(i + 1, n):
            factor[i, j] = 0.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _scale_rows(jacobian, factor, side, c, body, m, n, scaled):
    """scaled = H L for one contact and side, L lower triangular."""
    for i in range(m):
        for j in range(n):
            total = 0.0
            for k in range(j, n):
                total += jacobian[c, side, i, k] * factor[body, k, j]
            scaled[c, side, i, j] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _mass_scaled(inverse_mass, v_free, bodies, jacobian, offset):
    """Scale by mass: M^-1 = L L^T, G = H L, so that u = q + G y and y = G^T p, and one array of rows serves both ways.

    Supports become a last, dummy body whose rows are zero.
    """
    contacts, m = offset.shape
    free, n = v_free.shape
    factor = np.empty((free, n, n))
    for b in range(free):
        _cholesky_small(inverse_mass[b], factor[b], n)
    g = np.zeros(jacobian.shape)
    q = offset.copy()
    index = np.empty((contacts, 2), dtype=np.int64)
    for c in range(contacts):
        for side in range(2):
            body = bodies[c, side]
            index[c, side] = body if body >= 0 else free
            if body < 0:
                continue
            if m == 3 and n == 6:
                _scale_rows(jacobian, factor, side, c, body, 3, 6, g)
            else:
                _scale_rows(jacobian, factor, side, c, body, m, n, g)
            for i in range(m):
                for k in range(n):
                    q[c, i] += jacobian[c, side, i, k] * v_free[body, k]
    return factor, g, q, index


@njit(cache=True, nogil=True, error_model="numpy")
def _laws(g: np.ndarray, q: np.ndarray, index: np.ndarray, mu: np.ndarray, compliance: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The table of contacts: q, p, and the laws, from W_cc + C_cc, W_cc = sum over sides of G G^T (both sides on one body add up)."""
    contacts, _, m, n = g.shape
    law = np.zeros((contacts, ROW))
    w = np.zeros((3, 3))
    for c in range(contacts):
        cross = index[c, 0] == index[c, 1]
        for i in range(m):
            for j in range(m):
                total = 0.0
                for k in range(n):
                    total += g[c, 0, i, k] * g[c, 0, j, k] + g[c, 1, i, k] * g[c, 1, j, k]
                    if cross:
                        total += g[c, 0, i, k] * g[c, 1, j, k] + g[c, 1, i, k] * g[c, 0, j, k]
                w[i, j] = total
            if len(compliance):
                w[i, i] += compliance[c, i]
        _law_row(w, m, mu[c], law, c)
        for i in range(m):
            law[c, Q + i], law[c, P + i] = q[c, i], p[c, i]
            if len(compliance):
                law[c, C + i] = compliance[c, i]
    return law


@njit(cache=True, nogil=True, error_model="numpy")
def _groups(index: np.ndarray) -> np.ndarray:
    """Starts of the groups that a sweep visits in random order, with the end appended.

    A group is a run of whole joints (consecutive contacts between the same two bodies) of at least GROUP contacts: small enough for a
    random order to spread news as fast as single joints do, large enough that memory is read ahead, which saves a third of the time.
    """
    contacts = len(index)
    starts = np.empty(contacts + 1, dtype=np.int64)
    count = 0
    for c in range(contacts):
        new = c == 0 or index[c, 0] != index[c - 1, 0] or index[c, 1] != index[c - 1, 1]
        if new and (count == 0 or c - starts[count - 1] >= GROUP):
            starts[count] = c
            count += 1
    starts[count] = contacts
    return starts[: count + 1]


@intrinsic
def _prefetch(typing: Any, array: types.Array, entry: types.Integer) -> tuple[Any, Any]:
    """Ask for the line of the cache that holds an entry of a contiguous array, counted flat; beyond its ends nothing happens."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.bitcast(builder.gep(data, [arguments[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [address.type, number, number, number])
        fetch = builder.module.declare_intrinsic("llvm.prefetch", [address.type], kind)
        builder.call(fetch, [address, number(0), number(3), number(1)])  # to read, to be kept near, data
        return context.get_dummy_value()

    return types.void(array, entry), generate


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep_spatial(g, y, index, law, starts, order, ahead):
    """One Gauss-Seidel sweep for m = 3, n = 6: what a contact sees, its exact answer, the push on its two bodies.

    Written out, so that both bodies stay in registers: half the time of loops over the components. The random order keeps the processor
    from guessing what comes next, so the group that comes ``ahead`` groups later is asked for: with 60,000 contacts that halves the time.
    """
    for place in range(len(order)):
        group = order[place]
        later = starts[order[min(place + ahead, len(order) - 1)]] - starts[group]
        for c in range(starts[group], starts[group + 1]):
            for line in range(5):
                _prefetch(g, 36 * (c + later) + 8 * line)
            for line in range(3):
                _prefetch(law, ROW * (c + later) + 8 * line)
            a, b = index[c, 0], index[c, 1]
            a0, a1, a2, a3, a4, a5 = y[a, 0], y[a, 1], y[a, 2], y[a, 3], y[a, 4], y[a, 5]
            b0, b1, b2, b3, b4, b5 = y[b, 0], y[b, 1], y[b, 2], y[b, 3], y[b, 4], y[b, 5]
            u0 = (
                (g[c, 0, 0, 0] * a0 + g[c, 0, 0, 1] * a1 + g[c, 0, 0, 2] * a2)
                + (g[c, 0, 0, 3] * a3 + g[c, 0, 0, 4] * a4 + g[c, 0, 0, 5] * a5)
                + (g[c, 1, 0, 0] * b0 + g[c, 1, 0, 1] * b1 + g[c, 1, 0, 2] * b2)
                + (g[c, 1, 0, 3] * b3 + g[c, 1, 0, 4] * b4 + g[c, 1, 0, 5] * b5)
            )
            u1 = (
                (g[c, 0, 1, 0] * a0 + g[c, 0, 1, 1] * a1 + g[c, 0, 1, 2] * a2)
                + (g[c, 0, 1, 3] * a3 + g[c, 0, 1, 4] * a4 + g[c, 0, 1, 5] * a5)
                + (g[c, 1, 1, 0] * b0 + g[c, 1, 1, 1] * b1 + g[c, 1, 1, 2] * b2)
                + (g[c, 1, 1, 3] * b3 + g[c, 1, 1, 4] * b4 + g[c, 1, 1, 5] * b5)
            )
            u2 = (
                (g[c, 0, 2, 0] * a0 + g[c, 0, 2, 1] * a1 + g[c, 0, 2, 2] * a2)
                + (g[c, 0, 2, 3] * a3 + g[c, 0, 2, 4] * a4 + g[c, 0, 2, 5] * a5)
                + (g[c, 1, 2, 0] * b0 + g[c, 1, 2, 1] * b1 + g[c, 1, 2, 2] * b2)
                + (g[c, 1, 2, 3] * b3 + g[c, 1, 2, 4] * b4 + g[c, 1, 2, 5] * b5)
            )
            c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
            old_n, old_1, old_2 = law[c, P], law[c, P + 1], law[c, P + 2]
            own_n, own_1, own_2 = _own_velocity(old_n, old_1, old_2, c1, c2, s11, s12, s22, law[c, 6])
            q0 = (law[c, Q] + law[c, C] * old_n - own_n) + u0
            q1 = (law[c, Q + 1] + law[c, C + 1] * old_1 - own_1) + u1
            q2 = (law[c, Q + 2] + law[c, C + 2] * old_2 - own_2) + u2
            pn, p1, p2, law[c, START] = _local_step(q0, q1, q2, law[c, 0], c1, c2, s11, s12, s22, law[c, MU], law[c, START])
            d0, d1, d2 = pn - old_n, p1 - old_1, p2 - old_2
            law[c, P], law[c, P + 1], law[c, P + 2] = pn, p1, p2
            y[a, 0] = a0 + (g[c, 0, 0, 0] * d0 + g[c, 0, 1, 0] * d1 + g[c, 0, 2, 0] * d2)
            y[a, 1] = a1 + (g[c, 0, 0, 1] * d0 + g[c, 0, 1, 1] * d1 + g[c, 0, 2, 1] * d2)
            y[a, 2] = a2 + (g[c, 0, 0, 2] * d0 + g[c, 0, 1, 2] * d1 + g[c, 0, 2, 2] * d2)
            y[a, 3] = a3 + (g[c, 0, 0, 3] * d0 + g[c, 0, 1, 3] * d1 + g[c, 0, 2, 3] * d2)
            y[a, 4] = a4 + (g[c, 0, 0, 4] * d0 + g[c, 0, 1, 4] * d1 + g[c, 0, 2, 4] * d2)
            y[a, 5] = a5 + (g[c, 0, 0, 5] * d0 + g[c, 0, 1, 5] * d1 + g[c, 0, 2, 5] * d2)
            y[b, 0] = b0 + (g[c, 1, 0, 0] * d0 + g[c, 1, 1, 0] * d1 + g[c, 1, 2, 0] * d2)
            y[b, 1] = b1 + (g[c, 1, 0, 1] * d0 + g[c, 1, 1, 1] * d1 + g[c, 1, 2, 1] * d2)
            y[b, 2] = b2 + (g[c, 1, 0, 2] * d0 + g[c, 1, 1, 2] * d1 + g[c, 1, 2, 2] * d2)
            y[b, 3] = b3 + (g[c, 1, 0, 3] * d0 + g[c, 1, 1, 3] * d1 + g[c, 1, 2, 3] * d2)
            y[b, 4] = b4 + (g[c, 1, 0, 4] * d0 + g[c, 1, 1, 4] * d1 + g[c, 1, 2, 4] * d2)
            y[b, 5] = b5 + (g[c, 1, 0, 5] * d0 + g[c, 1, 1, 5] * d1 + g[c, 1, 2, 5] * d2)


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep_any(g, y, index, law, starts, order):
    """The same for any size; planar problems (m = 2, n = 3) come here."""
    m, n = g.shape[2], g.shape[3]
    see, push = np.zeros(3), np.zeros(3)
    for group in order:
        for c in range(starts[group], starts[group + 1]):
            a, b = index[c, 0], index[c, 1]
            c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
            own_n, own_1, own_2 = _own_velocity(law[c, P], law[c, P + 1], law[c, P + 2], c1, c2, s11, s12, s22, law[c, 6])
            see[0], see[1], see[2] = -own_n, -own_1, -own_2 if m == 3 else 0.0
            for i in range(m):
                see[i] += law[c, Q + i] + law[c, C + i] * law[c, P + i]
                for k in range(n):
                    see[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
            push[0], push[1], push[2], law[c, START] = _local_step(
                see[0], see[1], see[2], law[c, 0], c1, c2, s11, s12, s22, law[c, MU], law[c, START]
            )
            for i in range(m):
                change = push[i] - law[c, P + i]
                law[c, P + i] = push[i]
                for k in range(n):
                    y[a, k] += g[c, 0, i, k] * change
                    y[b, k] += g[c, 1, i, k] * change


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep(g, y, index, law, starts, order, ahead):
    """One Gauss-Seidel sweep, group after group in the given order."""
    if g.shape[2] == 3 and g.shape[3] == 6:
        _sweep_spatial(g, y, index, law, starts, order, ahead)
    else:
        _sweep_any(g, y, index, law, starts, order)


@njit(cache=True, nogil=True, error_model="numpy")
def _collect(g: np.ndarray, index: np.ndarray, p: np.ndarray, y: np.ndarray) -> None:
    """y = G^T p from scratch, which also clears the rounding of many sweeps."""
    contacts, _, m, n = g.shape
    y[:] = 0.0
    for c in range(contacts):
        for side in range(2):
            body = index[c, side]
            for i in range(m):
                for k in range(n):
                    y[body, k] += g[c, side, i, k] * p[c, i]


@njit(cache=True, nogil=True, error_model="numpy")
def _residual(g, y, index, law):
    """Natural map error of the impulses in the table, whose y = G^T p is given."""
    contacts, _, m, n = g.shape
    residual, size = 0.0, 0.0
    w = np.zeros(3)
    for c in range(contacts):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            size += law[c, Q + i] * law[c, Q + i] / law[c, SCALE]
            w[i] = law[c, Q + i] + law[c, C + i] * law[c, P + i]
            for k in range(n):
                w[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
        residual += _natural_map2(law[c, P], law[c, P + 1], law[c, P + 2], w[0], w[1], w[2], law[c, MU], law[c, SCALE])
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)


@njit(cache=True, nogil=True, error_model="numpy")
def collect_and_measure(g, y, index, law):
    """y = G^T p from scratch, and the natural map error."""
    _collect(g, index, law[:, P : P + g.shape[2]], y)
    return _residual(g, y, index, law)


@njit(cache=True, nogil=True, error_model="numpy")
def _velocities(factor: np.ndarray, v_free: np.ndarray, y: np.ndarray, v: np.ndarray) -> None:
    """v = v_free + L y."""
    for body in range(v.shape[0]):
        for i in range(v.shape[1]):
            total = v_free[body, i]
            for k in range(i + 1):
                total += factor[body, i, k] * y[body, k]
            v[body, i] = total


@njit(cache=True, nogil=True, error_model="numpy")
def nlgs_bodies(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, v, tolerance, limit, seed, every):
    """Gauss-Seidel over a FrictionProblem. p (C, m) holds the start and then the answer, v (B, n) the velocities.

    Returns the sweeps made and the natural map error measured last.
    """
    factor, g, q, index = _mass_scaled(inverse_mass, v_free, bodies, jacobian, offset)
    law = _laws(g, q, index, mu, compliance, p)
    starts = _groups(index)
    order = np.arange(len(starts) - 1)
    state = _seeded(seed)
    y = np.empty((v_free.shape[0] + 1, v_free.shape[1]))
    error = collect_and_measure(g, y, index, law)
    sweeps = 0
    while error > tolerance and sweeps < limit:
        for _ in range(min(every, limit - sweeps)):
            _shuffle(order, state)
            _sweep(g, y, index, law, starts, order, 1)
            sweeps += 1
        error = collect_and_measure(g, y, index, law)
    for c in range(len(p)):
        for i in range(p.shape[1]):
            p[c, i] = law[c, P + i]
    _velocities(factor, v_free, y, v)
    return sweeps, error


# --- coloured sweeps, for many contacts and threads ---------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def colour_joints(index: np.ndarray, bodies: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colour the joints so that no two of a colour share a body: greedily, in their order.

    Returns starts of the joints (J + 1,), the joints sorted by colour (J,) and the starts of the colours in that list.
    """
    contacts = len(index)
    start = np.empty(contacts + 1, dtype=np.int64)
    joints = 0
    for c in range(contacts):
        if c == 0 or index[c, 0] != index[c - 1, 0] or index[c, 1] != index[c - 1, 1]:
            start[joints] = c
            joints += 1
    start[joints] = contacts
    taken = np.zeros((bodies + 1, 2), dtype=np.uint64)  # 128 colours: more joints than that meet in no block
    colour = np.empty(joints, dtype=np.int64)
    count = np.zeros(129, dtype=np.int64)
    for j in range(joints):
        a, b = index[start[j], 0], index[start[j], 1]
        for k in range(128):
            word, bit = k >> 6, np.uint64(1) << np.uint64(k & 63)
            if not ((taken[a, word] | taken[b, word]) & bit) or k == 127:
                break
        colour[j] = k
        count[k + 1] += 1
        for body in (a, b):
            if body < bodies:  # supports do not move: any number of joints may rest on them at once
                taken[body, word] |= bit
    for k in range(128):
        count[k + 1] += count[k]
    at, order = count[:-1].copy(), np.empty(joints, dtype=np.int64)
    for j in range(joints):
        order[at[colour[j]]] = j
        at[colour[j]] += 1
    return start[: joints + 1], order, count


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def sweep_coloured(g, y, index, law, start, order, colours, first, last, chunk):
    """One sweep over the joints of the colours in the given order; those of one colour in parallel, 128 of them alone.

    Joints of a colour share no body that moves, so the result does not depend on who takes which, nor on how many threads there are.
    """
    for place in range(len(colours)):
        low, high = first[colours[place]], last[colours[place]]
        if colours[place] == 127:
            _sweep(g, y, index, law, start, order[low:high], 4)
        else:
            for part in prange((high - low + chunk - 1) // chunk):
                begin = low + part * chunk
                _sweep(g, y, index, law, start, order[begin : min(begin + chunk, high)], 4)


@njit(cache=True, nogil=True, error_model="numpy")
def prepare_sweeps(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p):
    """What the coloured sweeps need: L, G, bodies of the contacts and the table of contacts."""
    factor, g, q, index = _mass_scaled(inverse_mass, v_free, bodies, jacobian, offset)
    return factor, g, index, _laws(g, q, index, mu, compliance, p)


@njit(cache=True, nogil=True, error_model="numpy")
def velocities(factor, v_free, y, v):
    """v = v_free + L y."""
    _velocities(factor, v_free, y, v)


# --- a local problem, W as sparse blocks ---------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _row_velocity(data, indices, indptr, q, p, c, i):
    """One component of u = W p + q."""
    total = q[c, i]
    for k in range(indptr[c], indptr[c + 1]):
        j = indices[k]
        for l in range(p.shape[1]):  # noqa: E741
            total += data[k, i, l] * p[j, l]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _local_residual(data, indices, indptr, q, mu, p, law):
    """Natural map error of p for a local problem."""
    contacts, m = p.shape
    residual, size = 0.0, 0.0
    for c in range(contacts):
        un = _row_velocity(data, indices, indptr, q, p, c, 0)
        u1 = _row_velocity(data, indices, indptr, q, p, c, 1)
        u2 = _row_velocity(data, indices, indptr, q, p, c, 2) if m == 3 else 0.0
        residual += _natural_map2(p[c, 0], p[c, 1], p[c, 2] if m == 3 else 0.0, un, u1, u2, mu[c], law[c, SCALE])
        for i in range(m):
            size += q[c, i] * q[c, i] / law[c, SCALE]
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)


@njit(cache=True, nogil=True, error_model="numpy")
def nlgs_local(data, indices, indptr, diagonal, q, mu, p, tolerance, limit, seed, every):
    """Gauss-Seidel over a LocalProblem with W in blocks (nnz, m, m). p holds the start and then the answer."""
    contacts, m = p.shape
    law = np.empty((contacts, ROW))
    w = np.zeros((3, 3))
    for c in range(contacts):
        for i in range(m):
            for j in range(m):
                w[i, j] = diagonal[c, i, j]
        _law_row(w, m, mu[c], law, c)
    order = np.arange(contacts)
    state = _seeded(seed)
    error = _local_residual(data, indices, indptr, q, mu, p, law)
    sweeps = 0
    while error > tolerance and sweeps < limit:
        for _ in range(min(every, limit - sweeps)):
            _shuffle(order, state)
            sweeps += 1
            for c in order:
                p2 = p[c, 2] if m == 3 else 0.0
                c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
                own_n, own_1, own_2 = _own_velocity(p[c, 0], p[c, 1], p2, c1, c2, s11, s12, s22, law[c, 6])
                qn = _row_velocity(data, indices, indptr, q, p, c, 0) - own_n
                q1 = _row_velocity(data, indices, indptr, q, p, c, 1) - own_1
                q2 = _row_velocity(data, indices, indptr, q, p, c, 2) - own_2 if m == 3 else 0.0
                pn, p1, p2, law[c, START] = _local_step(qn, q1, q2, law[c, 0], c1, c2, s11, s12, s22, mu[c], law[c, START])
                p[c, 0], p[c, 1] = pn, p1
                if m == 3:
                    p[c, 2] = p2
        error = _local_residual(data, indices, indptr, q, mu, p, law)
    return sweeps, error


# --- a team of threads ---------------------------------------------------------------------------------------------------------------
#
# Threads that share a solve all run the same kernel on the same arrays. Each takes its share of the parts of a :class:`Plan` and waits for
# the others where their results are needed; decisions are taken by all of them alike, from the same numbers. Which thread takes what
# never enters a result: a sum over parts is taken in the order of the parts. So equal inputs give equal bits with any number of threads,
# and with one the same code runs without waiting.


class Team(NamedTuple):
    """What a thread knows of the others."""

    rank: int
    size: int
    gate: np.ndarray  # (3,) of all: how many wait, how often all were through, whether a factorisation failed


@intrinsic
def _add_at(typing: Any, array: types.Array, entry: types.Integer, value: types.Integer) -> tuple[Any, Any]:
    """Add to an entry of an array of int64 at once for all threads; returns what was there."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [context.cast(builder, arguments[1], signature.args[1], types.intp)])
        return builder.atomic_rmw("add", address, context.cast(builder, arguments[2], signature.args[2], types.int64), "seq_cst")

    return types.int64(array, entry, value), generate


@intrinsic
def _look_at(typing: Any, array: types.Array, entry: types.Integer) -> tuple[Any, Any]:
    """An entry of an array of int64 as the other threads left it."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [context.cast(builder, arguments[1], signature.args[1], types.intp)])
        return builder.load_atomic(address, "seq_cst", 8)

    return types.int64(array, entry), generate


@intrinsic
def _let_others_run(typing: Any) -> tuple[Any, Any]:
    """Give the processor to another thread that wants it."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = ir.IntType(32)
        builder.call(get_or_insert_function(builder.module, ir.FunctionType(number, []), "sched_yield"), [])
        return context.get_dummy_value()

    return types.void(), generate


@njit(cache=True, nogil=True, error_model="numpy")
def _wait(team):
    """Go on when all threads of the team are here."""
    if team.size == 1:
        return
    turn = _look_at(team.gate, 1)
    if _add_at(team.gate, 0, 1) == team.size - 1:
        team.gate[0] = 0
        _add_at(team.gate, 1, 1)
    while _look_at(team.gate, 1) == turn:
        _let_others_run()


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _share(team, first, end):
    """The thread's share of a range."""
    count = end - first
    return first + count * team.rank // team.size, first + count * (team.rank + 1) // team.size


# --- sparse blocks: L D U of a matrix over the body graph -----------------------------------------------------------------------
#
# A matrix such as M + H^T R H has one (n, n) block per body and one per pair of bodies that touch. It is factorised as A = L D U, in the
# order that a minimum degree ordering gives (see solvers/pattern.py), looking left (George & Liu, Computer Solution of Large Sparse
# Positive Definite Systems, 1981). Neighbouring columns with nearly the same rows below go together, as in CHOLMOD (Chen, Davis, Hager &
# Rajamanickam, ACM Trans. Math. Softw. 35, 2008): D has a dense square block per run of columns, kept as its inverse, L and D U one dense
# panel each, so that most of the work is products of dense matrices with long inner loops. Panels are stored by columns of L: entry [k,
# i] belongs to column k of the run and row i below it. A symmetric matrix has U = L^T and no panel of D U; it goes by Cholesky, which
# needs no more room than the factors, in the precision of their arrays. Where there is hardly any fill-in (arches, towers, arcades)
# columns stay alone, their blocks one after another in plain unrolled loops, which takes a quarter of the time there. The bits do not
# depend on a library's threads, and the loops below solve without leaving compiled code, which for small scenes is most of the time.
# Multiplications and additions are fused ("contract"), which rounds once instead of twice, and the sums of a solve are taken in the order
# that the processor likes ("reassoc"); equal inputs still give equal bits on one machine.
#
# **Parts.** Large plans are cut into parts of about PART blocks: subtrees of the elimination tree, which do not know of one another, then
# subtrees of what is left of it, of twice the size, and so on; the parts of a level can be worked on at the same time. What a part leaves
# to nodes of later parts goes to rows of its own, the copies, which are added up when their node's turn comes. A part's factors stay in
# the cache while an iteration comes down to it, meets its contacts and goes up again, which pays with one thread too. They are stored in
# the order in which it comes down, when they have to be fetched.
#
# size_m and size_n are tuples of m and n zeros: their lengths are part of their types, so the compiler knows m and n and unrolls.


class Plan(NamedTuple):
    """Where the blocks of A and of its factors are, for N nodes in order of elimination and S runs of them."""

    column: np.ndarray  # (N + 1,) starts of the columns of A below the diagonal
    row: np.ndarray  # (E,) rows of its blocks, ascending in each column
    first: np.ndarray  # (S + 1,) first node of each run
    start: np.ndarray  # (S + 1,) starts of the rows below each run
    below: np.ndarray  # (R,) these rows, ascending in each run
    square: np.ndarray  # (S + 1,) starts of the squares of D, in blocks, and the end of all; see make_plan for their order
    panel: np.ndarray  # (S + 1,) starts of the panels of L and D U likewise
    pull: np.ndarray  # (S + 1,) starts of the earlier runs that leave something to each run
    puller: np.ndarray  # (U,) these runs, ascending
    entry: np.ndarray  # (U,) the first of their rows that is in the run
    part: np.ndarray  # (K + 1,) starts of the parts, in runs
    level: np.ndarray  # (Y + 1,) starts of the levels, in parts
    target: np.ndarray  # (R,) row that stands for each of ``below``: the node itself, or its copy if it is in a later part
    border: np.ndarray  # (K + 1,) starts of the copies of each part; copy e is row N + 1 + e, after the nodes and the supports' row
    spread: np.ndarray  # (N + 1,) starts of the copies of each node
    copies: np.ndarray  # (E,) rows of these copies, by part


@njit(cache=True, nogil=True, error_model="numpy")
def neighbours_below(first: np.ndarray, second: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Adjacency of a graph of given edges: for each node i its neighbours k < i, as starts (size + 1,) and neighbours."""
    start = np.zeros(size + 1, dtype=np.int64)
    for e in range(len(first)):
        start[max(first[e], second[e]) + 1] += 1
    for i in range(size):
        start[i + 1] += start[i]
    at = start[:-1].copy()
    neighbour = np.empty(len(first), dtype=np.int64)
    for e in range(len(first)):
        i = max(first[e], second[e])
        neighbour[at[i]] = min(first[e], second[e])
        at[i] += 1
    return start, neighbour


@njit(cache=True, nogil=True, error_model="numpy")
def fill_in(start: np.ndarray, neighbour: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pattern of L by columns: starts (size + 1,) and rows below the diagonal, ascending, found along the elimination tree."""
    size = len(start) - 1
    column = np.zeros(size + 1, dtype=np.int64)
    parent, mark, at = np.full(size, -1), np.full(size, -1), np.zeros(size, dtype=np.int64)
    row = np.empty(0, dtype=np.int64)
    for writing in range(2):
        mark[:] = -1
        for i in range(size):
            mark[i] = i
            for e in range(start[i], start[i + 1]):
                k = neighbour[e]
                while mark[k] != i:
                    mark[k] = i
                    if writing:
                        row[at[k]] = i
                        at[k] += 1
                    else:
                        column[k + 1] += 1
                        if parent[k] < 0:
                            parent[k] = i
                    k = parent[k]
        if not writing:
            for i in range(size):
                column[i + 1] += column[i]
            _copy(column[:-1], at)
            row = np.empty(column[size], dtype=np.int64)
    return column, row


@njit(cache=True, nogil=True, error_model="numpy")
def runs(column: np.ndarray, row: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Starts of the runs of columns of L that are factorised together, with the end appended: columns with the same rows below, nearly.

    All columns stay alone where L has few blocks to a column. None reaches across a column of which ``head`` says that it starts a part.

    A run takes in the one before it if few zeros come along: at most these shares of its blocks, more where it is short.
    """
    size, count = len(column) - 1, 0
    if column[size] <= THIN * size:
        return np.arange(size + 1)
    first, zeros = np.empty(size + 1, dtype=np.int64), np.zeros(size + 1)
    for j in range(size):
        start, below, added = j, column[j + 1] - column[j], 0.0
        while count > 0 and not head[start] and column[start] > column[start - 1] and row[column[start - 1]] <= j:
            before = first[count - 1]
            width = j + 1 - before
            more = zeros[count - 1] + (start - before) * (j + 1 - start + below - (column[start] - column[start - 1]))
            share = 0.8 if width <= SHORT else (0.3 if width <= 4 * SHORT else 0.08)
            if width > WIDEST or added + more > share * width * (width + below):
                break
            start, added, count = before, added + more, count - 1
        first[count], zeros[count] = start, added
        count += 1
    first[count] = size
    return first[: count + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def cut(first: np.ndarray, second: np.ndarray, size: int, limit: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cut the elimination tree of a graph of given edges, numbered in order of elimination, into parts of about ``limit`` blocks of L.

    Returns the nodes part by part, each part in an order of elimination (N,), the starts of the parts among them (K + 1,), and the starts
    of the levels among the parts. Where L has few blocks to a column there is one part.
    """
    start, neighbour = neighbours_below(first, second, size)
    column, row = fill_in(start, neighbour)
    if column[size] <= THIN * size:  # columns stay alone, see runs
        limit = column[size] + size
    parent, weight = np.full(size, -1), np.empty(size, dtype=np.int64)
    child, sibling = np.full(size, -1), np.full(size, -1)
    for j in range(size - 1, -1, -1):
        weight[j] = 1 + column[j + 1] - column[j]
        if column[j + 1] > column[j]:
            parent[j] = row[column[j]]
            sibling[j], child[parent[j]] = child[parent[j]], j
    # the nodes, children before parents and subtrees together
    post, count, stack = np.empty(size, dtype=np.int64), 0, np.empty(size, dtype=np.int64)
    for root in range(size):
        if parent[root] >= 0:
            continue
        depth, stack[0] = 1, root
        while depth > 0:
            j = stack[depth - 1]
            if child[j] >= 0:
                stack[depth], child[j] = child[j], sibling[child[j]]
                depth += 1
            else:
                post[count] = j
                count, depth = count + 1, depth - 1
    order, part, level = np.empty(size, dtype=np.int64), np.zeros(size + 1, dtype=np.int64), np.zeros(size + 1, dtype=np.int64)
    placed, total = np.zeros(size, dtype=np.bool_), np.empty(size, dtype=np.int64)
    done, parts, levels = 0, 0, 0
    while done < size:
        _copy(weight, total)
        for j in range(size):  # weight of what is left below each node
            if not placed[j] and parent[j] >= 0:
                total[parent[j]] += total[j]
        filled, begun = 0, done
        for i in range(size):
            j = post[i]
            if placed[j] or total[j] > limit:
                continue
            order[done] = j
            done += 1
            if parent[j] < 0 or total[parent[j]] > limit:  # the end of a subtree
                filled += total[j]
                if filled > limit // 2:
                    parts, filled = parts + 1, 0
                    part[parts] = done
        if filled > 0:
            parts += 1
            part[parts] = done
        for i in range(begun, done):
            placed[order[i]] = True
        if done > begun:
            levels += 1
            level[levels] = parts
        limit *= 2
    if size == 0:  # a part all the same
        return order, np.zeros(2, dtype=np.int64), np.arange(2)
    return order, part[: parts + 1], level[: levels + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _pulls(run, begin, below):
    """For each run the earlier ones with a row in it: starts, these runs ascending, and the first of their rows there."""
    count = len(run) - 1
    owner, pull = np.empty(run[count], dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        owner[run[s] : run[s + 1]] = s
    puller, entry, at = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        for d in range(count):
            for t in range(begin[d], begin[d + 1]):
                s = owner[below[t]]
                if t > begin[d] and owner[below[t - 1]] == s:
                    continue
                if writing:
                    puller[at[s]], entry[at[s]] = d, t
                    at[s] += 1
                else:
                    pull[s + 1] += 1
        if not writing:
            for s in range(count):
                pull[s + 1] += pull[s]
            puller, entry, at = np.empty(pull[count], dtype=np.int64), np.empty(pull[count], dtype=np.int64), pull[:-1].copy()
    return pull, puller, entry


@njit(cache=True, nogil=True, error_model="numpy")
def _copies(run, begin, below, part, size):
    """The copies of a plan: target, border, spread and copies, see :class:`Plan`."""
    count = len(part) - 1
    target, border, mark, slot = below.copy(), np.zeros(count + 1, dtype=np.int64), np.full(size, -1), np.empty(size, dtype=np.int64)
    spread, copies, at = np.zeros(size + 1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        mark[:] = -1
        for q in range(count):
            border[q + 1] = border[q]
            for s in range(part[q], part[q + 1]):
                for t in range(begin[s], begin[s + 1]):
                    j = below[t]
                    if j < run[part[q + 1]]:
                        continue
                    if mark[j] != q:
                        mark[j], slot[j] = q, size + 1 + border[q + 1]
                        border[q + 1] += 1
                        if writing:
                            copies[at[j]] = slot[j]
                            at[j] += 1
                        else:
                            spread[j + 1] += 1
                    target[t] = slot[j]
        if not writing:
            for j in range(size):
                spread[j + 1] += spread[j]
            copies, at = np.empty(spread[size], dtype=np.int64), spread[:-1].copy()
    return target, border, spread, copies


@njit(cache=True, nogil=True, error_model="numpy")
def make_plan(first: np.ndarray, second: np.ndarray, size: int, part: np.ndarray, level: np.ndarray) -> Plan:
    """The plan for a graph of given edges, each once, whose nodes are numbered in order of elimination.

    part and level are the starts of the parts among the nodes and of the levels among the parts, as :func:`cut` gives them.
    """
    start, neighbour = neighbours_below(first, second, size)
    column, at = np.zeros(size + 1, dtype=np.int64), np.zeros(size, dtype=np.int64)
    row = np.empty(len(neighbour), dtype=np.int64)
    for k in neighbour:
        column[k + 1] += 1
    for i in range(size):
        column[i + 1] += column[i]
        at[i] = column[i]
    for i in range(size):
        for e in range(start[i], start[i + 1]):
            row[at[neighbour[e]]] = i
            at[neighbour[e]] += 1
    filled, its_row = fill_in(start, neighbour)
    head = np.zeros(size + 1, dtype=np.bool_)
    for q in range(len(part)):
        head[part[q]] = True
    run = runs(filled, its_row, head)
    count = len(run) - 1
    part_of_runs, q = np.zeros(len(part), dtype=np.int64), 0
    for s in range(count + 1):
        if run[s] == part[q]:
            part_of_runs[q] = s
            q += 1
    begin, square, panel = np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        begin[s + 1] = begin[s] + filled[run[s + 1]] - filled[run[s + 1] - 1]
    alone = count == size and len(part) == 2  # see _columns_alone; else in the order in which a solve comes down
    for q in range(len(part) - 1):
        for i in range(part_of_runs[q], part_of_runs[q + 1]):
            s = i if alone else part_of_runs[q] + part_of_runs[q + 1] - 1 - i
            width = run[s + 1] - run[s]
            square[s], panel[s] = square[count], panel[count]
            square[count] += width * width
            panel[count] += width * (begin[s + 1] - begin[s])
    below = np.empty(begin[count], dtype=np.int64)
    for s in range(count):  # those of the last column, which has all that the others have
        _copy(its_row[filled[run[s + 1] - 1] : filled[run[s + 1]]], below[begin[s] : begin[s + 1]])
    pull, puller, entry = _pulls(run, begin, below)
    target, border, spread, copies = _copies(run, begin, below, part_of_runs, size)
    return Plan(column, row, run, begin, below, square, panel, pull, puller, entry, part_of_runs, level, target, border, spread, copies)


class Turns(NamedTuple):
    """The contacts part by part: each belongs to the part of the one of its two bodies that is eliminated first."""

    contact: np.ndarray  # (C,)
    start: np.ndarray  # (K + 1,) starts of the parts
    place: np.ndarray  # (C, 2) places of the bodies, in this order
    landing: np.ndarray  # (C, 2) rows that stand for them: themselves, or their copies in the part
    spot: np.ndarray  # (C,) blocks that couple them


@njit(cache=True, nogil=True, error_model="numpy")
def share_contacts(index: np.ndarray, spot: np.ndarray, plan: Plan) -> Turns:
    """Assign contacts, whose bodies are at the places index (C, 2), to the parts of a plan; those that meet no body go to the last."""
    contacts, count, size = len(index), len(plan.part) - 1, len(plan.column) - 1
    start, order = np.zeros(count + 1, dtype=np.int64), np.arange(contacts)
    start[count] = contacts
    if count == 1:
        return Turns(order, start, index, index, spot)
    own, row = np.empty(size + 1, dtype=np.int64), np.arange(size + 1)
    for q in range(count):
        own[plan.first[plan.part[q]] : plan.first[plan.part[q + 1]]] = q
    own[size] = count - 1
    start[count] = 0
    for c in range(contacts):
        start[own[min(index[c, 0], index[c, 1])] + 1] += 1
    for q in range(count):
        start[q + 1] += start[q]
    at = start[:-1].copy()
    for c in range(contacts):
        q = own[min(index[c, 0], index[c, 1])]
        order[at[q]] = c
        at[q] += 1
    sorted_index, landing, sorted_spot = (
        np.empty((contacts, 2), dtype=np.int64),
        np.empty((contacts, 2), dtype=np.int64),
        np.empty_like(spot),
    )
    for q in range(count):
        for s in range(plan.part[q], plan.part[q + 1]):
            for t in range(plan.start[s], plan.start[s + 1]):
                row[plan.below[t]] = plan.target[t]
        for k in range(start[q], start[q + 1]):
            sorted_spot[k] = spot[order[k]]
            for side in range(2):
                b = index[order[k], side]
                sorted_index[k, side] = b
                landing[k, side] = row[b] if own[b] > q else b
    return Turns(order, start, sorted_index, landing, sorted_spot)


@njit(cache=True, nogil=True, error_model="numpy")
def locate(bodies, last, place, column, row, index, spot):
    """Places of the bodies of each contact (supports: one past the last) and the block that couples them, -1 for none.

    Returns -1 if a pair of bodies has no block in the pattern, 1 if the bodies are those of the ``last`` contacts, else 0.
    """
    size, same = len(place), len(bodies) == len(last)
    for c in range(len(bodies)):
        for side in range(2):
            index[c, side] = place[bodies[c, side]] if bodies[c, side] >= 0 else size
            same = same and bodies[c, side] == last[c, side]
        low, high = min(index[c, 0], index[c, 1]), max(index[c, 0], index[c, 1])
        spot[c] = -1
        if high == size or low == high:
            continue
        first, end = column[low], column[low + 1]
        while first < end:
            middle = (first + end) // 2
            if row[middle] < high:
                first = middle + 1
            else:
                end = middle
        if first == column[low + 1] or row[first] != high:
            return -1
        spot[c] = first
    return 1 if same else 0


@njit(cache=True, nogil=True, error_model="numpy")
def _invert(a, out, work, size_n):
    """Inverse of an (n, n) block by Gauss-Jordan with row pivoting; False if it is singular or not finite."""
    n = len(size_n)
    for i in range(n):
        for j in range(n):
            work[i, j] = a[i, j]
            out[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(work[i, k]) > abs(work[best, k]):
                best = i
        if not (0.0 < abs(work[best, k]) < np.inf):
            return False
        if best != k:
            for j in range(n):
                work[k, j], work[best, j] = work[best, j], work[k, j]
                out[k, j], out[best, j] = out[best, j], out[k, j]
        scale = 1.0 / work[k, k]
        for j in range(n):
            work[k, j] *= scale
            out[k, j] *= scale
        for i in range(n):
            factor = work[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    work[i, j] -= factor * work[k, j]
                    out[i, j] -= factor * out[k, j]
    return True


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _times(a, b, transposed, out, size_n):
    """out = a b, or a b^T."""
    n = len(size_n)
    for p in range(n):
        for q in range(n):
            total = 0.0
            for r in range(n):
                total += a[p, r] * (b[q, r] if transposed else b[r, q])
            out[p, q] = total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _dense(x, at, rows, inner, g, begin, end, out):
    """out (rows, end - begin) = x[:, at : at + rows]^T g[:, begin:end]. Most of a factorisation is spent here: three rows at a time."""
    length, threes, full = end - begin, inner - inner % 3, rows - rows % 3
    for j in range(0, full, 3):
        a, b, c = out[j, :length], out[j + 1, :length], out[j + 2, :length]
        a[:], b[:], c[:] = 0.0, 0.0, 0.0
        for k in range(0, threes, 3):
            x0, x1, x2 = x[k, at + j], x[k + 1, at + j], x[k + 2, at + j]
            y0, y1, y2 = x[k, at + j + 1], x[k + 1, at + j + 1], x[k + 2, at + j + 1]
            z0, z1, z2 = x[k, at + j + 2], x[k + 1, at + j + 2], x[k + 2, at + j + 2]
            g0, g1, g2 = g[k, begin:end], g[k + 1, begin:end], g[k + 2, begin:end]
            for i in range(length):
                h0, h1, h2 = g0[i], g1[i], g2[i]
                a[i] += x0 * h0 + x1 * h1 + x2 * h2
                b[i] += y0 * h0 + y1 * h1 + y2 * h2
                c[i] += z0 * h0 + z1 * h1 + z2 * h2
        for k in range(threes, inner):
            for i in range(length):
                a[i] += x[k, at + j] * g[k, begin + i]
                b[i] += x[k, at + j + 1] * g[k, begin + i]
                c[i] += x[k, at + j + 2] * g[k, begin + i]
    for j in range(full, rows):
        out[j, :length] = 0.0
        for k in range(inner):
            for i in range(length):
                out[j, i] += x[k, at + j] * g[k, begin + i]


@njit(cache=True, nogil=True, error_model="numpy")
def _load(plan, s, where, diagonal, lower, upper, square, low, up, size_n):
    """Blocks of A of the run s into its square and its panels."""
    n, begin, end = len(size_n), plan.first[s], plan.first[s + 1]
    square[:] = 0.0
    up[:] = 0.0
    low[:] = 0.0
    for j in range(begin, end):
        k = (j - begin) * n
        for p in range(n):
            for q in range(n):
                square[k + p, k + q] = diagonal[j, p, q]
        for t in range(plan.column[j], plan.column[j + 1]):
            i = where[plan.row[t]] * n
            for p in range(n):
                for q in range(n):
                    if plan.row[t] < end:
                        square[i + p, k + q], square[k + q, i + p] = lower[t, p, q], upper[t, p, q]
                    else:
                        low[k + q, i + p], up[k + q, i + p] = lower[t, p, q], upper[t, p, q]


@njit(cache=True, nogil=True, error_model="numpy")
def _subtract(product, skip, below, begin, own, end, where, panel, n):
    """panel[j, i] -= product[j, i] for the columns j of the first ``own`` rows of the list and the other rows i of it.

    ``skip`` entries of each line of the product come before those of these rows.
    """
    i = 0
    while own + i < end - begin:
        at, first = where[below[begin + own + i]], i
        while own + i < end - begin and where[below[begin + own + i]] == at + i - first:  # neighbours in both
            i += 1
        for j in range(own):
            for q in range(n):
                to = panel[where[below[begin + j]] * n + q, n * at : n * (at + i - first)]
                what = product[j * n + q, skip + n * first : skip + n * i]
                for k in range(len(to)):
                    to[k] -= what[k]


@njit(cache=True, nogil=True, error_model="numpy")
def _update(plan, d, t0, t1, where, low, up, square, own_low, own_up, out, size_n):
    """Take from a run what the earlier run d leaves to it; ``low`` and ``up`` are the panels of d, t0 to t1 its rows in the run."""
    n, last, inner, length = len(size_n), plan.start[d + 1], len(up), up.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    _dense(up, first, rows, inner, low, first, length, out)
    for j in range(t1 - t0):
        for i in range(t1 - t0):
            row, column = n * where[plan.below[t0 + i]], n * where[plan.below[t0 + j]]
            for q in range(n):
                for p in range(n):
                    square[row + p, column + q] -= out[j * n + q, i * n + p]
    _subtract(out, rows, plan.below, t0, t1 - t0, last, where, own_low, n)
    _dense(low, first, rows, inner, up, first + rows, length, out)
    _subtract(out, 0, plan.below, t0, t1 - t0, last, where, own_up, n)


@njit(cache=True, nogil=True, error_model="numpy")
def _invert_square(a, column, out, work, size_n):
    """Inverse of a square in place, block by block (Gauss & Jordan); False when a block cannot be inverted."""
    n, size = len(size_n), len(a)
    block, inverse = work[0], work[1]
    for b in range(0, size, n):
        for p in range(n):
            for q in range(n):
                block[p, q] = a[b + p, b + q]
        if not _invert(block, inverse, work[2], size_n):
            return False
        for q in range(n):
            for i in range(size):
                column[q, i] = 0.0 if b <= i < b + n else a[i, b + q]
                a[i, b + q] = 1.0 if i == b + q else 0.0
            for p in range(n):
                block[q, p] = inverse[p, q]
        _dense(block, 0, n, n, a[b : b + n], 0, size, out)
        for p in range(n):
            for i in range(size):
                a[b + p, i] = out[p, i]
        _dense(column, 0, size, n, a[b : b + n], 0, size, out)
        for i in range(size):
            to, what = a[i], out[i]
            for k in range(size):
                to[k] -= what[k]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _view(values, start, rows, columns, n):
    """A square or panel as a matrix."""
    begin = start * n * n
    return values[begin : begin + rows * columns].reshape((rows, columns))


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _room(plan, size_n):
    """Room for the squares and the panels of L and of D U; what is not touched, as the last for a symmetric matrix, costs nothing."""
    blocks = len(size_n) * len(size_n)
    return np.empty(plan.square[-1] * blocks), np.empty(plan.panel[-1] * blocks), np.empty(plan.panel[-1] * blocks)


@njit(cache=True, nogil=True, error_model="numpy")
def _columns_alone(plan):
    """Whether each run is one node, all of them in one part."""
    return len(plan.first) == len(plan.column) and len(plan.part) == 2


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _minus_product(c, at, a, i, b, size_n):
    """c[at] -= a[i] b for blocks. For n = 6 a row of c is held in registers."""
    n = len(size_n)
    for p in range(n):
        if n == 6:
            c0, c1, c2, c3, c4, c5 = c[at, p, 0], c[at, p, 1], c[at, p, 2], c[at, p, 3], c[at, p, 4], c[at, p, 5]
            for r in range(6):
                x = a[i, p, r]
                c0 -= x * b[r, 0]
                c1 -= x * b[r, 1]
                c2 -= x * b[r, 2]
                c3 -= x * b[r, 3]
                c4 -= x * b[r, 4]
                c5 -= x * b[r, 5]
            c[at, p, 0], c[at, p, 1], c[at, p, 2], c[at, p, 3], c[at, p, 4], c[at, p, 5] = c0, c1, c2, c3, c4, c5
        else:
            for q in range(n):
                total = c[at, p, q]
                for r in range(n):
                    total -= a[i, p, r] * b[r, q]
                c[at, p, q] = total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _factorise_columns(plan, diagonal, lower, upper, inverse, low, up, symmetric, size_n):
    """:func:`_factorise` where each run is one node: blocks of L and of U^T one after another, all loops over them unrolled."""
    n, size, first, below = len(size_n), len(plan.column) - 1, plan.start, plan.below
    squares, lows, ups = inverse.reshape((size, n, n)), low.reshape((len(below), n, n)), up.reshape((len(below), n, n))
    head, following, at = np.full(size, -1), np.full(size, -1), np.empty(size, dtype=np.int64)
    where = np.empty(size, dtype=np.int64)
    square, turned, other, work = np.empty((1, n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    lows[:] = 0.0
    if not symmetric:
        ups[:] = 0.0
    for j in range(size):
        for t in range(first[j], first[j + 1]):
            where[below[t]] = t
        for t in range(plan.column[j], plan.column[j + 1]):
            i = where[plan.row[t]]
            for p in range(n):
                for q in range(n):
                    lows[i, p, q] = lower[t, p, q]
            if not symmetric:
                for p in range(n):
                    for q in range(n):
                        ups[i, p, q] = upper[t, p, q]
        for p in range(n):
            for q in range(n):
                square[0, p, q] = diagonal[j, p, q]
        k = head[j]
        while k >= 0:  # all columns k < j with a block in row j
            coming, t0, end = following[k], at[k], first[k + 1]
            for p in range(n):
                for q in range(n):
                    total = 0.0
                    for r in range(n):
                        total += squares[k, q, r] * (lows[t0, p, r] if symmetric else ups[t0, p, r])
                    turned[q, p] = total
            _minus_product(square, 0, lows, t0, turned, size_n)
            for t in range(t0 + 1, end):
                _minus_product(lows, where[below[t]], lows, t, turned, size_n)
            if symmetric:
                for p in range(n):
                    for q in range(n):
                        lows[t0, p, q] = turned[q, p]
            else:
                for p in range(n):
                    for q in range(n):
                        total = 0.0
                        for r in range(n):
                            total += lows[t0, p, r] * squares[k, r, q]
                        other[q, p] = total
                for t in range(t0 + 1, end):
                    _minus_product(ups, where[below[t]], ups, t, other, size_n)
                for p in range(n):
                    for q in range(n):
                        lows[t0, p, q], ups[t0, p, q] = other[q, p], turned[q, p]
            if t0 + 1 < end:
                at[k], following[k] = t0 + 1, head[below[t0 + 1]]
                head[below[t0 + 1]] = k
            k = coming
        if not _invert(square[0], squares[j], work, size_n):
            return False
        if first[j] < first[j + 1]:
            at[j], following[j] = first[j], head[below[first[j]]]
            head[below[first[j]]] = j
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _extent(plan, first, last, n):
    """Most rows and longest line of the squares and panels that a factorisation of runs first to last meets."""
    widest, longest = 0, 0
    for s in range(first, last):
        width = plan.first[s + 1] - plan.first[s]
        widest, longest = max(widest, n * width), max(longest, n * max(width, plan.start[s + 1] - plan.start[s]))
        for e in range(plan.pull[s], plan.pull[s + 1]):
            d = plan.puller[e]
            widest, longest = max(widest, n * (plan.first[d + 1] - plan.first[d])), max(longest, n * (plan.start[d + 1] - plan.entry[e]))
    return widest, longest


@njit(cache=True, nogil=True, error_model="numpy")
def _number(plan, s, where):
    """``where`` the nodes of run s and the rows below it stand in its square and its panel."""
    for i in range(plan.first[s], plan.first[s + 1]):
        where[i] = i - plan.first[s]
    for t in range(plan.start[s], plan.start[s + 1]):
        where[plan.below[t]] = t - plan.start[s]


@njit(cache=True, nogil=True, error_model="numpy")
def _end_inside(plan, e, end):
    """The end of those rows of the e-th puller that are before node ``end``."""
    t, last = plan.entry[e], plan.start[plan.puller[e] + 1]
    while t < last and plan.below[t] < end:
        t += 1
    return t


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _factorise(plan, diagonal, lower, upper, inverse, low, up, size_n):
    """A = L D U: inverse (squares of D^-1), low (panels of L) and up (panels of D U) from diagonal blocks A_jj, lower A_ij, upper A_ji^T.

    Returns False when a diagonal block cannot be inverted.
    """
    if _columns_alone(plan):
        return _factorise_columns(plan, diagonal, lower, upper, inverse, low, up, UNSYMMETRIC, size_n)
    n, size, count = len(size_n), len(plan.column) - 1, len(plan.first) - 1
    widest, longest = _extent(plan, 0, count, n)
    out, column, work = np.empty((widest, longest)), np.empty((n, widest)), np.empty((3, n, n))
    where = np.empty(size, dtype=np.int64)
    for s in range(count):
        _number(plan, s, where)
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square = _view(inverse, plan.square[s], width, width, n)
        own_low, own_up = _view(low, plan.panel[s], width, length, n), _view(up, plan.panel[s], width, length, n)
        _load(plan, s, where, diagonal, lower, upper, square, own_low, own_up, size_n)
        for e in range(plan.pull[s], plan.pull[s + 1]):
            d = plan.puller[e]
            rows, columns = n * (plan.first[d + 1] - plan.first[d]), n * (plan.start[d + 1] - plan.start[d])
            its_low, its_up = _view(low, plan.panel[d], rows, columns, n), _view(up, plan.panel[d], rows, columns, n)
            t1 = _end_inside(plan, e, plan.first[s + 1])
            _update(plan, d, plan.entry[e], t1, where, its_low, its_up, square, own_low, own_up, out, size_n)
        if not _invert_square(square, column, out, work, size_n):
            return False
        _dense(square, 0, width, width, own_low, 0, length, out)
        for j in range(width):
            for i in range(length):
                own_low[j, i] = out[j, i]
    return True


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _root(a, out):
    """out = C^-T, upper triangular, of a symmetric a = C C^T, of which the upper triangle is given and used up; False if there is none."""
    size = len(a)
    out[:] = 0.0
    for k in range(size):
        if not (0.0 < a[k, k] < np.inf):
            return False
        out[k, k] = 1.0
        own, line, inverse = a[k], out[k], 1.0 / a[k, k]
        for i in range(k + 1, size):  # rows of the identity below each other: C^-1 but for the lengths of its rows
            factor, other, root = own[i] * inverse, a[i], out[i]
            for j in range(i, size):
                other[j] -= factor * own[j]
            for j in range(k + 1):
                root[j] -= factor * line[j]
    for k in range(size):
        length = 1.0 / np.sqrt(a[k, k])
        for j in range(k + 1):
            out[k, j] *= length
    for k in range(size):
        for j in range(k):
            out[j, k], out[k, j] = out[k, j], 0.0
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _load_symmetric(plan, s, where, diagonal, lower, square, panel, n):
    """Blocks of a symmetric A of the run s into the upper triangle of its square and into its panel."""
    begin, end = plan.first[s], plan.first[s + 1]
    square[:] = 0.0
    panel[:] = 0.0
    for j in range(begin, end):
        k = (j - begin) * n
        for p in range(n):
            for q in range(n):
                square[k + p, k + q] = diagonal[j, p, q]
        for t in range(plan.column[j], plan.column[j + 1]):
            i = where[plan.row[t]] * n
            for p in range(n):
                for q in range(n):
                    if plan.row[t] < end:
                        square[k + q, i + p] = lower[t, p, q]
                    else:
                        panel[k + q, i + p] = lower[t, p, q]


@njit(cache=True, nogil=True, error_model="numpy")
def _update_symmetric(plan, d, t0, t1, where, panel, square, own, out, n):
    """:func:`_update` of a symmetric matrix, of the upper triangle of the square."""
    last, inner, length = plan.start[d + 1], len(panel), panel.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    _dense(panel, first, rows, inner, panel, first, length, out)
    for j in range(t1 - t0):
        row = n * where[plan.below[t0 + j]]
        for i in range(j, t1 - t0):
            column = n * where[plan.below[t0 + i]]
            for q in range(n):
                for p in range(n):
                    square[row + q, column + p] -= out[j * n + q, i * n + p]
    _subtract(out, rows, plan.below, t0, t1 - t0, last, where, own, n)


@njit(cache=True, nogil=True, error_model="numpy")
def _factorise_runs(plan, first, last, diagonal, lower, squares, panels, n):
    """A = L L^T of a symmetric A for runs first to last, if all that they pull from are done, with blocks of n x n.

    Squares: C^-T of the triangles C on the diagonal of L; panels: L^T right of them; in the precision of their arrays. Only the square at
    work is in double precision whatever they are. Returns False when A is not positive definite.
    """
    size = len(plan.column) - 1
    widest, longest = _extent(plan, first, last, n)
    out, where = np.empty((widest, longest), dtype=panels.dtype), np.empty(size, dtype=np.int64)
    room, other = np.empty(widest * widest), np.empty(widest * widest)
    for s in range(first, last):
        _number(plan, s, where)
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square, panel = room[: width * width].reshape((width, width)), _view(panels, plan.panel[s], width, length, n)
        _load_symmetric(plan, s, where, diagonal, lower, square, panel, n)
        for e in range(plan.pull[s], plan.pull[s + 1]):
            d, t1 = plan.puller[e], _end_inside(plan, e, plan.first[s + 1])
            its = _view(panels, plan.panel[d], n * (plan.first[d + 1] - plan.first[d]), n * (plan.start[d + 1] - plan.start[d]), n)
            _update_symmetric(plan, d, plan.entry[e], t1, where, its, square, panel, out, n)
        root, kept = other[: width * width].reshape((width, width)), _view(squares, plan.square[s], width, width, n)
        if not _root(square, root):
            return False
        _copy(root, kept)
        for j in range(width - 1 - (width - 1) % 3, -1, -3):  # from below, where a row needs all above it and none needs it
            rows = min(3, width - j)
            _dense(kept, j, rows, j + rows, panel, 0, length, out)
            for k in range(rows):
                for i in range(length):
                    panel[j + k, i] = out[k, i]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _free_of_roots(plan, first, last, squares, panels, n):
    """From the factors of :func:`_factorise_runs` to A = L D L^T with ones on the diagonal of L: squares of D^-1 and panels of L.

    A solve then reads the squares once, not twice.
    """
    widest, longest = _extent(plan, first, last, n)
    out, room = np.empty((3, longest), dtype=panels.dtype), np.empty(widest * widest, dtype=panels.dtype)
    for s in range(first, last):
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square, panel = _view(squares, plan.square[s], width, width, n), _view(panels, plan.panel[s], width, length, n)
        root = room[: width * width].reshape((width, width))  # C^-1
        for j in range(width):
            for i in range(width):
                root[i, j] = square[j, i]
        for j in range(0, width, 3):  # from above, where a row needs all below it and none needs it
            rows = min(3, width - j)
            for lines, of in ((square, root), (panel, panel)):
                _dense(root[j:], j, rows, width - j, of[j:], 0, lines.shape[1], out)
                for k in range(rows):
                    for i in range(lines.shape[1]):
                        lines[j + k, i] = out[k, i]


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _factorise_symmetric(plan, diagonal, lower, squares, panels, size_n):
    """A = L D L^T: squares of D^-1 and panels of L from diagonal blocks A_jj and lower A_ij.

    Returns False when A is not positive definite; if all columns are alone, when a diagonal block cannot be inverted.
    """
    if _columns_alone(plan):
        return _factorise_columns(plan, diagonal, lower, lower, squares, panels, panels, SYMMETRIC, size_n)
    n, count = len(size_n), len(plan.first) - 1
    ok = _factorise_runs(plan, 0, count, diagonal, lower, squares, panels, n)
    if ok:
        _free_of_roots(plan, 0, count, squares, panels, n)
    return ok


@njit(cache=True, nogil=True, error_model="numpy")
def _factorise_together(team, plan, diagonal, lower, squares, panels, n):
    """:func:`_factorise_symmetric` by a team, where not all columns are alone."""
    for level in range(len(plan.level) - 1):
        begin, end = _share(team, plan.level[level], plan.level[level + 1])
        for q in range(begin, end):
            first, last = plan.part[q], plan.part[q + 1]
            if team.gate[2] == 0 and not _factorise_runs(plan, first, last, diagonal, lower, squares, panels, n):
                team.gate[2] = 1
        _wait(team)
    ok = team.gate[2] == 0
    begin, end = _all_parts(team, plan)
    if ok:
        _free_of_roots(plan, plan.part[begin], plan.part[end], squares, panels, n)
    _wait(team)
    team.gate[2] = 0
    return ok


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _add_columns(lines, at, length, factors, out, size_n):
    """out = sum of factors[k] times line k, lines of so many entries one after another from ``at`` on; three at a time, as in the next."""
    count, threes = len(factors), len(factors) - len(factors) % 3 if len(size_n) % 3 else len(factors)
    out[:length] = 0.0
    for k in range(0, threes, 3):
        x0, x1, x2 = factors[k], factors[k + 1], factors[k + 2]
        a, b, c = at + k * length, at + (k + 1) * length, at + (k + 2) * length
        l0, l1, l2 = lines[a:b], lines[b:c], lines[c : c + length]
        for i in range(length):
            out[i] += l0[i] * x0 + l1[i] * x1 + l2[i] * x2
    for k in range(threes, count):
        line = lines[at + k * length : at + (k + 1) * length]
        for i in range(length):
            out[i] += line[i] * factors[k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _add_rows(lines, at, length, factors, sign, out, size_n):
    """out[k] += sign times line k . factors."""
    factor = lines.dtype.type(sign)
    count, threes = len(out), len(out) - len(out) % 3 if len(size_n) % 3 else len(out)
    for k in range(0, threes, 3):
        a, b, c = at + k * length, at + (k + 1) * length, at + (k + 2) * length
        l0, l1, l2 = lines[a:b], lines[b:c], lines[c : c + length]
        t0 = t1 = t2 = lines.dtype.type(0.0)
        for i in range(length):
            x = factors[i]
            t0 += l0[i] * x
            t1 += l1[i] * x
            t2 += l2[i] * x
        out[k] += factor * t0
        out[k + 1] += factor * t1
        out[k + 2] += factor * t2
    for k in range(threes, count):
        line, total = lines[at + k * length : at + (k + 1) * length], lines.dtype.type(0.0)
        for i in range(length):
            total += line[i] * factors[i]
        out[k] += factor * total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _go_up_columns(plan, low, x, size_n):
    """:func:`_go_up` where each run is one node."""
    n, below = len(size_n), plan.below
    lows = low.reshape((len(below), n, n))
    for j in range(len(plan.column) - 1):
        for t in range(plan.start[j], plan.start[j + 1]):
            i = below[t]
            for p in range(n):
                total = x[i, p]
                for q in range(n):
                    total -= lows[t, p, q] * x[j, q]
                x[i, p] = total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _come_down_columns(plan, inverse, up, x, size_n):
    """:func:`_come_down` where each run is one node."""
    n, below, size = len(size_n), plan.below, len(plan.column) - 1
    squares, ups, y = inverse.reshape((size, n, n)), up.reshape((len(below), n, n)), np.empty(n, dtype=up.dtype)
    for j in range(size):
        for p in range(n):
            total = up.dtype.type(0.0)
            for q in range(n):
                total += squares[j, p, q] * x[j, q]
            y[p] = total
        for p in range(n):
            x[j, p] = y[p]
    for j in range(size - 1, -1, -1):
        for t in range(plan.start[j], plan.start[j + 1]):
            i = below[t]
            for q in range(n):
                total = x[j, q]
                for p in range(n):
                    total -= ups[t, p, q] * x[i, p]
                x[j, q] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _longest(plan, first, last, n):
    """Entries of the longest line of a panel or square of runs first to last."""
    longest = 0
    for s in range(first, last):
        longest = max(longest, n * max(plan.first[s + 1] - plan.first[s], plan.start[s + 1] - plan.start[s]))
    return longest


@njit(cache=True, nogil=True, error_model="numpy")
def _gather(plan, s, x, y, n):
    """y = the rows of x below run s."""
    k = 0
    for t in range(plan.start[s], plan.start[s + 1]):
        for p in range(n):
            y[k] = x[plan.below[t], p]
            k += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _take_off(plan, s, row, y, x, n):
    """Take y off the rows of x below run s; ``row`` says where these are: plan.below, or plan.target."""
    k = 0
    for t in range(plan.start[s], plan.start[s + 1]):
        for p in range(n):
            x[row[t], p] -= y[k]
            k += 1


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _solve_factorised(plan, inverse, low, up, x, size_n):
    """Solve L D U x = x in place, x (N or more, n)."""
    if _columns_alone(plan):
        _go_up_columns(plan, low, x, size_n)
        _come_down_columns(plan, inverse, up, x, size_n)
        return
    n, count = len(size_n), len(plan.first) - 1
    longest, blocks, flat = _longest(plan, 0, count, n), n * n, x.reshape(x.size)
    y, z = np.empty(longest), np.empty(longest)
    for s in range(count):
        own, length = flat[n * plan.first[s] : n * plan.first[s + 1]], n * (plan.start[s + 1] - plan.start[s])
        _add_columns(low, plan.panel[s] * blocks, length, own, y, size_n)
        _take_off(plan, s, plan.below, y, x, n)
    for s in range(count - 1, -1, -1):
        own, length = flat[n * plan.first[s] : n * plan.first[s + 1]], n * (plan.start[s + 1] - plan.start[s])
        _gather(plan, s, x, y, n)
        _add_rows(up, plan.panel[s] * blocks, length, y, -1.0, own, size_n)
        _copy(own, z)
        own[:] = 0.0
        _add_rows(inverse, plan.square[s] * blocks, len(own), z, 1.0, own, size_n)


@njit(cache=True, nogil=True, error_model="numpy")
def _go_up(plan, first, last, row, panels, x, size_n):
    """x <- L^-1 x of a symmetric matrix for runs first to last; ``row`` as in :func:`_take_off`."""
    if _columns_alone(plan):
        _go_up_columns(plan, panels, x, size_n)
        return
    n, blocks, flat = len(size_n), len(size_n) * len(size_n), x.reshape(x.size)
    y = np.empty(_longest(plan, first, last, n), dtype=panels.dtype)
    for s in range(first, last):
        own, length = flat[n * plan.first[s] : n * plan.first[s + 1]], n * (plan.start[s + 1] - plan.start[s])
        _add_columns(panels, plan.panel[s] * blocks, length, own, y, size_n)
        _take_off(plan, s, row, y, x, n)


@njit(cache=True, nogil=True, error_model="numpy")
def _come_down(plan, first, last, squares, panels, x, size_n):
    """x <- L^-T D^-1 x of a symmetric matrix for runs first to last, if the later ones are done."""
    if _columns_alone(plan):
        _come_down_columns(plan, squares, panels, x, size_n)
        return
    n, blocks, flat = len(size_n), len(size_n) * len(size_n), x.reshape(x.size)
    y = np.empty(_longest(plan, first, last, n), dtype=panels.dtype)
    for s in range(last - 1, first - 1, -1):
        own, length = flat[n * plan.first[s] : n * plan.first[s + 1]], n * (plan.start[s + 1] - plan.start[s])
        _copy(own, y[: len(own)])
        own[:] = 0.0
        _add_rows(squares, plan.square[s] * blocks, len(own), y, 1.0, own, size_n)
        _gather(plan, s, x, y, n)
        _add_rows(panels, plan.panel[s] * blocks, length, y, -1.0, own, size_n)


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _solve_symmetric(plan, squares, panels, x, size_n):
    """Solve A x = x in place for the factors of a symmetric A, x (N or more, n)."""
    count = len(plan.first) - 1
    _go_up(plan, 0, count, plan.below, panels, x, size_n)
    _come_down(plan, 0, count, squares, panels, x, size_n)


# --- bodies in the order of the factorisation --------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def _in_order(inverse_mass, v_free, order, size_n):
    """M^-1, M and v_free with the bodies in elimination order."""
    bodies, n = len(order), len(size_n)
    inverse, mass, free = np.empty((bodies, n, n)), np.empty((bodies, n, n)), np.empty((bodies, n))
    _put_in_order(inverse_mass, v_free, order, 0, bodies, inverse, mass, free, size_n)
    return inverse, mass, free


@njit(cache=True, nogil=True, error_model="numpy")
def _put_in_order(inverse_mass, v_free, order, first, end, inverse, mass, free, size_n):
    """The same for places first to end of given arrays."""
    n = len(size_n)
    work = np.empty((n, n))
    for b in range(first, end):
        coupled = False
        for i in range(n):
            free[b, i] = v_free[order[b], i]
            for j in range(n):
                inverse[b, i, j] = inverse_mass[order[b], i, j]
                mass[b, i, j] = 0.0
                coupled = coupled or (i != j and inverse[b, i, j] != 0.0)
        if coupled:
            _invert(inverse[b], mass[b], work, size_n)
        else:  # as in a plane
            for i in range(n):
                mass[b, i, i] = 1.0 / inverse[b, i, i]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _scales(inverse, jacobian, index, compliance, size_m, size_n):
    """d_c = trace(W_cc + C_cc) / m."""
    d = np.empty(len(index))
    _measure_scales(inverse, jacobian, index, compliance, 0, len(index), d, size_m, size_n)
    return d


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _measure_scales(inverse, jacobian, index, compliance, first, end, d, size_m, size_n):
    """The same for contacts first to end."""
    m, n, bodies = len(size_m), len(size_n), len(inverse)
    for c in range(first, end):
        a, b, trace = index[c, 0], index[c, 1], 0.0
        for side in range(2):
            body = index[c, side]
            if body == bodies:
                continue
            for i in range(m):
                for k in range(n):
                    total = 0.0
                    for l in range(n):  # noqa: E741
                        total += inverse[body, k, l] * jacobian[c, side, i, l]
                        if a == b:
                            total += inverse[body, k, l] * jacobian[c, 1 - side, i, l]
                    trace += total * jacobian[c, side, i, k]
        if len(compliance):
            for i in range(m):
                trace += compliance[c, i]
        d[c] = trace / m


@njit(cache=True, nogil=True, error_model="numpy")
def _rows(jacobian, index, offset, v, u, size_m, size_n):
    """u = H v + b; v (bodies + 1, n) with a last row of zeros for the supports."""
    _some_rows(jacobian, index, offset, v, 0, len(index), u, size_m, size_n)


@njit(cache=True, nogil=True, error_model="numpy")
def _some_rows(jacobian, index, offset, v, first, end, u, size_m, size_n):
    """The same for contacts first to end."""
    m, n = len(size_m), len(size_n)
    for c in range(first, end):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            total = offset[c, i]
            for k in range(n):
                total += jacobian[c, 0, i, k] * v[a, k] + jacobian[c, 1, i, k] * v[b, k]
            u[c, i] = total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _add_push(jacobian, index, p, out, size_m, size_n):
    """out += H^T p; the last row of out, of the supports, is of no use."""
    m, n = len(size_m), len(size_n)
    for c in range(len(index)):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            x = p[c, i]
            for k in range(n):
                out[a, k] += jacobian[c, 0, i, k] * x
                out[b, k] += jacobian[c, 1, i, k] * x


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _velocity_of(inverse, free, jacobian, index, p, push, v, size_m, size_n):
    """v = v_free + M^-1 H^T p, with a last row of zeros."""
    n = len(size_n)
    push[:] = 0.0
    _add_push(jacobian, index, p, push, size_m, size_n)
    for b in range(len(inverse)):
        for i in range(n):
            total = free[b, i]
            for k in range(n):
                total += inverse[b, i, k] * push[b, k]
            v[b, i] = total
    v[-1] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _missing_momentum(mass, free, v, out, size_n):
    """out = M (v_free - v)."""
    _some_momentum(mass, free, v, 0, len(mass), out, size_n)
    out[-1] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _some_momentum(mass, free, v, first, end, out, size_n):
    """The same for bodies first to end."""
    n = len(size_n)
    for b in range(first, end):
        for i in range(n):
            total = 0.0
            for k in range(n):
                total += mass[b, i, k] * (free[b, k] - v[b, k])
            out[b, i] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _size_of(q: np.ndarray, d: np.ndarray) -> float:
    """|q / sqrt(d)|, by which errors are divided; 1 if it is zero."""
    total = 0.0
    for c in range(len(d)):
        for i in range(q.shape[1]):
            total += q[c, i] * q[c, i] / d[c]
    return np.sqrt(total) if total > 0.0 else 1.0


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n):
    """Norm of the natural map residual for impulses p and body velocities v."""
    return np.sqrt(_some_map2(jacobian, index, offset, mu, compliance, d, p, v, 0, len(index), size_m, size_n))


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _some_map2(jacobian, index, offset, mu, compliance, d, p, v, first, end, size_m, size_n):
    """Its square, of the contacts first to end."""
    m, n = len(size_m), len(size_n)
    total = 0.0
    for c in range(first, end):
        a, b = index[c, 0], index[c, 1]
        un, u1, u2 = offset[c, 0], offset[c, 1], 0.0
        if m == 3:
            u2 = offset[c, 2]
        for k in range(n):
            x, y = v[a, k], v[b, k]
            un += jacobian[c, 0, 0, k] * x + jacobian[c, 1, 0, k] * y
            u1 += jacobian[c, 0, 1, k] * x + jacobian[c, 1, 1, k] * y
            if m == 3:
                u2 += jacobian[c, 0, 2, k] * x + jacobian[c, 1, 2, k] * y
        p2 = p[c, 2] if m == 3 else 0.0
        if len(compliance):
            un += compliance[c, 0] * p[c, 0]
            u1 += compliance[c, 1] * p[c, 1]
            u2 += compliance[c, m - 1] * p2
        total += _natural_map2(p[c, 0], p[c, 1], p2, un, u1, u2, mu[c], d[c])
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _nodes(plan, q):
    """First node of a part and the one after its last."""
    return plan.first[plan.part[q]], plan.first[plan.part[q + 1]]


@njit(cache=True, nogil=True, error_model="numpy")
def _clear_copies(plan, q, values):
    """Nothing left by part q to later ones; values (N + 1 + E, ...)."""
    size = len(plan.spread)
    values[size + plan.border[q] : size + plan.border[q + 1]] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _add_copies(plan, q, values):
    """Add to the nodes of part q what earlier parts left to them."""
    begin, end = _nodes(plan, q)
    for j in range(begin, end):
        for e in range(plan.spread[j], plan.spread[j + 1]):
            for i in range(values.shape[1]):
                values[j, i] += values[plan.copies[e], i]


@njit(cache=True, nogil=True, error_model="numpy")
def _all_parts(team, plan):
    """The thread's share of all parts."""
    return _share(team, 0, len(plan.part) - 1)


@njit(cache=True, nogil=True, error_model="numpy")
def _clear_push(plan, q, push):
    """No impulse on the bodies of part q, and none left by it to later ones."""
    first, last = _nodes(plan, q)
    push[first:last] = 0.0
    _clear_copies(plan, q, push)


@njit(cache=True, nogil=True, error_model="numpy")
def _pushed_together(team, plan, inverse, free, push, v, size_n):
    """v = v_free + M^-1 of what all parts pushed."""
    n, (begin, end) = len(size_n), _all_parts(team, plan)
    _wait(team)
    for q in range(begin, end):
        first, last = _nodes(plan, q)
        _add_copies(plan, q, push)
        for b in range(first, last):
            for i in range(n):
                total = free[b, i]
                for k in range(n):
                    total += inverse[b, i, k] * push[b, k]
                v[b, i] = total
    _wait(team)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _push_some(jacobian, turns, q, p, out, size_m, size_n):
    """out += H^T p of the contacts of part q."""
    m, n = len(size_m), len(size_n)
    for c in range(turns.start[q], turns.start[q + 1]):
        a, b = turns.landing[c, 0], turns.landing[c, 1]
        for i in range(m):
            x = p[c, i]
            for k in range(n):
                out[a, k] += jacobian[c, 0, i, k] * x
                out[b, k] += jacobian[c, 1, i, k] * x


@njit(cache=True, nogil=True, error_model="numpy")
def _map_norm_together(team, plan, turns, jacobian, index, offset, mu, compliance, d, p, v, sums, size_m, size_n):
    """Norm of the natural map residual by a team; sums (K,) is where they put their shares."""
    begin, end = _all_parts(team, plan)
    for q in range(begin, end):
        first, last = turns.start[q], turns.start[q + 1]
        sums[q] = _some_map2(jacobian, index, offset, mu, compliance, d, p, v, first, last, size_m, size_n)
    _wait(team)
    total = np.sqrt(sums.sum())
    _wait(team)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _put_back(v, order, out):
    """Velocities from elimination order to the order of the problem."""
    for b in range(len(order)):
        for i in range(out.shape[1]):
            out[order[b], i] = v[b, i]


@njit(cache=True, nogil=True, error_model="numpy")
def _law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, scaled, size_m, size_n):
    """w = H v + b + C p of impulses p, q = H v_free + b, and d, which is 1 if not ``scaled``."""
    count, contacts, m, n = len(v_free), len(p), len(size_m), len(size_n)
    index = np.empty((contacts, 2), dtype=np.int64)
    for c in range(contacts):
        for side in range(2):
            index[c, side] = bodies[c, side] if bodies[c, side] >= 0 else count
    v, push, q, w = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.empty((contacts, m)), np.empty((contacts, m))
    _copy(v_free, v)
    _rows(jacobian, index, offset, v, q, size_m, size_n)
    _velocity_of(inverse_mass, v_free, jacobian, index, p, push, v, size_m, size_n)
    _rows(jacobian, index, offset, v, w, size_m, size_n)
    if len(compliance):
        for c in range(contacts):
            for i in range(m):
                w[c, i] += compliance[c, i] * p[c, i]
    d = _scales(inverse_mass, jacobian, index, compliance, size_m, size_n) if scaled else np.ones(contacts)
    return w, q, d


@njit(cache=True, nogil=True, error_model="numpy")
def error_bodies(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, scaled, size_m, size_n):
    """Norms of the natural map residual and of q for impulses p over a FrictionProblem; scaled by d, or with d = 1."""
    w, q, d = _law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, scaled, size_m, size_n)
    return natural_map_norms(p, w, q, mu, d)


@njit(cache=True, nogil=True, error_model="numpy")
def errors_by_group(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, group, groups, size_m, size_n):
    """The same norms, scaled, over each group of contacts: (G,) and (G,); ``group`` (C,) is the number of each contact's."""
    w, q, d = _law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, True, size_m, size_n)
    residual, size, m = np.zeros(groups), np.zeros(groups), len(size_m)
    for c in range(len(p)):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        residual[group[c]] += _natural_map2(p[c, 0], p[c, 1], p2, w[c, 0], w[c, 1], w2, mu[c], d[c])
        for i in range(m):
            size[group[c]] += q[c, i] * q[c, i] / d[c]
    return np.sqrt(residual), np.sqrt(size)


# --- ADMM over bodies ------------------------------------------------------------------------------------------------------------------


class Desk(NamedTuple):
    """Room for what a team works on together: bodies in the order of elimination, then the supports, then the copies."""

    inverse: np.ndarray  # (N, n, n) M^-1
    mass: np.ndarray  # (N, n, n)
    free: np.ndarray  # (N, n) v_free
    v: np.ndarray  # (N + 1, n)
    trial: np.ndarray  # (N + 1, n) velocities to be judged
    best_v: np.ndarray  # (N + 1, n)
    push: np.ndarray  # (N + 1 + E, n)
    x: np.ndarray  # (N + 1 + E, n) in single precision
    jacobian: np.ndarray  # (C, 2, m, n) contacts in the order of their parts, here and in what follows
    offset: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)
    compliance: np.ndarray  # (C, m), or (0, m)
    even: np.ndarray  # (C, m) impulses after an even number of iterations
    odd: np.ndarray  # (C, m)
    best: np.ndarray  # (C, m)
    carried: np.ndarray  # (C, m) impulses to be judged
    d: np.ndarray  # (C,)
    sums: np.ndarray  # (3, K) shares of the parts in sums
    diagonal: np.ndarray  # (N + 1 + E, n n) blocks of M + H^T R H
    lower: np.ndarray  # (pairs, n, n)
    squares: np.ndarray  # of the factors in double precision, if all columns are alone
    panels: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def _sort_contacts(turns, jacobian, offset, mu, compliance, p, first, end, desk, size_m, size_n):
    """Put contacts first to end on the desk, unless they lie there as they are."""
    m, n, moved = len(size_m), len(size_n), len(turns.start) > 2
    for c in range(first, end):
        old = turns.contact[c]
        for i in range(m):
            desk.even[c, i] = p[old, i]
        if not moved:
            continue
        desk.mu[c] = mu[old]
        for i in range(m):
            desk.offset[c, i] = offset[old, i]
            if len(compliance):
                desk.compliance[c, i] = compliance[old, i]
            for k in range(n):
                desk.jacobian[c, 0, i, k] = jacobian[old, 0, i, k]
                desk.jacobian[c, 1, i, k] = jacobian[old, 1, i, k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _augment(plan, turns, q, mass, jacobian, rho, diagonal, lower, size_m, size_n):
    """Blocks of M + H^T R H in the columns of part q, and what its contacts add to diagonal blocks (.., n n) of later ones."""
    m, n, bodies, (first, last) = len(size_m), len(size_n), len(mass), _nodes(plan, q)
    lower[plan.column[first] : plan.column[last]] = 0.0
    _clear_copies(plan, q, diagonal)
    for b in range(first, last):
        for p in range(n):
            for r in range(n):
                diagonal[b, n * p + r] = mass[b, p, r]
    for c in range(turns.start[q], turns.start[q + 1]):
        a, b, r = turns.landing[c, 0], turns.landing[c, 1], rho[c]
        for i in range(m):
            for p in range(n):
                x, y = r * jacobian[c, 0, i, p], r * jacobian[c, 1, i, p]
                for t in range(n):
                    if a != bodies:
                        diagonal[a, n * p + t] += x * jacobian[c, 0, i, t]
                    if b != bodies:
                        diagonal[b, n * p + t] += y * jacobian[c, 1, i, t]
                if a == b != bodies:
                    for t in range(n):
                        diagonal[a, n * p + t] += x * jacobian[c, 1, i, t] + y * jacobian[c, 0, i, t]
                if turns.spot[c] >= 0:
                    for t in range(n):
                        lower[turns.spot[c], p, t] += (
                            x * jacobian[c, 1, i, t] if turns.place[c, 0] > turns.place[c, 1] else y * jacobian[c, 0, i, t]
                        )


@njit(cache=True, nogil=True, error_model="numpy")
def _choose_stiffness(k, d, compliance, first, end, rho):
    """R of each contact: k / d_c for rigid ones, softer for elastic ones, see solvers/admm.py."""
    for c in range(first, end):
        rho[c] = k / d[c]
        if len(compliance):
            soft = compliance[c].sum() / compliance.shape[1]
            own = d[c] - soft
            rho[c] = 1.0 / (own / k + soft / np.sqrt(1.0 + soft / own))


@njit(cache=True, nogil=True, error_model="numpy")
def _prepare_admm(team, plan, turns, k, desk, squares, panels, rho, size_m, size_n):
    """Factorise M + H^T R H by a team; the factors are in single precision. False if that is not possible."""
    n, (begin, end) = len(size_n), _all_parts(team, plan)
    first, last = _share(team, 0, len(rho))
    _choose_stiffness(k, desk.d, desk.compliance, first, last, rho)
    _wait(team)
    for q in range(begin, end):
        _augment(plan, turns, q, desk.mass, desk.jacobian, rho, desk.diagonal, desk.lower, size_m, size_n)
    _wait(team)
    for q in range(begin, end):
        _add_copies(plan, q, desk.diagonal)
    _wait(team)
    blocks = desk.diagonal.reshape((len(desk.diagonal), n, n))
    if not _columns_alone(plan):
        return _factorise_together(team, plan, blocks, desk.lower, squares, panels, n)
    ok = _factorise_symmetric(plan, blocks, desk.lower, desk.squares, desk.panels, size_n)  # by one, there is one part
    _copy(desk.squares, squares)
    _copy(desk.panels, panels)
    return ok


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _augmented_pass(panels, line, end, turns, part, jacobian, offset, mu, compliance, d, rho, p, v, new, out, size_m, size_n):
    """new = P_K(p - S (w + mu |w_t| n)), S^-1 = R^-1 + C, out += H^T (2 new - p), for the contacts of a part.

    There is more to calculate than to fetch, so entries ``line`` to ``end`` of the panels, for which the next part would wait, are fetched
    on the way. Returns the squared scaled change of p.
    """
    m, n, index = len(size_m), len(size_n), turns.place
    change, contacts = 0.0, max(turns.start[part + 1] - turns.start[part], 1)
    share = (end - line + contacts - 1) // contacts
    for c in range(turns.start[part], turns.start[part + 1]):
        for entry in range(line, min(line + share, end), 16):
            _prefetch(panels, entry)
        line += share
        a, b, r = index[c, 0], index[c, 1], rho[c]
        un, u1, u2 = offset[c, 0], offset[c, 1], 0.0
        pn, p1, p2 = p[c, 0], p[c, 1], 0.0
        if m == 3:
            u2, p2 = offset[c, 2], p[c, 2]
        for k in range(n):
            x, y = v[a, k], v[b, k]
            un += jacobian[c, 0, 0, k] * x + jacobian[c, 1, 0, k] * y
            u1 += jacobian[c, 0, 1, k] * x + jacobian[c, 1, 1, k] * y
            if m == 3:
                u2 += jacobian[c, 0, 2, k] * x + jacobian[c, 1, 2, k] * y
        if len(compliance):
            un += compliance[c, 0] * pn
            u1 += compliance[c, 1] * p1
            u2 += compliance[c, m - 1] * p2
            s, r = r / (1.0 + r * max(compliance[c, 1], compliance[c, m - 1])), r / (1.0 + r * compliance[c, 0])
            xn, x1, x2 = _project_stretched(pn - r * (un + mu[c] * _length(u1, u2)), p1 - s * u1, p2 - s * u2, mu[c], r / s)
        else:
            xn, x1, x2 = _project(pn - r * (un + mu[c] * _length(u1, u2)), p1 - r * u1, p2 - r * u2, mu[c])
        new[c, 0], new[c, 1] = xn, x1
        if m == 3:
            new[c, 2] = x2
        change += d[c] * ((xn - pn) * (xn - pn) + (x1 - p1) * (x1 - p1) + (x2 - p2) * (x2 - p2))
        tn, t1, t2 = 2.0 * xn - pn, 2.0 * x1 - p1, 2.0 * x2 - p2
        a, b = turns.landing[c, 0], turns.landing[c, 1]
        for k in range(n):
            if m == 3:
                out[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1 + jacobian[c, 0, 2, k] * t2
                out[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1 + jacobian[c, 1, 2, k] * t2
            else:
                out[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1
                out[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1
    return change


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _carry_some(jacobian, turns, part, rho, last, p, step, out, push, size_m, size_n):
    """out = 2 p - last - R H step, the impulses whose velocities an iteration of ADMM has found, and push += H^T out.

    For the contacts of a part; step (bodies + 1, n) or more is what the iteration added to the velocities.
    """
    m, n = len(size_m), len(size_n)
    for c in range(turns.start[part], turns.start[part + 1]):
        a, b = turns.place[c, 0], turns.place[c, 1]
        to, other = turns.landing[c, 0], turns.landing[c, 1]
        for i in range(m):
            gain = 0.0
            for k in range(n):
                gain += jacobian[c, 0, i, k] * step[a, k] + jacobian[c, 1, i, k] * step[b, k]
            x = 2.0 * p[c, i] - last[c, i] - rho[c] * gain
            out[c, i] = x
            for k in range(n):
                push[to, k] += jacobian[c, 0, i, k] * x
                push[other, k] += jacobian[c, 1, i, k] * x


@njit(cache=True, nogil=True, error_model="numpy")
def _panels_of(plan, q, n):
    """First entry and end of the panels of part q, one of several: they are stored from its last run to its first."""
    s = plan.part[q]
    end = plan.panel[s] + (plan.first[s + 1] - plan.first[s]) * (plan.start[s + 1] - plan.start[s])
    return n * n * plan.panel[plan.part[q + 1] - 1], n * n * end


@njit(cache=True, nogil=True, error_model="numpy")
def _rise(plan, turns, q, coming, desk, rho, panels, p, new, size_m, size_n):
    """The contacts of part q, and L^-1 of what they ask for; ``coming`` is the part that comes down next, or -1.

    Returns the squared scaled change of p.
    """
    first, last = _nodes(plan, q)
    line, end = _panels_of(plan, coming, len(size_n)) if coming >= 0 else (0, 0)
    push, x = desk.push, desk.x
    _some_momentum(desk.mass, desk.free, desk.v, first, last, push, size_n)
    _clear_copies(plan, q, push)
    _add_copies(plan, q, push)
    change = _augmented_pass(
        panels, line, end, turns, q, desk.jacobian, desk.offset, desk.mu, desk.compliance, desk.d, rho, p, desk.v, new, push, size_m, size_n
    )
    _copy(push[first:last], x[first:last])
    _clear_copies(plan, q, x)
    _add_copies(plan, q, x)
    _go_up(plan, plan.part[q], plan.part[q + 1], plan.target, panels, x, size_n)
    return change


@njit(cache=True, nogil=True, error_model="numpy")
def _descend(plan, q, desk, squares, panels, size_n):
    """The velocities of the bodies of part q change by L^-T D^-1 of what :func:`_rise` left."""
    first, last = _nodes(plan, q)
    _come_down(plan, plan.part[q], plan.part[q + 1], squares, panels, desk.x, size_n)
    size = (last - first) * len(size_n)
    v, x = desk.v[first:last].reshape(size), desk.x[first:last].reshape(size)
    for i in range(size):
        v[i] += x[i]


@njit(cache=True, nogil=True, error_model="numpy")
def admm_bodies(
    team, inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, turns, desk, squares, panels, rho, p_out, v_out, k,
    fresh, moving, rate, tolerance, limit, size_m, size_n,
):  # fmt: skip
    """ADMM over a FrictionProblem, see solvers/admm.py, by a team. p_out and v_out hold the start and then the best answer found.

    squares, panels and rho (in the order of the parts) hold a factorisation of M + H^T R H, used as it is unless ``fresh`` is set. It is in
    single precision: what it is asked for are corrections, which become small, of velocities and impulses in double precision. The
    velocities to start from are those of the impulses; if ``moving`` is set, those of v_out where the impulses fit worse than none would.
    ``rate`` is the error over the change of p in the last iteration, as measured last, or 1.

    Returns iterations, natural map error, k at the end, the number of factorisations and the rate.
    """
    count, contacts, top = len(order), len(mu), len(plan.level) - 2
    b0, b1 = _share(team, 0, count)
    c0, c1 = _share(team, 0, contacts)
    q0, q1 = _share(team, plan.level[0], plan.level[1])
    begin, end = _all_parts(team, plan)
    patience = PATIENCE if rate != 1.0 else PATIENCE // 2
    problem = (desk.jacobian, turns.place, desk.offset, desk.mu, desk.compliance)
    v, trial, p, new, best, d, sums = desk.v, desk.trial, desk.even, desk.odd, desk.best, desk.d, desk.sums
    _put_in_order(inverse_mass, v_free, order, b0, b1, desk.inverse, desk.mass, desk.free, size_n)
    _copy(desk.free[b0:b1], v[b0:b1])
    v[count] = 0.0
    trial[count] = 0.0
    desk.x[count] = 0.0
    _wait(team)
    for q in range(begin, end):  # all of a part while it is in the cache
        first, last = turns.start[q], turns.start[q + 1]
        _sort_contacts(turns, jacobian, offset, mu, compliance, p_out, first, last, desk, size_m, size_n)
        _copy(p[first:last], best[first:last])
        _measure_scales(desk.inverse, desk.jacobian, turns.place, desk.compliance, first, last, d, size_m, size_n)
        _some_rows(desk.jacobian, turns.place, desk.offset, v, first, last, desk.carried, size_m, size_n)
        _clear_push(plan, q, desk.push)
        _push_some(desk.jacobian, turns, q, p, desk.push, size_m, size_n)
    _pushed_together(team, plan, desk.inverse, desk.free, desk.push, v, size_n)
    size = _size_of(desk.carried, d)
    error = _map_norm_together(team, plan, turns, *problem, d, p, v, sums[2], size_m, size_n) / size
    _copy(v[b0:b1], desk.best_v[b0:b1])
    if moving and error > 1.0:  # the impulses fit worse than none would
        for b in range(b0, b1):
            for i in range(len(size_n)):
                v[b, i] = v_out[order[b], i]
        _wait(team)
    smallest = before = error
    iterations, checked, switched, factorisations, ahead = 0, 0, 0, 0, False
    while iterations < limit and smallest > tolerance:
        if fresh:
            factorisations += 1
            if not _prepare_admm(team, plan, turns, k, desk, squares, panels, rho, size_m, size_n):
                k = 0.1 * k  # a matrix closer to that of the masses, which is definite
                if k < SOFTEST:
                    break
                continue
            fresh = False
        changes = sums[iterations % 2]
        if not ahead:
            for q in range(q0, q1):
                changes[q] = _rise(plan, turns, q, -1, desk, rho, panels, p, new, size_m, size_n)
            _wait(team)
        for level in range(1, top + 1):
            first, last = _share(team, plan.level[level], plan.level[level + 1])
            for q in range(first, last):
                changes[q] = _rise(plan, turns, q, -1, desk, rho, panels, p, new, size_m, size_n)
            _wait(team)
        change = np.sqrt(changes.sum()) / size
        iterations += 1
        p, new = new, p
        # the change of p tells when to look at the error itself
        ahead = iterations - checked < 2 or (rate * change > tolerance and iterations - checked < patience)
        ahead = ahead and iterations < limit
        for level in range(top, 0, -1):
            first, last = _share(team, plan.level[level], plan.level[level + 1])
            for q in range(first, last):
                _descend(plan, q, desk, squares, panels, size_n)
            _wait(team)
        for q in range(q0, q1):
            _descend(plan, q, desk, squares, panels, size_n)
            if ahead:  # while the factors are in the cache
                coming = q + 1 if q + 1 < q1 else -1
                sums[iterations % 2, q] = _rise(plan, turns, q, coming, desk, rho, panels, p, new, size_m, size_n)
        _wait(team)
        if ahead:
            continue
        for q in range(begin, end):
            _clear_push(plan, q, desk.push)
            _carry_some(desk.jacobian, turns, q, rho, new, p, desk.x, desk.carried, desk.push, size_m, size_n)
        _pushed_together(team, plan, desk.inverse, desk.free, desk.push, trial, size_n)
        error = _map_norm_together(team, plan, turns, *problem, d, desk.carried, trial, sums[2], size_m, size_n) / size
        checked = iterations
        rate = error / change if change > 0.0 else 1.0
        if error < smallest:
            smallest = error
            _copy(desk.carried[c0:c1], best[c0:c1])
            _copy(trial[b0:b1], desk.best_v[b0:b1])
        if not error < np.inf:
            _copy(best[c0:c1], p[c0:c1])
            _copy(desk.best_v[b0:b1], v[b0:b1])
        _wait(team)
        ends = iterations == limit and smallest > tolerance  # the next step begins with a k that suits this one better
        if ends or iterations - switched >= 40 or (iterations - switched >= 20 and error > before):
            if ends or not error < 0.1 * before:
                share = _map_norm_together(team, plan, turns, *problem, d, p, v, sums[2], size_m, size_n) / size / error
                if share > ALL and not ends:
                    k, fresh = min(5.0 * k, 1e6), True
                elif share < BALANCE:
                    k, fresh = max(k * max(np.sqrt(share / BALANCE), 0.01), 1.0), True
            switched, before = iterations, error
    for c in range(c0, c1):
        old = turns.contact[c]
        for i in range(len(size_m)):
            p_out[old, i] = best[c, i]
    for b in range(b0, b1):
        for i in range(len(size_n)):
            v_out[order[b], i] = desk.best_v[b, i]
    return iterations, smallest, k, factorisations, rate


# --- semismooth Newton over bodies ---------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def _tangent(pn, p1, p2, un, u1, u2, mu, d, stiffness, block, target, c, size_m):
    """Linearised law of contact c, p+ = target[c] - block[c] (u+ - u), for contact stiffness ``stiffness`` / d; see solvers/newton.py."""
    m = len(size_m)
    spatial = m == 3
    for i in range(m):
        target[c, i] = 0.0
        for j in range(m):
            block[c, i, j] = 0.0
    xn, x1, x2 = pn - un / d, p1 - u1 / d, p2 - u2 / d
    if xn <= 0.0:
        return
    kappa = stiffness / d
    length = _length(x1, x2)
    target[c, 0] = pn - kappa * un
    block[c, 0, 0] = kappa
    if length <= mu * xn:
        target[c, 1], block[c, 1, 1] = p1 - kappa * u1, kappa
        if spatial:
            target[c, 2], block[c, 2, 2] = p2 - kappa * u2, kappa
        return
    e1, e2 = x1 / length, x2 / length
    target[c, 1], block[c, 1, 0] = mu * e1 * target[c, 0], mu * e1 * kappa
    if spatial:  # across the slip the direction of friction turns with the velocity
        share = mu * xn / length
        beta = min(share / (d * max(1.0 - share, 1e-12)), kappa)
        across = u2 * e1 - u1 * e2
        target[c, 2], block[c, 2, 0] = mu * e2 * target[c, 0], mu * e2 * kappa
        target[c, 1] += beta * across * e2
        target[c, 2] -= beta * across * e1
        block[c, 1, 1], block[c, 1, 2], block[c, 2, 1], block[c, 2, 2] = beta * e2 * e2, -beta * e1 * e2, -beta * e1 * e2, beta * e1 * e1


@njit(cache=True, nogil=True, error_model="numpy")
def _in_series(block, compliance, share, softer, work, size_m):
    """Put the contact's own spring in series with a linearised law p+ - p = r - B (w+ - w), where w+ - w = u+ - u + C (p+ - p).

    share = (I + B C)^-1 leaves p+ - p = share r - softer (u+ - u), softer = share B. False if it is singular.
    """
    m = len(size_m)
    for i in range(m):
        for j in range(m):
            softer[i, j] = block[i, j] * compliance[j] + (1.0 if i == j else 0.0)
    regular = _invert(softer, share, work, size_m)
    _times(share, block, False, softer, size_m)
    return regular


@njit(cache=True, nogil=True, error_model="numpy")
def _take_share(share, target, p0, p1, p2, size_m):
    """target <- p + share (target - p)."""
    m = len(size_m)
    r0, r1, r2 = target[0] - p0, target[1] - p1, target[m - 1] - p2 if m == 3 else 0.0
    for i in range(m):
        target[i] = (p0, p1, p2)[i] + share[i, 0] * r0 + share[i, 1] * r1 + share[i, m - 1] * r2


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n):
    """Diagonal, lower and transposed upper blocks of M + H^T B H, B one (m, m) block per contact."""
    m, n, bodies = len(size_m), len(size_n), len(mass)
    _copy(mass, diagonal)
    lower[:] = 0.0
    upper[:] = 0.0
    turned = np.empty((2, m, n))
    for c in range(len(index)):
        a, b = index[c, 0], index[c, 1]
        for side in range(2):
            for i in range(m):
                for q in range(n):
                    total = 0.0
                    for k in range(m):
                        total += blocks[c, i, k] * jacobian[c, side, k, q]
                    turned[side, i, q] = total
            body = index[c, side]
            if body < bodies:
                for p in range(n):
                    for q in range(n):
                        total = 0.0
                        for i in range(m):
                            total += jacobian[c, side, i, p] * turned[side, i, q]
                        diagonal[body, p, q] += total
        if a == b < bodies:
            for p in range(n):
                for q in range(n):
                    for i in range(m):
                        diagonal[a, p, q] += jacobian[c, 0, i, p] * turned[1, i, q] + jacobian[c, 1, i, p] * turned[0, i, q]
        if spot[c] >= 0:
            low = 1 if a > b else 0
            high = 1 - low
            for p in range(n):
                for q in range(n):
                    one, other = 0.0, 0.0
                    for i in range(m):
                        one += jacobian[c, high, i, p] * turned[low, i, q]
                        other += jacobian[c, low, i, q] * turned[high, i, p]
                    lower[spot[c], p, q] += one
                    upper[spot[c], p, q] += other


@njit(cache=True, nogil=True, error_model="numpy")
def _damp(new: float, error: float, first: bool, stiffness: float) -> tuple[bool, float]:
    """Whether a Newton step that changed the error so is accepted, and the stiffness of the next one."""
    if not (new < 1.5 * error or (first and new < np.inf)):
        return False, 0.125 * stiffness
    if new < 0.7 * error:
        return True, min(4.0 * stiffness, 1e8)
    return True, 2.0 * stiffness if new <= error else 0.5 * stiffness


@njit(entry=False, cache=True, nogil=True, error_model="numpy")
def newton_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, stiffness, tolerance, limit,
    size_m, size_n,
):  # fmt: skip
    """Semismooth Newton over a FrictionProblem, see solvers/newton.py. p holds the start and then the best answer found.

    Returns iterations, natural map error, the error at the start, and the stiffness at the end.
    """
    count, m, n, contacts = len(order), len(size_m), len(size_n), len(mu)
    inverse, mass, free = _in_order(inverse_mass, v_free, order, size_n)
    d = _scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, best_v = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.empty((count + 1, n))
    w, target, blocks = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m, m))
    _copy(free, v)
    _rows(jacobian, index, offset, v, w, size_m, size_n)
    size = _size_of(w, d)
    _velocity_of(inverse, free, jacobian, index, p, out, v, size_m, size_n)
    best = p.copy()
    _copy(v, best_v)
    smallest = error = begin = _map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
    hold, hold_v = p.copy(), v.copy()
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    squares, panels, others = _room(plan, size_n)
    share, softer, work = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    iterations, refused = 0, 0
    while iterations < limit and smallest > tolerance and refused < 8:
        _rows(jacobian, index, offset, v, w, size_m, size_n)
        for c in range(contacts):
            if len(compliance):
                for i in range(m):
                    w[c, i] += compliance[c, i] * p[c, i]
            p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
            _tangent(p[c, 0], p[c, 1], p2, w[c, 0], w[c, 1], w2, mu[c], d[c], stiffness, blocks, target, c, size_m)
            if len(compliance):
                _in_series(blocks[c], compliance[c], share, softer, work, size_m)
                _take_share(share, target[c], p[c, 0], p[c, 1], p2, size_m)
                _copy(softer, blocks[c])
        _augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n)
        iterations += 1
        new = np.inf
        if _factorise(plan, diagonal, lower, upper, squares, panels, others, size_n):
            _missing_momentum(mass, free, v, out, size_n)
            _add_push(jacobian, index, target, out, size_m, size_n)
            _solve_factorised(plan, squares, panels, others, out, size_n)
            out[count] = 0.0
            for c in range(contacts):
                a, b = index[c, 0], index[c, 1]
                for i in range(m):
                    p[c, i] = target[c, i]
                for i in range(m):
                    change = 0.0
                    for k in range(n):
                        change += jacobian[c, 0, i, k] * out[a, k] + jacobian[c, 1, i, k] * out[b, k]
                    for k in range(m):
                        p[c, k] -= blocks[c, k, i] * change
            _velocity_of(inverse, free, jacobian, index, p, out, v, size_m, size_n)
            new = _map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
        accepted, stiffness = _damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            _copy(p, hold)
            _copy(v, hold_v)
        else:
            refused += 1
            _copy(hold, p)
            _copy(hold_v, v)
        if error < smallest:
            smallest = error
            _copy(p, best)
            _copy(v, best_v)
    _copy(best, p)
    _put_back(best_v, order, v_out)
    return iterations, smallest, begin, stiffness


# --- ADMM and Newton for local problems ------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def _product(data, indices, indptr, p, out, size_m):
    """out = W p."""
    m = len(size_m)
    for c in range(len(p)):
        for i in range(m):
            total = 0.0
            for k in range(indptr[c], indptr[c + 1]):
                for l in range(m):  # noqa: E741
                    total += data[k, i, l] * p[indices[k], l]
            out[c, i] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _local_norm(data, indices, indptr, q, mu, d, p, u, size_m):
    """u = W p + q, and the norm of the natural map residual."""
    m, total = len(size_m), 0.0
    _product(data, indices, indptr, p, u, size_m)
    for c in range(len(p)):
        for i in range(m):
            u[c, i] += q[c, i]
        total += _natural_map2(p[c, 0], p[c, 1], p[c, 2] if m == 3 else 0.0, u[c, 0], u[c, 1], u[c, 2] if m == 3 else 0.0, mu[c], d[c])
    return np.sqrt(total)


@njit(cache=True, nogil=True, error_model="numpy")
def _block_at(column: np.ndarray, row: np.ndarray, low: int, high: int) -> int:
    """Index of block (high, low) below the diagonal."""
    return column[low] + np.searchsorted(row[column[low] : column[low + 1]], high)


@njit(cache=True, nogil=True, error_model="numpy")
def _place_blocks(data, indices, indptr, scale, place, plan, symmetric, diagonal, lower, upper, size_m):
    """Diagonal, lower and transposed upper blocks of S W, S one block per contact; or the symmetric part of W into lower alone."""
    m = len(size_m)
    diagonal[:] = 0.0
    lower[:] = 0.0
    upper[:] = 0.0
    block = np.empty((m, m))
    for c in range(len(place)):
        for k in range(indptr[c], indptr[c + 1]):
            i, j = place[c], place[indices[k]]
            _times(scale[c], data[k], False, block, size_m)
            at = 0 if i == j else _block_at(plan.column, plan.row, min(i, j), max(i, j))
            for r in range(m):
                for s in range(m):
                    if i == j:
                        diagonal[i, r, s] += 0.5 * (block[r, s] + block[s, r]) if symmetric else block[r, s]
                    elif symmetric:
                        lower[at, r, s] += 0.5 * (block[r, s] if i > j else block[s, r])
                    elif i > j:
                        lower[at, r, s] += block[r, s]
                    else:
                        upper[at, s, r] += block[r, s]


@njit(cache=True, nogil=True, error_model="numpy")
def _identities(count, size_m):
    """Unit blocks (count, m, m)."""
    out = np.zeros((count, len(size_m), len(size_m)))
    for c in range(count):
        for i in range(len(size_m)):
            out[c, i, i] = 1.0
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def admm_local(data, indices, indptr, q, mu, d, order, place, plan, p, k, tolerance, limit, size_m):
    """ADMM over a LocalProblem: pi stands for the velocities, u = W pi + q, and (W + R^-1) (pi+ - pi) = R^-1 (2 p+ - p - pi).

    p holds the start and then the best answer. Returns iterations and natural map error.
    """
    count, m = len(mu), len(size_m)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(plan.row), m, m))
    squares, panels, _ = _room(plan, size_m)
    scale = _identities(count, size_m)
    size = _size_of(q, d)
    pi, u, right, best = p.copy(), np.empty(p.shape), np.empty(p.shape), p.copy()
    smallest = before = _local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    iterations, checked, switched, fresh = 0, 0, 0, True
    while iterations < limit and smallest > tolerance:
        if fresh:
            _place_blocks(data, indices, indptr, scale, place, plan, True, diagonal, lower, lower, size_m)
            for i in range(count):
                for r in range(m):
                    diagonal[i, r, r] += d[order[i]] / k
            if not _factorise_symmetric(plan, diagonal, lower, squares, panels, size_m):
                k = 0.1 * k
                if k < SOFTEST:
                    break
                continue
            fresh = False
        for c in range(count):
            rho = k / d[c]
            p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
            shift = mu[c] * _length(u[c, 1], u2)
            xn, x1, x2 = _project(p[c, 0] - rho * (u[c, 0] + shift), p[c, 1] - rho * u[c, 1], p2 - rho * u2, mu[c])
            right[place[c], 0] = (2.0 * xn - p[c, 0] - pi[c, 0]) / rho
            right[place[c], 1] = (2.0 * x1 - p[c, 1] - pi[c, 1]) / rho
            p[c, 0], p[c, 1] = xn, x1
            if m == 3:
                right[place[c], 2] = (2.0 * x2 - p2 - pi[c, 2]) / rho
                p[c, 2] = x2
        _solve_symmetric(plan, squares, panels, right, size_m)
        for c in range(count):
            for i in range(m):
                pi[c, i] += right[place[c], i]
        iterations += 1
        if iterations - checked >= 5 or iterations == limit:
            checked = iterations
            error = _local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
            if error < smallest:
                smallest = error
                _copy(p, best)
            if not error < np.inf:
                _copy(best, p)
                _copy(best, pi)
            if iterations - switched >= 40:
                if not error < 0.1 * before:
                    _product(data, indices, indptr, pi, u, size_m)
                    total = 0.0
                    for c in range(count):
                        for i in range(m):
                            u[c, i] += q[c, i]
                        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
                        total += _natural_map2(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c])
                    own = np.sqrt(total) / size
                    k = min(5.0 * k, 1e6) if own > 0.02 * error else max(0.2 * k, 1.0)
                    fresh = True
                switched, before = iterations, error
        _product(data, indices, indptr, pi, u, size_m)
        for c in range(count):
            for i in range(m):
                u[c, i] += q[c, i]
    _copy(best, p)
    return iterations, smallest


@njit(cache=True, nogil=True, error_model="numpy")
def newton_local(data, indices, indptr, own, q, mu, d, place, plan, p, stiffness, tolerance, limit, size_m):
    """Semismooth Newton over a LocalProblem: (I + B W) (p+ - p) = g - p, its rows scaled to unit diagonal blocks.

    own (C, m, m) are the blocks W_cc. p holds the start and then the best answer. Returns iterations, error, error at the start.
    """
    count, m = len(mu), len(size_m)
    diagonal, lower, upper = np.empty((count, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    squares, panels, others = _room(plan, size_m)
    scale, right, unit = np.empty((count, m, m)), np.empty(p.shape), np.empty((count, m, m))
    target, block, work, inverse = np.zeros((1, m)), np.zeros((1, m, m)), np.empty((m, m)), np.empty((m, m))
    small = np.empty((m, m))
    size = _size_of(q, d)
    u, best, hold = np.empty(p.shape), p.copy(), p.copy()
    smallest = error = begin = _local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    iterations, refused = 0, 0
    while iterations < limit and smallest > tolerance and refused < 8:
        regular = True
        for c in range(count):
            p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
            _tangent(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c], stiffness, block, target, 0, size_m)
            for i in range(m):
                for j in range(m):
                    small[i, j] = block[0, i, j]
            _times(small, own[c], False, work, size_m)
            for i in range(m):
                work[i, i] += 1.0
            regular = regular and _invert(work, inverse, diagonal[0], size_m)
            _times(inverse, small, False, scale[c], size_m)
            for i in range(m):
                total = 0.0
                for j in range(m):
                    total += inverse[i, j] * (target[0, j] - p[c, j])
                    unit[place[c], i, j] = inverse[i, j]
                right[place[c], i] = total
        _place_blocks(data, indices, indptr, scale, place, plan, False, diagonal, lower, upper, size_m)
        for i in range(count):
            for r in range(m):
                for s in range(m):
                    diagonal[i, r, s] += unit[i, r, s]
        iterations += 1
        new = np.inf
        if regular and _factorise(plan, diagonal, lower, upper, squares, panels, others, size_m):
            _solve_factorised(plan, squares, panels, others, right, size_m)
            for c in range(count):
                for i in range(m):
                    p[c, i] += right[place[c], i]
            new = _local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
        accepted, stiffness = _damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            _copy(p, hold)
        else:
            refused += 1
            _copy(hold, p)
            _local_norm(data, indices, indptr, q, mu, d, p, u, size_m)
        if error < smallest:
            smallest = error
            _copy(p, best)
    _copy(best, p)
    return iterations, smallest, begin


@njit(cache=True, nogil=True, error_model="numpy")
def is_definite(data, indices, indptr, shift, place, plan, size_m):
    """Whether the symmetric part of W, with shift added to its diagonal, is positive definite: all squares of D are (Sylvester)."""
    count, m = len(place), len(size_m)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(plan.row), m, m))
    squares, panels, _ = _room(plan, size_m)
    _place_blocks(data, indices, indptr, _identities(count, size_m), place, plan, SYMMETRIC, diagonal, lower, lower, size_m)
    for i in range(count):
        for r in range(m):
            diagonal[i, r, r] += shift
    if not _factorise_symmetric(plan, diagonal, lower, squares, panels, size_m):
        return False
    for s in range(len(plan.first) - 1):
        width = m * (plan.first[s + 1] - plan.first[s])
        left = _view(squares, plan.square[s], width, width, m).copy()
        for k in range(width):
            if not left[k, k] > 0.0:
                return False
            for i in range(k + 1, width):
                factor = left[i, k] / left[k, k]
                for j in range(k + 1, width):
                    left[i, j] -= factor * left[k, j]
    return True


# --- interior point over bodies -------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _cone_det(x0: float, x1: float, x2: float) -> float:
    """x_0^2 - |x_t|^2, positive inside the second-order cone; written so that it does not cancel."""
    t = _length(x1, x2)
    return (x0 - t) * (x0 + t)


@njit(cache=True, nogil=True, error_model="numpy")
def _way_out(x0: float, x1: float, x2: float, d0: float, d1: float, d2: float) -> float:
    """Largest step from x inside the second-order cone along d that stays inside, at most 1e10."""
    best = -x0 / d0 if d0 < 0.0 else 1e10
    a, b, c = d0 * d0 - d1 * d1 - d2 * d2, x0 * d0 - x1 * d1 - x2 * d2, max(_cone_det(x0, x1, x2), 0.0)
    root = b * b - a * c  # of a t^2 + 2 b t + c = 0
    if root < 0.0:
        return best
    far = -(b + np.sqrt(root)) if b >= 0.0 else -(b - np.sqrt(root))
    if far != 0.0 and c / far > 0.0:
        best = min(best, c / far)
    if a != 0.0 and far / a > 0.0:
        best = min(best, far / a)
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def _determinant_sign(plan, squares, size_n):
    """Sign of the determinant of a factorised matrix, from the inverses of its diagonal squares."""
    sign = 1.0
    for s in range(len(plan.first) - 1):
        width = len(size_n) * (plan.first[s + 1] - plan.first[s])
        work = _view(squares, plan.square[s], width, width, len(size_n)).copy()
        for k in range(width):
            best = k
            for i in range(k + 1, width):
                if abs(work[i, k]) > abs(work[best, k]):
                    best = i
            if best != k:
                sign = -sign
                for j in range(k, width):
                    work[k, j], work[best, j] = work[best, j], work[k, j]
            if work[k, k] < 0.0:
                sign = -sign
            for i in range(k + 1, width):
                factor = work[i, k] / work[k, k]
                for j in range(k + 1, width):
                    work[i, j] -= factor * work[k, j]
    return sign


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _complementarity(w, p, gamma, mu, m, out):
    """The products of a contact that vanish in a solution: w_n p_n and (gamma, w_t) o (mu p_n, p_t)."""
    out[0] = w[0] * p[0]
    out[1] = gamma * mu * p[0]
    for i in range(1, m):
        out[1] += w[i] * p[i]
        out[1 + i] = gamma * p[i] + mu * p[0] * w[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _move_inside(p, u, mu, d, shift, w, inner, m):
    """Centred w and impulses with products shift^2 / d for x = d p - u of a contact; returns its gamma.

    On the path w_n = (root - x_n) / 2 and d p_n = (root + x_n) / 2, root = sqrt(x_n^2 + 4 shift^2); tangentially w_t = -x_t gamma / (gamma
    + beta), d p_t = x_t beta / (gamma + beta), beta = mu d p_n, and gamma solves one cubic equation.
    """
    xn = d * p[0] - u[0]
    root = np.sqrt(xn * xn + 4.0 * shift * shift)
    far = 0.5 * (root + abs(xn))
    near = shift * shift / far  # without cancellation
    w[0], inner[0] = (near, far / d) if xn > 0.0 else (far, near / d)
    bound, r2 = mu * inner[0] * d, 0.0
    for i in range(1, m):
        r2 += (d * p[i] - u[i]) ** 2
    level = shift * shift / bound
    gamma = np.sqrt(r2) + level
    for _ in range(60):
        total = gamma + bound
        move = (gamma - r2 * gamma / (total * total) - level) / (1.0 - r2 * (bound - gamma) / (total * total * total))
        gamma = max(gamma - move, 0.5 * gamma)
        if abs(move) <= 1e-10 * gamma:
            break
    for i in range(1, m):
        x = d * p[i] - u[i]
        inner[i], w[i] = x * bound / (gamma + bound) / d, -x * gamma / (gamma + bound)
    return gamma


@njit(cache=True, nogil=True, error_model="numpy")
def _linearise_products(w, p, gamma, mu, soft, inverse, gain, work, size_m, size_k):
    """Linearised products of a contact whose w is that of the velocities, softened by its compliance and by the damping.

    (dp, dgamma) = inverse r - gain (du + miss) changes them by r. work (3, k, k). False if they cannot be solved for that.
    """
    m, k = len(size_m), len(size_k)
    change, by_w = work[0], work[1]
    change[:], by_w[:] = 0.0, 0.0
    change[0, 0], by_w[0, 0] = w[0], p[0]
    change[1, 0], change[1, m] = gamma * mu, mu * p[0]
    for i in range(1, m):
        change[1, i], by_w[1, i] = w[i], p[i]
        change[1 + i, i], change[1 + i, m], change[1 + i, 0], by_w[1 + i, i] = gamma, p[i], mu * w[i], mu * p[0]
    for i in range(k):
        for j in range(m):
            change[i, j] += by_w[i, j] * soft[j]
    regular = _invert(change, inverse, work[2], size_k)
    for i in range(k):
        for j in range(m):
            total = 0.0
            for q in range(k):
                total += inverse[i, q] * by_w[q, j]
            gain[i, j] = total
    return regular


@njit(cache=True, nogil=True, error_model="numpy")
def _interior_direction(
    momentum, jacobian, index, wanted, inverse, gain, miss, soft, plan, factors, out, dw, dp, dgamma, size_m, size_n, size_k
):
    """The step that changes the products as wanted and takes all other residuals away: out (of v), dw, dp, dgamma.

    momentum is H^T p - M (v - v_free), miss = H v + b + C p - w, factors those of M + H^T B H with B the first rows of gain.
    """
    m, n, k = len(size_m), len(size_n), len(size_k)
    for c in range(len(index)):
        for i in range(k):
            total = 0.0
            for j in range(k):
                total += inverse[c, i, j] * wanted[c, j]
            for j in range(m):
                total -= gain[c, i, j] * miss[c, j]
            if i < m:
                dp[c, i] = total
            else:
                dgamma[c] = total
    _copy(momentum, out)
    _add_push(jacobian, index, dp, out, size_m, size_n)
    _solve_factorised(plan, factors[0], factors[1], factors[2], out, size_n)
    out[-1] = 0.0
    for c in range(len(index)):
        a, b, h = index[c, 0], index[c, 1], jacobian[c]
        for j in range(m):
            change = 0.0
            for q in range(n):
                change += h[0, j, q] * out[a, q] + h[1, j, q] * out[b, q]
            dw[c, j] = change + miss[c, j]
            for i in range(m):
                dp[c, i] -= gain[c, i, j] * change
            dgamma[c] -= gain[c, m, j] * change
        for i in range(m):
            dw[c, i] += soft[c, i] * dp[c, i]


@njit(cache=True, nogil=True, error_model="numpy")
def _largest(x):
    """Largest size of an entry."""
    most = 0.0
    for c in range(len(x)):
        for i in range(x.shape[1]):
            most = max(most, abs(x[c, i]))
    return most


@njit(cache=True, nogil=True, error_model="numpy")
def _longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m):
    """Largest step that keeps every contact inside its cones."""
    m, longest = len(size_m), 1e10
    for c in range(len(mu)):
        if dw[c, 0] < 0.0:
            longest = min(longest, -w[c, 0] / dw[c, 0])
        w2, p2, dw2, dp2 = (w[c, 2], p[c, 2], dw[c, 2], dp[c, 2]) if m == 3 else (0.0, 0.0, 0.0, 0.0)
        longest = min(longest, _way_out(gamma[c], w[c, 1], w2, dgamma[c], dw[c, 1], dw2))
        longest = min(longest, _way_out(mu[c] * p[c, 0], p[c, 1], p2, mu[c] * dp[c, 0], dp[c, 1], dp2))
    return longest


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(dw, dp, dgamma, mu, product, target, second, wanted, size_m, size_k):
    """The changes of the products that lead to ``target``, with the second order of the last direction if ``second`` is set."""
    m, k = len(size_m), len(size_k)
    for c in range(len(mu)):
        if second:
            _complementarity(dw[c], dp[c], dgamma[c], mu[c], m, wanted[c])
        for i in range(k):
            wanted[c, i] = (target if i < 2 else 0.0) - product[c, i] - (wanted[c, i] if second else 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _centring(dw, dp, dgamma, mu, product, gap, undone, longest, step, room, size_m):
    """Share of the gap to aim at, from what the predictor would leave of it, and more after a short step; ``room`` (C, k) is used up.

    ``undone`` measures what w misses in the units of the gap: the gap is not to vanish before it.
    """
    contacts, ahead, reach = len(mu), 0.0, min(1.0, longest)
    for c in range(contacts):
        _complementarity(dw[c], dp[c], dgamma[c], mu[c], len(size_m), room[c])
        ahead += 0.5 * (1.0 - reach) * (product[c, 0] + product[c, 1]) / contacts
        ahead += 0.5 * reach * reach * (room[c, 0] + room[c, 1]) / contacts
    left = max(min(1.0, max(ahead / gap, 0.0)) ** 3, min(1.0, 0.3 * undone / gap))
    return max(left, 1e-6 if step > 0.2 else (0.5 if step > 0.05 else 1.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _take_impulse(p, friction, impulse, size_m):
    """impulse = p, without a tangential part where there is no friction."""
    for c in range(len(friction)):
        for i in range(len(size_m)):
            impulse[c, i] = p[c, i] if i == 0 or friction[c] > 0.0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m):
    """Go a share of the direction; ``impulse`` gets p, without friction where there is none."""
    for c in range(len(friction)):
        gamma[c] += step * dgamma[c]
        for i in range(len(size_m)):
            w[c, i] += step * dw[c, i]
            p[c, i] += step * dp[c, i]
    _take_impulse(p, friction, impulse, size_m)


@njit(cache=True, nogil=True, error_model="numpy")
def _stiffness_after(step, stiffness):
    """Long steps can do with stiffer contacts, short ones need softer."""
    if step > 0.5:
        return min(4.0 * stiffness, STIFFEST)
    return max(0.25 * stiffness, 1.0) if step < 0.1 else stiffness


@njit(cache=True, nogil=True, error_model="numpy")
def _begin_inside(
    inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, u, push, w, p, gamma, size_m, size_n
):
    """The start: fill w, p and gamma from inside the cones, at a distance from their walls, v with the velocities of the impulses.

    u (C, m) and push (bodies + 1, n) are room. Returns the size of the problem, the shift, and the natural map error of the impulses.
    """
    _copy(free, v)
    _rows(jacobian, index, offset, v, u, size_m, size_n)
    size, shift = _size_of(u, d), distance * _largest(u)
    _velocity_of(inverse, free, jacobian, index, impulse, push, v, size_m, size_n)
    error = _map_norm(jacobian, index, offset, friction, compliance, d, impulse, v, size_m, size_n) / size
    _rows(jacobian, index, offset, v, u, size_m, size_n)
    for c in range(len(mu)):
        gamma[c] = _move_inside(impulse[c], u[c], mu[c], d[c], shift, w[c], p[c], len(size_m))
    return size, shift, error


@njit(entry=False, cache=True, nogil=True, error_model="numpy")
def interior_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, friction, compliance, order, plan, index, spot, impulse, v_out, distance,
    stiffness, tolerance, limit, size_m, size_n, size_k,
):  # fmt: skip
    """Interior point method over a FrictionProblem, see solvers/interior.py. impulse holds the start and then the best answer found.

    size_k is a tuple of m + 1 zeros. Returns iterations and natural map error.
    """
    count, m, n, k, contacts = len(order), len(size_m), len(size_n), len(size_k), len(friction)
    inverse, mass, free = _in_order(inverse_mass, v_free, order, size_n)
    d = _scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, own_v, momentum = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.zeros((count + 1, n)), np.empty((count + 1, n))
    u, soft = np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    dw, dp, dgamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work = np.empty((contacts, k, k)), np.empty((3, k, k))
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = _room(plan, size_n)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    size, _, smallest = _begin_inside(
        inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, u, out, w, p, gamma, size_m, size_n
    )
    best, best_v = impulse.copy(), v.copy()
    step, iterations, short = 1.0, 0, 0
    while iterations < limit and smallest > tolerance and short < 6:
        iterations += 1
        _rows(jacobian, index, offset, v, u, size_m, size_n)
        gap, undone, regular = 0.0, 0.0, True
        for c in range(contacts):
            for i in range(m):
                own = compliance[c, i] if len(compliance) else 0.0
                soft[c, i] = own + d[c] / stiffness
                u[c, i] += own * p[c, i] - w[c, i]  # what w misses
                undone += abs(u[c, i] * p[c, i]) / contacts
            _complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            gap += 0.5 * (product[c, 0] + product[c, 1]) / contacts
            regular = _linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
        _augment_blocks(mass, jacobian, index, spot, gain, diagonal, lower, upper, size_m, size_n)
        regular = regular and _factorise(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n)
        if not (gap > 0.0 and regular):
            break
        if _determinant_sign(plan, factors[0], size_n) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        _missing_momentum(mass, free, v, momentum, size_n)
        _add_push(jacobian, index, p, momentum, size_m, size_n)
        # predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out
        centring, longest = 0.0, 0.0
        for turn in range(3):
            if turn == 2 and longest >= 0.1:
                break
            _aim(dw, dp, dgamma, mu, product, centring * gap, turn == 1, wanted, size_m, size_k)
            _interior_direction(
                momentum, jacobian, index, wanted, undo, gain, u, soft, plan, factors, out, dw, dp, dgamma, size_m, size_n, size_k
            )
            longest = _longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m)
            if turn == 0:
                centring = _centring(dw, dp, dgamma, mu, product, gap, undone, longest, step, wanted, size_m)
        step = min(1.0, 0.99 * longest)
        _advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m)
        for b in range(count):
            for i in range(n):
                v[b, i] += step * out[b, i]
        short = short + 1 if step < 0.02 else 0
        stiffness = _stiffness_after(step, stiffness)
        _velocity_of(inverse, free, jacobian, index, impulse, out, own_v, size_m, size_n)
        error = _map_norm(jacobian, index, offset, friction, compliance, d, impulse, own_v, size_m, size_n) / size
        if error < smallest:
            smallest = error
            _copy(impulse, best)
            _copy(own_v, best_v)
        if not error < np.inf:
            break
    _copy(best, impulse)
    _put_back(best_v, order, v_out)
    return iterations, smallest


@njit(cache=True, nogil=True, error_model="numpy")
def _way_product(a, b, w, p, gamma, mu, size_m):
    """Inner product of two changes (dw, dp, dgamma), each relative to what it changes, mean over the contacts."""
    m, total = len(size_m), 0.0
    for c in range(len(mu)):
        slide, bound = 1.0 / gamma[c], 1.0 / (mu[c] * p[c, 0])
        total += a[0][c, 0] * b[0][c, 0] / (w[c, 0] * w[c, 0]) + a[1][c, 0] * b[1][c, 0] / (p[c, 0] * p[c, 0])
        total += a[2][c] * b[2][c] * slide * slide
        for i in range(1, m):
            total += a[0][c, i] * b[0][c, i] * slide * slide + a[1][c, i] * b[1][c, i] * bound * bound
    return total / len(mu)


@njit(cache=True, nogil=True, error_model="numpy")
def _combine(x, a, y, b, z, out):
    """out = x + a y + b z, for arrays of any shape."""
    x, y, z, out = x.reshape(x.size), y.reshape(y.size), z.reshape(z.size), out.reshape(out.size)
    for i in range(len(out)):
        out[i] = x[i] + a * y[i] + b * z[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _combine_ways(x, a, y, b, z, out):
    """The same for changes of (w, p, gamma, v)."""
    _combine(x[0], a, y[0], b, z[0], out[0])
    _combine(x[1], a, y[1], b, z[1], out[1])
    _combine(x[2], a, y[2], b, z[2], out[2])
    _combine(x[3], a, y[3], b, z[3], out[3])


@njit(cache=True, nogil=True, error_model="numpy")
def _step_ahead(w, p, gamma, mu, back, tangent, bend, drop, sign, curve, wide, tau, level, way, trial, size_m):
    """way = back + h tangent + h^2 bend with the largest h that stays inside the cones and near the path.

    The change of tau goes along, tau drop + h sign + h^2 curve. Near: no product of a contact is off tau times its level by more than
    ``wide`` times that. trial (k,) is room. Returns the relative change of tau.
    """
    m, h = len(size_m), 2.0 if sign > 0.0 else 0.97
    for _ in range(40):
        _combine_ways(back, h * sign, tangent, h * h, bend, way)
        change = drop + h * sign + h * h * curve
        if change > -0.98 and _longest_step(w, p, gamma, mu, way[0], way[1], way[2], size_m) > 1.02:
            off = 0.0
            for c in range(len(mu)):
                _complementarity(w[c] + way[0][c], p[c] + way[1][c], gamma[c] + way[2][c], mu[c], m, trial)
                off = max(off, _off_path(trial, tau * (1.0 + change) * level[c]))
            if off < wide:
                break
        h *= 0.75
    return change


@njit(cache=True, nogil=True, error_model="numpy")
def _off_path(product, goal):
    """How far the products of a contact are from goal (1, e), relative to goal."""
    across = (product[1] - goal) ** 2
    for i in range(2, len(product)):
        across += product[i] * product[i]
    return max(abs(product[0] - goal), np.sqrt(across)) / goal


@njit(entry=False, cache=True, nogil=True, error_model="numpy")
def path_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, friction, compliance, order, plan, index, spot, impulse, v_out, distance,
    stiffness, wide, tolerance, limit, size_m, size_n, size_k,
):  # fmt: skip
    """The central path followed by its length over a FrictionProblem, see solvers/interior.py. impulse holds the start and then the best.

    size_k is a tuple of m + 1 zeros. Returns iterations and natural map error.
    """
    count, m, n, k, contacts = len(order), len(size_m), len(size_n), len(size_k), len(friction)
    inverse, mass, free = _in_order(inverse_mass, v_free, order, size_n)
    d = _scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, own_v = np.zeros((count + 1, n)), np.zeros((count + 1, n))
    momentum, still = np.empty((count + 1, n)), np.zeros((count + 1, n))
    miss, far, soft = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma, level = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts), np.empty(contacts)
    ways = [(np.zeros((contacts, m)), np.zeros((contacts, m)), np.zeros(contacts), np.zeros((count + 1, n))) for _ in range(4)]
    back, tangent, bend, way = ways[0], ways[1], ways[2], ways[3]
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work, trial = np.empty((contacts, k, k)), np.empty((3, k, k)), np.empty(k)
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = _room(plan, size_n)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    # start: a point on the path at tau = 1, where w is off by far
    size, shift, smallest = _begin_inside(
        inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, miss, momentum, w, p, gamma,
        size_m, size_n,
    )  # fmt: skip
    best, best_v = impulse.copy(), v.copy()
    for c in range(contacts):
        level[c] = shift * shift / d[c]
    _velocity_of(inverse, free, jacobian, index, p, momentum, v, size_m, size_n)
    _rows(jacobian, index, offset, v, far, size_m, size_n)
    for c in range(contacts):
        for i in range(m):
            own = compliance[c, i] if len(compliance) else 0.0
            soft[c, i] = own + d[c] / stiffness
            far[c, i] += own * p[c, i] - w[c, i]
    tau, iterations = 1.0, 0
    while iterations < limit and smallest > tolerance:
        iterations += 1
        _rows(jacobian, index, offset, v, miss, size_m, size_n)
        regular = True
        for c in range(contacts):
            for i in range(m):
                own = compliance[c, i] if len(compliance) else 0.0
                miss[c, i] += own * p[c, i] - w[c, i] - tau * far[c, i]
            _complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            regular = _linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
        _augment_blocks(mass, jacobian, index, spot, gain, diagonal, lower, upper, size_m, size_n)
        if not regular or not _factorise(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n):
            break
        sign = -_determinant_sign(plan, factors[0], size_n)  # of the change of tau on the way
        # back to the path with tau held; the tangent, by d(log tau); and how it bends
        _missing_momentum(mass, free, v, momentum, size_n)
        _add_push(jacobian, index, p, momentum, size_m, size_n)
        for turn in range(3):
            for c in range(contacts):
                if turn == 2:
                    _complementarity(tangent[0][c], tangent[1][c], tangent[2][c], mu[c], m, wanted[c])
                for i in range(k):
                    goal = tau * level[c] if i < 2 else 0.0
                    wanted[c, i] = goal - product[c, i] if turn == 0 else (goal if turn == 1 else -wanted[c, i])
                for i in range(m):
                    if turn > 0:
                        miss[c, i] = -tau * far[c, i] if turn == 1 else 0.0
            dw, dp, dgamma, out = ways[turn]
            _interior_direction(
                momentum if turn == 0 else still, jacobian, index, wanted, undo, gain, miss, soft, plan, factors, out, dw, dp, dgamma,
                size_m, size_n, size_k,
            )  # fmt: skip
        # both corrections across the tangent: this is what lets the path turn back
        length = 1.0 + _way_product(tangent, tangent, w, p, gamma, mu, size_m)
        drop = -_way_product(back, tangent, w, p, gamma, mu, size_m) / length
        curve = -_way_product(bend, tangent, w, p, gamma, mu, size_m) / length
        _combine_ways(back, drop, tangent, 0.0, tangent, back)
        _combine_ways(bend, curve, tangent, 0.0, tangent, bend)
        longest = 0.9 * _longest_step(w, p, gamma, mu, back[0], back[1], back[2], size_m)
        if longest < 1.0:  # back to the path first
            change = longest * drop
            _combine_ways(back, longest - 1.0, back, 0.0, back, way)
        else:
            change = _step_ahead(w, p, gamma, mu, back, tangent, bend, drop, sign, curve, wide, tau, level, way, trial, size_m)
        here = (w, p, gamma, v)
        _combine_ways(here, 1.0, way, 0.0, way, here)
        tau *= 1.0 + change
        _take_impulse(p, friction, impulse, size_m)
        _velocity_of(inverse, free, jacobian, index, impulse, momentum, own_v, size_m, size_n)
        error = _map_norm(jacobian, index, offset, friction, compliance, d, impulse, own_v, size_m, size_n) / size
        if error < smallest:
            smallest = error
            _copy(impulse, best)
            _copy(own_v, best_v)
        if not error < np.inf:
            break
    _copy(best, impulse)
    _put_back(best_v, order, v_out)
    return iterations, smallest


# --- proximal points over bodies ------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _softness(compliance, scale, c, m):
    """Compliance of the springs of contact c along and across the normal: the proximal one and the contact's own."""
    if len(compliance):
        return scale + compliance[c, 0], scale + max(compliance[c, 1], compliance[c, m - 1])
    return scale, scale


@njit(cache=True, nogil=True, error_model="numpy")
def _spring_residual(model, mu, compliance, d, stiffness, centre, v, held, status, x, p, out, size_m, size_n):
    """Trial impulses x and impulses p of the springs at velocities v, and out = M (v_free - v) + H^T p; returns its norm in M^-1.

    model holds the mass, its inverse, v_free, H by contact, the places of the bodies and b. The status of the contacts follows x, or is
    held as it is.
    """
    mass, inverse, free, jacobian, index, offset = model
    m, n = len(size_m), len(size_n)
    _rows(jacobian, index, offset, v, x, size_m, size_n)
    for c in range(len(mu)):
        soft_n, soft_t = _softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - x[c, i]) / soft
        length = _length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        if not held:
            status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
        share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
        for i in range(m):
            p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])
    _missing_momentum(mass, free, v, out, size_n)
    _add_push(jacobian, index, p, out, size_m, size_n)
    out[-1] = 0.0
    total = 0.0
    for b in range(len(mass)):
        for i in range(n):
            for j in range(n):
                total += out[b, i] * inverse[b, i, j] * out[b, j]
    return np.sqrt(max(total, 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _spring_blocks(mu, compliance, d, stiffness, status, x, blocks, size_m):
    """B = -dp/du of the springs."""
    m = len(size_m)
    blocks[:] = 0.0
    for c in range(len(mu)):
        if status[c] == OPEN:
            continue
        soft_n, soft_t = _softness(compliance, d[c] / stiffness, c, m)
        blocks[c, 0, 0] = 1.0 / soft_n
        length = _length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        share = mu[c] * max(x[c, 0], 0.0) / length if length > 0.0 else 1.0
        for i in range(1, m):
            if status[c] == STICK:
                blocks[c, i, i] = 1.0 / soft_t
            elif length > 0.0:
                blocks[c, i, 0] = mu[c] * x[c, i] / (length * soft_n)
                for j in range(1, m):  # zero in a plane
                    across = (1.0 if i == j else 0.0) - x[c, i] * x[c, j] / (length * length)
                    blocks[c, i, j] = min(share, 1.0) / soft_t * across


@njit(cache=True, nogil=True, error_model="numpy")
def _spring_changes(jacobian, index, compliance, d, stiffness, change, dx, size_m, size_n):
    """Change of the trial impulses with the velocities."""
    m, n = len(size_m), len(size_n)
    for c in range(len(d)):
        soft_n, soft_t = _softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            total = 0.0
            for k in range(n):
                total += jacobian[c, 0, i, k] * change[index[c, 0], k] + jacobian[c, 1, i, k] * change[index[c, 1], k]
            dx[c, i] = -total / (soft_n if i == 0 else soft_t)


@njit(entry=True, cache=True, nogil=True, error_model="numpy")
def _first_change(mu, status, x, dx, size_m):
    """The step along dx at which the first contact changes its status, that contact, and its new status."""
    m, first, which, new = len(size_m), np.inf, -1, OPEN
    for c in range(len(mu)):
        if (status[c] == OPEN) == (dx[c, 0] > 0.0):  # closes or opens
            step = max(-x[c, 0] / dx[c, 0], 0.0)
            if step < first:
                first, which, new = step, c, SLIP if status[c] == OPEN else OPEN
        if status[c] == OPEN:
            continue
        a, b, e = -((mu[c] * dx[c, 0]) ** 2), -mu[c] * mu[c] * x[c, 0] * dx[c, 0], -((mu[c] * x[c, 0]) ** 2)
        for i in range(1, m):  # |x_t|^2 - mu^2 x_n^2 = a step^2 + 2 b step + e
            a += dx[c, i] * dx[c, i]
            b += x[c, i] * dx[c, i]
            e += x[c, i] * x[c, i]
        outward, root, step = 1.0 if status[c] == STICK else -1.0, b * b - a * e, np.inf
        if outward * e >= 0.0 and outward * b > 0.0:  # there already
            step = 0.0
        elif root >= 0.0:
            q = -(b + np.sqrt(root)) if b >= 0.0 else -(b - np.sqrt(root))
            if q != 0.0 and e / q > 0.0 and outward * (a * (e / q) + b) > 0.0:
                step = e / q
            if a != 0.0 and q / a > 0.0 and outward * (q + b) > 0.0:
                step = min(step, q / a)
        if step < first:
            first, which, new = step, c, STICK + SLIP - status[c]
    return first, which, new


@njit(cache=True, nogil=True, error_model="numpy")
def _add_step(v, step, change, size_n, out):
    """out = v + step change."""
    for b in range(len(v)):
        for i in range(len(size_n)):
            out[b, i] = v[b, i] + step * change[b, i]


@njit(entry=False, cache=True, nogil=True, error_model="numpy")
def proximal_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, tolerance, limit, size_m,
    size_n,
):  # fmt: skip
    """Proximal points over a FrictionProblem, see solvers/interior.py. p holds the start and then the best answer found.

    Returns iterations (one factorisation each) and natural map error.
    """
    count, m, n, contacts = len(order), len(size_m), len(size_n), len(mu)
    inverse, mass, free = _in_order(inverse_mass, v_free, order, size_n)
    left, slip = np.empty((count, n)), np.empty((contacts, m))
    model = (mass, inverse, left, jacobian, index, slip)  # of the change of velocity from that of the centre, which rounding spares
    d = _scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, change, trial = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.zeros((count + 1, n)), np.zeros((count + 1, n))
    x, dx, blocks = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m, m))
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = _room(plan, size_n)
    status, held = np.zeros(contacts, dtype=np.int64), np.zeros(contacts, dtype=np.int64)
    _copy(free, v)
    _rows(jacobian, index, offset, v, x, size_m, size_n)
    size = _size_of(x, d)
    _velocity_of(inverse, free, jacobian, index, p, out, v, size_m, size_n)
    smallest = error = _map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
    best, best_v, centre, centre_v, own_v = p.copy(), v.copy(), p.copy(), v.copy(), v.copy()
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed = 0, 0
    while iterations < limit and smallest > tolerance and failed < 8:
        # the springs' problem to a hundredth of the error, from the centre
        goal = size * max(1e-2 * error, 1e-3 * tolerance)
        _add_step(free, -1.0, centre_v, size_n, left)
        _rows(jacobian, index, offset, centre_v, slip, size_m, size_n)
        _add_step(centre_v, -1.0, centre_v, size_n, v)
        norm = _spring_residual(model, mu, compliance, d, stiffness, centre, v, FREE, status, x, p, out, size_m, size_n)
        begun, turned, last = iterations, 0, -1
        while norm > goal and iterations < min(limit, begun + 25) and turned < 3:
            _spring_blocks(mu, compliance, d, stiffness, status, x, blocks, size_m)
            _augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n)
            iterations += 1
            if not _factorise(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n):
                break
            _solve_factorised(plan, factors[0], factors[1], factors[2], out, size_n)
            _copy(out[:count], change)
            step, new = 2.0, np.inf
            _copy(status, held)
            while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
                step *= 0.5
                _add_step(v, step, change, size_n, trial)
                new = _spring_residual(model, mu, compliance, d, stiffness, centre, trial, FREE, status, x, p, out, size_m, size_n)
            if new < (1.0 - 0.1 * step) * norm:
                _copy(trial, v)
                norm, last, turned = new, -1, 0
                continue
            # no progress across the kinks: as far as the first of them, and the contact there changes its status
            _copy(held, status)
            _spring_residual(model, mu, compliance, d, stiffness, centre, v, HELD, status, x, p, out, size_m, size_n)
            _spring_changes(jacobian, index, compliance, d, stiffness, change, dx, size_m, size_n)
            step, which, other = _first_change(mu, status, x, dx, size_m)
            if step < 1.0:
                turned = turned + 1 if which == last and step < 1e-9 else 0
                status[which], last = other, which
            _add_step(v, min(step, 0.5) if step >= 1.0 else step, change, size_n, v)
            norm = _spring_residual(model, mu, compliance, d, stiffness, centre, v, HELD, status, x, p, out, size_m, size_n)
        solved, spent = norm <= goal, iterations - begun
        _velocity_of(inverse, free, jacobian, index, p, out, own_v, size_m, size_n)
        new = _map_norm(jacobian, index, offset, mu, compliance, d, p, own_v, size_m, size_n) / size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        if not solved:
            stiffness *= 0.25
        elif spent <= 8:
            stiffness *= 16.0 if new > 0.5 * error and spent < 4 else 4.0
        error, failed = new, 0
        stiffness = min(stiffness, STIFFEST)
        _copy(p, centre)
        _add_step(centre_v, 1.0, v, size_n, centre_v)
        if error < smallest:
            smallest = error
            _copy(p, best)
            _copy(own_v, best_v)
    _copy(best, p)
    _put_back(best_v, order, v_out)
    return iterations, smallest


# --- the four of them -------------------------------------------------------------------------------------------------------------------

NEWTON, INTERIOR, PATH, PROXIMAL = 0, 1, 2, 3  # methods that linearise the law


@njit(cache=True, nogil=True, error_model="numpy")
def linearised_bodies(
    method, inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, distance, stiffness, wide,
    tolerance, limit, size_m, size_n, size_k,
):  # fmt: skip
    """One of these methods over a FrictionProblem. p holds the start and then the best answer found.

    Python enters here alone, so that their factorisation, the larger part of each, is compiled once. Returns iterations, natural map
    error, and of Newton the error at the start and the stiffness at the end.
    """
    if method == NEWTON:
        return newton_bodies(
            inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, stiffness, tolerance,
            limit, size_m, size_n,
        )  # fmt: skip
    if method == INTERIOR:
        iterations, error = interior_bodies(
            inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, distance, stiffness,
            tolerance, limit, size_m, size_n, size_k,
        )  # fmt: skip
    elif method == PATH:
        iterations, error = path_bodies(
            inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, distance, stiffness,
            wide, tolerance, limit, size_m, size_n, size_k,
        )  # fmt: skip
    else:
        iterations, error = proximal_bodies(
            inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, tolerance, limit, size_m,
            size_n,
        )  # fmt: skip
    return iterations, error, np.nan, stiffness


# --- interior point and proximal points for local problems -----------------------------------------------------------------------------
#
# In the impulses instead of the velocities: a step solves (I + S W) dp = r, S one block per contact. The problems come scaled, so that
# trace(W_cc) = m; then the centring treats all contacts alike.


@njit(cache=True, nogil=True, error_model="numpy")
def _factorise_local(data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m):
    """Factorise I + S W, S one block per contact. False if that fails."""
    _place_blocks(data, indices, indptr, blocks, place, plan, UNSYMMETRIC, diagonal, lower, upper, size_m)
    for i in range(len(place)):
        for r in range(len(size_m)):
            diagonal[i, r, r] += 1.0
    return _factorise(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_m)


@njit(cache=True, nogil=True, error_model="numpy")
def _solve_local(plan, factors, place, right, x, size_m):
    """x <- (I + S W)^-1 x, by contact; right (C, m) is room for x in the order of elimination."""
    m = len(size_m)
    for c in range(len(place)):
        for i in range(m):
            right[place[c], i] = x[c, i]
    _solve_factorised(plan, factors[0], factors[1], factors[2], right, size_m)
    for c in range(len(place)):
        for i in range(m):
            x[c, i] = right[place[c], i]


@njit(cache=True, nogil=True, error_model="numpy")
def _interior_direction_local(
    data, indices, indptr, wanted, inverse, gain, miss, soft, plan, factors, place, right, dw, dp, dgamma, size_m, size_k
):
    """The step that changes the products as wanted and takes the other residual away, miss = W p + q - w: dw, dp, dgamma."""
    m, k = len(size_m), len(size_k)
    for c in range(len(dp)):
        for i in range(k):
            total = 0.0
            for j in range(k):
                total += inverse[c, i, j] * wanted[c, j]
            for j in range(m):
                total -= gain[c, i, j] * miss[c, j]
            if i < m:
                dp[c, i] = total
            else:
                dgamma[c] = total
    _solve_local(plan, factors, place, right, dp, size_m)
    _product(data, indices, indptr, dp, dw, size_m)
    for c in range(len(dp)):
        for j in range(m):
            dgamma[c] -= gain[c, m, j] * dw[c, j]
        for i in range(m):
            dw[c, i] += miss[c, i] + soft[c, i] * dp[c, i]


@njit(cache=True, nogil=True, error_model="numpy")
def interior_local(
    data, indices, indptr, q, friction, place, plan, impulse, distance, stiffness, tolerance, limit, size_m, size_k
):  # fmt: skip
    """Interior point method over a scaled LocalProblem, as :func:`interior_bodies`: (I + G W) dp = r, G the first rows of the gains.

    impulse holds the start and then the best answer found. Returns iterations and natural map error.
    """
    contacts, m, k = len(friction), len(size_m), len(size_k)
    d = np.ones(contacts)
    u, soft, right = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    dw, dp, dgamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work, blocks = np.empty((contacts, k, k)), np.empty((3, k, k)), np.empty((contacts, m, m))
    diagonal, lower, upper = np.empty((contacts, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    factors = _room(plan, size_m)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    size, shift = _size_of(q, d), distance * np.abs(q).max()
    best = impulse.copy()
    smallest = _local_norm(data, indices, indptr, q, friction, d, best, u, size_m) / size
    for c in range(contacts):
        gamma[c] = _move_inside(best[c], u[c], mu[c], 1.0, shift, w[c], p[c], m)
    step, iterations, short = 1.0, 0, 0
    while iterations < limit and smallest > tolerance and short < 6:
        iterations += 1
        _product(data, indices, indptr, p, u, size_m)
        gap, undone, regular = 0.0, 0.0, True
        for c in range(contacts):
            for i in range(m):
                soft[c, i] = 1.0 / stiffness
                u[c, i] += q[c, i] - w[c, i]  # what w misses
                undone += abs(u[c, i] * p[c, i]) / contacts
            _complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            gap += 0.5 * (product[c, 0] + product[c, 1]) / contacts
            regular = _linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
            _copy(gain[c, :m], blocks[c])
        if not (gap > 0.0 and regular) or not _factorise_local(
            data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m
        ):
            break
        if _determinant_sign(plan, factors[0], size_m) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        centring, longest = 0.0, 0.0
        for turn in range(3):
            if turn == 2 and longest >= 0.1:
                break
            _aim(dw, dp, dgamma, mu, product, centring * gap, turn == 1, wanted, size_m, size_k)
            _interior_direction_local(
                data, indices, indptr, wanted, undo, gain, u, soft, plan, factors, place, right, dw, dp, dgamma, size_m, size_k
            )
            longest = _longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m)
            if turn == 0:
                centring = _centring(dw, dp, dgamma, mu, product, gap, undone, longest, step, wanted, size_m)
        step = min(1.0, 0.99 * longest)
        _advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m)
        short = short + 1 if step < 0.02 else 0
        stiffness = _stiffness_after(step, stiffness)
        error = _local_norm(data, indices, indptr, q, friction, d, impulse, dw, size_m) / size
        if error < smallest:
            smallest = error
            _copy(impulse, best)
        if not error < np.inf:
            break
    _copy(best, impulse)
    return iterations, smallest


@njit(cache=True, nogil=True, error_model="numpy")
def _spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, held, status, x, p, out, size_m):
    """Trial impulses x and impulses p of the springs at velocities u (C, m), and out = W p + q - u; returns its norm.

    The status of the contacts follows x, or is held as it is.
    """
    m, total = len(size_m), 0.0
    for c in range(len(mu)):
        for i in range(m):
            x[c, i] = centre[c, i] - stiffness * u[c, i]
        length = _length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        if not held:
            status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
        share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
        for i in range(m):
            p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])
    _product(data, indices, indptr, p, out, size_m)
    for c in range(len(mu)):
        for i in range(m):
            out[c, i] += q[c, i] - u[c, i]
            total += out[c, i] * out[c, i]
    return np.sqrt(total)


@njit(cache=True, nogil=True, error_model="numpy")
def proximal_local(data, indices, indptr, q, mu, place, plan, p, tolerance, limit, size_m):
    """Proximal points over a scaled LocalProblem, as :func:`proximal_bodies` but in u: du = r + W dp, (I + B W) dp = -B r, r = W p + q - u.

    p holds the start and then the best answer found. Returns iterations (one factorisation each) and natural map error.
    """
    contacts, m = len(mu), len(size_m)
    d, u, out = np.ones(contacts), np.empty(p.shape), np.empty(p.shape)
    change, trial, right = np.empty(p.shape), np.empty(p.shape), np.empty(p.shape)
    x, dx, blocks, rigid = np.empty(p.shape), np.empty(p.shape), np.empty((contacts, m, m)), np.empty((0, m))
    diagonal, lower, upper = np.empty((contacts, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    factors = _room(plan, size_m)
    status, held = np.zeros(contacts, dtype=np.int64), np.zeros(contacts, dtype=np.int64)
    size = _size_of(q, d)
    smallest = error = _local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    best, centre, centre_u = p.copy(), p.copy(), u.copy()
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed = 0, 0
    while iterations < limit and smallest > tolerance and failed < 16:
        # the springs' problem to a hundredth of the error, from the centre
        goal = size * max(1e-2 * error, 1e-3 * tolerance)
        _copy(centre_u, u)
        norm = _spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, FREE, status, x, p, out, size_m)
        begun, turned, last = iterations, 0, -1
        while norm > goal and iterations < min(limit, begun + 60) and turned < 3:
            _spring_blocks(mu, rigid, d, stiffness, status, x, blocks, size_m)
            iterations += 1
            if not _factorise_local(data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m):
                break
            for c in range(contacts):
                for i in range(m):
                    change[c, i] = 0.0
                    for j in range(m):
                        change[c, i] -= blocks[c, i, j] * out[c, j]
            _solve_local(plan, factors, place, right, change, size_m)  # that of p
            _product(data, indices, indptr, change, trial, size_m)
            for c in range(contacts):
                for i in range(m):
                    change[c, i] = out[c, i] + trial[c, i]
            step, new = 2.0, np.inf
            _copy(status, held)
            while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
                step *= 0.5
                for c in range(contacts):
                    for i in range(m):
                        trial[c, i] = u[c, i] + step * change[c, i]
                new = _spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, trial, FREE, status, x, p, out, size_m)
            if new < (1.0 - 0.1 * step) * norm:
                _copy(trial, u)
                norm, last, turned = new, -1, 0
                continue
            # no progress across the kinks: as far as the first of them, and the contact there changes its status
            _copy(held, status)
            _spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, HELD, status, x, p, out, size_m)
            for c in range(contacts):
                for i in range(m):
                    dx[c, i] = -stiffness * change[c, i]
            step, which, other = _first_change(mu, status, x, dx, size_m)
            if step < 1.0:
                turned = turned + 1 if which == last and step < 1e-9 else 0
                status[which], last = other, which
            share = min(step, 0.5) if step >= 1.0 else step
            for c in range(contacts):
                for i in range(m):
                    u[c, i] += share * change[c, i]
            norm = _spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, HELD, status, x, p, out, size_m)
        solved, spent = norm <= goal, iterations - begun
        new = _local_norm(data, indices, indptr, q, mu, d, p, trial, size_m) / size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        if not solved:
            stiffness *= 0.25
        elif spent <= 8:
            stiffness *= 16.0 if new > 0.5 * error and spent < 4 else 4.0
        error = new
        stiffness = min(stiffness, max(1e13 * error, 1e4))  # or else rounding, EPSILON times it, shows
        _copy(p, centre)
        _copy(u, centre_u)
        if error < smallest:
            smallest = error
            _copy(p, best)
    _copy(best, p)
    return iterations, smallest
