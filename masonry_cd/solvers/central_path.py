"""What the interior point method and the path by its length share: the products of a contact, their linearisation, and steps in the
cones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.operators import add_generalised_impulse, relative_velocity
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.triangular import solve_ldu

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
def allocate_iterate(shape, rows):
    """An :class:`Iterate` of zeros for numbers of contacts and of bodies; m rows a contact, n unknowns a body."""
    return Iterate(np.zeros(shape), np.zeros(shape), np.zeros(shape[0]), np.zeros(rows))


@kernel()
def allocate_linearisation(contacts, cones):
    """Room for a :class:`Linearisation`."""
    m, k = len(cones.m), len(cones.k)
    product, wanted = np.empty((contacts, k)), np.empty((contacts, k))
    inverse, gain = np.empty((contacts, k, k)), np.empty((contacts, k, m))
    return Linearisation(product, wanted, inverse, gain, np.empty((contacts, m)), np.empty((contacts, m)), np.zeros((contacts, m)))


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


@kernel()
def linearise_products(cones, here, linear):
    """Fill the products of all contacts and their linearisation. False if one cannot be solved for its impulse."""
    regular = True
    for c in range(len(cones.mu)):
        w, p, gamma, mu = here.w[c], here.p[c], here.gamma[c], cones.mu[c]
        complementarity(w, p, gamma, mu, len(cones.m), linear.product[c])
        inverse, gain = linear.inverse[c], linear.gain[c]
        regular = linearise_contact(w, p, gamma, mu, linear.soft[c], inverse, gain, cones.m, cones.k) and regular
    return regular


@borrower()
def soften(problem, stiffness, linear):
    """The springs in series with the products, C + d / K."""
    compliance, d, soft = problem.compliance, problem.d, linear.soft
    for c in range(len(d)):
        for i in range(len(problem.m)):
            soft[c, i] = (compliance[c, i] if len(compliance) else 0.0) + d[c] / stiffness


@borrower()
def missing_velocity(problem, here, tau, linear):
    """What w misses, H v + b + C p - w - tau far."""
    compliance, miss, far = problem.compliance, linear.miss, linear.far
    relative_velocity(problem, here.v, miss)
    for c in range(len(miss)):
        for i in range(len(problem.m)):
            own = compliance[c, i] if len(compliance) else 0.0
            miss[c, i] += own * here.p[c, i] - here.w[c, i] - tau * far[c, i]


@kernel()
def interior_direction(problem, work, linear, way):
    """The direction that changes the products as wanted and takes all other residuals away.

    The factors are those of M + H^T B H with B the first rows of the gains; ``room`` has H^T p - M (v - v_free).
    """
    m, n, k = len(problem.m), len(problem.n), linear.product.shape[1]
    start_direction(linear, way, m, k)
    dw, dp, dgamma, out = way.w, way.p, way.gamma, way.v
    copy_flat(work.room, out)
    add_generalised_impulse(problem, dp, out)
    solve_ldu(work.factor, out)
    out[-1] = 0.0
    jacobian, index, gain, miss, soft = problem.jacobian, problem.places, linear.gain, linear.miss, linear.soft
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


@kernel(inline="always")
def start_direction(linear, way, m, k):
    """dp and dgamma of a direction as far as they do not depend on the change of the velocities."""
    for c in range(len(way.p)):
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
def longest_step(here, way, cones):
    """Largest step along a direction that keeps every contact inside its cones."""
    (w, p, gamma, _), (dw, dp, dgamma, _) = here, way
    longest = 1e10
    for c in range(len(cones.mu)):
        longest = min(longest, contact_step(w[c], p[c], gamma[c], dw[c], dp[c], dgamma[c], cones.mu[c], len(cones.m)))
    return longest


@borrower()
def take_impulse(p, friction, impulse):
    """impulse = p (C, m), without a tangential part where there is no friction."""
    for c in range(len(friction)):
        for i in range(p.shape[1]):
            impulse[c, i] = p[c, i] if i == 0 or friction[c] > 0.0 else 0.0


@borrower()
def add_flat(x, step, change):
    """x += step change, both contiguous and of one shape."""
    x, change = x.reshape(x.size), change.reshape(change.size)
    for i in range(len(x)):
        x[i] += step * change[i]


@borrower()
def advance(here, step, way):
    """Go a share of a direction."""
    add_flat(here.w, step, way.w)
    add_flat(here.p, step, way.p)
    add_flat(here.gamma, step, way.gamma)
    add_flat(here.v, step, way.v)


@borrower()
def begin_inside(problem, answer, cones, distance, here, u):
    """The start: w, p and gamma inside the cones, near the answer, and v its velocities; u (C, m) are those of the contacts.

    Returns the distance from the walls as a speed, ``distance`` times the largest without impulses.
    """
    shift, impulse = distance * answer.speed, answer.impulse
    copy_flat(answer.velocity, here.v)
    for c in range(len(cones.mu)):
        here.gamma[c] = central_start(impulse[c], u[c], cones.mu[c], problem.d[c], shift, here.w[c], here.p[c], len(cones.m))
    return shift
