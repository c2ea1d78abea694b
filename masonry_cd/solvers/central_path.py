"""What the interior point method and the path by its length share: the products of a contact, their linearisation, and steps in the
cones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.body_sides import add_impulse_of_sides
from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.threads import take, wait
from masonry_cd.solvers.shared_operators import contact_velocity, solve_by_first
from masonry_cd.solvers.shares import add_share, begin_sums, chunk_of, copy_share, least_of_chunks, sum_of_chunks

STIFFEST = 1e12  # K of interior and proximal points; stiff springs beside rigid contacts settle where K exceeds d / C


class Cones(NamedTuple):
    """The cones of the contacts."""

    mu: np.ndarray  # (C,) friction, nowhere zero: a cone without width has no inside
    m: tuple[int, ...]  # m zeros
    k: tuple[int, ...]  # m + 1 zeros: as many products as a contact has


class Iterate(NamedTuple):
    """A point inside the cones, or a direction in which to move it."""

    w: np.ndarray  # (C, m)
    p: np.ndarray  # (C, m)
    gamma: np.ndarray  # (C,) sliding speeds
    v: np.ndarray  # (B + 1, n) body velocities; of no use where W alone is given


class Linearisation(NamedTuple):
    """The products of each contact and their linearisation: (dp, dgamma) = inverse r - gain (du + miss) changes them by r."""

    product: np.ndarray  # (C, k) w_n p_n and (gamma, w_t) o (mu p_n, p_t)
    wanted: np.ndarray  # (C, k) r
    inverse: np.ndarray  # (C, k, k)
    gain: np.ndarray  # (C, k, m)
    soft: np.ndarray  # (C, m) compliance of the spring in series, the contact's own and that of the damping
    miss: np.ndarray  # (C, m) H v + b + C p - w, and on the path by its length less tau times that of the start
    far: np.ndarray  # (C, m) that of the start, zero without such a path


@kernel()
def cones_of(mu, m, k):
    """The :class:`Cones` of contacts with friction mu (C,)."""
    return Cones(np.maximum(mu, 1e-6), m, k)


@kernel()
def allocate_iterate(room, shape, rows):
    """An :class:`Iterate` of zeros for contacts (C, m) and velocities of a shape."""
    return Iterate(take(room, shape), take(room, shape), take(room, shape[:1]), take(room, rows))


@kernel()
def allocate_linearisation(room, shape):
    """Room for a :class:`Linearisation` of contacts (C, m); ``far`` is zero."""
    contacts, m = shape
    products, blocks, gains = (contacts, m + 1), (contacts, m + 1, m + 1), (contacts, m + 1, m)
    product, wanted = take(room, products), take(room, products)
    inverse, gain = take(room, blocks), take(room, gains)
    return Linearisation(product, wanted, inverse, gain, take(room, shape), take(room, shape), take(room, shape))


@kernel(inline="always")
def cone_det(x0: float, x1: float, x2: float) -> float:
    """x_0^2 - |x_t|^2, positive inside the second-order cone; written so that it does not cancel."""
    t = tangent_length(x1, x2)
    return (x0 - t) * (x0 + t)


@borrower()
def max_step_to_cone(x0: float, x1: float, x2: float, d0: float, d1: float, d2: float) -> float:
    """Largest step from x inside the second-order cone along d that stays inside, at most 1e10."""
    best = -x0 / d0 if d0 < 0.0 else 1e10
    a, b, c = d0 * d0 - d1 * d1 - d2 * d2, x0 * d0 - x1 * d1 - x2 * d2, max(cone_det(x0, x1, x2), 0.0)
    root = b * b - a * c  # of a t^2 + 2 b t + c = 0
    if root < 0.0:
        return best
    far = -(b + np.sqrt(root)) if b >= 0.0 else -(b - np.sqrt(root))
    if far != 0.0 and c / far > 0.0:
        best = min(best, c / far)
    if a != 0.0 and far / a > 0.0:
        best = min(best, far / a)
    return best


@kernel(inline="always")
def complementarity(w, p, gamma, mu, m, out):
    """The products of a contact that vanish in a solution: w_n p_n and (gamma, w_t) o (mu p_n, p_t)."""
    out[0] = w[0] * p[0]
    out[1] = gamma * mu * p[0]
    for i in range(1, m):
        out[1] += w[i] * p[i]
        out[1 + i] = gamma * p[i] + mu * p[0] * w[i]


@borrower()
def central_start(p, u, mu, d, shift, w, inner, m):
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


@borrower()
def linearise_contact(w, p, gamma, mu, soft, inverse, gain, size_m, size_k):
    """Fill inverse (k, k) and gain (k, m) of one contact, see :class:`Linearisation`; False if they do not exist.

    The products change with x = (dp, dgamma), dw = soft dp, by rows that are an arrow,

        a x_0,     b x_0 + sum e_i x_i + f x_m,     g_i x_0 + d_i x_i + h_i x_m,     i = 1 .. m - 1,

    where a and d_i are positive inside the cones: x_0 comes from the first row, x_i from its own, and x_m from the one that is left.
    """
    m, k, a, f = len(size_m), len(size_k), w[0] + p[0] * soft[0], mu * p[0]
    first, slope, left = 1.0 / a, gamma * mu, f
    for i in range(1, m):
        own, share = 1.0 / (gamma + f * soft[i]), w[i] + p[i] * soft[i]
        inverse[i, 1 + i], inverse[m, 1 + i] = own, share * own
        slope -= share * own * mu * w[i]
        left -= share * own * p[i]
    last = 1.0 / left
    for j in range(1, k):
        inverse[0, j] = 0.0
    inverse[0, 0], inverse[m, 0], inverse[m, 1] = first, -slope * first * last, last
    for i in range(1, m):
        inverse[m, 1 + i] *= -last
    for i in range(1, m):
        own = inverse[i, 1 + i]
        inverse[i, 0] = -own * (mu * w[i] * first + p[i] * inverse[m, 0])
        inverse[i, 1] = -own * p[i] * last
        for j in range(1, m):
            inverse[i, 1 + j] = (own if i == j else 0.0) - own * p[i] * inverse[m, 1 + j]
    for i in range(k):
        gain[i, 0] = inverse[i, 0] * p[0]
        for j in range(1, m):
            gain[i, j] = inverse[i, 1] * p[j] + inverse[i, 1 + j] * f
    return 0.0 < a < np.inf and 0.0 < abs(left) < np.inf


@borrower()
def linearise_products(shares, cones, here, linear):
    """Fill the products of the contacts and their linearisation.

    Returns how far the products are from zero, the gap tau, and what w misses in its units, both as means over the contacts; the gap is
    not a number if a contact cannot be solved for its impulse.
    """
    m, contacts, turn, (first, end) = len(cones.m), len(cones.mu), begin_sums(shares), shares.chunks
    for k in range(first, end):
        gap, undone = 0.0, 0.0
        begin, stop = chunk_of(k, contacts)
        for c in range(begin, stop):
            w, p, gamma, mu = here.w[c], here.p[c], here.gamma[c], cones.mu[c]
            complementarity(w, p, gamma, mu, m, linear.product[c])
            gap += 0.5 * (linear.product[c, 0] + linear.product[c, 1])
            if not linearise_contact(w, p, gamma, mu, linear.soft[c], linear.inverse[c], linear.gain[c], cones.m, cones.k):
                gap = np.nan
            for i in range(m):
                undone += abs(linear.miss[c, i] * p[i])
        shares.sums[turn, 0, k], shares.sums[turn, 1, k] = gap, undone
    wait(shares.team)
    return sum_of_chunks(shares, 0, contacts) / contacts, sum_of_chunks(shares, 1, contacts) / contacts


@borrower()
def soften(shares, problem, stiffness, linear):
    """The springs in series with the products, C + d / K."""
    compliance, d, soft, (first, end) = problem.compliance, problem.d, linear.soft, shares.contacts
    for c in range(first, end):
        for i in range(len(problem.m)):
            soft[c, i] = (compliance[c, i] if len(compliance) else 0.0) + d[c] / stiffness


@borrower()
def missing_velocity(shares, problem, here, tau, linear):
    """What w misses, H v + b + C p - w - tau far."""
    compliance, miss, far, (first, end) = problem.compliance, linear.miss, linear.far, shares.contacts
    contact_velocity(shares, problem, here.v, miss)
    for c in range(first, end):
        for i in range(len(problem.m)):
            own = compliance[c, i] if len(compliance) else 0.0
            miss[c, i] += own * here.p[c, i] - here.w[c, i] - tau * far[c, i]


@kernel()
def interior_direction(shares, problem, work, linear, way):
    """The direction that changes the products as wanted and takes all other residuals away.

    The factors are those of M + H^T B H with B the first rows of the gains; ``room`` has H^T p - M (v - v_free).
    """
    begin, stop = shares.rows
    start_direction(shares, linear, way, len(problem.m), linear.product.shape[1])
    copy_share(shares.rows, work.room, way.v)
    wait(shares.team)
    add_impulse_of_sides(problem, shares.sides, way.p, begin, stop, way.v)
    solve_by_first(shares, work.factor, way.v)
    finish_direction(shares, problem, linear, way)


@borrower()
def finish_direction(shares, problem, linear, way):
    """What of a direction depends on the change of the velocities, once this is known."""
    (dw, dp, dgamma, out), m, n = way, len(problem.m), len(problem.n)
    jacobian, index, gain, miss, soft = problem.jacobian, problem.places, linear.gain, linear.miss, linear.soft
    first, end = shares.contacts
    for c in range(first, end):
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


@kernel(inline="always")
def start_direction(shares, linear, way, m, k):
    """dp and dgamma of a direction as far as they do not depend on the change of the velocities."""
    first, end = shares.contacts
    for c in range(first, end):
        for i in range(k):
            total = 0.0
            for j in range(k):
                total += linear.inverse[c, i, j] * linear.wanted[c, j]
            for j in range(m):
                total -= linear.gain[c, i, j] * linear.miss[c, j]
            if i < m:
                way.p[c, i] = total
            else:
                way.gamma[c] = total


@borrower()
def contact_step(w, p, gamma, dw, dp, dgamma, mu, m):
    """Largest step along a direction that keeps one contact inside its cones, at most 1e10; vectors (m,)."""
    longest = -w[0] / dw[0] if dw[0] < 0.0 else 1e10
    w2, p2, dw2, dp2 = (w[2], p[2], dw[2], dp[2]) if m == 3 else (0.0, 0.0, 0.0, 0.0)
    longest = min(longest, max_step_to_cone(gamma, w[1], w2, dgamma, dw[1], dw2))
    return min(longest, max_step_to_cone(mu * p[0], p[1], p2, mu * dp[0], dp[1], dp2))


@borrower()
def longest_step(shares, here, way, cones):
    """Largest step along a direction that keeps every contact inside its cones, at most 1e10."""
    (w, p, gamma, _), (dw, dp, dgamma, _), m, mu = here, way, len(cones.m), cones.mu
    turn, (first, end) = begin_sums(shares), shares.chunks
    for k in range(first, end):
        longest = 1e10
        begin, stop = chunk_of(k, len(mu))
        for c in range(begin, stop):
            longest = min(longest, contact_step(w[c], p[c], gamma[c], dw[c], dp[c], dgamma[c], mu[c], m))
        shares.sums[turn, 0, k] = longest
    wait(shares.team)
    return least_of_chunks(shares, len(mu))[0]


@borrower()
def take_impulse(shares, p, friction, impulse):
    """impulse = p (C, m), without a tangential part where there is no friction."""
    first, end = shares.contacts
    for c in range(first, end):
        for i in range(p.shape[1]):
            impulse[c, i] = p[c, i] if i == 0 or friction[c] > 0.0 else 0.0


@borrower()
def advance(shares, here, step, way):
    """Go a share of a direction."""
    add_share(shares.contacts, here.w, step, way.w, here.w)
    add_share(shares.contacts, here.p, step, way.p, here.p)
    add_share(shares.contacts, here.gamma, step, way.gamma, here.gamma)
    add_share(shares.rows, here.v, step, way.v, here.v)


@borrower()
def begin_inside(shares, problem, answer, cones, distance, here, u):
    """The start: w, p and gamma inside the cones, near the answer, and v its velocities; u (C, m) are those of the contacts.

    Returns the distance from the walls as a speed, ``distance`` times the largest without impulses.
    """
    shift, impulse, m, (first, end) = distance * answer.speed, answer.impulse, len(cones.m), shares.contacts
    copy_share(shares.rows, answer.velocity, here.v)
    for c in range(first, end):
        here.gamma[c] = central_start(impulse[c], u[c], cones.mu[c], problem.d[c], shift, here.w[c], here.p[c], m)
    return shift
