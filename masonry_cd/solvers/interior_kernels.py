"""The interior point method over bodies, and the four methods that linearise the law behind one entry; see interior.py."""

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
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.inertia import determinant_sign
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.solvers.central_path import (
    advance,
    begin_inside,
    centring_share,
    complementarity,
    corrector_rhs,
    interior_direction,
    linearise_products,
    longest_step,
    stiffness_after,
)
from masonry_cd.solvers.newton_kernels import augment_blocks, newton_bodies
from masonry_cd.solvers.path_kernels import path_bodies
from masonry_cd.solvers.proximal_kernels import proximal_bodies

NEWTON, INTERIOR, PATH, PROXIMAL = 0, 1, 2, 3  # methods that linearise the law


@kernel()
def interior_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, friction, compliance, order, plan, index, spot, impulse, v_out, distance,
    stiffness, tolerance, limit, size_m, size_n, size_k,
):  # fmt: skip
    """Interior point method over a FrictionProblem, see solvers/interior.py. impulse holds the start and then the best answer found.

    size_k is a tuple of m + 1 zeros. Returns iterations and natural map error.
    """
    count, m, n, k, contacts = len(order), len(size_m), len(size_n), len(size_k), len(friction)
    inverse, mass, free = in_order(inverse_mass, v_free, order, size_n)
    d = contact_scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, own_v, momentum = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.zeros((count + 1, n)), np.empty((count + 1, n))
    u, soft = np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    dw, dp, dgamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work = np.empty((contacts, k, k)), np.empty((3, k, k))
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = allocate_factors(plan, size_n)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    size, _, smallest = begin_inside(
        inverse, free, jacobian, index, offset, friction, compliance, d, mu, distance, impulse, v, u, out, w, p, gamma, size_m, size_n
    )
    best, best_v = impulse.copy(), v.copy()
    step, iterations, short = 1.0, 0, 0
    while iterations < limit and smallest > tolerance and short < 6:
        iterations += 1
        relative_velocity(jacobian, index, offset, v, u, size_m, size_n)
        gap, undone, regular = 0.0, 0.0, True
        for c in range(contacts):
            for i in range(m):
                own = compliance[c, i] if len(compliance) else 0.0
                soft[c, i] = own + d[c] / stiffness
                u[c, i] += own * p[c, i] - w[c, i]  # what w misses
                undone += abs(u[c, i] * p[c, i]) / contacts
            complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            gap += 0.5 * (product[c, 0] + product[c, 1]) / contacts
            regular = linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
        augment_blocks(mass, jacobian, index, spot, gain, diagonal, lower, upper, size_m, size_n)
        regular = regular and factorise_ldu(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n)
        if not (gap > 0.0 and regular):
            break
        if determinant_sign(plan, factors[0], size_n) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        missing_momentum(mass, free, v, momentum, size_n)
        add_generalised_impulse(jacobian, index, p, momentum, size_m, size_n)
        # predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out
        centring, longest = 0.0, 0.0
        for turn in range(3):
            if turn == 2 and longest >= 0.1:
                break
            corrector_rhs(dw, dp, dgamma, mu, product, centring * gap, turn == 1, wanted, size_m, size_k)
            interior_direction(
                momentum, jacobian, index, wanted, undo, gain, u, soft, plan, factors, out, dw, dp, dgamma, size_m, size_n, size_k
            )
            longest = longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m)
            if turn == 0:
                centring = centring_share(dw, dp, dgamma, mu, product, gap, undone, longest, step, wanted, size_m)
        step = min(1.0, 0.99 * longest)
        advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m)
        for b in range(count):
            for i in range(n):
                v[b, i] += step * out[b, i]
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        body_velocity(inverse, free, jacobian, index, impulse, out, own_v, size_m, size_n)
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


@entry()
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
