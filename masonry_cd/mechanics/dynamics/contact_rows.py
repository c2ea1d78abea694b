# SPDX-License-Identifier: GPL-3.0-or-later
r"""Assemble: the friction problem of the contacts at q_m.

Each contact has a frame of unit vectors n, t1, t2 and, on each of its blocks, an arm X - x from the centre x of the block to the contact
at X. Between rigid blocks these stand for its rows of H; where blocks deform a contact has the rows themselves. On a block that along t is

    sign (t, (X - x) x t),        sign = +1 on the candidate, -1 on the antagonist,

followed by what strains add. The offset b holds the velocity of the supports and, on the normal, the gap over the step, max(g, 0) / h. In a
plane a contact has the rows n and t1 only, and t1 lies in the plane. Elastic and bonded joints then put their law in, see ``joint_law.py``.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays, StepConstants
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.joint_history import with_springs
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.strain import fill_strain_rows
from masonry_cd.mechanics.dynamics.system import Motion, System
from masonry_cd.mechanics.dynamics.warps import fill_warp_rows, warped_gaps
from masonry_cd.mechanics.friction.contact_geometry import BY_ROWS, IN_SPACE, form_of
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution
from masonry_cd.mechanics.linalg.threads import in_shares
from masonry_cd.mechanics.model.deformation import STRAINS


def assemble(system: System, last: Motion, predicted: Prediction, found: ContactSet, pairs: np.ndarray) -> StepProblem:
    """The friction problem of contacts found between pairs of parts (P, 2), and impulses and velocities of the last step to start from."""
    warps, now = None if system.strains is None else system.strains.warps, predicted.state
    touch = None
    if warps is not None:
        own = on_this_side(found.point, found.area, system.constants)
        touch = warps.touches(found.bodies[own], found.point[own], now.position, predicted.maps, system.constants.plane_axis)
        found = found._replace(gap=warped_gaps(warps.arrays, found, own, touch, predicted.rotation, now.strain[:, STRAINS:]))
    room = ContactRows.allocate(len(found.gap), system.rows, system.unknowns)
    given = (found, system.blocks, system.constants, predicted.state.position, predicted.loads.support_after, system.assembly.friction)
    threads = system.threads_for(len(found.gap)) if system.constants.plane_axis < 0 else 1
    counts = in_shares(lambda _, first, end: fill_rows(*given, last.impulse, room, (first, end)), threads, len(found.gap))
    rows = room.first(sum(counts))
    if system.strains is not None:
        at, axis = predicted.state.position, system.constants.plane_axis
        fill_strain_rows(system.strains.arrays, found.point, at, predicted.rotation, predicted.maps, axis, rows)
    if warps is not None and touch is not None:
        fill_warp_rows(warps.arrays, touch, predicted.rotation, rows)
    none = rows.offset[:0]  # (0, m)
    rigid = FrictionProblem(predicted.inverse_mass, predicted.v_free, rows.bodies, rows.geometry, rows.offset, rows.mu, compliance=none)
    made = StepProblem(predicted, found, rows, None, rigid, Solution(rows.start, last.v, 0))
    return made if system.laws is None else with_springs(system, system.laws, last, made, pairs)


@entry()
def on_this_side(point: np.ndarray, area: np.ndarray, constants: StepConstants) -> np.ndarray:
    """Which contacts found the friction problem has, (C,), by their points (., 3) [m] and areas (.,) [m2]."""
    out, count = np.empty(len(point), dtype=np.int64), 0
    for c in range(len(point)):
        if not _is_image(point, area, constants, c):
            out[count] = c
            count += 1
    return out[:count]


@borrower()
def _is_image(point, area, constants, c):
    """Whether contact c is the mirror image of another one, see :func:`fill_rows`."""
    axis = constants.plane_axis
    return axis >= 0 and point[c, axis] > constants.plane_at + (constants.closed if area[c] > 0.0 else 0.0)


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
) -> int:
    """Fill ``rows``, with room for all contacts found, as of rigid joints; return how many the friction problem has.

    ``share``: the first contact that is looked at, and the end; all of them in a plane, where not each becomes a row.

    Positions (B, 3) at q_m [m], velocities of the supports (S, 3) at the end of the step [m/s], coefficients of friction (G, G) by group,
    impulses of all contacts of the last set (., m) [N s].

    Gaps up to ``closed`` [m] count as closed, and become zero in ``rows``: positions at rest carry rounding, coordinates of files more than
    that, and gaps of that size only keep contacts undecided.

    In a plane only the contacts on one side of the middle plane count, moved into it: the others are their mirror images. The centroid of
    a joint with an area lies in that plane and is its own image.
    """
    point, gap, area, previous = found.point, found.gap, found.area, found.previous
    free_index, support_of, group_of, columns = blocks.free_index, blocks.support_of, blocks.group_of, blocks.columns
    step, plane_axis, closed = constants.step, constants.plane_axis, constants.closed
    frames, jacobian, offset, form = rows.frame, rows.geometry.jacobian, rows.offset, form_of(rows.geometry)
    m, n = offset.shape[1], len(columns)
    arm, row = np.empty(3), np.empty(6)
    count = share[0]
    for c in range(share[0], share[1]):
        if _is_image(point, area, constants, c):
            continue
        is_closed = 0.0 <= gap[c] <= closed
        rows.active[count], rows.gap[count], rows.pair[count] = c, 0.0 if is_closed else gap[c], found.pair[c]
        _frame(found.normal, c, plane_axis, frames, count)
        for i in range(m):
            offset[count, i] = 0.0
            rows.start[count, i] = last_impulse[previous[c], i] if previous[c] >= 0 else 0.0
        offset[count, 0] = gap[c] / step if gap[c] > closed else 0.0
        for side in range(2):
            block, sign = found.bodies[c, side], 1.0 - 2.0 * side
            rows.blocks[count, side], rows.groups[count, side] = block, group_of[block]
            rows.bodies[count, side], rows.supports[count, side] = free_index[block], support_of[block]
            for d in range(3):
                arm[d] = point[c, d] - position[block, d]
            if plane_axis >= 0:
                arm[plane_axis] = 0.0
            x, y, z = arm[0], arm[1], arm[2]
            if form != BY_ROWS:
                _place(form, arm, free_index[block] < 0, columns, rows, count, side)
            for i in range(m):
                tx, ty, tz = frames[count, i, 0], frames[count, i, 1], frames[count, i, 2]
                if form == BY_ROWS:
                    row[0], row[1], row[2] = sign * tx, sign * ty, sign * tz
                    row[3], row[4], row[5] = sign * (y * tz - z * ty), sign * (z * tx - x * tz), sign * (x * ty - y * tx)
                    for j in range(n):
                        jacobian[count, side, i, j] = row[columns[j]]
                if free_index[block] < 0:
                    s = support_of[block]
                    offset[count, i] += sign * (tx * support_velocity[s, 0] + ty * support_velocity[s, 1] + tz * support_velocity[s, 2])
        rows.mu[count] = friction[rows.groups[count, 0], rows.groups[count, 1]]
        count += 1
    return count - share[0]


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
