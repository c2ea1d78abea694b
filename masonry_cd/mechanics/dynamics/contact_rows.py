# SPDX-License-Identifier: GPL-3.0-or-later
r"""Assemble: the friction problem of the contacts at q_m.

Each contact has a frame of unit vectors n, t1, t2 and, on each of its blocks, an arm X - x from the centre x of the block to the contact
at X. Between rigid blocks these stand for its rows of H; where blocks deform a contact has the rows themselves. On a block that along t is

    sign (t, (X - x) x t),        sign = +1 on the candidate, -1 on the antagonist,

followed by what strains add. The offset b holds the velocity of the supports, v + w x (X - x) where they turn, and, on the normal, the gap
over the step, max(g, 0) / h. In a plane a contact has the rows n and t1 only, and t1 lies in the plane. Elastic and bonded joints then put
their law in, see ``joint_law.py``.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays, StepConstants
from masonry_cd.mechanics.dynamics.bonds import Bonds
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.joint_history import with_springs
from masonry_cd.mechanics.dynamics.restitution import thrown_back
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.strain import fill_strain_rows
from masonry_cd.mechanics.dynamics.system import NO_APPROACH, MotionState, System
from masonry_cd.mechanics.dynamics.warps import fill_warp_rows, warped_gaps
from masonry_cd.mechanics.friction.contact_geometry import BY_ROWS, IN_SPACE, form_of
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution
from masonry_cd.mechanics.linalg.threads import in_shares
from masonry_cd.mechanics.model.deformation import STRAINS


def assemble(
    system: System, last: MotionState, predicted: Prediction, found: ContactSet, pairs: np.ndarray, bonds: Bonds | None = None
) -> StepProblem:
    """The friction problem of contacts found between pairs of parts (P, 2), and impulses and velocities of the last step to start from.

    ``bonds``: those that soften; None: no joint has such a bond.
    """
    warps, now = None if system.strains is None else system.strains.warps, predicted.state
    own, touch = on_this_side(found.point, found.area, system.constants), None
    if warps is not None:
        touch = warps.touches(found.bodies[own], found.point[own], now.position, predicted.maps, system.constants.plane_axis)
        found = found._replace(gap=warped_gaps(warps.arrays, found, own, touch, predicted.rotation, now.strain[:, STRAINS:]))
    rows = ContactRows.allocate(own, system.rows, system.unknowns, system.loads.turning)
    given = (found, system.blocks, system.constants, predicted.state.position, predicted.loads.support_after, system.assembly.friction)
    in_shares(lambda _, first, end: fill_rows(*given, last.impulse, rows, (first, end)), system.threads_for(len(own)), len(own))
    if system.strains is not None:
        at, axis = predicted.state.position, system.constants.plane_axis
        fill_strain_rows(system.strains.arrays, found.point, at, predicted.rotation, predicted.maps, axis, rows)
    if warps is not None and touch is not None:
        fill_warp_rows(warps.arrays, touch, predicted.rotation, rows)
    links = None
    if predicted.linked is not None:
        left, links = predicted.linked.contacts(rows)
        rows = rows.of(left)
    none = rows.offset[:0]  # (0, m)
    rigid = FrictionProblem(predicted.inverse_mass, predicted.v_free, rows.bodies, rows.geometry, rows.offset, rows.mu, compliance=none)
    approach = NO_APPROACH
    if system.bounces:
        rigid, approach = thrown_back(system, last, predicted, found, rows, rigid)
    made = StepProblem(predicted, found, rows, None, rigid, Solution(rows.start, last.v, 0), approach=approach, bonds=bonds, links=links)
    return made if system.laws is None else with_springs(system, system.laws, last, made, pairs)


@entry()
def on_this_side(point: np.ndarray, area: np.ndarray, constants: StepConstants) -> np.ndarray:
    """Which contacts found the friction problem has, (C,), by their points (., 3) [m] and areas (.,) [m2].

    In a plane only those on one side of the middle plane count, moved into it: the others are their mirror images. The centroid of a joint
    with an area lies in that plane and is its own image.
    """
    out, count, axis = np.empty(len(point), dtype=np.int64), 0, constants.plane_axis
    for c in range(len(point)):
        if axis >= 0 and point[c, axis] > constants.plane_at + (constants.closed if area[c] > 0.0 else 0.0):
            continue
        out[count] = c
        count += 1
    return out[:count]


@entry()
def fill_rows(
    found: ContactSet,
    blocks: BlockArrays,
    constants: StepConstants,
    position: np.ndarray,
    support_velocity: np.ndarray,
    friction: np.ndarray,
    last_impulse: np.ndarray,
    rows: ContactRows,
    share: tuple[int, int],
) -> None:
    """Fill ``rows`` of a share (first, end), whose places among the contacts found are known, as of rigid joints.

    Positions (B, 3) at q_m [m], velocities of the supports (S, 3 or 6) at the end of the step, coefficients of friction (G, G) by group,
    impulses of all contacts of the last set (., m) [N s].

    Gaps up to ``closed`` [m] count as closed, and become zero in ``rows``: positions at rest carry rounding, coordinates of files more than
    that, and gaps of that size only keep contacts undecided.
    """
    point, gap, previous = found.point, found.gap, found.previous
    free_index, support_of, group_of, columns = blocks.free_index, blocks.support_of, blocks.group_of, blocks.columns
    step, plane_axis, closed = constants.step, constants.plane_axis, constants.closed
    frames, jacobian, offset, form = rows.frame, rows.geometry.jacobian, rows.offset, form_of(rows.geometry)
    m, n = offset.shape[1], len(columns)
    arm, of_h = np.empty(3), np.empty(6)
    for row in range(share[0], share[1]):
        c = rows.active[row]
        rows.gap[row], rows.pair[row] = 0.0 if 0.0 <= gap[c] <= closed else gap[c], found.pair[c]
        _frame(found.normal, c, plane_axis, frames, row)
        for i in range(m):
            offset[row, i] = 0.0
            rows.start[row, i] = last_impulse[previous[c], i] if previous[c] >= 0 else 0.0
        offset[row, 0] = gap[c] / step if gap[c] > closed else 0.0
        within = blocks.stone[found.bodies[c, 0]] >= 0 and blocks.stone[found.bodies[c, 0]] == blocks.stone[found.bodies[c, 1]]
        for side in range(2):
            block, sign = found.bodies[c, side], 1.0 - 2.0 * side
            rows.blocks[row, side], rows.groups[row, side] = block, group_of[block]
            if within:
                rows.groups[row, side] = blocks.plane_row[block]
            rows.bodies[row, side], rows.supports[row, side] = free_index[block], support_of[block]
            for d in range(3):
                arm[d] = point[c, d] - position[block, d]
            if plane_axis >= 0:
                arm[plane_axis] = 0.0
            x, y, z = arm[0], arm[1], arm[2]
            if len(rows.support_arm) and free_index[block] < 0:
                rows.support_arm[row, side, 0], rows.support_arm[row, side, 1], rows.support_arm[row, side, 2] = x, y, z
            if form != BY_ROWS:
                _place(form, arm, free_index[block] < 0, columns, rows, row, side)
            for i in range(m):
                tx, ty, tz = frames[row, i, 0], frames[row, i, 1], frames[row, i, 2]
                if form == BY_ROWS:
                    of_h[0], of_h[1], of_h[2] = sign * tx, sign * ty, sign * tz
                    of_h[3], of_h[4], of_h[5] = sign * (y * tz - z * ty), sign * (z * tx - x * tz), sign * (x * ty - y * tx)
                    for j in range(n):
                        jacobian[row, side, i, j] = of_h[columns[j]]
                if free_index[block] < 0:
                    s = support_of[block]
                    offset[row, i] += sign * (tx * support_velocity[s, 0] + ty * support_velocity[s, 1] + tz * support_velocity[s, 2])
                    if len(rows.support_arm):
                        wx, wy, wz = support_velocity[s, 3], support_velocity[s, 4], support_velocity[s, 5]
                        offset[row, i] += sign * (tx * (wy * z - wz * y) + ty * (wz * x - wx * z) + tz * (wx * y - wy * x))
        rows.mu[row] = friction[rows.groups[row, 0], rows.groups[row, 1]]


@borrower()
def _place(form, arm, fixed, columns, rows, at, side):
    """Fill the arm of contact ``at`` on a side, zero on a support, from that in space (3,); and in a plane, with two components, its frame.

    ``columns`` (3,) are those of a block in a plane: two directions, and three more than its normal, about which it turns.
    """
    frame, arms = rows.geometry.frame, rows.geometry.arm
    if form == IN_SPACE:
        for d in range(3):
            arms[at, side, d] = 0.0 if fixed else arm[d]
        return
    first, second = columns[0], columns[1]
    sign = 0.0 if fixed else 1.0 if (first + 1) % 3 == second else -1.0  # of (first x second) . normal
    arms[at, side, 0], arms[at, side, 1] = -sign * arm[second], sign * arm[first]
    for i in range(2):
        frame[at, i, 0], frame[at, i, 1] = rows.frame[at, i, first], rows.frame[at, i, second]


@borrower()
def _frame(normal, c, plane_axis, frames, at):
    """Fill frames[at] with the rows n, t1, t2 of contact c.

    In a plane t1 lies in it, t1 = e x n with e along ``plane_axis``. In space (-1) e is y, or x where n is nearly along y.
    """
    nx, ny, nz = normal[c, 0], normal[c, 1], normal[c, 2]
    axis = plane_axis if plane_axis >= 0 else 1 if abs(ny) < 0.9 else 0
    if axis == 0:
        x, y, z = 0.0, -nz, ny
    elif axis == 1:
        x, y, z = nz, 0.0, -nx
    else:
        x, y, z = -ny, nx, 0.0
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    x, y, z = scale * x, scale * y, scale * z
    frames[at, 0, 0], frames[at, 0, 1], frames[at, 0, 2] = nx, ny, nz
    frames[at, 1, 0], frames[at, 1, 1], frames[at, 1, 2] = x, y, z
    frames[at, 2, 0], frames[at, 2, 1], frames[at, 2, 2] = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
