"""Proximal points over bodies; see interior.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import OPEN, SLIP, STICK, tangent_length
from masonry_cd.friction.natural_map import size_of
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
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.central_path import STIFFEST
from masonry_cd.solvers.newton_kernels import augment_blocks

FREE, HELD = np.bool_(False), np.bool_(True)  # whether a status may change; for plain False and True numba would compile the code twice


@kernel(inline="always")
def softness(compliance, scale, c, m):
    """Compliance of the springs of contact c along and across the normal: the proximal one and the contact's own."""
    if len(compliance):
        return scale + compliance[c, 0], scale + max(compliance[c, 1], compliance[c, m - 1])
    return scale, scale


@kernel()
def spring_residual(model, mu, compliance, d, stiffness, centre, v, held, status, x, p, out, size_m, size_n):
    """Trial impulses x and impulses p of the springs at velocities v, and out = M (v_free - v) + H^T p; returns its norm in M^-1.

    model holds the mass, its inverse, v_free, H by contact, the places of the bodies and b. The status of the contacts follows x, or is
    held as it is.
    """
    mass, inverse, free, jacobian, index, offset = model
    m, n = len(size_m), len(size_n)
    relative_velocity(jacobian, index, offset, v, x, size_m, size_n)
    for c in range(len(mu)):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - x[c, i]) / soft
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        if not held:
            status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
        share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
        for i in range(m):
            p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])
    missing_momentum(mass, free, v, out, size_n)
    add_generalised_impulse(jacobian, index, p, out, size_m, size_n)
    out[-1] = 0.0
    total = 0.0
    for b in range(len(mass)):
        for i in range(n):
            for j in range(n):
                total += out[b, i] * inverse[b, i, j] * out[b, j]
    return np.sqrt(max(total, 0.0))


@kernel()
def spring_blocks(mu, compliance, d, stiffness, status, x, blocks, size_m):
    """B = -dp/du of the springs."""
    m = len(size_m)
    blocks[:] = 0.0
    for c in range(len(mu)):
        if status[c] == OPEN:
            continue
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        blocks[c, 0, 0] = 1.0 / soft_n
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        share = mu[c] * max(x[c, 0], 0.0) / length if length > 0.0 else 1.0
        for i in range(1, m):
            if status[c] == STICK:
                blocks[c, i, i] = 1.0 / soft_t
            elif length > 0.0:
                blocks[c, i, 0] = mu[c] * x[c, i] / (length * soft_n)
                for j in range(1, m):  # zero in a plane
                    across = (1.0 if i == j else 0.0) - x[c, i] * x[c, j] / (length * length)
                    blocks[c, i, j] = min(share, 1.0) / soft_t * across


@kernel()
def spring_changes(jacobian, index, compliance, d, stiffness, change, dx, size_m, size_n):
    """Change of the trial impulses with the velocities."""
    m, n = len(size_m), len(size_n)
    for c in range(len(d)):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            total = 0.0
            for k in range(n):
                total += jacobian[c, 0, i, k] * change[index[c, 0], k] + jacobian[c, 1, i, k] * change[index[c, 1], k]
            dx[c, i] = -total / (soft_n if i == 0 else soft_t)


@entry()
def first_change(mu, status, x, dx, size_m):
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


@kernel()
def add_step(v, step, change, size_n, out):
    """out = v + step change."""
    for b in range(len(v)):
        for i in range(len(size_n)):
            out[b, i] = v[b, i] + step * change[b, i]


@kernel()
def proximal_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, tolerance, limit, size_m,
    size_n,
):  # fmt: skip
    """Proximal points over a FrictionProblem, see solvers/interior.py. p holds the start and then the best answer found.

    Returns iterations (one factorisation each) and natural map error.
    """
    count, m, n, contacts = len(order), len(size_m), len(size_n), len(mu)
    inverse, mass, free = in_order(inverse_mass, v_free, order, size_n)
    left, slip = np.empty((count, n)), np.empty((contacts, m))
    model = (mass, inverse, left, jacobian, index, slip)  # of the change of velocity from that of the centre, which rounding spares
    d = contact_scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, change, trial = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.zeros((count + 1, n)), np.zeros((count + 1, n))
    x, dx, blocks = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m, m))
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    factors = allocate_factors(plan, size_n)
    status, held = np.zeros(contacts, dtype=np.int64), np.zeros(contacts, dtype=np.int64)
    copy_flat(free, v)
    relative_velocity(jacobian, index, offset, v, x, size_m, size_n)
    size = size_of(x, d)
    body_velocity(inverse, free, jacobian, index, p, out, v, size_m, size_n)
    smallest = error = map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
    best, best_v, centre, centre_v, own_v = p.copy(), v.copy(), p.copy(), v.copy(), v.copy()
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed = 0, 0
    while iterations < limit and smallest > tolerance and failed < 8:
        # the springs' problem to a hundredth of the error, from the centre
        goal = size * max(1e-2 * error, 1e-3 * tolerance)
        add_step(free, -1.0, centre_v, size_n, left)
        relative_velocity(jacobian, index, offset, centre_v, slip, size_m, size_n)
        add_step(centre_v, -1.0, centre_v, size_n, v)
        norm = spring_residual(model, mu, compliance, d, stiffness, centre, v, FREE, status, x, p, out, size_m, size_n)
        begun, turned, last = iterations, 0, -1
        while norm > goal and iterations < min(limit, begun + 25) and turned < 3:
            spring_blocks(mu, compliance, d, stiffness, status, x, blocks, size_m)
            augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n)
            iterations += 1
            if not factorise_ldu(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_n):
                break
            solve_ldu(plan, factors[0], factors[1], factors[2], out, size_n)
            copy_flat(out[:count], change)
            step, new = 2.0, np.inf
            copy_flat(status, held)
            while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
                step *= 0.5
                add_step(v, step, change, size_n, trial)
                new = spring_residual(model, mu, compliance, d, stiffness, centre, trial, FREE, status, x, p, out, size_m, size_n)
            if new < (1.0 - 0.1 * step) * norm:
                copy_flat(trial, v)
                norm, last, turned = new, -1, 0
                continue
            # no progress across the kinks: as far as the first of them, and the contact there changes its status
            copy_flat(held, status)
            spring_residual(model, mu, compliance, d, stiffness, centre, v, HELD, status, x, p, out, size_m, size_n)
            spring_changes(jacobian, index, compliance, d, stiffness, change, dx, size_m, size_n)
            step, which, other = first_change(mu, status, x, dx, size_m)
            if step < 1.0:
                turned = turned + 1 if which == last and step < 1e-9 else 0
                status[which], last = other, which
            add_step(v, min(step, 0.5) if step >= 1.0 else step, change, size_n, v)
            norm = spring_residual(model, mu, compliance, d, stiffness, centre, v, HELD, status, x, p, out, size_m, size_n)
        solved, spent = norm <= goal, iterations - begun
        body_velocity(inverse, free, jacobian, index, p, out, own_v, size_m, size_n)
        new = map_norm(jacobian, index, offset, mu, compliance, d, p, own_v, size_m, size_n) / size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        if not solved:
            stiffness *= 0.25
        elif spent <= 8:
            stiffness *= 16.0 if new > 0.5 * error and spent < 4 else 4.0
        error, failed = new, 0
        stiffness = min(stiffness, STIFFEST)
        copy_flat(p, centre)
        add_step(centre_v, 1.0, v, size_n, centre_v)
        if error < smallest:
            smallest = error
            copy_flat(p, best)
            copy_flat(own_v, best_v)
    copy_flat(best, p)
    put_back(best_v, order, v_out)
    return iterations, smallest
