"""What the interior point method and the path by its length share: the products of a contact, their linearisation, and steps in the
cones."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.natural_map import size_of
from masonry_cd.friction.operators import add_generalised_impulse, body_velocity, map_norm, relative_velocity
from masonry_cd.jit import kernel
from masonry_cd.linalg.small_blocks import copy_flat, invert
from masonry_cd.linalg.triangular import solve_ldu

STIFFEST = 1e12  # K of interior and proximal points; stiff springs beside rigid contacts settle where K exceeds d / C


@kernel(inline="always")
def cone_det(x0: float, x1: float, x2: float) -> float:
    """x_0^2 - |x_t|^2, positive inside the second-order cone; written so that it does not cancel."""
    t = tangent_length(x1, x2)
    return (x0 - t) * (x0 + t)


@kernel()
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


@kernel()
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


@kernel()
def linearise_products(w, p, gamma, mu, soft, inverse, gain, work, size_m, size_k):
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
    regular = invert(change, inverse, work[2], size_k)
    for i in range(k):
        for j in range(m):
            total = 0.0
            for q in range(k):
                total += inverse[i, q] * by_w[q, j]
            gain[i, j] = total
    return regular


@kernel()
def interior_direction(
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
    copy_flat(momentum, out)
    add_generalised_impulse(jacobian, index, dp, out, size_m, size_n)
    solve_ldu(plan, factors[0], factors[1], factors[2], out, size_n)
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


@kernel()
def largest(x):
    """Largest size of an entry."""
    most = 0.0
    for c in range(len(x)):
        for i in range(x.shape[1]):
            most = max(most, abs(x[c, i]))
    return most


@kernel()
def longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m):
    """Largest step that keeps every contact inside its cones."""
    m, longest = len(size_m), 1e10
    for c in range(len(mu)):
        if dw[c, 0] < 0.0:
            longest = min(longest, -w[c, 0] / dw[c, 0])
        w2, p2, dw2, dp2 = (w[c, 2], p[c, 2], dw[c, 2], dp[c, 2]) if m == 3 else (0.0, 0.0, 0.0, 0.0)
        longest = min(longest, max_step_to_cone(gamma[c], w[c, 1], w2, dgamma[c], dw[c, 1], dw2))
        longest = min(longest, max_step_to_cone(mu[c] * p[c, 0], p[c, 1], p2, mu[c] * dp[c, 0], dp[c, 1], dp2))
    return longest


@kernel()
def corrector_rhs(dw, dp, dgamma, mu, product, target, second, wanted, size_m, size_k):
    """The changes of the products that lead to ``target``, with the second order of the last direction if ``second`` is set."""
    m, k = len(size_m), len(size_k)
    for c in range(len(mu)):
        if second:
            complementarity(dw[c], dp[c], dgamma[c], mu[c], m, wanted[c])
        for i in range(k):
            wanted[c, i] = (target if i < 2 else 0.0) - product[c, i] - (wanted[c, i] if second else 0.0)


@kernel()
def centring_share(dw, dp, dgamma, mu, product, gap, undone, longest, step, room, size_m):
    """Share of the gap to aim at, from what the predictor would leave of it, and more after a short step; ``room`` (C, k) is used up.

    ``undone`` measures what w misses in the units of the gap: the gap is not to vanish before it.
    """
    contacts, ahead, reach = len(mu), 0.0, min(1.0, longest)
    for c in range(contacts):
        complementarity(dw[c], dp[c], dgamma[c], mu[c], len(size_m), room[c])
        ahead += 0.5 * (1.0 - reach) * (product[c, 0] + product[c, 1]) / contacts
        ahead += 0.5 * reach * reach * (room[c, 0] + room[c, 1]) / contacts
    left = max(min(1.0, max(ahead / gap, 0.0)) ** 3, min(1.0, 0.3 * undone / gap))
    return max(left, 1e-6 if step > 0.2 else (0.5 if step > 0.05 else 1.0))


@kernel()
def take_impulse(p, friction, impulse, size_m):
    """impulse = p, without a tangential part where there is no friction."""
    for c in range(len(friction)):
        for i in range(len(size_m)):
            impulse[c, i] = p[c, i] if i == 0 or friction[c] > 0.0 else 0.0


@kernel()
def advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m):
    """Go a share of the direction; ``impulse`` gets p, without friction where there is none."""
    for c in range(len(friction)):
        gamma[c] += step * dgamma[c]
        for i in range(len(size_m)):
            w[c, i] += step * dw[c, i]
            p[c, i] += step * dp[c, i]
    take_impulse(p, friction, impulse, size_m)


@kernel()
def stiffness_after(step, stiffness):
    """Long steps can do with stiffer contacts, short ones need softer."""
    if step > 0.5:
        return min(4.0 * stiffness, STIFFEST)
    return max(0.25 * stiffness, 1.0) if step < 0.1 else stiffness


@kernel()
def begin_inside(
    inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, u, push, w, p, gamma, size_m, size_n
):
    """The start: fill w, p and gamma from inside the cones, at a distance from their walls, v with the velocities of the impulses.

    u (C, m) and push (bodies + 1, n) are room. Returns the size of the problem, the shift, and the natural map error of the impulses.
    """
    copy_flat(free, v)
    relative_velocity(jacobian, index, offset, v, u, size_m, size_n)
    size, shift = size_of(u, d), distance * largest(u)
    body_velocity(inverse, free, jacobian, index, impulse, push, v, size_m, size_n)
    error = map_norm(jacobian, index, offset, friction, compliance, d, impulse, v, size_m, size_n) / size
    relative_velocity(jacobian, index, offset, v, u, size_m, size_n)
    for c in range(len(mu)):
        gamma[c] = central_start(impulse[c], u[c], mu[c], d[c], shift, w[c], p[c], len(size_m))
    return size, shift, error
