"""What an ADMM iteration does in a subtree: forward substitution after a pass over its contacts, and backward substitution; see admm.py."""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.friction.coulomb_law import tangent_length
from masonry_cd.mechanics.friction.joint_twists import add_to_wrench, add_wrench, twist_of, velocity_at
from masonry_cd.mechanics.friction.natural_map import project_stretched, project_to_cone, squared_residual
from masonry_cd.mechanics.friction.operators import missing_momentum_of, unknowns_at
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of
from masonry_cd.mechanics.linalg.intrinsics import prefetch
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.triangular import backward_substitution, forward_substitution


@borrower()
def eliminate_subtree(work, q, coming, relaxation, p, new, line):
    """The contacts of subtree q, p to new (C, m), and L^-1 of the momentum that they leave; returns the squared scaled change of p.

    ``coming`` is the subtree of the next backward substitution, or -1; ``line`` is room for :func:`longest_line` numbers.
    """
    problem, symbolic, panels = work.problem, work.factor.symbolic, work.factor.panels
    v, momentum, x = work.iterates.v, work.iterates.momentum, work.iterates.correction
    first, last = nodes_of(symbolic, q)
    missing_momentum_of(problem, v, first, last, momentum)
    clear_ghosts(symbolic, q, momentum)
    add_ghosts(symbolic, q, momentum)
    ahead = panels_of(symbolic, coming, len(problem.n)) if coming >= 0 else (0, 0)
    change = meet_contacts(work, q, relaxation, p, new, ahead)
    copy_flat(momentum[first:last], x[first:last])
    clear_ghosts(symbolic, q, x)
    add_ghosts(symbolic, q, x)
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    forward_substitution(symbolic, begin, end, symbolic.target, panels, x, line, problem.n)
    return change


@borrower()
def update_subtree(work, q, relaxation, line):
    """v <- v + relaxation L^-T D^-1 x for the bodies of subtree q, x from :func:`eliminate_subtree`, after all later subtrees."""
    symbolic, size_n = work.factor.symbolic, work.problem.n
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    backward_substitution(symbolic, begin, end, work.factor.squares, work.factor.panels, work.iterates.correction, line, size_n)
    first, last = nodes_of(symbolic, q)
    size = (last - first) * len(size_n)
    v, x = work.iterates.v[first:last].reshape(size), work.iterates.correction[first:last].reshape(size)
    for i in range(size):
        v[i] += relaxation * x[i]


@borrower()
def panels_of(symbolic, q, n):
    """First entry and end of the panels of subtree q, one of several: they are stored from its last supernode to its first."""
    s = symbolic.subtree[q]
    end = symbolic.panel[s] + (symbolic.first[s + 1] - symbolic.first[s]) * (symbolic.start[s + 1] - symbolic.start[s])
    return n * n * symbolic.panel[symbolic.subtree[q + 1] - 1], n * n * end


@borrower(fastmath={"contract"})
def meet_contacts(work, q, relaxation, p, new, ahead):
    """p+ = P_K(p - S (w + mu |w_t| n)), S^-1 = R^-1 + C, new = p + relaxation (p+ - p), momentum += H^T (2 p+ - p), for subtree q.

    There is more to calculate than to fetch, so the panels between the two entries ``ahead``, which the next backward substitution needs,
    are fetched on the way. Returns the squared scaled change of p.
    """
    problem, partition, rho, panels, joints = work.problem, work.partition, work.factor.rho, work.factor.panels, work.partition.joints
    v, momentum = work.iterates.v, work.iterates.momentum
    offset, mu, compliance, d = problem.offset, problem.mu, problem.compliance, problem.d
    m, place, target = len(problem.m), partition.place, partition.target
    line, end = ahead
    change, count = 0.0, max(partition.joint[q + 1] - partition.joint[q], 1)
    share = (end - line + count - 1) // count
    for g in range(partition.joint[q], partition.joint[q + 1]):
        for entry in range(line, min(line + share, end), 16):
            prefetch(panels, entry)
        line += share
        n = unknowns_at(problem, place[g, 0], place[g, 1])
        twist, wrench = twist_of(joints, g, v, place[g, 0], place[g, 1], n), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for c in range(joints.start[g], joints.start[g + 1]):
            r, (un, u1, u2) = rho[c], velocity_at(joints, twist, c)
            un, u1, pn, p1, p2 = un + offset[c, 0], u1 + offset[c, 1], p[c, 0], p[c, 1], 0.0
            if m == 3:
                u2, p2 = u2 + offset[c, 2], p[c, 2]
            if len(compliance):
                un += compliance[c, 0] * pn
                u1 += compliance[c, 1] * p1
                u2 += compliance[c, m - 1] * p2
                s, r = r / (1.0 + r * max(compliance[c, 1], compliance[c, m - 1])), r / (1.0 + r * compliance[c, 0])
                xn, x1, x2 = project_stretched(pn - r * (un + mu[c] * tangent_length(u1, u2)), p1 - s * u1, p2 - s * u2, mu[c], r / s)
            else:
                xn, x1, x2 = project_to_cone(pn - r * (un + mu[c] * tangent_length(u1, u2)), p1 - r * u1, p2 - r * u2, mu[c])
            new[c, 0], new[c, 1] = pn + relaxation * (xn - pn), p1 + relaxation * (x1 - p1)
            if m == 3:
                new[c, 2] = p2 + relaxation * (x2 - p2)
            change += d[c] * ((xn - pn) * (xn - pn) + (x1 - p1) * (x1 - p1) + (x2 - p2) * (x2 - p2))
            wrench = add_to_wrench(joints, wrench, c, 2.0 * xn - pn, 2.0 * x1 - p1, 2.0 * x2 - p2)
        add_wrench(joints, g, wrench, target[g, 0], target[g, 1], momentum, n)
    return change


@borrower()
def clear_momentum(work, q):
    """No generalised impulse on the bodies of subtree q, nor in its ghost rows."""
    first, last = nodes_of(work.factor.symbolic, q)
    work.iterates.momentum[first:last] = 0.0
    clear_ghosts(work.factor.symbolic, q, work.iterates.momentum)


@borrower()
def add_momentum(work, q, p):
    """momentum += H^T p of the contacts of subtree q."""
    joints, place, target = work.partition.joints, work.partition.place, work.partition.target
    for g in range(work.partition.joint[q], work.partition.joint[q + 1]):
        wrench, n = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), unknowns_at(work.problem, place[g, 0], place[g, 1])
        for c in range(joints.start[g], joints.start[g + 1]):
            wrench = add_to_wrench(joints, wrench, c, p[c, 0], p[c, 1], p[c, 2] if p.shape[1] == 3 else 0.0)
        add_wrench(joints, g, wrench, target[g, 0], target[g, 1], work.iterates.momentum, n)


@borrower(fastmath={"contract"})
def contact_velocity(work, q, v, u):
    """u = H v + b (C, m) of the contacts of subtree q for body velocities v (N + 1, n)."""
    joints, place, offset = work.partition.joints, work.partition.place, work.problem.offset
    for g in range(work.partition.joint[q], work.partition.joint[q + 1]):
        n = unknowns_at(work.problem, place[g, 0], place[g, 1])
        twist = twist_of(joints, g, v, place[g, 0], place[g, 1], n)
        for c in range(joints.start[g], joints.start[g + 1]):
            velocity = velocity_at(joints, twist, c)
            for i in range(len(work.problem.m)):
                u[c, i] = offset[c, i] + velocity[i]


@borrower(fastmath={"contract"})
def squared_map_norm(work, q, p, v):
    """Square of the norm of the natural map residual of the contacts of subtree q, for impulses p (C, m) and velocities v (N + 1, n)."""
    problem, joints, place = work.problem, work.partition.joints, work.partition.place
    offset, compliance, m, total = problem.offset, problem.compliance, len(problem.m), 0.0
    for g in range(work.partition.joint[q], work.partition.joint[q + 1]):
        n = unknowns_at(problem, place[g, 0], place[g, 1])
        twist = twist_of(joints, g, v, place[g, 0], place[g, 1], n)
        for c in range(joints.start[g], joints.start[g + 1]):
            un, u1, u2 = velocity_at(joints, twist, c)
            un, u1, p2 = un + offset[c, 0], u1 + offset[c, 1], 0.0
            if m == 3:
                u2, p2 = u2 + offset[c, 2], p[c, 2]
            if len(compliance):
                un += compliance[c, 0] * p[c, 0]
                u1 += compliance[c, 1] * p[c, 1]
                u2 += compliance[c, m - 1] * p2
            total += squared_residual(p[c, 0], p[c, 1], p2, un, u1, u2, problem.mu[c], problem.d[c])
    return total


@borrower(fastmath={"contract"})
def carry_impulses(work, q, relaxation, last, p):
    """carried = 2 p+ - last - R H (v+ - v), the impulses whose velocities an iteration has found, and momentum += H^T carried.

    For the contacts of subtree q; last (C, m) and p = last + relaxation (p+ - last) are the impulses before and after the iteration.
    """
    partition, joints, rho = work.partition, work.partition.joints, work.factor.rho
    step, carried, place, target = work.iterates.correction, work.iterates.carried, partition.place, partition.target
    for g in range(partition.joint[q], partition.joint[q + 1]):
        n = unknowns_at(work.problem, place[g, 0], place[g, 1])
        twist, wrench = twist_of(joints, g, step, place[g, 0], place[g, 1], n), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for c in range(joints.start[g], joints.start[g + 1]):
            gain = velocity_at(joints, twist, c)
            for i in range(len(work.problem.m)):
                carried[c, i] = last[c, i] + 2.0 / relaxation * (p[c, i] - last[c, i]) - rho[c] * gain[i]
            wrench = add_to_wrench(joints, wrench, c, carried[c, 0], carried[c, 1], carried[c, 2] if carried.shape[1] == 3 else 0.0)
        add_wrench(joints, g, wrench, target[g, 0], target[g, 1], work.iterates.momentum, n)
