r"""Contact detection between convex parts: which surfaces may touch within the coming step, where, and how far apart they are.

**Broad phase.** Bounding boxes grown by a skin, swept along the axis on which they spread most. The list of pairs stays valid
until a part has left its grown box; the common motion of the supports is taken off first, so that shaking alone rebuilds nothing.

**Narrow phase.** Two convex polyhedra are apart by the largest separation over the face normals of either and the cross products
of their edges; edge pairs count only where their arcs cross on the Gauss map of the Minkowski difference (Gregorius, "The separating
axis test between convex polyhedra", GDC 2013). The feature found is remembered with the relative pose and used again until
the pair has moved by REUSE of its size; a pair that is apart is not looked at before it can have met.

**Manifold.** Face on face: the incident polygon clipped by the reference face, all its corners kept, no inset (their placement is
physics: an inset of 1.25 % raises the minimum thickness of an arch by 2.6 %). Overlaps narrower than SLIVER of the smaller part are no
interface: blocks that only share an edge or a corner, as diagonal neighbours in a bond do, must not wedge each other apart.
Crossing edges: one point, midway between them.

**Areas.** A joint whose law goes by area, elastic or bonded, has one more point, at the centroid of its polygon, and shares its area out so
that springs at the points act as springs all over it. With A_i the triangles (centroid, c_i, c_i+1), c seen from the centroid,

    w_i = lambda (A_i-1 + A_i) / 6 at corner i, the rest at the centroid,   lambda = 1 + sum A_i c_i . c_i+1 / sum A_i (c_i^2 + c_i+1^2).

First moments sum w_i c_i are zero for any polygon; lambda, between 1/2 and 3/2, gives the second moments their exact trace (the torsion of
the joint), and all of them are exact for triangles, parallelograms and regular polygons (A/12 at a corner of a rectangle). No weight is
negative. Corners that have moved less than JOINT_SNAP off a side plane stay on it, or every small turn would double them. Crossing edges
have no area: they are rigid and dry in any joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit

from masonry_cd.blocks import Assembly

SLIVER = 1e-4  # narrowest interface, as a share of the smaller part's width
REUSE = 1e-3  # a remembered feature is trusted until the pair has moved by this share of the smaller part's width
SKIN = 0.2  # growth of the bounding boxes, as a share of the median width of the parts
EDGE_BIAS = 1e-3  # an edge pair must be this much farther apart than the best face, as a share of the smaller width
SNAP = 1e-7  # a corner this close to a side plane is on it
JOINT_SNAP = 1e-4  # the same for joints whose law goes by area, as a share of the smaller part's width
MATCH = 0.05  # a contact is the same as one of the last step if it moved by less than this share of the smaller part's width

UNKNOWN, NOTHING, FACE_OF_A, FACE_OF_B, EDGES = 0, 1, 2, 3, 4  # kinds of separating feature


@dataclass(frozen=True, eq=False)
class ContactSet:
    """C contacts. The normal points from the antagonist (second body) to the candidate (first body)."""

    bodies: np.ndarray  # (C, 2) candidate and antagonist block
    point: np.ndarray  # (C, 3) world frame [m]
    normal: np.ndarray  # (C, 3) unit
    gap: np.ndarray  # (C,) [m], negative when the blocks overlap
    area: np.ndarray  # (C,) share of the joint's area where its law goes by area, else 0 [m2]
    pair: np.ndarray  # (C,) row of the detector's pair list
    previous: np.ndarray  # (C,) the same contact in the last set, -1 for a new one

    @property
    def count(self) -> int:
        """Number of contacts C."""
        return len(self.gap)

    @classmethod
    def none(cls) -> ContactSet:
        """No contacts."""
        return _Buffers(0).first(0)


class Detector:
    """Finds contacts step after step and remembers what the next step can use."""

    def __init__(self, assembly: Assembly, corners_only: bool = False) -> None:
        shapes = assembly.shapes
        self._group_of = assembly.group_of
        self._by_area = assembly.laws.by_area & (not corners_only)
        self._shapes = shapes
        self._fixed_part = assembly.fixed[shapes.part_block]
        self._skin = SKIN * float(np.median(shapes.size[~self._fixed_part]))
        self._world = np.empty_like(shapes.vertices)
        self._box = np.empty((len(shapes.part_block), 6))
        self._grown = np.full_like(self._box, np.nan)  # nothing lies inside NaN: the first call builds the list
        self._memory = PairMemory.empty(0)
        self._last = _Buffers(0)
        self._spare = _Buffers(64)
        self._loop = int(np.diff(shapes.loop_start).max())
        self.rebuilds = 0

    @property
    def pairs(self) -> np.ndarray:
        """(P, 2) parts that may meet before the list is made anew."""
        return self._memory.parts

    def detect(
        self, position: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, step: float, slack: float, origin: np.ndarray
    ) -> ContactSet:
        """List the contacts of a configuration.

        Args:
            position: (B, 3) centres of mass [m].
            rotation: (B, 3, 3) body to world.
            velocity: (B, 6), bounds how far blocks can come closer within the step.
            step: time step [s].
            slack: distance that forces not yet known may add within the step [m].
            origin: (3,) displacement of the supports since the start [m].
        """
        s, memory = self._shapes, None
        if not _place(position, rotation, s.part_block, s.vertex_start, s.vertices, self._world, self._box, origin, self._grown):
            self._rebuild()
        memory, count = self._memory, -1
        while count < 0:
            out = self._spare
            count = _narrow(
                memory.parts, memory.feature, memory.budget, memory.pose, memory.begin, memory.count,
                s.part_block, s.vertex_start, s.face_start, s.face_normals, s.loop_start, s.loops, s.edge_start, s.edges, s.radius, s.size,
                self._group_of, self._by_area, self._loop, self._world, position, rotation, velocity, step, slack, self._last.local,
                out.bodies, out.point, out.normal, out.gap, out.area, out.pair, out.previous, out.local,
            )  # fmt: skip
            if count < 0:
                self._spare = _Buffers(2 * len(out.gap))
        self._spare, self._last = self._last if len(self._last.gap) == len(out.gap) else _Buffers(len(out.gap)), out
        return out.first(count)

    def snapshot(self) -> dict[str, np.ndarray]:
        """What the detector remembers, as arrays for a checkpoint."""
        memory = {name: getattr(self._memory, name) for name in PairMemory.__dataclass_fields__}
        contacts = int(self._memory.count.sum())
        return memory | {"grown": self._grown, "local": self._last.local[:contacts]}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self._memory = PairMemory(**{name: arrays[name] for name in PairMemory.__dataclass_fields__})
        self._grown = arrays["grown"]
        self._last = _Buffers(len(arrays["local"]))
        self._last.local[:] = arrays["local"]

    def _rebuild(self) -> None:
        """Sweep the boxes again, and carry over what is remembered of the pairs that stay."""
        self._grown[:, :3] = self._box[:, :3] - self._skin
        self._grown[:, 3:] = self._box[:, 3:] + self._skin
        pairs = _sweep(self._grown, self._fixed_part, self._shapes.part_block)
        self._memory = self._memory.carried_over(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])
        self.rebuilds += 1


@dataclass(eq=False)
class PairMemory:
    """What is remembered of each of P candidate pairs from one step to the next; arrays, so that a checkpoint can hold them."""

    parts: np.ndarray  # (P, 2)
    feature: np.ndarray  # (P, 3) kind of the separating feature and its face or edges; NOTHING: apart
    budget: np.ndarray  # (P,) distance between the parts when they were last found apart [m]
    pose: np.ndarray  # (P, 12) pose of b in the frame of a when the feature was found
    begin: np.ndarray  # (P,) first contact in the last set
    count: np.ndarray  # (P,) contacts in the last set

    @classmethod
    def empty(cls, pairs: int) -> PairMemory:
        """Nothing remembered: every pair is looked at afresh."""
        return cls(
            np.zeros((pairs, 2), dtype=np.int64), np.full((pairs, 3), UNKNOWN), np.zeros(pairs), np.full((pairs, 12), np.inf),
            np.zeros(pairs, dtype=np.int64), np.zeros(pairs, dtype=np.int64),
        )  # fmt: skip

    def carried_over(self, parts: np.ndarray) -> PairMemory:
        """The memory for a new list of pairs (sorted), with what was known of those in the old one."""
        new = PairMemory.empty(len(parts))
        new.parts = parts
        if len(self.parts) and len(parts):
            span = max(self.parts.max(), parts.max()) + 1
            old_key, new_key = self.parts @ [span, 1], parts @ [span, 1]
            at = np.minimum(np.searchsorted(old_key, new_key), len(old_key) - 1)
            on = np.flatnonzero(old_key[at] == new_key)
            for name in ("feature", "budget", "pose", "begin", "count"):
                getattr(new, name)[on] = getattr(self, name)[at[on]]
        return new


class _Buffers:
    """Arrays for the contacts of one step; two sets take turns, so that the last one stays readable."""

    def __init__(self, capacity: int) -> None:
        self.bodies = np.empty((capacity, 2), dtype=np.int64)
        self.point = np.empty((capacity, 3))
        self.normal = np.empty((capacity, 3))
        self.gap = np.empty(capacity)
        self.area = np.empty(capacity)
        self.pair = np.empty(capacity, dtype=np.int64)
        self.previous = np.empty(capacity, dtype=np.int64)
        self.local = np.empty((capacity, 3))  # contact point in the body frame of the antagonist

    def first(self, count: int) -> ContactSet:
        """The first entries, as views."""
        return ContactSet(
            self.bodies[:count], self.point[:count], self.normal[:count], self.gap[:count], self.area[:count], self.pair[:count],
            self.previous[:count],
        )  # fmt: skip


# --- broad phase ----------------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True)
def _place(position, rotation, part_block, vertex_start, vertices, world, box, origin, grown):
    """Place all vertices in the world and box every part; return whether all boxes lie inside their grown ones."""
    inside = True
    for p in range(part_block.shape[0]):
        r, x = rotation[part_block[p]], position[part_block[p]]
        for d in range(3):
            low, high = np.inf, -np.inf
            for i in range(vertex_start[p], vertex_start[p + 1]):
                value = r[d, 0] * vertices[i, 0] + r[d, 1] * vertices[i, 1] + r[d, 2] * vertices[i, 2] + x[d]
                world[i, d] = value
                low, high = min(low, value), max(high, value)
            box[p, d], box[p, 3 + d] = low - origin[d], high - origin[d]
            if not (box[p, d] >= grown[p, d] and box[p, 3 + d] <= grown[p, 3 + d]):
                inside = False
    return inside


@njit(cache=True, nogil=True)
def _sweep(box, fixed, block):
    """Pairs of overlapping boxes, swept along the axis on which their centres spread most; two supports never pair up."""
    parts = box.shape[0]
    axis, widest = 0, -1.0
    for d in range(3):
        spread = np.std(box[:, d] + box[:, 3 + d])
        if spread > widest:
            axis, widest = d, spread
    order = np.argsort(box[:, axis], kind="mergesort")
    u, w = (axis + 1) % 3, (axis + 2) % 3
    capacity, count = 8 * parts + 16, 0
    pairs = np.empty((capacity, 2), dtype=np.int64)
    for i in range(parts):
        p = order[i]
        for j in range(i + 1, parts):
            q = order[j]
            if box[q, axis] > box[p, 3 + axis]:
                break
            if box[q, u] > box[p, 3 + u] or box[q, 3 + u] < box[p, u] or box[q, w] > box[p, 3 + w] or box[q, 3 + w] < box[p, w]:
                continue
            if (fixed[p] and fixed[q]) or block[p] == block[q]:
                continue
            if count == capacity:
                capacity *= 2
                grown = np.empty((capacity, 2), dtype=np.int64)
                grown[:count] = pairs
                pairs = grown
            pairs[count, 0], pairs[count, 1] = min(p, q), max(p, q)
            count += 1
    return pairs[:count].copy()


# --- narrow phase ---------------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True)
def _narrow(
    parts, feature, budget, pose, begin, count_of,
    part_block, vertex_start, face_start, normals, loop_start, loops, edge_start, edges, radius, size,
    group_of, by_area, longest, world, position, rotation, velocity, step, slack, last_local,
    bodies, point, normal, gap, area, pair, previous, local,
):  # fmt: skip
    """Contacts of all pairs, written into the arrays of the last line; their number, or -1 when these are too short.

    The memory of the last contacts (begin, count_of) is only replaced when all fitted, so the call can be repeated.
    """
    capacity, total = gap.shape[0], 0
    most = 4 * longest + 8
    polygon, other = np.empty((most, 3)), np.empty((most, 3))
    height, weight = np.empty(most), np.empty(most)
    new_begin = np.empty(parts.shape[0], dtype=np.int64)
    for k in range(parts.shape[0]):
        new_begin[k] = total
        a, b = parts[k, 0], parts[k, 1]
        body_a, body_b = part_block[a], part_block[b]
        width = min(size[a], size[b])
        margin = slack + 1e-3 * width + 2.0 * step * _closing_speed(velocity[body_a], velocity[body_b], radius[a], radius[b])
        moved = _moved(position[body_a], rotation[body_a], position[body_b], rotation[body_b], radius[b], pose[k])
        if feature[k, 0] == NOTHING and budget[k] - moved > margin:
            continue
        if feature[k, 0] == NOTHING or not moved < REUSE * width:
            apart = _separate(a, b, vertex_start, face_start, normals, loop_start, loops, edge_start, edges, world,
                              rotation[body_a], rotation[body_b], EDGE_BIAS * width, feature[k])  # fmt: skip
            _remember_pose(position[body_a], rotation[body_a], position[body_b], rotation[body_b], pose[k])
            if apart > margin:
                feature[k, 0], budget[k] = NOTHING, apart
                continue
        if total + most > capacity:
            return -1
        n = normal[total]
        with_area = by_area[group_of[body_a], group_of[body_b]]
        if feature[k, 0] == EDGES:
            found = _edge_contact(feature[k], edges, world, normals, rotation[body_a], n, polygon, height)
        else:
            found = _face_contacts(feature[k], a, b, body_a, body_b, vertex_start, face_start, normals, loop_start, loops, world, rotation,
                                   width, with_area, n, polygon, other, height, weight)  # fmt: skip
        first = total
        for i in range(found):
            if height[i] > margin:
                continue
            gap[total], pair[total] = height[i], k
            area[total] = weight[i] if with_area and feature[k, 0] != EDGES else 0.0
            bodies[total, 0], bodies[total, 1] = body_b, body_a
            for d in range(3):
                normal[total, d] = normal[first, d]
                point[total, d] = polygon[i, d]
            _to_local(rotation[body_a], position[body_a], polygon[i], local[total])
            previous[total] = _match(local, first, total, last_local, begin[k], count_of[k], previous, MATCH * width, with_area)
            total += 1
    for k in range(parts.shape[0]):
        end = new_begin[k + 1] if k + 1 < parts.shape[0] else total
        begin[k], count_of[k] = new_begin[k], end - new_begin[k]
    return total


@njit(cache=True, nogil=True)
def _closing_speed(va, vb, radius_a, radius_b):
    """Bound on the speed at which a point of one body nears a point of the other [m/s]."""
    dx, dy, dz = vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]
    spin_a = np.sqrt(va[3] * va[3] + va[4] * va[4] + va[5] * va[5])
    spin_b = np.sqrt(vb[3] * vb[3] + vb[4] * vb[4] + vb[5] * vb[5])
    return np.sqrt(dx * dx + dy * dy + dz * dz) + spin_a * radius_a + spin_b * radius_b


@njit(cache=True, nogil=True)
def _remember_pose(xa, ra, xb, rb, pose):
    """Store the pose of b in the frame of a."""
    for i in range(3):
        value = 0.0
        for d in range(3):
            value += ra[d, i] * (xb[d] - xa[d])
        pose[i] = value
        for j in range(3):
            pose[3 + 3 * i + j] = ra[0, i] * rb[0, j] + ra[1, i] * rb[1, j] + ra[2, i] * rb[2, j]


@njit(cache=True, nogil=True)
def _moved(xa, ra, xb, rb, radius, pose):
    """Bound on how far any point of b has moved in the frame of a since the pose was stored [m]."""
    shift, turn = 0.0, 0.0
    for i in range(3):
        value = 0.0
        for d in range(3):
            value += ra[d, i] * (xb[d] - xa[d])
        shift += (value - pose[i]) ** 2
        for j in range(3):
            turn += (ra[0, i] * rb[0, j] + ra[1, i] * rb[1, j] + ra[2, i] * rb[2, j] - pose[3 + 3 * i + j]) ** 2
    return np.sqrt(shift) + radius * np.sqrt(turn)


@njit(cache=True, nogil=True)
def _separate(a, b, vertex_start, face_start, normals, loop_start, loops, edge_start, edges, world, ra, rb, bias, feature):
    """Find the axis of largest separation, write it into ``feature`` and return the separation [m].

    Faces win over edges, and the face of the last step over others, unless beaten by the bias: the normal must not flicker.
    """
    best, face = _face_axis(a, b, vertex_start, face_start, normals, loop_start, loops, world, ra)
    best_b, face_b = _face_axis(b, a, vertex_start, face_start, normals, loop_start, loops, world, rb)
    kind = FACE_OF_A
    prefer_b = feature[0] == FACE_OF_B
    if best_b > best + (-0.1 * bias if prefer_b else 0.1 * bias):
        best, face, kind = best_b, face_b, FACE_OF_B
    edge_best, edge_a, edge_b = _edge_axis(a, b, edge_start, edges, normals, world, ra, rb)
    if edge_best > best + bias:
        feature[0], feature[1], feature[2] = EDGES, edge_a, edge_b
        return edge_best
    feature[0], feature[1], feature[2] = kind, face, -1
    return best


@njit(cache=True, nogil=True)
def _face_axis(a, b, vertex_start, face_start, normals, loop_start, loops, world, ra):
    """Largest separation of b from a over the faces of a, and the face."""
    best, at = -np.inf, -1
    for f in range(face_start[a], face_start[a + 1]):
        nx, ny, nz = _turned(ra, normals[f])
        corner = world[loops[loop_start[f]]]
        offset = nx * corner[0] + ny * corner[1] + nz * corner[2]
        least = np.inf
        for i in range(vertex_start[b], vertex_start[b + 1]):
            value = nx * world[i, 0] + ny * world[i, 1] + nz * world[i, 2]
            if value < least:
                least = value
                if least - offset < best:
                    break
        if least - offset > best:
            best, at = least - offset, f
    return best, at


@njit(cache=True, nogil=True)
def _edge_axis(a, b, edge_start, edges, normals, world, ra, rb):
    """Largest separation over the edge pairs whose Gauss arcs cross, and the edges."""
    best, at_a, at_b = -np.inf, -1, -1
    for i in range(edge_start[a], edge_start[a + 1]):
        ax, ay, az = _turned(ra, normals[edges[i, 2]])
        bx, by, bz = _turned(ra, normals[edges[i, 3]])
        px, py, pz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax  # b x a, along the edge
        p = world[edges[i, 0]]
        for j in range(edge_start[b], edge_start[b + 1]):
            cx, cy, cz = _turned(rb, normals[edges[j, 2]])
            dx, dy, dz = _turned(rb, normals[edges[j, 3]])
            cba = -(cx * px + cy * py + cz * pz)
            dba = -(dx * px + dy * py + dz * pz)
            if cba * dba >= 0.0:
                continue
            qx, qy, qz = dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx
            adc = ax * qx + ay * qy + az * qz
            bdc = bx * qx + by * qy + bz * qz
            if adc * bdc >= 0.0 or cba * bdc <= 0.0:
                continue
            ux, uy, uz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
            length = np.sqrt(ux * ux + uy * uy + uz * uz)
            if length < 1e-6 * np.sqrt((px * px + py * py + pz * pz) * (qx * qx + qy * qy + qz * qz)):
                continue  # parallel edges: a face axis is at least as good
            sign = 1.0 if ux * (ax + bx) + uy * (ay + by) + uz * (az + bz) > 0.0 else -1.0
            q = world[edges[j, 0]]
            value = sign * (ux * (q[0] - p[0]) + uy * (q[1] - p[1]) + uz * (q[2] - p[2])) / length
            if value > best:
                best, at_a, at_b = value, i, j
    return best, at_a, at_b


# --- manifolds ------------------------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True)
def _face_contacts(feature, a, b, body_a, body_b, vertex_start, face_start, normals, loop_start, loops, world, rotation, width,
                   with_area, n, polygon, other, height, weight):  # fmt: skip
    """Clip the incident face by the reference face. Fills polygon (contact points), height (gaps), n (from a to b) and weight (areas)."""
    on_a = feature[0] == FACE_OF_A
    reference, partner = feature[1], b if on_a else a
    r_ref, r_inc = (rotation[body_a], rotation[body_b]) if on_a else (rotation[body_b], rotation[body_a])
    nx, ny, nz = _turned(r_ref, normals[reference])
    incident = _incident_face(partner, face_start, normals, r_inc, nx, ny, nz)
    count = 0
    for i in range(loop_start[incident], loop_start[incident + 1]):
        polygon[count] = world[loops[i]]
        count += 1
    snap = (JOINT_SNAP if with_area else SNAP) * width
    first, last = loop_start[reference], loop_start[reference + 1]
    for i in range(first, last):  # side planes of the reference face point inwards: normal x edge
        p, q = world[loops[i]], world[loops[i + 1] if i + 1 < last else loops[first]]
        ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        sx, sy, sz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        scale = 1.0 / np.sqrt(sx * sx + sy * sy + sz * sz)
        count = _cut(polygon, count, scale * sx, scale * sy, scale * sz, p, snap, other)
        for k in range(count):
            polygon[k] = other[k]
    count = _without_twins(polygon, count, snap)
    if count < 3 or _narrowness(polygon, count, nx, ny, nz) < SLIVER * width:
        return 0
    if with_area:
        count = _share_out(polygon, count, nx, ny, nz, weight)
    p = world[loops[first]]
    sign = 1.0 if on_a else -1.0
    n[0], n[1], n[2] = sign * nx, sign * ny, sign * nz
    for k in range(count):  # the point lies midway between the two surfaces
        height[k] = nx * (polygon[k, 0] - p[0]) + ny * (polygon[k, 1] - p[1]) + nz * (polygon[k, 2] - p[2])
        polygon[k, 0] -= 0.5 * height[k] * nx
        polygon[k, 1] -= 0.5 * height[k] * ny
        polygon[k, 2] -= 0.5 * height[k] * nz
    return count


@njit(cache=True, nogil=True)
def _incident_face(part, face_start, normals, r, nx, ny, nz):
    """The face of a part that faces the direction -n most squarely."""
    least, at = np.inf, -1
    for f in range(face_start[part], face_start[part + 1]):
        x, y, z = _turned(r, normals[f])
        value = x * nx + y * ny + z * nz
        if value < least:
            least, at = value, f
    return at


@njit(cache=True, nogil=True)
def _cut(polygon, count, sx, sy, sz, p, snap, kept):
    """Keep the part of a polygon on the positive side of the plane through p; corners within ``snap`` of it count as on it."""
    out = 0
    for k in range(count):
        x, y = polygon[k], polygon[k + 1 if k + 1 < count else 0]
        fx = sx * (x[0] - p[0]) + sy * (x[1] - p[1]) + sz * (x[2] - p[2])
        fy = sx * (y[0] - p[0]) + sy * (y[1] - p[1]) + sz * (y[2] - p[2])
        if fx >= -snap:
            kept[out] = x
            out += 1
        if (fx > snap and fy < -snap) or (fx < -snap and fy > snap):
            t = fx / (fx - fy)
            for d in range(3):
                kept[out, d] = x[d] + t * (y[d] - x[d])
            out += 1
    return out


@njit(cache=True, nogil=True)
def _without_twins(polygon, count, tolerance):
    """Drop corners that coincide with the one before; return how many stay."""
    out = 0
    for k in range(count):
        last = polygon[out - 1 if out > 0 else count - 1]
        dx, dy, dz = polygon[k, 0] - last[0], polygon[k, 1] - last[1], polygon[k, 2] - last[2]
        if dx * dx + dy * dy + dz * dz > tolerance * tolerance or count == 1:
            polygon[out] = polygon[k]
            out += 1
    return out


@njit(cache=True, nogil=True)
def _narrowness(polygon, count, nx, ny, nz):
    """Area over diameter of a polygon seen along n: about its width [m]."""
    area, diameter = 0.0, 0.0
    for k in range(1, count):
        ax, ay, az = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1], polygon[k, 2] - polygon[0, 2]
        diameter = max(diameter, ax * ax + ay * ay + az * az)
        if k + 1 < count:
            bx, by, bz = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1], polygon[k + 1, 2] - polygon[0, 2]
            area += nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx)
    return 0.5 * abs(area) / np.sqrt(diameter) if diameter > 0.0 else 0.0


@njit(cache=True, nogil=True)
def _share_out(polygon, count, nx, ny, nz, weight):
    """Append the centroid to a polygon, and share its area seen along n out between corners and centroid; see the head of this file."""
    total, first = 0.0, polygon[0]
    centre = polygon[count]
    centre[:] = 0.0
    for i in range(1, count - 1):
        part = _triangle(first, polygon[i], polygon[i + 1], nx, ny, nz)
        total += part
        for d in range(3):
            centre[d] += part * (first[d] + polygon[i, d] + polygon[i + 1, d]) / 3.0
    for d in range(3):
        centre[d] /= total
    mixed, squares = 0.0, 0.0
    weight[: count + 1] = 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        part = abs(_triangle(centre, polygon[i], polygon[j], nx, ny, nz))
        weight[i] += part / 6.0
        weight[j] += part / 6.0
        for d in range(3):
            x, y = polygon[i, d] - centre[d], polygon[j, d] - centre[d]
            mixed += part * x * y
            squares += part * (x * x + y * y)
    weight[count] = abs(total)
    for i in range(count):
        weight[i] *= 1.0 + mixed / squares
        weight[count] -= weight[i]
    return count + 1


@njit(cache=True, nogil=True)
def _triangle(p, q, r, nx, ny, nz):
    """Signed area of a triangle seen along n."""
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return 0.5 * (nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx))


@njit(cache=True, nogil=True)
def _edge_contact(feature, edges, world, normals, ra, n, polygon, height):
    """The point midway between two crossing edges, its gap, and the normal from a to b."""
    i, j = feature[1], feature[2]
    p, q = world[edges[i, 0]], world[edges[j, 0]]
    u, v = world[edges[i, 1]] - p, world[edges[j, 1]] - q
    axis = np.cross(u, v)
    length = np.sqrt(np.dot(axis, axis))
    ax, ay, az = _turned(ra, normals[edges[i, 2]])
    bx, by, bz = _turned(ra, normals[edges[i, 3]])
    if axis[0] * (ax + bx) + axis[1] * (ay + by) + axis[2] * (az + bz) < 0.0:
        length = -length
    for d in range(3):
        n[d] = axis[d] / length
    w = q - p
    uu, uv, vv, uw, vw = np.dot(u, u), np.dot(u, v), np.dot(v, v), np.dot(u, w), np.dot(v, w)
    det = uu * vv - uv * uv
    s = min(1.0, max(0.0, (uw * vv - uv * vw) / det))
    t = min(1.0, max(0.0, (uw * uv - uu * vw) / det))
    for d in range(3):
        polygon[0, d] = 0.5 * (p[d] + s * u[d] + q[d] + t * v[d])
    height[0] = np.dot(w, n)
    return 1


@njit(cache=True, nogil=True)
def _to_local(r, x, p, out):
    """World point into the body frame."""
    for i in range(3):
        out[i] = r[0, i] * (p[0] - x[0]) + r[1, i] * (p[1] - x[1]) + r[2, i] * (p[2] - x[2])


@njit(cache=True, nogil=True)
def _match(local, first, at, last_local, begin, count, previous, reach, shared):
    """The nearest contact of the same pair in the last step that no other one has taken, or -1.

    With ``shared`` one that was taken counts too: a corner that parts in two hands on its slip and its bond to both.
    """
    nearest, found = reach * reach, -1
    for i in range(begin, begin + count):
        taken = False
        for k in range(first, at):
            taken = taken or (previous[k] == i and not shared)
        dx, dy, dz = local[at, 0] - last_local[i, 0], local[at, 1] - last_local[i, 1], local[at, 2] - last_local[i, 2]
        distance = dx * dx + dy * dy + dz * dz
        if not taken and distance < nearest:
            nearest, found = distance, i
    return found


@njit(cache=True, nogil=True)
def _turned(r, n):
    """The vector r n, as three numbers: no array is made."""
    return (
        r[0, 0] * n[0] + r[0, 1] * n[1] + r[0, 2] * n[2],
        r[1, 0] * n[0] + r[1, 1] * n[1] + r[1, 2] * n[2],
        r[2, 0] * n[0] + r[2, 1] * n[1] + r[2, 2] * n[2],
    )
