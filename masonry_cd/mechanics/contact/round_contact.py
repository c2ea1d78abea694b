# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact of a sphere with a sphere, or with a face, an edge or a corner of a convex part: one point, where it comes nearest.

With c the centre of the sphere and R its radius, and d the distance of c from the nearest point of the other part, gap = d - R, and the
normal is along the line between them. Where c itself is in the polyhedron, it is that of the face which is least deep. For two spheres the
other part is the other centre, and gap = d - R_a - R_b. The point lies midway between the two surfaces. A pair has one point at most, so it
continues that of the last set, however far it has rolled.

**Seams.** Where a face goes on in that of another block, the edge between them is not an obstacle, but the plane across the line to it is:
a sphere that comes to it within the step would run into that plane, though it stays clear of the edge all the way. So where the gap of an
edge or a corner closes by this plane and not in truth, as the centre now moves, the plane is that of the end of its motion s. Overlaps
below s^2 / 2 R, by which plane and sphere differ, are no hit, up to SHALLOW of R.

**Rolling friction.** A real contact is a spot, not a point, and the resultant of its pressure may move ahead of the centre by some arm e:
it resists rolling by a moment of up to e N (Coulomb's law of rolling). So here a contact with rolling friction is four points, at e ahead,
behind, and on both sides, and that moment is what unilateral contacts and friction give by themselves. The points are lined up with the
rolling, so that the arm is e in whatever direction a sphere rolls; where it does not roll, across it, the moment is at least e N / sqrt(2).
Turning on the spot about the normal is resisted by mu e N. A sphere that rolls at an angular velocity w is carried by its front point, at a
gap of e w h: a disc of radius e tilts as it goes on. That is of the order of the time step, and closes as the sphere stops.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.motion import distance_moved
from masonry_cd.mechanics.contact.separation import FAR_APART, ROUND, WHOLE, Placed, place_part
from masonry_cd.mechanics.model.geometry import Polyhedra, turned_normal

POINTS = 4  # of a contact with rolling friction
SHALLOW = 1e-3  # share of the radius by which a sphere may overlap a seam at the most
STILL_ROLLING = 1e-9  # spheres that roll by less per step [rad] have their four points lined up with an axis


@borrower()
def find_round_contact(memory, k, shapes, motion, margin, arm, work):
    """Find the points of pair k, of which one part at least is a sphere, and their gaps; returns False where it was known to be apart.

    ``margin`` [m] up to which gaps count; ``arm`` [m] of the rolling friction, 0 for none; ``work`` holds the pose of b in the frame of a.
    """
    now, feature = work.now, memory.feature[k]
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    if feature[0] == FAR_APART and memory.budget[k] - distance_moved(now, memory.pose[k], shapes.radius[b]) > margin:
        return False
    gap, grown, x, y, z, nx, ny, nz = _nearest(a, b, shapes, motion, margin, work)
    for i in range(12):
        memory.pose[k, i], memory.built[k, i] = now[i], now[i]
    feature[1], feature[2] = -1, -1
    if gap > margin:
        feature[0], memory.budget[k], memory.point_count[k] = FAR_APART, gap, 0
        return True
    feature[0] = ROUND
    memory.normal[k, 0], memory.normal[k, 1], memory.normal[k, 2] = nx, ny, nz
    _store(memory, k, (x, y, z), gap / grown, 1 if arm == 0.0 else POINTS)
    if arm > 0.0:
        _spread_out(memory, k, shapes, motion, arm, (nx, ny, nz))
    return True


@borrower()
def _nearest(a, b, shapes, motion, enough, work):
    """Gap between parts a and b, of which one is a sphere [m], by what gaps along the normal grow with the strain of a, the point midway
    between them and the normal from a to b, in the frame of a; gaps above ``enough`` [m] may come out smaller, but not below it."""
    solids, now, rounding = shapes.solids, work.now, shapes.rounding
    radius_a, radius_b = rounding[a], rounding[b]
    own = solids.vertices[solids.vertex_start[a]]  # the centre, of a sphere
    first = solids.vertices[solids.vertex_start[b]]
    cx = now[0] + now[3] * first[0] + now[4] * first[1] + now[5] * first[2]
    cy = now[1] + now[6] * first[0] + now[7] * first[1] + now[8] * first[2]
    cz = now[2] + now[9] * first[0] + now[10] * first[1] + now[11] * first[2]
    if radius_a > 0.0 and radius_b > 0.0:
        dx, dy, dz = cx - own[0], cy - own[1], cz - own[2]
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        nx, ny, nz = (dx / distance, dy / distance, dz / distance) if distance > 0.0 else (0.0, 0.0, 1.0)
        gap = distance - radius_a - radius_b
        along = radius_a + 0.5 * gap
        return gap, 1.0, own[0] + along * nx, own[1] + along * ny, own[2] + along * nz, nx, ny, nz
    block_a, block_b = shapes.part_block[a], shapes.part_block[b]
    if radius_a > 0.0:
        other = place_part(now, b, solids, motion.affine, work.vertices, work.normals)
        ahead = _motion_ahead(motion, block_a, block_b, block_a)
        distance, nx, ny, nz = _distance_on_the_way(b, solids, other, (own[0], own[1], own[2]), ahead, radius_a, enough + radius_a)
        gap = distance - radius_a
        along = radius_a + 0.5 * gap
        return gap, 1.0, own[0] - along * nx, own[1] - along * ny, own[2] - along * nz, -nx, -ny, -nz
    placed, grown = Placed(solids.vertices, solids.normals, WHOLE, WHOLE), 1.0
    ahead = _motion_ahead(motion, block_b, block_a, block_a)
    distance, nx, ny, nz = _distance_on_the_way(a, solids, placed, (cx, cy, cz), ahead, radius_b, enough + radius_b)
    if len(motion.affine) == 2:
        work.ahead_position[0, 0], work.ahead_position[0, 1], work.ahead_position[0, 2] = nx, ny, nz
        grown = turned_normal(motion.rotation, block_a, work.ahead_position[0])[3]
    gap = grown * distance - radius_b
    along = (radius_b + 0.5 * gap) / grown
    return gap, grown, cx - along * nx, cy - along * ny, cz - along * nz, nx, ny, nz


@borrower()
def _motion_ahead(motion, sphere, block, frame):
    """How far the centre of a sphere moves within the step as seen from a block, three numbers in the frame of block ``frame`` [m]."""
    vs, vb, r = motion.velocity[sphere], motion.velocity[block], motion.rotation[frame]
    xs, xb = motion.position[sphere], motion.position[block]
    ax, ay, az = xs[0] - xb[0], xs[1] - xb[1], xs[2] - xb[2]
    x = motion.step * (vs[0] - vb[0] - (vb[4] * az - vb[5] * ay))
    y = motion.step * (vs[1] - vb[1] - (vb[5] * ax - vb[3] * az))
    z = motion.step * (vs[2] - vb[2] - (vb[3] * ay - vb[4] * ax))
    return (
        r[0, 0] * x + r[1, 0] * y + r[2, 0] * z,
        r[0, 1] * x + r[1, 1] * y + r[2, 1] * z,
        r[0, 2] * x + r[1, 2] * y + r[2, 2] * z,
    )


@borrower()
def _distance_on_the_way(p, solids, placed, centre, ahead, radius, enough):
    """As :func:`distance_to_point` of the centre of a sphere, but of what it only seems to meet the height over the plane that it comes to,
    and the normal of that; ``ahead``: its motion within the step, three numbers [m]."""
    distance, nx, ny, nz, on_face = distance_to_point(p, solids, placed, centre, enough)
    (x, y, z), (sx, sy, sz) = centre, ahead
    if on_face or distance > enough or distance + nx * sx + ny * sy + nz * sz >= radius:
        return distance, nx, ny, nz
    later, mx, my, mz, _ = distance_to_point(p, solids, placed, (x + sx, y + sy, z + sz), np.inf)
    if later < radius - min(0.5 * (sx * sx + sy * sy + sz * sz) / radius, SHALLOW * radius):
        return distance, nx, ny, nz
    return max(min(distance, radius), later - mx * sx - my * sy - mz * sz), mx, my, mz


@borrower()
def distance_to_point(p, solids, placed, point, enough):
    """Distance of a point from polyhedron p [m], negative inside, the unit normal as three numbers, outwards from where p is nearest, and
    whether that is on a face.

    ``point``: three numbers; beyond ``enough`` [m] a lower bound of the distance, but not below ``enough``, will do.
    """
    normals, vertices, loops, starts = placed.normals, placed.vertices, solids.loops, solids.loop_start
    x, y, z = point
    best, at = -np.inf, 0
    for f in range(solids.face_start[p], solids.face_start[p + 1]):
        n, corner = normals[f - placed.first_face], vertices[loops[starts[f]] - placed.first_vertex]
        height = n[0] * (x - corner[0]) + n[1] * (y - corner[1]) + n[2] * (z - corner[2])
        if height > best:
            best, at = height, f - placed.first_face
    bx, by, bz = normals[at, 0], normals[at, 1], normals[at, 2]
    if best <= 0.0 or best > enough:
        return best, bx, by, bz, True
    least = np.inf
    for f in range(solids.face_start[p], solids.face_start[p + 1]):
        n, corner = normals[f - placed.first_face], vertices[loops[starts[f]] - placed.first_vertex]
        height = n[0] * (x - corner[0]) + n[1] * (y - corner[1]) + n[2] * (z - corner[2])
        if height <= 0.0:
            continue
        over = True  # whether the point is above the face itself: then it is the nearest there is
        for i in range(starts[f], starts[f + 1]):
            u = vertices[loops[i] - placed.first_vertex]
            v = vertices[loops[i + 1 if i + 1 < starts[f + 1] else starts[f]] - placed.first_vertex]
            ex, ey, ez, dx, dy, dz = v[0] - u[0], v[1] - u[1], v[2] - u[2], x - u[0], y - u[1], z - u[2]
            side = (n[1] * ez - n[2] * ey) * dx + (n[2] * ex - n[0] * ez) * dy + (n[0] * ey - n[1] * ex) * dz
            if side >= 0.0:
                continue
            over = False
            share = min(1.0, max(0.0, (ex * dx + ey * dy + ez * dz) / (ex * ex + ey * ey + ez * ez)))
            dx, dy, dz = dx - share * ex, dy - share * ey, dz - share * ez
            square = dx * dx + dy * dy + dz * dz
            if square < least:
                least, bx, by, bz = square, dx, dy, dz
        if over:
            return height, n[0], n[1], n[2], True
    distance = np.sqrt(least)
    return distance, bx / distance, by / distance, bz / distance, False


@borrower()
def _store(memory, k, point, height, count):
    """Put ``count`` points at one place in the memory of pair k, each the one that it was in the last set, and their gap [m]."""
    known = memory.point_count[k]
    for i in range(count):
        s = memory.slot[k] + i
        memory.local[s, 0], memory.local[s, 1], memory.local[s, 2] = point
        memory.height[s], memory.gap[s], memory.area[s] = height, height, 0.0
        if i >= known:
            memory.place[s] = -1
    memory.point_count[k] = count


@borrower()
def _spread_out(memory, k, shapes, motion, arm, normal):
    """Move the four points of pair k apart by ``arm`` [m], two of them along the rolling of b over a; ``normal`` as three numbers."""
    nx, ny, nz = normal
    block_a, block_b = shapes.part_block[memory.parts[k, 0]], shapes.part_block[memory.parts[k, 1]]
    r, va, vb = motion.rotation[block_a], motion.velocity[block_a], motion.velocity[block_b]
    wx, wy, wz = vb[3] - va[3], vb[4] - va[4], vb[5] - va[5]
    wx, wy, wz = (  # in the frame of a
        r[0, 0] * wx + r[1, 0] * wy + r[2, 0] * wz,
        r[0, 1] * wx + r[1, 1] * wy + r[2, 1] * wz,
        r[0, 2] * wx + r[1, 2] * wy + r[2, 2] * wz,
    )
    ex, ey, ez = wy * nz - wz * ny, wz * nx - wx * nz, wx * ny - wy * nx
    length = np.sqrt(ex * ex + ey * ey + ez * ez)
    if not length * motion.step > STILL_ROLLING:
        ex, ey, ez = (nz, 0.0, -nx) if abs(ny) < 0.9 else (0.0, -nz, ny)
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
    ex, ey, ez = arm * ex / length, arm * ey / length, arm * ez / length
    fx, fy, fz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
    local, s = memory.local, memory.slot[k]
    for i in range(POINTS):
        sign, ahead = 1.0 - 2.0 * (i % 2), i < 2
        local[s + i, 0] += sign * (ex if ahead else fx)
        local[s + i, 1] += sign * (ey if ahead else fy)
        local[s + i, 2] += sign * (ez if ahead else fz)


# --- without a run: how deep spheres are in others -------------------------------------------------------------------------------


def round_depths(solids: Polyhedra, rounding: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """How deep the parts of each pair (n, 2) are in each other, of which one at least is a sphere, (n,) [m]; negative: apart.

    ``rounding`` (P,) is the radius of spheres, 0 of polyhedra [m].
    """
    out = np.empty(len(pairs))
    _fill_round_depths(solids, rounding, pairs, out)
    return out


@entry()
def _fill_round_depths(solids: Polyhedra, rounding: np.ndarray, pairs: np.ndarray, out: np.ndarray) -> None:
    """Fill ``out`` (n,), see :func:`round_depths`."""
    placed = Placed(solids.vertices, solids.normals, WHOLE, WHOLE)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        first, second = solids.vertices[solids.vertex_start[a]], solids.vertices[solids.vertex_start[b]]
        if rounding[a] > 0.0 and rounding[b] > 0.0:
            dx, dy, dz = second[0] - first[0], second[1] - first[1], second[2] - first[2]
            apart = np.sqrt(dx * dx + dy * dy + dz * dz)
        elif rounding[a] > 0.0:
            apart = distance_to_point(b, solids, placed, (first[0], first[1], first[2]), np.inf)[0]
        else:
            apart = distance_to_point(a, solids, placed, (second[0], second[1], second[2]), np.inf)[0]
        out[k] = rounding[a] + rounding[b] - apart
