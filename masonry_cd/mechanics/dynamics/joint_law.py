# SPDX-License-Identifier: GPL-3.0-or-later
r"""Elastic and bonded joints: springs and dashpots that are implicit in the step, and bonds that break for good.

**Springs.** A contact with a share A of its joint's area carries

    p_n = h k_n A (-g_w)+,        p_t = -h k_t A s_w,        |p_t| <= mu p_n,

with the gap g and the elastic slip s taken at the place of the generalised midpoint rule, theta in [1/2, 1]. With the states g^, s^ between
two q_m,

    g^1 = g^0 + h (theta u+ + (1 - theta) u),        g_w = theta g^1 + (1 - theta) g^0,

and s^ alike, less the plastic slip theta h w_t (plasticity by this rule: Simo & Taylor, Int. J. Numer. Methods Eng. 22, 1986). Solved for
the velocities u+ at the end of the step this is the contact law of the rigid joint about w = u + b + C p instead of u, with

    C   = 1 / (theta^2 h^2 k A),
    b_n = (g^0 + theta (1 - theta) h u_n) / (theta^2 h),
    b_t = (s^0 + theta (1 - theta) h u_t) / (theta^2 h),

so a stiffness limits no time step: for k -> infinity C vanishes. g^0 = g - (1 - theta) h u_n follows from the gap at q_m with its sign;
s^0 is remembered, as a vector that turns with the antagonist. theta = 1/2 is of second order and keeps the energy; above, a mode of
circular frequency omega is damped by (2 theta - 1) omega h / 2, and one too stiff for the step decays by (1 - theta) / theta per step.

**Dashpots.** Next to the spring a dashpot of beta times its stiffness takes part in the force, which is that of the stretch plus beta times
its rate, (g^1 - g^0) / h on the normal (a Kelvin-Voigt joint; all of them together are Rayleigh's stiffness-proportional damping, which
takes pi f beta of critical from a mode of frequency f). With a = theta h + beta that is

    C   = 1 / (theta h a k A),        b = (g^0 + (1 - theta) a u) / (theta a),

and alike along the joint, where w_t is what slides and neither spring nor dashpot stretches. The force of both together is what does not
pull, and what friction bounds.

A spring that is only just closing, g^0 > 0, takes theta = 1 on the normal: the average of an open and a closed state would give it energy
that nobody put in, and its dashpot waits for the next step. A stiff spring so lands without a bounce, like a rigid contact, and no spring
bounces higher than it fell.

**Bonds.** An intact contact of cohesion c carries

    |p_t| <= mu p_n + h c A:

Coulomb's cone about the impulse p + h tau A n, tau = c / mu, and a pretension -h tau A n among the free forces. An interface with a contact
whose tension has passed the tensile strength, or that slipped or parted, is broken from the next step on, all of it: a crack in brittle
mortar is not stopped by the smaller area that is left. So a joint bends up to the tensile strength at its edge, and is dry then. Bonds are
made at the start of a run where blocks touch, and never again: a contact that appears later takes the bond and the slip of the nearest
contact of its interface, and where there is none it is dry.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.block_arrays import StepConstants
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows, Velocities, support_velocity
from masonry_cd.mechanics.friction.contact_geometry import velocity_between
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.triples import plus
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws

AT_LIMIT = 1e-6  # an impulse this close to the cone, as a share of it, is on it


class JointLawArrays(NamedTuple):
    """The joint laws between G groups, (G, G) each, but for the stiffness, which each contact has of its own."""

    apex: np.ndarray  # tau, tension at the tip of the cone [Pa]; 0: no bond
    tension: np.ndarray  # tensile strength [Pa]
    theta: np.ndarray  # of the spring over the step
    retardation: np.ndarray  # beta, coefficient of the dashpot over the stiffness [s]


class JointMemory(NamedTuple):
    """Memory of the joints from step to step, by contact of the last set; one entry at least."""

    slip: np.ndarray  # (K, 3) elastic slip in the frame of the antagonist [m]
    bonded: np.ndarray  # (K,) bool: intact
    area: np.ndarray  # (K,) [m2]; 0: not elastic
    place: np.ndarray  # (K, 3) in the axes of the antagonist [m]

    @classmethod
    def empty(cls, contacts: int) -> JointMemory:
        """Contacts that are dry and have not slipped."""
        k = max(1, contacts)
        return cls(np.zeros((k, 3)), np.zeros(k, dtype=np.bool_), np.zeros(k), np.zeros((k, 3)))


class LawSprings(NamedTuple):
    """The contacts of a friction problem whose law is per area; C contacts with m rows each."""

    area: np.ndarray  # (C,) [m2], that of mirror images in a plane included
    stiffness: np.ndarray  # (C, 2) k_n and k_t [N/m3]; 0: rigid
    elastic: np.ndarray  # (C,) bool
    bonded: np.ndarray  # (C,) bool: intact in this step
    bond: np.ndarray  # (C,) h tau A of intact contacts, else 0 [N s]
    slip: np.ndarray  # (C, m - 1) elastic slip s^0 in the contact frame [m]
    before: np.ndarray  # (C, m) relative velocity u at the beginning of the step [m/s]
    compliance: np.ndarray  # (C, m) diagonal of C; 0: rigid
    offset: np.ndarray  # (C, m) b [m/s]

    @classmethod
    def none(cls, problem: FrictionProblem, stiffness: np.ndarray) -> LawSprings:
        """Contacts of a stiffness (C, 2) that are all rigid and dry, to be filled."""
        c, m = problem.contacts, problem.dimension
        off = np.zeros(c, dtype=np.bool_)
        return cls(
            np.zeros(c), stiffness, off, off.copy(), np.zeros(c), np.zeros((c, m - 1)), np.zeros((c, m)), np.zeros((c, m)),
            problem.offset.copy(),
        )  # fmt: skip

    @property
    def whole(self) -> np.ndarray:
        """(C,) bool: the law holds for the impulse of the whole step, that of an impact included."""
        return self.elastic | self.bonded


def law_arrays(laws: JointLaws) -> JointLawArrays:
    """The tables of the laws for the kernels."""
    return JointLawArrays(laws.apex, laws.tension, laws.theta, laws.retardation)


@entry()
def load_springs(
    laws: JointLawArrays,
    found: ContactSet,
    rows: ContactRows,
    constants: StepConstants,
    rotation: np.ndarray,
    before: Velocities,
    support_after: np.ndarray,
    memory: JointMemory,
    bonding: float,
    springs: LawSprings,
) -> None:
    """Fill ``springs`` for the contacts whose law is per area, see the head of this file.

    ``found``, ``rows``: ContactSet and ContactRows of the step; rotations (B, 3, 3) at q_m; ``before``: Velocities at the beginning of
    the step; velocities of the supports (S, 3) at its end; ``memory``: JointMemory of the last set; ``bonding``: gaps up to which new
    contacts are bonded [m], negative after the first step.
    """
    frame, groups, h, m = rows.frame, rows.groups, constants.step, rows.offset.shape[1]
    moved, pair = np.zeros((6, 3)), -1
    for c in range(rows.active.shape[0]):
        k, first, second = rows.active[c], groups[c, 0], groups[c, 1]
        if found.area[k] == 0.0:
            continue
        area = springs.area[c] = _whole_area(found.area, found.point, k, constants)
        apex, k_n, k_t = laws.apex[first, second], springs.stiffness[c, 0], springs.stiffness[c, 1]
        old, gap = found.previous[k], found.gap[k]
        if apex > 0.0:
            springs.bonded[c] = memory.bonded[old] if old >= 0 else gap <= bonding
        if springs.bonded[c]:
            springs.bond[c] = h * apex * area
        base = support_velocity(rows, c, support_after)
        start_velocity = plus(velocity_between(rows.bodies, rows.geometry, c, before.free), support_velocity(rows, c, before.support))
        for i in range(m):
            springs.before[c, i] = start_velocity[i]
        if k_n == 0.0:
            continue
        springs.elastic[c] = True
        theta, u = laws.theta[first, second], springs.before[c]
        a = theta * h + laws.retardation[first, second]
        start = gap - (1.0 - theta) * h * u[0]
        if start > 0.0 and not springs.bonded[c]:
            springs.compliance[c, 0] = 1.0 / (h * h * k_n * area)
            springs.offset[c, 0] = base[0] + gap / h
        else:
            springs.compliance[c, 0] = 1.0 / (theta * h * a * k_n * area)
            springs.offset[c, 0] = base[0] + (start + (1.0 - theta) * a * u[0]) / (theta * a)
        if found.exchanged[k] and rows.pair[c] != pair:
            pair = rows.pair[c]
            _rigid_slip(found, rows, c, constants, rotation, memory, moved)
        for i in range(1, m):
            if found.exchanged[k]:
                slip = _slip_at(moved, found.point[k], frame[c, i])
            else:
                slip = _remembered(memory.slip, old, rotation, rows.blocks[c, 1], frame, c, i) if old >= 0 else 0.0
            springs.slip[c, i - 1] = slip
            springs.compliance[c, i] = 1.0 / (theta * h * a * k_t * area)
            springs.offset[c, i] = base[i] + (slip + (1.0 - theta) * a * u[i]) / (theta * a)


@borrower()
def _whole_area(share, point, k, constants):
    """Area that contact k of those found stands for [m2]: in a plane also that of its mirror image, where it is not its own."""
    axis = constants.plane_axis
    mirrored = axis >= 0 and abs(point[k, axis] - constants.plane_at) > constants.closed
    return 2.0 * share[k] if mirrored else share[k]


@borrower()
def _remembered(last_slip, old, rotation, antagonist, frame, c, i):
    """Slip of contact ``old`` of the last set along row i of contact c [m]: its vector has turned with the antagonist."""
    slip = 0.0
    for d in range(3):
        held = (
            rotation[antagonist, d, 0] * last_slip[old, 0]
            + rotation[antagonist, d, 1] * last_slip[old, 1]
            + rotation[antagonist, d, 2] * last_slip[old, 2]
        )
        slip += frame[c, i, d] * held
    return slip


@borrower()
def _rigid_slip(found, rows, first, constants, rotation, memory, moved):
    """Fill ``moved`` (6, 3) with how points have slipped together that were exchanged for the contacts of a joint, from ``first`` on.

    Its rows are, in the world frame, the slip of their centre [m], the turn about the normal, the centre of the new points [m], and
    scratch. Force and torque of the springs stay, and their energy where the slip was rigid, as in a joint that sticks; what else there was
    of it is lost, so the energy never grows. In a plane nothing turns.
    """
    low, high, turn, n, active = memory.area.shape[0], -1, rotation[rows.blocks[first, 1]], rows.frame[first, 0], rows.active
    centre, middle, arm, slip = moved[2], moved[3], moved[4], moved[5]
    moved[:] = 0.0
    area, polar, c = 0.0, 0.0, first
    while c < active.shape[0] and rows.pair[c] == rows.pair[first]:
        share = _whole_area(found.area, found.point, active[c], constants)
        area += share
        for d in range(3):
            centre[d] += share * found.point[active[c], d]
        if found.previous[active[c]] >= 0:
            low, high = min(low, found.previous[active[c]]), max(high, found.previous[active[c]])
        c += 1
    for d in range(3):
        centre[d] /= area
    for j in range(first, c):
        polar += _whole_area(found.area, found.point, active[j], constants) * _square_of_arm(found.point[active[j]], centre, n)
    area_before, polar_before, torque = 0.0, 0.0, 0.0
    for old in range(low, high + 1):
        _turn(turn, memory.place[old], arm)
        area_before += memory.area[old]
        for d in range(3):
            middle[d] += memory.area[old] * arm[d]
    if area_before == 0.0:
        return
    for d in range(3):
        middle[d] /= area_before
    for old in range(low, high + 1):
        _turn(turn, memory.place[old], arm)
        _turn(turn, memory.slip[old], slip)
        polar_before += memory.area[old] * _square_of_arm(arm, middle, n)
        for d in range(3):
            moved[0, d] += memory.area[old] * slip[d] / max(area_before, area)
            arm[d] -= middle[d]
        torque += memory.area[old] * _triple(n, arm, slip)
    polar = max(polar, polar_before)
    if rows.offset.shape[1] == 3 and polar > 0.0:
        for d in range(3):
            moved[1, d] = torque / polar * n[d]


@borrower()
def _slip_at(moved, point, along):
    """Slip [m] along a direction (3,) at a point of a joint that has slipped as ``moved`` (6, 3) says, see :func:`_rigid_slip`."""
    slip, turn, centre = moved[0], moved[1], moved[2]
    x, y, z = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
    out = along[0] * (slip[0] + turn[1] * z - turn[2] * y) + along[1] * (slip[1] + turn[2] * x - turn[0] * z)
    return out + along[2] * (slip[2] + turn[0] * y - turn[1] * x)


@borrower()
def _square_of_arm(point, centre, n):
    """Squared distance of a point from an axis along n through a centre (3,) [m2]."""
    square, along = 0.0, 0.0
    for d in range(3):
        x = point[d] - centre[d]
        square, along = square + x * x, along + x * n[d]
    return square - along * along


@borrower()
def _triple(n, arm, x):
    """n . (arm x x), vectors (3,)."""
    first = n[0] * (arm[1] * x[2] - arm[2] * x[1]) + n[1] * (arm[2] * x[0] - arm[0] * x[2])
    return first + n[2] * (arm[0] * x[1] - arm[1] * x[0])


@borrower()
def _turn(rotation, x, out):
    """Fill out (3,) with the rotation (3, 3) of x."""
    for d in range(3):
        out[d] = rotation[d, 0] * x[0] + rotation[d, 1] * x[1] + rotation[d, 2] * x[2]


@entry()
def unload_springs(
    laws: JointLawArrays,
    found: ContactSet,
    rows: ContactRows,
    constants: StepConstants,
    springs: LawSprings,
    rotation: np.ndarray,
    after: Velocities,
    impulse: np.ndarray,
    still: float,
    memory: JointMemory,
) -> np.ndarray:
    """Carry slips and bonds over the step: fill ``memory``, a JointMemory of all contacts found.

    ``springs`` are those of the step, ``after`` the Velocities at its end, impulses (C, m) [N s]; ``still`` is the slip that counts as
    none when bonds are judged [m/s].

    Returns:
        (4,) what elastic contacts took from the blocks, what of that friction used up, and the energy of all springs after and before the
        step [J].
    """
    frame, groups, (contacts, m) = rows.frame, rows.groups, rows.offset.shape
    u, w, slips, work = np.zeros((contacts, m)), np.zeros((contacts, m)), np.zeros(contacts, dtype=np.bool_), np.zeros(4)
    for c in range(contacts):
        if springs.area[c] > 0.0:
            motion, base = velocity_between(rows.bodies, rows.geometry, c, after.free), support_velocity(rows, c, after.support)
            for i in range(m):
                u[c, i] = motion[i] + base[i]
                w[c, i] = motion[i] + springs.offset[c, i] + springs.compliance[c, i] * impulse[c, i]
            reach = rows.mu[c] * (impulse[c, 0] + springs.bond[c])
            slips[c] = _size(w[c, 1:]) > still and _size(impulse[c, 1:]) >= (1.0 - AT_LIMIT) * reach
    first = 0
    while first < contacts:  # interface by interface, whose contacts follow each other: they break together
        last, holds = first, True
        while last < contacts and rows.pair[last] == rows.pair[first]:
            if springs.bonded[last]:
                strength = constants.step * laws.tension[groups[last, 0], groups[last, 1]] * springs.area[last]
                holds = holds and not slips[last] and _holds(impulse[last, 0], springs.bond[last], strength, w[last, 0] > still)
            last += 1
        for c in range(first, last):
            memory.bonded[rows.active[c]] = springs.bonded[c] and holds
        first = last
    slip = np.empty(m - 1)
    for c in range(contacts):
        if not springs.elastic[c]:
            continue
        k, area, theta = rows.active[c], springs.area[c], laws.theta[groups[c, 0], groups[c, 1]]
        bonded, before, p = memory.bonded[k], springs.before[c], impulse[c]
        k_n, k_t = springs.stiffness[c, 0] * area, springs.stiffness[c, 1] * area
        work[3] += _stored(k_n, found.gap[k] - (1.0 - theta) * constants.step * before[0], springs.bonded[c])
        work[2] += _stored(k_n, found.gap[k] + theta * constants.step * u[c, 0], bonded)
        work[0] -= 0.5 * p[0] * (before[0] + u[c, 0])
        held, taken = _size(springs.slip[c]), 0.0
        for i in range(1, m):
            slip[i - 1] = springs.slip[c, i - 1] + constants.step * (theta * u[c, i] + (1.0 - theta) * before[i] - theta * w[c, i])
            taken -= 0.5 * p[i] * (before[i] + u[c, i])
        size, keeps = _size(slip), 1.0
        if p[0] <= 0.0 and not bonded:
            keeps = 0.0
        elif slips[c] and size > 0.0:  # the state at the end of a slipping step is brought back to the cone
            keeps = min(1.0, rows.mu[c] * (p[0] + springs.bond[c]) / (constants.step * k_t * size))
        _remember(keeps, slip, rotation[rows.blocks[c, 1]], frame[c], memory.slip[k])
        memory.area[k] = area
        for d in range(3):
            for e in range(3):
                memory.place[k, d] += rotation[rows.blocks[c, 1], e, d] * found.point[k, e]
        work[0] += taken
        work[2] += 0.5 * k_t * (keeps * size) ** 2
        work[3] += 0.5 * k_t * held**2
        if slips[c]:
            work[1] += taken - 0.5 * k_t * ((keeps * size) ** 2 - held**2)
    return work


@borrower()
def _holds(impulse, bond, strength, opens):
    """Return True if a bonded contact neither parts nor passes its tensile strength [N s] under a normal impulse."""
    parts = opens and impulse + bond <= AT_LIMIT * bond
    return not (parts or -impulse > (1.0 + AT_LIMIT) * strength)


@borrower()
def _stored(stiffness, stretch, bonded):
    """Energy [J] of a spring of a stiffness [N/m]: one that is not bonded has none when it is open, stretch > 0 [m]."""
    return 0.5 * stiffness * stretch * stretch if stretch < 0.0 or bonded else 0.0


@borrower()
def _remember(keeps, slip, turn, frame, out):
    """Add to out (3,), in the frame of the antagonist with rotation ``turn`` (3, 3), a share of a slip along rows 1 and on of ``frame``."""
    for i in range(slip.shape[0]):
        for d in range(3):
            for e in range(3):
                out[d] += turn[e, d] * keeps * slip[i] * frame[i + 1, e]


@borrower()
def _size(x):
    """Length of a short vector."""
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i] * x[i]
    return np.sqrt(total)


@entry()
def bonded_area(active, pair, pair_joint, area, bonded, total):
    """Add the area of intact contacts to ``total`` (J,) of their joints [m2]; ``bonded`` by contact of the set."""
    for c in range(active.shape[0]):
        joint = pair_joint[pair[active[c]]]
        if joint >= 0 and bonded[active[c]]:
            total[joint] += area[c]
