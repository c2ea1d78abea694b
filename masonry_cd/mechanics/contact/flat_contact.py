# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact of two polyhedra: the face or the edges that separate them, and the points, found again as far as the pair has moved.

**Fast pairs.** Blocks that pass each other edge by edge face nothing of one another now, and yet may meet before the next look. Where a
pair has no points and may move by FAR of its width, they are those of its pose a step later, if both go on as they move, as far as their
normal separates the pair now, too, and what they join is within reach now.

**Poses.** A normal is one of the pose that its points are found in. A face that separates a pair still does so, but for what the pair has
moved; the direction across two edges may turn far more than they do, so it is looked at again wherever it is used. No gap is less than the
separation along the normal; one that is less than the motion since the pair was last searched allows is a fault, and reported.

**Springs.** The parts of an elastic joint overlap by what it is shortened. Where a pair overlaps whose joint was not there before, its
springs would be born with an energy that nobody put in: a stone at the toe of a rocking tower, squeezed by some centimetres, turns another
face to its neighbour, and is shot out. Such springs begin without force. What they do not feel of the overlap is forgotten as far as the
parts come out of each other.

**Meshed blocks.** Where one of the faces has facets, the points are those between them (``facets.py``).
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.contact.facets import has_facets, split
from masonry_cd.mechanics.contact.joint_points import EVEN, is_spread, spread_out
from masonry_cd.mechanics.contact.manifold import SNAP, contact_points, incident_face
from masonry_cd.mechanics.contact.motion import distance_moved, pose_ahead
from masonry_cd.mechanics.contact.pair_memory import APART, CLIPPED, REUSE, SEARCHED, let_go, store_points, update_gaps
from masonry_cd.mechanics.contact.separation import (
    EDGES,
    FACE_OF_A,
    FAR_APART,
    WHOLE,
    Placed,
    edges_separate,
    place_part,
    separate,
    separation_along,
)
from masonry_cd.mechanics.model.geometry import inverse_row

EDGE_BIAS = 1e-3  # an edge pair must be this much farther apart than the best face, as a share of the smaller width
SAME = 0.9  # least cosine of the angle between the normals of a contact before and now; where it is less it is another one
UNEXPLAINED = 0.01  # share of the smaller part's width by which an overlap may exceed what the motion of the pair explains
FAR = 0.05  # a pair that may move by more than this share of the smaller part's width in a step is looked at as it will be then, too


@borrower()
def look_again(memory, k, shapes, motion, margin, width, by_area, work, overlay, tally):
    """Find the points of pair k and their gaps again, as far as the pair has moved; ``margin`` and ``width`` [m].

    ``overlay``: with the facets of meshed blocks; None, which is known when this is compiled, where none of the two has any.
    """
    solids, now, feature = shapes.solids, work.now, memory.feature[k]
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    moved = distance_moved(now, memory.pose[k], shapes.radius[b])
    least = memory.budget[k] - moved  # of what separates them now
    if feature[0] == FAR_APART and least > margin:
        tally[APART] += 1
        let_go(memory, k)
        return
    own, other = (
        Placed(solids.vertices, solids.normals, WHOLE, WHOLE),
        place_part(now, b, solids, motion.affine, work.vertices, work.normals),
    )
    if feature[0] == FAR_APART or not moved < REUSE * width or (feature[0] == EDGES and not edges_separate(feature, solids, own, other)):
        tally[SEARCHED] += 1
        memory.budget[k] = separate(a, b, solids, own, other, EDGE_BIAS * width, by_area, feature)
        _copy(now, memory.pose[k])
        least = max(least, memory.budget[k])
        if memory.budget[k] > margin:
            feature[0] = FAR_APART
            let_go(memory, k)
            return
    tally[CLIPPED] += 1
    with_area = by_area and feature[0] != EDGES
    facing = _facing(memory, k)
    _copy(now, memory.built[k])
    found = _points(memory, k, solids, own, other, width, margin, with_area, work, overlay)
    if with_area:
        _forgive(memory, k, found, facing, EDGE_BIAS * width, work.manifold.height)
    if memory.rings[k] > 1:
        found = _exchange_points(memory, k, found, with_area, EVEN * width, work.manifold)
    if found == 0 and margin > FAR * width and not by_area:
        found, apart = _look_ahead(memory, k, shapes, motion, margin, width, work, overlay)
        store_points(memory, k, found, work.manifold, False, width, work)
        _gaps_before(memory, k, now, motion.affine, apart, margin)
    else:
        store_points(memory, k, found, work.manifold, with_area, width, work)
        update_gaps(memory, k, now, motion.affine)
    _check(memory, k, min(0.0, least), UNEXPLAINED * width, work.unexplained)


@borrower()
def _check(memory, k, least, allowed, unexplained):
    """Note pair k and its gap in ``unexplained`` (3,) where one is less than ``least``, the gap that its motion explains, by more than
    ``allowed`` [m]."""
    for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
        if memory.gap[s] < least - allowed and unexplained[0] < 0.0:
            unexplained[0], unexplained[1], unexplained[2] = k, memory.gap[s], least


@borrower()
def _facing(memory, k):
    """The direction in which the springs of pair k act; three zeros where it has none."""
    n, count = memory.normal[k], memory.point_count[k]
    if count == 0 or memory.area[memory.slot[k] + count - 1] == 0.0:
        return 0.0, 0.0, 0.0
    return n[0], n[1], n[2]


@borrower()
def _forgive(memory, k, found, facing, allowed, height):
    """Take what its springs do not feel of the overlap of pair k off the gaps ``height`` of its ``found`` points.

    ``facing``: where its springs faced before, three numbers; a new joint has its springs feel an overlap up to ``allowed`` [m].
    """
    deepest, n = 0.0, memory.normal[k]
    for i in range(found):
        deepest = max(deepest, -height[i])
    if n[0] * facing[0] + n[1] * facing[1] + n[2] * facing[2] < SAME:
        memory.unfelt[k] = deepest if deepest > allowed else 0.0
        for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
            memory.crushed[s] = 0.0  # another face
    else:
        memory.unfelt[k] = min(memory.unfelt[k], deepest)
    for i in range(found):
        height[i] += memory.unfelt[k]


@borrower()
def _exchange_points(memory, k, found, with_area, even, manifold):
    """Put rings in place of the corners of pair k where its joint opens; returns how many of the ``found`` points of the manifold there are
    then. Gaps that differ by up to ``even`` [m] are one."""
    had = memory.spread[k]
    memory.spread[k] = with_area and found > 0 and is_spread(had, memory.rings[k], memory.light[k], found, even, manifold)
    memory.exchanged[k] = memory.spread[k] != had
    return spread_out(memory.rings[k], found, manifold) if memory.spread[k] else found


@borrower()
def _copy(pose, to):
    """Copy a relative pose (12,)."""
    for i in range(12):
        to[i] = pose[i]


@borrower()
def _look_ahead(memory, k, shapes, motion, margin, width, work, overlay):
    """Fill the manifold with the points of pair k in its pose a step later, which becomes the pose remembered.

    Returns how many, and the separation along their normal now [m]; there are none where that does not separate the pair now.
    """
    solids, feature, pose = shapes.solids, memory.feature[k], memory.built[k]
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    pose_ahead(motion, shapes.part_block[a], shapes.part_block[b], work.ahead_position, work.ahead_rotation, pose)
    own, other = (
        Placed(solids.vertices, solids.normals, WHOLE, WHOLE),
        place_part(pose, b, solids, motion.affine, work.vertices, work.normals),
    )
    _copy(pose, memory.pose[k])
    memory.budget[k] = separate(a, b, solids, own, other, EDGE_BIAS * width, False, feature)
    if memory.budget[k] > margin:
        feature[0] = FAR_APART
        return 0, 0.0
    found = _points(memory, k, solids, own, other, width, 0.0, False, work, overlay)
    apart = separation_along(memory.normal[k], a, b, solids, work.now)
    return (found, max(0.0, apart)) if apart > -SNAP * width else (0, 0.0)


@borrower()
def _gaps_before(memory, k, now, affine, apart, margin):
    """Gaps of pair k in the pose ``now`` (12,) from points found in one ahead of it: along their normal between what they join then.

    None is less than ``apart``, the separation along the normal [m]; inf where what they join is not within the ``margin`` [m].
    ``affine``: two zeros where poses hold strains, else one.
    """
    then, n = memory.built[k], memory.normal[k]
    for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
        half, gap, square = 0.5 * memory.height[s], 0.0, 0.0
        x, y, z = (memory.local[s, 0] + half * n[0], memory.local[s, 1] + half * n[1], memory.local[s, 2] + half * n[2])
        x, y, z = x - then[0], y - then[1], z - then[2]
        bx, by, bz = 0.0, 0.0, 0.0  # in the frame of b
        for j in range(3):
            rx, ry, rz = inverse_row(then[3:].reshape((1, 3, 3)), 0, j) if len(affine) == 2 else (then[3 + j], then[6 + j], then[9 + j])
            along = rx * x + ry * y + rz * z
            bx, by, bz = (along if j == 0 else bx), (along if j == 1 else by), (along if j == 2 else bz)
        for d in range(3):
            from_b = now[d] + now[3 + 3 * d] * bx + now[4 + 3 * d] * by + now[5 + 3 * d] * bz
            way = from_b - (memory.local[s, d] - half * n[d])
            gap, square = gap + n[d] * way, square + way * way
        memory.gap[s] = max(apart, gap) if square <= margin * margin else np.inf


@borrower()
def _points(memory, k, solids, own, other, width, reach, with_area, work, overlay):
    """Fill the manifold with the points of pair k in the pose that is in ``memory.built``; returns how many.

    ``reach`` [m] of edges that do not cross within their lengths.
    """
    parts, feature = (memory.parts[k, 0], memory.parts[k, 1]), memory.feature[k]
    if overlay is None:
        return contact_points(parts, feature, solids, own, other, width, reach, with_area, memory.normal[k], work.manifold)
    faces, cut = overlay.faces, False
    if feature[0] != EDGES:
        if feature[0] == FACE_OF_A:
            faces[0], faces[1] = feature[1], incident_face(parts[1], solids, other, own.normals[feature[1] - own.first_face])
        else:
            faces[0], faces[1] = incident_face(parts[0], solids, own, other.normals[feature[1] - other.first_face]), feature[1]
        cut = has_facets(overlay.facets, faces)
    found = contact_points(parts, feature, solids, own, other, width, reach, with_area and not cut, memory.normal[k], work.manifold)
    if not cut or found == 0:
        return found
    return split(overlay, memory.built[k], memory.normal[k], found, width, with_area, memory.slot[k + 1] - memory.slot[k], work.manifold)
