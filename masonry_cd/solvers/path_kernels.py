"""The central path followed by its length over bodies; see interior.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.operators import (
    add_generalised_impulse,
    body_velocity,
    contact_scales,
    in_order,
    map_norm,
    missing_momentum,
    put_back,
    relative_velocity,
)
from masonry_cd.jit import kernel
from masonry_cd.linalg.inertia import determinant_sign
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.solvers.central_path import (
    begin_inside,
    complementarity,
    interior_direction,
    linearise_products,
    longest_step,
    take_impulse,
)
from masonry_cd.solvers.newton_kernels import augment_blocks


@kernel()
def way_product(a, b, w, p, gamma, mu, size_m):
    """Inner product of two changes (dw, dp, dgamma), each relative to what it changes, mean over the contacts."""
    m, total = len(size_m), 0.0
    for c in range(len(mu)):
        slide, bound = 1.0 / gamma[c], 1.0 / (mu[c] * p[c, 0])
        total += a[0][c, 0] * b[0][c, 0] / (w[c, 0] * w[c, 0]) + a[1][c, 0] * b[1][c, 0] / (p[c, 0] * p[c, 0])
        total += a[2][c] * b[2][c] * slide * slide
        for i in range(1, m):
            total += a[0][c, i] * b[0][c, i] * slide * slide + a[1][c, i] * b[1][c, i] * bound * bound
    return total / len(mu)


@kernel()
def combine(x, a, y, b, z, out):
    """out = x + a y + b z, for arrays of any shape."""
    x, y, z, out = x.reshape(x.size), y.reshape(y.size), z.reshape(z.size), out.reshape(out.size)
    for i in range(len(out)):
        out[i] = x[i] + a * y[i] + b * z[i]


@kernel()
def combine_ways(x, a, y, b, z, out):
    """The same for changes of (w, p, gamma, v)."""
    combine(x[0], a, y[0], b, z[0], out[0])
    combine(x[1], a, y[1], b, z[1], out[1])
    combine(x[2], a, y[2], b, z[2], out[2])
    combine(x[3], a, y[3], b, z[3], out[3])


@kernel()
def step_ahead(w, p, gamma, mu, back, tangent, bend, drop, sign, curve, wide, tau, level, way, trial, size_m):
    """way = back + h tangent + h^2 bend with the largest h that stays inside the cones and near the path.

    The change of tau goes along, tau drop + h sign + h^2 curve. Near: no product of a contact is off tau times its level by more than
    ``wide`` times that. trial (k,) is room. Returns the relative change of tau.
    """
    m, h = len(size_m), 2.0 if sign > 0.0 else 0.97
    for _ in range(40):
        combine_ways(back, h * sign, tangent, h * h, bend, way)
        change = drop + h * sign + h * h * curve
        if change > -0.98 and longest_step(w, p, gamma, mu, way[0], way[1], way[2], size_m) > 1.02:
            off = 0.0
            for c in range(len(mu)):
                complementarity(w[c] + way[0][c], p[c] + way[1][c], gamma[c] + way[2][c], mu[c], m, trial)
                off = max(off, off_path(trial, tau * (1.0 + change) * level[c]))
            if off < wide:
                break
        h *= 0.75
    return change


@kernel()
def off_path(product, goal):
    """How far the products of a contact are from goal (1, e), relative to goal."""
    across = (product[1] - goal) ** 2
    for i in range(2, len(product)):
        across += product[i] * product[i]
    return max(abs(product[0] - goal), np.sqrt(across)) / goal


@kernel()
def path_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, friction, compliance, order, plan, index, spot, impulse, v_out, distance,
    stiffness, wide, tolerance, limit, size_m, size_n, size_k,
):  # fmt: skip
    """The central path followed by its length over a FrictionProblem, see solvers/interior.py. impulse holds the start and then the best.

    size_k is a tuple of m + 1 zeros. Returns iterations and natural map error.
    """
    count, m, n, k, contacts = len(order), len(size_m), len(size_n), len(size_k), len(friction)
    inverse, mass, free = in_order(inverse_mass, v_free, order, size_n)
    d = contact_scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, own_v = np.zeros((count + 1, n)), np.zeros((count + 1, n))
    momentum, still = np.empty((count + 1, n)), np.zeros((count + 1, n))
    miss, far, soft = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma, level = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts), np.empty(contacts)
    ways = [(np.zeros((contacts, m)), np.zeros((contacts, m)), np.zeros(contacts), np.zeros((count + 1, n))) for _ in range(4)]
    back, tangent, bend, way = ways[0], ways[1], ways[2], ways[3]
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work, trial = np.empty((contacts, k, k)), np.empty((3, k, k)), np.empty(k)
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = allocate_factors(plan, size_n)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    # start: a point on the path at tau = 1, where w is off by far
    size, shift, smallest = begin_inside(
        inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, miss, momentum, w, p, gamma,
        size_m, size_n,
    )  # fmt: skip
    best, best_v = impulse.copy(), v.copy()
    for c in range(contacts):
        level[c] = shift * shift / d[c]
    body_velocity(inverse, free, jacobian, index, p, momentum, v, size_m, size_n)
    relative_velocity(jacobian, index, offset, v, far, size_m, size_n)
    for c in range(contacts):
        for i in range(m):
            own = compliance[c, i] if len(compliance) else 0.0
            soft[c, i] = own + d[c] / stiffness
            far[c, i] += own * p[c, i] - w[c, i]
    tau, iterations = 1.0, 0
    while iterations < limit and smallest > tolerance:
        iterations += 1
        relative_velocity(jacobian, index, offset, v, miss, size_m, size_n)
        regular = True
        for c in range(contacts):
            for i in range(m):
                own = compliance[c, i] if len(compliance) else 0.0
                miss[c, i] += own * p[c, i] - w[c, i] - tau * far[c, i]
            complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            regular = linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
        augment_blocks(mass, jacobian, index, spot, gain, diagonal, lower, upper, size_m, size_n)
        if not regular or not factorise_ldu(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n):
            break
        sign = -determinant_sign(plan, factors[0], size_n)  # of the change of tau on the way
        # back to the path with tau held; the tangent, by d(log tau); and how it bends
        missing_momentum(mass, free, v, momentum, size_n)
        add_generalised_impulse(jacobian, index, p, momentum, size_m, size_n)
        for turn in range(3):
            for c in range(contacts):
                if turn == 2:
                    complementarity(tangent[0][c], tangent[1][c], tangent[2][c], mu[c], m, wanted[c])
                for i in range(k):
                    goal = tau * level[c] if i < 2 else 0.0
                    wanted[c, i] = goal - product[c, i] if turn == 0 else (goal if turn == 1 else -wanted[c, i])
                for i in range(m):
                    if turn > 0:
                        miss[c, i] = -tau * far[c, i] if turn == 1 else 0.0
            dw, dp, dgamma, out = ways[turn]
            interior_direction(
                momentum if turn == 0 else still, jacobian, index, wanted, undo, gain, miss, soft, plan, factors, out, dw, dp, dgamma,
                size_m, size_n, size_k,
            )  # fmt: skip
        # both corrections across the tangent: this is what lets the path turn back
        length = 1.0 + way_product(tangent, tangent, w, p, gamma, mu, size_m)
        drop = -way_product(back, tangent, w, p, gamma, mu, size_m) / length
        curve = -way_product(bend, tangent, w, p, gamma, mu, size_m) / length
        combine_ways(back, drop, tangent, 0.0, tangent, back)
        combine_ways(bend, curve, tangent, 0.0, tangent, bend)
        longest = 0.9 * longest_step(w, p, gamma, mu, back[0], back[1], back[2], size_m)
        if longest < 1.0:  # back to the path first
            change = longest * drop
            combine_ways(back, longest - 1.0, back, 0.0, back, way)
        else:
            change = step_ahead(w, p, gamma, mu, back, tangent, bend, drop, sign, curve, wide, tau, level, way, trial, size_m)
        here = (w, p, gamma, v)
        combine_ways(here, 1.0, way, 0.0, way, here)
        tau *= 1.0 + change
        take_impulse(p, friction, impulse, size_m)
        body_velocity(inverse, free, jacobian, index, impulse, momentum, own_v, size_m, size_n)
        error = map_norm(jacobian, index, offset, friction, compliance, d, impulse, own_v, size_m, size_n) / size
        if error < smallest:
            smallest = error
            copy_flat(impulse, best)
            copy_flat(own_v, best_v)
        if not error < np.inf:
            break
    copy_flat(best, impulse)
    put_back(best_v, order, v_out)
    return iterations, smallest
