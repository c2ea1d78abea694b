"""Kernels of the Moreau-Jean step: drift, free velocity, the contact rows of the friction problem, and the energy balance.

The method is told in ``stepping``. One kernel for each part of the step, so that a small scene is not ruled by call overhead.

``columns`` picks the unknowns of a body among (vx, vy, vz, wx, wy, wz): all six in space, three in a plane. A contact has the rows
normal, first tangent, second tangent; in a plane the first two, and the first tangent lies in the plane.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import entry, kernel


@entry()
def drift(position, orientation, velocity, time):
    """Move all bodies with constant velocity; orientations by the exponential map, q <- exp(w t / 2) q."""
    for b in range(position.shape[0]):
        for d in range(3):
            position[b, d] += time * velocity[b, d]
        wx, wy, wz = velocity[b, 3], velocity[b, 4], velocity[b, 5]
        speed = np.sqrt(wx * wx + wy * wy + wz * wz)
        if speed == 0.0:
            continue
        half = 0.5 * time * speed
        c, s = np.cos(half), np.sin(half) / speed
        x, y, z = s * wx, s * wy, s * wz
        qw, qx, qy, qz = orientation[b]
        pw = c * qw - x * qx - y * qy - z * qz
        px = c * qx + x * qw + y * qz - z * qy
        py = c * qy + y * qw + z * qx - x * qz
        pz = c * qz + z * qw + x * qy - y * qx
        scale = 1.0 / np.sqrt(pw * pw + px * px + py * py + pz * pz)
        orientation[b, 0], orientation[b, 1], orientation[b, 2], orientation[b, 3] = pw * scale, px * scale, py * scale, pz * scale


@entry()
def free_motion(rotation, velocity, spin, mass, inverse_inertia, free_index, columns, acceleration, step, inverse_mass, v_free):
    """For free bodies, M^-1 (n, n) and the velocity without contact (n,).

    The free rotation keeps the angular momentum L (``spin``) and takes the inertia of the middle of the motion from q_m to the next
    q_m, w = I(exp(h w / 2) q_m)^-1 L: the implicit midpoint rule, reversible, so that a tumbling block does not gain energy.
    """
    full = np.zeros((6, 6))
    free = np.empty(6)
    for b in range(rotation.shape[0]):
        i = free_index[b]
        if i < 0:
            continue
        for d in range(3):
            full[d, d] = 1.0 / mass[b]
            free[d] = velocity[b, d] + step * acceleration[d]
        _turn_tensor(rotation[b], inverse_inertia[b], full[3:, 3:])
        _midpoint_spin(full[3:, 3:], spin[b], step, columns.shape[0] == 3, free[3:])
        for j in range(columns.shape[0]):
            v_free[i, j] = free[columns[j]]
            for k in range(columns.shape[0]):
                inverse_mass[i, j, k] = full[columns[j], columns[k]]


@kernel()
def _midpoint_spin(inverse_inertia, spin, step, planar, w):
    """Solve w = I(exp(h w / 2) q_m)^-1 L by fixed point; about a fixed axis, as in a plane, I does not change."""
    for d in range(3):
        w[d] = inverse_inertia[d, 0] * spin[0] + inverse_inertia[d, 1] * spin[1] + inverse_inertia[d, 2] * spin[2]
    if planar:
        return
    for _ in range(50):
        speed = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        if step * speed < 1e-14:
            return
        ax, ay, az = w[0] / speed, w[1] / speed, w[2] / speed
        c, s = np.cos(0.5 * step * speed), np.sin(0.5 * step * speed)
        lx, ly, lz = _turn(spin[0], spin[1], spin[2], ax, ay, az, c, -s)  # L seen by the body as it is at q_m
        bx = inverse_inertia[0, 0] * lx + inverse_inertia[0, 1] * ly + inverse_inertia[0, 2] * lz
        by = inverse_inertia[1, 0] * lx + inverse_inertia[1, 1] * ly + inverse_inertia[1, 2] * lz
        bz = inverse_inertia[2, 0] * lx + inverse_inertia[2, 1] * ly + inverse_inertia[2, 2] * lz
        x, y, z = _turn(bx, by, bz, ax, ay, az, c, s)
        change = abs(x - w[0]) + abs(y - w[1]) + abs(z - w[2])
        w[0], w[1], w[2] = x, y, z
        if change <= 1e-14 * speed:
            return


@kernel()
def _turn(x, y, z, ax, ay, az, c, s):
    """Rodrigues' rotation of (x, y, z) about the unit axis a by the angle with cosine c and sine s."""
    along = (1.0 - c) * (ax * x + ay * y + az * z)
    return (
        c * x + s * (ay * z - az * y) + along * ax,
        c * y + s * (az * x - ax * z) + along * ay,
        c * z + s * (ax * y - ay * x) + along * az,
    )


@entry()
def contact_rows(
    blocks, point, normal, gap, area, previous, last_impulse, plane_axis, plane_at, position, support_velocity, support_of, free_index,
    group_of, friction, columns, step, closed, chosen, bodies, frames, jacobian, offset, mu, impulse,
):  # fmt: skip
    """Fill the friction problem of rigid contacts, their frames, and the impulses to start from; return the number of its contacts.

    Gaps up to ``closed`` [m] count as closed: positions at rest carry rounding, and gaps of that size only keep contacts undecided.

    In a plane only the contacts on one side of the middle plane count, moved into it: the others are their mirror images. The centroid of
    a joint with an area lies in that plane and is its own image.
    """
    m, n = jacobian.shape[2], jacobian.shape[3]
    arm, row = np.empty(3), np.empty(6)
    count = 0
    for c in range(gap.shape[0]):
        if plane_axis >= 0 and point[c, plane_axis] > plane_at + (closed if area[c] > 0.0 else 0.0):
            continue
        chosen[count] = c
        _frame(normal, c, plane_axis, frames, count)
        for i in range(m):
            offset[count, i] = 0.0
            impulse[count, i] = last_impulse[previous[c], i] if previous[c] >= 0 else 0.0
        offset[count, 0] = gap[c] / step if gap[c] > closed else 0.0
        for side in range(2):
            block, sign = blocks[c, side], 1.0 - 2.0 * side
            for d in range(3):
                arm[d] = point[c, d] - position[block, d]
            if plane_axis >= 0:
                arm[plane_axis] = 0.0
            x, y, z = arm[0], arm[1], arm[2]
            bodies[count, side] = free_index[block]
            for i in range(m):
                tx, ty, tz = frames[count, i, 0], frames[count, i, 1], frames[count, i, 2]
                row[0], row[1], row[2] = sign * tx, sign * ty, sign * tz
                row[3], row[4], row[5] = sign * (y * tz - z * ty), sign * (z * tx - x * tz), sign * (x * ty - y * tx)
                for j in range(n):
                    jacobian[count, side, i, j] = row[columns[j]]
                if free_index[block] < 0:
                    s = support_of[block]
                    offset[count, i] += sign * (tx * support_velocity[s, 0] + ty * support_velocity[s, 1] + tz * support_velocity[s, 2])
        mu[count] = friction[group_of[blocks[c, 0]], group_of[blocks[c, 1]]]
        count += 1
    return count


@entry()
def position_correction(gap, bodies, jacobian, inverse_mass, allowed, share, sweeps, shift):
    """Displacements (B, n) that take a share of the overlaps away, by projected Gauss-Seidel on the normals alone.

    The least displacement in the norm of M that leaves no gap g + H_n dq below -allowed, or below g with its share taken off. Velocities
    are not touched, so no energy of motion is fed; what the blocks are lifted is booked as correction.
    """
    contacts, n = gap.shape[0], inverse_mass.shape[1]
    push, compliance = np.zeros(contacts), np.zeros(contacts)
    row = np.empty((contacts, 2, n))  # M^-1 H_n^T
    for c in range(contacts):
        for side in range(2):
            b = bodies[c, side]
            if b < 0:
                continue
            for j in range(n):
                value = 0.0
                for k in range(n):
                    value += inverse_mass[b, j, k] * jacobian[c, side, 0, k]
                row[c, side, j] = value
                compliance[c] += jacobian[c, side, 0, j] * value
    shift[:] = 0.0
    for _ in range(sweeps):
        for c in range(contacts):
            wanted = gap[c] + share * (-allowed - gap[c]) if gap[c] < -allowed else -allowed
            moved = gap[c]
            for side in range(2):
                b = bodies[c, side]
                if b >= 0:
                    for j in range(n):
                        moved += jacobian[c, side, 0, j] * shift[b, j]
            step = max(-push[c], (wanted - moved) / compliance[c])
            push[c] += step
            for side in range(2):
                b = bodies[c, side]
                if b >= 0:
                    for j in range(n):
                        shift[b, j] += row[c, side, j] * step


@entry()
def dissipation(impulse, chosen, blocks, frames, elastic, bodies, jacobian, v_old, v_new, support_old, support_new, support_of, work):
    """Add to ``work`` the energy that rigid contacts lost in friction and in impacts, and the work done by the supports, over the step [J].

    With mean velocities over the step the balance is exact: the kinetic energy changes by p . H (v_old + v_new) / 2, which is the
    relative motion of the contact (lost) less the part of the support's own motion (work of the base).
    """
    m, n = jacobian.shape[2], jacobian.shape[3]
    for c in range(impulse.shape[0]):
        frame = frames[c]
        for i in range(m):
            motion, base = 0.0, 0.0
            for side in range(2):
                b = bodies[c, side]
                if b >= 0:
                    for j in range(n):
                        motion += 0.5 * jacobian[c, side, i, j] * (v_old[b, j] + v_new[b, j])
                else:
                    s, sign = support_of[blocks[chosen[c], side]], 1.0 - 2.0 * side
                    for d in range(3):
                        base += 0.5 * sign * frame[i, d] * (support_old[s, d] + support_new[s, d])
            if not elastic[c]:
                work[0 if i > 0 else 1] -= impulse[c, i] * (motion + base)
            work[2] -= impulse[c, i] * base


@entry()
def finish(v, v_free, columns, free_index, support_of, support_velocity, rotation, mass, inertia, velocity, spin):
    """Write the new velocities into the state; add to the angular momentum (B, 3) what the impulses changed, I (w - w_free).

    Returns the kinetic energy of the free bodies [J].
    """
    kinetic = 0.0
    world = np.empty((3, 3))
    change = np.zeros(6)
    for b in range(velocity.shape[0]):
        i = free_index[b]
        if i < 0:
            for d in range(3):
                velocity[b, d] = support_velocity[support_of[b], d]
            continue
        for j in range(columns.shape[0]):
            velocity[b, columns[j]] = v[i, j]
            change[columns[j]] = v[i, j] - v_free[i, j]
        _turn_tensor(rotation[b], inertia[b], world)
        for d in range(3):
            spin[b, d] += world[d, 0] * change[3] + world[d, 1] * change[4] + world[d, 2] * change[5]
            kinetic += 0.5 * (mass[b] * velocity[b, d] ** 2 + spin[b, d] * velocity[b, 3 + d])
    return kinetic


@entry()
def joint_forces(impulse, chosen, frames, point, pair, pair_joint, plane_axis, plane_at, step, total, force, at):
    """Normal force and shear force [N] of each joint, (2, J), and where their resultant crosses its plane, (J, 3) [m].

    They come from the contact impulses of its two blocks over the step. The contacts of a joint lie in its plane, so their tangential
    parts turn about its normal alone: the point about which the moment in the plane vanishes is the mean of the contact points
    weighted by normal impulse; NaN where there is none. ``total`` (J, 4) is room for sums: tangential force, normal impulse.
    """
    force[:], at[:], total[:] = 0.0, 0.0, 0.0
    for c in range(impulse.shape[0]):
        joint = pair_joint[pair[chosen[c]]]
        if joint < 0:
            continue
        force[0, joint] += impulse[c, 0] / step
        total[joint, 3] += impulse[c, 0]
        for d in range(3):
            at[joint, d] += impulse[c, 0] * (plane_at if d == plane_axis else point[chosen[c], d])
            for i in range(1, impulse.shape[1]):
                total[joint, d] += impulse[c, i] * frames[c, i, d] / step
    for j in range(total.shape[0]):
        force[1, j] = np.sqrt(total[j, 0] ** 2 + total[j, 1] ** 2 + total[j, 2] ** 2)
        for d in range(3):
            at[j, d] = at[j, d] / total[j, 3] if total[j, 3] != 0.0 else np.nan


@kernel()
def _turn_tensor(r, tensor, out):
    """R T R^T."""
    for i in range(3):
        a0 = r[i, 0] * tensor[0, 0] + r[i, 1] * tensor[1, 0] + r[i, 2] * tensor[2, 0]
        a1 = r[i, 0] * tensor[0, 1] + r[i, 1] * tensor[1, 1] + r[i, 2] * tensor[2, 1]
        a2 = r[i, 0] * tensor[0, 2] + r[i, 1] * tensor[1, 2] + r[i, 2] * tensor[2, 2]
        for j in range(3):
            out[i, j] = a0 * r[j, 0] + a1 * r[j, 1] + a2 * r[j, 2]


@kernel()
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
