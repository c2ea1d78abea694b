r"""Elastic and bonded joints: springs that are implicit in the step, and bonds that break for good.

**Springs.** A contact with a share A of its joint's area carries p_n = h k_n A (-g_w)+ and p_t = -h k_t A s_w, cut by Coulomb's cone.
The gap g and the elastic slip s are taken at the place of the generalised midpoint rule, theta in [1/2, 1]. With states g^, s^ between
two q_m,

    g^1 = g^0 + h (theta u+ + (1 - theta) u),        g_w = theta g^1 + (1 - theta) g^0,

and s^ alike, less the plastic slip theta h w_t. Solved for the velocities u+ at the end of the step this is the contact law of the rigid
joint about w = u + b + C p instead of u, with a = theta^2,

    C = 1 / (a h^2 k A),        b_n = (g^0 + theta (1 - theta) h u_n) / (a h),        b_t = (s^0 + theta (1 - theta) h u_t) / (a h),

so a stiffness limits no time step: for k -> infinity C vanishes. g^0 = g - (1 - theta) h u_n follows from the gap at q_m with its sign;
s^0 is remembered, as a vector that turns with the antagonist (for plasticity by this rule: Simo & Taylor, Int. J. Numer. Methods Eng. 22,
1986). theta = 1/2 is of second order and keeps the energy; above, a mode of circular frequency omega is damped by
(2 theta - 1) omega h / 2, and one too stiff for the step dies out by (1 - theta) / theta per step.

A spring that is only just closing, g^0 > 0, takes theta = 1 on the normal: the average of an open and a closed state would give it energy
that nobody put in. A stiff spring so lands without a bounce, like a rigid contact, and no spring bounces higher than it fell.

**Bonds.** An intact contact of cohesion c carries |p_t| <= mu p_n + h c A: Coulomb's cone about the impulse p + h tau A n, tau = c / mu,
and a pretension -h tau A n among the free forces. An interface with a contact whose tension has passed the tensile strength, or that
slipped or parted, is broken from the next step on, all of it: a crack in brittle mortar is not stopped by the less area that is left. So a
joint bends up to the tensile strength at its edge, and is dry then. Bonds are made at the start of a run where blocks touch, and never
again: a contact that appears later takes the bond and the slip of the nearest contact of its interface, and where there is none it is dry.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.model.materials import JointLaws

AT_LIMIT = 1e-6  # an impulse this close to the cone, as a share of it, is on it


def law_arrays(laws: JointLaws) -> np.ndarray:
    """The tables of the laws, (6, G, G), for the kernels: k_n, k_t, tau, tensile strength, theta, and whether the law goes by area."""
    tables = (laws.normal_stiffness, laws.tangential_stiffness, laws.apex, laws.tension, laws.theta, laws.by_area.astype(float))
    return np.stack(tables)


@entry()
def spring_rows(
    laws, chosen, blocks, group_of, point, gap, share, previous, frame, plane_axis, plane_at, closed, bonding, last_slip, last_bonded,
    rotation, bodies, jacobian, v, support_old, support_new, support_of, step,
    compliance, offset, area, elastic, bonded, bond, slip, before,
):  # fmt: skip
    """Fill C and b of the elastic contacts, and the arrays of ``springs.Springs``, see the head of this file.

    ``bonding`` [m]: gaps up to which new contacts are bonded; negative after the start. ``v`` (B, n): velocities of the last step.
    """
    m, n = jacobian.shape[2], jacobian.shape[3]
    base = np.empty(m)
    for c in range(chosen.shape[0]):
        k, first, second = chosen[c], group_of[blocks[chosen[c], 0]], group_of[blocks[chosen[c], 1]]
        if share[k] == 0.0:
            continue
        mirrored = plane_axis >= 0 and abs(point[k, plane_axis] - plane_at) > closed
        area[c] = 2.0 * share[k] if mirrored else share[k]
        if laws[2, first, second] > 0.0:
            bonded[c] = last_bonded[previous[k]] if previous[k] >= 0 else gap[k] <= bonding
        if bonded[c]:
            bond[c] = step * laws[2, first, second] * area[c]
        for i in range(m):
            before[c, i], base[i] = 0.0, 0.0
            for side in range(2):
                b, sign = bodies[c, side], 1.0 - 2.0 * side
                if b >= 0:
                    for j in range(n):
                        before[c, i] += jacobian[c, side, i, j] * v[b, j]
                else:
                    s = support_of[blocks[k, side]]
                    for d in range(3):
                        before[c, i] += sign * frame[c, i, d] * support_old[s, d]
                        base[i] += sign * frame[c, i, d] * support_new[s, d]
        if laws[0, first, second] == 0.0:
            continue
        elastic[c] = True
        theta = laws[4, first, second]
        start = gap[k] - (1.0 - theta) * step * before[c, 0]
        if start > 0.0 and not bonded[c]:
            compliance[c, 0] = 1.0 / (step * step * laws[0, first, second] * area[c])
            offset[c, 0] = base[0] + gap[k] / step
        else:
            compliance[c, 0] = 1.0 / (theta * theta * step * step * laws[0, first, second] * area[c])
            offset[c, 0] = base[0] + (start + theta * (1.0 - theta) * step * before[c, 0]) / (theta * theta * step)
        for i in range(1, m):
            slip[c, i - 1] = 0.0
            if previous[k] >= 0:
                turn = rotation[blocks[k, 1]]
                for d in range(3):
                    held = (
                        turn[d, 0] * last_slip[previous[k], 0]
                        + turn[d, 1] * last_slip[previous[k], 1]
                        + turn[d, 2] * last_slip[previous[k], 2]
                    )
                    slip[c, i - 1] += frame[c, i, d] * held
            compliance[c, i] = 1.0 / (theta * theta * step * step * laws[1, first, second] * area[c])
            offset[c, i] = base[i] + (slip[c, i - 1] + theta * (1.0 - theta) * step * before[c, i]) / (theta * theta * step)


@entry()
def spring_update(
    laws, chosen, blocks, group_of, pair, gap, frame, rotation, bodies, jacobian, v, offset, compliance, mu, impulse, support_new,
    support_of, step, still, area, elastic, bonded, bond, slip, before,
    new_slip, new_bonded, work,
):  # fmt: skip
    """Carry slips and bonds over the step: fill ``new_slip`` and ``new_bonded`` of all contacts.

    Adds to ``work`` [J] what elastic contacts took from the blocks, what of that friction used up, and the energy of all springs after
    and before the step. ``still`` [m/s] is the slip that counts as none when bonds are judged.
    """
    contacts, m = chosen.shape[0], jacobian.shape[2]
    u, w, slips = np.zeros((contacts, m)), np.zeros((contacts, m)), np.zeros(contacts, dtype=np.bool_)
    first = 0
    while first < contacts:  # interface by interface, whose contacts follow each other: they break together
        last, holds = first, True
        while last < contacts and pair[chosen[last]] == pair[chosen[first]]:
            if area[last] > 0.0:
                side = blocks[chosen[last]]
                _velocities(last, side, frame, bodies, jacobian, v, offset, compliance, impulse, support_new, support_of, u[last], w[last])
                reach = mu[last] * (impulse[last, 0] + bond[last])
                slips[last] = _size(w[last, 1:]) > still and _size(impulse[last, 1:]) >= (1.0 - AT_LIMIT) * reach
                parts = w[last, 0] > still and impulse[last, 0] + bond[last] <= AT_LIMIT * bond[last]
                strength = step * laws[3, group_of[side[0]], group_of[side[1]]] * area[last]
                torn = -impulse[last, 0] > (1.0 + AT_LIMIT) * strength
                if bonded[last] and (slips[last] or parts or torn):
                    holds = False
            last += 1
        for c in range(first, last):
            new_bonded[chosen[c]] = bonded[c] and holds
        first = last
    for c in range(contacts):
        if elastic[c]:
            k = chosen[c]
            law = laws[:, group_of[blocks[k, 0]], group_of[blocks[k, 1]]]
            turn = rotation[blocks[k, 1]]
            _spring(law, gap[k], area[c], mu[c], bond[c], bonded[c], new_bonded[k], slips[c], step, frame[c], turn, impulse[c], before[c],
                    u[c], w[c], slip[c], new_slip[k], work)  # fmt: skip


@kernel()
def _velocities(c, blocks, frame, bodies, jacobian, v, offset, compliance, impulse, support_new, support_of, u, w):
    """Relative velocity u of a contact at the end of the step, and w = H v + b + C p."""
    for i in range(u.shape[0]):
        w[i] = offset[c, i] + compliance[c, i] * impulse[c, i]
        for side in range(2):
            b, sign = bodies[c, side], 1.0 - 2.0 * side
            if b >= 0:
                for j in range(v.shape[1]):
                    u[i] += jacobian[c, side, i, j] * v[b, j]
                    w[i] += jacobian[c, side, i, j] * v[b, j]
            else:
                for d in range(3):
                    u[i] += sign * frame[c, i, d] * support_new[support_of[blocks[side]], d]


@kernel()
def _spring(law, gap, area, mu, bond, was_bonded, is_bonded, slips, step, frame, turn, impulse, before, u, w, slip, new_slip, work):
    """Slip and energy of one elastic contact at the end of the step; ``turn`` is the rotation of its antagonist."""
    m, theta = u.shape[0], law[4]
    start, stretch = gap - (1.0 - theta) * step * before[0], gap + theta * step * u[0]
    if start < 0.0 or was_bonded:
        work[3] += 0.5 * law[0] * area * start * start
    if stretch < 0.0 or is_bonded:
        work[2] += 0.5 * law[0] * area * stretch * stretch
    work[0] -= 0.5 * impulse[0] * (before[0] + u[0])
    held, taken = _size(slip), 0.0
    for i in range(1, m):
        slip[i - 1] += step * (theta * u[i] + (1.0 - theta) * before[i] - theta * w[i])
        taken -= 0.5 * impulse[i] * (before[i] + u[i])
    stiffness, size, keeps = law[1] * area, _size(slip), 1.0
    if impulse[0] <= 0.0 and not is_bonded:
        keeps = 0.0
    elif slips and size > 0.0:  # the state at the end of a slipping step is brought back to the cone
        keeps = min(1.0, mu * (impulse[0] + bond) / (step * stiffness * size))
    for i in range(1, m):
        for d in range(3):  # R^T of the antagonist
            for e in range(3):
                new_slip[d] += turn[e, d] * keeps * slip[i - 1] * frame[i, e]
    work[0] += taken
    work[2] += 0.5 * stiffness * (keeps * size) ** 2
    work[3] += 0.5 * stiffness * held**2
    if slips:
        work[1] += taken - 0.5 * stiffness * ((keeps * size) ** 2 - held**2)


@kernel()
def _size(x):
    """Length of a short vector."""
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i] * x[i]
    return np.sqrt(total)


@entry()
def bonded_area(chosen, pair, pair_joint, area, bonded, total):
    """Add the area of intact contacts to ``total`` (J,) of their joints [m2]; ``bonded`` by contact of the set."""
    for c in range(chosen.shape[0]):
        joint = pair_joint[pair[chosen[c]]]
        if joint >= 0 and bonded[chosen[c]]:
            total[joint] += area[c]
