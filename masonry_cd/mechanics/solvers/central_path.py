# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts common to the interior point method and the path by its length: the products of a contact, their linearisation, and steps in the
cones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import NARROWEST, has_friction, tangent_length
from masonry_cd.mechanics.friction.operators import add_impulse
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.linearised import contact_velocity, keep_better, law_velocity, map_norm, solve_by_first
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, chunk_of, copy_share, least_of_chunks, sum_of_chunks

LONGEST = 2.0  # step: more than one is not made


class Cones(NamedTuple):
    """The cones of the contacts."""

    mu: np.ndarray  # (C,) friction, nowhere zero: a cone without width has no inside
    m: tuple[int, ...]  # m zeros


class Iterate(NamedTuple):
    """A point inside the cones, or a direction in which to move it."""

    w: np.ndarray  # (C, m)
    p: np.ndarray  # (C, m)
    gamma: np.ndarray  # (C,) sliding speeds
    v: np.ndarray  # (B + 1, n) body velocities


class Linearisation(NamedTuple):
    """The products of each contact at a point and their linearisation, see :func:`linearise_contact`."""

    here: Iterate  # the point
    product: np.ndarray  # (C, m + 1) w_n p_n and (gamma, w_t) o (mu p_n, p_t)
    wanted: np.ndarray  # (C, m + 1) their changes
    pivot: np.ndarray  # (C, m + 1) reciprocals that solve for dp and dgamma
    gain: np.ndarray  # (C, m, m) dp falls by so much of the change of H v
    soft: np.ndarray  # (C, m) compliance of the spring in series, the contact's own and that of the damping
    miss: np.ndarray  # (C, m) H v + b + C p - w, and on the path by its length less tau times that of the start
    far: np.ndarray  # (C, m) that of the start, zero without such a path


class Directions(NamedTuple):
    """The directions of a step; the interior point method has the last alone."""

    back: Iterate  # to the path, with tau held
    tangent: Iterate  # by d(log tau)
    bend: Iterate  # second order
    ahead: Iterate  # the step


class InteriorWorkspace(NamedTuple):
    """Workspace of both methods."""

    impulse: np.ndarray  # (C, m) those of the iterate, admissible where there is no friction
    v: np.ndarray  # (B + 1, n) their velocities
    here: Iterate
    linear: Linearisation
    directions: Directions


@kernel()
def cones_of(problem):
    """The :class:`Cones` of the contacts."""
    return Cones(np.maximum(problem.mu, NARROWEST), problem.m)


@kernel()
def allocate_iterate(arena, shape, rows):
    """An :class:`Iterate` of zeros for contacts (C, m) and velocities of a shape."""
    return Iterate(take(arena, shape), take(arena, shape), take(arena, shape[:1]), take(arena, rows))


@kernel()
def allocate_interior(arena, shape, rows):
    """:class:`InteriorWorkspace` of zeros for contacts (C, m) and velocities of a shape."""
    (contacts, m), here = shape, allocate_iterate(arena, shape, rows)
    product, wanted, pivot = take(arena, (contacts, m + 1)), take(arena, (contacts, m + 1)), take(arena, (contacts, m + 1))
    gain = take(arena, (contacts, m, m))
    linear = Linearisation(here, product, wanted, pivot, gain, take(arena, shape), take(arena, shape), take(arena, shape))
    back, tangent = allocate_iterate(arena, shape, rows), allocate_iterate(arena, shape, rows)
    directions = Directions(back, tangent, allocate_iterate(arena, shape, rows), allocate_iterate(arena, shape, rows))
    return InteriorWorkspace(take(arena, shape), take(arena, rows), here, linear, directions)


@kernel(inline="always")
def are_inside(w, p, gamma, mu, m):
    """Return True if w and p (m,) and the sliding speed of a contact are inside their cones."""
    bound, w2, p2 = mu * p[0], w[2] if m == 3 else 0.0, p[2] if m == 3 else 0.0
    slides, holds = w[1] * w[1] + w2 * w2 < gamma * gamma, p[1] * p[1] + p2 * p2 < bound * bound
    return w[0] > 0.0 and p[0] > 0.0 and gamma > 0.0 and slides and holds


@borrower()
def max_step_to_cone(x0: float, x1: float, x2: float, d0: float, d1: float, d2: float) -> float:
    """Largest step from x inside the second-order cone along d that stays inside, at most 1e10."""
    best, t = -x0 / d0 if d0 < 0.0 else 1e10, tangent_length(x1, x2)
    a, b, c = d0 * d0 - d1 * d1 - d2 * d2, x0 * d0 - x1 * d1 - x2 * d2, max((x0 - t) * (x0 + t), 0.0)  # c does not cancel
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
def linearise_contact(w, p, gamma, mu, soft, pivot, gain, size_m):
    """Fill pivot (m + 1,) and gain (m, m) of one contact, see :class:`Linearisation`; False if they do not exist.

    The products change with x = (dp, dgamma), dw = soft dp + z, by rows that are an arrow,

        a x_0 + p_0 z_0,     b x_0 + sum (e_i x_i + p_i z_i) + f x_m,     g_i x_0 + d_i x_i + h_i x_m + f z_i,     i = 1 .. m - 1,

    where a and d_i are positive inside the cones: x_0 comes from the first row, x_i from its own, and x_m from the one that is left.
    """
    m, a, f = len(size_m), w[0] + p[0] * soft[0], mu * p[0]
    left = f
    pivot[0] = 1.0 / a
    for i in range(1, m):
        pivot[i] = 1.0 / (gamma + f * soft[i])
        left -= (w[i] + p[i] * soft[i]) * pivot[i] * p[i]
    pivot[m] = 1.0 / left
    for j in range(m):
        first = p[0] * pivot[0] if j == 0 else 0.0
        turn = (p[j] if j > 0 else 0.0) - gamma * mu * first
        for i in range(1, m):
            gain[i, j] = (f if i == j else 0.0) - mu * w[i] * first
            turn -= (w[i] + p[i] * soft[i]) * pivot[i] * gain[i, j]
        turn *= pivot[m]
        gain[0, j] = first
        for i in range(1, m):
            gain[i, j] = (gain[i, j] - p[i] * turn) * pivot[i]
    return 0.0 < a < np.inf and 0.0 < abs(left) < np.inf


@kernel(inline="always")
def change_contact(linear, mu, c, direction, m):
    """dp and dgamma of contact c, and dw from z, which is in its place; see :func:`linearise_contact`."""
    (w, p, gamma, _), wanted, pivot, soft, x, z = linear.here, linear.wanted, linear.pivot, linear.soft, direction.p, direction.w
    f, first = mu * p[c, 0], (wanted[c, 0] - p[c, 0] * z[c, 0]) * pivot[c, 0]
    turn = wanted[c, 1] - gamma[c] * mu * first
    x[c, 0] = first
    for i in range(1, m):
        x[c, i] = wanted[c, 1 + i] - f * z[c, i] - mu * w[c, i] * first
        turn -= p[c, i] * z[c, i] + (w[c, i] + p[c, i] * soft[c, i]) * pivot[c, i] * x[c, i]
    turn *= pivot[c, m]
    direction.gamma[c] = turn
    z[c, 0] += soft[c, 0] * first
    for i in range(1, m):
        x[c, i] = (x[c, i] - p[c, i] * turn) * pivot[c, i]
        z[c, i] += soft[c, i] * x[c, i]


@borrower()
def linearise_products(shares, cones, linear):
    """Fill the products of the contacts and their linearisation.

    Returns how far the products are from zero, the gap tau, and what w misses in its units, both as means over the contacts; the gap is
    not a number if a contact cannot be solved for its impulse.
    """
    m, contacts, turn, (first, end), here = len(cones.m), len(cones.mu), begin_sums(shares), shares.chunks, linear.here
    for k in range(first, end):
        gap, undone = 0.0, 0.0
        begin, stop = chunk_of(k, contacts)
        for c in range(begin, stop):
            w, p, gamma, mu = here.w[c], here.p[c], here.gamma[c], cones.mu[c]
            complementarity(w, p, gamma, mu, m, linear.product[c])
            gap += 0.5 * (linear.product[c, 0] + linear.product[c, 1])
            if not linearise_contact(w, p, gamma, mu, linear.soft[c], linear.pivot[c], linear.gain[c], cones.m):
                gap = np.nan
            for i in range(m):
                undone += abs(linear.miss[c, i] * p[i])
        shares.sums[turn, 0, k], shares.sums[turn, 1, k] = gap, undone
    wait(shares.team)
    return sum_of_chunks(shares, 0, contacts) / contacts, sum_of_chunks(shares, 1, contacts) / contacts


@borrower()
def set_damping(shares, problem, stiffness, linear):
    """The springs in series with the products, C + d / K."""
    compliance, d, soft, (first, end) = problem.compliance, problem.d, linear.soft, shares.contacts
    for c in range(first, end):
        for i in range(len(problem.m)):
            soft[c, i] = (compliance[c, i] if len(compliance) else 0.0) + d[c] / stiffness


@borrower()
def missing_velocity(shares, problem, here, tau, linear):
    """Return the residual of w, H v + b + C p - w - tau far."""
    compliance, miss, far, (first, end) = problem.compliance, linear.miss, linear.far, shares.contacts
    law_velocity(shares, problem, here.v, miss)
    for c in range(first, end):
        for i in range(len(problem.m)):
            own = compliance[c, i] if len(compliance) else 0.0
            miss[c, i] += own * here.p[c, i] - here.w[c, i] - tau * far[c, i]


@kernel()
def interior_direction(shares, problem, work, cones, linear, direction):
    """The direction that changes the products as wanted and takes all other residuals away.

    The factors are those of M + H^T B H with B the gains; ``work.scratch`` has H^T p - M (v - v_free).
    """
    (begin, stop), (first, end) = shares.rows, shares.contacts
    direction.w[first:end] = 0.0
    change_contacts(shares, cones, linear, direction)  # dp as long as the velocities do not change
    copy_share(shares.rows, work.scratch, direction.v)
    wait(shares.team)
    add_impulse(problem, direction.p, begin, stop, direction.v)
    solve_by_first(shares, work.factor, direction.v)
    contact_velocity(shares, problem, direction.v, direction.w)
    change_contacts(shares, cones, linear, direction)


@borrower()
def change_contacts(shares, cones, linear, direction):
    """dp, dgamma and dw of a direction from the change of the velocities of the contacts, which is in the place of dw."""
    first, end = shares.contacts
    for c in range(first, end):
        for i in range(len(cones.m)):
            direction.w[c, i] += linear.miss[c, i]
        change_contact(linear, cones.mu[c], c, direction, len(cones.m))


@borrower()
def contact_step(w, p, gamma, dw, dp, dgamma, mu, m):
    """Largest step along a direction that keeps one contact inside its cones, at most 1e10; vectors (m,)."""
    longest = -w[0] / dw[0] if dw[0] < 0.0 else 1e10
    w2, p2, dw2, dp2 = (w[2], p[2], dw[2], dp[2]) if m == 3 else (0.0, 0.0, 0.0, 0.0)
    longest = min(longest, max_step_to_cone(gamma, w[1], w2, dgamma, dw[1], dw2))
    return min(longest, max_step_to_cone(mu * p[0], p[1], p2, mu * dp[0], dp[1], dp2))


@borrower()
def allows_step(w, p, gamma, dw, dp, dgamma, mu, step, m):
    """Return True if a step along a direction keeps one contact inside its cones; vectors (m,)."""
    w2, p2 = (w[2] + step * dw[2], p[2] + step * dp[2]) if m == 3 else (0.0, 0.0)
    moved_w, moved_p = (w[0] + step * dw[0], w[1] + step * dw[1], w2), (p[0] + step * dp[0], p[1] + step * dp[1], p2)
    return are_inside(moved_w, moved_p, gamma + step * dgamma, mu, m)


@borrower()
def longest_step(shares, here, direction, cones):
    """Largest step along a direction that keeps every contact inside its cones, at most LONGEST.

    Cones are convex: a contact that allows the longest so far need not compute its own, which costs roots and divisions.
    """
    (w, p, gamma, _), (dw, dp, dgamma, _), m, mu = here, direction, len(cones.m), cones.mu
    turn, (first, end) = begin_sums(shares), shares.chunks
    for k in range(first, end):
        longest = LONGEST
        begin, stop = chunk_of(k, len(mu))
        for c in range(begin, stop):
            if not allows_step(w[c], p[c], gamma[c], dw[c], dp[c], dgamma[c], mu[c], longest, m):
                longest = min(longest, contact_step(w[c], p[c], gamma[c], dw[c], dp[c], dgamma[c], mu[c], m))
        shares.sums[turn, 0, k] = longest
    wait(shares.team)
    return least_of_chunks(shares, len(mu))[0]


@kernel()
def keep_if_better(shares, problem, work, workspace, answer):
    """Take where a method is as the answer if its error is less; returns the error. Without friction there is no tangential impulse."""
    p, impulse, friction, (first, end) = workspace.here.p, workspace.impulse, problem.mu, shares.contacts
    for c in range(first, end):
        for i in range(len(problem.m)):
            impulse[c, i] = p[c, i] if i == 0 or has_friction(friction[c]) else 0.0
    error = map_norm(shares, problem, impulse, work.scratch, workspace.v) / answer.size
    keep_better(shares, answer, impulse, workspace.v, error)
    return error


@borrower()
def advance(shares, x, step, direction, out):
    """out = x + step direction, for a point or direction x and a direction."""
    add_share(shares.contacts, x.w, step, direction.w, out.w)
    add_share(shares.contacts, x.p, step, direction.p, out.p)
    add_share(shares.contacts, x.gamma, step, direction.gamma, out.gamma)
    add_share(shares.rows, x.v, step, direction.v, out.v)


@borrower()
def start_inside_cones(shares, problem, answer, cones, distance, here, u):
    """The start: w, p and gamma inside the cones, near the answer, and v its velocities; u (C, m) are those of the contacts.

    Returns the distance from the walls as a speed, ``distance`` times the largest without impulses.
    """
    shift, impulse, m, (first, end) = distance * answer.speed, answer.impulse, len(cones.m), shares.contacts
    copy_share(shares.rows, answer.velocity, here.v)
    for c in range(first, end):
        here.gamma[c] = central_start(impulse[c], u[c], cones.mu[c], problem.d[c], shift, here.w[c], here.p[c], m)
    return shift
